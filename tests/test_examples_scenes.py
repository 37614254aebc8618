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


@pytest.mark.long
def test_fan_that_is_closed_is_as_stiff_as_if_nothing_had_been_cut() -> None:
    pytest.importorskip("ipctk")
    scenes = importlib.import_module("folded_and_pressed")
    solid = scenes.stored(scenes.fan(closing=True, cut=False))
    assert solid == pytest.approx(scenes.of_fibres(), rel=0.02)
    assert scenes.main() == pytest.approx(1.0, abs=0.07)  # the layer gives a little at each of five slits
    assert scenes.stored(scenes.fan(closing=False)) < 0.03 * solid


@pytest.mark.long
def test_card_folded_flat_and_spiral_pressed_back_balance() -> None:
    pytest.importorskip("ipctk")
    scenes = importlib.import_module("folded_and_pressed")
    card = scenes.folded()
    force, left = scenes.pressed(card)
    assert force > 1.0 and left < 1e-9 * force
    height = card.position()[-1, card.rest[:, 0] > 0.5 * scenes.WINDOW + 1e-9, 2]
    assert height == pytest.approx(0.9 * scenes.SHEET, rel=1e-6)
    disc = scenes.spiral()
    assert scenes.work(disc) == pytest.approx(scenes.stored(disc), rel=0.01)
    for res in (card, disc):
        kinds = {event.kind for event in res.events}
        assert {"contact", "yield"} <= kinds and "crossing" not in kinds
