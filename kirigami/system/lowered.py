"""A model lowered once: its kernels, the rows of its displacements, the sizes it is judged by, and what it remembers.

The numbering of the unknowns is in :mod:`kirigami.system.unknowns`, what is asked at displacements in
:mod:`kirigami.system.system`.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from kirigami.errors import ModelError
from kirigami.model.model import Model
from kirigami.primitives.checks import require_instance
from kirigami.primitives.kernel import Array, Configuration, Kernel
from kirigami.primitives.parts import Numbering
from kirigami.system.apart import ApartKernel, kernels_apart, require_apart
from kirigami.system.clock import Clock
from kirigami.system.unknowns import Unknowns
from kirigami.words import counted

ROUNDING = 2e-15  # strain or angle [rad] that rounding alone may leave in a member


class Lowered(Unknowns):
    """What :class:`kirigami.System` is made of a model, before anything is asked of it."""

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
                f"{counted(loose.size, 'dangling node')} that no element holds, the first "
                f"{numbering.describe(int(loose[0]))}: remove them, connect them or fix them"
            )

    def _measure(self) -> None:
        """Median member length and stiffness, and the size of forces that are nothing but rounding."""
        rest = self.configuration(np.zeros_like(self.rest))
        lengths, stiffness, rounded, exact = [], [], [], []
        for kernel in self.kernels:
            if kernel.pairs == () or not kernel.stores_energy:
                continue
            stiffness.append(kernel.stiffness_size(rest, 0.0))
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
                f"these displacements are of {counted(len(u), 'node')} and {counted(len(inner), 'row')} behind them, "
                f"but the model has {self.points} and {len(self.rest) - self.points}"
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
