"""The scenes of many effects among the examples, on coarse meshes, each held to a formula."""

from __future__ import annotations

import importlib
from pathlib import Path

import pytest

EXAMPLES = Path(__file__).parent.parent / "examples"


@pytest.fixture(autouse=True)
def beside_the_examples(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(str(EXAMPLES))


def test_lamp_hangs_as_twisted_strips_while_it_hangs_little() -> None:
    # Wahl's strips know neither the start nor the end of the slit; found 1.3 % below them.
    lamp = importlib.import_module("spiral_lamp")
    assert lamp.drop(lamp.hung([lamp.LITTLE]), lamp.LITTLE) == pytest.approx(
        lamp.drop_of_spring(lamp.LITTLE), rel=0.025
    )
