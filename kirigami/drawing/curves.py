"""Curves as readers find them: points with where they come from, their unit, and chords along what is smooth."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import shapely
from numpy.typing import NDArray

from kirigami.errors import GeometryError, KirigamiWarning
from kirigami.primitives.checks import shown
from kirigami.units import METRES, metres_per

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Curve:
    """One drawn curve as points (k, 2), with where it comes from; closed where the last point is the first.

    `fold` tells the side of a fold, positive a valley and negative a mountain, and how far it is folded where known.
    `bow` (k - 1,) is how far the true curve may lie from each chord: zero where it was drawn straight. `numbers` are
    those of the drawn curves that it was joined from.
    """

    points: Floats
    layer: str = ""
    color: str = ""
    source: str = ""
    line_type: str = ""
    bow: Floats | float = 0.0
    role: str = ""
    numbers: tuple[int, ...] = ()
    fold: float = 0.0

    @property
    def closed(self) -> bool:
        return len(self.points) > 3 and bool((self.points[0] == self.points[-1]).all())

    @property
    def length(self) -> float:
        return float(np.linalg.norm(np.diff(self.points, axis=0), axis=1).sum())

    def taken_as(self, role: str, number: int, fold: float) -> Curve:
        """The same as the curve of this number, with a role; `dataclasses.replace` would take several times as long."""
        return Curve(
            self.points, self.layer, self.color, self.source, self.line_type, self.bow, role, (number,), fold
        )

    @property
    def called(self) -> str:
        """Its source with layer and colour, for messages."""
        by = [f"layer {self.layer!r}"] if self.layer else []
        by += [self.color] if self.color else []
        return f"{self.source} ({', '.join(by)})" if by else self.source


def lines_of(curves: Sequence[Curve]) -> NDArray[np.object_]:
    """The curves as LineStrings, in one array."""
    if not curves:
        return np.empty(0, dtype=object)
    counts = [len(curve.points) for curve in curves]
    points = np.concatenate([curve.points for curve in curves])
    lines: NDArray[np.object_] = shapely.linestrings(points, indices=np.repeat(np.arange(len(curves)), counts))
    return lines


def scale_of(unit: str, drawn_in: str | None, stated: str | None, notes: list[str]) -> tuple[float, str]:
    """Factor from drawn numbers to the wanted unit, and the unit of the result; says what it assumes."""
    metres_per(unit)  # refused here, whether it is used or not
    if drawn_in is not None:
        metres_per(drawn_in)
    if drawn_in is None and stated is None:
        warnings.warn(
            f"the drawing names no unit: its numbers are taken as {unit}; "
            'say `drawn_in="mm"` (or what they are) to convert them',
            KirigamiWarning,
            stacklevel=3,
        )
        notes.append(f"no unit in the drawing: numbers taken as {unit}")
        return 1.0, unit
    source = drawn_in or stated or unit
    if drawn_in is None and source not in METRES:
        raise GeometryError(
            f"the drawing is in a unit that is not known, {shown(source)}: say `drawn_in='mm'`, or what it is"
        )
    notes.append(f"drawn in {source}, converted to {unit}")
    ratio = metres_per(source) / metres_per(unit)
    return (float(round(ratio)) if abs(ratio - round(ratio)) < 1e-12 * ratio else ratio), unit


def all_at_once(parts: Sequence[Floats], change: Callable[[Floats], Floats]) -> list[Floats]:
    """A function of rows, applied to all rows of many arrays in one call."""
    if not parts:
        return []
    whole = change(np.concatenate(parts))
    ends = np.cumsum([len(part) for part in parts]).tolist()
    return [whole[start:end] for start, end in zip([0, *ends], ends)]


def scaled(points: Floats, factor: float) -> Floats:
    """Points times a factor, dividing by whole numbers where that rounds less (mm to m)."""
    inverse = round(1 / factor)
    return points / inverse if factor < 1 and abs(inverse * factor - 1) < 1e-12 else points * factor


def flattened(position: Any, flatness: float) -> Floats:
    """Points along a smooth curve ``position(t)``, t in [0, 1] -> (k, 2), with chords nearer to it than `flatness`."""
    t = np.linspace(0.0, 1.0, 9)
    for _ in range(12):
        points, middles = position(t), position(0.5 * (t[1:] + t[:-1]))
        chord = points[1:] - points[:-1]
        length = np.maximum(np.linalg.norm(chord, axis=1), 1e-300)
        off = middles - points[:-1]
        height = np.abs(chord[:, 0] * off[:, 1] - chord[:, 1] * off[:, 0]) / length
        rough = height > flatness
        if not rough.any():
            break
        t = np.sort(np.concatenate([t, 0.5 * (t[1:] + t[:-1])[rough]]))
    return np.asarray(position(t), dtype=float)
