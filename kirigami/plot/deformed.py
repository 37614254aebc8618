"""The deformed structure: sheets as filled facets, everything else as lines."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kirigami.errors import ModelError
from kirigami.plot import style
from kirigami.plot.field import Field
from kirigami.primitives.checks import require_choice, require_finite, shown
from kirigami.results.scale import scale_of
from kirigami.units import unit_for

if TYPE_CHECKING:
    from kirigami.geometry.mesh import TriMesh
    from kirigami.results.results import Results

NEARER = 0.7  # of an edge, by which lines are drawn in front of facets: their middles are 2/3 of a height from it
MOST_PIECES = 24_000  # that a smooth picture of a sheet is cut into
Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

EDGES = ("boundary", "all", "none")


@style.styled
def plot_results(
    results: Results,
    step: int = -1,
    ax: Any = None,
    color: str | ArrayLike | None = None,
    edges: str = "boundary",
    view: str | tuple[float, float] | None = None,
    magnify: float = 1.0,
    colorbar: bool = True,
    cmap: Any = None,
    label: str | None = None,
    smooth: bool = True,
) -> Any:
    """Draw the deformed structure at one step.

    Where results are known to be in SI units, axes and colours are in millimetres, megapascals and so on, and say so.

    Parameters
    ----------
    results : Results
        What to draw.
    step : int
        Number of the stored step; -1 is the last.
    ax : matplotlib axes, optional
        Where to draw; a new figure by default.
    color : str or array_like, optional
        "height", "displacement", "energy" (elastic energy per area at rest; of bar structures, energy), "stress" (von
        Mises', at the face where it is larger; for sheets that know their thickness and material), "plastic strain"
        (accumulated, where it is largest over the thickness of a sheet), for bar
        structures also "force" and "strain"; "none" for one plain colour; or one value per node, facet or bar (taken
        as nodal where the numbers agree). Of stress, plastic strain and energy the highest values, of 0.5 % of the
        area at the tips of cuts, share a colour, and the colour bar has a point. By default height for sheets in space,
        displacement for sheets in the plane, and force for bar structures.
    edges : {"boundary", "all", "none"}
        Facet edges to draw on a sheet: free boundaries and cuts, every edge, or none.
    view : "top", "3d" or (elevation, azimuth), optional
        From above, or from a direction [degrees]; by default in space for models with dim=3, else from above.
    magnify : float
        Factor on the displacements.
    colorbar : bool
        Whether to add a colour bar.
    cmap : matplotlib colour map, optional
        Colour map, or its name.
    label : str, optional
        What the colours stand for, at the colour bar.
    smooth : bool
        Whether colours and light of a sheet go over from facet to facet, with jumps at cuts and folds. Values given per
        facet are shown as they are.

    Returns
    -------
    matplotlib axes

    Raises
    ------
    ModelError
        No such step, colour, kind of edges or view; a view in space on flat axes.

    Examples
    --------
    >>> import kirigami as kg
    >>> mesh = kg.TriMesh([(0, 0), (1, 0), (1, 1), (0, 1)], [(0, 1, 2), (0, 2, 3)])
    >>> m = kg.Model.from_mesh(mesh, thickness=0.01, material=kg.Material(E=1e9))
    >>> left, right = m.select(boundary="left"), m.select(boundary="right")
    >>> held = m.add(kg.Fix(left), kg.Fix(right, "z"), kg.Prescribe(right, x=0.1))
    >>> ax = kg.LinearStatic(m).run().plot(view="top")
    >>> ax.get_xlabel()
    'x'
    """
    number = results.step_number(step, "plot")
    looking = chosen_view(results, ax, view)
    field = Field(results, color, smooth)
    points = displaced(results, results[number].u, magnify)
    held = points if results.mesh is not None else np.concatenate([points, results.rest])
    values = field.at(number)
    bar = colorbar and values is not None
    place = None
    if ax is None:
        ax, place = suitable_axes(held, looking, bar)
    picture = Picture(results, ax, field, edges, cmap, fine=True)
    picture.scale_colors(values)
    frame(ax, held, looking)  # first, since lines stand a little nearer to who looks, from where that is
    picture.update(points, values)
    if results.units and looking == "top":
        style.axes_in_unit(ax, scale_of(results))
    if bar:
        color_bar(picture, field, place, label)
    return ax


def color_bar(picture: Picture, field: Field, place: Any, label: str | None = None) -> None:
    """The colour bar of a picture, with a unit where it is known."""
    text, kind = field.label if label is None else label, field.kind
    bar = style.color_bar(picture.ax, picture.mappable, text, place, extend="max" if picture.peaked else "neither")
    if kind and picture.results.units and label is None:
        low, high = picture.mappable.get_clim()
        scale = scale_of(picture.results)  # one unit of length in a picture; others as suits the values
        unit, factor = scale.unit(kind) if kind in ("length", "area") else unit_for(max(abs(low), abs(high)), kind)
        bar.ax.yaxis.set_major_formatter(style.in_units_of(factor))
        bar.set_label(f"{text} [{style.raised(unit)}]")


def chosen_view(results: Results, ax: Any, view: Any) -> style.View:
    """The direction to look from, as far as the axes allow."""
    if view is None:
        solid = results.dim == 3 if ax is None else style.is_solid(ax)
        return style.DEFAULT_VIEW if solid else "top"
    looking = style.checked_view(view, "plot")
    if ax is not None and style.is_solid(ax) == (looking == "top"):
        need = "flat axes" if looking == "top" else "axes made with projection='3d'"
        raise ModelError(f"plot: view={shown(view)} needs {need}")
    return looking


def displaced(results: Results, u: Floats, magnify: float = 1.0) -> Floats:
    """Positions (n, 3) with magnified displacements."""
    points: Floats = results.rest + require_finite(magnify, "magnify", "plot") * u
    if not np.isfinite(points).all():
        raise ModelError(f"plot: displacements magnified by {magnify:g} are beyond all numbers")
    return points


def suitable_axes(
    points: Floats, looking: style.View, bar: bool, foot: bool = False, managed: bool = True
) -> tuple[Any, Any]:
    """New axes for a picture of points (n, 3), and axes for its colour bar where they must be made at once."""
    if isinstance(looking, str):
        size = style.size_for(points.min(axis=0), points.max(axis=0), bar)
        return style.new_axes(size, managed), None
    return style.new_solid_axes(points, looking, bar, foot, managed)


def frame(ax: Any, points: Floats, looking: style.View) -> None:
    """Limits that hold points (n, 3)."""
    if isinstance(looking, str):
        style.frame_flat(ax, points.min(axis=0), points.max(axis=0))
    else:
        style.frame_solid(ax, points, looking)


class Picture:
    """The drawn structure, which can be moved and coloured anew for each frame of an animation."""

    def __init__(
        self, results: Results, ax: Any, field: Field, edges: str = "boundary", cmap: Any = None, fine: bool = False
    ) -> None:
        from matplotlib import colormaps
        from matplotlib.cm import ScalarMappable
        from matplotlib.colors import Normalize

        require_choice(edges, EDGES, "edges", "plot")
        self.ax, self.results, self.field = ax, results, field
        if cmap is None:
            cmap = field.map()
        elif isinstance(cmap, str):
            cmap = colormaps[cmap]
        self.mappable = ScalarMappable(Normalize(0, 1), cmap)
        self.symmetric = field.diverging
        self.peaked = False  # whether there are values beyond the colours
        self.solid = style.is_solid(ax)
        self.mesh: TriMesh | None = results.mesh
        self.bars = field.cells
        if self.mesh is None:
            self._artist = self._make_lines(results)
        else:
            outline = {"boundary": self.mesh.boundary_edges, "all": np.arange(len(self.mesh.edges)), "none": []}
            self.lines = self.mesh.edges[np.asarray(outline[edges], dtype=np.int64)]
            level = 0
            while fine and field.smooth and level < 2 and len(self.mesh.triangles) * 4 ** (level + 1) <= MOST_PIECES:
                level += 1
            self.pieces = _pieces(level)
            self._artist = self._make_facets()

    def scale_colors(self, *values: Floats | None) -> None:
        """Let the colours span the values given."""
        given = [part for part in values if part is not None and part.size]
        if not given:
            return
        low, high = np.array([self.field.span(part) for part in given]).T
        low, high = float(low.min()), float(high.max())
        self.peaked = high < max(float(part.max()) for part in given)
        if self.symmetric:
            high = max(abs(low), abs(high))
            low = -high
        if high - low <= 1e-12 * max(abs(low), abs(high)):
            low, high = low - 0.5 * (abs(low) or 1.0), high + 0.5 * (abs(high) or 1.0)
        self.mappable.set_clim(low, high)

    def update(self, points: Floats, values: Floats | None) -> None:
        """Move to positions `points` (n, 3) and colour by `values`, one per facet or bar."""
        if self.mesh is None:
            self._artist.set_segments(points[self.bars] if self.solid else points[self.bars][..., :2])
            self._artist.set_color(style.INK if values is None else self.mappable.to_rgba(values))
            return
        corners = points[self.mesh.triangles]
        middles = self.pieces.mean(axis=1)  # (pieces, 3 corners of the facet)
        light = _light(self._normals(corners, middles))
        corners = np.einsum("pcw,mwx->mpcx", self.pieces, corners).reshape(-1, 3, 3)
        if values is None:
            colors = np.tile(_rgba(style.PALE), (len(corners), 1))
        else:
            parts = self.field.sectors if self.field.smooth else None
            here = np.repeat(values, len(middles)) if parts is None else values[parts.corner] @ middles.T
            colors = self.mappable.to_rgba(here.ravel())
        colors[:, :3] *= light[:, None]
        # Sorted by depth, lines come in parts as long as the pieces beside them and before these, or they are dashed.
        count = round(np.sqrt(len(self.pieces)))
        ends = points[self.lines]
        places = ends[:, :1] + np.linspace(0.0, 1.0, count + 1)[:, None] * np.diff(ends, axis=1)
        ends = np.stack([places[:, :-1], places[:, 1:]], axis=2).reshape(-1, 2, 3)
        ends = ends + NEARER / count * float(self.mesh.edge_lengths.max()) * self._towards()
        # Edges go into the same collection as facets with no area, so that depth sorting hides those at the back.
        polygons = np.concatenate([corners, ends[:, [0, 1, 1]]])
        faces = np.concatenate([colors, np.zeros((len(ends), 4))])
        rims = np.concatenate([colors, np.tile(_rgba(style.INK), (len(ends), 1))])
        if not self.solid:
            order = np.argsort(polygons[..., 2].mean(axis=1), kind="stable")
            polygons, faces, rims = polygons[order][..., :2], faces[order], rims[order]
        self._artist.set_verts(polygons)
        self._artist.set_facecolor(faces)
        self._artist.set_edgecolor(rims)

    def _towards(self) -> Floats:
        """Direction (3,) from the picture to who looks at it."""
        if not self.solid:
            return np.array([0.0, 0.0, 1.0])
        return style.towards_viewer((self.ax.elev, self.ax.azim))

    def _normals(self, corners: Floats, middles: Floats) -> Floats:
        """Directions (pieces, 3) in which the pieces face: those of the facets, or smooth ones."""
        normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        parts = self.field.sectors
        if not self.field.smooth or parts is None:
            return np.repeat(normal, len(middles), axis=0)
        size = np.linalg.norm(normal, axis=1)
        normal = normal / np.where(size > 0, size, 1.0)[:, None]
        at = parts.means(normal.T).T[parts.corner]  # (m, 3 corners, 3)
        found: Floats = np.einsum("pw,mwx->mpx", middles, at).reshape(-1, 3)
        return found

    def _make_facets(self) -> Any:
        if self.solid:
            from mpl_toolkits.mplot3d.art3d import Poly3DCollection

            return self.ax.add_collection3d(Poly3DCollection(np.zeros((1, 3, 3)), linewidths=0.45))
        from matplotlib.collections import PolyCollection

        return self.ax.add_collection(PolyCollection([], linewidths=0.45), autolim=False)

    def _make_lines(self, results: Results) -> Any:
        rest: Any = results.rest[self.bars]
        width = 2.2 if len(self.bars) < 60 else 1.2
        if self.solid:
            from mpl_toolkits.mplot3d.art3d import Line3DCollection

            self.ax.computed_zorder = False  # which would bring the rest state to the front here and there
            behind = Line3DCollection(rest, colors=style.PALE, linewidths=0.6 * width, zorder=1)
            self.ax.add_collection3d(behind)
            return self.ax.add_collection3d(Line3DCollection(rest, linewidths=width, zorder=2))
        from matplotlib.collections import LineCollection

        flat = rest[..., :2]
        self.ax.add_collection(LineCollection(flat, colors=style.PALE, linewidths=0.6 * width, zorder=1))
        return self.ax.add_collection(LineCollection(flat, linewidths=width, capstyle="round", zorder=2))


def _rgba(color: str) -> Floats:
    from matplotlib.colors import to_rgba

    return np.array(to_rgba(color))


def _pieces(level: int) -> Floats:
    """A triangle in 4^level like ones: weights (pieces, 3 corners, 3) of its own corners."""
    pieces = np.eye(3)[None]
    for _ in range(level):
        a, b, c = pieces.transpose(1, 0, 2)
        ab, bc, ca = (a + b) / 2, (b + c) / 2, (c + a) / 2
        parts = [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
        pieces = np.concatenate([np.stack(part, axis=1) for part in parts])
    return np.asarray(pieces)


def _light(normal: Floats) -> Floats:
    """Brightness from 0.8 to 1 by where a facet (m, 3) faces: enough to see a fold, too little to be taken for a
    value."""
    size = np.linalg.norm(normal, axis=1)
    towards_light = np.abs(normal @ np.array([-0.48, -0.36, 0.8])) / np.where(size > 0, size, 1.0)
    brightness: Floats = 0.8 + 0.2 * towards_light
    return brightness
