"""The folded skin of the crawler: free of stress when folded, fins that pop out, push back and press on the ground."""

from __future__ import annotations

import importlib.util
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import kirigami as kg

SMALL = {"rows": 3, "max_edge": 4.0}


@pytest.fixture(scope="module")
def crawler() -> Any:
    path = Path(__file__).parent.parent / "examples" / "crawler.py"
    specification = importlib.util.spec_from_file_location("small_crawler", path)
    assert specification is not None and specification.loader is not None
    module = importlib.util.module_from_spec(specification)
    import sys

    sys.modules["small_crawler"] = module  # dataclasses look it up; "crawler" is what other tests import, unchanged
    specification.loader.exec_module(module)
    module.STRAIN = 0.02
    return module


@pytest.fixture(scope="module")
def pulled(crawler: Any) -> tuple[Any, kg.Results]:
    body = crawler.skin("triangle", **SMALL)
    return body, crawler.stretched(body)


@pytest.mark.parametrize("shape", ["triangle", "circle", "trapezoid", "slit"])
def test_folding_makes_no_stress_and_keeps_faces_plane(crawler: Any, shape: str) -> None:
    body = crawler.skin(shape, 2, 5.0, lean=0.0)
    mesh, m = body.model.mesh, body.model
    system = kg.System(m)
    at_rest = np.zeros((len(m.nodes), 3))
    assert sum(system.energies(at_rest).values()) == 0.0
    assert not system.gradient(at_rest).any()
    # Developable: the angles of the facets about an inner node make a full turn.
    corners = mesh.nodes[mesh.triangles]
    ahead, behind = np.roll(corners, -1, axis=1) - corners, np.roll(corners, 1, axis=1) - corners
    cosine = (ahead * behind).sum(axis=2) / np.linalg.norm(ahead, axis=2) / np.linalg.norm(behind, axis=2)
    turn = np.bincount(mesh.triangles.ravel(), np.arccos(cosine).ravel())
    inner = np.setdiff1d(np.arange(len(turn)), mesh.boundary("free"))
    assert turn[inner] == pytest.approx(np.full(len(inner), 2 * np.pi), abs=1e-12)
    # Three plane faces: every hinge is flat or folded by the same angle, those on the two creases.
    angle = next(kernel for kernel in system.kernels if kernel.name == "hinges").deformation(system.rest)
    folded = np.abs(angle) > 1e-6
    assert np.abs(angle[~folded]).max() < 1e-12
    assert np.abs(np.abs(angle[folded]) - crawler.FOLD).max() < 1e-12
    assert mesh.facet_areas.sum() == pytest.approx(crawler.WIDTH * np.ptp(mesh.nodes[:, 0]), rel=1e-12)
    # The imperfection is free of stress as well.
    leaning = kg.System(crawler.skin(shape, 2, 5.0).model)
    assert sum(leaning.energies(at_rest).values()) == 0.0


def test_fins_pop_out_as_the_body_is_stretched(crawler: Any, pulled: tuple[Any, kg.Results]) -> None:
    body, res = pulled
    height = body.height(res)
    assert height[0] == pytest.approx(crawler.LEAN)
    assert (np.diff(height) > 0).all() and height[-1] > 8 * crawler.LEAN
    assert res.stable.all()
    assert res.reaction(body.right, "x") == pytest.approx(-res.reaction(body.left, "x"), rel=1e-6, abs=1e-9)


def test_fin_at_rest_is_alike_both_ways_to_first_order(crawler: Any, pulled: tuple[Any, kg.Results]) -> None:
    """What is different each way comes with displacement: a fin pushed against its tip buckles."""
    skin, at = crawler.skin("triangle", **SMALL), pulled[1][0]
    forces = crawler.pushed(skin, kg.Step.at(skin.model, at.lam, at.u), push=1e-5)[:, -1]
    assert forces[0] == pytest.approx(forces[1], rel=0.01)


def test_ground_carries_what_the_ends_are_pushed_up_with(crawler: Any) -> None:
    res, force, dent = crawler.pressed("triangle", **SMALL)
    ends = np.flatnonzero(res.constrained[:, 2])
    assert force[0] == 0 and force[-1] > 0
    assert res.reaction(ends, "z") == pytest.approx(-force, abs=1e-4 * force.max())
    assert dent.max() < 1e-3 * crawler.THICKNESS
    lowest = res.position()[..., 2].min(axis=1)
    assert lowest.min() > -crawler.GROUND - 1e-3 * crawler.THICKNESS


def test_popped_fin_is_stiffer_with_its_tip_and_friction_follows_the_height(
    crawler: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    found = crawler.main(**SMALL, shapes=("triangle",))["triangle"]
    assert found["with the tip"] / found["against it"] > 1.2
    per_area = 1 / (crawler.PITCH * crawler.SPACING)
    assert found["friction"] == pytest.approx(0.2 + crawler.ENGAGEMENT * found["height"] * per_area, rel=1e-12)
    assert found["friction"] > found["friction by area"] > crawler.BASE_FRICTION
    assert not list(tmp_path.iterdir())
