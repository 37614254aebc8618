"""Shape of a stretched sheet: its height, its width, and the Poisson ratio it seems to have."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kirigami.errors import ModelError
from kirigami.primitives.checks import require_array, require_axis, require_finite, require_instance
from kirigami.words import counted

if TYPE_CHECKING:
    from kirigami.geometry.mesh import TriMesh

Floats = NDArray[np.float64]

FLAT = 1e-9  # largest height of a flat drawing, over its size
LEVELS = 41  # heights at which the band is measured; their mean is that of the band to about 1e-3 of its change


def principal_values(xx: Floats, yy: Floats, xy: Floats) -> Floats:
    """Principal values (..., 2) of plane tensors, the algebraically larger first."""
    mean, radius = 0.5 * (xx + yy), np.hypot(0.5 * (xx - yy), xy)
    return np.stack([mean + radius, mean - radius], axis=-1)


def height(positions: ArrayLike) -> Floats:
    """Height of a sheet above its lowest point, max z - min z.

    Parameters
    ----------
    positions : array_like, shape (s, n, 3) or (n, 3)
        Node positions at each of s steps [length].

    Returns
    -------
    ndarray, shape (s,) or ()
        Height [length].

    Raises
    ------
    ModelError
        Positions of the wrong shape or not finite.

    Examples
    --------
    >>> from kirigami.post.shape import height
    >>> float(height([(0, 0, -1), (1, 0, 0), (0, 1, 2)]))
    3.0
    """
    z = checked_positions(positions, "height")[..., 2]
    tall: Floats = np.ptp(z, axis=-1)
    return tall


def width(positions: ArrayLike, mesh: TriMesh, axis: str = "y", band: float = 0.5) -> Floats:
    """Mean width of the sheet across the pull, seen from above, over a band at mid height.

    The band is one of material: the part of the sheet whose place in the drawing, along the pull, is within
    ``band / 2`` heights of the middle. Both sides of the outline are followed there, and the mean distance between
    them, measured across the pull, is the width; lips of cuts that reach the side do not count.

    Parameters
    ----------
    positions : array_like, shape (s, n, 3) or (n, 3)
        Node positions at each of s steps [length].
    mesh : TriMesh
        The sheet as drawn, flat, with an outline that a line across the pull meets twice.
    axis : {"y", "x"}
        Direction of the pull.
    band : float
        Height of the band over the height of the sheet, between 0 and 1; 0 is the width at mid height alone.

    Returns
    -------
    ndarray, shape (s,) or ()
        Width [length].

    Raises
    ------
    ModelError
        Positions of the wrong shape or not finite, an unknown axis, a band out of range, or a mesh that is not flat.

    Examples
    --------
    >>> from kirigami.post.shape import width
    >>> import kirigami as kg
    >>> mesh = kg.Sheet([(0, 0), (2, 0), (2, 3), (0, 3)]).mesh(1.0)
    >>> round(float(width(mesh.nodes * (0.9, 1.2, 1), mesh)), 12)
    1.8
    """
    nodes = len(checked_mesh(mesh, "width").nodes)
    return _Band(mesh, axis, band, "width").widths(checked_positions(positions, "width", nodes))


def poisson_ratio(
    positions: ArrayLike, mesh: TriMesh, axis: str = "y", band: float = 0.5, strain: ArrayLike | None = None
) -> Floats:
    """Effective Poisson ratio: minus the relative change of the mean width over the axial strain.

    Parameters
    ----------
    positions : array_like, shape (s, n, 3) or (n, 3)
        Node positions at each of s steps [length].
    mesh : TriMesh
        The sheet as drawn, flat, with an outline that a line across the pull meets twice.
    axis : {"y", "x"}
        Direction of the pull.
    band : float
        Height over which the width is averaged, over the height of the sheet, above 0 and up to 1; see :func:`width`.
    strain : array_like, shape (s,) or (), optional
        What to divide by, for example the displacement of the grip over the free length; by default the strain of the
        band itself, the mean elongation of both its sides.

    Returns
    -------
    ndarray, shape (s,) or ()
        Ratio; positive where the sheet gets narrower as it is pulled. It is not defined, and nan, where the strain is
        less than 1e-12.

    Raises
    ------
    ModelError
        Positions of the wrong shape or not finite, an unknown axis, a band out of range, strains of another number, or
        a mesh that is not flat, such as a tube.

    Notes
    -----
    Strains are changes of length over length as drawn. A pulled sheet of constant Poisson ratio whose ends are free
    to contract has that ratio; clamped ends hold the width back near them, which is why the band is in the middle.

    Examples
    --------
    >>> from kirigami.post.shape import poisson_ratio
    >>> import kirigami as kg
    >>> mesh = kg.Sheet([(0, 0), (2, 0), (2, 3), (0, 3)]).mesh(1.0)
    >>> round(float(poisson_ratio(mesh.nodes * (0.9, 1.2, 1), mesh)), 12)
    0.5
    """
    checked_mesh(mesh, "poisson_ratio")
    points = checked_positions(positions, "poisson_ratio", len(mesh.nodes))
    measured = _Band(mesh, axis, band, "poisson_ratio")
    if strain is None:
        if measured.band == 0:
            raise ModelError("poisson_ratio: a band without height has no strain; give a band above 0, or the strain")
        axial = measured.strains(points)
    else:
        axial = require_array(strain, points.shape[:-2], name="strain", owner="poisson_ratio")
    drawn = measured.widths(mesh.nodes)
    across = measured.widths(points) / drawn - 1
    stretched = np.abs(axial) >= 1e-12
    ratio: Floats = np.where(stretched, -across / np.where(stretched, axial, 1.0), np.nan)
    return ratio


def check_flat(mesh: TriMesh, owner: str) -> None:
    """Refuse what is not drawn flat, such as a tube: nothing there says what is along the sheet and what across."""
    if np.ptp(mesh.nodes[:, 2]) > FLAT * mesh.size:
        raise ModelError(f"{owner}: the drawing must be flat and level, but the nodes of the mesh differ in z")


def checked_mesh(mesh: TriMesh, owner: str) -> TriMesh:
    """A mesh, or a ModelError."""
    from kirigami.geometry.mesh import TriMesh  # what draws no sheet needs none

    return require_instance(mesh, TriMesh, "mesh", owner, "make one with Sheet.mesh or TriMesh")


def checked_positions(positions: ArrayLike, owner: str, nodes: int | None = None) -> Floats:
    """Finite positions (s, n, 3) or (n, 3), or a ModelError."""
    points = require_array(positions, (None, 3), (None, None, 3), name="positions", owner=owner)
    if nodes is not None and points.shape[-2] != nodes:
        raise ModelError(
            f"{owner}: the mesh has {counted(nodes, 'node')}, but positions are given for {points.shape[-2]}"
        )
    return points


class _Band:
    """Levels of the outline at mid height, each between two of its nodes, on the lower and on the upper side."""

    def __init__(self, mesh: TriMesh, axis: str, band: float, owner: str) -> None:
        require_axis(axis, owner, axes="xy")
        band = require_finite(band, "band", owner)
        if not 0 <= band <= 1:
            raise ModelError(f"{owner}: band must lie between 0 and 1, got {band!r}")
        check_flat(mesh, owner)
        self.along, self.across = (1, 0) if axis == "y" else (0, 1)
        self.band = float(band)
        place = mesh.nodes[:, self.along]
        middle, size = 0.5 * (place.max() + place.min()), float(np.ptp(place))
        self.levels = middle + (0.5 * self.band * size) * np.linspace(-1, 1, LEVELS if band else 1)
        outline = mesh.boundary("outer")
        centre = 0.5 * (mesh.nodes[outline, self.across].max() + mesh.nodes[outline, self.across].min())
        self.sides = []
        for sign in (-1.0, 1.0):
            side = outline[sign * (mesh.nodes[outline, self.across] - centre) > 0]
            # first the level; where an end of the sheet has several nodes at one level, the outermost is the side
            side = side[np.lexsort((sign * mesh.nodes[side, self.across], place[side]))]
            last = np.append(np.diff(place[side]) > 1e-12 * size, True)
            side = side[last]
            if len(side) < 2:
                raise ModelError(f"{owner}: the outline has no side to measure along {axis}")
            self.sides.append((side, place[side]))

    def _at(self, points: Floats, component: int, levels: Floats) -> list[Floats]:
        """A coordinate (..., levels) of the material on each side at levels of the drawing."""
        found = []
        for side, place in self.sides:
            above = np.searchsorted(place, levels).clip(1, len(place) - 1)
            part = ((levels - place[above - 1]) / (place[above] - place[above - 1])).clip(0, 1)
            values = points[..., side, component]
            found.append(values[..., above - 1] * (1 - part) + values[..., above] * part)
        return found

    def widths(self, points: Floats) -> Floats:
        """Mean distance between the sides, (...)."""
        low, high = self._at(points, self.across, self.levels)
        between: Floats = (high - low).mean(axis=-1)
        return between

    def strains(self, points: Floats) -> Floats:
        """Mean elongation of the sides of the band over its height, (...)."""
        ends = self.levels[[0, -1]]
        spans = [side[..., 1] - side[..., 0] for side in self._at(points, self.along, ends)]
        strain: Floats = 0.5 * (spans[0] + spans[1]) / (ends[1] - ends[0]) - 1
        return strain
