"""Loops over node blocks for Numba to compile; only :mod:`kirigami.system.assembly` imports this file."""

from __future__ import annotations

import math

from kirigami.primitives.compiling import compiler

compiled = compiler()


@compiled
def complete(low, high, own, blocks):  # type: ignore[no-untyped-def]
    """Fill in the block of each node with itself; see BlockPlan.complete."""
    for k in range(len(low)):
        if low[k] != high[k]:
            first, second = own[low[k]], own[high[k]]
            for a in range(3):
                for b in range(a + 1):
                    blocks[first, a, b] -= blocks[k, a, b]
                    blocks[second, a, b] -= blocks[k, b, a]
    for first in own:
        for a in range(3):
            for b in range(a):
                blocks[first, b, a] = blocks[first, a, b]


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
