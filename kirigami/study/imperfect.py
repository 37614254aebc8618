"""The imperfection a sheet has: how it would lie if a random pressure had been at work on it, free of stress.

No sheet is flat. Which of its many buckled shapes a pull leads to depends on how it was not flat, so a study must be
able to say it, and to say the same on another mesh and another rung. The field is the small deflection of the
supported structure under a random pressure that is a function of place alone: with bending modes v_k of eigenvalue
s_k it is the sum of v_k (v_k . pressure) / s_k, a smooth random sum of all bending modes that does not ask for one of
them, whose signs and mixtures depend on the mesh. Clamps stay clamped, and the lips of a cut part.
"""

from __future__ import annotations

import numpy as np
from scipy.sparse import diags

from kirigami.errors import ModelError
from kirigami.linalg import factorize
from kirigami.linalg.checked import SingularMatrixError
from kirigami.linalg.eigenpairs import grounded, orthonormal, resists
from kirigami.model.model import Model
from kirigami.primitives.checks import require_finite, require_whole
from kirigami.primitives.kernel import Array
from kirigami.study.quadrature import POINTS, WEIGHTS
from kirigami.study.shape.space import FLAT
from kirigami.system.supports import rigid_unknowns
from kirigami.system.system import System
from kirigami.words import counted

SHARE = 0.1  # of the thickness is the default height: a strip bowed by it is 6 % more compliant, until it is straight
WAVES = 64  # of which the pressure is the sum
LONGEST, SHORTEST = 1.0, 16.0  # wave numbers times the radius of gyration: from twice the sheet to an eighth of it
ROUND = 0.01  # difference of the principal moments, relative, below which a sheet has no long direction


def imperfect(model: Model, amplitude: float | None = None, seed: int = 0) -> None:
    """Give a model the stress-free imperfection a sheet has: a smooth random field of its bending modes.

    It is the shape under a random pressure of long waves, in which soft modes are strong and stiff ones weak, and the
    same field on every mesh of a sheet and in every unit of length; it turns with the sheet. Add the supports first:
    what they hold stays where it is.

    Parameters
    ----------
    model : Model
        The model, with dim=3; its rest state is moved.
    amplitude : float, optional
        Largest offset of a node [length]; None takes a tenth of the thickness of the sheet, 0 does nothing.
    seed : int
        Another number is another field; the negative amplitude is the field to the other side.

    Raises
    ------
    ModelError
        A model in the plane; no amplitude where there is no thickness; nothing that bends and resists bending.

    Examples
    --------
    >>> import shapely, kirigami as kg
    >>> sheet = kg.Sheet(shapely.box(0, 0, 2, 1), thickness=0.01, material=kg.Material(E=1e9))
    >>> m = kg.Model.from_mesh(sheet.mesh(0.2))
    >>> held = m.add(kg.Fix(m.select(boundary="left"), clamp=True))
    >>> m.imperfect()
    >>> heights = m.positions()[:, 2]
    >>> round(float(abs(heights).max()), 12), float(abs(heights[m.index(m.select(boundary="left"))]).max())
    (0.001, 0.0)
    """
    if model.dim == 2:
        raise ModelError("imperfect: a sheet is imperfect out of its plane, which a model with dim=2 does not know")
    seed = require_whole(seed, "seed", "imperfect", least=0)
    height = _height(model) if amplitude is None else require_finite(amplitude, "amplitude", "imperfect")
    if height:
        shape = bending_field(model, seed)
        model.perturb(shape, amplitude=height)


def _height(model: Model) -> float:
    """A tenth of the thickness, of the thinnest part where it varies."""
    constants = model.sheet_constants
    if constants is None:
        raise ModelError("imperfect: give an amplitude; only sheets have a thickness to measure it by")
    return SHARE * float(np.min(constants.thickness))


def bending_field(model: Model, seed: int) -> Array:
    """The shape (nodes, 3) of the imperfection with a seed, of any size."""
    place = model.positions()
    if len(place) < 3:
        raise ModelError(f"imperfect: a model of {counted(len(place), 'node')} has nothing that bends")
    loads, areas, normal = _random_loads(model, place, seed)
    system = System(model)
    if not system.free:
        raise ModelError("imperfect: the supports hold every node, so that nothing can be out of its place")
    rest = np.zeros_like(system.rest)
    matrix = system.matrix(system.stiffness_blocks(rest, 0.0))

    def reduced(values: Array) -> Array:
        rows = np.zeros_like(system.rest)
        rows[: len(place)] = values  # behind the nodes follow the unknowns of elements
        return system.reduce(system.carried(rows, rest))

    weight = reduced(np.repeat(areas[:, None], 3, axis=1))
    # A free body gets loads that do not move it as a whole, and a field without such a motion.
    rigid = orthonormal(rigid_unknowns(system, rest, matrix), diags(weight, format="csc"))
    force = reduced(loads)
    force = force - weight * (rigid @ (rigid.T @ force))
    supported = grounded(matrix, rigid)
    try:
        factor = factorize(supported)
        if not resists(supported, factor):
            raise SingularMatrixError
    except SingularMatrixError:
        raise ModelError(
            "imperfect: parts of the model move without resistance, so no field of bending modes can be told; give it "
            "hinges or supports, or move it by m.perturb(shape)"
        ) from None
    found = factor.solve(force)
    found = found - rigid @ (rigid.T @ (weight * found))
    field = np.asarray(system.small_displacement(found, 0.0)[: len(place)], dtype=float)
    if normal is not None:
        field = np.outer(field @ normal, normal)
    if not np.isfinite(field).all() or not np.abs(field).max(initial=0.0) > 0:
        raise ModelError("imperfect: the supports hold every node, so that nothing can be out of its place")
    return field


def _random_loads(model: Model, place: Array, seed: int) -> tuple[Array, Array, Array | None]:
    """Loads (n, 3) of a random pressure, areas (n,) of the nodes, and the normal of a sheet that is flat."""
    mesh = model.mesh
    if mesh is None:
        areas: Array = np.ones(len(place))
        centre, axes, size, flat = _frame(place, areas)
        waves = _Waves(seed, centre, axes, size, flat)
        directions = np.column_stack([waves(place, number) for number in range(3)])
        return (np.outer(directions[:, 0], axes[2]) if flat else directions), areas, axes[2] if flat else None
    corners = place[mesh.triangles]
    points = np.einsum("qc,mcx->mqx", POINTS, corners)
    shares = np.outer(mesh.facet_areas, WEIGHTS)
    areas = np.asarray(np.bincount(mesh.triangles.ravel(), np.repeat(mesh.facet_areas / 3, 3), len(place)), dtype=float)
    centre, axes, size, flat = _frame(points.reshape(-1, 3), shares.ravel())
    pressure = _Waves(seed, centre, axes, size, flat)(points.reshape(-1, 3)).reshape(shares.shape)
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    forces = np.einsum("mq,qc->mc", shares * pressure, POINTS)[:, :, None] * normals[:, None, :]
    loads = np.zeros((len(place), 3))
    np.add.at(loads, mesh.triangles, forces)
    return loads, areas, axes[2] if flat else None


def _frame(points: Array, weights: Array) -> tuple[Array, Array, float, bool]:
    """Centroid, principal axes as rows (3, 3), radius of gyration, and whether all lies in the plane of the first two.

    Axes that are no better than any other are those of the drawing; each points to the positive side.
    """
    share = weights / weights.sum()
    centre = share @ points
    offset = points - centre
    moments, columns = np.linalg.eigh((offset * share[:, None]).T @ offset)
    moments, axes = moments[::-1], columns.T[::-1]
    size = float(np.sqrt(moments.sum()))
    flat = bool(np.abs(offset @ axes[2]).max() <= FLAT * size)
    if moments[0] - moments[1] < ROUND * moments[0]:
        if flat:
            first = np.eye(3)[int(np.argmin(np.abs(axes[2])))]
            first = first - (first @ axes[2]) * axes[2]
            first /= np.linalg.norm(first)
            axes = np.array([first, np.cross(axes[2], first), axes[2]])
        else:
            axes = np.eye(3)
    signs = np.sign(axes[np.arange(3), np.argmax(np.abs(axes).round(6), axis=1)])
    return centre, axes * signs[:, None], size, flat


class _Waves:
    """A random sum of waves in the frame of a structure, drawn from a seed and nothing else."""

    def __init__(self, seed: int, centre: Array, axes: Array, size: float, flat: bool) -> None:
        random = np.random.default_rng(seed)
        vectors = random.standard_normal((3, WAVES, 3))
        number = LONGEST * (SHORTEST / LONGEST) ** random.random((3, WAVES))
        self.phase = 2 * np.pi * random.random((3, WAVES))
        # Bending answers with the inverse fourth power of the wave number: the field falls with its square.
        self.height = number**2 * random.standard_normal((3, WAVES))
        if flat:
            vectors[:, :, 2] = 0.0
        length = np.linalg.norm(vectors, axis=2)
        self.vectors = (vectors * (number / length)[:, :, None]) @ axes / size
        self.centre = centre

    def __call__(self, points: Array, which: int = 0) -> Array:
        angle = (points - self.centre) @ self.vectors[which].T + self.phase[which]
        values: Array = np.cos(angle) @ self.height[which]
        return values

