"""Edges of bars and hinges that clamps and mirror planes hold, for Numba to compile; only
:mod:`kirigami.elements.compiled` imports this file.

Same formulas as :mod:`kirigami.elements.edge_turn`; conn (n, 3) are the wing i and the ends j, k of each edge.
"""

from __future__ import annotations

import math

import numpy as np

from kirigami.elements.compiled_loops import compiled, mixed, push, scaled
from kirigami.elements.shell_loops import dot


@compiled
def cross(a, b):  # type: ignore[no-untyped-def]
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


@compiled
def row(values, m):  # type: ignore[no-untyped-def]
    return values[m, 0], values[m, 1], values[m, 2]


@compiled
def state(  # type: ignore[no-untyped-def]
    m, conn, u, rest_edge, rest_wing, unit, direction, carried, committed, stands
):
    """Turn of edge m beyond where it stands free, edge and its length, unit vector along, height and foot fraction of
    the wing, unit vectors inwards and along the normal."""
    i, j, k = conn[m, 0], conn[m, 1], conn[m, 2]
    e = (
        rest_edge[m, 0] + (u[k, 0] - u[j, 0]), rest_edge[m, 1] + (u[k, 1] - u[j, 1]),
        rest_edge[m, 2] + (u[k, 2] - u[j, 2]),
    )  # fmt: skip
    w = (
        rest_wing[m, 0] + (u[i, 0] - u[j, 0]), rest_wing[m, 1] + (u[i, 1] - u[j, 1]),
        rest_wing[m, 2] + (u[i, 2] - u[j, 2]),
    )  # fmt: skip
    length = math.sqrt(dot(e, e))
    along, d = scaled(1.0 / length, e), row(direction, m)
    if carried[m]:
        rest = row(unit, m)
        share = -dot(along, d) / (1.0 + dot(along, rest))
        facing = mixed(1.0, d, share, mixed(1.0, rest, 1.0, along))
    else:
        facing = mixed(1.0, d, -dot(along, d), along)
    angle = math.atan2(dot(w, cross(along, facing)), dot(w, facing))
    angle += 2 * math.pi * np.rint((committed[m] - angle) / (2 * math.pi))
    beta = dot(w, along) / length
    off = mixed(1.0, w, -beta * length, along)
    height = math.sqrt(dot(off, off))
    inward = scaled(1.0 / height, off)
    return angle - stands[m], e, length, along, height, beta, inward, cross(along, inward)


@compiled
def spin(m, e, length, along, unit, direction, carried):  # type: ignore[no-untyped-def]
    """The spin a of the direction about edge m; and w, v and c of the symmetric part of its derivative, that of w v'
    plus c w N', N the direction."""
    d = row(direction, m)
    if carried[m]:
        rest = row(unit, m)
        ahead = dot(rest, e)
        w, size = cross(e, rest), length * (length + ahead)
        change = mixed(2.0, e, 1.0, mixed(ahead, along, length, rest))
        return scaled(1.0 / size, w), w, scaled(-1.0 / size**2, change), 0.0
    p = dot(d, e)
    across = length**2 - p**2
    w, size = cross(e, d), length * across
    change = mixed(across, along, 2 * length, mixed(1.0, e, -p, d))
    return scaled(-p / size, w), w, scaled(p / size**2, change), -1.0 / size


@compiled
def forces(  # type: ignore[no-untyped-def]
    conn, u, rest_edge, rest_wing, unit, direction, carried, committed, stands, stiffness, total
):
    squares = 0.0
    for m in range(len(conn)):
        turn, e, length, along, height, beta, _, n = state(
            m, conn, u, rest_edge, rest_wing, unit, direction, carried, committed, stands
        )
        a = spin(m, e, length, along, unit, direction, carried)[0]
        moment, g = stiffness[m] * turn, scaled(1.0 / height, n)
        squares += push(total, conn[m, 0], moment, g)
        squares += push(total, conn[m, 1], moment, mixed(beta - 1.0, g, 1.0, a))
        squares += push(total, conn[m, 2], moment, mixed(-beta, g, -1.0, a))
    return squares


@compiled
def blocks(  # type: ignore[no-untyped-def]
    conn, u, rest_edge, rest_wing, unit, direction, carried, committed, stands, stiffness, convexity, slots, target
):
    members, count, d = len(conn), len(target), (0.0, -1.0, 1.0)
    for m in range(members):
        turn, e, length, along, height, beta, t, n = state(
            m, conn, u, rest_edge, rest_wing, unit, direction, carried, committed, stands
        )
        a, w, v, share = spin(m, e, length, along, unit, direction, carried)
        k, normal = stiffness[m], row(direction, m)
        bent, c = (1.0 - convexity) * k * turn, (1.0, beta - 1.0, -beta)
        chain = (
            scaled(c[0] / height, n), mixed(c[1] / height, n, 1.0, a), mixed(c[2] / height, n, -1.0, a),
        )  # fmt: skip
        pair = 0
        for p in range(3):
            for q in range(p, 3):
                slot = slots[pair * members + m]
                pair += 1
                for x in range(3):
                    for y in range(3):
                        bend = n[x] * t[y] + t[x] * n[y]
                        twist = 0.5 * (w[x] * v[y] + v[x] * w[y] + share * (w[x] * normal[y] + normal[x] * w[y]))
                        value = k * chain[p][x] * chain[q][y] - bent * (
                            c[p] * c[q] * bend / height**2
                            + (c[p] * d[q] * along[x] * n[y] + d[p] * c[q] * n[x] * along[y]) / (height * length)
                            + d[p] * d[q] * (0.5 * bend / length**2 + twist)
                        )
                        if slot < count:
                            target[slot, x, y] += value
                        else:
                            target[slot - count, y, x] += value
