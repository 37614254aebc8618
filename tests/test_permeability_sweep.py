"""The permeability study on a handful of small sheets, and its statistics on tables whose answer is known."""

from __future__ import annotations

import importlib.util
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import kirigami as kg

EXAMPLE = Path(__file__).parent.parent / "examples" / "permeability_sweep.py"


@pytest.fixture(scope="module")
def study() -> Any:
    specification = importlib.util.spec_from_file_location("permeability_sweep", EXAMPLE)
    assert specification is not None and specification.loader is not None
    module = importlib.util.module_from_spec(specification)
    specification.loader.exec_module(module)
    return module


def test_the_75_designs_fill_their_ranges(study: Any) -> None:
    designs = kg.latin_hypercube(study.RANGES, 75, seed=study.SEED)
    for name in ("length_ratio", "depth_ratio", "stretch"):
        low, high = study.RANGES[name]
        assert sorted(int(75 * (design[name] - low) / (high - low)) for design in designs) == list(range(75))
    for name in ("cells_across", "cells_along"):
        low, high = study.RANGES[name]
        assert {design[name] for design in designs} == set(range(low, high + 1))


def test_small_sheets(study: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """More stretch opens every cut further; a design that cannot be drawn is a row that says so."""
    common = {"cells_across": 1, "cells_along": 2, "length_ratio": 3.0, "depth_ratio": 0.8}
    designs = [{**common, "stretch": 0.06}, {**common, "stretch": 0.1}, {**common, "stretch": 0.1, "length_ratio": 1.0}]
    monkeypatch.setattr(kg, "latin_hypercube", lambda ranges, n, seed: designs)
    table = study.sweep(3, {}, tmp_path / "small", executor=ThreadPoolExecutor(1))
    low, high, refused = table
    assert refused["status"] == "failed" and refused["error"].startswith("GeometryError: cuts 0 and")
    assert "design 2 failed: GeometryError" in table.summary()
    drawn = kg.cuts.curved_cells(1, 2, length_ratio=3.0, depth_ratio=0.8, points=study.EDGES_PER_CUT + 1)
    assert low["cut_length"] == pytest.approx(sum(cut.length for cut in drawn) / (2.0 * 2.4), rel=1e-3)
    assert 0 < low["open_area"] < high["open_area"] < 0.5 and low["cuts"] == 8
    # Both pass through 5 % stretch, up to which of its stable shapes the sheet snaps into (they differ by 4.5 %).
    assert low["permeability_at_least_stretch"] == pytest.approx(high["permeability_at_least_stretch"], rel=1e-6)
    assert low["permeability_at_least_stretch"] < low["permeability"] < high["permeability"]


def made(**columns: np.ndarray) -> kg.SweepTable:
    names = list(columns)
    rows = [dict(zip(names, values)) | {"status": "done", "seconds": 1.0} for values in zip(*columns.values())]
    return kg.SweepTable(rows, [*names, "status", "seconds"])


def test_statistics_of_a_known_law(study: Any) -> None:
    rng = np.random.default_rng(4)
    area = rng.uniform(0.05, 0.3, 60)
    table = made(open_area=area, permeability=7.0 * area**3, cuts=rng.permutation(60), stretch=0.05 + 0 * area)
    assert study.fit(table) == pytest.approx((3.0, 7.0, 1.0), rel=1e-9)
    assert study.fit(table, 1 / area) == pytest.approx((2.0, 7.0, 1.0), rel=1e-9)
    assert study.rank_correlation(table, "open_area") == pytest.approx(1.0)
    assert abs(study.rank_correlation(table, "cuts")) < 4 / np.sqrt(60)
    tight, wide = study.pair_to_show(table)
    assert (tight["open_area"], wide["open_area"]) == (area.min(), area.max())


def test_the_pair_is_stretched_alike(study: Any) -> None:
    table = made(permeability=np.array([1.0, 2.0, 50.0, 9.0]), stretch=np.array([0.10, 0.104, 0.2, 0.101]))
    tight, wide = study.pair_to_show(table)
    assert (tight["permeability"], wide["permeability"]) == (1.0, 9.0)
