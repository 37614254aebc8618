"""Families of periodic tilings; each function returns one cell, of which ``patch`` makes a finite lattice."""

from __future__ import annotations

import math

import numpy as np

from kirigami.errors import GeometryError
from kirigami.lattice.tilings.tiling import Tiling
from kirigami.primitives.checks import require_array, require_finite, require_positive
from kirigami.primitives.kernel import Array


def rotating_squares(angle: float, side: float = 1.0) -> Tiling:
    """Equal squares joined at all corners; neighbours turn against each other (Grima and Evans 2000).

    The cell holds two by two squares; lattice spacing per square is side (cos(angle/2) + sin(angle/2)) both ways, so
    Poisson's ratio is -1 at every strain.

    Parameters
    ----------
    angle : float
        Opening between the sides of neighbours [rad], from 0 (closed) to pi (closed the other way).
    side : float
        Side of the squares [length].

    Raises
    ------
    GeometryError
        The angle is out of range.

    Examples
    --------
    >>> import kirigami as kg
    >>> import math
    >>> cell = kg.tilings.rotating_squares(angle=math.pi / 2, side=2.0)
    >>> print(cell, round(cell.cell_area, 9))
    Periodic tiling of 4 panels with 8 joints 32.0
    """
    _within(angle, 0.0, math.pi, "rotating_squares: angle")
    side = require_positive(side, "side", "rotating_squares")
    c, s = math.cos(angle / 2), math.sin(angle / 2)
    spacing = side * (c + s)
    # Joint to the right of square (i, j) and joint above it, seen from the centre of the square.
    right = 0.5 * side * np.array([c + s, s - c])
    above = 0.5 * side * np.array([c - s, c + s])
    points = np.zeros((8, 2))
    panels = []
    for j in range(2):
        for i in range(2):
            centre = spacing * np.array([i, j])
            turned = 1.0 if (i + j) % 2 == 0 else -1.0  # counter-clockwise or clockwise
            points[2 * i + j] = centre + right * [1, turned]
            points[4 + 2 * i + j] = centre + above * [turned, 1]
            to_right, to_top = (2 * i + j, 0, 0), (4 + 2 * i + j, 0, 0)
            to_left = (2 * (1 - i) + j, i - 1, 0)
            to_bottom = (4 + 2 * i + (1 - j), 0, j - 1)
            around = [to_bottom, to_right, to_top, to_left]
            panels.append(around if turned > 0 else [to_left, to_bottom, to_right, to_top])
    return Tiling(points, panels, 2 * spacing * np.eye(2))


def square_rhombus(angle: float, side: float = 1.0) -> Tiling:
    """Squares standing corner on corner in columns, linked across by rhombi that lean by an angle.

    A square is joined to the squares below and above it and to a rhombus at either side; that leaves as many motions
    as constraints in each cell. If the lowest corners are pinned, turns of neighbouring squares in a row relate as
    tan(pi/4 - angle) to first order: the lean breaks the symmetry of left and right, and motion dies out towards one
    side, as in the topological chain of Kane and Lubensky (Nature Physics 10, 39 (2014)). It is an arrangement of the
    kind of Coulais, Sounas and Alu (Nature 542, 461 (2017)), not a copy of their drawing.

    Parameters
    ----------
    angle : float
        Lean of the rhombi against the diagonals of the squares [rad], between -pi/8 and pi/8; the opposite angle gives
        the mirror image. The corners of the rhombi at the joints measure pi/2 - abs(angle).
    side : float
        Side of squares and rhombi [length].

    Raises
    ------
    GeometryError
        The angle is out of range.

    Examples
    --------
    >>> import kirigami as kg
    >>> import math
    >>> row = kg.tilings.square_rhombus(math.pi / 16).patch(4, 1, keep=lambda a, b, panel: panel == 0 or a < 3)
    >>> print(row)
    Tiling of 7 panels with 6 joints
    """
    _within(angle, -math.pi / 8, math.pi / 8, "square_rhombus: angle")
    side = require_positive(side, "side", "square_rhombus")
    diagonal = math.sqrt(2) * side
    half_corner = math.pi / 4 - abs(angle) / 2
    link = 2 * side * math.cos(half_corner) * np.array([math.cos(angle), math.sin(angle)])
    across = side * math.sin(half_corner) * np.array([-math.sin(angle), math.cos(angle)])
    bottom, right, top = np.zeros(2), np.array([diagonal, diagonal]) / 2, np.array([0.0, diagonal])
    left = right - [diagonal, 0]
    middle = right + link / 2
    points = np.array([bottom, right, left, middle + across, middle - across])
    row = right + link - left
    square = [(0, 0, 0), (1, 0, 0), (0, 0, 1), (2, 0, 0)]
    rhombus = [(1, 0, 0), (4, 0, 0), (2, 1, 0), (3, 0, 0)]
    return _along_x(points, [square, rhombus], np.array([row, top]))


def kagome(angle: float, sides: tuple[float, float, float] = (0.8, 0.6, 1.0), side: float = 1.0) -> Tiling:
    """Equilateral and scalene triangles joined at corners: a deformed kagome lattice with a soft twist.

    At a joint O the equilateral triangle has the corners O, P, Q and the scalene one O, R, S, `angle` runs from OP to
    OR. Changing it moves the whole lattice and deforms no panel. At the angles of :func:`critical_angles` sides come
    into line; between them the lattice is topologically polarised (Rocklin, Zhou, Sun and Mao, Nature Communications
    8, 14201 (2017)). Rows run along x.

    Parameters
    ----------
    angle : float
        Twist [rad].
    sides : (float, float, float)
        Sides OR, OS and RS of the scalene triangle over `side`.
    side : float
        Side of the equilateral triangle [length].

    Raises
    ------
    GeometryError
        The sides make no triangle, or panels overlap at this angle.

    Examples
    --------
    >>> import kirigami as kg
    >>> cell = kg.tilings.kagome(angle=1.75)
    >>> print(cell, len(cell.bars()), len(cell.points))
    Periodic tiling of 2 panels with 3 joints 6 3
    """
    angle = require_finite(angle, "angle", "kagome")
    side = require_positive(side, "side", "kagome")
    a, s, _ = _checked_sides(sides)
    alpha, _ = _scalene_angles(sides)
    P, Q = np.array([1.0, 0.0]), np.array([0.5, -math.sqrt(3) / 2])
    R = a * np.array([math.cos(angle), math.sin(angle)])
    S = s * np.array([math.cos(angle + alpha), math.sin(angle + alpha)])
    # R is the corner Q of the cell above, S the corner P of the cell above and to the left.
    panels = [[(0, 0, 0), (2, 0, 0), (1, 0, 0)], [(0, 0, 0), (2, 0, 1), (1, -1, 1)]]
    lattice = np.array([R - S + P - Q, R - Q])
    if np.linalg.det(lattice) <= 0:
        raise GeometryError(f"kagome: at the angle {angle:.6g} the lattice has no area left")
    return _along_x(side * np.array([[0.0, 0.0], P, Q]), panels, side * lattice)


def critical_angles(sides: tuple[float, float, float] = (0.8, 0.6, 1.0)) -> tuple[float, float, float]:
    """Ascending twist angles of :func:`kagome` with sides of neighbours in line: 2 pi/3, pi - alpha, pi/3 + rho.

    Parameters
    ----------
    sides : (float, float, float)
        As for :func:`kagome`; alpha and rho are the angles of the scalene triangle at O and R.

    Examples
    --------
    >>> import kirigami as kg
    >>> [round(angle, 4) for angle in kg.tilings.critical_angles()]
    [1.5708, 1.6907, 2.0944]
    """
    alpha, rho = _scalene_angles(sides)
    first, second, third = sorted((2 * math.pi / 3, math.pi - alpha, math.pi / 3 + rho))
    return first, second, third


def rotating_triangles(angle: float, side: float = 1.0) -> Tiling:
    """Equal equilateral triangles joined at corners: the twisted kagome lattice, Poisson's ratio -1.

    Parameters
    ----------
    angle : float
        Opening between the sides of neighbours [rad], from 0 (closed) through 2 pi/3 (the regular kagome lattice).
    side : float
        Side of the triangles [length].

    Raises
    ------
    GeometryError
        Panels overlap at this angle.

    Examples
    --------
    >>> import kirigami as kg
    >>> import math
    >>> print(round(kg.tilings.rotating_triangles(2 * math.pi / 3).cell_area, 6))    # regular kagome: 2 sqrt(3)
    3.464102
    """
    return kagome(angle, (1.0, 1.0, 1.0), side)


def _scalene_angles(sides: tuple[float, float, float]) -> tuple[float, float]:
    """Angles alpha at O and rho at R of a triangle with sides OR, OS, RS."""
    a, s, b = _checked_sides(sides)
    cosines = np.array([(a * a + s * s - b * b) / (2 * a * s), (a * a + b * b - s * s) / (2 * a * b)])
    if np.any(np.abs(cosines) >= 1 - 1e-12):
        raise GeometryError(f"kagome: sides {sides} make no triangle with area")
    alpha, rho = np.arccos(cosines).tolist()
    return alpha, rho


def _checked_sides(sides: tuple[float, float, float]) -> tuple[float, float, float]:
    a, s, b = require_array(sides, (3,), name="sides", owner="kagome", error=GeometryError).tolist()
    return (
        require_positive(a, "sides", "kagome", GeometryError),
        require_positive(s, "sides", "kagome", GeometryError),
        require_positive(b, "sides", "kagome", GeometryError),
    )


def _within(value: float, low: float, high: float, name: str) -> None:
    if not low <= require_finite(value, "angle", name) <= high:
        raise GeometryError(f"{name} must lie between {low:.6g} and {high:.6g} rad, got {value:.6g}")


def _along_x(points: Array, panels: list[list[tuple[int, int, int]]], lattice: Array) -> Tiling:
    """Turn the tiling so that its first lattice vector lies along x."""
    c, s = lattice[0] / np.linalg.norm(lattice[0])
    turn = np.array([[c, -s], [s, c]])
    return Tiling(points @ turn, panels, lattice @ turn)
