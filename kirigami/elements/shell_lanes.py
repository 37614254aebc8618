"""Energy, forces and tangent of shell facets for Numba to compile; only :mod:`kirigami.elements.compiled_shell` imports
this file.

Same formulas as :mod:`kirigami.elements.shell_membrane` and :mod:`kirigami.elements.shell_bending`, for LANES facets
at once, which stand on the last axis of every array, so that the processor's vector units work on them together. The
stiffness of the sheet comes as its square root: weighted measures y = stretch r + couple b and z = bend b, whose
squares add up to twice the energy; so the tangent is a sum of squares of their derivatives, and only its lower half is
made. Facets that answer by a law of their own are those that are not -1 in `own` (n,), or none where that is empty.
"""

from __future__ import annotations

import numpy as np

from kirigami.elements.shell_lane_rows import (
    LANES,
    angle_rows,
    area_frames,
    bend_rows,
    bend_shares,
    bend_slopes,
    bent,
    edge_frames,
    facing,
    gather,
    stretch_rows,
    stretch_slopes,
    stretched,
    weigh,
    weigh_back,
)
from kirigami.elements.shell_lane_scatter import scatter
from kirigami.elements.shell_lane_second import add_points, add_squares, edge_parts, inside_parts, mean_second
from kirigami.elements.shell_loops import compiled, pulled_back


@compiled
def scratch():  # type: ignore[no-untyped-def]
    """Room for a batch: vectors, frames, and what measures are made of."""
    normals = np.empty((9, 3, LANES))
    moved = np.empty((5, 3, LANES)), np.empty((5, 3, LANES))
    frames = (
        normals, normals[:3], normals[3:], np.empty((6, 3, LANES)), np.empty((6, 3, LANES)), np.empty((3, 6, LANES)),
        np.empty((2, 3, 3, LANES)),
    )  # fmt: skip
    seen = np.empty((6, 3, LANES)), np.empty((3, 6, LANES)), np.empty((6, LANES))
    numbers = np.empty((9, LANES)), np.empty((15, LANES)), np.empty((9, LANES)), np.empty((9, LANES))
    return moved, frames, seen, numbers, (np.empty((3, LANES)), np.empty((3, LANES)))


@compiled
def measure(batch, conn, x, u, described, directors, edge, stored, released, room):  # type: ignore[no-untyped-def]
    """Frames and weighted measures of a batch of facets, into the `room` for them."""
    all_rest, all_per_square, all_forms, all_stretch, all_couple, all_bend, curved, angle, curvature, scale = described
    (du, v), (_, area_normal, normal, inward, tangent, sizes, dual), (seen, faced, turned), (r, b, y, z), pair = room
    near, far = pair
    f, n = batch * LANES, len(conn)
    gather(f, n, conn, u, all_rest[batch], du, v)
    for lane in range(LANES):
        at = min(f + lane, n - 1)
        for g in range(6):
            turned[g, lane] = x[conn[at, 6 + g // 2], stored[g, at]]
            for axis in range(3):
                seen[g, axis, lane] = directors[edge[g, at], stored[g, at], axis]
    edge_frames(v, normal, inward, tangent, sizes, near, far)
    area_frames(v, area_normal, dual, near, far)
    stretched(du, all_rest[batch], all_per_square[batch], all_forms[batch], r, near, far)
    facing(normal, inward, tangent, seen, faced)
    bent(v, area_normal, faced, turned, curved[batch], angle[batch], curvature[batch], scale[batch], b)
    y[:], z[:] = 0.0, 0.0
    if len(released):  # what the facets bear nothing at, weighted as the measures are
        for m in range(9):
            for lane in range(LANES):
                y[m, lane], z[m, lane] = -released[batch, m, lane], -released[batch, 9 + m, lane]
    weigh(all_stretch[batch], r, y)
    weigh(all_bend[batch], b, z)
    if len(all_couple):
        weigh(all_couple[batch], b, y)


@compiled
def resist(batch, described, y, z, pull, moment):  # type: ignore[no-untyped-def]
    """Derivatives of the energy by the membrane (9, LANES) and bending (15, LANES) measures."""
    _, _, _, all_stretch, all_couple, all_bend, _, _, _, _ = described
    pull[:], moment[:] = 0.0, 0.0
    weigh_back(all_stretch[batch], y, pull)
    weigh_back(all_bend[batch], z, moment)
    if len(all_couple):
        weigh_back(all_couple[batch], y, moment)


@compiled
def energy(conn, x, u, described, directors, edge, stored, released, first, last):  # type: ignore[no-untyped-def]
    """Energy of all facets."""
    room, total = scratch(), 0.0
    y, z = room[3][2], room[3][3]
    for batch in range(first, last):
        measure(batch, conn, x, u, described, directors, edge, stored, released, room)
        for lane in range(min(LANES, len(conn) - batch * LANES)):
            for m in range(9):
                total += y[m, lane] * y[m, lane] + z[m, lane] * z[m, lane]
    return 0.5 * total


@compiled
def forces(  # type: ignore[no-untyped-def]
    conn, x, u, described, directors, edge, stored, released, own, answers, to_strain, to_curvature, first, last, total,
):  # fmt: skip
    """Add the gradient; the sum of its squares. Facets of a law of their own have derivatives by the fields `answers`
    (k, 18)."""
    n, room = len(conn), scratch()
    _, all_per_square, all_forms, _, _, _, all_second, _, _, all_scale = described
    (_, v), (_, area_normal, normal, inward, _, sizes, dual), (_, faced, _), (_, _, y, z), _ = room
    pull, moment = np.empty((9, LANES)), np.empty((15, LANES))
    shares, levers, slides = np.empty((9, 5, LANES)), np.empty((6, 5, LANES)), np.empty((6, 3, LANES))
    stretch_slope, bend_slope = np.zeros((9, 15, LANES)), np.empty((15, 15, LANES))
    local = np.empty((21, LANES))
    squares = 0.0
    for batch in range(first, last):
        f = batch * LANES
        measure(batch, conn, x, u, described, directors, edge, stored, released, room)
        resist(batch, described, y, z, pull, moment)
        if len(own):
            for lane in range(min(LANES, n - f)):
                if own[f + lane] >= 0:
                    pulled_back(
                        f + lane, answers[own[f + lane]], to_strain, to_curvature, pull[:, lane], moment[:, lane]
                    )
        bend_shares(v, dual, all_second[batch], shares)
        angle_rows(normal, inward, sizes, faced, levers, slides)
        stretch_slopes(v, all_per_square[batch], all_forms[batch], stretch_slope)
        bend_slopes(area_normal, normal, shares, levers, slides, bend_slope)
        for k in range(15):
            for lane in range(LANES):
                value = 0.0
                for m in range(9):
                    value += stretch_slope[m, k, lane] * pull[m, lane]
                for m in range(15):
                    value += bend_slope[m, k, lane] * moment[m, lane]
                local[k, lane] = value
        for g in range(6):
            for lane in range(LANES):
                local[15 + g, lane] = -all_scale[batch, g, lane] * moment[9 + g, lane]
        for lane in range(min(LANES, n - f)):
            at = f + lane
            for p in range(5):
                for axis in range(3):
                    value = local[3 * p + axis, lane]
                    total[conn[at, 1 + p], axis] += value
                    squares += value * value
            for axis in range(3):
                value = -local[axis, lane] - local[3 + axis, lane]
                total[conn[at, 0], axis] += value
                squares += value * value
            for g in range(6):
                value = local[15 + g, lane]
                total[conn[at, 6 + g // 2], stored[g, at]] += value
                squares += value * value
    return squares


@compiled
def blocks(  # type: ignore[no-untyped-def]
    conn, x, u, described, directors, edge, stored, tangents, released, own, first, last, ahead, convexity, slots,
    target,
):  # fmt: skip
    """Add the Hessian of all facets but those of a law of their own."""
    n, exact, room = len(conn), 1.0 - convexity, scratch()
    _, all_per_square, all_forms, all_stretch, all_couple, all_bend, all_second, _, _, all_scale = described
    coupled = len(all_couple) > 0
    (_, v), (normals, area_normal, normal, inward, tangent, sizes, dual), (_, faced, _), (_, _, y, z), _ = room
    pull, moment = np.empty((9, LANES)), np.empty((15, LANES))
    shares, levers, slides = np.empty((9, 5, LANES)), np.empty((6, 5, LANES)), np.empty((6, 3, LANES))
    stretch_slope, bend_slope = np.zeros((9, 15, LANES)), np.empty((15, 15, LANES))
    rows, local = np.zeros((9, 21, LANES)), np.empty((21, 21, LANES))
    arms, weights, loads = np.empty((9, 5, 3, LANES)), np.empty((9, 5, LANES)), np.empty((3, LANES))
    heights, forms_along, block = np.empty((3, 5, 5, LANES)), np.empty((6, 3, 3, LANES)), np.empty((3, 3, LANES))
    for batch in range(first, last):
        f = batch * LANES
        per_square, forms, stretch, bend = all_per_square[batch], all_forms[batch], all_stretch[batch], all_bend[batch]
        second, scale = all_second[batch], all_scale[batch]
        measure(batch, conn, x, u, described, directors, edge, stored, released, room)
        resist(batch, described, y, z, pull, moment)
        # derivatives of the weighted measures, and their squares
        local[:] = 0.0
        bend_shares(v, dual, second, shares)
        angle_rows(normal, inward, sizes, faced, levers, slides)
        stretch_slopes(v, per_square, forms, stretch_slope)
        bend_slopes(area_normal, normal, shares, levers, slides, bend_slope)
        stretch_rows(stretch, stretch_slope, rows)
        if coupled:
            rows[:, 15:] = 0.0
            bend_rows(all_couple[batch], bend_slope, scale, 1.0, rows)
        add_squares(rows, 21 if coupled else 15, local)
        bend_rows(bend, bend_slope, scale, 0.0, rows)
        add_squares(rows, 21, local)
        # second derivatives of the measures
        if len(ahead):
            for lane in range(LANES):
                at = min(f + lane, n - 1)
                for m in range(9):
                    pull[m, lane] = ahead[at, m]
        mean_second(pull, forms, tangents[batch], exact, convexity, local)
        if exact > 0.0:
            for m in range(9):
                for lane in range(LANES):
                    pull[m, lane] *= exact
            for m in range(15):
                for lane in range(LANES):
                    moment[m, lane] *= exact
            inside_parts(v, area_normal, dual, moment, second, arms, weights, loads, heights)
            frames = normal, inward, tangent, sizes
            edge_parts(frames, faced, moment, pull, per_square, arms, weights, loads, forms_along)
            add_points(normals, arms, weights, heights, forms_along, local)
        scatter(local, stored, f, n, own, slots, block, target)
