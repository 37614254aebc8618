"""Strain and curvature that a sheet takes by itself: heat, swelling, prestretch, layers that do not fit.

A facet with strain e and curvature k bears forces and moments by what they are beyond the natural e_0 and k_0:

    energy  A ((e - e_0, k - k_0) . section . (e - e_0, k - k_0)) / 2

Heat by dT makes e_0 = alpha dT (1, 1, 0), and a rise of dT over the thickness t makes k_0 = -alpha dT / t (1, 1, 0)
where the side of the normal is the warmer one. Two equal layers of thickness t / 2 whose free strains differ by d bend
to k_0 = 3 d / (2 t) (Timoshenko, J. Opt. Soc. Am. 11 (1925), 233).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kirigami.elements.shell_kernel import ShellFacetKernel
from kirigami.errors import ModelError
from kirigami.model.spread_loads import Surface, _facets
from kirigami.primitives.checks import require_array, require_boolean, require_finite
from kirigami.primitives.kernel import Array, Kernel
from kirigami.primitives.material import Laminate
from kirigami.primitives.node import Node
from kirigami.primitives.parts import ModelObject, Numbering

Index = NDArray[np.int64]


@dataclass(frozen=True, slots=True, eq=False, repr=False, init=False)
class Actuate(ModelObject):
    """Gives facets of the shell rung a strain and a curvature of their own, at which they bear nothing.

    Several on one facet add up. A model that only this drives needs no load.

    Parameters
    ----------
    facets : str or array_like of int, optional
        Name of a region of the mesh, or numbers of facets; None is the whole sheet.
    strain : array_like, shape (3,)
        (exx, eyy, gamma_xy) at load factor 1, in the axes of the drawing.
    curvature : array_like, shape (3,)
        (kxx, kyy, 2 kxy) at load factor 1 [1 / length]; kxx > 0 curves a flat sheet towards its normal.
    constant : bool
        They are there in full whatever the load factor.

    Raises
    ------
    ModelError
        Values that are no three numbers, or all zero; in a run facets that are not there, or a rung other than "shell".

    Examples
    --------
    >>> import kirigami as kg
    >>> mesh = kg.Sheet([(0, 0), (4, 0), (4, 1), (0, 1)]).mesh(0.8)
    >>> m = kg.Model.from_mesh(mesh, thickness=0.05, material=kg.Material(E=1e6), stiffness="shell")
    >>> held = m.add(kg.Fix(m.nodes[0]), kg.Fix(m.nodes[1], "yz"), kg.Fix(m.nodes[2], "z"))
    >>> heat = m.add(kg.Actuate(strain=(0.01, 0.01, 0)))
    >>> res = kg.LoadControl(m).run()
    >>> round(float(res.width("y")[-1]), 3), bool(max(sum(res.energy.values())) < 1e-12)
    (4.04, True)
    """

    kind: ClassVar[str] = "effect"
    facets: Index | str | None
    strain: tuple[float, float, float]
    curvature: tuple[float, float, float]
    constant: bool

    def __init__(
        self,
        facets: str | ArrayLike | None = None,
        strain: ArrayLike = (0.0, 0.0, 0.0),
        curvature: ArrayLike = (0.0, 0.0, 0.0),
        constant: bool = False,
    ) -> None:
        object.__setattr__(self, "facets", _facets(facets, "Actuate"))
        for name, value in (("strain", strain), ("curvature", curvature)):
            object.__setattr__(self, name, tuple(require_array(value, (3,), name=name, owner="Actuate").tolist()))
        if not any(self.strain + self.curvature):
            raise ModelError("Actuate: give a strain or a curvature other than zero")
        object.__setattr__(self, "constant", require_boolean(constant, "constant", "Actuate"))

    @property
    def nodes(self) -> tuple[Node, ...]:
        return ()

    def held(self, lam: float) -> Actuate:
        """The same, constant at load factor `lam`."""
        lam = require_finite(lam, "lam", "Actuate.held")
        if self.constant or lam == 0:
            return self
        strain, curvature = (np.multiply(lam, values) for values in (self.strain, self.curvature))
        return Actuate(self.facets, strain, curvature, constant=True)

    @classmethod
    def lower(cls, objects: Sequence[Any], numbering: Numbering) -> list[Kernel]:
        """Nothing is made: the facets themselves are told."""
        shells = [kernel for kernel in numbering.kernels if isinstance(kernel, ShellFacetKernel)]
        if not shells or numbering.mesh is None:
            raise ModelError(
                f"{objects[0]!r} needs the sheet of a mesh with stiffness='shell': other rungs have no strain of their "
                "own; drive their bars by target_length and their hinges by target_angle"
            )
        if numbering.sheet is not None:
            _, materials = numbering.sheet.material_of_facets(len(numbering.mesh.triangles))
            if any(isinstance(material, Laminate) for material in materials):
                raise ModelError(
                    f"{objects[0]!r}: the layers of a Laminate would each have a strain of their own, which is not "
                    "known; give the sheet a Material or Orthotropic"
                )
        surface = Surface(numbering, "Actuate")
        size = len(numbering.rest)
        for item in objects:
            facets = surface.chosen(item.facets, repr(item))
            wanted = _codes(surface.triangles[facets], size)
            found = 0
            for kernel in shells:
                rows = np.flatnonzero(np.isin(_codes(kernel.conn[:, :3], size), wanted))
                local = _turned(numbering.rest[kernel.conn[rows, :3]], np.array(item.strain), np.array(item.curvature))
                kernel.actuate(rows, local, item.constant)
                found += len(rows)
            if found < len(facets):
                raise ModelError(f"{item!r}: {len(facets) - found} of its facets were taken out of the model")
        return []

    def __repr__(self) -> str:
        where = "the whole sheet" if self.facets is None else (
            repr(self.facets) if isinstance(self.facets, str) else f"{len(self.facets)} facets"
        )
        return f"Actuate({where}, strain={self.strain}, curvature={self.curvature})"


def _codes(triangles: Index, size: int) -> Index:
    """One number (m,) for the corners of each facet, in whatever order."""
    low, middle, high = np.sort(triangles, axis=1).T
    return np.asarray((low * size + middle) * size + high)


def _turned(corners: Array, strain: Array, curvature: Array) -> Array:
    """Strain and curvature (m, 6) in the axes of facets (m, 3, 3), the first along the edge 01."""
    first = corners[:, 1] - corners[:, 0]
    first /= np.linalg.norm(first, axis=1)[:, None]
    normal = np.cross(first, corners[:, 2] - corners[:, 0])
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    second = np.cross(normal, first)
    found = np.empty((len(corners), 6))
    for part, (xx, yy, xy) in enumerate((strain, curvature)):
        tensor = np.array([[xx, xy / 2, 0.0], [xy / 2, yy, 0.0], [0.0, 0.0, 0.0]])
        columns = [(first, first, 1.0), (second, second, 1.0), (first, second, 2.0)]
        for column, (a, b, factor) in enumerate(columns):
            found[:, 3 * part + column] = factor * np.einsum("na,ab,nb->n", a, tensor, b)
    return found
