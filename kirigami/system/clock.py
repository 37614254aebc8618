"""Seconds per part of an analysis."""

from __future__ import annotations

import time


class Clock:
    """Seconds and counts per part, so that cost can be explained."""

    def __init__(self) -> None:
        self.seconds: dict[str, float] = {}
        self.counts: dict[str, int] = {}

    def __call__(self, part: str) -> Watch:
        return Watch(self, part)


class Watch:
    """Times one stretch of work; a class, since on small systems a generator took longer than what it timed."""

    __slots__ = ("clock", "part", "start")

    def __init__(self, clock: Clock, part: str) -> None:
        self.clock, self.part = clock, part

    def __enter__(self) -> None:
        self.start = time.perf_counter()

    def __exit__(self, *_: object) -> None:
        passed, clock, part = time.perf_counter() - self.start, self.clock, self.part
        clock.seconds[part] = clock.seconds.get(part, 0.0) + passed
        clock.counts[part] = clock.counts.get(part, 0) + 1
