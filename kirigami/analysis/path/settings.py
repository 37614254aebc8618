"""What a path analysis is told: settings, checked when they are given, and what the path methods differ in."""

from __future__ import annotations

from kirigami.analysis.path.controls import Control, LoadFactorControl
from kirigami.analysis.path.descent import CORRECTORS
from kirigami.analysis.path.increments import Increments
from kirigami.analysis.path.points import Point
from kirigami.analysis.resumable import Resumable
from kirigami.errors import ModelError
from kirigami.model.model import Model
from kirigami.primitives.checks import require_choice, require_positive, require_whole, shown
from kirigami.primitives.kernel import Array
from kirigami.results.results import Results
from kirigami.results.step import Event, Step
from kirigami.system.system import System

ON_INSTABILITY = ("follow", "switch", "stop")


class PathSettings(Resumable):
    """Settings of a path analysis; a run of it is a :class:`~kirigami.analysis.path.walk.Walk`."""

    max_steps = 100_000
    settle = "overdamped"
    damping = 0.05

    def __init__(
        self,
        model: Model,
        tol: float,
        start: Step | Event | None,
        on_instability: str,
        branch: int | None,
        corrector: str = "path",
    ) -> None:
        super().__init__(model)
        owner = type(self).__name__
        self.on_instability = require_choice(on_instability, ON_INSTABILITY, "on_instability", owner)
        self.corrector = require_choice(corrector, CORRECTORS, "corrector", owner)
        self.tol = require_positive(tol, "tol", owner)
        self.branch = None if branch is None else require_whole(branch, "branch", owner)
        self.mode: Array | None = None
        if branch is not None and (branch not in (1, -1) or getattr(start, "kind", "") != "bifurcation"):
            raise ModelError(f"{owner}: branch=+1 or -1 goes with start=event, a located bifurcation of results.events")
        if isinstance(start, Event):
            if start.located is None:
                raise ModelError(f"{owner}: this event was not located, so nothing can start from it: {start}")
            self.mode = start.mode
            start = start.located
        if start is not None and not isinstance(start, Step):
            raise ModelError(f"{owner}: start must be a Step, such as results[-1], or an Event, got {shown(start)}")
        self.start = start

    def goes_downhill(self, control: Control) -> bool:
        """Whether unstable equilibria are left for stable ones at the same load factor."""
        return self.on_instability == "switch" and isinstance(control, LoadFactorControl)

    # What the three methods differ in.

    def chosen_for(self, system: System) -> PathSettings:
        """These settings with what depends on the structure."""
        return self

    def make_control(self, system: System) -> Control:
        """The equation beside equilibrium that says how far to go."""
        raise NotImplementedError

    def plan(self, control: Control, point: Point) -> Increments:
        """Increments for a walk that starts from `point`."""
        raise NotImplementedError

    def stops(self, results: Results) -> bool:
        """Whether the path ends here by choice."""
        return False

    def steer(self, increments: Increments, results: Results, point: Point) -> None:
        """Adjust the increments once a point is accepted."""
