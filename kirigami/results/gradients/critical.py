"""How critical load factors change: at limit points by the null vector, at bifurcations by the eigenvalue.

With the null vector phi of K, a = d(phi' K phi)/dq and K eta = a beside phi,

    limit point    d lam_c/dp = -phi . r_p / phi . r_lam
    bifurcation    d lam_c/dp = -(phi' K_p phi - eta . r_p) / (phi' K_lam phi - eta . r_lam)

(Thompson and Hunt, A General Theory of Elastic Stability, 1973). phi' K_p phi is the difference of phi . r_p over a
short way along phi. A bifurcation stays one only under changes that keep the symmetry it comes from.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from kirigami.errors import AnalysisError, ModelError
from kirigami.linalg import SingularMatrixError, factorize, inverse_iteration
from kirigami.primitives.checks import require_whole
from kirigami.primitives.kernel import Array
from kirigami.results.gradients.equilibrium import Adjoint, Equilibrium, prepared, refuse_history, weighted
from kirigami.results.gradients.functionals import Told
from kirigami.results.results import Results
from kirigami.results.step import Event
from kirigami.system.system import System

TURN = 1e-4  # turn of a member along the null vector in differences [rad]
SHIFT = 1e-9  # of the mean stiffness, where a tangent is too singular to solve with
ROUNDS = 12
SETTLED = 1e-12  # change of the load factor that is nothing
KINDS = ("limit point", "bifurcation")


def gradient(results: Results, functional: Any, derive: Callable[[Sequence[Adjoint]], list[Any]]) -> Any:
    """Derivative of the load factor of an event by what `derive` takes derivatives with respect to."""
    event = event_of(results, functional)
    point = CriticalPoint(prepared(results.model, event.located.history if event.located else None), event)
    return point.derivative(derive)


def event_of(results: Results, functional: Any, owner: str = "gradient") -> Event:
    """The event that ("critical", number) names."""
    if len(functional) != 2:
        raise ModelError(f"{owner}: give ('critical', number of the event)")
    number = require_whole(functional[1], "the number of the event", owner)
    if not -len(results.events) <= number < len(results.events):
        raise ModelError(f"{owner}: there is no event {number}: the results hold {len(results.events)}")
    event = results.events[number]
    if event.kind not in KINDS or event.located is None:
        raise ModelError(
            f"{owner}: event {number} ({event}) is no limit point or bifurcation that was located: it has no gradient"
        )
    return event


class CriticalPoint:
    """A limit point or bifurcation next to that of an event, to the last digits."""

    def __init__(self, system: System, event: Event, owner: str = "gradient") -> None:
        refuse_history(system, owner)
        assert event.located is not None
        self.system, self.kind, self.owner = system, event.kind, owner
        self.lam = event.located.lam
        self.q = system.unknowns(system.joined(event.located.u, event.located.inner))
        self._settle()

    @classmethod
    def next_to(cls, other: CriticalPoint, system: System) -> CriticalPoint:
        """The point of the same kind of a system close by."""
        refuse_history(system, other.owner)
        found = cls.__new__(cls)
        found.system, found.kind, found.owner, found.lam, found.q = system, other.kind, other.owner, other.lam, other.q
        found._settle()
        return found

    def adjoints(self) -> list[Adjoint]:
        """Adjoint fields whose derivatives sum up to that of the load factor."""
        found: list[Adjoint] = []

        def keep(adjoints: Sequence[Adjoint]) -> list[Any]:
            found.extend(adjoints)
            return [0.0] * len(adjoints)

        self.derivative(keep)
        return found

    def _look(self) -> None:
        """Tangent, null vector and their changes at the present place."""
        system = self.system
        u = system.displacement(self.q, self.lam)
        blocks = system.stiffness_blocks(u, self.lam)
        matrix = system.matrix(blocks)
        shift = SHIFT * float(np.abs(matrix.diagonal()).mean())
        from scipy.sparse import identity

        moved = (matrix + shift * identity(system.free, format="csc")).tocsc()
        try:
            self.factor = factorize(moved)
            _, phi = inverse_iteration(self.factor, system.free, 60, 1e-13)
        except SingularMatrixError:
            raise AnalysisError(f"{self.owner}: the tangent at load factor {self.lam:.6g} has no factor") from None
        self.matrix, self.phi = matrix, phi
        self.eigenvalue = float(phi @ (matrix @ phi))
        turn = system.largest_rotation(system.motion(phi, 0.0, u))
        self.step = TURN / turn
        sides = []
        for sign in (1.0, -1.0):
            v = system.displacement(self.q + sign * self.step * phi, self.lam)
            around = system.stiffness_blocks(v, self.lam)
            rate = system.load_rate(v, self.lam, around)
            sides.append((system.matrix(around) @ phi, float(phi @ rate)))
        self.a = (sides[0][0] - sides[1][0]) / (2 * self.step)
        self.by_load = (sides[0][1] - sides[1][1]) / (2 * self.step)  # phi' K_lam phi
        self.rate = system.load_rate(u, self.lam, blocks)
        self.residual = system.imbalance(u, self.lam)[0]

    def beside(self, right: Array) -> Array:
        """Solution of the tangent in all directions but that of the null vector."""
        phi = self.phi
        right = right - phi * (phi @ right)
        answer = self.factor.solve(right)
        answer -= phi * (phi @ answer)
        for _ in range(3):
            rest = right - self.matrix @ answer
            rest -= phi * (phi @ rest)
            more = self.factor.solve(rest)
            answer += more - phi * (phi @ more)
        return np.asarray(answer)

    def _settle(self) -> None:
        size = abs(self.lam) or 1.0
        for _ in range(ROUNDS):
            self._look()
            if self.kind == "limit point":
                change = -float(self.phi @ self.residual) / float(self.phi @ self.rate)
                aside = self.beside(-(self.residual + change * self.rate))
                along = -(self.eigenvalue + self.a @ aside + self.by_load * change) / float(self.a @ self.phi)
                self.q = self.q + aside + along * self.phi
            else:
                per_load = -self.beside(self.rate)
                aside = -self.beside(self.residual)
                slope = self.by_load + float(self.a @ per_load)
                change = -(self.eigenvalue + float(self.a @ aside)) / slope
                self.q = self.q + aside + change * per_load
            if not np.isfinite(change) or abs(change) > 0.2 * size:
                raise AnalysisError(f"{self.owner}: the {self.kind} at load factor {self.lam:.6g} could not be refined")
            self.lam += change
            if abs(change) < SETTLED * size:
                break
        self._look()

    def derivative(self, derive: Callable[[Sequence[Adjoint]], list[Any]]) -> Any:
        """d lam_c by what `derive` takes derivatives with respect to."""
        if self.kind == "limit point":
            return self._of_residual(self.q, self.phi / float(self.phi @ self.rate), derive)
        eta = self.beside(self.a)
        whole = self.by_load - float(eta @ self.rate)
        share = self.phi / (2 * self.step * whole)
        parts = [
            self._of_residual(self.q + self.step * self.phi, share, derive),
            self._of_residual(self.q - self.step * self.phi, -share, derive),
            self._of_residual(self.q, -eta / whole, derive),
        ]
        return weighted((1.0, 1.0, 1.0), parts)

    def _of_residual(self, q: Array, multiplier: Array, derive: Callable[[Sequence[Adjoint]], list[Any]]) -> Any:
        """-multiplier . dr/dp at unknowns q."""
        at = Equilibrium.as_given(self.system, q, self.lam, self.owner)
        told = Told(self.lam, np.zeros((len(self.system.rest), 3)), np.zeros((self.system.points, 3)))
        return derive([Adjoint(at, told, np.zeros_like(self.system.rest), multiplier)])[0]
