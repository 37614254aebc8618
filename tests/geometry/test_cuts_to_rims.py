"""Cuts may end on any rim, hole, cut or vertex at any angle: the sheet has as many parts as the drawing's graph says.

A cut with one end on what is drawn severs nothing; one that joins two loose pieces (rim, holes, cuts) severs nothing
either; one that joins a piece to itself adds one part. So the number of parts follows from counting alone, whatever the
coordinates round to.
"""

from __future__ import annotations

import sys
import warnings

import numpy as np
import pytest
import shapely

import kirigami as kg

CLEARANCE = 0.03  # between things that do not touch; the mesher snaps at 1e-4


class Sheets:
    """A random sheet: its outline, cuts, and how many parts it must have."""

    def __init__(self, seed: int, severing: bool) -> None:
        self.random = np.random.default_rng(seed)
        self.severing = severing
        turn = self.random.uniform(0, 2 * np.pi)
        self.turn = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
        self.shift = self.random.uniform(-3, 3, 2) * self.random.choice([0, 1, 100])
        self.scale = 10.0 ** self.random.integers(-3, 4)
        rim = self._rim()
        self.pieces = [shapely.LinearRing(self._placed(rim))]  # connected line work, one geometry a piece
        self.size = self.scale
        self.outline = shapely.Polygon(self.pieces[0])
        self.cuts: list[shapely.LineString | shapely.Polygon] = []
        self.parts = 1
        for _ in range(int(self.random.integers(0, 4))):
            self._hole()
        for _ in range(int(self.random.integers(2, 9))):
            self._slit()
        order = self.random.permutation(len(self.cuts))
        self.cuts = [self.cuts[k] for k in order]

    def _rim(self) -> np.ndarray:
        kind = self.random.integers(5)
        if kind == 0:
            return np.array([(0, 0), (1, 0), (1, 0.6), (0, 0.6)])
        if kind == 1:  # regular polygons, from hexagons to discs
            count = int(self.random.choice([6, 8, 48]))
            angle = np.arange(count) * 2 * np.pi / count
            return 0.5 * np.column_stack([np.cos(angle), np.sin(angle)])
        if kind == 2:
            return np.array([(0, 0), (1, 0.2), (0.9, 1), (0.1, 0.8)])
        if kind == 3:  # an L
            return np.array([(0, 0), (1, 0), (1, 0.5), (0.5, 0.5), (0.5, 1), (0, 1)])
        angle = np.sort(self.random.uniform(0, 2 * np.pi, 9)) + np.arange(9) * 0.3
        angle *= 2 * np.pi / (angle[-1] + 0.4)
        return self.random.uniform(0.45, 0.65, 9)[:, None] * np.column_stack([np.cos(angle), np.sin(angle)])

    def _placed(self, points: np.ndarray) -> np.ndarray:
        return self.scale * (points @ self.turn.T + self.shift)

    def _inside(self) -> np.ndarray:
        low, high = np.array(self.outline.bounds).reshape(2, 2)
        while True:
            point = self.random.uniform(low, high)
            if self._free(shapely.Point(point)):
                return point

    def _free(self, shape: shapely.Geometry) -> bool:
        """Whether a shape keeps clear of all that is drawn."""
        holes = [cut for cut in self.cuts if isinstance(cut, shapely.Polygon)]
        clear = self.outline.contains(shape) and not any(hole.intersects(shape) for hole in holes)
        return clear and min(piece.distance(shape) for piece in self.pieces) > CLEARANCE * self.size

    def _hole(self) -> None:
        count, radius = int(self.random.choice([3, 4, 24])), self.random.uniform(0.04, 0.12)
        angle = self.random.uniform(0, 7) + np.arange(count) * 2 * np.pi / count
        ring = self._inside() + self.scale * radius * np.column_stack([np.cos(angle), np.sin(angle)])
        if self._free(shapely.Polygon(ring)):
            self.cuts.append(shapely.Polygon(ring))
            self.pieces.append(shapely.LinearRing(ring))

    def _slit(self) -> None:
        """A slit with one or two ends on what is drawn, at any place of it, and clear of everything else."""
        for _ in range(60):
            one = int(self.random.integers(len(self.pieces)))
            start = self._on(self.pieces[one])
            if self.random.random() < 0.6:
                other, end = -1, self._inside()
            else:
                other = int(self.random.integers(len(self.pieces)))
                end = self._on(self.pieces[other])
                if other == one and not self.severing:
                    continue
            length = np.hypot(*(end - start))
            if length < 4 * CLEARANCE * self.size:
                continue
            near = 1.5 * CLEARANCE * self.size / length  # at both ends it may come near, at no flat angle
            body = self._without_ends(start, end, near, near if other >= 0 else 0.0)
            all_but_ends = self._without_ends(start, end, 1e-6, 1e-6)
            if not self._free(body) or any(piece.intersects(all_but_ends) for piece in self.pieces):
                continue
            slit = shapely.LineString([start, end] if self.random.random() < 0.5 else [end, start])
            self.cuts.append(slit)
            if other == one:
                self.parts += 1
            self.pieces[one] = shapely.union_all([self.pieces[one], slit])
            if other >= 0 and other != one:
                self.pieces[one] = shapely.union_all([self.pieces[one], self.pieces[other]])
                del self.pieces[other]
            return

    @staticmethod
    def _without_ends(start: np.ndarray, end: np.ndarray, first: float, last: float) -> shapely.LineString:
        return shapely.LineString([start + first * (end - start), end - last * (end - start)])

    def _on(self, piece: shapely.Geometry) -> np.ndarray:
        """A point on line work: a vertex, the middle of a side, or anywhere, as floating point numbers have it."""
        line = self.random.choice(np.array(getattr(piece, "geoms", [piece]), dtype=object))
        points = shapely.get_coordinates(line)
        side = int(self.random.integers(len(points) - 1))
        share = self.random.choice([0.0, 0.5, self.random.random()])
        return points[side] + share * (points[side + 1] - points[side])


def check(seed: int) -> None:
    """One sheet that nothing severs, or one in parts."""
    severing = seed % 3 == 0
    drawn = Sheets(seed, severing)
    sheet = kg.Sheet(drawn.outline, drawn.cuts)
    mesh = sheet.mesh(0.2 * drawn.size, cut_edge=0.1 * drawn.size, allow_parts=severing)
    assert mesh.facet_parts.max() + 1 == drawn.parts, seed
    drawn_length = drawn.outline.length + sum(cut.length for cut in drawn.cuts)
    assert abs(mesh.facet_areas.sum() - sheet.area) < 0.5e-4 * drawn.size * drawn_length, seed  # snapping moves by that
    assert sorted(number for cut in mesh.cuts for number in cut.members) == list(range(len(drawn.cuts))), seed


def survey(first: int, count: int) -> int:
    """Check many sheets; how many fail."""
    failures = 0
    for seed in range(first, first + count):
        try:
            check(seed)
        except (kg.KirigamiError, AssertionError) as error:
            failures += 1
            print(seed, type(error).__name__, error)
    return failures


@pytest.mark.filterwarnings("ignore::kirigami.KirigamiWarning")
def test_sheets_have_the_parts_they_must_have():
    assert survey(0, 100) == 0


@pytest.mark.long
@pytest.mark.filterwarnings("ignore::kirigami.KirigamiWarning")
def test_five_hundred_sheets():
    assert survey(1000, 500) == 0


@pytest.mark.filterwarnings("ignore::kirigami.KirigamiWarning")
@pytest.mark.parametrize("corners", [4, 6])
def test_slits_from_every_side_of_turned_sheets(corners):
    """Regular sheets turned by forty angles, seven slits from the rim each: one part, the area of the polygon."""
    for step in range(40):
        angle = np.radians(step * 360 / 40 + 0.3) + np.arange(corners) * 2 * np.pi / corners
        ring = 40 * np.column_stack([np.cos(angle), np.sin(angle)])
        slits = []
        for k in range(7):
            side, share = k % corners, 0.2 + 0.09 * k
            start = ring[side] + share * (ring[(side + 1) % corners] - ring[side])
            slits.append(shapely.LineString([start, 0.7 * start]))
        mesh = kg.Sheet(ring, slits).mesh(10.0)
        assert mesh.facet_parts.max() == 0 and len(mesh.cuts) == 7 and all(cut.open for cut in mesh.cuts)
        assert mesh.facet_areas.sum() == pytest.approx(shapely.Polygon(ring).area, rel=1e-9)


def test_small_pieces_fall_out_and_are_told():
    """A slot drawn as three lines is a notch; what falls out is told with its area and place."""
    slot = shapely.LineString([(0, 0.45), (0.4, 0.45), (0.4, 0.55), (0, 0.55)])
    with pytest.warns(kg.KirigamiWarning, match=r"1 piece falls out: x 0 to 0.4, y 0.45 to 0.55, area 0.04, along cut"):
        mesh = kg.Sheet(shapely.box(0, 0, 1, 1), slot).mesh(0.1)
    assert mesh.facet_areas.sum() == pytest.approx(0.96)
    assert mesh.facet_parts.max() == 0 and mesh.cuts[0].open
    kept = kg.Sheet(shapely.box(0, 0, 1, 1), slot).mesh(0.1, allow_parts=True)
    assert kept.facet_areas.sum() == pytest.approx(1.0) and kept.facet_parts.max() == 1


if __name__ == "__main__":
    warnings.simplefilter("ignore")
    first, count = (int(word) for word in sys.argv[1:3])
    failed = survey(first, count)
    print(f"{count - failed} of {count} sheets have the right number of parts")
    sys.exit(failed > 0)
