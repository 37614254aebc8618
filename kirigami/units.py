"""Quantities written with their unit, as on a command line: "0.1mm", "3.5GPa", "20%"."""

from __future__ import annotations

import math
import re

from kirigami.errors import ModelError
from kirigami.primitives.checks import require_choice, require_finite, require_not_negative

METRES = {
    "m": 1.0, "km": 1e3, "dm": 0.1, "cm": 1e-2, "mm": 1e-3, "um": 1e-6, "µm": 1e-6, "nm": 1e-9,
    "in": 0.0254, "inch": 0.0254, '"': 0.0254, "mil": 2.54e-5, "ft": 0.3048, "pt": 0.0254 / 72, "px": 0.0254 / 96,
}  # fmt: skip
UNITS: dict[str, dict[str, float]] = {
    "length": METRES,
    "stress": {
        "Pa": 1.0, "kPa": 1e3, "MPa": 1e6, "GPa": 1e9, "TPa": 1e12, "N/m2": 1.0, "N/mm2": 1e6, "bar": 1e5,
        "psi": 6894.757293168, "ksi": 6894757.293168,
    },
    "force": {"N": 1.0, "mN": 1e-3, "uN": 1e-6, "kN": 1e3, "lbf": 4.4482216152605, "gf": 9.80665e-3, "kgf": 9.80665},
    "torque": {"Nm": 1.0, "N m": 1.0, "N*m": 1.0, "mNm": 1e-3, "Nmm": 1e-3, "N mm": 1e-3, "N*mm": 1e-3, "kNm": 1e3},
    "density": {"kg/m3": 1.0, "g/cm3": 1e3, "g/cc": 1e3},
    "ratio": {"%": 1e-2, "": 1.0},
}  # fmt: skip
STEPS = {  # units, their sizes, and from where on they are used
    "length": (("m", 1.0, 1.0), ("mm", 1e-3, 1e-5), ("um", 1e-6, 0.0)),
    "area": (("m2", 1.0, 1.0), ("cm2", 1e-4, 1e-5), ("mm2", 1e-6, 0.0)),
    "stress": (("GPa", 1e9, 1e9), ("MPa", 1e6, 1e6), ("kPa", 1e3, 1e3), ("Pa", 1.0, 0.0)),
    "force": (("kN", 1e3, 1e3), ("N", 1.0, 0.1), ("mN", 1e-3, 1e-4), ("uN", 1e-6, 0.0)),
    "torque": (("N m", 1.0, 1.0), ("N mm", 1e-3, 1e-4), ("uN m", 1e-6, 0.0)),
    "energy": (("J", 1.0, 1.0), ("mJ", 1e-3, 1e-4), ("uJ", 1e-6, 0.0)),
    "energy per area": (("J/m2", 1.0, 0.1), ("mJ/m2", 1e-3, 0.0)),
}
_QUANTITY = re.compile(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*(.*?)\s*")


def metres_per(unit: str) -> float:
    """Length of one `unit` in metres.

    Parameters
    ----------
    unit : str
        "mm", "in", ...

    Raises
    ------
    ModelError
        The unit is unknown; the message lists those there are.

    Examples
    --------
    >>> from kirigami.units import metres_per
    >>> metres_per("mm")
    0.001
    """
    return METRES[require_choice(unit, METRES, "unit of length", "units")]


def parse(text: str | float, kind: str) -> float:
    """A quantity in SI units.

    Parameters
    ----------
    text : str or float
        Number and unit. A number alone is in SI units (metres, pascals, kg/m3, a ratio).
    kind : {"length", "stress", "force", "torque", "density", "ratio"}
        What it must be.

    Raises
    ------
    ModelError
        No number, a unit of another kind or none that is known, or a value that is not finite.

    Examples
    --------
    >>> from kirigami.units import parse
    >>> parse("0.1mm", "length"), parse("3.5 GPa", "stress"), parse("20%", "ratio")
    (0.0001, 3500000000.0, 0.2)
    """
    known = UNITS[require_choice(kind, UNITS, "kind", "units.parse")]
    if not isinstance(text, str):
        text = repr(require_finite(text, f"a {kind}", "units.parse"))
    match = _QUANTITY.fullmatch(text)
    if not match:
        raise ModelError(f"{text!r} is no {kind}: write a number and a unit, such as {_example(kind)}")
    number, unit = float(match[1]), match[2].replace("^", "").replace("²", "2").replace("³", "3")
    if unit and unit not in known:
        other = next((name for name, units in UNITS.items() if unit in units), None)
        alike = next((name for name in known if name.lower() == unit.lower()), None)
        why = f"{unit!r} is a unit of {other}" if other else f"the unit {unit!r} is unknown"
        why += f" (did you mean {alike}?)" if alike else ""
        raise ModelError(f"{text!r}: {why}; a {kind} takes {', '.join(filter(None, known))}")
    # Dividing by the whole number of small units rounds once, where multiplying by 1e-3 would round twice.
    factor = known[unit] if unit else 1.0
    inverse = round(1 / factor)
    value = number / inverse if factor < 1 and math.isclose(inverse * factor, 1.0, rel_tol=1e-15) else number * factor
    if not math.isfinite(value):
        raise ModelError(f"{text!r} is not a finite {kind}")
    return value


def _example(kind: str) -> str:
    return {
        "length": "0.1mm", "stress": "3.5GPa", "force": "2N", "torque": "5Nmm", "density": "1390kg/m3", "ratio": "20%",
    }[kind]  # fmt: skip


def show(value: float, kind: str) -> str:
    """A quantity in SI units as a person would write it.

    Parameters
    ----------
    value : float
        In SI units.
    kind : {"length", "area", "stress", "force", "torque", "energy", "energy per area", "density", "ratio"}
        What it is; areas to four digits.

    Examples
    --------
    >>> from kirigami.units import show
    >>> show(1e-4, "length"), show(3.5e9, "stress"), show(0.2, "ratio")
    ('0.1 mm', '3.5 GPa', '20 %')
    """
    require_choice(kind, {**UNITS, **STEPS}, "kind", "units.show")
    value = require_finite(value, "value", "units.show")
    if kind == "ratio":
        return f"{100 * value:.6g} %"
    if kind == "density":
        return f"{value:.6g} kg/m3"
    unit, factor = unit_for(value, kind)
    return f"{value / factor:.{4 if kind == 'area' else 6}g} {unit}"


def unit_for(value: float, kind: str) -> tuple[str, float]:
    """The unit in which a person would write a quantity, and its size in SI units.

    Parameters
    ----------
    value : float
        The quantity, or the largest of many, in SI units.
    kind : {"length", "area", "stress", "force", "torque", "energy", "energy per area"}
        What it is.

    Examples
    --------
    >>> from kirigami.units import unit_for
    >>> unit_for(0.02, "length"), unit_for(3e7, "stress")
    (('mm', 0.001), ('MPa', 1000000.0))
    """
    value = abs(require_finite(value, "value", "units.unit_for"))
    steps = STEPS[require_choice(kind, STEPS, "kind", "units.unit_for")]
    return next((unit, factor) for unit, factor, least in steps if value >= least)


def doubts(*, thickness: float, size: float, E: float, strain: float, imperfection: float = 0.0) -> list[str]:
    """What looks like a slip of units, in words; an empty list where all is plausible.

    Parameters
    ----------
    thickness, size : float
        Of the sheet [m]; size is its longer side.
    E : float
        Young's modulus [Pa].
    strain : float
        Largest strain asked for.
    imperfection : float
        How far from flat the sheet is taken to be [m].

    Examples
    --------
    >>> from kirigami.units import doubts
    >>> doubts(thickness=1e-4, size=0.2, E=3.5e9, strain=0.2)
    []
    >>> doubts(thickness=0.1, size=0.2, E=3.5e9, strain=20)
    ['the thickness 100 mm is 50 % of the size 200 mm: not a thin sheet', 'a strain of 2000 %: was 20 % meant?']
    """
    thickness = require_not_negative(thickness, "thickness", "units.doubts")
    size = require_not_negative(size, "size", "units.doubts")
    E, strain = require_finite(E, "E", "units.doubts"), require_finite(strain, "strain", "units.doubts")
    imperfection = abs(require_finite(imperfection, "imperfection", "units.doubts"))
    found = []
    if imperfection > 0.1 * size:
        found.append(f"an imperfection of {show(imperfection, 'length')} is no small one of a sheet of "
                     f"{show(size, 'length')}: it is another shape")  # fmt: skip
    if thickness > 0.1 * size:
        share = show(thickness / size, "ratio") if size else "more than all"
        found.append(f"the thickness {show(thickness, 'length')} is {share} of the size {show(size, 'length')}: "
                     "not a thin sheet")  # fmt: skip
    if thickness < 1e-6 * size:
        found.append(f"the thickness {show(thickness, 'length')} is less than a millionth of the size "
                     f"{show(size, 'length')}")  # fmt: skip
    if not 1e3 <= E <= 1.5e12:
        found.append(f"a Young's modulus of {show(E, 'stress')} is outside what sheets are made of (1 kPa to 1.5 TPa)")
    if not 1e-6 <= size <= 100:
        found.append(f"the sheet measures {show(size, 'length')}: is the unit of the drawing right?")
    if abs(strain) > 5:
        found.append(f"a strain of {show(strain, 'ratio')}: was {strain:.6g} % meant?")
    return found
