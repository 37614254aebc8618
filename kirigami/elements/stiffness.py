"""The rungs of accuracy: from a mesh and a material to elements and their constants.

The rungs, from cheap to accurate, all on the same mesh:

* "paper", "plate" or a Calibration: bars and hinges, three unknowns a node. They fix Poisson's ratio at about 1/3 in
  the plane and -1/3 in bending, so that twisting costs twice what it should; refinement does not change that.
* "facet": the edges of a facet stretch and fold together, three unknowns a node. Uniform strain is exact for any
  Poisson ratio; bending and twisting are right within some percent on good meshes.
* "shell": six-node facets with two angles an edge, eighteen unknowns a node, of which only corners are seen. Exact for
  uniform strain and curvature on any mesh, in tension and at folds too, of third to fourth order for plates; see
  :mod:`kirigami.elements.shell_facet`. "split", which had normals at the nodes, is an old name of it.

The constants of bars and hinges: with facet areas A, edge length L, thickness t and material (E, nu):

* bars    EA = (sum of F_s E t A over the one or two facets of the edge) / L
* hinges  k = L^2 / (A1 / (c E t^3)_1 + A2 / (c E t^3)_2), the total of the edge

"plate" takes F_s = 1, the triangulated-membrane rule of Van Gelder (1998), which is exact for equilateral facets at
nu = 1/3, and c = 1 / (12 (1 - nu^2)), which makes cylindrical bending exact on equilateral and on leg-aligned
right-angled facets (Seung and Nelson, 1988). "paper" takes the published F_s = 0.85, c = 0.125 / 48, which is
about 36 times softer in bending than the material; it is kept to reproduce the publication.
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from kirigami.deferred import deferred
from kirigami.errors import ModelError
from kirigami.primitives.checks import require_array, require_choice, require_instance, require_positive
from kirigami.primitives.kernel import Array
from kirigami.primitives.material import SheetMaterial, each_section

if TYPE_CHECKING:
    from kirigami.geometry.mesh import TriMesh

RUNGS = ("paper", "plate", "facet", "shell")  # from cheap to accurate
ALIASES = {"split": "shell"}  # names of earlier versions
Constant = float | Array  # of the whole sheet, or of each facet


def rung_named(stiffness: str, owner: str) -> str:
    """The rung of a name, also of an earlier version's, or a ModelError with the names there are."""
    if not (isinstance(stiffness, str) and stiffness in ALIASES):
        return require_choice(stiffness, RUNGS, "stiffness", owner)  # an old name is taken, but not proposed
    new = ALIASES[stiffness]
    warnings.warn(f"{owner}: {stiffness!r} is an old name, use stiffness={new!r}", DeprecationWarning, stacklevel=3)
    return new


@dataclass(frozen=True)
class Calibration:
    """Factors of your own for the constants of bars and hinges, in the place of "plate" or "paper".

    Bars have EA = F_s E t (A1 + A2) / L, hinges k = c E t^3 L^2 / (A1 + A2), with the areas of the facets at an edge of
    length L (:mod:`kirigami.stiffness`).

    Parameters
    ----------
    F_s : float
        Factor of the bar stiffness.
    c : float
        Factor of the hinge stiffness; plate theory has 1 / (12 (1 - nu^2)).

    Raises
    ------
    ModelError
        A factor is not positive and finite.

    Examples
    --------
    >>> import kirigami as kg
    >>> kg.Calibration(F_s=1.0, c=0.09)
    Calibration(F_s=1.0, c=0.09)
    """

    F_s: float
    c: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "F_s", require_positive(self.F_s, "F_s", "Calibration"))
        object.__setattr__(self, "c", require_positive(self.c, "c", "Calibration"))

    @classmethod
    def named(cls, stiffness: str | Calibration, material: SheetMaterial) -> Calibration:
        """The calibration of a name for an isotropic material, or the one given."""
        require_instance(material, SheetMaterial, "material", "Calibration.named")
        if isinstance(stiffness, Calibration):
            return stiffness
        if not (isinstance(stiffness, str) and stiffness in ALIASES):
            require_choice(stiffness, RUNGS, "stiffness", "Model.from_mesh", or_else="a Calibration(F_s, c)")
        if stiffness == "paper":
            return cls(F_s=0.85, c=0.125 / 48)
        return cls(F_s=1.0, c=_plate_factor(getattr(material, "nu", 0.0)))


def _plate_factor(nu: float) -> float:
    """The factor c of plate theory."""
    return 1 / (12 * (1 - nu**2))


@dataclass(frozen=True, eq=False)
class SheetConstants:
    """The calibration a model was made with, and what it was applied to.

    Attributes
    ----------
    calibration : Calibration
        That of the rung; "plate" takes the c of each facet's own Poisson ratio.
    thickness : float or ndarray, shape (m,)
        One for the whole sheet, or one for each facet [length].
    material : SheetMaterial or tuple of SheetMaterial
        One for the whole sheet, or one for each facet.
    rung : str
        Name of the rung of accuracy, "calibration" for own factors.
    """

    calibration: Calibration
    thickness: float | Array
    material: SheetMaterial | tuple[SheetMaterial, ...]
    rung: str = "calibration"

    @property
    def materials(self) -> tuple[SheetMaterial, ...]:
        """Every material there is, each once."""
        return self.material_of_facets(1)[1]

    def material_of_facets(self, count: int) -> tuple[NDArray[np.int64], tuple[SheetMaterial, ...]]:
        """Number (count,) of the material of each facet, and the materials."""
        if isinstance(self.material, SheetMaterial):
            return np.zeros(count, np.int64), (self.material,)
        known = {material: number for number, material in enumerate(dict.fromkeys(self.material))}
        return np.array([known[material] for material in self.material]), tuple(known)

    def thickness_of_facets(self, count: int) -> Array:
        """Thickness (count,) of each facet."""
        return np.broadcast_to(np.asarray(self.thickness, dtype=float), (count,))

    def sections(self, count: int) -> Array:
        """Section matrices (count, 6, 6) of the facets in the axes of the drawing."""
        return each_section(self.thickness_of_facets(count), *self.material_of_facets(count))

    def of_facets(self, name: str) -> float | Array:
        """A constant of an isotropic material ("E", "nu"), or the factor "c": one, or one for each facet (m,)."""
        if name == "c":
            if self.rung in ("calibration", "paper"):
                return self.calibration.c
            nu = self.of_facets("nu")
            return _plate_factor(nu) if isinstance(nu, float) else 1 / (12 * (1 - nu**2))
        if isinstance(self.material, SheetMaterial):
            return float(getattr(self.material, name))
        return np.array([getattr(material, name) for material in self.material])

    def mass_per_area(self, count: int) -> Array | None:
        """Mass per area (count,) of each facet, None where a density is not known."""
        number, materials = self.material_of_facets(count)
        thickness = self.thickness_of_facets(count)
        found = np.empty(count)
        for position, material in enumerate(materials):
            if material.density is None:
                return None
            found[number == position] = material.density
        return np.asarray(found * thickness)


def bar_stiffness(mesh: TriMesh, thickness: Constant, E: Constant, F_s: Constant) -> Array:
    """EA of each mesh edge (edges,) [force]; constants of the sheet, or of each facet (m,)."""
    factor = _facet_factor("bar_stiffness", mesh, 1, thickness=thickness, E=E, F_s=F_s)
    return _facet_sum(mesh, mesh.facet_areas * factor) / mesh.edge_lengths


def hinge_stiffness(mesh: TriMesh, thickness: Constant, E: Constant, c: Constant) -> Array:
    """Rotational stiffness of each mesh edge (edges,) [force length / rad]; meaningful for inner edges.

    Both facets bend by the same moment, each by its own stiffness. Constants of the sheet, or of each facet (m,).
    """
    factor = _facet_factor("hinge_stiffness", mesh, 3, thickness=thickness, E=E, c=c)
    return mesh.edge_lengths**2 / _facet_sum(mesh, mesh.facet_areas / factor)


def _check_mesh(mesh: TriMesh, owner: str) -> None:
    from kirigami.geometry.mesh import TriMesh  # a truss needs none

    require_instance(mesh, TriMesh, "mesh", owner, "make one with Sheet.mesh or TriMesh")


def _facet_factor(owner: str, mesh: TriMesh, power: int, thickness: Constant, **others: Constant) -> Array:
    """Product (m,) of the constants of each facet, the thickness to a power."""
    _check_mesh(mesh, owner)
    count = len(mesh.triangles)
    product = np.ones(count)
    with np.errstate(over="ignore"):
        for name, value in {"thickness": thickness, **others}.items():
            each = require_array(value, (), (count,), name=name, owner=owner)
            if each.min() <= 0:
                require_positive(float(each.min()), name, owner)
            product = product * each ** (power if name == "thickness" else 1)
    if not np.isfinite(product * np.max(thickness) ** (3 - power)).all():
        raise ModelError(f"{owner}: the stiffness of a sheet of thickness {np.max(thickness):g} is beyond all numbers")
    return product


def _facet_sum(mesh: TriMesh, values: Array) -> Array:
    """Sums (edges,) of values (m,) of the one or two facets at each edge."""
    total: Array = np.append(values, 0.0)[mesh.edge_facets].sum(axis=1)  # a missing facet has index -1
    return total


report = deferred("kirigami.study.effective:report", static=True)


def directional_bias(mesh: TriMesh) -> tuple[float, float]:
    """Smallest and largest ratio over directions of the stiffness that edges represent, before the mesh relaxes.

    Edges that share their area among the directions evenly give bars the same E, and hinges the same D, in every
    direction; single-diagonal meshes do not. It costs one pass over the edges, unlike :func:`report`. Directions are
    those in the surface, so that a rolled sheet has the bias of the flat one.
    """
    _check_mesh(mesh, "directional_bias")
    from kirigami.elements.mesh_bias import MeshBias  # a truss needs no mesh

    return MeshBias(mesh).edges
