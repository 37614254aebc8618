"""Lattices of slits whose lengths, angles and spacings are functions of place: large sheets from few numbers."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely.geometry.base import BaseGeometry

from kirigami.errors import GeometryError
from kirigami.geometry.cuts import MOST, _require_apart
from kirigami.geometry.given import checked_outline
from kirigami.primitives.checks import require_array, require_not_negative, require_positive

Floats = NDArray[np.float64]
Field = float | Callable[[Floats, Floats], Any]
SLACK = 1e-9  # of the size


def graded_slits(
    outline: Any, spacing: Field, pitch: Field, length: Field, angle: Field = 0.0, margin: float = 0.0
) -> list[BaseGeometry]:
    """Rows of slits over any outline, every other row shifted by half a pitch; stretched along y, they open.

    Where the slits stand is said by `spacing` and `pitch` alone, so that their number and order stay when lengths and
    angles change, as a :class:`kirigami.Design` needs it.

    Parameters
    ----------
    outline : shapely.Polygon or sequence of (x, y)
        The sheet.
    spacing, pitch : float or callable
        Distance from row to row, told at the middle of a row, and from slit to slit along it, told at a slit [length]:
        a number, or ``function(x, y)``.
    length : float or callable
        Length of a slit [length], at its middle.
    angle : float or callable
        Its angle against the x axis, counter-clockwise [rad].
    margin : float
        Least distance [length] of the place of a slit, which is one pitch long, from the outline.

    Returns
    -------
    list of shapely.LineString

    Raises
    ------
    GeometryError
        Values that are not positive numbers, no slit that fits, slits that meet or leave the sheet, or more than
        100,000 in a row.

    Examples
    --------
    Slits that get longer towards the right:

    >>> import kirigami as kg
    >>> slits = kg.cuts.graded_slits([(0, 0), (6, 0), (6, 2), (0, 2)], 0.5, 1.0, lambda x, y: 0.3 + 0.08 * x)
    >>> len(slits), [round(slit.length, 2) for slit in slits[:3]]
    (22, [0.34, 0.42, 0.5])
    """
    sheet = checked_outline(outline)
    margin = require_not_negative(margin, "margin", "graded_slits", GeometryError)
    xmin, ymin, xmax, ymax = sheet.bounds
    middle, size = 0.5 * (xmin + xmax), max(xmax - xmin, ymax - ymin)
    room = sheet.buffer(-margin + SLACK * size)
    rows: list[float] = []
    y = ymin + 0.5 * _told(spacing, middle, ymin, "spacing")
    while y < ymax:
        rows.append(y)
        _limit(len(rows), "rows")
        y += _told(spacing, middle, y, "spacing")
    slits: list[BaseGeometry] = []
    for number, height in enumerate(rows):
        step = _told(pitch, xmin, height, "pitch")
        x = xmin + (0.5 * step if number % 2 == 0 else step)
        count = 0
        while x < xmax:
            step = _told(pitch, x, height, "pitch")
            place = shapely.LineString([(x - 0.5 * step, height), (x + 0.5 * step, height)])
            if room.covers(place):
                slits.append(_slit(x, height, length, angle))
            x += step
            count += 1
            _limit(count, "slits in a row")
    if not slits:
        raise GeometryError("graded_slits: no slit fits into the outline: give a smaller spacing, pitch or margin")
    for slit in slits:
        if not sheet.contains(slit):
            x, height = slit.centroid.coords[0]
            raise GeometryError(f"graded_slits: the slit at ({x:.6g}, {height:.6g}) leaves the sheet: make it shorter")
    _require_apart(slits, "make the slits shorter, or spacing and pitch larger")
    return slits


def _told(field: Field, x: float, y: float, name: str, positive: bool = True) -> float:
    """A field at one point."""
    value = field(np.array([x]), np.array([y])) if callable(field) else field
    number = require_array(value, (), (1,), name=name, owner="graded_slits", error=GeometryError).ravel()[0]
    return require_positive(float(number), name, "graded_slits", GeometryError) if positive else float(number)


def _slit(x: float, y: float, length: Field, angle: Field) -> BaseGeometry:
    half, turn = 0.5 * _told(length, x, y, "length"), _told(angle, x, y, "angle", positive=False)
    along = half * np.array([np.cos(turn), np.sin(turn)])
    return shapely.LineString([(x - along[0], y - along[1]), (x + along[0], y + along[1])])


def _limit(count: int, what: str) -> None:
    if count > MOST:
        raise GeometryError(f"graded_slits: more than {MOST:,} {what}: are spacing and pitch right?")
