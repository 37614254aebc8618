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
    bent,
    edge_frames,
    facing,
    gather,
    stretch_rows,
    stretched,
    weigh,
    weigh_back,
)
from kirigami.elements.shell_lane_second import add_squares, edges_second, inside_second, mean_second
from kirigami.elements.shell_loops import compiled, scatter


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
    normal, inward, tangent = np.empty((6, 3, LANES)), np.empty((6, 3, LANES)), np.empty((6, 3, LANES))
    sizes, area_normal, dual = np.empty((3, 6, LANES)), np.empty((3, 3, LANES)), np.empty((2, 3, 3, LANES))
    seen, faced, turned = np.empty((6, 3, LANES)), np.empty((3, 6, LANES)), np.empty((6, LANES))
    near, far = np.empty((3, LANES)), np.empty((3, LANES))
    r, b, y, z = np.empty((9, LANES)), np.empty((15, LANES)), np.empty((9, LANES)), np.empty((9, LANES))
    pull, moment = np.empty((9, LANES)), np.empty((15, LANES))
    shares, levers, slides = np.empty((9, 5, LANES)), np.empty((6, 5, LANES)), np.empty((6, 3, LANES))
    rows, local = np.empty((9, 21, LANES)), np.empty((21, 21, LANES))
    work = (
        np.empty((3, 3, LANES)), np.empty((3, 3, LANES)), np.empty((3, 3, LANES)), np.empty((3, 3, LANES)),
        np.empty((3, 3, LANES)), np.empty((3, LANES)), np.empty((3, LANES)),
    )  # fmt: skip
    full, place = np.zeros((27, 27)), np.empty(21, np.int64)
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
        stretch_rows(v, per_square, forms, stretch, rows, near)
        if coupled:
            rows[:, 15:] = 0.0
            bend_rows(area_normal, normal, shares, levers, slides, couple, scale, rows, near)
        add_squares(rows, 21 if coupled else 15, local)
        rows[:] = 0.0
        bend_rows(area_normal, normal, shares, levers, slides, bend, scale, rows, near)
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
            inside_second(v, area_normal, dual, moment, second, local, work)
            edges_second((normal, inward, tangent, sizes), faced, moment, pull, per_square, local, work)
        for lane in range(min(LANES, n - f)):
            if not len(own) or own[f + lane] < 0:
                scatter(local[:, :, lane], stored[:, f + lane], f + lane, n, slots, full, place, target)
