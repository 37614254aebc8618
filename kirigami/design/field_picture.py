"""A gradient drawn on the sheet: where thicker, where stiffer, where longer."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from kirigami.geometry.mesh import TriMesh
from kirigami.plot import style
from kirigami.primitives.checks import require_array, require_instance


@style.styled
def plot_gradient(mesh: TriMesh, values: ArrayLike, ax: Any = None, label: str = "gradient per area") -> Any:
    """Draw a gradient by facets on the sheet, per area, so that it does not show how large the facets are.

    Parameters
    ----------
    mesh : TriMesh
        The mesh of the results.
    values : array_like, shape (facets,)
        What ``results.gradient(..., "thickness")`` gives, or a column of that by "strain".
    ax : matplotlib Axes, optional
        Where to draw.
    label : str
        What stands at the colour bar.

    Returns
    -------
    matplotlib Axes

    Raises
    ------
    ModelError
        No mesh, or values of another number.

    Examples
    --------
    >>> import kirigami as kg
    >>> from kirigami.design.field_picture import plot_gradient
    >>> mesh = kg.TriMesh([[0, 0], [1, 0], [1, 1], [0, 1]], [[0, 1, 2], [0, 2, 3]])
    >>> plot_gradient(mesh, [1.0, -2.0]).get_aspect()
    1.0
    """
    require_instance(mesh, TriMesh, "mesh", "plot_gradient")
    given = require_array(values, (len(mesh.triangles),), name="values", owner="plot_gradient")
    density = given / mesh.facet_areas
    ax = style.new_axes((4.5, 4.0)) if ax is None else ax
    size = float(np.abs(density).max(initial=0.0)) or 1.0
    drawn = ax.tripcolor(
        mesh.nodes[:, 0], mesh.nodes[:, 1], mesh.triangles, facecolors=density, cmap=style.diverging_map(), vmin=-size,
        vmax=size,
    )  # fmt: skip
    ax.set_aspect("equal")
    ax.set_axis_off()
    style.color_bar(ax, drawn, label)
    return ax
