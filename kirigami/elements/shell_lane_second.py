"""Second derivatives of shell facets, LANES facets at once; see :mod:`kirigami.elements.shell_lanes`.

At nine points, three inside and six on the edges, a normal n turns with the vectors v_p. What that adds to the block
(p, q) of second derivatives has one form, n (w_q a_p)' + (w_p a_q) n' with weights w and arms a of the five vectors;
inside less h (a_p.a_q) n n', on the edges with what the slide along them adds.
"""

from __future__ import annotations

from kirigami.elements.shell_lane_rows import LANES
from kirigami.elements.shell_loops import ALONG, FIRST, INWARD, SECOND, compiled, tension


@compiled
def add_squares(rows, width, local):  # type: ignore[no-untyped-def]
    """Add the lower half of rows' rows, of rows (9, width, LANES)."""
    for y in range(width):
        for z in range(y + 1):
            for lane in range(LANES):
                total = 0.0
                for i in range(9):
                    total += rows[i, y, lane] * rows[i, z, lane]
                local[y, z, lane] += total


@compiled
def inside_parts(v, normal, dual, moment, second, arms, weights, loads, heights):  # type: ignore[no-untyped-def]
    """Arms (.., 5, 3, LANES) and weights (.., 5, LANES) of the three points inside, with the moments of the curvatures
    there, and heights (3, 5, 5, LANES), h times the products of arms."""
    width = moment.shape[1]
    for k in range(3):
        for p in range(5):
            for axis in range(3):
                for lane in range(width):
                    arms[k, p, axis, lane] = (
                        FIRST[k, p] * dual[0, k, axis, lane] + SECOND[k, p] * dual[1, k, axis, lane]
                    )
        weights[k] = 0.0
        loads[:] = 0.0
        for e in range(3):
            for lane in range(width):
                share = high = one = two = 0.0
                for c in range(3):
                    share += moment[3 * k + c, lane] * second[e, c, lane]
                    high += normal[k, c, lane] * v[2 + e, c, lane]
                    one += dual[0, k, c, lane] * v[2 + e, c, lane]
                    two += dual[1, k, c, lane] * v[2 + e, c, lane]
                loads[0, lane] += share * high
                loads[1, lane] += share * one
                loads[2, lane] += share * two
                weights[k, 2 + e, lane] -= share
        for p in range(5):
            for lane in range(width):
                weights[k, p, lane] += FIRST[k, p] * loads[1, lane] + SECOND[k, p] * loads[2, lane]
            for q in range(p + 1):
                for lane in range(width):
                    product = 0.0
                    for axis in range(3):
                        product += arms[k, p, axis, lane] * arms[k, q, axis, lane]
                    heights[k, p, q, lane] = loads[0, lane] * product


@compiled
def edge_parts(frames, faced, moment, pull, per_square, arms, weights, loads, forms):  # type: ignore[no-untyped-def]
    """Arms and weights of the six points on the edges, with the moments of the angles, and forms (6, 3, 3, LANES) of
    ALONG: of the slide along the edge, and of the strains there."""
    normal, inward, tangent, sizes = frames
    width = moment.shape[1]
    for g in range(6):
        for lane in range(width):
            c, length, reach = moment[9 + g, lane], sizes[0, g, lane], sizes[1, g, lane]
            loads[0, lane] = c / (reach * reach)
            loads[1, lane] = c / (length * reach)
            loads[2, lane] = 0.5 * c / (length * length)
        for p in range(5):
            for lane in range(width):
                weights[3 + g, p, lane] = INWARD[g, p] - sizes[2, g, lane] * ALONG[g, p]
            for axis in range(3):
                for lane in range(width):
                    arms[3 + g, p, axis, lane] = (
                        loads[0, lane] * weights[3 + g, p, lane] * inward[g, axis, lane]
                        + loads[1, lane] * ALONG[g, p] * tangent[g, axis, lane]
                    )
        for i in range(3):
            for j in range(i + 1):
                for lane in range(width):
                    up, side, lean = faced[0, g, lane], faced[1, g, lane], faced[2, g, lane]
                    n, m, t = normal[g, i, lane], inward[g, i, lane], tangent[g, i, lane]
                    nn, mm, tt = normal[g, j, lane], inward[g, j, lane], tangent[g, j, lane]
                    square = up * up + side * side
                    over, under = (1.0 + lean * lean) / (square * square), 2.0 * lean / square
                    turn, curl = up * m - side * n, over * (up * n + side * m) - under * t
                    other, bend = up * mm - side * nn, over * (up * nn + side * mm) - under * tt
                    form = loads[2, lane] * (n * mm + m * nn + turn * bend + curl * other)
                    if i == j:
                        form += pull[g, lane] * per_square[g, lane]
                    forms[g, i, j, lane] = form
                    forms[g, j, i, lane] = form


@compiled
def add_points(normals, arms, weights, heights, forms, local):  # type: ignore[no-untyped-def]
    """Add what the nine points make of their parts to the lower half of the second derivatives."""
    for p in range(5):
        for q in range(p + 1):
            for i in range(3):
                for j in range(3 if q < p else i + 1):
                    for lane in range(LANES):
                        total = 0.0
                        for k in range(9):
                            total += normals[k, i, lane] * weights[k, q, lane] * arms[k, p, j, lane]
                            total += normals[k, j, lane] * weights[k, p, lane] * arms[k, q, i, lane]
                        for k in range(3):
                            total -= heights[k, p, q, lane] * normals[k, i, lane] * normals[k, j, lane]
                        local[3 * p + i, 3 * q + j, lane] += total
    for g in range(6):
        for p in range(5):
            for q in range(p + 1):
                part = ALONG[g, p] * ALONG[g, q]
                if part != 0.0:
                    for i in range(3):
                        for j in range(3 if q < p else i + 1):
                            for lane in range(LANES):
                                local[3 * p + i, 3 * q + j, lane] += part * forms[g, i, j, lane]


@compiled
def mean_second(pull, forms, tangent, exact, convexity, local):  # type: ignore[no-untyped-def]
    """Add the form of the mean membrane forces, mixed with that of the mean tension alone."""
    for lane in range(LANES):
        n0, n1, n2 = exact * pull[6, lane], exact * pull[7, lane], exact * pull[8, lane]
        if convexity > 0.0:
            m0, m1, m2 = pull[6, lane], pull[7, lane], pull[8, lane]
            for g in range(6):
                tx, ty = tangent[g // 2, 0, lane], tangent[g // 2, 1, lane]
                m0, m1, m2 = m0 + pull[g, lane] * tx * tx, m1 + pull[g, lane] * ty * ty, m2 + pull[g, lane] * tx * ty
            m0, m1, m2 = tension(m0, m1, m2)
            n0, n1, n2 = n0 + convexity * m0, n1 + convexity * m1, n2 + convexity * m2
        for p in range(5):
            for q in range(p + 1):
                form = n0 * forms[0, p, q, lane] + n1 * forms[1, p, q, lane] + n2 * forms[2, p, q, lane]
                for axis in range(3):
                    local[3 * p + axis, 3 * q + axis, lane] += form
