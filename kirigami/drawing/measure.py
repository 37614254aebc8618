"""How messages about a drawing give lengths and places: in the unit in which it was drawn."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from kirigami.drawing.curves import Curve, Floats
from kirigami.units import metres_per

SIGNS = 6  # digits of a coordinate


@dataclass(frozen=True)
class Measure:
    """Lengths and places of a drawing in words.

    Attributes
    ----------
    unit : str
        Unit of the coordinates.
    shown : str
        Unit that is shown.
    size : float
        Size of the drawing, in the unit of the coordinates.
    """

    unit: str
    shown: str
    size: float

    @property
    def factor(self) -> float:
        return metres_per(self.unit) / metres_per(self.shown)

    def _number(self, value: float, digits: int = SIGNS) -> str:
        within = float(np.round(value * self.factor, 12 - int(np.ceil(np.log10(max(self.size * self.factor, 1e-300))))))
        return f"{within + 0.0:.{digits}g}"

    def length(self, value: float) -> str:
        """A length: "0.02 mm"."""
        return f"{self._number(value, 3)} {self.shown}"

    def point(self, point: Floats | Sequence[float]) -> str:
        """A place without its unit: "(90, 10)"."""
        return f"({self._number(float(point[0]))}, {self._number(float(point[1]))})"

    def box(self, bounds: Any) -> str:
        """Where something lies: "x 2 to 4, y 1 to 3 mm"."""
        x0, y0, x1, y1 = (self._number(float(value)) for value in bounds)
        return f"x {x0} to {x1}, y {y0} to {y1} {self.shown}"

    def extent(self, bounds: Any) -> str:
        """How large something is: "80 x 40 mm"."""
        x0, y0, x1, y1 = (float(value) for value in bounds)
        return f"{self._number(x1 - x0)} x {self._number(y1 - y0)} {self.shown}"

    def area(self, value: float) -> str:
        """An area: "40 mm2"."""
        return f"{value * self.factor**2:.4g} {self.shown}2"

    def tolerance(self, length: float) -> tuple[float, str, str]:
        """The round share of the size just above a length, the same as text, and as a length with its unit."""
        exponent = int(np.floor(np.log10(length * 1.02 / self.size)))
        digit = int(np.ceil(length * 1.02 / self.size / 10.0**exponent))
        share = float(f"{digit}e{exponent}")
        return share, f"{digit}e{exponent}", f"{self._number(share * self.size, 3)}{self.shown}"

    def curves(self, curves: Sequence[Curve], most: int = 3) -> str:
        """The first few curves with their places."""
        few = [f"{curve.called} at {self.box([*curve.points.min(axis=0), *curve.points.max(axis=0)])}"
               for curve in curves[:most]]  # fmt: skip
        return "; ".join(few) + (f"; and {len(curves) - most} more" if len(curves) > most else "")
