"""What the facet elements share: a triangle laid out flat, and strain from the stretch of its edges.

Edge c of a facet runs from corner c + 1 to corner c + 2, opposite corner c. With its flat vector y_c and the rows
(y_1^2, y_2^2, y_1 y_2) / |y|^2, three edge strains determine the strain (exx, eyy, gamma_xy) of the facet, and three
bars coupled by the plane-stress matrix are a constant-strain triangle in natural strains (Argyris, 1964).
"""

from __future__ import annotations

import warnings

import numpy as np
from numpy.typing import NDArray

from kirigami.errors import KirigamiWarning, ModelError
from kirigami.primitives.kernel import Array
from kirigami.primitives.node import place_in_words
from kirigami.primitives.parts import Numbering
from kirigami.words import counted

DEGENERATE = 1e-10  # least height of a facet over its longest edge
JUMP = 100.0  # ratio of the thickness of neighbours from which on it is worth a warning
STARTS, ENDS = (1, 2, 0), (2, 0, 1)  # corners that edge c leaves from and goes to


def edge_vectors(points: Array, conn: NDArray[np.int64]) -> Array:
    """Vectors (n, 3, dim) of the three edges of the facets whose corners are the first three columns of `conn`."""
    corners = points[conn[:, :3]]
    vectors: Array = corners[:, ENDS] - corners[:, STARTS]
    return vectors


def flat_edges(edges: Array) -> tuple[Array, Array]:
    """Edge vectors (n, 3, 2) of each triangle laid out in its plane, edge 2 along the first axis, and areas (n,)."""
    along = edges[:, 2]
    length = np.linalg.norm(along, axis=1)
    side = -edges[:, 1]  # from corner 0 to corner 2
    foot = np.einsum("na,na->n", side, along) / length
    height = np.linalg.norm(side - (foot / length)[:, None] * along, axis=1)
    zero = np.zeros_like(length)
    first = np.stack([length, zero], axis=1)
    second = np.stack([foot, height], axis=1)
    return np.stack([second - first, -second, first], axis=1), 0.5 * length * height


def plane_stress(nu: float) -> Array:
    """Plane-stress matrix (3, 3) over E, for strains (exx, eyy, gamma_xy)."""
    return np.array([[1, nu, 0], [nu, 1, 0], [0, 0, (1 - nu) / 2]]) / (1 - nu**2)


def section_matrices(thickness: Array, E: Array, nu: Array) -> Array:
    """Matrices (n, 6, 6) from (exx, eyy, gamma_xy, kxx, kyy, 2 kxy) to forces and moments per length of a plate."""
    values, which = np.unique(nu, return_inverse=True)
    elasticity = np.array([plane_stress(value) for value in values])[which] * E[:, None, None]
    section = np.zeros((len(E), 6, 6))
    section[:, :3, :3] = elasticity * thickness[:, None, None]
    section[:, 3:, 3:] = elasticity * (thickness**3 / 12)[:, None, None]
    return section


def check_areas(owner: str, corners: NDArray[np.int64], numbering: Numbering) -> None:
    """Refuse facets without area, whose corners (n, 3) lie on a line."""
    edges = edge_vectors(numbering.rest, corners)
    with np.errstate(divide="ignore", invalid="ignore"):  # corners may coincide
        _, area = flat_edges(edges)
    bad = np.flatnonzero(~(area > 0.5 * DEGENERATE * (edges**2).sum(axis=2).max(axis=1)))
    if bad.size:
        first = ", ".join(numbering.describe(k) for k in corners[bad[0]].tolist())
        raise ModelError(f"{counted(bad.size, owner)} without area, the first on {first}: remove or remesh them")


def warn_of_jumps(owner: str, corners: NDArray[np.int64], thickness: Array, rest: Array, stacklevel: int) -> None:
    """Say where the thickness (n,) of facets with `corners` (n, 3) jumps by more than a factor `JUMP` at an edge."""
    if not thickness.size or thickness.max() <= JUMP * thickness.min():
        return
    ends = np.sort(np.stack([corners, np.roll(corners, -1, axis=1)], axis=2).reshape(-1, 2), axis=1)
    edge = np.unique(ends, axis=0, return_inverse=True)[1].ravel()
    order = np.argsort(edge, kind="stable")
    same = edge[order[1:]] == edge[order[:-1]]
    one, other = order[:-1][same] // 3, order[1:][same] // 3
    if not len(one):
        return
    ratio = np.maximum(thickness[one], thickness[other]) / np.minimum(thickness[one], thickness[other])
    worst = int(np.argmax(ratio))
    if ratio[worst] > JUMP:
        first, second = one[worst], other[worst]
        place = place_in_words(rest[corners[first]].mean(axis=0))
        warnings.warn(
            f"{owner}: the thickness jumps at {place} from {thickness[first]:.4g} to "
            f"{thickness[second]:.4g}, by a factor of {ratio[worst]:.4g}: is that a unit of length? A part so much "
            "thicker is rigid beside the other, and digits are lost",
            KirigamiWarning,
            stacklevel=stacklevel,
        )


def membrane_stiffness(to_strain: Array, area: Array, thickness: Array, E: Array, nu: Array) -> Array:
    """Matrices (n, 3, 3) of the plane-stress energy in what `to_strain` turns into strain, such as edge strains."""
    values, which = np.unique(nu, return_inverse=True)
    elasticity = np.array([plane_stress(value) for value in values])[which] * (E * thickness * area)[:, None, None]
    return np.asarray(to_strain.transpose(0, 2, 1) @ elasticity @ to_strain)


def strain_from_edges(flat: Array) -> Array:
    """Matrices (n, 3, 3) that turn edge strains into (exx, eyy, gamma_xy)."""
    x, y = flat[..., 0], flat[..., 1]
    rows = np.stack([x * x, y * y, x * y], axis=-1) / (x * x + y * y)[..., None]
    return np.asarray(np.linalg.inv(rows))


class SurfaceStrain:
    """Green strain of flat facets, from their rest state, as the strains of their edges determine it.

    Parameters
    ----------
    rest : ndarray, shape (n, 3)
        Positions at rest [length].
    triangles : ndarray of int, shape (m, 3)
        Corners of the facets.
    """

    def __init__(self, rest: Array, triangles: NDArray[np.int64]) -> None:
        self.triangles = triangles
        self.edges = edge_vectors(rest, triangles)
        self.flat, self.area = flat_edges(self.edges)
        self.square = (self.flat**2).sum(axis=2)
        self._to_strain = strain_from_edges(self.flat)

    def at(self, u: Array, linear: bool = False) -> Array:
        """Strain (m, 3), (exx, eyy, gamma_xy) with the first axis along the edge from corner 0 to 1, at displacements
        `u` (n, 3); `linear` leaves the squares of these out."""
        change = edge_vectors(u, self.triangles)
        second = 0.0 if linear else 0.5 * change
        stretch = ((self.edges + second) * change).sum(axis=2) / self.square
        return np.asarray(np.einsum("nac,nc->na", self._to_strain, stretch))

    def add_rate(self, u: Array, by_strain: Array, total: Array) -> None:
        """Add to `total` (rows, 3) the derivatives by displacements of a number, from those by strain (m, 3)."""
        change = edge_vectors(u, self.triangles)
        by_stretch = np.einsum("nac,na->nc", self._to_strain, by_strain) / self.square
        pull = by_stretch[..., None] * (self.edges + change)
        np.add.at(total, self.triangles[:, ENDS], pull)
        np.add.at(total, self.triangles[:, STARTS], -pull)


def without_compression(force: Array, to_strain: Array) -> Array:
    """Edge forces (n, 3) of the facet tensions that remain when compressive principal stresses are dropped.

    `force` holds the derivatives of the membrane energy by the edge strains, `to_strain` is from
    :func:`strain_from_edges`. Clamping the tensor instead of each edge leaves harmless compression of single edges.
    """
    resultant = np.einsum("nca,nc->na", np.linalg.inv(to_strain), force)
    mean = 0.5 * (resultant[:, 0] + resultant[:, 1])
    half = 0.5 * (resultant[:, 0] - resultant[:, 1])
    shear = resultant[:, 2]
    radius = np.hypot(half, shear)
    high, low = np.maximum(mean + radius, 0.0), np.maximum(mean - radius, 0.0)
    turn = 0.5 * (high - low) / np.where(radius > 0, radius, 1.0)
    centre = 0.5 * (high + low)
    kept = np.stack([centre + turn * half, centre - turn * half, turn * shear], axis=1)
    return np.asarray(np.einsum("nac,na->nc", to_strain, kept))


def corner_mass(mass: Array, lumped: bool) -> Array:
    """Mass matrices (n, 3, 3) of triangles of given `mass` (n,) whose displacement is linear between the corners;
    lumped, a third at each."""
    shares = np.eye(3) / 3 if lumped else (1 + np.eye(3)) / 12
    return np.asarray(mass[:, None, None] * shares)
