"""Smoother strain and curvature than the elements have, and the energy of what lies between the two.

What elements say of strain and curvature jumps from facet to facet; the exact ones do not. Their means over the facets
round each node, linear in between, are nearer to the truth, and the difference is taken for the error (Zienkiewicz and
Zhu, 1987). Nothing is averaged across cuts, folds, or between facets whose sections jump
(:mod:`kirigami.results.smooth`).
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from kirigami.elements.surface import SurfaceKernel, surfaces_of
from kirigami.elements.triangle import SurfaceStrain
from kirigami.primitives.kernel import Array
from kirigami.results.results import Results
from kirigami.results.sheet_state import SheetState, StateReader, placed, state_reader
from kirigami.results.smooth import sectors
from kirigami.results.step import Step

if TYPE_CHECKING:
    from kirigami.geometry.mesh import TriMesh

Index = NDArray[np.int64]
MEMBRANE, BENDING = slice(0, 3), slice(3, 6)
ENGINEERING = np.array([1.0, 1.0, 2.0])


class Recovery:
    """Deformation of a sheet at the corners of its facets, and how far it is from a smooth one.

    Fields have the shape (m, 3, 6): at the three corners of every facet (exx, eyy, gamma_xy, kxx, kyy, 2 kxy), the
    first axis along the edge from its first corner to its second.

    Attributes
    ----------
    area : ndarray, shape (m,)
        Areas of the facets at rest [length^2].
    section : ndarray, shape (m, 6, 6)
        Forces and moments per length of a unit deformation, by plate theory.
    patch : ndarray of int, shape (m, 3)
        Which corners of facets share their smooth values.
    """

    def __init__(self, results: Results, mesh: TriMesh) -> None:
        self.results, self.mesh = results, mesh
        self.surface = SurfaceStrain(results.rest, mesh.triangles)
        self.area = self.surface.area
        plates = [kernel for kernel in surfaces_of(results.kernels, "error") if kernel.plate_theory]
        self.shell: SurfaceKernel | None = plates[0] if len(plates) == 1 else None
        self.section = self._sections()
        self.patch = sectors(results).corner
        corners = results.rest[mesh.triangles]
        along, across = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
        first = along / np.linalg.norm(along, axis=1)[:, None]
        second = across - (across * first).sum(axis=1)[:, None] * first
        self.axes = np.stack([first, second / np.linalg.norm(second, axis=1)[:, None]], axis=1)  # (m, 2, 3)
        self.weight = np.repeat(self.area, 3)

    def _sections(self) -> Array:
        """Sections of the facets, by plate theory."""
        if self.shell is not None:
            self.row = placed(self.mesh.triangles, self.shell.conn[:, :3])
            if (self.row >= 0).all():
                return np.asarray(self.shell.section[self.row])
            self.shell = None
        constants = self.results.sheet_constants
        assert constants is not None
        return constants.sections(len(self.mesh.triangles))

    @property
    def reader(self) -> StateReader:
        return state_reader(self.results, self.mesh)

    @property
    def patterned(self) -> bool:
        """Whether strains jump in the pattern of the mesh: those of bars, which know no facets."""
        return self.shell is None and not any(kernel.surface for kernel in self.results.kernels)

    def state(self, step: Step) -> SheetState | None:
        """What the elements bear, on rungs that do not obey plate theory themselves."""
        return None if self.shell is not None else self.reader.at(step)

    def fields(self, step: Step, state: SheetState | None = None) -> Array:
        """The deformation (m, 3, 6) as the elements have it at a step, beyond what they take by themselves."""
        if self.shell is not None:
            told: Array = self.results.told(self.shell, step, self.shell.corner_deformation)[self.row]
            natural = self.shell.natural(step.lam)
            return told if natural is None else told - natural[self.row, None]
        flat = np.zeros((len(self.area), 6))
        flat[:, MEMBRANE] = self.surface.at(step.u, self.results.linear)
        if state is not None:
            turn = self.reader.turn
            local = turn @ state.curvature @ turn.transpose(0, 2, 1)
            flat[:, BENDING] = np.stack([local[:, 0, 0], local[:, 1, 1], 2 * local[:, 0, 1]], axis=1)
        return np.repeat(flat[:, None], 3, axis=1)

    def borne(self, step: Step, fields: Array) -> Array:
        """The deformation (m, 3, 6) whose forces by plate theory are those borne: `fields` where the law is linear."""
        if self.shell is None or self.shell.linear_law:
            return fields
        shell = self.shell
        told: Array = self.results.told(shell, step, lambda x: shell.borne_deformation(x, step.lam))[self.row]
        return told

    def lost(self, step: Step, fields: Array) -> tuple[Array, Array]:
        """Energy (m,) of each facet between the deformation and a smooth one, of stretching and of bending.

        By a convex law W it lies between nothing and the work w = (N(s) - N(e)).(s - e), for whose N(s) stand the
        smooth forces: half of w where the law is linear, all of it where the force no longer grows, as beyond yield.
        Between these it is told by w over that of the section at rest.
        """
        beyond, borne = self.smooth(fields) - fields, self.borne(step, fields)
        elastic = self.work(beyond, beyond)
        if borne is fields:
            return 0.5 * elastic[0], 0.5 * elastic[1]
        found = []
        for work, at_rest in zip(self.work(self.smooth(borne) - borne, beyond), elastic):
            firm = np.divide(work, at_rest, out=np.ones_like(work), where=at_rest > 0)
            found.append((1 - 0.5 * np.clip(firm, 0.0, 1.0)) * work)
        return found[0], found[1]

    def rate(self, step: Step, change: Array) -> Array:
        """Change (m, 3, 6) of the deformation with a change (rows, dim) of all displacements."""
        largest = float(np.abs(change).max(initial=0.0))
        share = 1e-4 * self.mesh.size / largest if largest > 0 else 1.0
        count = len(self.results.rest)
        ends = []
        for sign in (share, -share):
            u, inner = step.u.copy(), step.inner.copy()
            u[:, : self.results.dim] += sign * change[:count]
            if len(inner):
                inner[:, : self.results.dim] += sign * change[count:]
            moved = replace(step, u=u, inner=inner)
            ends.append(self.fields(moved, self.state(moved)))
        return np.asarray((ends[0] - ends[1]) / (2 * share))

    def smooth(self, fields: Array) -> Array:
        """The smooth deformation (m, 3, 6)."""
        mean = np.empty_like(fields)
        for part in (MEMBRANE, BENDING):
            xx, yy, xy = np.moveaxis(fields[..., part] / ENGINEERING, -1, 0)
            local = np.stack([np.stack([xx, xy], axis=-1), np.stack([xy, yy], axis=-1)], axis=-2)
            placed_tensor = self.axes.transpose(0, 2, 1)[:, None] @ local @ self.axes[:, None]
            flat = placed_tensor.reshape(-1, 9)
            patch = self.patch.ravel()
            total = np.bincount(patch, self.weight)
            means = np.stack([np.bincount(patch, self.weight * column) / total for column in flat.T], axis=1)
            back = self.axes[:, None] @ means[self.patch].reshape(-1, 3, 3, 3) @ self.axes.transpose(0, 2, 1)[:, None]
            mean[..., part] = np.stack([back[..., 0, 0], back[..., 1, 1], 2 * back[..., 0, 1]], axis=-1)
        return mean

    def work(self, one: Array, other: Array) -> tuple[Array, Array]:
        """Integrals (m,) over each facet of one.C.other, of stretching and of bending; without what couples them."""
        found = []
        for part in (MEMBRANE, BENDING):
            force = one[..., part] @ self.section[:, part, part]
            both = (force * other[..., part]).sum(axis=(1, 2))
            both += (force.sum(axis=1) * other[..., part].sum(axis=1)).sum(axis=1)
            found.append(self.area / 12 * both)
        return found[0], found[1]
