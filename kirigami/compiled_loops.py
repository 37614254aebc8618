"""Loops over bars and hinges for Numba to compile; only :mod:`kirigami.compiled` imports this file."""

from __future__ import annotations

import math

import numpy as np

try:
    from numba import njit

    compiled = njit(cache=True, error_model="numpy")
except ImportError:  # plain Python then, which nobody calls: too slow

    def compiled(function):  # type: ignore[no-untyped-def]
        return function


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
def hinge_state(  # type: ignore[no-untyped-def]
    m, conn, u, rest_edge, rest_i, rest_l, rest_angle, committed, edge, wings, beta, height, t, n, grad
):
    """Excess of the angle of hinge m over its rest value; fills the geometry of its wings and the gradient."""
    j, k = conn[m, 1], conn[m, 2]
    for axis in range(3):
        edge[axis] = rest_edge[axis, m] + (u[k, axis] - u[j, axis])
        wings[0, axis] = rest_i[axis, m] + (u[conn[m, 0], axis] - u[j, axis])
        wings[1, axis] = rest_l[axis, m] + (u[conn[m, 3], axis] - u[j, axis])
    e0, e1, e2 = edge[0], edge[1], edge[2]
    a0, a1, a2 = wings[0, 0], wings[0, 1], wings[0, 2]
    b0, b1, b2 = wings[1, 0], wings[1, 1], wings[1, 2]
    square = e0 * e0 + e1 * e1 + e2 * e2
    length = math.sqrt(square)
    m0, m1, m2 = e1 * a2 - e2 * a1, e2 * a0 - e0 * a2, e0 * a1 - e1 * a0
    n0, n1, n2 = b1 * e2 - b2 * e1, b2 * e0 - b0 * e2, b0 * e1 - b1 * e0
    angle = math.atan2(length * (m0 * b0 + m1 * b1 + m2 * b2), m0 * n0 + m1 * n1 + m2 * n2)
    angle += 2 * math.pi * np.rint((committed[m] - angle) / (2 * math.pi))
    grad[:] = 0.0
    for w in range(2):
        beta[w] = (e0 * wings[w, 0] + e1 * wings[w, 1] + e2 * wings[w, 2]) / square
        for axis in range(3):
            t[w, axis] = wings[w, axis] - beta[w] * edge[axis]
        height[w] = math.sqrt(t[w, 0] ** 2 + t[w, 1] ** 2 + t[w, 2] ** 2)
        for axis in range(3):
            t[w, axis] /= height[w]
        side = (1.0 - 2.0 * w) / length
        n[w, 0] = side * (e1 * t[w, 2] - e2 * t[w, 1])
        n[w, 1] = side * (e2 * t[w, 0] - e0 * t[w, 2])
        n[w, 2] = side * (e0 * t[w, 1] - e1 * t[w, 0])
        for axis in range(3):
            g = n[w, axis] / height[w]
            grad[3 * w, axis] = g
            grad[1, axis] += (beta[w] - 1.0) * g
            grad[2, axis] -= beta[w] * g
    return angle - rest_angle[m]


@compiled
def hinge_forces(  # type: ignore[no-untyped-def]
    conn, u, rest_edge, rest_i, rest_l, stiffness, rest_angle, committed, total
):
    edge, wings, beta, height = np.empty(3), np.empty((2, 3)), np.empty(2), np.empty(2)
    t, n, grad = np.empty((2, 3)), np.empty((2, 3)), np.empty((4, 3))
    squares = 0.0
    for m in range(len(conn)):
        excess = hinge_state(
            m, conn, u, rest_edge, rest_i, rest_l, rest_angle, committed, edge, wings, beta, height, t, n, grad
        )
        moment = stiffness[m] * excess
        for p in range(4):
            for axis in range(3):
                force = moment * grad[p, axis]
                squares += force * force
                total[conn[m, p], axis] += force
    return squares


@compiled
def hinge_blocks(  # type: ignore[no-untyped-def]
    conn, u, rest_edge, rest_i, rest_l, stiffness, rest_angle, committed, convexity, slots, blocks
):
    edge, wings, beta, height = np.empty(3), np.empty((2, 3)), np.empty(2), np.empty(2)
    t, n, grad, h = np.empty((2, 3)), np.empty((2, 3)), np.empty((4, 3)), np.empty((6, 3, 3))
    count, members = len(blocks), len(conn)
    for m in range(members):
        excess = hinge_state(
            m, conn, u, rest_edge, rest_i, rest_l, rest_angle, committed, edge, wings, beta, height, t, n, grad
        )
        moment = (1.0 - convexity) * stiffness[m] * excess
        inverse_square = 1.0 / (edge[0] ** 2 + edge[1] ** 2 + edge[2] ** 2)
        for a in range(3):
            for b in range(3):
                h[2, a, b] = stiffness[m] * grad[0, a] * grad[3, b]
                h[3, a, b] = stiffness[m] * grad[1, a] * grad[2, b]
        for w in range(2):
            share, by_square = stiffness[m] / height[w], moment / height[w] ** 2
            by_length = moment * inverse_square / height[w]
            common = beta[w] * (beta[w] - 1.0) + 0.5 * height[w] ** 2 * inverse_square
            for a in range(3):
                for b in range(3):
                    # Each block is n y' + z n'; see BendHingeKernel.second_derivatives. First (a, b), then (b, a).
                    over, over_b = by_square * t[w, a], by_square * t[w, b]
                    skew, skew_b = by_length * edge[a], by_length * edge[b]
                    na, nb = n[w, a], n[w, b]
                    h[3, a, b] += na * (common * over_b - beta[w] * skew_b)
                    h[3, a, b] += (common * over - (beta[w] - 1.0) * skew) * nb
                    if w == 0:
                        h[0, a, b] = na * ((1.0 - beta[w]) * over_b + share * grad[1, b])
                        h[0, a, b] += ((1.0 - beta[w]) * over + skew) * nb
                        h[1, a, b] = na * (beta[w] * over_b + share * grad[2, b])
                        h[1, a, b] += (beta[w] * over - skew) * nb
                    else:
                        h[4, a, b] = ((1.0 - beta[w]) * over + share * grad[1, a]) * nb
                        h[4, a, b] += na * ((1.0 - beta[w]) * over_b + skew_b)
                        h[5, a, b] = (beta[w] * over + share * grad[2, a]) * nb
                        h[5, a, b] += na * (beta[w] * over_b - skew_b)
        for pair in range(6):
            slot = slots[pair * members + m]
            if slot < count:
                for a in range(3):
                    for b in range(3):
                        blocks[slot, a, b] += h[pair, a, b]
            else:
                for a in range(3):
                    for b in range(3):
                        blocks[slot - count, b, a] += h[pair, a, b]


@compiled
def largest_turn(change, low, high, distance):  # type: ignore[no-untyped-def]
    """Largest relative displacement of joined nodes over their distance; not finite where one is not."""
    largest = 0.0
    for k in range(len(low)):
        square = 0.0
        for axis in range(change.shape[1]):
            apart = change[high[k], axis] - change[low[k], axis]
            square += apart * apart
        turn = square / (distance[k] * distance[k])
        if not turn <= largest:
            largest = turn
            if not math.isfinite(turn):
                break
    return math.sqrt(largest)
