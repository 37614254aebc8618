"""The tangent of shell facets for Numba to compile; only :mod:`kirigami.elements.compiled_shell` imports this file.

Same formulas as :mod:`kirigami.elements.shell_membrane` and :mod:`kirigami.elements.shell_bending`, for LANES facets
at once, which stand on the last axis of every array, so that the processor's vector units work on them together. The
stiffness of the sheet comes as its square root: weighted measures y = stretch r + couple b and z = bend b, whose
squares add up to twice the energy; so the tangent is a sum of squares of their derivatives, and only its lower half is
made.
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
from kirigami.elements.shell_loops import compiled


@compiled
def blocks(  # type: ignore[no-untyped-def]
    conn, x, u, all_rest, all_per_square, all_forms, all_stretch, all_couple, all_bend, all_second, rest_angle,
    rest_curvature, directors, edge, stored, all_scale, tangents, released, own, first, last, ahead, convexity, slots,
    target,
):  # fmt: skip
    """Add the Hessian of all facets but those that answer by a law of their own: not -1 in `own` (n,), or none."""
    n = len(conn)
    exact, coupled = 1.0 - convexity, len(all_couple) > 0
    du, v = np.empty((5, 3, LANES)), np.empty((5, 3, LANES))
    normals, inward, tangent = np.empty((9, 3, LANES)), np.empty((6, 3, LANES)), np.empty((6, 3, LANES))
    area_normal, normal = normals[:3], normals[3:]
    sizes, dual = np.empty((3, 6, LANES)), np.empty((2, 3, 3, LANES))
    seen, faced, turned = np.empty((6, 3, LANES)), np.empty((3, 6, LANES)), np.empty((6, LANES))
    near, far = np.empty((3, LANES)), np.empty((3, LANES))
    r, b, y, z = np.empty((9, LANES)), np.empty((15, LANES)), np.empty((9, LANES)), np.empty((9, LANES))
    pull, moment = np.empty((9, LANES)), np.empty((15, LANES))
    shares, levers, slides = np.empty((9, 5, LANES)), np.empty((6, 5, LANES)), np.empty((6, 3, LANES))
    stretch_slope, bend_slope = np.zeros((9, 15, LANES)), np.empty((15, 15, LANES))
    rows, local = np.zeros((9, 21, LANES)), np.empty((21, 21, LANES))
    arms, weights, loads = np.empty((9, 5, 3, LANES)), np.empty((9, 5, LANES)), np.empty((3, LANES))
    heights, forms_along, block = np.empty((3, 5, 5, LANES)), np.empty((6, 3, 3, LANES)), np.empty((3, 3, LANES))
    for batch in range(first, last):
        f = batch * LANES
        rest, per_square, forms, stretch = all_rest[batch], all_per_square[batch], all_forms[batch], all_stretch[batch]
        bend, second, scale = all_bend[batch], all_second[batch], all_scale[batch]
        couple = all_couple[batch] if coupled else bend
        gather(f, n, conn, u, rest, du, v)
        for lane in range(LANES):
            at = min(f + lane, n - 1)
            for g in range(6):
                turned[g, lane] = x[conn[at, 6 + g // 2], stored[g, at]]
                for axis in range(3):
                    seen[g, axis, lane] = directors[edge[g, at], stored[g, at], axis]
        edge_frames(v, normal, inward, tangent, sizes, near, far)
        area_frames(v, area_normal, dual, near, far)
        stretched(du, rest, per_square, forms, r, near, far)
        facing(normal, inward, tangent, seen, faced)
        bent(v, area_normal, faced, turned, second, rest_angle[batch], rest_curvature[batch], scale, b)
        y[:], z[:], pull[:], moment[:] = 0.0, 0.0, 0.0, 0.0
        if len(released):  # what the facets bear nothing at, weighted as the measures are
            for m in range(9):
                for lane in range(LANES):
                    y[m, lane], z[m, lane] = -released[batch, m, lane], -released[batch, 9 + m, lane]
        weigh(stretch, r, y)
        weigh(bend, b, z)
        if coupled:
            weigh(couple, b, y)
            weigh_back(couple, y, moment)
        weigh_back(stretch, y, pull)
        weigh_back(bend, z, moment)
        # derivatives of the weighted measures, and their squares
        local[:] = 0.0
        bend_shares(v, dual, second, shares)
        angle_rows(normal, inward, sizes, faced, levers, slides)
        stretch_slopes(v, per_square, forms, stretch_slope)
        bend_slopes(area_normal, normal, shares, levers, slides, bend_slope)
        stretch_rows(stretch, stretch_slope, rows)
        if coupled:
            rows[:, 15:] = 0.0
            bend_rows(couple, bend_slope, scale, 1.0, rows)
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
