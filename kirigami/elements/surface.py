"""What kernels of facets tell of their state, whatever the facets are: the base of them all."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from kirigami.elements.natural import NaturalKernel, derived
from kirigami.errors import ModelError
from kirigami.primitives.kernel import Array, Kernel


class SurfaceKernel(NaturalKernel):
    """Base of the kernels whose members are facets of a sheet.

    Attributes
    ----------
    section : ndarray, shape (n, 6, 6)
        Forces and moments per length by strain and curvature, at rest.
    uniform : bool
        True where strain and curvature are the same all over a facet, else they are linear over it.
    bends_by_folds : bool
        True where moments are those of the folds between facets, :meth:`fold_moments`, and curvature is what the
        surface has.
    plate_theory : bool
        True where forces and moments are the section times what is felt beyond :meth:`natural`, as long as the law is
        linear, so that strain and curvature of their own are told as they are.
    linear_law : bool
        False where the law is none: then :meth:`borne_deformation` tells.
    """

    surface = True
    rest: Array
    section: Array
    uniform = True
    bends_by_folds = False
    plate_theory = False
    linear_law = True

    def on_rest(self, rest: Array) -> SurfaceKernel:
        """The same facets on a rest state (rows, dim) whose nodes lie elsewhere in the plane: grain and strains of
        their own do not turn with the facets."""
        raise ModelError(f"{self.name!r} does not know its facets on another rest state: its kernel defines no on_rest")

    def grown(self, members: NDArray[np.int64], values: Array) -> Array:
        """Strain and curvature (k, 6), as :meth:`deformation` has them, at which facets bear nothing whose layers have
        a strain, and a curvature beside it."""
        return values

    def actuate_facets(self, members: NDArray[np.int64], values: Array, folds: Array, constant: bool) -> None:
        """Add strain and curvature (k, 6) in the axes of facets, or in the place of the curvature the angles (k, 3) of
        the folds opposite their corners, to what `members` bear nothing at."""
        self.actuate(members, values, constant)

    def warm(self, facets: NDArray[np.int64], heat: Array, constant: bool) -> None:
        """Note the heat (k, 2) at the lower and upper faces of facets; those of one layer need not know."""

    def borne_deformation(self, x: Array, lam: float) -> Array:
        """Strain and curvature (n, k, 6) whose forces by the section are those borne."""
        fields, natural = self.corner_deformation(x), self.natural(lam)
        return fields if natural is None else np.asarray(fields - natural[:, None])

    def natural_deformation(self, lam: float) -> Array | None:
        """Strain and curvature (n, 6), as :meth:`deformation` has them, at which facets bear nothing; None for zero."""
        return None

    def heat(self, lam: float) -> Array | None:
        """Heat (n, 2) at the lower and upper faces at a load factor; None where there is none."""
        return None

    def corner_deformation(self, x: Array) -> Array:
        """Strain and curvature (n, k, 6) at the three corners of each facet, or once where they are uniform."""
        return self.deformation(x)[:, None]

    def fold_moments(self, x: Array, lam: float) -> Array:
        """Moment (n, 3) of each facet on its folds, opposite its corners."""
        return np.zeros((len(self.conn), 3))

    def membrane_energy(self, x: Array, lam: float) -> Array:
        """The energy (n,) that stretching stores; nan where it is the quadratic form of the section."""
        return np.full(len(self.conn), np.nan)

    def layer_stress(self, x: Array, lam: float) -> tuple[NDArray[np.int64], Array]:
        """Facets (k,) whose stress is not linear over the thickness, and that (k, layers, 3) from the lower face to the
        upper one."""
        return np.zeros(0, np.int64), np.zeros((0, 2, 3))


def surfaces_of(kernels: Iterable[Kernel], owner: str) -> list[SurfaceKernel]:
    """The kernels of facets, see :func:`derived`."""
    return derived(kernels, SurfaceKernel, lambda kernel: kernel.surface, owner)


def squares_over(fields: Array) -> Array:
    """Values (n, j, 6) whose products, summed up, are the means over facets of products of `fields` (n, k, 6), which
    are uniform (k = 1), or linear and given at the corners (k = 3)."""
    if fields.shape[1] == 1:
        return fields
    return np.asarray(np.concatenate([fields, fields.sum(axis=1, keepdims=True)], axis=1) / np.sqrt(12))
