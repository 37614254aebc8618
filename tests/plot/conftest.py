"""Results to draw, and figures closed after each test."""

from __future__ import annotations

from collections.abc import Iterator

import matplotlib
import pytest
from matplotlib import pyplot
from plot_samples import sheet_model, truss

import kirigami as kg

matplotlib.use("Agg")


@pytest.fixture(autouse=True)
def _close_figures() -> Iterator[None]:
    yield
    pyplot.close("all")


@pytest.fixture(scope="module")
def snapped() -> tuple[kg.Results, kg.Node, kg.Node]:
    m, left, apex = truss()
    return kg.DisplacementControl(m, to=-2.0, control=(apex, "y")).run(), left, apex


@pytest.fixture(scope="module")
def lifted() -> kg.Results:
    return kg.DisplacementControl(sheet_model(), targets=[0.1, 0.5]).run()
