"""Permeability of a stretched cut sheet: every open cut taken as a slit through which a viscous liquid creeps."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kirigami.errors import AnalysisError, ModelError
from kirigami.post.opening import open_area
from kirigami.primitives.checks import (
    require_array,
    require_choice,
    require_items,
    require_whole,
    require_whole_array,
    shown,
)
from kirigami.words import counted

Floats = NDArray[np.float64]
LENGTHS = ("diameter", "half perimeter")
SHEETS = ("deformed", "rest")


def slit_permeability(
    positions: ArrayLike, cuts: Sequence[Any], sheet_area: ArrayLike, length: str | ArrayLike = "diameter"
) -> Floats:
    """Permeability of openings given by their outlines, by the cubic law of slits.

    Parameters
    ----------
    positions : array_like, shape (s, n, 2 or 3) or (n, 2 or 3)
        Node positions at each of s steps [length]; what lies along z is left out.
    cuts : sequence of CutLoop or of integer arrays
        Node indices round each opening, counter-clockwise at rest, the first node not repeated.
    sheet_area : array_like, shape () or (s,)
        Area to which the flow is referred, A_sheet [length^2].
    length : {"diameter", "half perimeter"} or array_like, shape (cuts,) or (s, cuts)
        Length of each slit, l [length]: the largest distance between two corners of the opening, half its perimeter,
        or given.

    Returns
    -------
    ndarray, shape (s,)
        Permeability k [length^2]; a number without its axis if `positions` has no step axis.

    Raises
    ------
    ModelError
        Positions or cuts as for :func:`kirigami.post.opening.open_area`, a sheet area that is not positive, or lengths
        that are negative, not finite or of the wrong shape.

    Notes
    -----
    The flow through a slit of width w, length l and depth t under a drop p of pressure is ``w^3 l p / (12 mu t)``;
    Darcy's law for the sheet reads ``k A_sheet p / (mu t)``. Set equal and summed over the openings,

        k = 1 / A_sheet * sum w_i^3 l_i / 12,    w_i = 2 A_i / P_i,

    with area A_i and perimeter P_i of opening i in projection (Khawale et al., "Rapid kirigami simulation using the
    bar and hinge approach"; Zimmerman and Bodvarsson, Transport in Porous Media 23, 1996, for the cubic law).
    Thickness and viscosity drop out; k grows with the square of the size. An opening whose lips overlap so far that
    its signed area is negative lets nothing through.

    What this leaves out. The width 2 A/P is too small for a slit that is not thin: against the exact flow through long
    ducts, k is too small by a factor of

    ========================== ====== ====== ====== ====== ======
    width over length           1      0.5    0.2    0.1    0.02
    ========================== ====== ====== ====== ====== ======
    rectangle, l = long side    0.296  0.432  0.662  0.802  0.954
    ellipse, l = long axis      0.424  0.579  0.738  0.792  0.820
    ========================== ====== ====== ====== ====== ======

    More important: the depth of the ducts is the thickness of the sheet. Where an opening is wider than the sheet is
    thick, as in most stretched sheets, the resistance lies in the liquid that converges on the opening rather than in
    the duct, Poiseuille's profile never forms, and k by this formula is an index that ranks designs, not a
    measurement.

    Examples
    --------
    A rectangle 1 x 0.1 has w = 1 x 0.1 / 1.1:

    >>> from kirigami.post.permeability import slit_permeability
    >>> corners = [(0, 0), (1, 0), (1, 0.1), (0, 0.1)]
    >>> k = slit_permeability(corners, [[0, 1, 2, 3]], sheet_area=2.0, length=[1.0])
    >>> abs(float(k) / ((0.1 / 1.1) ** 3 / 24) - 1) < 1e-12
    True
    """
    points = _checked_positions(positions, "slit_permeability")
    cuts = require_items(cuts, "cuts", "slit_permeability")
    return _of_openings(points, cuts, np.atleast_2d(open_area(points, cuts)), sheet_area, length)


def _of_openings(
    points: Floats, cuts: Sequence[Any], area: Floats, sheet_area: ArrayLike, length: str | ArrayLike
) -> Floats:
    """Permeability of openings whose area (s, cuts) is known."""
    area = np.clip(area, 0.0, None)
    steps = points if points.ndim == 3 else points[None]
    total = require_array(sheet_area, (), (len(steps),), name="sheet_area", owner="permeability")
    if not (total > 0).all():
        raise ModelError(
            f"permeability: sheet_area must be positive, one number or one for each of {counted(len(steps), 'step')}"
        )
    outlines = [steps[:, np.asarray(getattr(cut, "loop", cut)), :2] for cut in cuts]
    perimeter = _by_cut(outlines, _perimeter, len(steps))
    if not isinstance(length, str):
        spans = require_array(length, (len(cuts),), area.shape, name="length", owner="permeability")
        if (spans < 0).any():
            raise ModelError("permeability: length must not be negative")
    elif length == "diameter":
        spans = _by_cut(outlines, _diameter, len(steps))
    elif length == "half perimeter":
        spans = 0.5 * perimeter
    else:
        require_choice(length, LENGTHS, "length", "permeability", or_else="numbers")
    width = np.divide(2.0 * area, perimeter, out=np.zeros_like(area), where=perimeter > 0)
    k: Floats = (width**3 * spans).sum(axis=1) / 12.0 / total
    return k[0] if points.ndim == 2 else k


def permeability(
    results: Any,
    sheet: str | ArrayLike = "deformed",
    length: str | ArrayLike = "diameter",
    cuts: Sequence[int] | None = None,
) -> Floats:
    """Permeability of a cut sheet at every stored step.

    Parameters
    ----------
    results : Results
        Of a model made from a mesh with cuts.
    sheet : {"deformed", "rest"} or array_like, shape () or (s,)
        Area to which the flow is referred [length^2]: that within the outline of the stretched sheet in projection,
        openings included; the same at rest; or given.
    length : {"diameter", "half perimeter", "rest"} or array_like, shape (cuts,) or (s, cuts)
        Length of each slit [length], see :func:`slit_permeability`; "rest" takes half the perimeter at rest, which is
        the length of the drawn slit.
    cuts : sequence of int, optional
        Numbers of the cuts that count; None takes all. A cut that reaches the edge of the sheet is closed by the chord
        of its mouth, as if a wall stood there.

    Returns
    -------
    ndarray, shape (s,)
        Permeability k [length^2].

    Raises
    ------
    AnalysisError
        The results belong to a model that was not made from a mesh.
    ModelError
        A word or a number that has no meaning here, or a cut that does not exist.

    Notes
    -----
    Formula, source and limits: :func:`slit_permeability`.

    Examples
    --------
    A square hole of side 1 in a sheet of 3 x 3, which a linear analysis leaves as it is:

    >>> from kirigami.post.permeability import permeability
    >>> import shapely
    >>> import kirigami as kg
    >>> sheet = kg.Sheet(shapely.box(0, 0, 3, 3), shapely.box(1, 1, 2, 2), 0.01, kg.Material(E=1.0))
    >>> m = kg.Model.from_mesh(sheet.mesh(0.6))
    >>> objects = m.add(kg.Fix(m.nodes), kg.NodalLoad(m.nodes[0], (1, 0, 0)))
    >>> k = permeability(kg.LinearStatic(m).run(), length=[1.0])
    >>> bool(abs(k[-1] / (0.5**3 / 12 / 9) - 1) < 1e-12)
    True
    """
    mesh = getattr(results, "mesh", results)
    if mesh is results:
        raise ModelError(f"permeability: results must be the Results of an analysis, got {shown(results)}")
    if mesh is None:
        raise AnalysisError("permeability needs a model made by Model.from_mesh", results=results)
    numbers = (
        range(len(mesh.cuts))
        if cuts is None
        else [require_whole(number, "cuts", "permeability") for number in require_items(cuts, "cuts", "permeability")]
    )
    if any(not 0 <= number < len(mesh.cuts) for number in numbers):
        raise ModelError(f"permeability: cuts must be numbers below {len(mesh.cuts)}, got {list(numbers)}")
    chosen = [mesh.cuts[number] for number in numbers]
    if isinstance(sheet, str):
        require_choice(sheet, SHEETS, "sheet", "permeability", or_else="numbers")
        outlined = results.position() if sheet == "deformed" else results.rest[None]
        area: Any = outlined_area(outlined, mesh.triangles, mesh.cuts)
        sheet = area if sheet == "deformed" else area[0]
    if isinstance(length, str) and length == "rest":
        length = [0.5 * float(_perimeter(results.rest[None, cut.loop, :2])[0]) for cut in chosen]
    return _of_openings(results.position(), chosen, results.open_area()[:, list(numbers)], sheet, length)


def outlined_area(positions: ArrayLike, triangles: ArrayLike, cuts: Sequence[Any]) -> Floats:
    """Area within the outline of a sheet in projection on the xy plane, openings included.

    Parameters
    ----------
    positions : array_like, shape (s, n, 2 or 3)
        Node positions at each of s steps [length].
    triangles : array_like of int, shape (m, 3)
        Facets, counter-clockwise at rest.
    cuts : sequence of CutLoop or of integer arrays
        All cuts of the sheet.

    Returns
    -------
    ndarray, shape (s,)
        Area [length^2].

    Notes
    -----
    Signed areas of facets and openings add up to the area within the outline, whatever folds lie inside it (Green's
    theorem).

    Examples
    --------
    >>> from kirigami.post.permeability import outlined_area
    >>> outlined_area([[(0, 0), (1, 0), (1, 1), (0, 1)]], [(0, 1, 2)], [[0, 2, 3]]).tolist()
    [1.0]
    """
    points = _checked_positions(positions, "outlined_area")
    points = points if points.ndim == 3 else points[None]
    corners = require_whole_array(triangles, (None, 3), name="triangles", owner="outlined_area")
    if corners.min() < 0 or corners.max() >= points.shape[1]:
        raise ModelError(f"outlined_area: triangles must hold node indices below {points.shape[1]}")
    a, b, c = (points[:, corner, :2] for corner in corners.T)
    facets = 0.5 * ((b - a)[..., 0] * (c - a)[..., 1] - (b - a)[..., 1] * (c - a)[..., 0])
    total: Floats = facets.sum(axis=1) + open_area(points, cuts).sum(axis=1)
    return total


def _checked_positions(positions: ArrayLike, owner: str) -> Floats:
    shapes = (None, 2), (None, 3), (None, None, 2), (None, None, 3)
    return require_array(positions, *shapes, name="positions", owner=owner)


def _by_cut(outlines: list[Floats], measure: Any, steps: int) -> Floats:
    found = np.zeros((steps, len(outlines)))
    for column, outline in enumerate(outlines):
        found[:, column] = measure(outline)
    return found


def _perimeter(outline: Floats) -> Floats:
    """Lengths (s,) of closed loops (s, k, 2)."""
    sides: Floats = np.linalg.norm(outline - np.roll(outline, -1, axis=1), axis=2)
    total: Floats = sides.sum(axis=1)
    return total


def _diameter(outline: Floats) -> Floats:
    """Largest distances (s,) between two corners of loops (s, k, 2)."""
    largest: Floats = np.array([np.hypot(*(loop[:, None] - loop[None]).T).max() for loop in outline])
    return largest
