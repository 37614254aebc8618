"""What a drawing means does not depend on how it lies, in what order or direction it was drawn, or in what pieces."""

from __future__ import annotations

import sys
import warnings
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
import shapely

import kirigami as kg
from kirigami.drawing.curves import Curve
from kirigami.drawing.drawing import Drawing, assemble
from kirigami.drawing.roles import Roles


def random_curves(seed: int) -> list[Curve]:
    """Lines, polylines, boxes and circles on a coarse grid, so that they meet, cross and lie on one another."""
    random = np.random.default_rng(seed)
    grid = random.choice([0.05, 0.1, 0.25])
    jitter = random.choice([0, 0, 1e-13, 1e-9, 1e-6, 3e-5, 1e-4, 1e-3])

    def points(count: int) -> np.ndarray:
        drawn = random.random((count, 2))
        return np.round(drawn / grid) * grid + jitter * random.normal(size=(count, 2))

    corners = np.array([(0, 0), (1, 0), (1, 1), (0, 1), (0, 0)], float)
    curves = []
    kind = random.integers(4)
    if kind == 0:
        curves.append(corners)
    elif kind == 1:
        curves += [corners[k : k + 2] + jitter * random.normal(size=(2, 2)) for k in range(4)]
    elif kind == 2:
        curves += [np.array([a - 0.05 * (b - a), b + 0.05 * (b - a)]) for a, b in pairwise(corners)]
    for kind in random.integers(6, size=random.integers(1, 14)):
        if kind < 3:
            curves.append(points(2))
        elif kind == 3:
            curves.append(points(int(random.integers(2, 6))))
        elif kind == 4:
            low = points(1)[0]
            curves.append(low + random.choice([grid, 0.02, 1e-5], 2) * corners)
        else:
            angle = np.linspace(0, 2 * np.pi, 33)
            ring = points(1)[0] + 0.1 * np.column_stack([np.cos(angle), np.sin(angle)])
            ring[-1] = ring[0]
            curves.append(ring)
    layers = ["", "", "", "cut", "fold", "outline"]
    return [Curve(points, str(random.choice(layers)), "", f"curve {k}") for k, points in enumerate(curves)]


def survey(first: int, count: int) -> str:
    """Read random curves: a sheet whose mesh has the area that was read, or a typed error."""
    read = refused = meshed = 0
    for seed in range(first, first + count):
        try:
            drawing = assemble(random_curves(seed), Roles(), unit="m", tolerance=1e-4)
        except kg.GeometryError:
            refused += 1
            continue
        read += 1
        sheet = drawing.sheet()  # what is read is a sheet
        try:
            with warnings.catch_warnings(record=True) as told:
                warnings.simplefilter("always")
                mesh = sheet.mesh(0.3)
        except kg.GeometryError:
            continue
        meshed += 1
        assert mesh.facet_parts.max() == 0, seed
        slack = 1e-3 * sheet.area + 1e-4
        fallen = any("out: " in str(warning.message) for warning in told)
        assert mesh.facet_areas.sum() < sheet.area + slack, seed
        assert fallen or mesh.facet_areas.sum() > sheet.area - slack, seed
    return f"{read} read, {meshed} meshed, {refused} refused"


@pytest.mark.filterwarnings("ignore::kirigami.KirigamiWarning")
def test_random_curves_are_read_or_refused() -> None:
    read, meshed, refused = (int(part.split()[0]) for part in survey(0, 100).split(","))
    assert read + refused == 100 and meshed > 20 and refused > 10
    assert survey(1409, 1).startswith("1 read")  # a fold smaller than the gap is led onto one point


@pytest.mark.long
@pytest.mark.filterwarnings("ignore::kirigami.KirigamiWarning")
def test_many_random_curves() -> None:
    survey(1000, 4000)


def slotted() -> list[Curve]:
    """A rim of lines that overshoot their corners, slits on the rim, a hole, a slot that falls out, a fold, a mark."""
    corners = np.array([(0, 0), (10, 0), (12, 7), (0, 8), (0, 0)], float)
    angle = np.linspace(0, 2 * np.pi, 41)
    hole = np.array([8.0, 4.0]) + np.column_stack([np.cos(angle), np.sin(angle)])
    hole[-1] = hole[0]
    lines = [np.array([a - 0.02 * (b - a), b + 0.02 * (b - a)]) for a, b in pairwise(corners)]
    lines += [np.array([(5, 0), (5, 3)], float), np.array([(11, 3.5), (9.5, 3.5)], float)]
    lines += [np.array([(0, 5), (2, 5), (2, 5.5), (0, 5.5)], float), hole, np.array([(-2, -2), (-1, -2)], float)]
    lines += [np.array([(3, 6), (6, 6)], float), np.array([(4, 6), (4, 4)], float)]
    curves = [Curve(line, "", "", f"line {k}") for k, line in enumerate(lines)]
    return [*curves, Curve(np.array([(6.5, 0), (6.5, 7.5)]), "fold", "", "fold")]


def meaning(drawing: Drawing) -> list[float]:
    """Numbers that do not depend on the place of the sheet."""
    slits = [cut.length for cut in drawing.cuts if cut.geom_type == "LineString"]
    openings = [cut.area for cut in drawing.cuts if cut.geom_type == "Polygon"]
    folds = [fold.length for fold in drawing.folds]
    return [drawing.outline.area, drawing.outline.length, len(slits), *sorted(slits), *sorted(openings), *sorted(folds)]


@pytest.mark.filterwarnings("ignore::kirigami.KirigamiWarning")
@pytest.mark.parametrize("seed", range(12))
def test_place_order_direction_and_pieces_do_not_matter(seed: int) -> None:
    curves = slotted()
    wanted = meaning(assemble(curves, Roles(), unit="m", tolerance=1e-4))
    # 10, 2 and 8 from the rim's corners by hand: the shoelace formula, less the slot of 2 by 0.5.
    assert wanted[0] == pytest.approx(0.5 * abs(10 * 7 + 12 * 8) - 1.0)
    assert wanted[2] == 4
    random = np.random.default_rng(seed)
    turn, scale = random.uniform(0, 2 * np.pi), 10.0 ** random.integers(-4, 4)
    matrix = scale * np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])
    if seed % 2:
        matrix = matrix @ np.diag([1.0, -1.0])
    shift = scale * random.uniform(-50, 50, 2)
    changed = []
    for curve in curves:
        points = curve.points @ matrix + shift
        if not curve.closed and random.random() < 0.5:
            points = points[::-1]
        if len(points) == 2 and random.random() < 0.5:  # drawn in two pieces
            share = random.uniform(0.2, 0.8)
            middle = points[0] + share * (points[1] - points[0])
            changed += [replace(curve, points=np.array([points[0], middle])),
                        replace(curve, points=np.array([middle, points[1]]))]  # fmt: skip
        else:
            changed.append(replace(curve, points=points))
    changed = [changed[k] for k in random.permutation(len(changed))]
    found = meaning(assemble(changed, Roles(), unit="m", tolerance=1e-4))
    sizes = np.array([scale**2, scale, 1] + [scale] * 4 + [scale**2] + [scale])
    assert np.array(found) / sizes == pytest.approx(np.array(wanted), rel=1e-6)


@pytest.mark.filterwarnings("ignore::kirigami.KirigamiWarning")
def test_slits_on_smooth_curves_of_any_flatness() -> None:
    """A slit that ends on the true circle, inside or outside of it, meets its chords however coarse they are."""
    for count in (8, 24, 200):
        angle = np.linspace(0, 2 * np.pi, count + 1)
        ring = np.column_stack([np.cos(angle), np.sin(angle)])
        ring[-1] = ring[0]
        bow = 1.0 - np.cos(np.pi / count)
        rim, hub = Curve(4 * ring, "outline", "", "rim", bow=4 * bow), Curve(ring, "cut", "", "hub", bow=bow)
        at = np.array([np.cos(0.3), np.sin(0.3)])
        slits = [Curve(np.array([4 * at, 3 * at]), "cut", "", "outer")]
        slits += [Curve(np.array([-at, -2 * at]), "cut", "", "inner")]
        drawing = assemble([rim, hub, *slits], Roles(), unit="m", tolerance=1e-4)
        mesh = drawing.sheet().mesh(1.0)
        assert len(mesh.boundary_loops) == 2  # both slits opened into a rim
        on_rim = shapely.distance(drawing.outline.exterior, shapely.Point(4 * at))
        assert on_rim < 1e-12


if __name__ == "__main__":
    warnings.simplefilter("ignore")
    print(survey(*(int(word) for word in sys.argv[1:3])))
