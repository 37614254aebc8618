"""Loops over layers that yield, for Numba to compile; only :mod:`kirigami.elements.compiled_yield` imports this file.

The formulas are those of :mod:`kirigami.elements.plane_stress` and :mod:`kirigami.elements.layers`.
"""

from __future__ import annotations

import math

from kirigami.elements.shell_loops import compiled


@compiled
def piece_at(strain, a):  # type: ignore[no-untyped-def]
    """Number of the piece of a curve at an accumulated plastic strain, and how far it is into it."""
    k = 0
    while k + 1 < len(strain) and a >= strain[k + 1]:
        k += 1
    return k, a - strain[k]


@compiled
def multiplier(  # type: ignore[no-untyped-def]
    both, apart, slow, fast, size, limit, before, start, strain, stress, slope, back, rise
):
    """The root g of 1 / q(g) = 1 / (sigma_y + H - H_0)(a(g)): Newton's method, with bisection where it leaves the
    bracket."""
    low, high, g = 0.0, (size / limit - 1.0) / min(slow, fast), 0.0
    whole = high
    for _ in range(100):
        u, v = 1.0 + slow * g, 1.0 + fast * g
        square = both / (u * u) + apart / (v * v)
        fall = both * slow / (u * u * u) + apart * fast / (v * v * v)
        root = math.sqrt(square)
        k, way = piece_at(strain, before + math.sqrt(2.0 / 3.0) * g * root)
        steep = slope[k] + rise[k]
        now = stress[k] + back[k] - start + steep * way
        value = 1.0 / (math.sqrt(1.5) * root) - 1.0 / now
        growth = math.sqrt(2.0 / 3.0) * (root - g * fall / root)
        change = fall / (math.sqrt(1.5) * root * square) + steep * growth / (now * now)
        if value <= 0.0:
            low = g
        else:
            high = g
        step = g - value / change
        if not low <= step <= high:
            step = 0.5 * (low + high)
        moved = abs(step - g)
        g = step
        if moved <= 4e-16 * whole:
            break
    return g


@compiled
def passed(inside, thickness, equal, shear, first, reach, found):  # type: ignore[no-untyped-def]
    """Whether facets that have not yielded yet do so at one of their outermost layers."""
    for f in range(len(inside)):
        most = 0.0
        for sign in (1.0, -1.0):
            z = sign * 0.5 * thickness[f] * reach
            for q in range(3):
                xx = inside[f, q, 0] - z * inside[f, q, 3]
                yy = inside[f, q, 1] - z * inside[f, q, 4]
                xy = inside[f, q, 2] - z * inside[f, q, 5]
                size = equal[f] * (xx + yy) ** 2 + shear[f] * ((xx - yy) ** 2 + xy * xy)
                most = max(most, size)
        found[f] = most > (first[f] * (1.0 + 1e-12)) ** 2


@compiled
def respond(  # type: ignore[no-untyped-def]
    inside, state, thickness, E, nu, strain, stress, slope, work, back, rise, store, places, weights, tangent,
    energy, borne, section, new,
):  # fmt: skip
    """Fill energy per area (n, 3), forces and moments (n, 3, 6), the tangent sections (n, 3, 6, 6) where `tangent`, and
    the state (n, 3, layers, 8)."""
    for f in range(len(inside)):
        G, S = E[f] / (2.0 * (1.0 + nu[f])), E[f] / (1.0 - nu[f])
        for q in range(3):
            for layer in range(len(places)):
                z = 0.5 * thickness[f] * places[layer]
                share = 0.5 * thickness[f] * weights[layer]
                p0, p1, p2 = state[f, q, layer, 0], state[f, q, layer, 1], state[f, q, layer, 2]
                a, behind = state[f, q, layer, 3], state[f, q, layer, 7]
                b0, b1, b2 = state[f, q, layer, 4], state[f, q, layer, 5], state[f, q, layer, 6]
                e0 = inside[f, q, 0] - z * inside[f, q, 3]
                e1 = inside[f, q, 1] - z * inside[f, q, 4]
                e2 = inside[f, q, 2] - z * inside[f, q, 5]
                mean, half = 0.5 * S * (e0 - p0 + e1 - p1), G * (e0 - p0 - e1 + p1)
                s0, s1, s2 = mean + half, mean - half, G * (e2 - p2)
                n0, n1, n2 = s0 - b0, s1 - b1, s2 - b2
                both, apart = (n0 + n1) ** 2 / 6.0, 0.5 * (n0 - n1) ** 2 + 2.0 * n2 * n2
                size = math.sqrt(1.5 * (both + apart))
                k, way = piece_at(strain[f], a)
                limit = stress[f, k] + slope[f, k] * way
                X, Y, fade = S, 2.0 * G, 0.0  # of the matrix with these eigenvalues, and how much of m m' is taken away
                m0 = m1 = m2 = 0.0
                if size > limit * (1.0 + 1e-12):
                    start = back[f, k] + rise[f, k] * way
                    stored = store[f, k] + way * (back[f, k] + 0.5 * rise[f, k] * way)
                    g = multiplier(
                        both, apart, S / 3.0, 2.0 * G, size, limit, a, start,
                        strain[f], stress[f], slope[f], back[f], rise[f],
                    )  # fmt: skip
                    u, v = 1.0 / (1.0 + S / 3.0 * g), 1.0 / (1.0 + 2.0 * G * g)
                    mean, half = 0.5 * u * (n0 + n1), 0.5 * v * (n0 - n1)
                    n0, n1, n2 = mean + half, mean - half, v * n2
                    d0, d1, d2 = (2.0 * n0 - n1) / 3.0, (2.0 * n1 - n0) / 3.0, 2.0 * n2
                    square = d0 * n0 + d1 * n1 + d2 * n2
                    flown = g * math.sqrt(2.0 / 3.0 * square)
                    p0, p1, p2, a = p0 + g * d0, p1 + g * d1, p2 + g * d2, a + flown
                    mean, half = 0.5 * S * (e0 - p0 + e1 - p1), G * (e0 - p0 - e1 + p1)
                    s0, s1, s2 = mean + half, mean - half, G * (e2 - p2)
                    k, way = piece_at(strain[f], a)
                    behind += g * (b0 * d0 + b1 * d1 + b2 * d2) - start * flown - stored
                    behind += store[f, k] + way * (back[f, k] + 0.5 * rise[f, k] * way)
                    moved = (back[f, k] + rise[f, k] * way - start) / math.sqrt(1.5 * square)
                    b0, b1, b2 = b0 + moved * n0, b1 + moved * n1, b2 + moved * n2
                    if tangent:
                        steep = slope[f, k] + rise[f, k]
                        t = 1.0 - 2.0 / 3.0 * steep * g
                        X, Y = 1.0 / (1.0 / S + g / 3.0), 1.0 / (1.0 / (2.0 * G) + g)
                        m0, m1 = 0.5 * (X + Y) * d0 + 0.5 * (X - Y) * d1, 0.5 * (X - Y) * d0 + 0.5 * (X + Y) * d1
                        m2 = 0.5 * Y * d2
                        fade = t / (2.0 / 3.0 * steep * square + t * (m0 * d0 + m1 * d1 + m2 * d2))
                new[f, q, layer, 0], new[f, q, layer, 1], new[f, q, layer, 2] = p0, p1, p2
                new[f, q, layer, 3], new[f, q, layer, 7] = a, behind
                new[f, q, layer, 4], new[f, q, layer, 5], new[f, q, layer, 6] = b0, b1, b2
                held = 0.5 * (s0 * (e0 - p0) + s1 * (e1 - p1) + s2 * (e2 - p2)) + behind
                energy[f, q] += share * (held + work[f, k] + way * (stress[f, k] + 0.5 * slope[f, k] * way))
                borne[f, q, 0] += share * s0
                borne[f, q, 1] += share * s1
                borne[f, q, 2] += share * s2
                borne[f, q, 3] -= share * z * s0
                borne[f, q, 4] -= share * z * s1
                borne[f, q, 5] -= share * z * s2
                if tangent:
                    D00, D11 = 0.5 * (X + Y) - fade * m0 * m0, 0.5 * (X + Y) - fade * m1 * m1
                    D01, D22 = 0.5 * (X - Y) - fade * m0 * m1, 0.5 * Y - fade * m2 * m2
                    D02, D12 = -fade * m0 * m2, -fade * m1 * m2
                    first = share
                    for i, j, value in ((0, 0, D00), (1, 1, D11), (2, 2, D22), (0, 1, D01), (0, 2, D02), (1, 2, D12)):
                        section[f, q, i, j] += first * value
                        section[f, q, i, 3 + j] -= first * z * value
                        section[f, q, 3 + i, 3 + j] += first * z * z * value
                        if i != j:
                            section[f, q, j, 3 + i] -= first * z * value
            if tangent:
                for i in range(6):
                    for j in range(i):
                        section[f, q, i, j] = section[f, q, j, i]
