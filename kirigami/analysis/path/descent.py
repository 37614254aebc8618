"""Downhill correctors at a given load factor: they end in a stable equilibrium or not at all.

Where Newton's method meets an indefinite tangent, it heads for a saddle or nowhere. Here the tangent of every
iteration is made positive definite first, by one of two means, and only as far as it takes for no pivot to be negative:

* ``"fade"``: the part of the Hessian that can make it indefinite (compression in bars, moments in hinges) is faded
  out. Only members under compression become stiffer, so soft motions elsewhere stay free.
* ``"shift"``: a multiple of the lumped mass is added. This is one backward Euler step of a viscous motion, that is
  pseudo-transient continuation (Kelley and Keyes, SIAM J. Numer. Anal. 35 (1998)); the shift is one over the time step.

With no negative pivot the iteration is Newton's, with the mixed stress and the cap on rotations of
:mod:`kirigami.analysis.path.newton`, so nothing is lost on smooth parts of the path. After each factorisation a few
more corrections use the same factor (chord steps) as long as the residual falls well: they cost a twentieth of it.
An equilibrium found is tested with the exact tangent, and left along its softest mode if it is unstable.

Most of what is set free is so in one place. There the iteration goes on by itself while all else stays, until it
balances against the rest, and only then a factor of the whole is made (:mod:`kirigami.analysis.path.places`).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from kirigami.analysis.path.iterate import Iterate
from kirigami.analysis.path.places import place_of
from kirigami.analysis.path.points import Attempt, State, Stiffness
from kirigami.linalg import Factor, SingularMatrixError, inverse_iteration, make_solver
from kirigami.primitives.kernel import Ahead, Array
from kirigami.system.system import System

FELL = "more energy is set free than by a bend of the path"
BALANCED = 0.1  # residual of a place over that of all else at which it has settled
IN_PLACE = 20  # most iterations of a place
PUSH = 0.05  # turn of a member by which an unstable equilibrium is pushed off along its mode [rad]
SHORTER = 0.25  # ... the next time over this time: two stable ones may lie so close that forces hardly tell them apart


@dataclass(frozen=True)
class Strategy:
    """How an increment is carried to a stable equilibrium.

    Attributes
    ----------
    newton_first : bool
        Try Newton's method at shorter and shorter increments before a descent.
    means : {"fade", "shift"}
        How the tangent is made positive definite.
    least, most : float
        Smallest and largest amount; for ``"shift"`` relative to the median diagonal of the stiffness.
    growth, decay : float
        Factors of the amount, after a factorisation with a negative pivot and after an iteration without one.
    many : int
        With more negative pivots than this, the largest amount is taken at once.
    chords : int
        Most corrections with an old factor.
    turn : float
        Largest turn of a member in a prediction [rad].
    cuts : int
        Shorter increments tried before the hard way: a descent after Newton's method, or one that moves only what is
        driven where the prediction turns members too far.
    least_growth, growth_after_snap : float
        Least factor from an increment to the next, and the factor where the descent led far off.
    """

    newton_first: bool = False
    means: str = "fade"
    least: float = 0.05
    most: float = 1.0
    growth: float = 4.0
    decay: float = 3.0
    many: int = 5
    chords: int = 4
    turn: float = 1.0
    cuts: int = 1
    least_growth: float = 0.9
    growth_after_snap: float = 1.5


CORRECTORS = {
    "path": Strategy(chords=8),
    "slow": Strategy(),
    "newton": Strategy(
        newton_first=True,
        least=0.02,
        growth=3.0,
        decay=1.5,
        many=10**9,
        chords=0,
        turn=0.5,
        cuts=3,
        least_growth=0.5,
        growth_after_snap=1.0,
    ),
    "descent": Strategy(),
    "viscous": Strategy(means="shift", least=1e-6, most=1e3, growth=10.0, decay=3.0, many=10**9),
}


def descend(
    system: System,
    factorize: Callable[[Array], Factor],
    start: State,
    tol: float,
    max_iterations: int,
    strategy: Strategy,
    on_iteration: Callable[[], None] = lambda: None,
    ahead: Ahead = None,
    floor: float = -np.inf,
    places: bool = False,
) -> Attempt:
    """Iterate downhill from `start`, at its load factor, to a stable equilibrium.

    `ahead` is the linear step that led to `start`: displacements and their change, see :class:`kirigami.Tangent`. Where
    the potential falls below `floor`, so will that of the equilibrium: the descent is given up, for the reason FELL.
    With `places` the place where nearly all of the residual sits settles by itself before each iteration of the whole.
    """
    return _Descent(system, factorize, start, tol, strategy, ahead, floor, places).run(max_iterations, on_iteration)


class _Descent(Iterate):
    """A descent, with the amount by which the tangent is made positive definite."""

    def __init__(
        self,
        system: System,
        factorize: Callable[[Array], Factor],
        start: State,
        tol: float,
        strategy: Strategy,
        ahead: Ahead,
        floor: float = -np.inf,
        places: bool = False,
    ) -> None:
        super().__init__(system, factorize, start, tol, ahead)
        self.strategy, self.floor = strategy, floor
        self.places = places and system.comes_apart
        self.amount, self.pushes = 0.0, 0
        self.left: tuple[State, Stiffness] | None = None
        self._unit: Array | None = None

    def run(self, max_iterations: int, on_iteration: Callable[[], None]) -> Attempt:
        for iteration in range(max_iterations + 1):
            self.history.append(self.relative)
            if not np.isfinite(self.relative):
                return self._attempt(iteration, "a member collapsed (forces are not finite)")
            try:
                if self.relative <= self.tol:
                    stiffness = self.stiffness()
                    if stiffness.factor.negative == 0:
                        found = self._attempt(iteration)
                        found.stiffness = stiffness
                        return found
                    if self.left is None:
                        self.left = self.state, stiffness
                    self.move(self._push(stiffness.factor))
                    self.balance()
                elif iteration < max_iterations:
                    self._iterate()
                    if np.isfinite(self.floor) and self._potential() < self.floor:
                        return self._attempt(iteration, FELL)
            except SingularMatrixError as error:
                return self._attempt(iteration, str(error))
            on_iteration()
        return self._attempt(max_iterations, "too many iterations")

    def _iterate(self) -> None:
        """One step with a positive definite tangent, and chord steps after it."""
        strategy = self.strategy
        if self.places and self.left is None:  # a place would go back to a saddle
            self._settle_place()
            if self.relative <= self.tol:
                return
        factor = self._positive_factor()
        self.correct(factor)
        self.chords(factor, strategy.chords)
        self.amount = self.amount / strategy.decay if self.amount > 0.25 * strategy.least else 0.0

    def _settle_place(self) -> None:
        """Let the place where nearly all of the residual sits settle while all else stays, if it does so downhill."""
        system = self.system
        place = place_of(system, self.residual)
        if place is None:
            return
        part, solver = system.part(place, self.u), make_solver("superlu")  # no plan to make
        start = State(self.q[place], self.lam, self.u)
        made = lambda blocks: solver.factorize(part.matrix(blocks))  # noqa: E731
        at = _Descent(part, made, start, self.tol, self.strategy, self.ahead)
        outside = np.delete(self.residual, place)
        enough, potential = BALANCED * float(np.linalg.norm(outside)), at._potential()

        def settled() -> bool:
            return at.relative <= at.tol or bool(np.linalg.norm(at.residual) <= enough)

        try:
            for _ in range(IN_PLACE):
                if settled() or not np.isfinite(at.relative):
                    break
                at._iterate()
        except SingularMatrixError:
            return
        if settled() and at._potential() <= potential:
            q = self.q.copy()
            q[place] = at.q
            self.q, self.u, self.ahead = q, system.displacement(q, self.lam), at.ahead
            self.balance()

    def _potential(self) -> float:
        with np.errstate(all="ignore"):
            return sum(self.system.energies(self.u, self.lam).values())

    def _positive_factor(self) -> Factor:
        """Factor of the tangent with just enough done to it for no pivot to be negative."""
        strategy = self.strategy
        factor = self.factor() if self.amount == 0 else self.factorize(self._raised())
        while (negative := factor.negative) and self.amount < strategy.most:
            grown = max(self.amount * strategy.growth, strategy.least)
            self.amount = strategy.most if negative > strategy.many else min(grown, strategy.most)
            del factor  # so that the next one takes its place in memory
            self.let_go()
            factor = self.factorize(self._raised())
        return factor

    def _raised(self) -> Array:
        """Blocks of the tangent with the present amount of fading or mass."""
        if self.strategy.means == "fade":
            return self.blocks(self.amount)
        blocks = self.blocks()
        plan = self.system.plan
        own = np.flatnonzero(plan.low == plan.high)
        axes = np.arange(self.system.dim)
        diagonal = blocks[axes[:, None], axes[:, None], own]
        if self._unit is None:
            self._unit = np.full(len(own), float(np.median(np.abs(diagonal))))
        blocks[axes[:, None], axes[:, None], own] = diagonal + self.amount * self._unit
        return blocks

    def _push(self, factor: Factor) -> Array:
        """A small move along the mode nearest to neutral, by inverse iteration; its largest entry is positive."""
        _, mode = inverse_iteration(factor, self.system.free, 8)
        mode *= np.sign(mode[np.argmax(np.abs(mode))])
        mode *= PUSH * SHORTER**self.pushes / self.system.largest_rotation(self.change(mode))
        self.pushes += 1
        return self.system.admissible(self.u, self.u + self.change(mode)) * mode

    def _attempt(self, iteration: int, reason: str = "") -> Attempt:
        return Attempt(self.state, not reason, self.relative, iteration, self.history, reason, left_at=self.left)
