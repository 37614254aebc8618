"""The units of one page, picture or report."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from kirigami.units import unit_for

SCALES: dict[str, dict[str, tuple[str, float]]] = {  # units of a page, and their sizes, by that of its lengths
    "": {},
    **{
        unit: {
            "length": (unit, size), "area": (f"{unit}2", size**2), "torque": (f"N {unit}", size), "force": ("N", 1.0),
            "energy": ("J", 1.0),
        }
        for unit, size in (("m", 1.0), ("mm", 1e-3), ("um", 1e-6))
    },
}


@dataclass(frozen=True)
class Scale:
    """The units of one page, picture or report: one of length, and of areas and torques what belongs to it.

    Parameters
    ----------
    length : {"m", "mm", "um", ""}
        The unit of length; "" where no units are known: then numbers stand alone.

    Examples
    --------
    >>> from kirigami.scale import Scale
    >>> scale = Scale.of(0.2)  # of a sheet of 200 mm
    >>> scale.show(5e-6, "length"), scale.show(0.0016, "area"), scale.title("torque", "torque")
    ('0.005 mm', '1600 mm2', 'torque [N mm]')
    >>> Scale().show(5e-6, "length"), Scale().title("torque", "torque")
    ('5e-06', 'torque')
    """

    length: str = ""

    @classmethod
    def of(cls, size: float) -> Scale:
        """The scale of what has a largest side [m]."""
        return cls(unit_for(size, "length")[0])

    def unit(self, kind: str) -> tuple[str, float]:
        """The unit of a "length", "area", "torque", "force" or "energy", and its size in SI units."""
        return SCALES[self.length].get(kind, ("", 1.0))

    def show(self, value: float, kind: str, digits: int = 4) -> str:
        """A quantity in SI units as a person would write it."""
        unit, factor = self.unit(kind)
        return f"{value / factor:.{digits}g} {unit}".rstrip()

    def place(self, point: Iterable[float], digits: int = 4, named: bool = True) -> str:
        """A point in words, with or without its unit: "(12.5, 3) mm", "(12.5, 3)"."""
        unit, factor = self.unit("length")
        return f"({', '.join(f'{value / factor:.{digits}g}' for value in point)}) {unit if named else ''}".rstrip()

    def title(self, what: str, kind: str) -> str:
        """Words for a quantity, with its unit behind them where one is known."""
        unit = self.unit(kind)[0]
        return f"{what} [{unit}]" if unit else what


UNKNOWN = Scale()
