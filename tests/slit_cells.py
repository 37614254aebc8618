"""Periodic unit cells of slit sheets, by reflection of a quarter, so that opposite borders carry the same nodes.

A quarter is a rectangle; parts of its sides are slits. Reflected at its right and upper side it makes the cell, whose
halves hang together where those sides are not slit; what is not slit on the outer border repeats from cell to cell.
Hinges across that border bend against a copy of the facet beyond, whose far node follows the original.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product

import numpy as np
import shapely

import kirigami as kg
from kirigami.lattice.periodic import PeriodicCell

Slit = tuple[tuple[float, float], tuple[float, float]]  # its ends, on one side of the quarter
SIDES = ("left", "right", "bottom", "top")


class SlitCell:
    """Cell of 2 width x 2 height, its model and its lattice."""

    def __init__(
        self, width: float, height: float, slits: Sequence[Slit], max_edge: float, thickness: float,
        material: kg.Material, stiffness: str = "plate",
    ) -> None:  # fmt: skip
        self.size, self.slits = np.array([width, height]), slits
        tips = {end for slit in slits for end in slit}
        ring = sorted(
            {(0.0, 0.0), (width, 0.0), (width, height), (0.0, height)} | tips,
            key=lambda point: np.arctan2(point[1] / height - 0.5, point[0] / width - 0.5),
        )
        quarter = kg.Sheet(shapely.Polygon(ring)).mesh(max_edge)
        points = quarter.nodes[:, :2]
        joined = {side: self._on(points, side) & ~self._slit(points, side) for side in SIDES}

        number: dict[tuple[int, int, int], int] = {}
        places, self.owner = [], np.zeros((2, 2, len(points)), dtype=int)
        for node, right, up in product(range(len(points)), (0, 1), (0, 1)):
            key = (node, right and not joined["right"][node], up and not joined["top"][node])
            if key not in number:
                number[key] = len(places)
                places.append([2 * self.size[a] - points[node, a] if key[1 + a] else points[node, a] for a in (0, 1)])
            self.owner[right, up, node] = number[key]
        self.leader, self.step = np.arange(len(places)), np.zeros((len(places), 2), dtype=int)
        for node, right, up in product(range(len(points)), (0, 1), (0, 1)):
            step = (right * int(joined["left"][node]), up * int(joined["bottom"][node]))
            image = self.owner[right, up, node]
            self.leader[image], self.step[image] = self.owner[right - step[0], up - step[1], node], step
        triangles = np.concatenate([self.owner[right, up][quarter.triangles] for right in (0, 1) for up in (0, 1)])
        self.mesh = kg.TriMesh(places, triangles, thickness=thickness, material=material)
        self.model = kg.Model.from_mesh(self.mesh, stiffness=stiffness)

    def _on(self, points: np.ndarray, side: str) -> np.ndarray:
        axis, value = {"left": (0, 0), "right": (0, self.size[0]), "bottom": (1, 0), "top": (1, self.size[1])}[side]
        near: np.ndarray = np.abs(points[:, axis] - value) < 1e-9 * self.size.max()
        return near

    def _slit(self, points: np.ndarray, side: str) -> np.ndarray:
        """Points strictly inside a slit on this side; a slit that ends in a corner goes on in the reflection."""
        inside = np.zeros(len(points), dtype=bool)
        for slit in self.slits:
            ends = np.array(slit)
            if self._on(ends, side).all():
                axis = int(np.ptp(ends[:, 1]) > np.ptp(ends[:, 0]))
                low, high = np.sort(ends[:, axis])
                low, high = (-1.0 if low == 0 else low), (np.inf if high == self.size[axis] else high)
                inside |= (points[:, axis] > low + 1e-9) & (points[:, axis] < high - 1e-9)
        return inside

    def part_lips(self, amount: float) -> None:
        """Stress-free imperfection: lips of the slits along x lie off the plane, upper ones up, lower ones down."""
        centre = self.mesh.nodes[self.mesh.triangles].mean(axis=1)
        lift = np.zeros(len(centre))
        for (left, y), (right, other) in self.slits:
            if y == other:
                middle, half = (left if left == 0 else right), right - left
                for x, row in product({-middle, middle, 2 * self.size[0] - middle}, {-y, y, 2 * self.size[1] - y}):
                    lift += _parted(centre, x, row, half, self.size[1])
        total, facets = np.zeros((2, len(self.leader)))
        np.add.at(total, self.leader[self.mesh.triangles], lift[:, None])
        np.add.at(facets, self.leader[self.mesh.triangles], 1)
        self.model.perturb(amount * (total / np.maximum(facets, 1))[self.leader])

    def periodic(self) -> PeriodicCell:
        """Repeat the cell, with the hinges across its border."""
        m, mesh, lattice = self.model, self.mesh, np.diag(2 * self.size)
        rows = [(k, self.leader[k], *self.step[k]) for k in np.flatnonzero(self.leader != np.arange(len(self.leader)))]
        constants = m.sheet_constants
        assert constants is not None
        bending = constants.calibration.c * constants.material.E * constants.thickness**3
        first: dict[frozenset[int], int] = {}
        for edge in np.flatnonzero(mesh.edge_facets[:, 1] < 0).tolist():
            j, k = mesh.edges[edge]
            twin = first.setdefault(frozenset((int(self.leader[j]), int(self.leader[k]))), edge)
            if twin == edge:
                continue
            start = next(node for node in mesh.edges[twin] if self.leader[node] == self.leader[j])
            shift = self.step[j] - self.step[start]
            wing, beyond = mesh.edge_wings[edge, 0], mesh.edge_wings[twin, 0]
            x, y = m.positions()[beyond, :2] + shift @ lattice
            copy = m.add(kg.Node(x, y, m.nodes[beyond].z))
            rows.append((len(m.nodes) - 1, self.leader[beyond], *(shift + self.step[beyond])))
            area = mesh.facet_areas[mesh.edge_facets[[edge, twin], 0]].sum()
            stiffness = bending * mesh.edge_lengths[edge] ** 2 / area
            m.add(kg.BendHinge(m.nodes[wing], m.nodes[j], m.nodes[k], copy, stiffness))
        return PeriodicCell(m, lattice, np.array(rows))


def stretched_freely(cell: SlitCell, strain: float, contraction: float) -> dict[str, float]:
    """Stretch along y at fixed width, then let the width go until the mean stress across is zero.

    `contraction` is what to pass on the way: a Poisson ratio surely above that of the sheet.
    """
    periodic = cell.periodic()
    imposed = periodic.impose(np.diag([0.0, strain, 0.0]))
    wide = kg.DisplacementControl(cell.model).run()[-1]
    cell.model.remove(*imposed)
    cell.model.hold(wide)
    periodic.impose(np.diag([-contraction * strain, strain, 0.0]))
    res = kg.DisplacementControl(cell.model, start=wide, targets=np.arange(1, 40) / 40).run()
    stress = periodic.mean_stress(res)
    last = int(np.argmax(stress[:, 0, 0] < 0))
    part = stress[last - 1, 0, 0] / (stress[last - 1, 0, 0] - stress[last, 0, 0])
    measured = {"poisson": res.lam * contraction, "line force": stress[:, 1, 1]}
    return {name: float(values[last - 1] + part * np.diff(values)[last - 1]) for name, values in measured.items()}


def _parted(centre: np.ndarray, x: float, y: float, half: float, row: float) -> np.ndarray:
    along = np.clip(1 - ((centre[:, 0] - x) / half) ** 2, 0, None) ** 2
    away = centre[:, 1] - y
    lift: np.ndarray = np.sign(away) * along * np.clip(1 - np.abs(away) / row, 0, None)
    return lift
