"""What goes into an analysis: drawings of cuts, meshes, and models with their supports and loads."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from kirigami.errors import ModelError
from kirigami.plot import style
from kirigami.plot.deformed import frame, suitable_axes
from kirigami.primitives.checks import shown

if TYPE_CHECKING:
    from kirigami.geometry.mesh import TriMesh
    from kirigami.geometry.sheet import Sheet
    from kirigami.model.model import Model

Floats = NDArray[np.float64]

ARROW = 0.13  # length of the longest arrow, of the size of the picture
MANY = 12  # of more nodes that move alike, one arrow stands for all
BELOW = 30.0  # points from flat axes to their legend: numbers and a name lie between
FLAT = 0.1  # a sheet lower than this part of its size is drawn from above


@style.styled
def plot_sheet(sheet: Sheet, ax: Any = None, fill: Any = style.PAPER, cut_color: Any = style.VERMILION) -> Any:
    """Draw the drawing: the outline, its holes, and the cuts.

    Parameters
    ----------
    sheet : Sheet
        What to draw.
    ax : matplotlib axes, optional
        Where to draw; a new figure by default.
    fill, cut_color : matplotlib colours
        Colour of the sheet and of the slits.

    Returns
    -------
    matplotlib axes

    Raises
    ------
    ModelError
        Axes that are not flat.

    Examples
    --------
    >>> import kirigami as kg
    >>> from shapely import LineString, box
    >>> ax = kg.plot.plot_sheet(kg.Sheet(box(0, 0, 2, 1), cuts=[LineString([(0.5, 0.5), (1.5, 0.5)])]))
    >>> len(ax.lines)
    1
    """
    import shapely

    if not hasattr(sheet, "outline") or not hasattr(sheet, "cuts"):
        raise ModelError(f"plot_sheet: sheet must be a Sheet, got {shown(sheet)}")
    bounds = np.array(sheet.outline.bounds).reshape(2, 2)
    ax = flat_axes(ax, "plot_sheet", bounds)
    draw_paper(ax, sheet.outline, sheet.cuts, fill)
    for cut in sheet.cuts:
        if not isinstance(cut, shapely.Polygon):
            ax.plot(*shapely.get_coordinates(cut).T, color=cut_color, linewidth=1.0, solid_capstyle="round")
    style.frame_flat(ax, bounds[0], bounds[1])
    return ax


def draw_paper(ax: Any, outline: Any, cuts: Iterable[Any], fill: Any) -> None:
    """Fill what the openings among the cuts leave of a sheet."""
    import shapely

    openings = [cut for cut in cuts if isinstance(cut, shapely.Polygon)]
    for part in shapely.get_parts(shapely.difference(outline, shapely.union_all(openings))):
        _draw_polygon(ax, part, fill)


def _draw_polygon(ax: Any, polygon: Any, fill: Any) -> None:
    """Fill a polygon and draw its rims."""
    from matplotlib.patches import PathPatch

    ax.add_patch(PathPatch(_path(polygon), facecolor=fill, edgecolor=style.INK, linewidth=0.8))


def _path(polygon: Any) -> Any:
    """A polygon as matplotlib fills it."""
    from matplotlib.path import Path
    from shapely.geometry.polygon import orient

    polygon = orient(polygon)  # rings that run the other way round stay empty
    rings = [np.asarray(ring.coords)[:, :2] for ring in (polygon.exterior, *polygon.interiors)]
    codes = [[Path.MOVETO, *[Path.LINETO] * (len(ring) - 2), Path.CLOSEPOLY] for ring in rings]
    return Path(np.concatenate(rings), np.concatenate(codes))


@style.styled
def plot_mesh(mesh: TriMesh, ax: Any = None, boundary: bool = True) -> Any:
    """Draw a mesh from above: edges, boundaries and cuts.

    Parameters
    ----------
    mesh : TriMesh
        What to draw.
    ax : matplotlib axes, optional
        Where to draw; a new figure by default.
    boundary : bool
        Whether to draw the outline and the lips of the cuts over the mesh.

    Returns
    -------
    matplotlib axes

    Raises
    ------
    ModelError
        Axes that are not flat.

    Examples
    --------
    >>> import kirigami as kg
    >>> ax = kg.plot.plot_mesh(kg.TriMesh([(0, 0), (1, 0), (1, 1), (0, 1)], [(0, 1, 2), (0, 2, 3)]))
    >>> ax.get_ylabel()
    'y'
    """
    from matplotlib.collections import LineCollection

    points = mesh.nodes[:, :2]
    bounds = np.stack([points.min(axis=0), points.max(axis=0)])
    ax = flat_axes(ax, "plot_mesh", bounds)
    width = float(np.clip(18.0 / np.sqrt(len(mesh.edges)), 0.15, 0.6))  # fine meshes would run together into grey
    edges: Any = points[mesh.edges]
    ax.add_collection(LineCollection(edges, colors=style.GREY, linewidths=width))
    if boundary:
        ax.add_collection(LineCollection(_outlines(mesh, points), colors=style.INK, linewidths=0.9))
        lips = [np.vstack([points[cut.loop], points[cut.loop[: 0 if cut.open else 1]]]) for cut in mesh.cuts]
        ax.add_collection(LineCollection(lips, colors=style.VERMILION, linewidths=1.0))
    style.frame_flat(ax, bounds[0], bounds[1])
    return ax


def _outlines(mesh: TriMesh, points: Floats) -> list[Floats]:
    """Boundary loops as closed lines; drawn edge by edge they would look dashed."""
    return [points[np.append(loop, loop[0])] for loop in mesh.boundary_loops]


@style.styled
def plot_model(
    model: Model,
    ax: Any = None,
    supports: bool = True,
    loads: bool = True,
    view: str | tuple[float, float] | None = None,
    legend: bool = True,
) -> Any:
    """Draw the rest state of a model with its supports, driven displacements and loads.

    Parameters
    ----------
    model : Model
        What to draw.
    ax : matplotlib axes, optional
        Where to draw; a new figure by default.
    supports : bool
        Whether to mark fixed, driven and tied nodes.
    loads : bool
        Whether to draw nodal forces as arrows; the longest is the largest force.
    view : "top", "3d" or (elevation, azimuth), optional
        From above, or from a direction [degrees]; by default from above for models with dim=2 and for flat sheets.
    legend : bool
        Whether to say what the marks mean.

    Returns
    -------
    matplotlib axes

    Raises
    ------
    ModelError
        A model without nodes, an unknown view, or a view in space on flat axes.

    Examples
    --------
    >>> import kirigami as kg
    >>> m = kg.Model(dim=2)
    >>> left, apex, right = m.add(kg.Node(-1, 0), kg.Node(0, 1), kg.Node(1, 0))
    >>> objects = m.add(kg.Bar(left, apex, EA=1.0), kg.Bar(apex, right, EA=1.0), kg.Fix([left, right]))
    >>> [text.get_text() for text in m.plot().get_legend().get_texts()]
    ['fixed xy']
    """
    if not model.nodes:
        raise ModelError("plot_model: the model has no nodes")
    points = model.positions()
    size = float(np.ptp(points, axis=0).max()) or 1.0
    if view is None:
        low = model.dim == 2 or (model.mesh is not None and np.ptp(points[:, 2]) < FLAT * size)
        solid = not low if ax is None else style.is_solid(ax)
        looking: style.View = style.DEFAULT_VIEW if solid else "top"
    else:
        looking = style.checked_view(view, "plot_model")
        solid = looking != "top"
    if ax is None:
        ax = suitable_axes(points, looking, bar=False, foot=legend)[0]
    elif style.is_solid(ax) != solid:
        raise ModelError(f"plot_model: view={view!r} does not go with the axes given")
    sketch = _Sketch(ax, solid, points, size)
    sketch.structure(model)
    if supports:
        sketch.supports(model)
    if loads:
        sketch.loads(model)
    sketch.frame(looking)
    if legend and sketch.labels:
        # In the plane below the name of the axis, whatever the height of the picture; in space at the figure's foot.
        from matplotlib.transforms import offset_copy

        below: Any = ax.figure.transFigure
        if not solid:
            below = offset_copy(ax.transAxes, ax.figure, y=-BELOW, units="points")
        where = {"loc": "lower center" if solid else "upper center", "bbox_to_anchor": (0.5, 0.0)}
        ax.legend(**where, bbox_transform=below, ncols=3, handlelength=1.5)
    return ax


class _Sketch:
    """Draws the parts of a model on flat or solid axes."""

    def __init__(self, ax: Any, solid: bool, points: Floats, size: float) -> None:
        self.ax, self.solid, self.points, self.size = ax, solid, points, size
        self.axes = 3 if solid else 2
        self.labels: set[str] = set()
        self.reach = [points]  # everything that the picture must hold
        if solid:
            ax.computed_zorder = False  # by which marks would vanish behind the facets they lie on

    def structure(self, model: Model) -> None:
        """The sheet, or bars, nodes and springs."""
        if model.mesh is not None:
            self._facets(self.points[model.mesh.triangles], style.PAPER)
            self._lines(_outlines(model.mesh, self.points), 0.8)
            return
        from kirigami.elements.bar import Bar

        pairs = [model.index(item.nodes) for item in model.elements if isinstance(item, Bar)]
        if pairs:
            self._lines(list(self.points[np.array(pairs)]), 1.8 if len(pairs) < 60 else 1.0)
        if len(self.points) <= 400:
            self._dots(self.points, "o", 3.0, style.INK)
        pivots = [item.nodes[1] for item in model.elements if len(item.nodes) == 3]
        if pivots:
            self._dots(self.points[model.index(pivots)], "o", 4.5, style.GREEN, "torsion spring")

    def supports(self, model: Model) -> None:
        """Fixed, driven and tied nodes; on a sheet, the facets between them."""
        from kirigami.model.constraints import Prescribe, Tie
        from kirigami.model.periodic import Periodic
        from kirigami.model.turn import Turn

        driven = []
        fixed: dict[int, str] = {}  # several Fix may hold one node
        for item in model.constraints:
            nodes = model.index(item.group)
            axes = "".join(axis for axis in item.values if axis in "xyz"[: model.dim])
            if isinstance(item, (Prescribe, Turn)):
                driven.append((nodes, axes, item))
            elif isinstance(item, Tie):
                self._mark(model, nodes, "x", style.GREY, f"tied {axes}")
            elif isinstance(item, Periodic):
                self._mark(model, nodes, "x", style.GREY, "repeats another node")
            else:
                fixed.update({node: fixed.get(node, "") + axes for node in nodes.tolist()})
        for axes in sorted(set(map("".join, map(sorted, fixed.values()))), key=len, reverse=True):
            nodes = np.array([node for node, held in fixed.items() if "".join(sorted(held)) == axes])
            whole = len(axes) == model.dim  # what can still move in some direction gets a ring
            self._mark(model, nodes, "s" if whole else "o", style.INK, f"fixed {axes}", None if whole else "white")
        arrows = []
        for nodes, axes, item in driven:
            self._mark(model, nodes, "D", style.VERMILION, f"driven {axes}")
            shift = [item.values.get(axis, np.zeros(len(nodes))) for axis in "xyz"]
            arrows.append((self.points[nodes], np.stack(shift, axis=1)))
        self._arrows(arrows, style.VERMILION, None)

    def loads(self, model: Model) -> None:
        """Forces at nodes; of what is spread over the sheet, one arrow in its middle."""
        forces, spread = [], []
        for item in model.loads:
            if hasattr(item, "force") and item.nodes:
                at = self.points[model.index(item.nodes)]
                forces.append((at, np.tile(item.force, (len(at), 1))))
            elif hasattr(item, "force") and model.mesh is not None:
                mesh, facets = model.mesh, item.facets
                chosen = mesh.regions[facets] if isinstance(facets, str) else slice(None) if facets is None else facets
                middles = self.points[mesh.triangles[chosen]].mean(axis=1)
                middle = np.average(middles, axis=0, weights=mesh.facet_areas[chosen])
                spread.append((middle[None], np.array([item.force])))
        self._arrows(forces, style.BLUE, "load")
        self._arrows(spread, style.BLUE, "load over the sheet")

    def _facets(self, corners: Floats, color: Any, label: str | None = None, alpha: float = 1.0) -> None:
        rims = color if alpha == 1.0 else "none"  # closes the seams between facets; would show where one sees through
        options: dict[str, Any] = {"facecolors": color, "edgecolors": rims, "linewidths": 0.3, "label": label}
        if self.solid:
            from mpl_toolkits.mplot3d.art3d import Poly3DCollection

            self.ax.add_collection3d(Poly3DCollection(corners, alpha=alpha, **options))
        elif alpha == 1.0:
            from matplotlib.collections import PolyCollection

            self.ax.add_collection(PolyCollection(list(corners[..., :2]), **options))
        else:  # where one sees through, seams between facets would show
            import shapely
            from matplotlib.patches import PathPatch

            for part in shapely.get_parts(shapely.union_all(shapely.polygons(corners[..., :2]))):
                self.ax.add_patch(PathPatch(_path(part), facecolor=color, lw=0, label=label, alpha=alpha))
                label = None

    def _lines(self, lines: list[Floats], width: float) -> None:
        if self.solid:
            from mpl_toolkits.mplot3d.art3d import Line3DCollection

            self.ax.add_collection3d(Line3DCollection(lines, colors=style.INK, linewidths=width, zorder=2))
        else:
            from matplotlib.collections import LineCollection

            flat = [line[:, :2] for line in lines]
            self.ax.add_collection(LineCollection(flat, colors=style.INK, linewidths=width, capstyle="round", zorder=2))

    def _mark(
        self, model: Model, nodes: NDArray[np.int64], marker: str, color: Any, label: str, face: Any = None
    ) -> None:
        """Mark constrained nodes: by shading where they cover whole facets, else by markers."""
        if model.mesh is not None:
            inside = np.isin(model.mesh.triangles, nodes).all(axis=1)
            if inside.any():
                corners = self.points[model.mesh.triangles[inside]]
                self._facets(corners, color, self._new(label), alpha=0.2 if face else 0.55)
                nodes = np.setdiff1d(nodes, model.mesh.triangles[inside])
        if len(nodes):
            size = 6.5 if len(nodes) <= 20 else 3.2
            size *= 0.7 if marker in "Dx" else 1.0
            self._dots(self.points[nodes], marker, size, color, label, face)

    def _new(self, label: str | None) -> str | None:
        """The label if it is not in the legend yet."""
        if label is None or label in self.labels:
            return None
        self.labels.add(label)
        return label

    def _dots(
        self, at: Floats, marker: str, size: float, color: Any, label: str | None = None, face: Any = None
    ) -> None:
        look = {"markerfacecolor": face or color, "markeredgecolor": color, "markeredgewidth": 0.8, "zorder": 3}
        place = at[:, : self.axes].T
        self.ax.plot(*place, linestyle="none", marker=marker, markersize=size, label=self._new(label), **look)

    def _arrows(self, groups: Iterable[tuple[Floats, Floats]], color: Any, label: str | None) -> None:
        tails, vectors = [], []
        for at, vector in groups:
            if len(at) > MANY and np.ptp(vector, axis=0).max() == 0.0:
                at, vector = at.mean(axis=0, keepdims=True), vector[:1]
            tails.append(at)
            vectors.append(vector)
        if not tails:
            return
        tail, vector = np.concatenate(tails), np.concatenate(vectors)
        vector = vector * (1.0, 1.0, float(self.solid))
        longest = np.linalg.norm(vector, axis=1).max()
        if longest == 0:
            return
        vector = ARROW * self.size / longest * vector
        kept = np.linalg.norm(vector, axis=1) > 1e-3 * self.size
        tail, vector = tail[kept], vector[kept]
        self.reach.append(tail + 1.15 * vector)
        if self.solid:
            self.ax.quiver(*tail.T, *vector.T, color=color, linewidth=1.6, arrow_length_ratio=0.3, zorder=4)
        else:
            options = {"angles": "xy", "scale_units": "xy", "scale": 1.0, "width": 0.006, "zorder": 4}
            self.ax.quiver(*tail[:, :2].T, *vector[:, :2].T, color=color, **options)
        if label:  # matplotlib would show a box for an arrow
            empty: Any = [[]] * self.axes
            look = {"marker": r"$\rightarrow$", "markersize": 11, "linestyle": "none"}
            self.ax.plot(*empty, color=color, label=self._new(label), **look)

    def frame(self, looking: style.View) -> None:
        """Limits that hold everything drawn."""
        frame(self.ax, np.concatenate(self.reach), looking)


def flat_axes(ax: Any, owner: str, bounds: Floats) -> Any:
    if ax is None:
        return style.new_axes(style.size_for(bounds[0], bounds[1], bar=False))
    if style.is_solid(ax):
        raise ModelError(f"{owner} draws in the plane: give axes made without projection='3d'")
    return ax
