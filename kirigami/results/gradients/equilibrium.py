"""An equilibrium found to the last digits, with its factored tangent, and the adjoint field of a functional there.

With unknowns q, displacements u(q, lam, p) and forces g(u, p), equilibrium is r = T' g = 0. For J(x, f, U) of
positions, nodal forces and stored energy, and K mu = dJ/dq,

    dJ/dp = d/dp [ J(x, f, U) - mu . r ]  at fixed q.

That needs no second solution, and no derivative of the equilibrium (adjoint method; Haftka and Guerdal, Elements of
Structural Optimization, 1992). With w = dJ/df and v = w - T mu the part of a member with forces g_m and energy U_m is
v . g_m + dJ/dU U_m.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import Any

import numpy as np

from kirigami.errors import AnalysisError, ModelError
from kirigami.linalg import SingularMatrixError, make_solver
from kirigami.primitives.kernel import Array, Configuration, Kernel
from kirigami.results.gradients.functionals import Tell, Told
from kirigami.system.assembly import scatter_add
from kirigami.system.system import System

BALANCED = 1e-14  # residual that is nothing but rounding
ENOUGH = 1e-9  # residual at which a search that goes no further has arrived
SLOW = 0.1  # growth of the residual from one correction to the next at which the tangent is made anew
ROUNDS = 25
TURN = 0.3  # largest turn of a member in one correction [rad]
EXACT = 1e-11  # residual of a solution, whose error a derivative feels as a share of right-hand side times change
REFINED = 1e-9  # residual of a solution with a tangent close by, above which it is made anew


class Equilibrium:
    """The equilibrium next to displacements `u` (rows, dim) of a system at a load factor.

    Raises
    ------
    AnalysisError
        There is none close by, or its tangent is singular.
    """

    def __init__(self, system: System, u: Array, lam: float, owner: str = "gradient") -> None:
        refuse_history(system, owner)
        self.system, self.lam, self.owner = system, lam, owner
        self.factorizations = 0
        self._solver = make_solver()
        self.q = system.unknowns(u)
        self._settle()

    @classmethod
    def as_given(cls, system: System, q: Array, lam: float, owner: str = "gradient") -> Equilibrium:
        """Unknowns as they are, in equilibrium or not."""
        state = cls.__new__(cls)
        state.system, state.lam, state.owner, state.q = system, lam, owner, q
        state.u = system.displacement(q, lam)
        state.factorizations, state._blocks = 0, None
        return state

    @property
    def negative(self) -> int:
        """Number of negative eigenvalues of the tangent."""
        return int(self.factor.negative)

    def take_tangent(self) -> None:
        """The exact tangent here."""
        self._blocks: Array | None = self.system.stiffness_blocks(self.u, self.lam)
        self.matrix = self.system.matrix(self._blocks)

    def _blocks_of_nodes(self) -> Array:
        """Blocks of the tangent before anything is carried to the rows that lead."""
        if self._blocks is None or self.system.grips is not None:
            return self.system.stiffness_blocks(self.u, self.lam, carried=False)
        return self._blocks

    def _factorize(self) -> None:
        self.take_tangent()
        try:
            self.factor = self._solver.factorize(self.matrix)
        except SingularMatrixError:
            raise AnalysisError(
                f"{self.owner}: the tangent stiffness is singular at load factor {self.lam:.6g}, so nothing changes "
                "smoothly there: take a step off the critical point"
            ) from None
        self.factorizations += 1

    def _settle(self) -> None:
        """Newton's method with a tangent that is kept as long as it serves."""
        system, before = self.system, np.inf
        best: tuple[float, Array] = (np.inf, self.q)
        fresh = False
        for _ in range(ROUNDS):
            self.u = system.displacement(self.q, self.lam)
            with np.errstate(all="ignore"):
                residual, size = system.imbalance(self.u, self.lam)
            if not np.isfinite(size):
                break
            if size < best[0]:
                best = (size, self.q)
            if size <= BALANCED and hasattr(self, "factor"):
                break
            stalled = size > 0.5 * before
            if fresh and stalled and best[0] <= ENOUGH:
                break
            if not hasattr(self, "factor") or (size > SLOW * before and not (fresh and size <= ENOUGH)):
                self._factorize()
                fresh = True
            else:
                fresh = False
            change = -self.factor.solve(residual)
            turn = system.largest_rotation(system.motion(change, 0.0, self.u))
            self.q = self.q + change * min(1.0, TURN / max(turn, 1e-300))
            before = size
        if best[0] > ENOUGH:
            raise AnalysisError(
                f"{self.owner}: no equilibrium was found next to the state given at load factor {self.lam:.6g} "
                f"(residual {best[0]:.1e})"
            )
        self.residual, self.q = best
        self.u = system.displacement(self.q, self.lam)
        self.take_tangent()

    def solve(self, right: Array) -> Array:
        """Unknowns (free,) or (free, k) of the exact tangent: the factor may be that of a state close by, which is
        refined."""
        if right.ndim == 1:
            return np.asarray(self.solve(right[:, None])[:, 0])
        size = np.linalg.norm(right, axis=0)
        if not size.any():
            return np.zeros_like(right)
        size = np.where(size > 0, size, 1.0)
        answer = self.factor.solve(right)
        rest = right - self.matrix @ answer
        now = np.linalg.norm(rest, axis=0) / size
        left = np.full_like(now, np.inf)
        for _ in range(8):
            again = (now > EXACT) & (now <= 0.5 * left)  # each as long as that helps
            if not again.any():
                break
            left[again] = now[again]
            answer[:, again] += self.factor.solve(rest[:, again])
            rest[:, again] = right[:, again] - self.matrix @ answer[:, again]
            now[again] = np.linalg.norm(rest[:, again], axis=0) / size[again]
        if not (np.minimum(now, left) <= REFINED).all():
            self._factorize()
            answer = self.factor.solve(right)
            answer = answer + self.factor.solve(right - self.matrix @ answer)
        return np.asarray(answer)

    # ---- what it tells

    @property
    def configuration(self) -> Configuration:
        """Rows (rows, dim) that kernels are evaluated at."""
        return self.system.configuration(self.u)

    @cached_property
    def _borne(self) -> tuple[Array, Array, float]:
        return borne(self.system, self.configuration, self.lam)

    def told(self, tell: Tell) -> Told:
        """A functional here, with its derivatives."""
        system = self.system
        forces, _, energy = self._borne
        rows = np.zeros((len(system.rest), 3))
        rows[: system.points] = system.model.positions()
        rows[:, : system.dim] = self.configuration
        told = tell(rows, system.parted(forces)[0], energy)
        finite = all(np.isfinite(part).all() for part in told[:4])
        if not finite:
            raise AnalysisError(f"{self.owner}: the functional returned numbers that are not finite")
        return told

    def adjoint(self, told: Told) -> Adjoint:
        """The field v of a functional."""
        return self.adjoints([told])[0]

    def adjoints(self, told: Sequence[Told]) -> list[Adjoint]:
        """The fields v of functionals, out of one solution for all of them."""
        system = self.system
        blocks: Array | None = None
        by_forces, rights = [], []
        for item in told:
            w = np.zeros_like(system.rest)
            w[: system.points] = item.by_force[:, : system.dim]
            right = item.by_position[:, : system.dim].copy()
            if w.any():
                blocks = self._blocks_of_nodes() if blocks is None else blocks
                right += system.multiply(blocks, w)
            if item.by_energy:
                right += item.by_energy * self._borne[1]
            by_forces.append(w)
            rights.append(system.reduce(system.carried(right, self.u)))
        multipliers = self.solve(np.stack(rights, axis=1))
        return [Adjoint(self, *parts) for parts in zip(told, by_forces, multipliers.T)]


class Adjoint:
    """The multipliers of one functional at one equilibrium."""

    def __init__(self, at: Equilibrium, told: Told, w: Array, multiplier: Array) -> None:
        self.at, self.told, self.w, self.multiplier = at, told, w, multiplier
        self.v = self.field(at.system, at.u)
        self._by_arrays: dict[int, dict[str, Array]] = {}

    def field(self, system: System, u: Array) -> Array:
        """v (rows, dim): what forces of members count for, in a system as it is at `u`."""
        return np.asarray(self.w - system.motion(self.multiplier, 0.0, u))

    def of_member_arrays(self, kernel: Kernel) -> dict[str, Array]:
        """Derivatives by the arrays of a kernel."""
        if id(kernel) not in self._by_arrays:
            energy = self.told.by_energy if kernel.stores_energy else 0.0
            found = kernel.sensitivity(self.at.configuration, self.at.lam, self.v, energy)
            self._by_arrays[id(kernel)] = found
        return self._by_arrays[id(kernel)]


def borne(system: System, configuration: Configuration, lam: float) -> tuple[Array, Array, float]:
    """Forces (rows, dim) of everything and of what stores energy, and that energy."""
    forces, stored, energy = np.zeros_like(system.rest), np.zeros_like(system.rest), 0.0
    for kernel in system.kernels:
        found = kernel.evaluate(configuration, lam, 1)
        assert found.gradient is not None
        scatter_add(stored if kernel.stores_energy else forces, kernel.conn, found.gradient)
        energy += float(found.energy.sum()) if kernel.stores_energy else 0.0
    return forces + stored, stored, energy


def weighted(weights: Sequence[float], rates: Sequence[Any]) -> Any:
    """A weighted sum of derivatives, be they numbers, arrays, or dicts of them by the names of parameters."""
    if isinstance(rates[0], dict):
        return {name: weighted(weights, [rate[name] for rate in rates]) for name in rates[0]}
    return sum(weight * rate for weight, rate in zip(weights, rates))


def refuse_history(system: System, owner: str) -> None:
    """Raise where an end state does not tell how it changes."""
    for kernel in system.kernels:
        if kernel.path_dependent:
            raise ModelError(
                f"{owner}: what {kernel.name!r} bears depends on the way it was reached, so an end state has no "
                "gradient: take it out of the model, or compare runs"
            )
        if type(kernel).coupling is not Kernel.coupling:
            raise ModelError(
                f"{owner}: {kernel.name!r} joins parts of the sheet that lie far apart, which gradients do not know: "
                "take it out of the model, or compare runs"
            )
    if not system.conservative:
        raise ModelError(
            f"{owner}: a force of the model has no potential, so its tangent is not the derivative of its forces: "
            "gradients are of structures with a potential"
        )


def prepared(model: Any, history: Any = None) -> System:
    """A model lowered, with the history of a step."""
    system = System(model)
    if history:
        system.history = history
    return system
