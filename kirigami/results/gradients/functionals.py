"""What an equilibrium can be asked for, with its derivatives by positions, by forces and by the stored energy."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from kirigami.elements.triangle import SurfaceStrain
from kirigami.errors import AnalysisError, ModelError
from kirigami.post import shape
from kirigami.primitives.checks import (
    require_array,
    require_axis,
    require_between,
    require_finite,
    require_whole_array,
    shown,
)
from kirigami.primitives.kernel import Array
from kirigami.primitives.node import AXES
from kirigami.primitives.rotation import best_rotation, turned
from kirigami.results.cut_edges import cut_edges
from kirigami.results.results import Results, _direction
from kirigami.results.supports import carried_by

STEP = 1e-6  # of the size of the structure or of its forces, in differences of a user's function
POWER, MOST_POWER = 3.0, 4.0  # below 4 the tips of cuts, where strain grows as r^(-1/2), count what they do in truth
ENGINEERING = np.array([1.0, 1.0, 0.5])  # weights of (exx, eyy, gamma) in the size of a strain
AT_ONCE = 3_000  # coordinates of shapes measured at a time
OUTSIDE = 1e-6  # of the size of the sheet: how far off it a material point may lie
KNOWN = "force, position, point, energy, open_area, height, width, poisson_ratio, strain, shape, stiffness, critical"


class Told(NamedTuple):
    """A number and its derivatives: by the rows (rows, 3), by nodal forces (n, 3) and by the stored energy."""

    value: float
    by_position: Array
    by_force: Array
    by_energy: float = 0.0
    by_drawing: Callable[[Any], float] | None = None  # the number, had it been measured against another drawn mesh


# Of the rows (rows, 3), which are the positions of nodes and what elements keep behind them, of forces (n, 3) of the
# supports on the nodes, and of the stored energy.
Tell = Callable[[Array, Array, float], Told]


def tell_of(functional: Any, results: Results, owner: str = "gradient") -> Tell:
    """The function that a functional stands for, on the nodes and supports of `results`."""
    if callable(functional):
        return _own(functional, owner)
    name, *given = _parts(functional, owner)
    builders: dict[str, Callable[..., Tell]] = {
        "force": _force, "position": _position, "point": _point, "energy": _energy, "open_area": _open_area,
        "height": _height, "width": _width, "poisson_ratio": _poisson_ratio, "strain": _strain,
        "shape": _shape,
    }  # fmt: skip
    if name not in builders:
        raise ModelError(f"{owner}: a functional is a function or begins with one of {KNOWN}, got {shown(functional)}")
    try:
        return builders[name](results, *given)
    except TypeError:
        raise ModelError(f"{owner}: {shown(functional)} has too many parts or too few: see the reference") from None


def _parts(functional: Any, owner: str) -> tuple[Any, ...]:
    if isinstance(functional, str):
        return (functional,)
    if isinstance(functional, tuple) and functional and isinstance(functional[0], str):
        return functional
    raise ModelError(
        f"{owner}: a functional is a function, or a tuple such as ('force', nodes, 'y'), got {shown(functional)}"
    )


def _zero(like: Array) -> Array:
    return np.zeros_like(like)


def _of_rows(by_nodes: Array, rows: Array) -> Array:
    """Derivatives by the nodes as those by all rows."""
    found = np.zeros_like(rows)
    found[: len(by_nodes)] = by_nodes
    return found


def _force(results: Results, nodes: Any, axis: Any) -> Tell:
    direction = np.zeros(3)
    along = _direction(axis)
    direction[: len(along)] = along
    weight = carried_by(results.node_index(nodes), results.supports, len(results.rest)) * direction
    return lambda x, f, energy: Told(float((weight * f).sum()), _zero(x), weight)


def _position(results: Results, nodes: Any, axis: str) -> Tell:
    index, letter = results.node_index(nodes), AXES.index(require_axis(axis, "gradient"))
    weight = np.zeros_like(results.rest)
    np.add.at(weight[:, letter], index, 1.0 / len(index))
    return lambda x, f, energy: Told(float((weight * x[: len(weight)]).sum()), _of_rows(weight, x), _zero(f))


def _point(results: Results, at: Any, axis: str) -> Tell:
    """Where the material point goes that was drawn at (x, y)."""
    if results.mesh is None:
        raise AnalysisError("gradient: a point of the drawing needs a model made by Model.from_mesh", results=results)
    place = require_array(at, (2,), name="the point", owner="gradient")
    letter = AXES.index(require_axis(axis, "gradient"))
    corners, share = _within(results.mesh, place)

    def again(x: Array, mesh: Any) -> float:
        corners, share = _within(mesh, place)
        return float(share @ x[corners, letter])

    def tell(x: Array, f: Array, energy: float) -> Told:
        rate = _zero(x)
        rate[corners, letter] = share
        return Told(float(share @ x[corners, letter]), rate, _zero(f), by_drawing=lambda mesh: again(x, mesh))

    return tell


def _within(mesh: Any, place: Array) -> tuple[Any, Array]:
    """Corners (3,) of the facet of a drawn mesh that a place lies in, and its barycentric coordinates there."""
    corner = mesh.nodes[mesh.triangles][..., :2]
    along, across, to = corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0], place - corner[:, 0]
    area = along[:, 0] * across[:, 1] - along[:, 1] * across[:, 0]
    second = (to[:, 0] * across[:, 1] - to[:, 1] * across[:, 0]) / area
    third = (along[:, 0] * to[:, 1] - along[:, 1] * to[:, 0]) / area
    share = np.stack([1 - second - third, second, third], axis=1)
    facet = int(np.argmax(share.min(axis=1)))
    if share[facet].min() < -OUTSIDE * mesh.size / np.sqrt(abs(area[facet])):
        raise ModelError(f"gradient: the point ({place[0]:.6g}, {place[1]:.6g}) is not on the sheet as it is drawn")
    return mesh.triangles[facet], share[facet]


def _energy(results: Results) -> Tell:
    return lambda x, f, energy: Told(energy, _zero(x), _zero(f), 1.0)


def _open_area(results: Results, which: Any = None) -> Tell:
    if results.mesh is None:
        raise AnalysisError("gradient: open_area needs a model made by Model.from_mesh", results=results)
    cuts = cut_edges(results, results.mesh)
    if which is not None:
        chosen = require_whole_array(which, (None,), name="the cuts", owner="gradient").tolist()
        if not chosen or not all(0 <= number < len(cuts) for number in chosen):
            raise ModelError(f"gradient: cuts are numbered from 0 to {len(cuts) - 1}, got {shown(which)}")
        cuts = [cuts[number] for number in chosen]

    def tell(x: Array, f: Array, energy: float) -> Told:
        rate, total = _zero(x), 0.0
        for edges in cuts:
            area, by_rows = edges.area(x)
            total, rate = total + area, rate + by_rows
        return Told(total, rate, _zero(f))

    return tell


def _height(results: Results) -> Tell:
    def tell(x: Array, f: Array, energy: float) -> Told:
        heights = x[: len(f), 2]
        high, low = int(np.argmax(heights)), int(np.argmin(heights))
        rate = _zero(x)
        rate[high, 2] += 1.0
        rate[low, 2] -= 1.0
        return Told(float(x[high, 2] - x[low, 2]), rate, _zero(f))

    return tell


def _width(results: Results, axis: str = "y") -> Tell:
    return _measured(results, "width", lambda x, mesh: shape.width(x, mesh, axis))


def _poisson_ratio(results: Results, axis: str = "y") -> Tell:
    return _measured(results, "poisson_ratio", lambda x, mesh: shape.poisson_ratio(x, mesh, axis))


def _strain(results: Results, power: float = POWER) -> Tell:
    """Mean of a power of the strain of the facets from how they are drawn, and the root of it."""
    mesh, power = results.mesh, require_between(power, 1.0, MOST_POWER, "the power of the strain", "gradient")
    if mesh is None:
        raise AnalysisError("gradient: strain needs a model made by Model.from_mesh", results=results)

    def mean(points: Array, drawn: Any) -> tuple[float, SurfaceStrain, Array, Array]:
        surface = SurfaceStrain(drawn.nodes, drawn.triangles)
        strain = surface.at(points - drawn.nodes)
        size = np.sqrt((strain**2 * ENGINEERING).sum(axis=1))
        share = surface.area / surface.area.sum()
        whole = float((share * size**power).sum() ** (1 / power))
        positive = size > 0
        rate = np.where(positive, share * whole ** (1 - power) * np.where(positive, size, 1.0) ** (power - 2), 0.0)
        return whole, surface, strain, rate[:, None] * ENGINEERING * strain

    def tell(x: Array, f: Array, energy: float) -> Told:
        points = x[: len(mesh.nodes)]
        value, surface, _, by_strain = mean(points, mesh)
        rate = _zero(x)
        surface.add_rate(points - mesh.nodes, by_strain if value > 0 else np.zeros_like(by_strain), rate)
        return Told(value, rate, _zero(f), by_drawing=lambda other: mean(points, other)[0])

    return tell


def _measured(results: Results, name: str, measure: Callable[[Array, Any], Array]) -> Tell:
    """A measure of shapes, many of which it takes at once: by differences of the nodes on the outline."""
    mesh = results.mesh
    if mesh is None:
        raise AnalysisError(f"gradient: {name} needs a model made by Model.from_mesh", results=results)

    def tell(x: Array, f: Array, energy: float) -> Told:
        points = x[: len(mesh.nodes)]
        moving = [(node, axis) for node in mesh.boundary("outer") for axis in (0, 1)]
        step, rate = STEP * float(np.ptp(points, axis=0).max()), _zero(x)
        for start in range(0, len(moving), AT_ONCE):
            part = moving[start : start + AT_ONCE]
            both = np.repeat(points[None], 2 * len(part), axis=0)
            for row, (node, axis) in enumerate(part):
                both[2 * row, node, axis] += step
                both[2 * row + 1, node, axis] -= step
            values = measure(both, mesh)
            for row, (node, axis) in enumerate(part):
                rate[node, axis] = (values[2 * row] - values[2 * row + 1]) / (2 * step)
        return Told(
            float(measure(points[None], mesh)[0]), rate, _zero(f),
            by_drawing=lambda other: float(measure(points[None], other)[0]),
        )  # fmt: skip

    return tell


def _shape(results: Results, target: Any) -> Tell:
    """Mean squared distance from a target shape, laid over the nodes as well as a rigid motion can."""
    count = len(results.rest)
    wanted = require_array(target, (count, 3), name="the target shape", owner="gradient")
    arms = wanted - wanted.mean(axis=0)

    def tell(x: Array, f: Array, energy: float) -> Told:
        now = x[:count] - x[:count].mean(axis=0)
        apart = now - (arms + turned(best_rotation(arms, now), arms))
        return Told(float((apart**2).sum() / count), _of_rows(2 * apart / count, x), _zero(f))

    return tell


def _own(function: Callable[..., Any], owner: str) -> Tell:
    """A user's function of positions and forces: it returns a number, or also its two derivatives (n, 3)."""

    def tell(rows: Array, f: Array, energy: float) -> Told:
        x = rows[: len(f)]
        answer = function(x.copy(), f.copy())
        if isinstance(answer, tuple):
            if len(answer) != 3:
                raise ModelError(f"{owner}: a functional returns a number, or (number, by positions, by forces)")
            rates = [require_array(part, x.shape, name="a derivative", owner=owner) for part in answer[1:]]
            value = require_finite(answer[0], "what the functional returns", owner)
            return Told(value, _of_rows(rates[0], rows), rates[1])
        value = require_finite(answer, "what the functional returns", owner)
        derivatives = []
        for given, size in ((x, float(np.ptp(x, axis=0).max())), (f, float(np.abs(f).max()))):
            step, rate = STEP * (size or 1.0), np.zeros_like(given)
            for place in np.ndindex(*given.shape):
                sides = []
                for sign in (1.0, -1.0):
                    moved = given.copy()
                    moved[place] += sign * step
                    pair = (moved, f.copy()) if given is x else (x.copy(), moved)
                    sides.append(require_finite(function(*pair), "what the functional returns", owner))
                rate[place] = (sides[0] - sides[1]) / (2 * step)
            derivatives.append(rate)
        return Told(value, _of_rows(derivatives[0], rows), derivatives[1])

    return tell
