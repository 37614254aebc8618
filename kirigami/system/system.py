"""System: a model lowered once, ready to be assembled: energies, forces and stiffness at displacements.

Assembly goes through node blocks: each Hessian block of each kernel adds to the block of its node pair (lower number
first), and the reduced matrix picks its entries there.
"""

from __future__ import annotations

import copy
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from kirigami.errors import MechanismError, ModelError
from kirigami.model.model import Model
from kirigami.primitives.checks import require_array, require_boolean, require_finite
from kirigami.primitives.kernel import EXACT, Array, Configuration, Kernel, Tangent, hessian_blocks
from kirigami.system.assembly import BlockPlan, Index, PickPlan, compiled_largest_turn, scatter_add, twins
from kirigami.system.blocks import Blocks, more_of
from kirigami.system.coupling_plan import CouplingPlan
from kirigami.system.lowered import Lowered


class System(Lowered):
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
        super().__init__(model, apart)
        self.twins = twins(self.kernels)
        self._limiting = [kernel for kernel in self.kernels if type(kernel).admissible is not Kernel.admissible]
        self._coupled = [kernel for kernel in self.kernels if type(kernel).coupling is not Kernel.coupling]
        repeated = [group.words for group in self.grips.groups if group.one_of_many] if self.grips is not None else []
        if self._coupled and repeated:
            names = ", ".join(kernel.name for kernel in self._coupled)
            raise ModelError(
                f"{names} does not go with {' and '.join(dict.fromkeys(repeated))}, whose neighbours are not there to "
                "be touched: take a finite sheet"
            )
        self.couplings = CouplingPlan(self.unknown, self.free, self.dim) if self._coupled else None
        self._blocks_plan: BlockPlan | None = None
        self._links: tuple[Index, Index, Array] | None = None
        self._pick_plan: PickPlan | None = None

    @property
    def memory(self) -> dict[str, Any]:
        """What a run that was interrupted needs beside the history of kernels to go on to the last bit."""
        return {} if self.couplings is None else {"couplings": self.couplings.pairs}

    def remember(self, memory: Mapping[str, Any]) -> None:
        """Take over what the :attr:`memory` of the run that was interrupted held."""
        if self.couplings is not None:
            self.couplings.remember(memory.get("couplings", ()))

    # ---- evaluation

    def energies(self, u: Array, lam: float = 0.0) -> dict[str, float]:
        """Energy of each kind of kernel at displacements `u` (n, dim or 3)."""
        lam = require_finite(lam, "lam", "System.energies")
        x = self.configuration(self._checked(u, "System.energies"))
        totals: dict[str, float] = {}
        for kernel, twin in zip(self.kernels, self.twins):
            energy = float(kernel.evaluate(x, lam, 0).energy.sum()) if twin is None else twin.energy(x, lam)
            totals[kernel.name] = totals.get(kernel.name, 0.0) + energy
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
        return self.load_rate_beside(self.drive_rate(lam, blocks), u, lam)

    def drive_rate(self, lam: float, blocks: Array) -> Array:
        """The part (n, dim) of :meth:`load_rate` that comes from what is driven: all that is asked of the blocks."""
        with self.clock("assembly"):
            drive = self.drive_at(lam).reshape(self.rest.shape)
            return self.multiply(blocks, drive) if drive.any() else np.zeros_like(drive)

    def load_rate_beside(self, drive_rate: Array, u: Array, lam: float) -> Array:
        """What :meth:`load_rate` is (free,), with the part of it that :meth:`drive_rate` gives known."""
        x, rate = self.configuration(u), drive_rate.copy()
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
        if not self._coupled:
            return blocks
        more = self._coupling(x, tangent)
        if more is not None and self.grips is not None and carried:
            chain = self.grips.chain(np.asarray(u))
            more = chain.T @ more @ chain
        return blocks if more is None else Blocks(blocks, more)

    def _coupling(self, x: Configuration, tangent: Tangent) -> Any:
        """What kernels couple beyond the plan, as a sparse matrix over all displacements; None where nothing does."""
        more = None
        for kernel in self._coupled:
            with self.clock(kernel.name):
                part = kernel.coupling(x, tangent)
            if part is not None:
                more = part if more is None else more + part
        return more

    def multiply(self, blocks: Array, vector: Array, sizes: bool = False) -> Array:
        """Product of assembled blocks with a field (n, dim), or of the sizes of both, without what couples beyond."""
        if sizes:
            return self.plan.multiply(np.asarray(blocks), vector, sizes)
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

    # ---- a part of it

    @property
    def comes_apart(self) -> bool:
        """Whether some unknowns can be looked at by themselves: what grips lead and effects couple or forbid is not in
        one place, and what remembers its way is not to go two."""
        together = self._limiting or self._coupled or self.grips is not None
        return not together and self.conservative and not any(kernel.path_dependent for kernel in self.kernels)

    def part(self, unknowns: Index, u: Array) -> System:
        """The system of some `unknowns` (k,) alone; all others stay where displacements `u` (n, dim) have them."""
        part = copy.copy(self)
        number = np.full(self.free + 1, -1)  # the last entry answers for known displacements, index -1
        number[unknowns] = np.arange(len(unknowns))
        part.unknown, part.free, part.heads = number[self.unknown], len(unknowns), self.heads[unknowns]
        moving = np.asarray(part.unknown >= 0)
        part.held, part.drive, part.begun = u.ravel().copy(), np.zeros_like(self.drive), 1.0
        part.held[moving] -= u.ravel()[part.heads][part.unknown[moving]]
        part.arcs, part._moved_apart = [], []
        part.kernels, part.twins = [], []
        rows = np.asarray(moving.reshape(self.rest.shape).any(axis=1))
        for kernel, twin in zip(self.kernels, self.twins):
            members = np.flatnonzero(rows[kernel.conn].any(axis=1))
            if len(members):
                own = kernel.part(members)
                part.kernels.append(own)
                part.twins.append(None if twin is None else twin if own is kernel else own.compiled())
        part._blocks_plan, part._pick_plan, part._links = None, None, None
        return part

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
