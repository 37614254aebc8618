"""Second derivatives of shell facets, LANES facets at once; see :mod:`kirigami.elements.shell_lanes`."""

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
def add_pairs(first, second, k, one, cross, two, local, left, right):  # type: ignore[no-untyped-def]
    """Add the lower half of the form with blocks one, cross and two (3, 3, LANES) in the vectors that row k of the
    tables `first` and `second` makes of the five."""
    for p in range(5):
        a, b = first[k, p], second[k, p]
        for i in range(3):
            for j in range(3):
                for lane in range(LANES):
                    left[i, j, lane] = a * one[i, j, lane] + b * cross[j, i, lane]
                    right[i, j, lane] = a * cross[i, j, lane] + b * two[i, j, lane]
        for q in range(p + 1):
            c, d = first[k, q], second[k, q]
            for i in range(3):
                for j in range(3 if q < p else i + 1):
                    for lane in range(LANES):
                        local[3 * p + i, 3 * q + j, lane] += c * left[i, j, lane] + d * right[i, j, lane]


@compiled
def inside_second(v, normal, dual, moment, second, local, work):  # type: ignore[no-untyped-def]
    """Add the second derivatives of the curvatures inside, summed with their moments."""
    one, cross, two, left, right, shares, load = work
    for q in range(3):
        load[:] = 0.0
        for e in range(3):
            for lane in range(LANES):
                share = 0.0
                for c in range(3):
                    share += moment[3 * q + c, lane] * second[e, c, lane]
                shares[e, lane] = share
                for axis in range(3):
                    load[axis, lane] += share * v[2 + e, axis, lane]
        for lane in range(LANES):
            height = tilt_one = tilt_two = d11 = d12 = d22 = 0.0
            for axis in range(3):
                height += normal[q, axis, lane] * load[axis, lane]
                tilt_one += dual[0, q, axis, lane] * load[axis, lane]
                tilt_two += dual[1, q, axis, lane] * load[axis, lane]
                d11 += dual[0, q, axis, lane] * dual[0, q, axis, lane]
                d12 += dual[0, q, axis, lane] * dual[1, q, axis, lane]
                d22 += dual[1, q, axis, lane] * dual[1, q, axis, lane]
            for i in range(3):
                n, a, b = normal[q, i, lane], dual[0, q, i, lane], dual[1, q, i, lane]
                for j in range(3):
                    m, c, d = normal[q, j, lane], dual[0, q, j, lane], dual[1, q, j, lane]
                    one[i, j, lane] = tilt_one * (n * c + a * m) - height * d11 * n * m
                    cross[i, j, lane] = tilt_two * n * c + tilt_one * b * m - height * d12 * n * m
                    two[i, j, lane] = tilt_two * (n * d + b * m) - height * d22 * n * m
        add_pairs(FIRST, SECOND, q, one, cross, two, local, left, right)
        for p in range(5):  # n.dg_A against g^A.dw
            for i in range(3):
                for j in range(3):
                    for lane in range(LANES):
                        left[i, j, lane] = normal[q, i, lane] * (
                            FIRST[q, p] * dual[0, q, j, lane] + SECOND[q, p] * dual[1, q, j, lane]
                        )
            for e in range(3):
                for i in range(3):
                    for j in range(3):
                        row, column = 3 * p + i, 6 + 3 * e + j
                        high, low, times = max(row, column), min(row, column), 2.0 if row == column else 1.0
                        for lane in range(LANES):
                            local[high, low, lane] -= times * shares[e, lane] * left[i, j, lane]


@compiled
def edges_second(frames, faced, moment, pull, per_square, local, work):  # type: ignore[no-untyped-def]
    """Add the second derivatives of the angles, summed with their moments, and of the strains along the edges."""
    normal, inward, tangent, sizes = frames
    one, cross, two, left, right, _, _ = work
    for g in range(6):
        for lane in range(LANES):
            up, side, lean = faced[0, g, lane], faced[1, g, lane], faced[2, g, lane]
            square = up * up + side * side
            c = moment[9 + g, lane]
            length, reach, slant = sizes[0, g, lane], sizes[1, g, lane], sizes[2, g, lane]
            mixed, inner, along = c / (length * reach), c / (reach * reach), c / (length * length)
            over, under = 0.5 * (1.0 + lean * lean) / (square * square), lean / square
            for i in range(3):
                n, m, t = normal[g, i, lane], inward[g, i, lane], tangent[g, i, lane]
                turn, curl = up * m - side * n, over * (up * n + side * m) - under * t
                for j in range(3):
                    nn, mm, tt = normal[g, j, lane], inward[g, j, lane], tangent[g, j, lane]
                    other, bend = up * mm - side * nn, over * (up * nn + side * mm) - under * tt
                    both = inner * (n * mm + m * nn)
                    shear = mixed * n * tt
                    one[i, j, lane] = (
                        along * (0.5 * (n * mm + m * nn) + turn * bend + curl * other)
                        - slant * (shear + mixed * t * nn) + slant * slant * both
                    )  # fmt: skip
                    cross[i, j, lane] = shear - slant * both
                    two[i, j, lane] = both
            for i in range(3):
                one[i, i, lane] += pull[g, lane] * per_square[g, lane]
        add_pairs(ALONG, INWARD, g, one, cross, two, local, left, right)


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
