"""From second derivatives by the vectors and angles of LANES facets to node blocks; see
:mod:`kirigami.elements.shell_lanes`.

Rows of a facet are its three corners, then the middles and then the angles of its edges. The vectors count from the
first corner, so that its derivatives are those of the two others with the sign turned.
"""

from __future__ import annotations

from kirigami.elements.shell_lane_rows import LANES
from kirigami.elements.shell_loops import compiled


@compiled
def deposit(block, pair, f, n, own, slots, target):  # type: ignore[no-untyped-def]
    """Add blocks (3, 3, LANES) of a pair of rows; those that come with the higher row first are turned over."""
    count = len(target)
    for lane in range(min(LANES, n - f)):
        if len(own) and own[f + lane] >= 0:
            continue
        slot = slots[pair * n + f + lane]
        if slot < count:
            for i in range(3):
                for j in range(3):
                    target[slot, i, j] += block[i, j, lane]
        else:
            for i in range(3):
                for j in range(3):
                    target[slot - count, i, j] += block[j, i, lane]


@compiled
def deposit_angles(block, width, one, other, pair, f, n, own, stored, slots, target):  # type: ignore[no-untyped-def]
    """The same of blocks with the two angles of edge `other`, beside `width` entries: three of a place, or the two
    angles of edge `one`. Angles go where they are `stored` (6, n) in their row."""
    count = len(target)
    for lane in range(min(LANES, n - f)):
        if len(own) and own[f + lane] >= 0:
            continue
        slot = slots[pair * n + f + lane]
        for j in range(2):
            column = stored[2 * other + j, f + lane]
            for i in range(width):
                row = i if width == 3 else stored[2 * one + i, f + lane]
                if slot < count:
                    target[slot, row, column] += block[i, j, lane]
                else:
                    target[slot - count, column, row] += block[i, j, lane]


@compiled
def scatter(local, stored, f, n, own, slots, block, target):  # type: ignore[no-untyped-def]
    """Add the tangents of facets from f on, the lower half of `local` (21, 21, LANES), to the blocks of the system's
    rows, but for facets that answer by a law of their own: not -1 in `own` (n,), or none."""
    for corner in range(3):  # the first corner with itself, and with the others
        for i in range(3):
            for j in range(3):
                high, low = max(i, j), min(i, j)
                for lane in range(LANES):
                    first = local[high, low, lane] + local[3 + i, j, lane]
                    second = local[3 + j, i, lane] + local[3 + high, 3 + low, lane]
                    block[i, j, lane] = first + second if corner == 0 else -first if corner == 1 else -second
        deposit(block, corner, f, n, own, slots, target)
    for e in range(3):
        for i in range(3):
            for j in range(3):
                for lane in range(LANES):
                    block[i, j, lane] = -local[6 + 3 * e + j, i, lane] - local[6 + 3 * e + j, 3 + i, lane]
        deposit(block, 3 + e, f, n, own, slots, target)
    for e in range(3):
        for i in range(3):
            for j in range(2):
                for lane in range(LANES):
                    block[i, j, lane] = -local[15 + 2 * e + j, i, lane] - local[15 + 2 * e + j, 3 + i, lane]
        deposit_angles(block, 3, 0, e, 6 + e, f, n, own, stored, slots, target)
    pair = 9
    for p in range(5):
        for q in range(p, 5):
            for i in range(3):
                for j in range(3):
                    high, low = max(3 * p + i, 3 * q + j), min(3 * p + i, 3 * q + j)
                    for lane in range(LANES):
                        block[i, j, lane] = local[high, low, lane]
            deposit(block, pair, f, n, own, slots, target)
            pair += 1
        for e in range(3):
            for i in range(3):
                for j in range(2):
                    for lane in range(LANES):
                        block[i, j, lane] = local[15 + 2 * e + j, 3 * p + i, lane]
            deposit_angles(block, 3, 0, e, pair, f, n, own, stored, slots, target)
            pair += 1
    for one in range(3):
        for other in range(one, 3):
            for i in range(2):
                for j in range(2):
                    high = max(15 + 2 * one + i, 15 + 2 * other + j)
                    low = min(15 + 2 * one + i, 15 + 2 * other + j)
                    for lane in range(LANES):
                        block[i, j, lane] = local[high, low, lane]
            deposit_angles(block, 2, one, other, pair, f, n, own, stored, slots, target)
            pair += 1
