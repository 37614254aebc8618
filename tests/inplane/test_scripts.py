"""Examples of the in-plane part run, and give the number they are about."""

from __future__ import annotations

import pytest
from lattices import script


def test_nonreciprocal_lattice() -> None:
    """A fine model of a shorter row confirms the transmitted displacements; here the share stays where it is."""
    assert script("examples", "nonreciprocal_lattice").main() == pytest.approx(0.540, abs=0.005)


def test_polarised_lattice() -> None:
    """Contrast 22 over 5.9 in the table of edge stiffness."""
    assert script("examples", "polarised_lattice").main(angles=(1.08, 1.92)) == pytest.approx(22 / 5.9, rel=0.05)


def test_rotating_squares() -> None:
    assert script("examples", "rotating_squares").main() < 1e-3
