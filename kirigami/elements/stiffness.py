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

* bars    EA = F_s E t (sum of A over the one or two facets of the edge) / L
* hinges  k = c E t^3 L^2 / (A1 + A2), the total of the edge

"plate" takes F_s = 1, the triangulated-membrane rule of Van Gelder (1998), which is exact for equilateral facets at
nu = 1/3, and c = 1 / (12 (1 - nu^2)), which makes cylindrical bending exact on equilateral and on leg-aligned
right-angled facets (Seung and Nelson, 1988). "paper" takes the published F_s = 0.85, c = 0.125 / 48, which is
about 36 times softer in bending than the material; it is kept to reproduce the publication.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from kirigami.deferred import deferred
from kirigami.errors import ModelError
from kirigami.primitives.checks import require_choice, require_instance, require_positive
from kirigami.primitives.kernel import Array
from kirigami.primitives.material import Material

if TYPE_CHECKING:
    from kirigami.geometry.mesh import TriMesh

RUNGS = ("paper", "plate", "facet", "shell")  # from cheap to accurate
ALIASES = {"split": "shell"}  # names of earlier versions


def rung_named(stiffness: str, owner: str) -> str:
    """The rung of a name, also of an earlier version's, or a ModelError with the names there are."""
    name: str = require_choice(stiffness, (*RUNGS, *ALIASES), "stiffness", owner)
    return ALIASES.get(name, name)


@dataclass(frozen=True)
class Calibration:
    """Factors of the bar and hinge constants; see the module's text.

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
    def named(cls, stiffness: str | Calibration, material: Material) -> Calibration:
        """The calibration of a name, or the one given."""
        require_instance(material, Material, "material", "Calibration.named")
        if isinstance(stiffness, Calibration):
            return stiffness
        known = (*RUNGS, *ALIASES)
        require_choice(stiffness, known, "stiffness", "Model.from_mesh", or_else="a Calibration(F_s, c)")
        if stiffness == "paper":
            return cls(F_s=0.85, c=0.125 / 48)
        return cls(F_s=1.0, c=1 / (12 * (1 - material.nu**2)))


@dataclass(frozen=True)
class SheetConstants:
    """The calibration a model was made with, and what it was applied to."""

    calibration: Calibration
    thickness: float
    material: Material
    rung: str = "calibration"  # name of the rung of accuracy, "calibration" for own factors


def bar_stiffness(mesh: TriMesh, thickness: float, E: float, F_s: float) -> Array:
    """EA of each mesh edge (edges,) [force]."""
    _check_constants("bar_stiffness", mesh, thickness=thickness, E=E, F_s=F_s)
    return F_s * E * thickness * _facet_area_sum(mesh) / mesh.edge_lengths


def hinge_stiffness(mesh: TriMesh, thickness: float, E: float, c: float) -> Array:
    """Rotational stiffness of each mesh edge (edges,) [force length / rad]; meaningful for inner edges."""
    _check_constants("hinge_stiffness", mesh, thickness=thickness, E=E, c=c)
    return c * E * thickness**3 * mesh.edge_lengths**2 / _facet_area_sum(mesh)


def _check_mesh(mesh: TriMesh, owner: str) -> None:
    from kirigami.geometry.mesh import TriMesh  # a truss needs none

    require_instance(mesh, TriMesh, "mesh", owner, "make one with Sheet.mesh or TriMesh")


def _check_constants(owner: str, mesh: TriMesh, **constants: float) -> None:
    _check_mesh(mesh, owner)
    for name, value in constants.items():
        require_positive(value, name, owner)
    rigidity = (
        float(np.prod([float(value) for value in constants.values()]))
        * float(constants["thickness"])
        * float(constants["thickness"])
    )
    if not np.isfinite(rigidity):
        raise ModelError(
            f"{owner}: the stiffness of a sheet of thickness {constants['thickness']:g} is beyond all numbers"
        )


def _facet_area_sum(mesh: TriMesh) -> Array:
    areas = np.append(mesh.facet_areas, 0.0)  # a missing facet has index -1
    total: Array = areas[mesh.edge_facets].sum(axis=1)
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
