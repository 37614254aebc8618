"""Dynamics: the motion of a structure in time, from rest, from an equilibrium, or from where it has just lost it."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from kirigami.analysis.dynamics.history import Histories, History
from kirigami.analysis.dynamics.run import DynamicsRun
from kirigami.analysis.dynamics.schemes import SCHEMES
from kirigami.analysis.resumable import Recorder, Resumable
from kirigami.errors import ModelError
from kirigami.model.model import Model
from kirigami.primitives.checks import (
    require_array,
    require_boolean,
    require_choice,
    require_finite,
    require_not_negative,
    require_positive,
    require_whole,
    shown,
)
from kirigami.primitives.kernel import Array
from kirigami.results.step import Event, Step
from kirigami.system.apart import require_apart

MASSES = ("consistent", "lumped")


class Dynamics(Resumable):
    """The motion of a structure with its masses, by implicit time steps.

    Parameters
    ----------
    model : Model
        Needs mass: a density of the material, ``mass_per_length`` of bars, or :class:`Mass` at nodes. Loads and
        prescribed displacements scale with the load factor, which `load` gives over time.
    end : float
        Time at the end [time].
    step : float
        Longest time step [time]. Steps are halved where no solution is found or a member turns by more than 0.7 rad,
        and kept to turns of 0.35 rad after that.
    damping : float or (float, float)
        Share of the mass [1 / time] in the damping matrix, or shares of mass and stiffness [time] (Rayleigh): a motion
        of circular frequency w is damped by mass / (2 w) + stiffness w / 2 of its critical damping.
    scheme : {"conserving", "damped"}
        "conserving": the average vector field, which keeps energy through snaps. "damped": the same with losses, so
        that motions too fast for the step die out, by 0.8 a step; energy never grows. A motion of circular frequency w
        is then damped by 0.056 w step of its critical damping.
    start : Step or Event, optional
        Where to start: an equilibrium, a moment of another motion, which goes on with its velocities and time, or a
        located limit point or bifurcation, which is left by a small push along its mode. None starts at rest.
    load : float, callable or array_like, shape (k, 2), optional
        Load factor over time: a value that acts from the beginning, a function of time, or a table of times and
        values. None is the load factor of a `start` in the same stage, and 1 otherwise.
    histories : mapping of objects of the model to float, callable or array_like, optional
        Loads and supports that follow load factors of their own, each given as `load` is:
        ``{wind: gust, shaker: sine}``.
    velocity : array_like, shape (n, 3) or (n, dim), optional
        Velocities of the nodes at the beginning [length / time].
    push : float
        Turn of a member [rad] by which a located event is left along its mode; negative for the other side.
    mass : {"consistent", "lumped"}
        As for :class:`Eigen`.
    every : int
        How many time steps go by between two that are stored; the last one is stored in any case.
    adaptive : bool
        False refuses the first time step that fails instead of halving it.
    tol : float
        Residual of a time step over the root sum of squares of its unassembled forces.

    Raises
    ------
    ModelError
        Values out of range, a history of what is no load and no driven support of the model; in a run no mass, a start
        of another model, supports that would have to jump.

    Notes
    -----
    Reactions of a motion have inertia and damping in them: each is the mean since the moment stored before, so that
    times the time gone by they sum up to the change of momentum. At the first moment they are what members and loads
    leave. On parts that nothing holds linear and angular momentum are kept too, at the cost of an error of energy that
    falls with the fourth power of the step: 1e-5 of it where a step turns the part by 0.005 rad, 2e-3 at 0.02 rad. A
    rigid link that floats in a plane keeps energy and momenta; in space its angular momentum to second order, and it is
    to turn by less than a full turn.

    Examples
    --------
    A mass on a spring that is loaded at once swings to twice its static displacement:

    >>> import numpy as np, kirigami as kg
    >>> m = kg.Model(dim=2)
    >>> a, b = m.add(kg.Node(0, 0), kg.Node(1, 0))
    >>> objects = m.add(kg.Bar(a, b, EA=100.0), kg.Fix(a), kg.Fix(b, "y"), kg.Mass(b, 1.0), kg.NodalLoad(b, (0.1, 0)))
    >>> res = kg.Dynamics(m, end=0.6, step=0.01).run()
    >>> round(float(res.u[:, 1, 0].max()), 4), round(float(res.time[np.argmax(res.u[:, 1, 0])]), 2)
    (0.002, 0.31)
    """

    def __init__(
        self,
        model: Model,
        end: float,
        step: float,
        damping: float | tuple[float, float] = 0.0,
        scheme: str = "conserving",
        start: Step | Event | None = None,
        load: float | Callable[[float], float] | ArrayLike | None = None,
        histories: Mapping[Any, float | Callable[[float], float] | ArrayLike] | None = None,
        velocity: ArrayLike | None = None,
        push: float = 0.01,
        mass: str = "consistent",
        every: int = 1,
        adaptive: bool = True,
        tol: float = 1e-8,
    ) -> None:
        super().__init__(model)
        self.end = require_positive(end, "end", "Dynamics")
        self.step = require_positive(step, "step", "Dynamics")
        self.damping = _shares(damping)
        self.scheme = require_choice(scheme, SCHEMES, "scheme", "Dynamics")
        self.mode: Array | None = None
        if isinstance(start, Event):
            if start.located is None:
                raise ModelError(f"Dynamics: this event was not located, so nothing can start from it: {start}")
            self.mode, start = start.mode, start.located
        if start is not None and not isinstance(start, Step):
            raise ModelError(f"Dynamics: start must be a Step, such as results[-1], or an Event, got {shown(start)}")
        self.start = start
        self.begin = 0.0 if start is None or not np.isfinite(start.time) else float(start.time)
        if self.end <= self.begin:
            raise ModelError(f"Dynamics: end={self.end:g} is not after the time of start, {self.begin:g}")
        if load is None:
            load = start.lam if start is not None and start.stage == self.model.stage else 1.0
        self._load = History(load, "load", "Dynamics")
        self._own = _own_histories(model, histories)
        n = len(self.model.nodes)
        self.velocity = None
        if velocity is not None:
            self.velocity = require_array(velocity, (n, 3), (n, self.model.dim), name="velocity", owner="Dynamics")
        self.push = require_finite(push, "push", "Dynamics")
        self.mass = require_choice(mass, MASSES, "mass", "Dynamics")
        self.every = require_whole(every, "every", "Dynamics", least=1)
        self.adaptive = require_boolean(adaptive, "adaptive", "Dynamics")
        self.tol = require_positive(tol, "tol", "Dynamics")

    @property
    def load(self) -> History:
        """The load factor over time."""
        return self._load

    @property
    def factors(self) -> Histories:
        """The load factor and those of the objects that have their own, over time."""
        return Histories([self._load, *self._own.values()])

    @property
    def apart(self) -> tuple[Any, ...]:
        """The objects that have a history of their own."""
        return tuple(self._own)

    def memorable(self) -> dict[str, Any]:
        """What tells this motion from another one of the same model; where it ends does not."""
        objects = {id(item): number for number, item in enumerate(self.model.objects)}
        until = self.begin + 1000 * self.step
        return {name: value for name, value in super().memorable().items() if name != "end"} | {
            "load": self._load.memorable(until),
            **{f"history of {objects[id(item)]}": own.memorable(until) for item, own in self._own.items()},
        }

    def _make_walk(self, recorders: Iterable[Recorder]) -> DynamicsRun:
        return DynamicsRun(self, recorders)


def _own_histories(model: Model, given: Any) -> dict[Any, History]:
    """The histories of loads and driven supports that have their own."""
    if given is None:
        return {}
    if not isinstance(given, Mapping):
        raise ModelError(
            "Dynamics: histories must map objects of the model to factors over time, as {wind: gust}, got "
            f"{shown(given)}"
        )
    items = require_apart(list(given), model, "histories", "Dynamics")
    return {item: History(given[item], f"history of {item!r}", "Dynamics") for item in items}


def _shares(damping: Any) -> tuple[float, float]:
    """Shares of mass and stiffness in the damping."""
    pair = damping if isinstance(damping, (tuple, list)) else (damping, 0.0)
    if len(pair) != 2:
        raise ModelError(f"Dynamics: damping must be one number or two, of mass and stiffness, got {shown(damping)}")
    mass, stiffness = (require_not_negative(share, "damping", "Dynamics") for share in pair)
    return mass, stiffness
