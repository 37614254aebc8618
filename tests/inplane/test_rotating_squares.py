"""Rotating squares: Poisson's ratio, force law, contact, opening of the closed state."""

from __future__ import annotations

import numpy as np
import pytest
from lattices import script

import kirigami as kg

EXAMPLE = script("examples", "rotating_squares")
Pulled = tuple[kg.Results, np.ndarray, np.ndarray, np.ndarray]  # results, force, strain along, strain across


@pytest.fixture(scope="module")
def pulled() -> Pulled:
    _, results, force, along, across = EXAMPLE.stretch(angle=0.3, strain=0.2)
    return results, force, along, across


def test_poissons_ratio_is_minus_one_at_every_strain(pulled: Pulled) -> None:
    _, _, along, across = pulled
    assert across[1:] / along[1:] == pytest.approx(1.0, abs=1e-3)


def test_force_law(pulled: Pulled) -> None:
    """F = 2 J 2 k (phi - phi0) / (N l (cos phi - sin phi)), bars 1e6 times stiffer than springs."""
    results, force, along, _ = pulled
    assert force[1:] == pytest.approx(EXAMPLE.expected_force(0.3, along)[1:], rel=1e-3)
    assert results.energy["bars"][-1] < 1e-3 * results.energy["springs"][-1]
    assert results.stable.all()


def test_contact_stops_the_closing() -> None:
    """Squeezed past closing: without contact panels pass through each other, with it they do not."""
    _, free, force_free, _, _ = EXAMPLE.stretch(angle=0.3, strain=-0.13)
    _, stopped, force_stopped, _, _ = EXAMPLE.stretch(angle=0.3, strain=-0.13, limit=True)
    assert "angle limits" not in free.energy
    assert force_stopped[-1] < 5 * force_free[-1] < 0
    # Closing needs a strain of 1 - 1 / (cos phi0 + sin phi0) = 0.115
    assert force_stopped[stopped.lam < 0.5] == pytest.approx(
        np.interp(stopped.lam[stopped.lam < 0.5], free.lam, force_free), rel=0.02, abs=1e-3
    )


def test_pressed_shut_squares_open_at_a_threshold() -> None:
    """Closing moment M0 in every joint: stiff up to 2 J M0 / (N l), the closed form beyond."""
    force, along = EXAMPLE.open_closed(closing_moment=0.2, strain=0.04)
    threshold = float(EXAMPLE.expected_force(0.0, np.zeros(1), closing_moment=0.2)[0])
    assert threshold == pytest.approx(2 * 24 * 0.2 / 4)
    assert np.interp(0.8 * threshold, force, along) < 2e-3
    far = along > 0.015
    assert far.sum() >= 2
    assert force[far] == pytest.approx(EXAMPLE.expected_force(0.0, along[far], closing_moment=0.2), rel=5e-3)
