"""Measures of shell facets and their derivatives, LANES facets at once; see :mod:`kirigami.elements.shell_lanes`."""


from __future__ import annotations

import math

import numpy as np

from kirigami.elements.shell_loops import ALONG, FIRST, INWARD, SECOND, TURN, compiled

LANES = 16  # facets side by side: two to four vector registers, and all they need in the nearest cache


@compiled
def combine(rows, k, v, found):  # type: ignore[no-untyped-def]
    """Row k of a table times the five vectors, into found (3, LANES)."""
    for axis in range(3):
        for lane in range(LANES):
            found[axis, lane] = (
                rows[k, 0] * v[0, axis, lane] + rows[k, 1] * v[1, axis, lane] + rows[k, 2] * v[2, axis, lane]
                + rows[k, 3] * v[3, axis, lane] + rows[k, 4] * v[4, axis, lane]
            )  # fmt: skip


@compiled
def gather(f, n, conn, u, rest, du, v):  # type: ignore[no-untyped-def]
    """Change of the five vectors of facets from f on, and the vectors themselves; beyond the last facet it repeats."""
    for lane in range(LANES):
        at = min(f + lane, n - 1)
        for axis in range(3):
            corner = u[conn[at, 0], axis]
            du[0, axis, lane] = u[conn[at, 1], axis] - corner
            du[1, axis, lane] = u[conn[at, 2], axis] - corner
            for edge in range(3):
                du[2 + edge, axis, lane] = u[conn[at, 3 + edge], axis]
            for p in range(5):
                v[p, axis, lane] = rest[p, axis, lane] + du[p, axis, lane]


@compiled
def edge_frames(v, normal, inward, tangent, sizes, along, across):  # type: ignore[no-untyped-def]
    """Unit vectors (6, 3, LANES) at the Gauss points; sizes (3, 6, LANES): length along, reach and slant."""
    for g in range(6):
        combine(ALONG, g, v, along)
        combine(INWARD, g, v, across)
        for lane in range(LANES):
            t0, t1, t2 = along[0, lane], along[1, lane], along[2, lane]
            a0, a1, a2 = across[0, lane], across[1, lane], across[2, lane]
            length = math.sqrt(t0 * t0 + t1 * t1 + t2 * t2)
            t0, t1, t2 = t0 / length, t1 / length, t2 / length
            n0, n1, n2 = t1 * a2 - t2 * a1, t2 * a0 - t0 * a2, t0 * a1 - t1 * a0
            size = math.sqrt(n0 * n0 + n1 * n1 + n2 * n2)
            n0, n1, n2 = n0 / size, n1 / size, n2 / size
            m0, m1, m2 = n1 * t2 - n2 * t1, n2 * t0 - n0 * t2, n0 * t1 - n1 * t0
            normal[g, 0, lane], normal[g, 1, lane], normal[g, 2, lane] = n0, n1, n2
            inward[g, 0, lane], inward[g, 1, lane], inward[g, 2, lane] = m0, m1, m2
            tangent[g, 0, lane], tangent[g, 1, lane], tangent[g, 2, lane] = t0, t1, t2
            sizes[0, g, lane] = length
            sizes[1, g, lane] = a0 * m0 + a1 * m1 + a2 * m2
            sizes[2, g, lane] = (a0 * t0 + a1 * t1 + a2 * t2) / length


@compiled
def area_frames(v, normal, dual, first, second):  # type: ignore[no-untyped-def]
    """Normals (3, 3, LANES) at the points inside and dual vectors (2, 3, 3, LANES)."""
    for q in range(3):
        combine(FIRST, q, v, first)
        combine(SECOND, q, v, second)
        for lane in range(LANES):
            a0, a1, a2 = first[0, lane], first[1, lane], first[2, lane]
            b0, b1, b2 = second[0, lane], second[1, lane], second[2, lane]
            n0, n1, n2 = a1 * b2 - a2 * b1, a2 * b0 - a0 * b2, a0 * b1 - a1 * b0
            size = math.sqrt(n0 * n0 + n1 * n1 + n2 * n2)
            n0, n1, n2 = n0 / size, n1 / size, n2 / size
            normal[q, 0, lane], normal[q, 1, lane], normal[q, 2, lane] = n0, n1, n2
            dual[0, q, 0, lane] = (b1 * n2 - b2 * n1) / size
            dual[0, q, 1, lane] = (b2 * n0 - b0 * n2) / size
            dual[0, q, 2, lane] = (b0 * n1 - b1 * n0) / size
            dual[1, q, 0, lane] = (n1 * a2 - n2 * a1) / size
            dual[1, q, 1, lane] = (n2 * a0 - n0 * a2) / size
            dual[1, q, 2, lane] = (n0 * a1 - n1 * a0) / size


@compiled
def facing(normal, inward, tangent, seen, found):  # type: ignore[no-untyped-def]
    """Parts (3, 6, LANES) of the directors `seen` (6, 3, LANES) along the normals, inwards and along the edges."""
    for g in range(6):
        for lane in range(LANES):
            up = side = lean = 0.0
            for axis in range(3):
                up += seen[g, axis, lane] * normal[g, axis, lane]
                side += seen[g, axis, lane] * inward[g, axis, lane]
                lean += seen[g, axis, lane] * tangent[g, axis, lane]
            found[0, g, lane], found[1, g, lane], found[2, g, lane] = up, side, lean


@compiled
def stretched(du, rest, per_square, forms, r, now, before):  # type: ignore[no-untyped-def]
    """The nine membrane measures r (9, LANES)."""
    for g in range(6):
        combine(ALONG, g, du, now)
        combine(ALONG, g, rest, before)
        for lane in range(LANES):
            total = 0.0
            for axis in range(3):
                total += (before[axis, lane] + 0.5 * now[axis, lane]) * now[axis, lane]
            r[g, lane] = per_square[g, lane] * total
    r[6:] = 0.0
    for p in range(5):
        for q in range(5):
            for lane in range(LANES):
                gram = 0.0
                for axis in range(3):
                    gram += (rest[p, axis, lane] + 0.5 * du[p, axis, lane]) * du[q, axis, lane]
                for c in range(3):
                    r[6 + c, lane] += forms[c, p, q, lane] * gram


@compiled
def bent(v, area_normal, faced, turned, second, rest_angle, rest_curvature, scale, b):  # type: ignore[no-untyped-def]
    """The fifteen bending measures b (15, LANES); `turned` (6, LANES) are the stored angles."""
    for q in range(3):
        for c in range(3):
            for lane in range(LANES):
                b[3 * q + c, lane] = -rest_curvature[3 * q + c, lane]
        for e in range(3):
            for lane in range(LANES):
                height = 0.0
                for axis in range(3):
                    height += area_normal[q, axis, lane] * v[2 + e, axis, lane]
                for c in range(3):
                    b[3 * q + c, lane] += second[e, c, lane] * height
    for g in range(6):
        for lane in range(LANES):
            angle = math.atan2(-faced[1, g, lane], faced[0, g, lane]) - rest_angle[g, lane]
            angle -= turned[g, lane] * scale[g, lane]
            b[9 + g, lane] = angle - TURN * np.rint(angle / TURN)


@compiled
def weigh(matrix, values, found):  # type: ignore[no-untyped-def]
    """Add a matrix (9, k, LANES) times values (k, LANES) to found (9, LANES)."""
    for i in range(9):
        for m in range(len(values)):
            for lane in range(LANES):
                found[i, lane] += matrix[i, m, lane] * values[m, lane]


@compiled
def weigh_back(matrix, values, found):  # type: ignore[no-untyped-def]
    """Add a turned matrix (9, k, LANES) times values (9, LANES) to found (k, LANES)."""
    for i in range(9):
        for m in range(len(found)):
            for lane in range(LANES):
                found[m, lane] += matrix[i, m, lane] * values[i, lane]


@compiled
def stretch_slopes(v, per_square, forms, slopes):  # type: ignore[no-untyped-def]
    """Derivatives (9, 15, LANES) of the membrane measures by the vectors; those that are always zero are left alone."""
    for g in range(6):
        for p in range(5):
            if ALONG[g, p] != 0.0:
                for axis in range(3):
                    for lane in range(LANES):
                        total = 0.0
                        for q in range(5):
                            total += ALONG[g, q] * v[q, axis, lane]
                        slopes[g, 3 * p + axis, lane] = ALONG[g, p] * per_square[g, lane] * total
    for c in range(3):
        for p in range(5):
            for axis in range(3):
                for lane in range(LANES):
                    total = 0.0
                    for q in range(5):
                        total += forms[c, p, q, lane] * v[q, axis, lane]
                    slopes[6 + c, 3 * p + axis, lane] = total


@compiled
def stretch_rows(stretch, slopes, rows):  # type: ignore[no-untyped-def]
    """Derivatives (9, 15, LANES) of the weighted membrane measures by the vectors, of those of the measures."""
    for i in range(9):
        for z in range(15):
            for lane in range(LANES):
                total = 0.0
                for m in range(9):
                    total += stretch[i, m, lane] * slopes[m, z, lane]
                rows[i, z, lane] = total


@compiled
def bend_shares(v, dual, second, shares):  # type: ignore[no-untyped-def]
    """Derivatives of the curvatures inside, as shares (9, 5, LANES) of the normal there."""
    for q in range(3):
        for c in range(3):
            for lane in range(LANES):
                shares[3 * q + c, 0, lane] = shares[3 * q + c, 1, lane] = 0.0
            for e in range(3):
                for lane in range(LANES):
                    shares[3 * q + c, 2 + e, lane] = second[e, c, lane]
        for e in range(3):
            for lane in range(LANES):
                one = two = 0.0
                for axis in range(3):
                    one += dual[0, q, axis, lane] * v[2 + e, axis, lane]
                    two += dual[1, q, axis, lane] * v[2 + e, axis, lane]
                for p in range(5):
                    tilt = one * FIRST[q, p] + two * SECOND[q, p]
                    for c in range(3):
                        shares[3 * q + c, p, lane] -= second[e, c, lane] * tilt


@compiled
def angle_rows(normal, inward, sizes, faced, levers, slides):  # type: ignore[no-untyped-def]
    """Derivatives of the angles: levers (6, 5, LANES) along the normal, and slides (6, 3, LANES) for ALONG."""
    for g in range(6):
        for lane in range(LANES):
            up, side, lean = faced[0, g, lane], faced[1, g, lane], faced[2, g, lane]
            size = lean / ((up * up + side * side) * sizes[0, g, lane])
            for axis in range(3):
                slides[g, axis, lane] = size * (up * inward[g, axis, lane] - side * normal[g, axis, lane])
            for p in range(5):
                levers[g, p, lane] = -(INWARD[g, p] - sizes[2, g, lane] * ALONG[g, p]) / sizes[1, g, lane]


@compiled
def bend_slopes(area_normal, normal, shares, levers, slides, slopes):  # type: ignore[no-untyped-def]
    """Derivatives (15, 15, LANES) of the bending measures by the vectors."""
    width = slopes.shape[2]
    for m in range(9):
        for p in range(5):
            for axis in range(3):
                for lane in range(width):
                    slopes[m, 3 * p + axis, lane] = shares[m, p, lane] * area_normal[m // 3, axis, lane]
    for g in range(6):
        for p in range(5):
            part = ALONG[g, p]
            for axis in range(3):
                for lane in range(width):
                    slopes[9 + g, 3 * p + axis, lane] = (
                        levers[g, p, lane] * normal[g, axis, lane] + part * slides[g, axis, lane]
                    )


@compiled
def bend_rows(bend, slopes, scale, kept, rows):  # type: ignore[no-untyped-def]
    """Derivatives (9, 21, LANES) of weighted bending measures by the vectors and the local angles as stored, beside
    what is `kept` of the rows."""
    for i in range(9):
        for z in range(15):
            for lane in range(LANES):
                total = 0.0
                for m in range(15):
                    total += bend[i, m, lane] * slopes[m, z, lane]
                rows[i, z, lane] = kept * rows[i, z, lane] + total
        for g in range(6):
            for lane in range(LANES):
                rows[i, 15 + g, lane] = kept * rows[i, 15 + g, lane] - bend[i, 9 + g, lane] * scale[g, lane]
