"""The shell facet: a six-node triangle of thin sheet, with positions and edge angles as its only unknowns.

Every edge has a middle, at w from the mean of its ends, and an angle at each of its two Gauss points; they belong to
the edge and are shared by the facets on it. Users see corners only: a system numbers the rest behind the nodes.

* Membrane: linear strain over the facet out of nine numbers, see :mod:`kirigami.elements.shell_membrane`.
* Bending: linear moments over the facet, see :mod:`kirigami.elements.shell_bending`.
* Energy, with strain and curvature (e_i, k_i) at the three corners and the 6 x 6 section matrix S = [[A, B], [B, D]]
  of the sheet, (area / 24) [sum (e_i, k_i)' S (e_i, k_i) + (sum (e_i, k_i))' S (sum (e_i, k_i))].

A flat sheet in its plane is the linear-strain triangle, exactly; in bending the facet is exact for any uniform
curvature on any mesh. Tension cannot make it buckle, bending to a cylinder does not lock, a sharp fold needs nothing
special, since an edge's angle belongs to the edge. Free and simply supported edges leave the angle free, a clamped one
holds it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from kirigami.elements.crease import Crease, folded_pairs
from kirigami.elements.shell_images import mirror_planes, plane_normals
from kirigami.elements.shell_kernel import ShellFacetKernel
from kirigami.elements.shell_rest import numbered_edges
from kirigami.elements.triangle import check_areas, warn_of_jumps
from kirigami.errors import ModelError
from kirigami.primitives.checks import require_array, require_instance, require_positive
from kirigami.primitives.kernel import Array, Kernel
from kirigami.primitives.material import SheetMaterial, each_section, strain_turn
from kirigami.primitives.node import Node, require_nodes
from kirigami.primitives.parts import ModelObject, Numbering


@dataclass(frozen=True, slots=True, eq=False)
class ShellFacet(ModelObject):
    """Triangle of a thin elastic sheet that converges to shell theory: the element of ``stiffness="shell"``.

    Parameters
    ----------
    i, j, k : Node
        Corners, counter-clockwise seen from the side of the normal.
    thickness : float
        Sheet thickness [length].
    material : Material, Orthotropic, Laminate or NeoHookean
        Elastic constants.
    normals : array_like, shape (3, 3), optional
        Normals of a curved rest surface at the corners, of any length. None takes the mean of the facets around a
        corner, but not across an edge that is sharper than 30 degrees or a :class:`Crease`. They say how the edges
        bulge; a flat sheet needs none.
    section : array_like, shape (6, 6), optional
        Stiffness of a sheet that is not isotropic: forces and moments per length (Nxx, Nyy, Nxy, Mxx, Myy, Mxy) by
        strains and curvatures (exx, eyy, gxy, kxx, kyy, 2 kxy), symmetric and positive definite. None takes that of
        `material`.
    axis : array_like, shape (3,)
        Direction whose projection on the facet is the first axis of `section` and of materials that are not isotropic.

    Raises
    ------
    ModelError
        A repeated corner, a thickness that is not positive, normals or a section of a wrong shape or kind.

    Examples
    --------
    >>> import kirigami as kg
    >>> m = kg.Model()
    >>> a, b, c = m.add(kg.Node(0, 0), kg.Node(1, 0), kg.Node(0, 1))
    >>> facet = m.add(kg.ShellFacet(a, b, c, thickness=0.01, material=kg.Material(E=1e9)))
    >>> print(m)
    Model in 3D: 3 nodes, 1 ShellFacet
    """

    kind: ClassVar[str] = "element"
    i: Node
    j: Node
    k: Node
    thickness: float
    material: SheetMaterial
    normals: ArrayLike | None = None
    section: ArrayLike | None = None
    axis: ArrayLike = (1.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        corners = self.nodes
        require_nodes("ShellFacet", i=self.i, j=self.j, k=self.k)
        if len(set(map(id, corners))) < 3:
            raise ModelError(f"ShellFacet on {corners}: give three different nodes as corners")
        object.__setattr__(self, "thickness", require_positive(self.thickness, "thickness", "ShellFacet"))
        require_instance(self.material, SheetMaterial, "material", "ShellFacet")
        if self.section is None:
            self.material.checked_thickness(self.thickness, "ShellFacet")
        for name, shape in (("normals", (3, 3)), ("section", (6, 6)), ("axis", (3,))):
            given = getattr(self, name)
            if given is not None or name == "axis":
                values = require_array(given, shape, name=name, owner="ShellFacet")
                values.flags.writeable = False
                object.__setattr__(self, name, values)
        if self.normals is not None and not np.linalg.norm(self.normals, axis=1).all():
            raise ModelError(f"ShellFacet on {corners}: a normal has no length")
        if self.section is not None:
            S = np.asarray(self.section)
            if not np.allclose(S, S.T, rtol=1e-9, atol=0) or np.linalg.eigvalsh(_scaled(S)).min() <= 0:
                raise ModelError(f"ShellFacet on {corners}: section must be symmetric and positive definite")

    @property
    def nodes(self) -> tuple[Node, ...]:
        return (self.i, self.j, self.k)

    @property
    def shaped(self) -> bool:  # type: ignore[override]
        """Where it has normals of its own."""
        return self.normals is not None

    @property
    def directed(self) -> bool:  # type: ignore[override]
        """Where its section or material is not the same along all directions, or not known to be."""
        return self.section is not None or not self.material.isotropic

    @classmethod
    def reserve(cls, objects: Sequence[ShellFacet], numbering: Numbering) -> None:
        """Ask for the rows of the edges: offsets of their middles, and their angles."""
        if numbering.dim == 2:
            raise ModelError("ShellFacet bends, so it needs a model with dim=3; in a plane use stiffness='facet'")
        triangles = numbering.connectivity(objects)
        check_areas("ShellFacet", triangles, numbering)
        if numbering.mesh is None:  # else it was said of the mesh
            thickness = np.array([facet.thickness for facet in objects])
            warn_of_jumps("ShellFacet", triangles, thickness, numbering.rest, 2)
        given = [facet.normals for facet in objects]
        folded = folded_pairs(numbering.objects.get(Crease, ()), numbering)
        numbering.edges = numbered_edges(numbering, triangles, given, folded)

    @classmethod
    def lower(cls, objects: Sequence[ShellFacet], numbering: Numbering) -> list[Kernel]:
        edges = numbering.edges
        assert edges is not None
        conn = np.concatenate([edges.triangles, edges.middle[edges.edge], edges.angle], axis=1)
        sections = section_matrices(objects, numbering.rest[edges.triangles])
        density = np.array([(f.material.density or np.nan) * f.thickness for f in objects])
        planes = plane_normals(mirror_planes(numbering), edges.ends, edges.edge)
        seams = edges.seam_angles if len(edges.seams) else None
        yields = any(facet.material.yields for facet in objects)
        if any(facet.material.hyperelastic for facet in objects):
            if yields:
                raise ModelError(
                    "a sheet of shell facets cannot be rubber in one place and yield in another: give the material "
                    "with a yield_stress hardening=None, and results tell where it is passed"
                )
            from kirigami.elements.shell_rubber import RubberShellKernel, rubber_moduli

            arrays = numbering.rest, conn, sections, edges.forward, density
            return [RubberShellKernel(*arrays, None, planes, seams=seams, rubber=rubber_moduli(objects))]
        if yields:
            from kirigami.elements.shell_yield import YieldingShellKernel, yield_constants

            arrays = numbering.rest, conn, sections, edges.forward, density
            return [YieldingShellKernel(*arrays, None, planes, seams=seams, **yield_constants(objects))]
        return [ShellFacetKernel(numbering.rest, conn, sections, edges.forward, density, planes=planes, seams=seams)]


def section_matrices(objects: Sequence[Any], corners: Array) -> Array:
    """Section matrices (n, 6, 6) of facets with `corners` (n, 3, 3), first axis along the edge from corner i to j."""
    sections = np.empty((len(objects), 6, 6))
    given = np.array([facet.section is not None for facet in objects])
    for position in np.flatnonzero(given).tolist():
        sections[position] = objects[position].section
    made = [facet for facet in objects if facet.section is None]
    if made:
        known = {material: number for number, material in enumerate(dict.fromkeys(facet.material for facet in made))}
        number = np.array([known[facet.material] for facet in made])
        sections[~given] = each_section(np.array([facet.thickness for facet in made]), number, tuple(known))
    turning = np.flatnonzero(given | np.array([not facet.material.isotropic for facet in objects]))
    if turning.size:
        axes = np.array([objects[position].axis for position in turning.tolist()], dtype=float)
        sections[turning] = turned_sections(sections[turning], axes, corners[turning])
    return sections


def turned_sections(sections: Array, axes: Array, corners: Array) -> Array:
    """Section matrices (n, 6, 6) in the axes of facets, from those whose first is the projection of `axes` (n, 3)."""
    along = corners[:, 1] - corners[:, 0]
    along = along / np.linalg.norm(along, axis=1)[:, None]
    normal = np.cross(along, corners[:, 2] - corners[:, 0])
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    first = axes - (axes * normal).sum(axis=1)[:, None] * normal
    standing = np.flatnonzero(np.linalg.norm(first, axis=1) < 1e-6 * np.linalg.norm(axes, axis=1))
    if standing.size:
        raise ModelError(
            f"ShellFacet with corners {corners[standing[0]].tolist()}: the axis {axes[standing[0]].tolist()} of its "
            "section or material stands on it: give another axis"
        )
    # from the facet's axis to the section's
    angle = np.arctan2((np.cross(along, first) * normal).sum(axis=1), (along * first).sum(axis=1))
    both = np.zeros((len(angle), 6, 6))
    both[:, :3, :3] = both[:, 3:, 3:] = strain_turn(angle)
    return np.asarray(both.transpose(0, 2, 1) @ sections @ both)


def _scaled(section: Array) -> Array:
    """With ones on the diagonal, so that bending and stretching compare."""
    size = np.sqrt(np.abs(np.diag(section)))
    return np.asarray(section / np.where(size > 0, size, 1.0) / np.where(size > 0, size, 1.0)[:, None])
