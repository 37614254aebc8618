"""Parts of an elimination tree that threads can work on side by side."""

from __future__ import annotations

import heapq

import numpy as np

from kirigami.linalg.dissection import Index
from kirigami.primitives.kernel import Array

PIECES = 4  # subtrees for each thread, so that they come out even


def shares(parent: Index, work: Array, threads: int) -> tuple[list[list[int]], list[int]]:
    """Fronts for each thread, and those that are left for when all of these are done; each in the order of the tree.

    Parameters
    ----------
    parent : ndarray of int, shape (n,)
        Parent of each front, which comes behind its children; -1 where it has none.
    work : ndarray, shape (n,)
        What each costs.
    threads : int
        How many threads there are.
    """
    count = len(parent)
    if threads < 2:
        return [], list(range(count))
    whole = work.astype(float).copy()  # of the subtree below
    children: list[list[int]] = [[] for _ in range(count)]
    pieces: list[tuple[float, int]] = []
    for front, above in enumerate(parent.tolist()):
        if above >= 0:
            whole[above] += whole[front]
            children[above].append(front)
    pieces = [(-float(whole[front]), front) for front in range(count) if parent[front] < 0]
    heapq.heapify(pieces)
    small = -sum(size for size, _ in pieces) / (PIECES * threads)
    done: list[tuple[float, int]] = []
    while pieces and len(pieces) + len(done) < PIECES * PIECES * threads:
        size, front = heapq.heappop(pieces)
        if -size <= small or not children[front]:
            done.append((size, front))
            continue
        for child in children[front]:
            heapq.heappush(pieces, (-float(whole[child]), child))
    owner = np.full(count, -1)
    load = np.zeros(threads)
    for size, front in sorted(pieces + done):
        least = int(np.argmin(load))
        load[least] -= size
        owner[front] = least
    for front in range(count - 1, -1, -1):  # a subtree goes to the owner of its root
        above = int(parent[front])
        if above >= 0 and owner[front] < 0 and owner[above] >= 0:
            owner[front] = owner[above]
    return [np.flatnonzero(owner == thread).tolist() for thread in range(threads)], np.flatnonzero(owner < 0).tolist()
