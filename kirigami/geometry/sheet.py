"""A sheet with cuts: an outline, slits without width, holes with area, and the way to a mesh."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely.geometry.base import BaseGeometry

from kirigami.deferred import deferred
from kirigami.errors import GeometryError, KirigamiWarning
from kirigami.geometry.clean import LineWork, clean
from kirigami.geometry.fold_line import Fold, FoldEdges
from kirigami.geometry.given import checked_line_or_polygon, checked_outline, flattened, folds_of, named_lines
from kirigami.geometry.mesh import TriMesh
from kirigami.geometry.refine import LONGEST, triangulate_drawing
from kirigami.geometry.regions import checked_regions, region_borders, region_facets
from kirigami.geometry.sizing import NODES, Sizing, mesh_within, warn_of_coarse
from kirigami.geometry.topology import pair_keys, signed_areas
from kirigami.geometry.triangulate import Triangulation
from kirigami.geometry.unzip import find_cuts, unzip
from kirigami.primitives.checks import (
    require_array,
    require_boolean,
    require_callable,
    require_finite,
    require_instance,
    require_positive,
    require_whole,
)
from kirigami.primitives.material import SheetMaterial
from kirigami.scale import Scale
from kirigami.words import counted

CUT_FRACTION = 0.4  # default edge length along cuts, as a fraction of max_edge
SNAP_PER_EDGE = 200  # the default snapping distance is this part of cut_edge
COARSE = 0.1  # with a budget of n nodes, curves with points closer than this / sqrt(n) of the size are thinned
DENSE = 4  # points per cut_edge beyond which a curve is thinned
LARGEST_SNAP, SMALLEST_SNAP = 1e-4, 1e-9  # default and limit, fractions of the size of the sheet
POOR_ANGLE = 20.0  # degrees; below, bars and hinges lose accuracy
FEWEST_NODES, MOST_NODES = 10, 1_000_000
WIDE = 1e6  # longest wanted edge over the size of the sheet; any beyond asks for the same
LARGEST_MIN_ANGLE = 33.0  # degrees; beyond, refinement need not come to an end


class Sheet:
    """A thin sheet in the plane, with its cuts.

    Parameters
    ----------
    outline : shapely.Polygon or sequence of (x, y)
        The sheet before it is cut; interior rings are holes of the sheet, not numbered as cuts.
    cuts : geometry or nested sequences of geometries
        ``LineString`` and ``LinearRing`` are slits without width, ``Polygon`` is an opening with area; collections and
        lists are taken apart in order, and the position in the resulting flat tuple is the number of the cut. A
        sequence of (x, y) pairs is a slit.
    thickness : float, optional
        Thickness in the unit of the coordinates, handed on to the mesh and the model.
    material : Material, Orthotropic, Laminate or NeoHookean, optional
        Handed on to the mesh and the model.
    folds : geometry, Fold, or nested sequences of them
        Lines along which the sheet is creased and not cut: a :class:`kirigami.Fold` says rest angle and stiffness, a
        mere line is a fold that rests flat.
    regions : mapping of str to shapely.Polygon, MultiPolygon or sequence of (x, y), optional
        Parts of the sheet with a name, to give thickness, material or loads to. Their borders become edges of the mesh,
        and ``mesh.regions`` holds the facets of each.

    Raises
    ------
    GeometryError
        If the outline crosses itself or encloses no area, or a coordinate is not finite, or a cut is neither line nor
        polygon.

    Examples
    --------
    >>> import shapely, kirigami as kg
    >>> sheet = kg.Sheet(shapely.box(0, 0, 2, 1), cuts=shapely.LineString([(0.5, 0.5), (1.5, 0.5)]))
    >>> sheet
    Sheet(2 x 1, area 2, 1 slit, 0 openings)
    >>> mesh = sheet.mesh(max_edge=0.1)
    >>> len(mesh.cuts), round(float(mesh.facet_areas.sum()), 10)
    (1, 2.0)
    """

    def __init__(
        self,
        outline: shapely.Polygon | Sequence[Sequence[float]] | NDArray[np.float64],
        cuts: Any = (),
        thickness: float | None = None,
        material: SheetMaterial | None = None,
        folds: Any = (),
        regions: Mapping[str, Any] | None = None,
    ) -> None:
        self.outline = checked_outline(outline)
        self.cuts: tuple[BaseGeometry, ...] = tuple(
            checked_line_or_polygon(cut, f"cut {number}") for number, cut in enumerate(flattened(cuts))
        )
        self.thickness = None if thickness is None else require_positive(thickness, "thickness", "Sheet")
        self.material = (
            None if material is None else require_instance(material, SheetMaterial, "material", "Sheet")
        )
        self.folds: tuple[Fold, ...] = tuple(folds_of(folds))
        if self.material is not None:
            self.thickness = self.material.checked_thickness(self.thickness, "Sheet")
        self.regions = checked_regions(regions, self.outline)
        self.scale = Scale()  # the units its lengths are told in, of a sheet that is known to be in metres

    @property
    def area(self) -> float:
        """Area of the sheet without its holes and openings."""
        openings = [cut for cut in self.cuts if isinstance(cut, shapely.Polygon)]
        return float(shapely.difference(self.outline, shapely.union_all(openings)).area)

    @property
    def bounds(self) -> tuple[float, float, float, float]:
        """Bounding box of the outline: xmin, ymin, xmax, ymax."""
        xmin, ymin, xmax, ymax = self.outline.bounds
        return xmin, ymin, xmax, ymax

    def mesh(
        self,
        max_edge: float | None = None,
        cut_edge: float | None = None,
        min_angle: float = 28.0,
        *,
        nodes: int | None = None,
        size: Callable[[NDArray[np.float64]], NDArray[np.float64]] | None = None,
        lines: Mapping[str, BaseGeometry] | Sequence[BaseGeometry] = (),
        snap: float | None = None,
        allow_parts: bool = False,
        mesher: str | None = None,
    ) -> TriMesh:
        """Mesh the sheet with triangles, open along every slit.

        Without ``max_edge`` the mesh chooses its own sizes within a budget of nodes: short edges at the tips of cuts,
        four or more facets across every ligament where the budget allows it, long edges elsewhere. What came of it is
        ``mesh.sizing``.

        Parameters
        ----------
        max_edge : float, optional
            Longest wanted edge, in the unit of the coordinates; no edge is longer than 1.1 times this.
        cut_edge : float, optional
            Longest edge along the cuts, 0.4 ``max_edge`` unless given; in between the length grows gradually.
        min_angle : float
            Smallest wanted angle in degrees, at most 33; kept unless the drawing has sharper corners.
        nodes : int, optional
            Budget of nodes of a mesh that chooses its own sizes, kept within a tenth; 4,000 unless given.
        size : callable, optional
            ``size(points)`` gives wanted edge lengths (n,) at points (n, 2) of the drawing; it counts where it is less
            than what ``max_edge`` and ``cut_edge`` give, which goes with it. :meth:`kirigami.study.ErrorEstimate.size`
            makes one.
        lines : mapping of str to geometry, or sequence of geometries
            Lines that are to be mesh edges without being cut, for example the edge of a grip. The nodes on a line with
            a name become the node set of that name.
        snap : float, optional
            Length below which details of the drawing close: points nearer than this become one, and ends of cuts that
            miss by less than half of it are moved onto what they nearly touch. Unless given, ``cut_edge / 200`` but not
            more than 1e-4 of the size of the sheet, which is what a budget of nodes takes: what is smaller would only
            make slivers. Curves with more than four
            points per ``cut_edge`` are thinned by no more than this.
        allow_parts : bool
            Accept cuts that sever the sheet.
        mesher : str, optional
            "triangle" (J. R. Shewchuk's Triangle, which may not be sold on) or "delaunay" (this package's own, slower).
            Unless given, what the environment variable ``KIRIGAMI_MESHER`` says, else Triangle where it is installed.

        Returns
        -------
        TriMesh

        Raises
        ------
        GeometryError
            If the cuts sever the sheet, or a cut lies outside of it or along its outline, or the edge lengths are not
            positive or ask for more than two million facets, or the drawing leaves a sliver that needs too many.

        Warns
        -----
        KirigamiWarning
            About repairs of the drawing, and about angles below 20 degrees; about a budget that the drawing itself
            exceeds or that leaves fewer than two facets across a ligament, and about ligaments narrower than the sheet
            is thick.

        Examples
        --------
        >>> import shapely, kirigami as kg
        >>> slits = [[(0.2, 0.5), (1.2, 0.5)], [(0.8, 0.6), (1.8, 0.6)]]
        >>> mesh = kg.Sheet(shapely.box(0, 0, 2, 1), slits).mesh(nodes=1500)
        >>> abs(len(mesh.nodes) / 1500 - 1) < 0.1, mesh.sizing.facets_across >= 4
        (True, True)
        """
        min_angle = require_finite(min_angle, "min_angle", "Sheet.mesh", GeometryError)
        allow_parts = require_boolean(allow_parts, "allow_parts", "Sheet.mesh", GeometryError)
        if not 0.0 < min_angle <= LARGEST_MIN_ANGLE:
            raise GeometryError(f"min_angle must lie between 0 and {LARGEST_MIN_ANGLE:g} degrees, not {min_angle}")
        names, geometries = named_lines(lines)
        creases = [fold.line for fold in self.folds]
        for border in region_borders(self.regions, self.outline):
            names.append("")
            geometries.append(border)
        xmin, ymin, xmax, ymax = self.bounds
        extent = max(xmax - xmin, ymax - ymin)
        if max_edge is None:
            budget = _budget(nodes, {"cut_edge": cut_edge, "size": size})
            relative = LARGEST_SNAP
            if snap is not None:
                relative = require_positive(snap, "snap", "Sheet.mesh", GeometryError) / extent
            snap, spacing = _checked_snap(relative, extent), COARSE / float(np.sqrt(budget))
            drawing = clean(self.outline, self.cuts, [*geometries, *creases], snap, spacing, allow_parts, mesher)
            made, sizing = mesh_within(drawing, budget, min_angle)
            sizing = replace(sizing, scale=self.scale)
            mesh = self._opened(drawing, made, names, sizing)
            _verify(mesh, drawing, made, np.inf, allow_parts)
            warn_of_coarse(sizing, self.thickness)
            return mesh
        if nodes is not None:
            raise GeometryError("give max_edge or a budget of nodes, not both")
        max_edge = require_positive(max_edge, "max_edge", "Sheet.mesh", GeometryError)
        along_cuts = CUT_FRACTION * max_edge if cut_edge is None else cut_edge
        cut_edge = min(require_positive(along_cuts, "cut_edge", "Sheet.mesh", GeometryError), max_edge)
        relative = (
            min(cut_edge / (SNAP_PER_EDGE * extent), LARGEST_SNAP)
            if snap is None
            else require_positive(snap, "snap", "Sheet.mesh", GeometryError) / extent
        )
        # rounded so that the same drawing in another unit gives the same mesh
        longest, at_cuts = (float(f"{min(length, WIDE):.12g}") for length in (max_edge / extent, cut_edge / extent))
        if snap is None and relative < SMALLEST_SNAP:
            raise GeometryError(
                f"edges of {max_edge:.4g}, along cuts {cut_edge:.4g}, are too short for a sheet of {extent:.4g}: "
                "take longer ones"
            )
        snap = _checked_snap(relative, extent)
        drawing = clean(self.outline, self.cuts, [*geometries, *creases], snap, at_cuts / DENSE, allow_parts, mesher)
        local = None
        if size is not None:
            lengths, frame = require_callable(size, "size", "Sheet.mesh", GeometryError), drawing.frame

            def local(points: NDArray[np.float64]) -> NDArray[np.float64]:
                found = lengths(frame.from_unit(points))
                count = len(points)
                return (
                    require_array(found, (count,), name="what size() gives", owner="Sheet.mesh", error=GeometryError)
                    / frame.size
                )

        made = triangulate_drawing(drawing, longest, at_cuts, min_angle, local)
        mesh = self._opened(drawing, made, names)
        _verify(mesh, drawing, made, max_edge, allow_parts)
        return mesh

    def _opened(
        self, drawing: LineWork, made: Triangulation, names: list[str], sizing: Sizing | None = None
    ) -> TriMesh:
        separates = drawing.label_separates[made.markers]
        triangles, origin = unzip(made.triangles, made.segments[separates])
        nodes = self._exact(drawing, made.points)[origin]
        sets: dict[str, list[NDArray[np.int64]]] = {name: [] for name in names if name}
        for owner, name in enumerate(names, start=1 + len(self.cuts)):
            if name:
                on_line = np.array([owner in owners for owners in drawing.owners])[made.markers]
                sets[name].append(np.flatnonzero(np.isin(origin, made.segments[on_line])))
        node_sets = {name: np.concatenate(pieces) for name, pieces in sets.items()}
        for name, nodes_on_line in node_sets.items():
            if not nodes_on_line.size:
                raise GeometryError(f"line {name!r} does not meet the sheet")
        regions = region_facets(self.regions, nodes, triangles)
        bare = TriMesh(
            nodes, triangles, node_sets, thickness=self.thickness, material=self.material, regions=regions
        )
        label = {
            (min(pair), max(pair)): number
            for pair, number in zip(made.segments.tolist(), made.markers.tolist(), strict=True)
        }
        cuts_of = [drawing.cuts_of(number) for number in range(len(drawing.owners))]
        boundary_cuts = []
        for loop in bare.boundary_loops:
            ends = np.sort(np.column_stack([origin[loop], origin[np.roll(loop, -1)]]), axis=1)
            boundary_cuts.append([cuts_of[label[low, high]] for low, high in ends.tolist()])
        opened = bare.with_cuts(find_cuts(bare, boundary_cuts), sizing)
        return opened.with_folds(self._creased(drawing, made, opened, origin, len(names))) if self.folds else opened

    def _creased(
        self, drawing: LineWork, made: Triangulation, mesh: TriMesh, origin: NDArray[np.int64], before: int
    ) -> list[FoldEdges]:
        """The edges of the opened mesh along each fold; where folds lie on one another they are the first one's."""
        count = int(origin.max()) + 1
        inner = np.flatnonzero(mesh.edge_facets[:, 1] >= 0)
        keys = pair_keys(origin[mesh.edges[inner]], count)
        free = np.ones(len(inner), bool)
        found = []
        for number, fold in enumerate(self.folds):
            owner = 1 + len(self.cuts) + before + number
            along = np.array([owner in owners for owners in drawing.owners])[made.markers]
            mine = np.isin(keys, pair_keys(made.segments[along], count)) & free
            free &= ~mine
            if mine.any():
                found.append(FoldEdges(mesh.edges[inner[mine]], fold.angle, fold.stiffness))
            else:
                warnings.warn(
                    f"fold {number} folds nothing: it lies outside the sheet, or along a rim, a cut or another fold",
                    KirigamiWarning, stacklevel=4,
                )  # fmt: skip
        return found

    def _exact(self, drawing: LineWork, unit_points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Coordinates in the unit of the drawing; those that rounding has moved off a drawn one are put back on it."""
        points = drawing.frame.from_unit(unit_points)
        drawn = np.concatenate([shapely.get_coordinates(geometry) for geometry in (self.outline, *self.cuts)])
        reach = 2e-12 * drawing.frame.size + 4 * np.finfo(float).eps * np.abs(drawn).max()
        for axis in (0, 1):
            values = np.unique(drawn[:, axis])
            above = np.searchsorted(values, points[:, axis]).clip(1, len(values) - 1)
            below = values[above - 1]
            nearest = np.where(points[:, axis] - below < values[above] - points[:, axis], below, values[above])
            points[:, axis] = np.where(np.abs(points[:, axis] - nearest) <= reach, nearest, points[:, axis])
        return points

    from_dxf = deferred("kirigami.drawing.convert:sheet_from_dxf", static=True)
    from_svg = deferred("kirigami.drawing.convert:sheet_from_svg", static=True)
    from_geojson = deferred("kirigami.drawing.convert:sheet_from_geojson", static=True)
    from_fold = deferred("kirigami.drawing.convert:sheet_from_fold", static=True)
    to_dxf = deferred("kirigami.drawing.dxf:write_dxf")
    to_svg = deferred("kirigami.drawing.svg:write_svg")
    to_geojson = deferred("kirigami.drawing.geojson:write_geojson")
    to_fold = deferred("kirigami.drawing.fold:write_fold")
    plot = deferred("kirigami.plot.undeformed:plot_sheet")

    def _repr_svg_(self) -> str:
        lines = [fold.line for fold in self.folds]
        return str(shapely.GeometryCollection([self.outline, *self.cuts, *lines])._repr_svg_())

    def __repr__(self) -> str:
        xmin, ymin, xmax, ymax = self.bounds
        openings = sum(isinstance(cut, shapely.Polygon) for cut in self.cuts)
        slits = len(self.cuts) - openings
        folds = f", {counted(len(self.folds), 'fold')}" if self.folds else ""
        return (
            f"{type(self).__name__}({xmax - xmin:.4g} x {ymax - ymin:.4g}, area {self.area:.4g}, "
            f"{counted(slits, 'slit')}, {counted(openings, 'opening')}{folds})"
        )


def _verify(mesh: TriMesh, drawing: LineWork, made: Triangulation, max_edge: float, allow_parts: bool) -> None:
    """Hold the mesh to what a mesh of this drawing must be; the mesh generator itself reports nothing."""
    area = float(signed_areas(made.points, made.triangles).sum())
    if abs(area - drawing.area) > 1e-10 * drawing.area:
        raise GeometryError(
            f"the mesh generator failed: the facets cover {area / drawing.area:.6f} of the sheet; simplify the drawing "
            "or try another max_edge"
        )
    parts = int(mesh.facet_parts.max()) + 1
    if parts > 1 and not allow_parts:
        raise GeometryError(f"the mesh generator failed: the mesh has {counted(parts, 'part')}; try another max_edge")
    if mesh.min_angle < POOR_ANGLE:
        # the corner of the drawing, or the detail, to look at
        worst = mesh.nodes[mesh.triangles[int(np.argmin(mesh.facet_min_angles))], :2].mean(axis=0)
        warnings.warn(
            f"the smallest angle of the mesh is {counted(mesh.min_angle, 'degree', spec='.3g')}, at ({worst[0]:.6g}, "
            f"{worst[1]:.6g}): the drawing has a sharp corner or a narrow gap there",
            KirigamiWarning,
            stacklevel=3,
        )
    longest = int(np.argmax(mesh.edge_lengths))
    if mesh.edge_lengths[longest] > LONGEST * max_edge:
        x, y, _ = mesh.nodes[mesh.edges[longest]].mean(axis=0)
        warnings.warn(
            f"an edge at ({x:.6g}, {y:.6g}) is {mesh.edge_lengths[longest] / max_edge:.3g} times max_edge",
            KirigamiWarning,
            stacklevel=3,
        )


# --- what may be drawn ---------------------------------------------------------------------------------------------


def _checked_snap(relative: float, extent: float) -> float:
    """The snapping distance, a share of the size of the sheet; rounded so that no unit of length shows in the mesh."""
    if not SMALLEST_SNAP <= relative <= 1e-2:
        raise GeometryError(
            f"details can be snapped at {SMALLEST_SNAP * extent:.3g} to {1e-2 * extent:.3g} for a sheet of this size, "
            f"not at {relative * extent:.3g}: give another `snap`"
        )
    return float(f"{relative:.12g}")


def _budget(nodes: int | None, unused: Mapping[str, Any]) -> int:
    """The budget of nodes of a mesh that chooses its own sizes."""
    for name, value in unused.items():
        if value is not None:
            raise GeometryError(f"{name} goes with max_edge; without it the mesh chooses its own sizes")
    if nodes is None:
        return NODES
    count = require_whole(nodes, "nodes", "Sheet.mesh", FEWEST_NODES, GeometryError)
    if count > MOST_NODES:
        raise GeometryError(f"nodes must be a whole number from {FEWEST_NODES} to {MOST_NODES:,}, not {count}")
    return count
