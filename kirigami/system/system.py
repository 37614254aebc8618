"""System: a model lowered once into kernels, numbered, constrained and ready to be assembled.

The numbering of the unknowns is in :mod:`kirigami.system.unknowns`. Assembly goes through node blocks: each Hessian
block of each kernel adds to the block of its node pair (lower number first), and the reduced matrix picks its entries
there.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from kirigami.errors import MechanismError, ModelError
from kirigami.model.model import Model
from kirigami.primitives.checks import require_array, require_boolean, require_finite, require_instance
from kirigami.primitives.kernel import EXACT, Array, Configuration, Kernel, Tangent, hessian_blocks
from kirigami.primitives.parts import Numbering
from kirigami.system.apart import ApartKernel, kernels_apart, require_apart
from kirigami.system.assembly import BlockPlan, Index, PickPlan, compiled_largest_turn, scatter_add, twins
from kirigami.system.blocks import Blocks, more_of
from kirigami.system.clock import Clock
from kirigami.system.coupling_plan import CouplingPlan
from kirigami.system.unknowns import Unknowns

ROUNDING = 2e-15  # strain or angle [rad] that rounding alone may leave in a member


class System(Unknowns):
    """The lowered form of a model.

    Parameters
    ----------
    model : Model
        Lowered as it stands now; using the system after the model was edited raises a ModelError.
    apart : sequence of objects
        Loads and supports of the model that follow load factors of their own, as :meth:`factored` says them.

    Attributes
    ----------
    kernels : list of Kernel
        Everything that makes force.
    points : int
        Number of nodes. Displacements `u` have a row for each of them and, behind, those that elements asked for (see
        :class:`kirigami.Numbering`).
    rest : ndarray, shape (rows, dim)
        Node positions without displacement, and what the rows behind them hold then.
    free : int
        Number of unknowns.
    length, stiffness_scale, noise : float
        Median member length and stiffness, by which tolerances are made dimensionless, and the size of forces that
        are nothing but rounding at displacements of a member's length.

    Raises
    ------
    ModelError
        No nodes or elements, dangling nodes, constraints in conflict, members without length or height.

    Examples
    --------
    >>> import kirigami as kg
    >>> m = kg.Model(dim=2)
    >>> a, b = m.add(kg.Node(0, 0), kg.Node(2, 0))
    >>> objects = m.add(kg.Bar(a, b, EA=10.0), kg.Fix(a), kg.Fix(b, "y"))
    >>> float(kg.System(m).stiffness().toarray()[0, 0])
    5.0
    """

    def __init__(self, model: Model, apart: Sequence[Any] = ()) -> None:
        require_instance(model, Model, "model", "System")
        if not model.nodes:
            raise ModelError("the model has no nodes: add nodes and elements before an analysis")
        if not model.elements:
            raise ModelError("the model has no elements: add bars, hinges or springs before an analysis")
        apart = require_apart(apart, model, "apart", "System")
        self.model = model
        self.version = model.version
        self.clock = Clock()
        with self.clock("lowering"):
            rest = model.positions()[:, : model.dim].copy()
            numbering = Numbering(model.nodes, rest, model.mesh, model.sheet_constants)
            self.size, self.points = numbering.size, numbering.points
            self.kernels = self._lower(model.objects, numbering)
            self._apart: list[Sequence[ApartKernel]] = [kernels_apart(item, numbering) for item in apart]
            self.kernels += [kernel for kernels in self._apart for kernel in kernels]
            self._reach = numbering.reach[self.points :]
            super().__init__(numbering, model.constraints, apart)
            self._check_dangling(numbering)
            self._measure()
        self.twins = twins(self.kernels)
        self._limiting = [kernel for kernel in self.kernels if type(kernel).admissible is not Kernel.admissible]
        self._coupled = [kernel for kernel in self.kernels if type(kernel).coupling is not Kernel.coupling]
        if self._coupled and self.grips is not None:
            names = ", ".join(kernel.name for kernel in self._coupled)
            others = " and ".join(dict.fromkeys(group.words for group in self.grips.groups))
            raise ModelError(
                f"{names} does not go with {others}: hold and move nodes by Fix and Prescribe, a finite sheet of cells"
            )
        self.couplings = CouplingPlan(self.unknown, self.free, self.dim) if self._coupled else None
        self._blocks_plan: BlockPlan | None = None
        self._links: tuple[Index, Index, Array] | None = None
        self._pick_plan: PickPlan | None = None

    # ---- lowering

    @staticmethod
    def _lower(objects: Sequence[Any], numbering: Numbering) -> list[Kernel]:
        for item in objects:
            numbering.objects.setdefault(type(item), []).append(item)
        for cls, items in numbering.objects.items():
            cls.reserve(items, numbering)
        for cls, items in numbering.objects.items():
            numbering.kernels.extend(cls.lower(items, numbering))
        return numbering.kernels

    def _check_dangling(self, numbering: Numbering) -> None:
        touched = np.zeros(len(self.rest), dtype=bool)
        for kernel in self.kernels:
            if kernel.stores_energy:
                touched[kernel.conn.ravel()] = True
        moving = np.zeros(self.free, dtype=bool)
        unknown = self.unknown.reshape(self.rest.shape)
        moving[unknown[touched][unknown[touched] >= 0]] = True
        still = np.append(~moving, False)  # the last entry answers for known displacements, index -1
        loose = np.flatnonzero(np.any(still[unknown[: self.points]], axis=1))
        if loose.size:
            raise ModelError(
                f"{loose.size} dangling node(s) that no element holds, the first {numbering.describe(int(loose[0]))}: "
                "remove them, connect them or fix them"
            )

    def _measure(self) -> None:
        """Median member length and stiffness, and the size of forces that are nothing but rounding."""
        rest = self.configuration(np.zeros_like(self.rest))
        lengths, stiffness, rounded, exact = [], [], [], []
        for kernel in self.kernels:
            if kernel.pairs == () or not kernel.stores_energy:
                continue
            hessian = hessian_blocks(kernel, rest, 0.0)
            stiffness.append(np.sqrt((hessian.reshape(len(kernel.conn), -1) ** 2).sum(axis=1)))
            rounded.append(kernel.stiffness_of_positions(stiffness[-1]))
            exact.append(stiffness[-1] if kernel.measures_displacement else 0.0 * stiffness[-1])
            if kernel.conn.shape[1] > 1 and kernel.conn[:, :2].max(initial=0) < self.points:
                corner = self.rest[kernel.conn[:, :2]]
                lengths.append(np.linalg.norm(corner[:, 1] - corner[:, 0], axis=1))
        self.length = float(np.median(np.concatenate(lengths))) if lengths else self.size
        norms = np.concatenate(stiffness)
        self._noises = [
            ROUNDING * self.length * float(np.linalg.norm(np.concatenate(part))) for part in (rounded, exact)
        ]
        self.noise = math.hypot(*self._noises)
        norms = norms[norms > 0] if norms.any() else norms  # what is not in touch at rest says nothing
        self.stiffness_scale = float(np.median(norms))

    def _noise_at(self, u: Array) -> float:
        """Size of forces that are nothing but rounding at displacements `u` (n, dim): less for small ones."""
        small = min(float(np.abs(u).max(initial=0.0)) / self.length, 1.0)
        return math.hypot(self._noises[0], small * self._noises[1])

    def check_version(self) -> None:
        """Refuse to answer for a model that has changed since; whatever depends on displacements asks this first."""
        if self.model.version != self.version:
            raise ModelError("the model was edited after this System was made: make a new System or analysis")

    def configuration(self, u: Array) -> Configuration:
        """Current rows (rows, dim) at displacements `u` (rows, dim or 3)."""
        self.check_version()
        return Configuration(self.rest, np.asarray(u, dtype=float)[:, : self.dim])

    def parted(self, u: Array) -> tuple[Array, Array]:
        """Displacements (rows, dim) parted into those of the nodes, (n, 3), and of the rows behind them, (h, 3)."""
        full = np.zeros((len(u), 3))
        full[:, : self.dim] = u
        return full[: self.points], full[self.points :]

    def joined(self, u: Array, inner: Array) -> Array:
        """The rows (rows, dim) of displacements (n, 3) of the nodes and (h, 3) of the rows behind them."""
        if len(u) + len(inner) != len(self.rest):
            raise ModelError(
                f"these displacements are of {len(u)} nodes and {len(inner)} rows behind them, but the model has "
                f"{self.points} and {len(self.rest) - self.points}"
            )
        return np.concatenate([u, inner])[:, : self.dim]

    def settled(self, u: Array) -> Array:
        """Rows (rows, dim) for displacements (n, 3) of the nodes alone: elements guess what stands behind them, and
        the history of kernels goes on from there."""
        x = np.array(self.rest)
        x[: self.points] += np.asarray(u, dtype=float)[:, : self.dim]
        for kernel in self.kernels:
            kernel.settle(x)
        rows: Array = x - self.rest
        rows[: self.points] = np.asarray(u, dtype=float)[:, : self.dim]
        if self.grips is not None:
            self.grips.settle(rows)
        return rows

    def factored(self, factors: Array) -> float:
        """Take load factors (1 + k,), the common one and those of the k objects with their own, for what is asked next;
        the common one."""
        self.own = factors[1:]
        for kernels, factor in zip(self._apart, self.own):
            for kernel in kernels:
                kernel.factor = float(factor)
        return float(factors[0])

    # ---- evaluation

    def energies(self, u: Array, lam: float = 0.0) -> dict[str, float]:
        """Energy of each kind of kernel at displacements `u` (n, dim or 3)."""
        lam = require_finite(lam, "lam", "System.energies")
        x = self.configuration(self._checked(u, "System.energies"))
        totals: dict[str, float] = {}
        for kernel in self.kernels:
            totals[kernel.name] = totals.get(kernel.name, 0.0) + float(kernel.evaluate(x, lam, 0).energy.sum())
        return totals

    def forces(self, u: Array, lam: float, carried: bool = True) -> tuple[Array, float]:
        """Gradient of the potential (n, dim), and the root sum of squares of the unassembled forces.

        `carried` adds what follows grips onto the rows that lead.
        """
        x = self.configuration(u)
        total = np.zeros(self.rest.shape)
        squares = 0.0
        for kernel, twin in zip(self.kernels, self.twins):
            if twin is not None:
                with self.clock(f"{kernel.name} (compiled)"):
                    squares += twin.add_forces(x, lam, total)
                continue
            with self.clock(kernel.name):
                gradient = kernel.evaluate(x, lam, 1).gradient
            assert gradient is not None
            with self.clock("assembly"):
                in_memory_order = gradient.ravel(order="K")
                squares += float(in_memory_order @ in_memory_order)
                scatter_add(total, kernel.conn, gradient)
        if self.grips is not None and carried:
            self.grips.carry(total, u)
        return total, float(np.sqrt(squares))

    def imbalance(self, u: Array, lam: float) -> tuple[Array, float]:
        """Residual (free,), and its norm over the root sum of squares of the unassembled forces.

        The second is zero where the residual is nothing but rounding, as in a structure at rest.
        """
        total, scale = self.forces(u, lam)
        residual = self.reduce(total)
        size = float(np.linalg.norm(residual))
        return residual, size / scale if size > self._noise_at(u) or not np.isfinite(size) else 0.0

    def gradient(self, u: ArrayLike, lam: float = 0.0) -> Array:
        """Gradient of the total potential (n, 3) at displacements `u` (n, 3): internal minus external forces."""
        lam = require_finite(lam, "lam", "System.gradient")
        return self.parted(self.forces(self._checked(u, "System.gradient"), lam)[0])[0]

    def _checked(self, u: ArrayLike, owner: str) -> Array:
        """Displacements given by a user."""
        shapes = ((rows, columns) for rows in {self.points, len(self.rest)} for columns in {self.dim, 3})
        given = require_array(u, *shapes, name="u", owner=owner)
        behind = np.zeros((len(self.rest) - len(given), given.shape[1]))  # what elements keep there stays at rest
        return np.concatenate([given, behind])

    def potential_rate(self, u: Array, lam: float) -> float:
        """Change of the total potential with the load factor at an equilibrium: what the drive works."""
        x = self.configuration(u)
        rate = float((self.forces(u, lam)[0].ravel() * self.drive_at(lam)).sum())
        for kernel in self.kernels:
            if kernel.scaled:
                rate += float(kernel.by_load(x, lam, 0).energy.sum())
        return rate

    def load_rate(self, u: Array, lam: float, blocks: Array) -> Array:
        """Change of the residual (free,) with the load factor at fixed unknowns."""
        x = self.configuration(u)
        with self.clock("assembly"):
            drive = self.drive_at(lam).reshape(self.rest.shape)
            rate = self.multiply(blocks, drive) if drive.any() else np.zeros_like(drive)
        loads = rate if self.grips is None else np.zeros_like(rate)
        for kernel in self.kernels:
            if kernel.scaled:
                gradient = kernel.by_load(x, lam, 1).gradient
                assert gradient is not None
                scatter_add(loads, kernel.conn, gradient)
        if self.grips is not None:  # the blocks have carried the rest already
            self.grips.carry(loads, u)
            rate += loads
        return self.reduce(rate)

    def stiffness_blocks(
        self, u: Array, lam: float, tangent: Tangent = EXACT, carried: bool = True, stored: bool = False
    ) -> Array:
        """Node blocks (dim, dim, blocks) of the Hessian of the potential, or of the tangent asked for.

        In `tangent`, ``ahead`` holds displacements and a change, both (n, dim). `carried` adds what follows grips onto
        the rows that lead. `stored` leaves out what stores no energy: loads that follow, friction.
        """
        x = self.configuration(u)
        if tangent.ahead is not None:
            start, change = tangent.ahead
            tangent = Tangent(tangent.convexity, (self.configuration(start), change[:, : self.dim]))
        plan = self.plan
        with self.clock("assembly"):
            by_block = np.zeros((plan.count, self.dim, self.dim))  # side by side in memory, where compiled loops add
            blocks: Array = by_block.transpose(1, 2, 0)
        for invariant in (True, False):
            served = False
            for kernel, slots, twin in zip(self.kernels, plan.slots, self.twins):
                if kernel.translation_invariant is not invariant or (twin is None and kernel.pairs == ()):
                    continue
                if stored and not kernel.stores_energy:
                    continue
                served = True
                if twin is not None:
                    with self.clock(f"{kernel.name} (compiled)"):
                        twin.add_blocks(x, lam, tangent, slots, by_block)
                    continue
                with self.clock(kernel.name):
                    hessian = hessian_blocks(kernel, x, lam, tangent)
                with self.clock("assembly"):
                    plan.add(blocks, kernel, slots, hessian)
            if invariant and served:
                with self.clock("assembly"):
                    if any(self.twins):
                        plan.complete_compiled(by_block)
                    else:
                        plan.complete(blocks)
        if self.grips is not None and carried:
            total, _ = self.forces(u, lam)
            with self.clock("grips"):
                self.grips.condense(blocks, plan.low, plan.high, np.asarray(u), total, tangent.convexity)
        return self._coupling(blocks, x, tangent) if self._coupled else blocks

    def _coupling(self, blocks: Array, x: Configuration, tangent: Tangent) -> Array:
        """The blocks with what kernels couple beyond the plan."""
        more = None
        for kernel in self._coupled:
            with self.clock(kernel.name):
                part = kernel.coupling(x, tangent)
            if part is not None:
                more = part if more is None else more + part
        return blocks if more is None else Blocks(blocks, more)

    def multiply(self, blocks: Array, vector: Array) -> Array:
        """Product of assembled blocks with a field (n, dim)."""
        product, more = self.plan.multiply(np.asarray(blocks), vector), more_of(blocks)
        return product if more is None else product + (more @ vector.ravel()).reshape(vector.shape)

    def matrix(self, blocks: Array) -> Any:
        """Reduced stiffness matrix, scipy CSC (free, free), of assembled blocks."""
        with self.clock("assembly"):
            if self._pick_plan is None:
                self._pick_plan = PickPlan(self.plan, self.unknown, self.free, self.dim)
            matrix = self._pick_plan.matrix(np.asarray(blocks))
            return matrix if self.couplings is None else self.couplings.matrix(matrix, more_of(blocks))

    def stiffness(self, u: ArrayLike | None = None, lam: float = 0.0, constrained: bool = True) -> Any:
        """Tangent stiffness as a scipy CSC matrix.

        Parameters
        ----------
        u : array_like, shape (n, 3), optional
            Displacements; None is the rest state.
        lam : float
            Load factor.
        constrained : bool
            True: over the unknowns (free, free). False: over all displacements, index dim * node + axis.
        """
        self.check_version()
        lam = require_finite(lam, "lam", "System.stiffness")
        require_boolean(constrained, "constrained", "System.stiffness")
        state = np.zeros(self.rest.shape) if u is None else self._checked(u, "System.stiffness")
        blocks = self.stiffness_blocks(state, lam, carried=constrained)
        if constrained:
            return self.matrix(blocks)
        matrix = PickPlan(self.plan, np.arange(self.rest.size), self.rest.size, self.dim).matrix(np.asarray(blocks))
        more = more_of(blocks)
        return matrix if more is None else (matrix + more).tocsc()

    @property
    def plan(self) -> BlockPlan:
        """Where each Hessian block goes; made once, when first needed."""
        if self._blocks_plan is None:
            with self.clock("assembly plan"):
                self._blocks_plan = BlockPlan(self.kernels, len(self.rest), grips=self.grips)
        return self._blocks_plan

    def plan_with(self, low: Index, high: Index) -> tuple[BlockPlan, Index]:
        """The plan with blocks for node pairs as well, lower number first, and which blocks theirs are."""
        slots = self.plan.find(low, high)
        if slots is None:
            self._blocks_plan = BlockPlan(self.kernels, len(self.rest), low * len(self.rest) + high, self.grips)
            self._pick_plan, self._links = None, None
            slots = self._blocks_plan.find(low, high)
            assert slots is not None
        return self.plan, slots

    def largest_rotation(self, change: Array) -> float:
        """Largest relative displacement of two joined nodes over their distance, for a change (n, dim)."""
        plan = self.plan
        with self.clock("step control"):
            if self._links is None:
                self._links = plan.links(self.rest, self.points)
            low, high, distance = self._links
            behind = float(np.max(np.linalg.norm(change[self.points :], axis=1) / self._reach, initial=0.0))
            if any(self.twins):
                return max(behind, compiled_largest_turn(change, low, high, distance))
            columns = np.ascontiguousarray(change.T)
            square = ((columns[:, high] - columns[:, low]) ** 2).sum(axis=0)
            return max(behind, float(np.sqrt((square / distance**2).max(initial=0.0))))

    def admissible(self, u: Array, v: Array) -> float:
        """Largest share of the straight way from displacements `u` to `v`, both (n, dim), that the effects allow."""
        if not self._limiting:
            return 1.0
        x, y = self.configuration(u), self.configuration(v)
        share = 1.0
        for kernel in self._limiting:
            with self.clock("step control"):
                share = min(share, kernel.admissible(x, y))
        return share

    def check_start(self, u: Array) -> None:
        """Raise a ModelError where an effect forbids displacements `u` (n, dim) as a start."""
        for kernel in self._limiting:
            kernel.check_start(self.configuration(u))

    @property
    def conservative(self) -> bool:
        """Whether all forces have a potential."""
        return all(kernel.conservative for kernel in self.kernels)

    # ---- history

    def begin(self, share: float) -> None:
        """Let this share be there of what acts whatever the load factor: constant loads, heat and supports."""
        self.begun = share
        for kernel in self.kernels:
            kernel.begun = share

    def commit(self, u: Array, lam: float = 0.0) -> None:
        """Accept displacements `u` (n, dim or 3) as an equilibrium at a load factor: history-dependent kernels move
        on."""
        x = self.configuration(u)
        for kernel in self.kernels:
            with self.clock(kernel.name):
                kernel.commit_at(x, lam)

    def go_on_from(self, history: tuple[Array | None, ...], u: Array, lam: float, new_stage: bool) -> None:
        """Take the history of a step as the present one; kernels that it says nothing of begin at displacements `u`."""
        x = self.configuration(u)
        for kernel, value in zip(self.kernels, self._shared_out(history)):
            kernel.history = value
            if value is None:
                kernel.commit_at(x, lam)
            elif new_stage:
                kernel.start_stage()

    def revert(self) -> None:
        """Forget everything since the last commit."""
        for kernel in self.kernels:
            kernel.revert()

    @property
    def history(self) -> tuple[Array | None, ...]:
        """Committed state of each kernel, to store with a step and to go back to."""
        return tuple(None if kernel.history is None else kernel.history.copy() for kernel in self.kernels)

    @history.setter
    def history(self, values: tuple[Array | None, ...] | None) -> None:
        for kernel, value in zip(self.kernels, self._shared_out(values or ())):
            kernel.history = value

    def _shared_out(self, history: tuple[Array | None, ...]) -> list[Array | None]:
        """The state of each kernel among those that a step remembers, None where it says nothing of one.

        What a stage adds or takes away, or another model, moves kernels to other places: then each takes the first
        state left that can be its own.
        """
        if len(history) == len(self.kernels) and all(
            value is None or kernel.fits(value) for kernel, value in zip(self.kernels, history)
        ):
            return list(history)
        left, found = [value for value in history if value is not None], list[Array | None]()
        for kernel in self.kernels:
            place = next((k for k, value in enumerate(left) if kernel.fits(value)), None)
            found.append(None if place is None else left.pop(place))
        return found

    # ---- supports

    def check_supports(self) -> None:
        """Raise a MechanismError that names every rigid motion the constraints leave to a connected part."""
        from kirigami.system.supports import free_rigid_motions

        self.check_version()
        with self.clock("checks"):
            found = free_rigid_motions(self)
        if found:
            motion, nodes, message = found
            raise MechanismError(message, motion=motion, nodes=nodes)
