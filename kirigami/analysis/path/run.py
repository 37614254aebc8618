"""One run of a path: what is lowered and found, and how a point is predicted, corrected and examined."""

from __future__ import annotations

from functools import cached_property

import numpy as np

from kirigami.analysis.base import Run, require_potential
from kirigami.analysis.path.controls import Control, LoadFactorControl
from kirigami.analysis.path.descent import CORRECTORS, descend
from kirigami.analysis.path.increments import Increments
from kirigami.analysis.path.iterate import Iterate
from kirigami.analysis.path.newton import BLOCKED, correct
from kirigami.analysis.path.points import Attempt, Point, State, Stiffness, Tangent
from kirigami.analysis.path.settings import PathSettings
from kirigami.analysis.path.skew import solve
from kirigami.analysis.path.tracking import CHORDS
from kirigami.errors import ConvergenceError
from kirigami.linalg import Factor, NearbyFactor, SingularMatrixError
from kirigami.primitives.kernel import Ahead, Array
from kirigami.words import percent

MAX_ITERATIONS = 14
MAX_RELAXATION = 120
DRIFT_LARGEST = 0.25  # an equilibrium that far off the prediction may lie on another branch: the increment is cut [rad]
STRAINED = 0.2  # change of length of an edge, as a share, from which on a failure is put down to it
HALVINGS = 6  # of the share of a prediction that effects allow
PREDICTED_TURN = 0.5  # a prediction that turns a member by more is cut before it is tried [rad]


class PathRun(Run):
    """One run of a path analysis.

    Attributes
    ----------
    settings : PathSettings
        What is to be done; a run reads it and changes nothing in it.
    control : Control
        The equation beside equilibrium.
    increments : Increments
        How far to go next.
    """

    increments: Increments

    def __init__(self, settings: PathSettings) -> None:
        super().__init__(settings)
        self.settings = settings = settings.chosen_for(self.system)
        self.control: Control = settings.make_control(self.system)
        if settings.on_instability != "follow":
            require_potential(self.system, type(settings).__name__)
        self.system.check_supports()

    @property
    def downhill(self) -> bool:
        """Whether unstable equilibria are left for stable ones at the same load factor."""
        return self.settings.goes_downhill(self.control)

    def predict(self, before: Point, increment: float) -> tuple[State, Array] | None:
        """The state on the tangent, one increment on, and the change to it; None where the tangent leads nowhere."""
        state, rate = before.state, before.tangent.rate
        self.control.begin(state, increment)
        step_lam = self.control.predict(increment, rate)
        if not np.isfinite(step_lam):
            return None
        q, lam = state.q + step_lam * rate, state.lam + step_lam
        u = self.system.displacement(q, lam)
        share = self.system.admissible(state.u, u)
        for _ in range(HALVINGS if share < 1 else 0):  # what is driven arrives, the rest follows as far as it may
            q = state.q + share * step_lam * rate
            u = self.system.displacement(q, lam)
            if self.system.admissible(state.u, u) == 1:
                break
            share *= 0.5
        return State(q, lam, u), u - state.u

    def blocked(self, before: Point, state: State) -> Attempt | None:
        """A failed attempt where the way from a point to a state is forbidden, else None."""
        if self.system.admissible(before.state.u, state.u) == 1:
            return None
        return Attempt(before.state, False, float("inf"), 0, [], BLOCKED)

    def try_increment(self, before: Point, increment: float) -> Attempt:
        """Predict along the tangent and correct by Newton's method."""
        system = self.system
        predicted = self.predict(before, increment)
        if predicted is None:
            return Attempt(before.state, False, float("inf"), 0, [], "the control does not act on the structure")
        state, change = predicted
        if system.largest_rotation(change) > PREDICTED_TURN:
            return Attempt(before.state, False, float("inf"), 0, [], "the increment turns members too far")
        if (blocked := self.blocked(before, state)) is not None:
            return blocked
        attempt = self.correct(self.control, state, (before.state.u, change))
        attempt.iterations += 1
        attempt.drift = system.largest_rotation(attempt.state.u - state.u)
        attempt.moved = system.largest_rotation(attempt.state.u - before.state.u)
        if attempt.converged and attempt.drift > DRIFT_LARGEST:
            attempt.converged = False
            attempt.reason = f"equilibrium found {attempt.drift:.2f} rad off the prediction, maybe on another branch"
        return attempt

    def relax(self, before: Point, increment: float, hold: bool) -> Attempt:
        """Run downhill from the prediction to a stable equilibrium.

        Near a limit point the tangent shoots off: then fail, or with `hold` move only what is driven, and let the rest
        follow.
        """
        system, strategy = self.system, CORRECTORS[self.settings.corrector]
        predicted = self.predict(before, increment)
        assert predicted is not None  # the load factor itself is the parameter
        state, change = predicted
        if system.largest_rotation(change) > strategy.turn:
            if not hold:
                return Attempt(before.state, False, float("inf"), 0, [], "the increment turns members too far")
            q = before.state.q
            state = State(q, state.lam, system.displacement(q, state.lam))
            change = state.u - before.state.u
        if (blocked := self.blocked(before, state)) is not None:
            return blocked
        attempt = self.descend(state, (before.state.u, change))
        attempt.iterations += 1
        attempt.drift = system.largest_rotation(attempt.state.u - state.u)
        attempt.relaxed = attempt.drift > DRIFT_LARGEST
        if attempt.left_at is not None:
            attempt.relaxed = True
            left, stiffness = attempt.left_at
            if system.largest_rotation(left.u - state.u) <= DRIFT_LARGEST:  # else the descent came from elsewhere
                attempt.left = Point(left, self.tangent(left, stiffness), before.history)
        self.results.stats["relaxations"] += int(attempt.relaxed or strategy.newton_first)
        return attempt

    def correct(self, control: Control, state: State, ahead: Ahead = None) -> Attempt:
        """Correct a state, which a linear step `ahead` may have led to, by Newton's method under any control."""
        tol, count = self.settings.tol, self.count_iteration
        return correct(self.system, self.factorize_blocks, control, state, tol, MAX_ITERATIONS, count, ahead)

    def descend(
        self, state: State, ahead: Ahead = None, floor: float = -np.inf, places: bool = False, share: float = 1.0
    ) -> Attempt:
        """Run downhill from a state, at its load factor, by the means of the corrector that was chosen; not below a
        potential of `floor`, with `places` one by one first, in a `share` of the iterations allowed."""
        strategy, tol, count = CORRECTORS[self.settings.corrector], self.settings.tol, self.count_iteration
        given = state, tol, int(share * MAX_RELAXATION), strategy, count, ahead, floor, places
        return descend(self.system, self.factorize_blocks, *given)

    def tangent_at(self, attempt: Attempt) -> Tangent | None:
        """The exact tangent at a converged state; None where the attempt failed or the tangent is singular."""
        if not attempt.converged:
            return None
        system, state = self.system, attempt.state
        try:
            if attempt.stiffness is None:
                with np.errstate(all="ignore"):  # a member without length is told of where the step is stored
                    blocks = system.stiffness_blocks(state.u, state.lam)
                driven, matrix = system.drive_rate(state.lam, blocks), system.matrix(blocks)
                del blocks
                attempt.stiffness = Stiffness(driven, self.factorize(matrix), state.u)
            return self.tangent(state, attempt.stiffness)
        except SingularMatrixError as error:
            attempt.reason = str(error)
            return None

    def tangent(self, state: State, stiffness: Stiffness) -> Tangent:
        """The tangent at an equilibrium, from its stiffness."""
        system = self.system
        with system.clock("solve"), np.errstate(all="ignore"):
            towards = system.load_rate_beside(stiffness.drive_rate, state.u, state.lam)
            rate = -solve(system, stiffness.factor, state.q, state.lam, towards)
        return Tangent(stiffness.factor, rate)

    def settled_rate(self, point: Point) -> Array:
        """Change of the unknowns with the load factor at a point, once that is balanced as well as rounding allows.

        Near a buckle a residual within the tolerance moves a thin sheet further along the softest mode, and its rate
        with it, than its imperfection does. It takes solutions with a known factor alone.
        """
        system, factor = self.system, point.tangent.factor
        system.history = point.history
        at = Iterate(system, self.factorize_blocks, point.state, 0.0)
        at.chords(factor, CHORDS)
        blocks = at.blocks()
        near = NearbyFactor(system.matrix(blocks), factor.near if isinstance(factor, NearbyFactor) else factor)
        try:
            return self.tangent(at.state, Stiffness(system.drive_rate(at.lam, blocks), near, at.u)).rate
        except SingularMatrixError:  # at the buckle itself
            return point.tangent.rate

    def factorize_blocks(self, blocks: Array) -> Factor:
        """Factor of the reduced matrix of assembled blocks."""
        return self.factorize(self.system.matrix(blocks))

    @cached_property
    def weight(self) -> Array:
        """What each unknown (free,) weighs: the area of the sheet about its node; without a mesh all the same."""
        system, mesh = self.system, self.system.model.mesh
        area = np.ones(len(system.rest))
        if mesh is not None:
            area[:] = 0.0
            np.add.at(area, mesh.triangles.ravel(), np.repeat(mesh.facet_areas / 3, 3))
        weight: Array = system.reduce(np.repeat(area[:, None], system.dim, axis=1))
        np.maximum(weight, 1e-6 * weight.max(initial=0.0), out=weight)
        return weight

    def count_iteration(self) -> None:
        """One more correction."""
        self.results.stats["iterations"] += 1

    def failure(self, attempt: Attempt, increment: float) -> ConvergenceError:
        """What to raise where no equilibrium is found after the last one."""
        system, results = self.system, self.results
        total, _ = system.forces(attempt.state.u, attempt.state.lam)
        unbalanced = np.zeros(system.rest.size)
        moving = system.unknown >= 0
        unbalanced[moving] = total.ravel()[moving]
        size = np.linalg.norm(unbalanced.reshape(total.shape)[: system.points], axis=1)
        worst = np.argsort(-np.nan_to_num(size, nan=np.inf), kind="stable")[:5].tolist()
        where = f"after load factor {results.steps[-1].lam:.6g}" if results.steps else "at the start"
        named = ", ".join(f"{k} {system.model.nodes[k]!r}" for k in worst[:3])
        return ConvergenceError(
            f"no equilibrium found {where}, last increment {increment:.3g}: {attempt.reason or 'not converged'}; "
            f"largest unbalanced forces at nodes {named}",
            results=results,
            history=attempt.history,
            worst_nodes=worst,
            hint=self._hint(attempt, worst[0]),
        )

    def _strain_about(self, node: int) -> float:
        """Largest change of length, as a share, of an edge at the neighbours of a node, at the last step."""
        mesh, steps = self.system.model.mesh, self.results.steps
        if mesh is None or not steps or node >= len(mesh.nodes):
            return 0.0
        beside = np.unique(mesh.edges[(mesh.edges == node).any(axis=1)])
        one, other = mesh.edges[np.isin(mesh.edges, beside).any(axis=1)].T
        first = self.system.rest[other] - self.system.rest[one]
        last = first + steps[-1].u[other] - steps[-1].u[one]
        return float(np.max(np.abs(np.linalg.norm(last, axis=1) / np.linalg.norm(first, axis=1) - 1.0)))

    def _hint(self, attempt: Attempt, worst: int) -> str:
        if attempt.reason == BLOCKED:
            return "what is held or driven meets other parts of the sheet: drive it less far, or free what must give"
        negative = self.results.steps[-1].negative if self.results.steps else 0
        if negative:
            return (
                "the last step is unstable: a slightly different imperfection (Model.perturb with a mode of Eigen) "
                "lets the path take the stable branch"
            )
        if isinstance(self.control, LoadFactorControl) and not self.system.drive.any():
            return "past a limit point no equilibrium exists at a higher load: use DisplacementControl or ArcLength"
        if (strain := self._strain_about(worst)) > STRAINED:
            return (
                f"there an edge has changed its length by {percent(strain)}, far more than the law of small strains "
                "means: facets collapse, where the material would tear. Pull less far, or draw the ligament wider or "
                "without it; the results so far are in error.results"
            )
        return (
            "a larger imperfection (Model.perturb), a smaller step, or ArcLength where the path turns back; "
            "the results so far are in error.results"
        )
