"""The mesh generator can end the process on bad input: nothing that passes the cleaning may do so.

Random drawings full of coincidences are meshed in a process of their own. Each must give a mesh of the right area or a
typed error, and the process must live.
"""

from __future__ import annotations

import subprocess
import sys
import warnings
from pathlib import Path

import numpy as np
import pytest
import shapely

import kirigami as kg

CASES = 120


def random_drawing(seed: int) -> tuple[shapely.Polygon, list[shapely.LineString | shapely.Polygon], float]:
    """Outline, cuts and an edge length: points on a coarse grid, shifted by next to nothing up to a visible amount."""
    random = np.random.default_rng(seed)
    grid = random.choice([0.05, 0.1, 0.25])
    jitter = random.choice([0, 0, 1e-15, 1e-12, 1e-9, 1e-7, 3e-6, 1e-5, 1e-4])

    def points(count: int) -> np.ndarray:
        drawn = random.random((count, 2))
        if random.random() < 0.7:
            drawn = np.round(drawn / grid) * grid
        return drawn + jitter * random.normal(size=(count, 2))

    outline = shapely.box(-0.01, -0.01, 1.01, 1.01) if random.random() < 0.7 else shapely.Polygon(_star(random))
    cuts: list[shapely.LineString | shapely.Polygon] = []
    for kind in random.integers(6, size=random.integers(14)):
        if kind < 3:
            cuts.append(shapely.LineString(points(2)))
        elif kind == 3:
            cuts.append(shapely.LineString(points(int(random.integers(2, 6)))))
        elif kind == 4:
            corner, sides = points(1)[0], random.choice([grid, 0.02, 1e-5, 1e-3], 2)
            cuts.append(shapely.box(*corner, *(corner + sides)))
        else:
            triangle = shapely.Polygon(points(3))
            cuts += [triangle] if triangle.area > 0 else []
    scale, shift = 10.0 ** random.integers(-4, 4), random.choice([0, 1, 100])

    def place(coordinates: np.ndarray) -> np.ndarray:
        return scale * (coordinates + shift)

    placed = [shapely.transform(cut, place) for cut in cuts]
    return shapely.transform(outline, place), placed, scale * random.choice([0.05, 0.1, 0.3, 2])


def _star(random: np.random.Generator) -> np.ndarray:
    angle = np.sort(random.random(random.integers(5, 40))) * 2 * np.pi
    reach = random.uniform(0.8, 1.2, len(angle))
    return 0.5 + np.column_stack([reach * np.cos(angle), reach * np.sin(angle)])


def survey(first: int, count: int) -> str:
    """Mesh drawings; how many gave a mesh and how many a typed error."""
    meshes = errors = 0
    for seed in range(first, first + count):
        outline, cuts, max_edge = random_drawing(seed)
        try:
            sheet = kg.Sheet(outline, cuts)
            with warnings.catch_warnings(record=True) as told:
                warnings.simplefilter("always")
                mesh = sheet.mesh(max_edge, allow_parts=seed % 3 > 0)
        except kg.GeometryError as error:
            assert "generator" not in str(error), f"drawing {seed}: {error}"  # the wall should have seen it
            errors += 1
            continue
        meshes += 1
        # Snapping moves points by less than a thousandth of the edges.
        slack = 2e-4 * sheet.area + 1e-4 * max_edge**2
        area = mesh.facet_areas.sum()
        if any("out: " in str(warning.message) for warning in told):  # scrap: what is left is the largest part
            whole = sheet.mesh(max_edge, allow_parts=True)
            assert whole.facet_parts.max() > 0, f"drawing {seed}: nothing could fall out"
            assert abs(np.bincount(whole.facet_parts, whole.facet_areas).max() - area) < slack, f"drawing {seed}: part"
            area = whole.facet_areas.sum()
        assert abs(area - sheet.area) < slack, f"drawing {seed}: area"
        assert mesh.edge_lengths.max() <= 1.1 * max_edge, f"drawing {seed}: long edge"
        drawn = sum(len(cut.members) for cut in mesh.cuts)
        assert drawn <= len(cuts), f"drawing {seed}: cuts"
    return f"{meshes} meshes, {errors} errors"


def test_no_drawing_ends_the_process():
    done = subprocess.run([sys.executable, __file__], capture_output=True, text=True, timeout=300, check=False)
    assert done.returncode == 0, done.stderr[-2000:]
    meshes, errors = (int(part.split()[0]) for part in done.stdout.split(","))
    assert meshes + errors == CASES
    assert min(meshes, errors) > CASES // 30  # neither all good nor all bad: large pieces, cuts outside, nothing left


@pytest.mark.long
def test_many_more_drawings():
    code = f"import sys; sys.path.insert(0, {str(Path(__file__).parent)!r})\n"
    code += (
        "import warnings; warnings.simplefilter('ignore')\nimport test_mesher_fuzz as f\nprint(f.survey(10_000, 2000))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr[-2000:]


if __name__ == "__main__":
    warnings.simplefilter("ignore")
    print(survey(0, CASES))
