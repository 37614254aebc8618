"""The friction law: the flat sheet's coefficient without pop-out or cuts, linear in each factor."""

from __future__ import annotations

import numpy as np
import pytest

import kirigami as kg
from kirigami.post.friction import friction_coefficient

LAW = {"base": 0.2, "engagement": 0.3}
VALUES = {"height": 1.7e-3, "density": 1.1e4, "surface_factor": 0.15}


def test_base_value_without_pop_out_cuts_or_footprint() -> None:
    for name in VALUES:
        assert friction_coefficient(**{**VALUES, name: 0.0}, **LAW) == 0.2  # type: ignore[arg-type]


@pytest.mark.parametrize("name", VALUES)
def test_linear_in_each_factor(name: str) -> None:
    factors = np.array([0.5, 1.0, 2.0, 7.0])
    mu = friction_coefficient(**{**VALUES, name: factors * VALUES[name]}, **LAW)  # type: ignore[arg-type]
    one = 0.3 * 1.7e-3 * 1.1e4 * 0.15
    assert mu - 0.2 == pytest.approx(factors * one, rel=1e-12)


def test_same_in_any_unit_of_length() -> None:
    """K_f is a length: in mm everything changes but the coefficient."""
    in_mm = friction_coefficient(1.7, 1.1e4 * 1e-6, 0.15, base=0.2, engagement=300.0)
    assert in_mm == pytest.approx(friction_coefficient(**VALUES, **LAW), rel=1e-12)


def test_a_curve_for_each_density() -> None:
    heights, densities = np.linspace(0, 1e-3, 5), np.array([[1e3], [2e3]])
    mu = friction_coefficient(heights, densities, 0.1, **LAW)
    assert mu.shape == (2, 5) and (np.diff(mu, axis=1) > 0).all()


def test_wrong_values_are_refused() -> None:
    for change, words in (({"height": -1.0}, "height"), ({"density": np.nan}, "density"), ({"base": "low"}, "base"),
                          ({"height": [1, 2], "density": [1, 2, 3]}, "do not fit")):  # fmt: skip
        with pytest.raises(kg.ModelError, match=words):
            friction_coefficient(**{**VALUES, **LAW, **change})  # type: ignore[arg-type]
