"""Measures of results: height, width, open area, Poisson ratio, curvature, energy shares; each a method of Results."""

from __future__ import annotations

from typing import TYPE_CHECKING

from numpy.typing import ArrayLike

from kirigami.errors import AnalysisError
from kirigami.post import curvature as angles
from kirigami.post import energy, shape
from kirigami.post.opening import areas
from kirigami.primitives.checks import require_boolean
from kirigami.primitives.kernel import Array
from kirigami.results.cut_edges import bulges, cut_edges

if TYPE_CHECKING:
    from kirigami.geometry.mesh import TriMesh
    from kirigami.results.results import Results


def height(results: Results) -> Array:
    """Largest minus smallest z of all nodes (s,) [length]; see :func:`kirigami.post.shape.height`."""
    return shape.height(results.position())


def width(results: Results, axis: str = "y", band: float = 0.5) -> Array:
    """Mean width across the pull (s,) [length], over a band at mid height.

    Parameters
    ----------
    axis : {"y", "x"}
        Direction of the pull.
    band : float
        Height of the band over the height of the sheet; see :func:`kirigami.post.shape.width`.

    Raises
    ------
    AnalysisError
        The model was not made from a mesh.
    ModelError
        An unknown axis, or a band out of range.
    """
    return shape.width(_points(results, "width"), _drawn(results, "width"), axis, band)


def poisson_ratio(results: Results, axis: str = "y", band: float = 0.5, strain: ArrayLike | None = None) -> Array:
    """Minus the relative change of width over the axial strain (s,); nan at steps without strain.

    Parameters
    ----------
    axis : {"y", "x"}
        Direction of the pull.
    band : float
        Height of the band over the height of the sheet; see :func:`kirigami.post.shape.poisson_ratio`.
    strain : array_like, shape (s,), optional
        What to divide by; by default the strain of the band itself.

    Raises
    ------
    AnalysisError
        The model was not made from a mesh.
    ModelError
        An unknown axis, a band out of range, or strains of another number.

    Examples
    --------
    >>> import kirigami as kg
    >>> mesh = kg.Sheet([(0, 0), (1, 0), (1, 2), (0, 2)]).mesh(0.1)
    >>> m = kg.Model.from_mesh(mesh, thickness=0.01, material=kg.Material(E=1e9), dim=2)
    >>> top = m.select(boundary="top")
    >>> held = m.add(kg.Fix(m.select(boundary="bottom")), kg.Fix(top, "x"), kg.Prescribe(top, y=1e-3))
    >>> bool(0.3 < kg.LinearStatic(m).run().poisson_ratio()[-1] < 0.4)  # bars make about 1/3
    True
    """
    return shape.poisson_ratio(_points(results, "poisson_ratio"), _drawn(results, "poisson_ratio"), axis, band, strain)


def curvature(results: Results, kind: str = "mean", per: str = "facet") -> Array:
    """Curvature of the sheet (s, facets) or (s, nodes), from the angles of its hinges.

    Parameters
    ----------
    kind : {"mean", "gaussian", "principal", "tensor"}
        Which; see :func:`kirigami.post.curvature.curvature` for shapes and units.
    per : {"facet", "node"}
        Where.

    Raises
    ------
    AnalysisError
        The model was not made from a mesh.
    ModelError
        An unknown kind or place, or a mesh that is not flat.
    """
    return angles.curvature(_points(results, "curvature"), _drawn(results, "curvature"), kind, per)


def energy_shares(results: Results) -> dict[str, Array]:
    """Energy by kind over the whole, each (s,); 0 where nothing is stored.

    Raises
    ------
    ModelError
        The structure has no elements.

    Examples
    --------
    >>> import kirigami as kg
    >>> m = kg.Model(dim=2)
    >>> a, b = m.add(kg.Node(0, 0), kg.Node(2, 0))
    >>> objects = m.add(kg.Bar(a, b, EA=10.0), kg.Fix(a), kg.Fix(b, "y"), kg.NodalLoad(b, (1, 0)))
    >>> kg.LinearStatic(m).run().energy_shares()["bars"].tolist()
    [0.0, 1.0]
    """
    return energy.energy_shares(results.energy)


def open_area(results: Results, union: bool = False) -> Array:
    """Projected area of the cut openings [length^2]; edges of shell facets are the parabolas that they are.

    Parameters
    ----------
    union : bool
        False: each cut by itself, (s, cuts). True: area of their union, (s,).

    Raises
    ------
    AnalysisError
        The model was not made from a mesh.
    """
    mesh = _drawn(results, "open_area")
    union = require_boolean(union, "union", "open_area")
    edges, position = cut_edges(results, mesh), results.position()
    loops = [position[:, each.start, :2] for each in edges]
    return areas(loops, len(position), union, bulges(results, edges))


def _points(results: Results, owner: str) -> Array:
    """Positions (s, n, 3) of the nodes of the mesh."""
    return results.position()[:, : len(_drawn(results, owner).nodes)]


def _drawn(results: Results, owner: str) -> TriMesh:
    """The mesh, or an AnalysisError."""

    if results.mesh is None:
        raise AnalysisError(f"{owner} needs a model made by Model.from_mesh", results=results)
    return results.mesh
