"""A gradient drawn on the sheet: where thicker, where stiffer, where longer."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from kirigami.geometry.mesh import TriMesh
from kirigami.plot import style
from kirigami.plot.undeformed import flat_axes
from kirigami.primitives.checks import require_array, require_instance


@style.styled
def plot_gradient(mesh: TriMesh, values: ArrayLike, ax: Any = None, label: str | None = None) -> Any:
    """Draw a gradient by facets on the sheet, per area, so that it does not show how large the facets are.

    Parameters
    ----------
    mesh : TriMesh
        The mesh of the results.
    values : array_like, shape (facets,)
        What ``results.gradient(..., "thickness")`` gives, or a column of that by "strain".
    ax : matplotlib axes, optional
        Where to draw; a new figure by default.
    label : str, optional
        What stands at the colour bar.

    Returns
    -------
    matplotlib axes

    Raises
    ------
    ModelError
        No mesh, values of another number, or axes that are not flat.

    Examples
    --------
    >>> import kirigami as kg
    >>> mesh = kg.TriMesh([[0, 0], [1, 0], [1, 1], [0, 1]], [[0, 1, 2], [0, 2, 3]])
    >>> kg.plot.plot_gradient(mesh, [1.0, -2.0]).get_aspect()
    1.0
    """
    require_instance(mesh, TriMesh, "mesh", "plot_gradient")
    given = require_array(values, (len(mesh.triangles),), name="values", owner="plot_gradient")
    density = given / mesh.facet_areas
    points = mesh.nodes[:, :2]
    bounds = np.stack([points.min(axis=0), points.max(axis=0)])
    ax = flat_axes(ax, "plot_gradient", bounds)
    size = float(np.abs(density).max(initial=0.0)) or 1.0
    drawn = ax.tripcolor(
        *points.T, mesh.triangles, facecolors=density, cmap=style.diverging_map(), vmin=-size, vmax=size
    )
    style.frame_flat(ax, *bounds)
    style.color_bar(ax, drawn, "gradient per area" if label is None else label)
    return ax
