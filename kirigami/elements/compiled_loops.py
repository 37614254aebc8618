"""Loops over bars and hinges for Numba to compile; only :mod:`kirigami.elements.compiled` imports this file."""

from __future__ import annotations

import math

import numpy as np

from kirigami.primitives.compiling import compiler

compiled = compiler()


@compiled
def bar_state(m, conn, u, rest_vector, rest_strain, rest_length, vector):  # type: ignore[no-untyped-def]
    """Green strain of bar m, and its current vector."""
    i, j = conn[m, 0], conn[m, 1]
    strain = 0.0
    for axis in range(3):
        change = u[j, axis] - u[i, axis]
        vector[axis] = rest_vector[axis, m] + change
        strain += (rest_vector[axis, m] + 0.5 * change) * change
    return rest_strain[m] + strain / rest_length[m] ** 2


@compiled
def bar_forces(conn, u, rest_vector, rest_strain, EA, rest_length, total):  # type: ignore[no-untyped-def]
    vector = np.empty(3)
    squares = 0.0
    for m in range(len(conn)):
        strain = bar_state(m, conn, u, rest_vector, rest_strain, rest_length, vector)
        scale = EA[m] * strain / rest_length[m]
        for axis in range(3):
            pull = scale * vector[axis]
            squares += 2 * pull * pull
            total[conn[m, 0], axis] -= pull
            total[conn[m, 1], axis] += pull
    return squares


@compiled
def bar_stress_ahead(conn, u, rest_vector, rest_strain, EA, rest_length, change, stress):  # type: ignore[no-untyped-def]
    """Stress over EA after a linear step `change` off u."""
    vector = np.empty(3)
    for m in range(len(conn)):
        strain = bar_state(m, conn, u, rest_vector, rest_strain, rest_length, vector)
        rate = 0.0
        for axis in range(3):
            rate += vector[axis] * (change[conn[m, 1], axis] - change[conn[m, 0], axis])
        stress[m] = strain + rate / rest_length[m] ** 2


@compiled
def bar_blocks(  # type: ignore[no-untyped-def]
    conn, u, rest_vector, rest_strain, EA, rest_length, ahead, convexity, slots, blocks
):
    count, n = len(blocks), len(conn)
    vector = np.empty(3)
    for m in range(n):
        stress = bar_state(m, conn, u, rest_vector, rest_strain, rest_length, vector)
        if len(ahead):
            stress = ahead[m]
        if stress < 0.0:
            stress -= convexity * stress
        geometric = EA[m] * stress / rest_length[m]
        along = EA[m] / rest_length[m] ** 3
        slot = slots[m] if slots[m] < count else slots[m] - count  # a symmetric block: no need to turn it over
        for a in range(3):
            for b in range(3):
                blocks[slot, a, b] -= along * vector[a] * vector[b]
            blocks[slot, a, a] -= geometric


@compiled
def wing(e, square, length, w, side):  # type: ignore[no-untyped-def]
    """Foot fraction, inverse height, in-facet unit vector and normal of a wing vector w over an edge e."""
    beta = (e[0] * w[0] + e[1] * w[1] + e[2] * w[2]) / square
    t0, t1, t2 = w[0] - beta * e[0], w[1] - beta * e[1], w[2] - beta * e[2]
    inverse = 1.0 / math.sqrt(t0 * t0 + t1 * t1 + t2 * t2)
    t0, t1, t2 = t0 * inverse, t1 * inverse, t2 * inverse
    scale = side / length
    n0, n1, n2 = e[1] * t2 - e[2] * t1, e[2] * t0 - e[0] * t2, e[0] * t1 - e[1] * t0
    return beta, inverse, (t0, t1, t2), (scale * n0, scale * n1, scale * n2)


@compiled
def current(m, i, j, u, rest):  # type: ignore[no-untyped-def]
    """Current vector from node j to node i, whose rest vector is column m of `rest`."""
    return rest[0, m] + (u[i, 0] - u[j, 0]), rest[1, m] + (u[i, 1] - u[j, 1]), rest[2, m] + (u[i, 2] - u[j, 2])


@compiled
def hinge_state(m, conn, u, rest_edge, rest_i, rest_l, rest_angle, committed):  # type: ignore[no-untyped-def]
    """Excess of the angle of hinge m over its rest value, its edge and the square of that, and both its wings."""
    j = conn[m, 1]
    e = current(m, conn[m, 2], j, u, rest_edge)
    a = current(m, conn[m, 0], j, u, rest_i)
    b = current(m, conn[m, 3], j, u, rest_l)
    square = e[0] * e[0] + e[1] * e[1] + e[2] * e[2]
    length = math.sqrt(square)
    m0, m1, m2 = e[1] * a[2] - e[2] * a[1], e[2] * a[0] - e[0] * a[2], e[0] * a[1] - e[1] * a[0]
    n0, n1, n2 = b[1] * e[2] - b[2] * e[1], b[2] * e[0] - b[0] * e[2], b[0] * e[1] - b[1] * e[0]
    angle = math.atan2(length * (m0 * b[0] + m1 * b[1] + m2 * b[2]), m0 * n0 + m1 * n1 + m2 * n2)
    angle += 2 * math.pi * np.rint((committed[m] - angle) / (2 * math.pi))
    first, second = wing(e, square, length, a, 1.0), wing(e, square, length, b, -1.0)
    return angle - rest_angle[m], e, square, first, second


@compiled
def scaled(c, v):  # type: ignore[no-untyped-def]
    return c * v[0], c * v[1], c * v[2]


@compiled
def mixed(c, v, d, w):  # type: ignore[no-untyped-def]
    return c * v[0] + d * w[0], c * v[1] + d * w[1], c * v[2] + d * w[2]


@compiled
def push(total, node, scale, v):  # type: ignore[no-untyped-def]
    """Add `scale` v to a row; returns the square of its length."""
    f0, f1, f2 = scale * v[0], scale * v[1], scale * v[2]
    total[node, 0] += f0
    total[node, 1] += f1
    total[node, 2] += f2
    return f0 * f0 + f1 * f1 + f2 * f2


@compiled
def hinge_forces(  # type: ignore[no-untyped-def]
    conn, u, rest_edge, rest_i, rest_l, stiffness, rest_angle, committed, total
):
    squares = 0.0
    for m in range(len(conn)):
        excess, _, _, first, second = hinge_state(m, conn, u, rest_edge, rest_i, rest_l, rest_angle, committed)
        beta, inverse, _, n = first
        other, other_inverse, _, other_n = second
        g, h = scaled(inverse, n), scaled(other_inverse, other_n)
        moment = stiffness[m] * excess
        squares += push(total, conn[m, 0], moment, g)
        squares += push(total, conn[m, 1], moment, mixed(beta - 1.0, g, other - 1.0, h))
        squares += push(total, conn[m, 2], moment, mixed(-beta, g, -other, h))
        squares += push(total, conn[m, 3], moment, h)
    return squares


@compiled
def add_pair(blocks, slot, n, y, z):  # type: ignore[no-untyped-def]
    """Add n y' + z n' to the block of a slot, or its transpose to that of a slot counted from the end on."""
    if slot >= len(blocks):
        slot, y, z = slot - len(blocks), z, y
    for a in range(3):
        for b in range(3):
            blocks[slot, a, b] += n[a] * y[b] + z[a] * n[b]


@compiled
def hinge_blocks(  # type: ignore[no-untyped-def]
    conn, u, rest_edge, rest_i, rest_l, stiffness, rest_angle, committed, convexity, slots, blocks
):
    """Each block is made of terms n y' + z n'; see BendHingeKernel.second_derivatives."""
    members, none = len(conn), (0.0, 0.0, 0.0)
    for m in range(members):
        excess, e, square, first, second = hinge_state(
            m, conn, u, rest_edge, rest_i, rest_l, rest_angle, committed
        )
        k = stiffness[m]
        moment = (1.0 - convexity) * k * excess
        beta, inverse, _, n = first
        other, other_inverse, _, other_n = second
        g, h = scaled(inverse, n), scaled(other_inverse, other_n)
        gj, gk = mixed(beta - 1.0, g, other - 1.0, h), mixed(-beta, g, -other, h)
        add_pair(blocks, slots[2 * members + m], scaled(k, g), h, none)
        middle = slots[3 * members + m]
        add_pair(blocks, middle, scaled(k, gj), gk, none)
        for last in range(2):
            beta, inverse, t, n = second if last else first
            share, over, skew = k * inverse, scaled(moment * inverse**2, t), scaled(moment * inverse / square, e)
            y, z = mixed(1.0 - beta, over, share, gj), mixed(1.0 - beta, over, 1.0, skew)
            if last:
                y, z = z, y
            add_pair(blocks, slots[4 * last * members + m], n, y, z)
            y, z = mixed(beta, over, share, gk), mixed(beta, over, -1.0, skew)
            if last:
                y, z = z, y
            add_pair(blocks, slots[(4 * last + 1) * members + m], n, y, z)
            common = beta * (beta - 1.0) + 0.5 / (square * inverse**2)
            add_pair(blocks, middle, n, mixed(common, over, -beta, skew), mixed(common, over, 1.0 - beta, skew))
