"""At which forces and moments the bars and hinges of a sheet yield.

A bar that stands for E t (A1 + A2) / L yields at the strain sigma_y / E, so at sigma_y t (A1 + A2) / L. A hinge of
length L yields at the fully plastic moment of a sheet in cylindrical bending, 2 / sqrt(3) sigma_y t^2 / 4 L, and its
plastic angle is the plastic curvature times (A1 + A2) / L. Between facets of different material or thickness the one
that yields first counts.
"""

from __future__ import annotations

from functools import cache
from typing import Any

from kirigami.elements.stiffness import SheetConstants
from kirigami.geometry.mesh import TriMesh
from kirigami.primitives.hardening import YieldCurve, bent
from kirigami.primitives.material import Material


class EdgeYield:
    """The arguments of bars and hinges of a mesh, edge by edge."""

    def __init__(self, mesh: TriMesh, constants: SheetConstants) -> None:
        count = len(mesh.triangles)
        number, self._materials = constants.material_of_facets(count)
        self._number, self._thickness = number.tolist(), constants.thickness_of_facets(count).tolist()
        self._facets = [[f for f in pair if f >= 0] for pair in mesh.edge_facets.tolist()]
        self._length = mesh.edge_lengths.tolist()
        self._area = mesh.facet_areas.tolist()
        self._curves: list[YieldCurve | None] = [each.yield_curve for each in self._materials]
        self._bent = cache(bent)

    def of_bar(self, edge: int, EA: float) -> dict[str, Any]:
        """Yield force and hardening of a bar of stiffness `EA`."""
        curves = []
        for facet in self._facets[edge]:
            number = self._number[facet]
            curve, material = self._curves[number], self._materials[number]
            if curve is not None and isinstance(material, Material):
                curves.append(curve.scaled(EA / material.E))
        return _arguments("yield_force", curves)

    def of_hinge(self, edge: int) -> dict[str, Any]:
        """Yield moment and hardening of a hinge."""
        facets, length = self._facets[edge], self._length[edge]
        width = sum(self._area[facet] for facet in facets) / length
        curves = []
        for facet in facets:
            curve = self._curves[self._number[facet]]
            if curve is not None:
                curves.append(self._bent(curve, self._thickness[facet]).scaled(length, width))
        return _arguments("yield_moment", curves)


def _arguments(name: str, curves: list[YieldCurve]) -> dict[str, Any]:
    """Those of the member whose curve begins lowest."""
    if not curves:
        return {}
    curve = min(curves, key=lambda each: each.stress[0])
    return {name: curve.stress[0], "hardening": curve}
