"""The tangent of shell facets that answer by sections of their own, as where they yield, one after the other.

For Numba to compile; only :mod:`kirigami.elements.compiled_shell` imports this file.
"""

from __future__ import annotations

import numpy as np

from kirigami.elements.shell_loops import (
    ALONG,
    FIRST,
    INWARD,
    SECOND,
    area_frame,
    bend_rows,
    compiled,
    dot,
    edge_frame,
    gather,
    mixed,
    pulled_back,
    scatter,
    stretch_rows,
    tension,
)


@compiled
def stretch_second(f, pull, per_square, forms, tangent, exact, convexity, form):  # type: ignore[no-untyped-def]
    """Form (5, 5) of the membrane forces, mixed with that of the mean tension alone."""
    form[:, :] = 0.0
    for g in range(6):
        weight = exact * pull[g] * per_square[f, g]
        for p in range(5):
            for q in range(5):
                form[p, q] += weight * ALONG[g, p] * ALONG[g, q]
    n0, n1, n2 = exact * pull[6], exact * pull[7], exact * pull[8]
    if convexity > 0.0:
        m0, m1, m2 = pull[6], pull[7], pull[8]
        for g in range(6):
            tx, ty = tangent[f, g // 2, 0], tangent[f, g // 2, 1]
            m0, m1, m2 = m0 + pull[g] * tx * tx, m1 + pull[g] * ty * ty, m2 + pull[g] * tx * ty
        m0, m1, m2 = tension(m0, m1, m2)
        n0, n1, n2 = n0 + convexity * m0, n1 + convexity * m1, n2 + convexity * m2
    for p in range(5):
        for q in range(5):
            form[p, q] += n0 * forms[f, 0, p, q] + n1 * forms[f, 1, p, q] + n2 * forms[f, 2, p, q]


@compiled
def add_dyad(local, rows, i, other, j, c, a, b):  # type: ignore[no-untyped-def]
    """Add the second derivative c (a.dV_i) (b.dV_j), V = rows times the vectors, made symmetric by the caller."""
    for p in range(5):
        for q in range(5):
            weight = c * rows[i, p] * other[j, q]
            if weight != 0.0:
                for k in range(3):
                    for m in range(3):
                        local[3 * p + k, 3 * q + m] += weight * a[k] * b[m]


@compiled
def inside_second(f, v, moment, second, local):  # type: ignore[no-untyped-def]
    """Add half of the second derivative of the curvatures inside; the caller adds the transpose."""
    for q in range(3):
        normal, one, two = area_frame(q, v)
        load = (0.0, 0.0, 0.0)
        for e in range(3):
            share = 0.0
            for c in range(3):
                share += moment[3 * q + c] * second[f, e, c]
            load = mixed(1.0, load, share, v[2 + e])
            for p in range(5):  # n.dg_A against g^A.dw
                for k in range(3):
                    for m in range(3):
                        local[3 * p + k, 6 + 3 * e + m] -= share * normal[k] * (
                            FIRST[q, p] * one[m] + SECOND[q, p] * two[m]
                        )
        height, tilt_one, tilt_two = dot(normal, load), dot(one, load), dot(two, load)
        h11, h12, h22 = -0.5 * height * dot(one, one), -0.5 * height * dot(one, two), -0.5 * height * dot(two, two)
        add_dyad(local, FIRST, q, FIRST, q, 1.0, normal, mixed(tilt_one, one, h11, normal))
        add_dyad(local, FIRST, q, SECOND, q, 1.0, normal, mixed(tilt_two, one, h12, normal))
        add_dyad(local, SECOND, q, FIRST, q, 1.0, normal, mixed(tilt_one, two, h12, normal))
        add_dyad(local, SECOND, q, SECOND, q, 1.0, normal, mixed(tilt_two, two, h22, normal))


@compiled
def angle_second(f, v, moment, director, rows, local):  # type: ignore[no-untyped-def]
    """Add half of the second derivative of the angles; `rows` is a work array for the slanted inward rows."""
    for g in range(6):
        c = moment[9 + g]
        normal, inward, tangent, length, reach, slant = edge_frame(g, v)
        for p in range(5):
            rows[0, p] = INWARD[g, p] - slant * ALONG[g, p]
        seen = director[f, g]
        up, side, lean = dot(seen, normal), dot(seen, inward), dot(seen, tangent)
        square = up * up + side * side
        across, turned = mixed(up, normal, side, inward), mixed(up, inward, -side, normal)
        add_dyad(local, ALONG, g, rows, 0, c / (length * reach), normal, tangent)
        add_dyad(local, rows, 0, rows, 0, c / reach**2, normal, inward)
        add_dyad(local, ALONG, g, ALONG, g, 0.5 * c / length**2, normal, inward)
        curl = mixed(0.5 * (1.0 + lean * lean) / square**2, across, -lean / square, tangent)
        add_dyad(local, ALONG, g, ALONG, g, c / length**2, turned, curl)


@compiled
def blocks(  # type: ignore[no-untyped-def]
    facets, answers, sections, conn, u, rest, per_square, forms, to_strain, to_curvature, second, area, director,
    stored, scale, first, last, tangent, convexity, slots, target,
):  # fmt: skip
    """Add the Hessian of `facets` (k,), whose derivatives by the fields are `answers` (k, 18), and whose tangents are
    `sections` (k, 3, 6, 6) at the points inside."""
    n = len(conn)
    exact = 1.0 - convexity
    du, v = np.empty((5, 3)), np.empty((5, 3))
    pull, moment, form, work = np.empty(9), np.empty(15), np.empty((5, 5)), np.empty((1, 5))
    membrane, bending = np.empty((9, 15)), np.zeros((15, 21))
    rows, stiff, local = np.empty((18, 21)), np.empty((18, 21)), np.empty((21, 21))
    full = np.zeros((27, 27))
    place = np.empty(21, np.int64)
    for own in range(first, last):
        f = facets[own]
        gather(f, conn, u, rest, du, v)
        pulled_back(f, answers[own], to_strain, to_curvature, pull, moment)
        stretch_rows(f, v, per_square, forms, membrane)
        bend_rows(f, v, director, scale, second, bending)
        # Strain and curvature at the corners, each plus a third of their sum: energy is then a sum of squares.
        for i in range(3):
            for c in range(3):
                for z in range(21):
                    rows[6 * i + c, z] = 0.0
                    rows[6 * i + 3 + c, z] = 0.0
                for m in range(9):
                    weight = to_strain[f, 3 * i + c, m]
                    for z in range(15):
                        rows[6 * i + c, z] += weight * membrane[m, z]
                for m in range(15):
                    weight = to_curvature[f, 3 * i + c, m]
                    if weight != 0.0:
                        for z in range(21):
                            rows[6 * i + 3 + c, z] += weight * bending[m, z]
        for c in range(6):
            for z in range(21):
                third = (rows[c, z] + rows[6 + c, z] + rows[12 + c, z]) / 3.0
                rows[c, z] += third
                rows[6 + c, z] += third
                rows[12 + c, z] += third
        for i in range(3):
            for c in range(6):
                for z in range(21):
                    stiff[6 * i + c, z] = 0.0
                for d in range(6):
                    weight = sections[own, i, c, d] * area[f] / 12.0
                    if weight != 0.0:
                        for z in range(21):
                            stiff[6 * i + c, z] += weight * rows[6 * i + d, z]
        local[:, :] = 0.0
        if exact > 0.0:
            for m in range(15):
                moment[m] *= exact
            inside_second(f, v, moment, second, local)
            angle_second(f, v, moment, director, work, local)
            for y in range(15):
                for z in range(y + 1):
                    both = local[y, z] + local[z, y]
                    local[y, z], local[z, y] = both, both
        stretch_second(f, pull, per_square, forms, tangent, exact, convexity, form)
        for p in range(5):
            for q in range(5):
                for axis in range(3):
                    local[3 * p + axis, 3 * q + axis] += form[p, q]
        for m in range(18):
            for y in range(21):
                weight = rows[m, y]
                for z in range(y + 1):
                    local[y, z] += weight * stiff[m, z]
        scatter(local, stored[f], f, n, slots, full, place, target)
