"""Numbers in words: of things, and shares."""

from __future__ import annotations

from decimal import Decimal
from math import isfinite

LEAST = 1e-6  # per cent that are written out


def counted(number: float, what: str, many: str | None = None, *, spec: str = "") -> str:
    """A number of things: "1 curve", "2 curves".

    Parameters
    ----------
    number : int or float
        How many.
    what : str
        One of them.
    many : str, optional
        Several of them, where that is not `what` with an s.
    spec : str
        How the number is written, as in ``f"{number:,}"``. What is written "1" is one.

    Examples
    --------
    >>> from kirigami.words import counted
    >>> counted(1, "cut"), counted(0, "cut"), counted(1200, "vertex", "vertices", spec=","), counted(1.5, "degree")
    ('1 cut', '0 cuts', '1,200 vertices', '1.5 degrees')
    """
    text = format(number, spec)
    return f"{text} {what if text == '1' else many or f'{what}s'}"


def percent(share: float, digits: int = 2) -> str:
    """A share in per cent, as people write it: without powers of ten.

    Parameters
    ----------
    share : float
        1 is all.
    digits : int
        How many count.

    Examples
    --------
    >>> from kirigami.words import percent
    >>> percent(0.01234), percent(3.31), percent(1.6e-7)
    ('1.2 %', '330 %', '0.000016 %')
    """
    rounded = f"{100 * share:.{digits}g}"
    if 0 < abs(float(rounded)) < LEAST:
        return f"under {LEAST:f} %"
    return f"{Decimal(rounded):f} %" if isfinite(share) else f"{share:g} %"
