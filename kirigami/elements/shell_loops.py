"""Measures and forces of shell facets, one after the other, and what their tangents share, for Numba to compile.

The formulas are those of :mod:`kirigami.elements.shell_membrane` and :mod:`kirigami.elements.shell_bending`; here each
facet is taken to its end, from displacements to entries of the node blocks.
"""

from __future__ import annotations

import math

import numpy as np

from kirigami.elements.shell_geometry import AREA_ROWS, EDGE_ROWS
from kirigami.primitives.compiling import compiler

compiled = compiler(nogil=True)

ALONG, INWARD = np.ascontiguousarray(EDGE_ROWS[0]), np.ascontiguousarray(EDGE_ROWS[1])
FIRST, SECOND = np.ascontiguousarray(AREA_ROWS[0]), np.ascontiguousarray(AREA_ROWS[1])
TURN = 2 * math.pi


@compiled
def combination(rows, k, v):  # type: ignore[no-untyped-def]
    """Row k of a table times the five vectors."""
    a = b = c = 0.0
    for p in range(5):
        a += rows[k, p] * v[p, 0]
        b += rows[k, p] * v[p, 1]
        c += rows[k, p] * v[p, 2]
    return a, b, c


@compiled
def dot(a, b):  # type: ignore[no-untyped-def]
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@compiled
def cross(a, b):  # type: ignore[no-untyped-def]
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


@compiled
def scaled(c, a):  # type: ignore[no-untyped-def]
    return c * a[0], c * a[1], c * a[2]


@compiled
def mixed(c, a, d, b):  # type: ignore[no-untyped-def]
    return c * a[0] + d * b[0], c * a[1] + d * b[1], c * a[2] + d * b[2]


@compiled
def gather(f, conn, u, rest, du, v):  # type: ignore[no-untyped-def]
    """Change of the five vectors of facet f, and the vectors themselves."""
    for axis in range(3):
        corner = u[conn[f, 0], axis]
        du[0, axis] = u[conn[f, 1], axis] - corner
        du[1, axis] = u[conn[f, 2], axis] - corner
        for edge in range(3):
            du[2 + edge, axis] = u[conn[f, 3 + edge], axis]
        for p in range(5):
            v[p, axis] = rest[f, p, axis] + du[p, axis]


@compiled
def stretch(f, rest, du, per_square, forms, found):  # type: ignore[no-untyped-def]
    """The nine membrane measures."""
    for g in range(6):
        now, before = combination(ALONG, g, du), combination(ALONG, g, rest[f])
        found[g] = per_square[f, g] * dot(mixed(1.0, before, 0.5, now), now)
    for c in range(3):
        found[6 + c] = 0.0
    for p in range(5):
        for q in range(5):
            gram = 0.0
            for axis in range(3):
                gram += (rest[f, p, axis] + 0.5 * du[p, axis]) * du[q, axis]
            for c in range(3):
                found[6 + c] += forms[f, c, p, q] * gram


@compiled
def stretch_rows(f, v, per_square, forms, rows):  # type: ignore[no-untyped-def]
    """First derivatives (9, 15) of the membrane measures."""
    for g in range(6):
        along = scaled(per_square[f, g], combination(ALONG, g, v))
        for p in range(5):
            for axis in range(3):
                rows[g, 3 * p + axis] = ALONG[g, p] * along[axis]
    for c in range(3):
        for p in range(5):
            for axis in range(3):
                total = 0.0
                for q in range(5):
                    total += forms[f, c, p, q] * v[q, axis]
                rows[6 + c, 3 * p + axis] = total


@compiled
def edge_frame(g, v):  # type: ignore[no-untyped-def]
    """Normal, inward and tangent unit vectors at Gauss point g, length along, reach and slant."""
    along, across = combination(ALONG, g, v), combination(INWARD, g, v)
    length = math.sqrt(dot(along, along))
    tangent = scaled(1.0 / length, along)
    normal = cross(along, across)
    normal = scaled(1.0 / math.sqrt(dot(normal, normal)), normal)
    inward = cross(normal, tangent)
    return normal, inward, tangent, length, dot(across, inward), dot(across, tangent) / length


@compiled
def area_frame(q, v):  # type: ignore[no-untyped-def]
    """Normal and dual vectors at point q inside."""
    first, second = combination(FIRST, q, v), combination(SECOND, q, v)
    normal = cross(first, second)
    size = math.sqrt(dot(normal, normal))
    normal = scaled(1.0 / size, normal)
    return normal, scaled(1.0 / size, cross(second, normal)), scaled(1.0 / size, cross(normal, first))


@compiled
def bend(f, v, x, conn, director, stored, scale, second, rest_angle, rest_curvature, found):  # type: ignore[no-untyped-def]
    """The fifteen bending measures."""
    for q in range(3):
        normal, _, _ = area_frame(q, v)
        for c in range(3):
            found[3 * q + c] = -rest_curvature[f, 3 * q + c]
        for e in range(3):
            height = normal[0] * v[2 + e, 0] + normal[1] * v[2 + e, 1] + normal[2] * v[2 + e, 2]
            for c in range(3):
                found[3 * q + c] += second[f, e, c] * height
    for g in range(6):
        normal, inward, _, _, _, _ = edge_frame(g, v)
        p = director[f, g]
        angle = math.atan2(-dot(p, inward), dot(p, normal)) - rest_angle[f, g]
        angle -= x[conn[f, 6 + g // 2], stored[f, g]] * scale[f, g]
        found[9 + g] = angle - TURN * np.rint(angle / TURN)


@compiled
def bend_rows(f, v, director, scale, second, rows):  # type: ignore[no-untyped-def]
    """First derivatives (15, 21) of the bending measures by the five vectors and the six local angles as stored."""
    for q in range(3):
        normal, one, two = area_frame(q, v)
        for c in range(3):
            for p in range(5):
                share = second[f, p - 2, c] if p >= 2 else 0.0
                for e in range(3):
                    w = v[2 + e]
                    share -= second[f, e, c] * (dot(one, w) * FIRST[q, p] + dot(two, w) * SECOND[q, p])
                for axis in range(3):
                    rows[3 * q + c, 3 * p + axis] = share * normal[axis]
    for g in range(6):
        normal, inward, tangent, length, reach, slant = edge_frame(g, v)
        seen = director[f, g]
        up, side, lean = dot(seen, normal), dot(seen, inward), dot(seen, tangent)
        slide = scaled(lean / ((up * up + side * side) * length), mixed(up, inward, -side, normal))
        for p in range(5):
            lever = -(INWARD[g, p] - slant * ALONG[g, p]) / reach
            for axis in range(3):
                rows[9 + g, 3 * p + axis] = lever * normal[axis] + ALONG[g, p] * slide[axis]
        for other in range(6):
            rows[9 + g, 15 + other] = 0.0
        rows[9 + g, 15 + g] = -scale[f, g]


@compiled
def fields_of(f, r, b, to_strain, to_curvature, fields):  # type: ignore[no-untyped-def]
    """Strain and curvature (18,) at the corners, six numbers each."""
    for i in range(3):
        for c in range(3):
            total = 0.0
            for m in range(9):
                total += to_strain[f, 3 * i + c, m] * r[m]
            fields[6 * i + c] = total
            total = 0.0
            for m in range(15):
                total += to_curvature[f, 3 * i + c, m] * b[m]
            fields[6 * i + 3 + c] = total


@compiled
def released(f, natural, fields):  # type: ignore[no-untyped-def]
    """Take off what a facet bears nothing at, of `natural` (n, 6), or nothing where that is empty."""
    if len(natural):
        for i in range(3):
            for c in range(6):
                fields[6 * i + c] -= natural[f, c]


@compiled
def resultants_of(f, fields, section, area, force):  # type: ignore[no-untyped-def]
    """Derivatives (18,) of the energy by the fields at the corners, of a facet that is elastic."""
    scale = area[f] / 12.0
    for c in range(6):
        total = 0.0
        for i in range(3):
            value = 0.0
            for d in range(6):
                value += section[f, c, d] * fields[6 * i + d]
            force[6 * i + c] = value
            total += value
        for i in range(3):
            force[6 * i + c] = scale * (force[6 * i + c] + total)


@compiled
def pulled_back(f, force, to_strain, to_curvature, pull, moment):  # type: ignore[no-untyped-def]
    """Derivatives of the energy by the membrane (9,) and bending (15,) measures."""
    for m in range(9):
        pull[m] = 0.0
    for m in range(15):
        moment[m] = 0.0
    for i in range(3):
        for c in range(3):
            n, k = force[6 * i + c], force[6 * i + 3 + c]
            for m in range(9):
                pull[m] += to_strain[f, 3 * i + c, m] * n
            for m in range(15):
                moment[m] += to_curvature[f, 3 * i + c, m] * k


@compiled
def fields_at(  # type: ignore[no-untyped-def]
    conn, x, u, rest, per_square, forms, to_strain, to_curvature, second, section, area,
    rest_angle, rest_curvature, director, stored, scale, natural, found,
):  # fmt: skip
    """Strain and curvature (n, 18) at the corners of all facets, beyond what they bear nothing at."""
    du, v, r, b = np.empty((5, 3)), np.empty((5, 3)), np.empty(9), np.empty(15)
    for f in range(len(conn)):
        gather(f, conn, u, rest, du, v)
        stretch(f, rest, du, per_square, forms, r)
        bend(f, v, x, conn, director, stored, scale, second, rest_angle, rest_curvature, b)
        fields_of(f, r, b, to_strain, to_curvature, found[f])
        released(f, natural, found[f])


@compiled
def pull_ahead(  # type: ignore[no-untyped-def]
    conn, u, change, rest, per_square, forms, to_strain, section, area, curvature, natural, ahead
):
    """Membrane forces by the measures, after a linear step `change` off u; curvatures (n, 3, 3) as they are there."""
    du, v, step = np.empty((5, 3)), np.empty((5, 3)), np.empty((5, 3))
    r, fields, force, membrane, rate = np.empty(9), np.empty(18), np.empty(18), np.empty((9, 15)), np.empty((5, 3))
    for f in range(len(conn)):
        gather(f, conn, u, rest, du, v)
        stretch(f, rest, du, per_square, forms, r)
        gather(f, conn, change, rest, rate, step)
        stretch_rows(f, v, per_square, forms, membrane)
        for m in range(9):
            for p in range(5):
                for axis in range(3):
                    r[m] += membrane[m, 3 * p + axis] * rate[p, axis]
        for i in range(3):
            for c in range(3):
                value = 0.0
                for m in range(9):
                    value += to_strain[f, 3 * i + c, m] * r[m]
                fields[6 * i + c] = value
                fields[6 * i + 3 + c] = curvature[f, i, c]
        released(f, natural, fields)
        resultants_of(f, fields, section, area, force)
        for m in range(9):
            value = 0.0
            for i in range(3):
                for c in range(3):
                    value += to_strain[f, 3 * i + c, m] * force[6 * i + c]
            ahead[f, m] = value


@compiled
def tension(n0, n1, n2):  # type: ignore[no-untyped-def]
    """The part of membrane forces (xx, yy, xy) whose principal values are not negative."""
    mean, half = 0.5 * (n0 + n1), 0.5 * (n0 - n1)
    radius = math.hypot(half, n2)
    high, low = max(mean + radius, 0.0), max(mean - radius, 0.0)
    turn = 0.5 * (high - low) / radius if radius > 0.0 else 0.0
    centre = 0.5 * (high + low)
    return centre + turn * half, centre - turn * half, turn * n2


@compiled
def scatter(local, stored, f, n, slots, full, place, target):  # type: ignore[no-untyped-def]
    """Add the tangent of facet f of n, the lower half of `local` (21, 21) by its vectors and angles, to the blocks of
    the system's rows. `stored` (6,) are the places of its angles; `full` (27, 27) of zeros and `place` (21,) are work
    arrays."""
    count = len(target)
    for z in range(15):
        place[z] = 3 + z
    for g in range(6):
        place[15 + g] = 18 + 3 * (g // 2) + stored[g]
    for y in range(21):
        for z in range(y + 1):
            value = local[y, z]
            full[place[y], place[z]] = value
            full[place[z], place[y]] = value
    for axis in range(3):
        for z in range(3, 27):
            full[axis, z] = -full[3 + axis, z] - full[6 + axis, z]
    for axis in range(3):
        for other in range(3):
            full[axis, other] = -full[axis, 3 + other] - full[axis, 6 + other]
    pair = 0
    for i in range(9):
        for j in range(i, 9):
            slot = slots[pair * n + f]
            pair += 1
            if slot < count:
                for k in range(3):
                    for m in range(3):
                        target[slot, k, m] += full[3 * i + k, 3 * j + m]
            else:
                slot -= count
                for k in range(3):
                    for m in range(3):
                        target[slot, k, m] += full[3 * i + m, 3 * j + k]
