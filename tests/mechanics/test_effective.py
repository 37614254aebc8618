"""Effective properties of a mesh against published homogenisation results, and the warning about biased meshes."""

from __future__ import annotations

import warnings

import meshes
import numpy as np
import pytest
import shapely

import kirigami as kg

MATERIAL = kg.Material(E=2e6, nu=1 / 3)


def report(nodes, triangles, rung: str):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", kg.KirigamiWarning)
        return kg.stiffness.report(kg.TriMesh(nodes, triangles), 0.01, MATERIAL, rung)


def test_single_diagonals_are_stiff_along_them_and_soft_across() -> None:
    """Bars: E between 1/3 and 4/3; hinges: D between 3/4 and 3, on average 3/2 (exact for the periodic cell)."""
    properties = report(*meshes.right_isosceles(14, 14), "plate")
    mean, low, high = properties.ratios["E"]
    assert (mean, low, high) == pytest.approx((0.8475, 1 / 3, 4 / 3), abs=0.01)
    mean, low, high = properties.ratios["bending"]
    assert (mean, low, high) == pytest.approx((1.5, 0.75, 3.0), abs=0.03)
    assert set(properties.off()) == {"E", "G", "bending", "twisting"}


def test_union_jack() -> None:
    mean, low, high = report(*meshes.right_isosceles(14, 14, diagonals="union jack"), "plate").ratios["E"]
    assert (mean, low, high) == pytest.approx((0.949, 0.75, 1.2), abs=0.01)


@pytest.mark.parametrize("diagonals", ["one", "alternating"])
def test_curved_facets_have_no_bias(diagonals: str) -> None:
    properties = report(*meshes.right_isosceles(8, 6, diagonals=diagonals), "shell")
    for mean, low, high in properties.ratios.values():
        assert (mean, low, high) == pytest.approx((1.0, 1.0, 1.0), abs=1e-8)
    assert properties.nu == pytest.approx(MATERIAL.nu, abs=1e-9) and not properties.off()


def test_bending_of_hinges_has_the_wrong_poisson_ratio() -> None:
    """On good meshes a twist costs about twice what it should, D (1 + 1/3) over D (1 - 1/3)."""
    mesh = kg.Sheet(shapely.box(0, 0, 2, 2), thickness=0.01, material=MATERIAL).mesh(0.2)
    ratios = kg.stiffness.report(mesh).ratios
    assert ratios["bending"][0] == pytest.approx(1.05, abs=0.05)
    assert ratios["twisting"][0] == pytest.approx(2.05, abs=0.12)
    assert kg.stiffness.report(mesh).off() == ["twisting"]


def test_cuts_do_not_count_as_softness() -> None:
    slit = shapely.LineString([(0.5, 1), (1.5, 1)])
    mesh = kg.Sheet(shapely.box(0, 0, 2, 2), [slit], thickness=0.01, material=MATERIAL).mesh(0.2)
    assert kg.stiffness.report(mesh).ratios["E"][0] == pytest.approx(0.97, abs=0.05)


def test_the_published_constants_are_soft() -> None:
    ratios = report(*meshes.right_isosceles(14, 14), "paper").ratios
    assert ratios["bending"][0] == pytest.approx(1.5 * 0.125 / 48 * 12 * (1 - 1 / 9), rel=0.02)


def test_a_biased_mesh_is_warned_about_and_a_good_one_not() -> None:
    biased = kg.TriMesh(*meshes.right_isosceles(8, 8))
    with pytest.warns(kg.KirigamiWarning, match="biased"):
        kg.Model.from_mesh(biased, 0.01, MATERIAL)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        kg.Model.from_mesh(biased, 0.01, MATERIAL, stiffness="shell")
        kg.Model.from_mesh(kg.Sheet(shapely.box(0, 0, 2, 1)).mesh(0.08), 0.01, MATERIAL)


def test_a_folded_mesh_is_refused() -> None:
    with pytest.raises(kg.ModelError, match="not flat"):
        kg.stiffness.report(kg.TriMesh([[0, 0, 0], [1, 0, 0.2], [0, 1, 0]], [[0, 1, 2]]), 0.1, MATERIAL)


def test_a_mesh_without_inner_facets_has_no_bending_to_report() -> None:
    with pytest.raises(kg.ModelError, match="free edge"):
        kg.stiffness.report(kg.TriMesh(np.eye(3)[:, :2], [[0, 1, 2]]), 0.1, MATERIAL, "facet")
