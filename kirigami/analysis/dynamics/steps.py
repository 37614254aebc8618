"""How long the time steps of a motion are: as long as allowed, shorter where members turn far or nothing is found."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from kirigami.analysis.dynamics.motion import Moment, Motion, StepFailedError
from kirigami.analysis.dynamics.schemes import advance
from kirigami.primitives.kernel import Array

SHORTEST = 2.0**-14  # shortest time step, as a share of the longest
WANTED = 0.35  # turn of a member to which steps are kept [rad]
EASY = 12  # corrections up to which the next step may be longer
GROWTH = 1.5  # by this factor


class TimeSteps:
    """Time steps of a motion, one after the other.

    Parameters
    ----------
    motion : Motion
        What moves.
    share : float
        Of the scheme; see :mod:`kirigami.analysis.dynamics.schemes`.
    longest : float
        Longest time step.
    load : callable
        Load factors (1 + k,) and their rates at a time.
    adaptive : bool
        Whether a step that fails is halved.
    on_cut : callable
        Called where one is.
    """

    def __init__(
        self,
        motion: Motion,
        share: float,
        longest: float,
        load: Callable[[float], tuple[Array, Array]],
        adaptive: bool = True,
        on_cut: Callable[[], None] = lambda: None,
    ) -> None:
        self.motion, self.share, self.longest, self.load = motion, share, longest, load
        self.adaptive, self.on_cut = adaptive, on_cut
        self.size = longest  # of the next one

    def advance(self, start: Moment, stop: float) -> tuple[Moment, int, float]:
        """The next moment, no later than `stop`, accepted; the corrections it took and its residual.

        Raises a StepFailedError that says how long the last attempt was.
        """
        system = self.motion.system
        while True:
            count = max(int(np.ceil((stop - start.time) / self.size - 1e-9)), 1)
            step = (stop - start.time) / count
            time = stop if count == 1 else start.time + step
            try:
                moment, corrections, residual = advance(self.motion, start, step, *self.load(time), self.share)
                break
            except StepFailedError as failure:
                if not self.adaptive or 0.5 * step < SHORTEST * self.longest:
                    raise StepFailedError(
                        f"no time step of {step:.3g} was found after time {start.time:.6g}: {failure}"
                    ) from None
                self.on_cut()
                self.size = 0.5 * step
        moment.time = time
        u = self.motion.displacement(moment)
        turn = system.largest_rotation(u - self.motion.displacement(start))
        system.commit(u, moment.lam)
        if self.adaptive:
            longer = GROWTH if corrections <= EASY else 1.0
            self.size = min(max(self.size, step) * min(longer, WANTED / max(turn, 1e-12)), self.longest)
        return moment, corrections, residual
