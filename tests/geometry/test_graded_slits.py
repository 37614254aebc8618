"""Lattices of slits by fields: counts, lengths, room; what does not fit is refused; out to the cutter and back."""

from __future__ import annotations

import numpy as np
import pytest
import shapely

import kirigami as kg

DISC = shapely.Point(0, 0).buffer(1.0, quad_segs=32)


def test_lengths_and_angles_are_those_of_the_fields():
    slits = kg.cuts.graded_slits(DISC, 0.2, 0.4, lambda x, y: 0.15 + 0.05 * x, lambda x, y: 0.3 * y, margin=0.05)
    for slit in slits:
        x, y = slit.centroid.coords[0]
        (a, b), (c, d) = slit.coords
        assert slit.length == pytest.approx(0.15 + 0.05 * x, rel=1e-9)
        assert np.arctan2(d - b, c - a) == pytest.approx(0.3 * y, abs=1e-9)
        assert DISC.boundary.distance(shapely.LineString([(x - 0.2, y), (x + 0.2, y)])) >= 0.05 - 1e-6


def test_number_and_places_do_not_depend_on_lengths():
    one, other = (kg.cuts.graded_slits(DISC, 0.2, 0.4, length) for length in (0.1, 0.35))
    places = [np.array([s.centroid.coords[0] for s in slits]) for slits in (one, other)]
    assert places[0] == pytest.approx(places[1], abs=1e-12)


def test_spacing_follows_its_field():
    slits = kg.cuts.graded_slits(shapely.box(0, 0, 4, 10), lambda x, y: 0.2 + 0.1 * y, 1.0, 0.3)
    rows = np.unique([round(s.centroid.y, 9) for s in slits])
    assert np.diff(rows) == pytest.approx(0.2 + 0.1 * rows[:-1])


def test_out_to_the_cutter_and_back(tmp_path):
    pytest.importorskip("ezdxf")
    slits = kg.cuts.graded_slits(shapely.box(0, 0, 4, 2), 0.5, 1.0, lambda x, y: 0.3 + 0.1 * x)
    kg.Sheet(shapely.box(0, 0, 4, 2), slits).to_dxf(tmp_path / "sheet.dxf")
    back = kg.Sheet.from_dxf(tmp_path / "sheet.dxf")
    assert len(back.cuts) == len(slits)
    assert sum(cut.length for cut in back.cuts) == pytest.approx(sum(slit.length for slit in slits), rel=1e-6)


def test_what_does_not_fit():
    box = shapely.box(0, 0, 4, 2)
    with pytest.raises(kg.GeometryError, match="touch at"):
        kg.cuts.graded_slits(box, 0.5, 1.0, 1.0)
    with pytest.raises(kg.GeometryError, match="no slit fits"):
        kg.cuts.graded_slits(box, 0.5, 9.0, 1.0)
    with pytest.raises(kg.GeometryError, match="length must be positive"):
        kg.cuts.graded_slits(box, 0.5, 1.0, lambda x, y: -x)
