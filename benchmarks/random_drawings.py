"""Drawings of cut sheets drawn at random: slits, crossing slits, slots and holes, lines that may sever the sheet."""

from __future__ import annotations

from typing import Any

import numpy as np
import shapely

import kirigami as kg
from kirigami.geometry.clean import SCRAP

KINDS = ("slits", "crossing slits", "slits and openings", "wild")


def drawing(seed: int, small: bool = False) -> tuple[shapely.Polygon, list[Any], np.random.Generator]:
    """Outline and cuts of a seed, only the first five for a small sheet, and the generator to go on with."""
    random = np.random.default_rng(seed)
    height = float(random.uniform(0.7, 1.5))
    outline = shapely.box(0.0, 0.0, 1.0, height)
    kind = KINDS[seed % len(KINDS)]
    if kind == "wild":
        return outline, _wild_cuts(random, outline)[: 5 if small else None], random
    cuts: list[Any] = []
    if kind == "slits and openings":
        for _ in range(int(random.integers(1, 5))):
            opening = _opening(random, outline)
            if outline.buffer(-0.03).contains(opening) and all(opening.distance(cut) > 0.03 for cut in cuts):
                cuts.append(opening)
    count = int(random.integers(1, 26))
    longest = float(random.uniform(0.15, 0.6))
    gap = float(random.uniform(0.01, 0.04))
    while True:
        try:
            slits = kg.cuts.random_slits(
                count, 1.0, height, (0.3 * longest, longest), seed=int(random.integers(2**31)), gap=gap,
                crossing=kind == "crossing slits",
            )  # fmt: skip
            break
        except kg.GeometryError:
            count = max(1, count // 2)
            longest = max(0.8 * longest, 0.1)
    cuts += [slit for slit in slits if all(slit.distance(cut) > gap for cut in cuts)]
    return outline, cuts[: 5 if small else None], random


def _opening(random: np.random.Generator, outline: shapely.Polygon) -> Any:
    """A round hole or a slot at any place and angle."""
    centre = shapely.Point(random.uniform(outline.bounds[:2], outline.bounds[2:]))
    if random.random() < 0.5:
        return centre.buffer(random.uniform(0.02, 0.15))
    length, width = random.uniform(0.1, 0.4), random.uniform(0.01, 0.05)
    slot = shapely.box(centre.x - length / 2, centre.y - width / 2, centre.x + length / 2, centre.y + width / 2)
    return shapely.affinity.rotate(slot, random.uniform(0, 180))


def _wild_cuts(random: np.random.Generator, outline: shapely.Polygon) -> list[Any]:
    """Lines, bent lines and openings that cross, reach the edge, enclose pieces or pass close to one another."""
    low, high = np.array(outline.bounds[:2]), np.array(outline.bounds[2:])
    cuts: list[Any] = []
    for _ in range(int(random.integers(1, 13))):
        start = random.uniform(low - 0.05, high + 0.05)
        if random.random() < 0.15:
            cut = _opening(random, outline)
        else:
            turns = np.cumsum(random.normal(0.0, 0.8, int(random.integers(1, 5)))) + random.uniform(0, 2 * np.pi)
            steps = random.uniform(0.08, 0.35, len(turns))[:, None] * np.column_stack([np.cos(turns), np.sin(turns)])
            cut = shapely.LineString(np.vstack([start, start + np.cumsum(steps, axis=0)]))
        inside = shapely.intersection(cut, outline)
        if inside.geom_type == cut.geom_type and not inside.is_empty:
            cuts.append(inside)
    return cuts


def parts_of(outline: shapely.Polygon, cuts: list[Any]) -> int:
    """Number of pieces of the sheet: the faces of the drawing that are no opening."""
    return len(areas_of(outline, cuts))


def falls_apart(outline: shapely.Polygon, cuts: list[Any]) -> bool:
    """Whether a second piece of the sheet is too large to fall out as scrap."""
    area = sorted(areas_of(outline, cuts))
    return len(area) > 1 and area[-2] > SCRAP * area[-1]


def areas_of(outline: shapely.Polygon, cuts: list[Any]) -> list[float]:
    """Areas of the pieces of the sheet."""
    openings = shapely.union_all([cut for cut in cuts if cut.geom_type == "Polygon"])
    lines = [cut.exterior if cut.geom_type == "Polygon" else cut for cut in cuts]
    faces = shapely.polygonize([shapely.union_all([outline.exterior, *lines])])
    return [face.area for face in faces.geoms if not openings.covers(face.representative_point())]
