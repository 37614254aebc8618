"""The two grips of a sheet: where they lie along the direction of a pull, and how they hold it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kirigami.errors import ModelError
from kirigami.geometry.sheet import Sheet
from kirigami.model.constraints import Fix, Prescribe
from kirigami.model.model import Model
from kirigami.model.turn import Turn
from kirigami.primitives.checks import require_finite
from kirigami.primitives.node import Node
from kirigami.words import counted

STRIP = 0.04  # of the length, where the end of a sheet is no straight edge to hold
STRAIGHT = 0.2  # of the width: what counts as a straight edge
LONGEST = 0.45  # of the length: the longest strip that leaves something between the grips
NAMES = {(1.0, 0.0): ("left", "right"), (0.0, 1.0): ("bottom", "top"), (-1.0, 0.0): ("right", "left"),
         (0.0, -1.0): ("top", "bottom")}  # fmt: skip


def pull_direction(direction: str | float) -> NDArray[np.float64]:
    """Unit vector (2,) of "x", "y" or an angle in degrees from x, counter-clockwise.

    Examples
    --------
    >>> from kirigami.study.grips import pull_direction
    >>> pull_direction("y").tolist(), pull_direction(60).round(3).tolist()
    ([0.0, 1.0], [0.5, 0.866])
    """
    if isinstance(direction, str) and direction in ("x", "y"):
        angle = 90.0 * ("xy".index(direction))
    elif isinstance(direction, str) or isinstance(direction, bool):
        raise ModelError(f"direction must be 'x', 'y' or an angle in degrees, got {direction!r}")
    else:
        angle = require_finite(direction, "direction (an angle in degrees)", "stretch") % 360.0
    turns = angle / 90.0
    if turns == round(turns):  # exact, so that a pull along an axis prescribes nothing across it
        x, y = ((1, 0), (0, 1), (-1, 0), (0, -1))[round(turns) % 4]
        return np.array([x, y], dtype=float)
    return np.array([math.cos(math.radians(angle)), math.sin(math.radians(angle))])


@dataclass(frozen=True)
class Grips:
    """The two ends of a sheet along a direction, of which the first is held and the second moved.

    Attributes
    ----------
    direction : ndarray, shape (2,)
        Unit vector from the held end to the moved one.
    first, last : float
        Where the sheet begins and ends along the direction [length].
    strip : float
        Length of the strip that is held at each end [length]; 0 where the edges alone are.
    across : tuple of float
        Where the sheet begins and ends across the direction [length].
    """

    direction: NDArray[np.float64]
    first: float
    last: float
    strip: float
    across: tuple[float, float]

    @property
    def length(self) -> float:
        """Length of the sheet along the direction."""
        return self.last - self.first

    @property
    def free_length(self) -> float:
        """Length between the grips: what a strain is taken of."""
        return self.length - 2 * self.strip

    @property
    def sideways(self) -> NDArray[np.float64]:
        """Unit vector (2,) across the direction, towards larger x, or larger y for a pull along x."""
        x, y = self.direction.tolist()
        return np.array([y, -x] if y > 0 or (y == 0 and x < 0) else [-y, x])

    @property
    def names(self) -> tuple[str, str]:
        """The held end and the moved one in words."""
        x, y = self.direction.tolist()
        if (x, y) in NAMES:
            return NAMES[x, y]
        angle = math.degrees(math.atan2(y, x)) % 360
        back, ahead = (counted(way % 360, "degree", spec=".6g") for way in (angle + 180, angle))
        return f"end towards {back}", f"end towards {ahead}"

    def lines(self) -> dict[str, Any]:
        """The inner ends of strips, to be mesh edges; nothing where edges are held."""
        from shapely import LineString

        if not self.strip:
            return {}
        normal = np.array([-self.direction[1], self.direction[0]])
        ends = self.first + self.strip, self.last - self.strip
        return {
            f"grip {k}": LineString([along * self.direction + side * normal for side in self.across])
            for k, along in enumerate(ends)
        }

    def hold(
        self, model: Model, pull: float, shear: float = 0.0, twist: float = 0.0
    ) -> tuple[list[Node], list[Node]]:
        """Clamp both ends of a model made from a mesh and drive one along [length], across [length] and about [degrees]
        the direction; returns the held and the moved nodes."""
        assert model.mesh is not None
        along = model.mesh.nodes[:, :2] @ self.direction
        slack = 1e-9 * model.mesh.size
        held = model.select(index=np.flatnonzero(along <= along.min() + self.strip + slack))
        moved = model.select(index=np.flatnonzero(along >= along.max() - self.strip - slack))
        model.add(Fix(held, clamp=True))
        by = pull * self.direction + shear * self.sideways
        if twist:
            axis = np.append(self.direction, 0.0)
            centre = self.last * self.direction + 0.5 * sum(self.across) * np.array(
                [-self.direction[1], self.direction[0]]
            )
            model.add(Turn(moved, twist, axis, about=centre, shift=by, clamp=True))
            return held, moved
        x, y = (share if share else None for share in by.tolist())
        still = ("x" if x is None else "") + ("y" if y is None else "") + "z"
        model.add(Fix(moved, still, clamp=True), Prescribe(moved, x=x, y=y))
        return held, moved


def find_grips(sheet: Sheet, direction: str | float = "y", strip: float | None = None) -> Grips:
    """The grips of a sheet: its straight edges at the two extremes along a direction, or strips there.

    Parameters
    ----------
    sheet : Sheet
        The sheet.
    direction : "x", "y" or float
        Of the pull; an angle is in degrees from x, counter-clockwise.
    strip : float, optional
        Length of the strips that are held [length]; 0 holds the edges alone. None takes 0 where both ends are straight
        over a fifth of the width, else 4 % of the length.

    Raises
    ------
    ModelError
        No such direction, or strips that leave nothing between them.

    Examples
    --------
    >>> import kirigami as kg
    >>> from kirigami.study.grips import find_grips
    >>> import shapely
    >>> find_grips(kg.Sheet(shapely.box(0, 0, 1, 2)), "y").free_length
    2.0
    >>> round(find_grips(kg.Sheet(shapely.Point(0, 0).buffer(1)), 30).free_length, 2)
    1.84
    """
    unit = pull_direction(direction)
    points = np.asarray(sheet.outline.exterior.coords)[:, :2]
    along, across = points @ unit, points @ np.array([-unit[1], unit[0]])
    first, last = float(along.min()), float(along.max())
    length, width = last - first, float(np.ptp(across))
    if strip is None:
        near = 1e-9 * max(length, width)
        straight = all(np.ptp(across[np.abs(along - end) <= near]) >= STRAIGHT * width for end in (first, last))
        strip = 0.0 if straight else STRIP * length
    elif strip < 0:
        raise ModelError(f"grip must not be negative, got {strip:.6g}")
    elif strip >= LONGEST * length:
        raise ModelError(
            f"grips of {100 * strip / length:.4g} % of the length at each end do not leave a free length in the sheet"
        )
    return Grips(unit, first, last, strip, (float(across.min()), float(across.max())))
