"""What the pattern of a mesh does to bars, hinges and flat facets, in closed form and one pass over its edges.

Under a uniform strain or curvature of the sheet, before any node gives way, the energy of the elements is

    bars    sum of EA L (n.E n)^2 / 2          hinges  sum of k (R : K)^2 / 2
    facets  sum of A (P K)' D (P K) / 2,       P K = sum over the folds of L / (A + A') (R : K) n n'

with the direction n of a bar or across a fold and the angle R : K of a fold (:mod:`kirigami.geometry.folds`). On
meshes with a pattern hardly any node gives way, so that this is what the mesh represents; on others it is close to what
``kirigami.stiffness.report`` finds. The numbers here are ratios to what the same elements represent where all
directions have an equal share: Poisson ratios of 1/3 in the plane and -1/3 in bending for bars and hinges, and the
material for facets.

Directions are those in the surface, from an axis that lies in the sheet as nearly as one can (of a cylinder its own),
so that a sheet that is rolled up or stands on edge has the bias of the flat one.

At free edges bars give way, since the facets there are not in balance under a uniform stress: ``free_compliance`` lets
all nodes of a flat sheet move in some steps of conjugate gradients, towards the strain under a uniform stress.
"""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from kirigami.geometry.folds import fold_curvature_rates
from kirigami.primitives.kernel import Array

if TYPE_CHECKING:
    from kirigami.geometry.mesh import TriMesh

Range = tuple[float, float]
DIRECTIONS = np.arange(60) * np.pi / 60
ISOTROPIC = 1 / 3  # Poisson's ratio of bars in all directions; hinges have minus that
STEPS = 10  # of conjugate gradients: what gives way at an edge reaches a few facets deep
FLAT = 1e-9  # largest height of a flat mesh over its size


class MeshBias:
    """Smallest and largest ratio over directions of what elements on a mesh represent to what they should.

    Parameters
    ----------
    mesh : TriMesh
        The mesh, of any shape.
    nu : float
        Poisson's ratio of the material, which only facets know.

    Examples
    --------
    >>> from kirigami.elements.mesh_bias import MeshBias
    >>> import kirigami as kg
    >>> squares = kg.TriMesh([(0, 0), (1, 0), (1, 1), (0, 1)], [(0, 1, 2), (0, 2, 3)])
    >>> low, high = MeshBias(squares).edges
    >>> round(low, 2), round(high, 2)
    (0.44, 1.33)
    """

    def __init__(self, mesh: TriMesh, nu: float = ISOTROPIC) -> None:
        self.mesh, self.nu = mesh, nu
        self.area = float(mesh.facet_areas.sum())
        self.shared = np.append(mesh.facet_areas, 0.0)[mesh.edge_facets].sum(axis=1)  # a missing facet has index -1

    @cached_property
    def _direction(self) -> Array:
        """Unit vectors (edges, 2) of the edges in the surface, against the axis that lies in it best."""
        mesh = self.mesh
        corners = mesh.nodes[mesh.triangles]
        normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])  # twice the areas
        axis = np.linalg.eigh(np.einsum("fa,fb->ab", normal, normal / np.linalg.norm(normal, axis=1)[:, None]))[1][:, 0]
        around = np.concatenate([normal, np.zeros((1, 3))])[mesh.edge_facets].sum(axis=1)
        size = np.linalg.norm(around, axis=1)
        across = np.cross(around, axis)
        # Facets folded onto each other, or level with the axis, have no direction: they count along the axis.
        clear = np.linalg.norm(across, axis=1) > 1e-6 * np.where(size > 0, size, 1.0)
        across[~clear] = np.cross(np.roll(axis, 1), axis)
        across /= np.linalg.norm(across, axis=1)[:, None]
        around /= np.where(size > 0, size, 1.0)[:, None]
        along = np.where(clear[:, None], np.cross(across, around), axis)
        edge = mesh.nodes[mesh.edges[:, 1]] - mesh.nodes[mesh.edges[:, 0]]
        plane = np.column_stack([(edge * along).sum(axis=1), (edge * across).sum(axis=1)])
        return np.asarray(plane / np.linalg.norm(plane, axis=1)[:, None])

    # ---- bars

    @cached_property
    def edges(self) -> Range:
        """Stiffness that the edges represent in a direction."""
        # The mean of cos^4 over all directions is 3/8, and every facet has three edges. Hinges bend across their
        # edges, so theirs are the same ratios, a right angle further.
        strain = stress_along(DIRECTIONS) * (1.0, 1.0, 2.0)  # of n.E n: the shear counts twice
        return _range(np.einsum("di,ij,dj->d", strain, self._bars, strain) / (9 / 8))

    @cached_property
    def _bars(self) -> Array:
        """Matrix (3, 3) from (exx, eyy, gamma) to stress over E, of bars."""
        c, s = self._direction.T
        rows = np.column_stack([c * c, s * s, c * s])
        return np.asarray(np.einsum("e,ei,ej->ij", self.shared / self.area, rows, rows))

    @property
    def stretching(self) -> Range:
        """Young's modulus of bars."""
        return _range(_compliance(self._bars, stress_along(DIRECTIONS)) ** -1)

    @property
    def shear(self) -> Range:
        """Shear modulus of bars, over E / (2 (1 + 1/3))."""
        return _range(8 / 3 / _compliance(self._bars, stress_across(DIRECTIONS)))

    @cached_property
    def free_stretching(self) -> Range | None:
        """Young's modulus of bars where all edges of the sheet are free; None where the mesh is not flat."""
        if np.ptp(self.mesh.nodes[:, 2]) > FLAT * self.mesh.size:
            return None
        stress = stress_along(DIRECTIONS)
        return _range(1 / np.einsum("di,ij,dj->d", stress, free_compliance(self.mesh), stress))

    # ---- folds

    @cached_property
    def _folds(self) -> tuple[NDArray[np.int64], Array, Array]:
        """The inner edges, rates (e, 3) of their angles with (kxx, kyy, 2 kxy), and (e, 3) n n' as (xx, yy, 2 xy)."""
        mesh = self.mesh
        inner = np.flatnonzero(mesh.edge_facets[:, 1] >= 0)
        start = mesh.nodes[mesh.edges[inner, 0]]
        edge = mesh.nodes[mesh.edges[inner, 1]] - start
        length = np.linalg.norm(edge, axis=1)
        along = edge / length[:, None]
        flat = np.zeros((len(inner), 4, 2))  # both facets laid out, the edge on the first axis
        flat[:, 2, 0] = length
        for corner, wing, side in ((0, 0, 1.0), (3, 1, -1.0)):
            arm = mesh.nodes[mesh.edge_wings[inner, wing]] - start
            foot = (arm * along).sum(axis=1)
            flat[:, corner] = np.column_stack([foot, side * np.linalg.norm(arm - foot[:, None] * along, axis=1)])
        c, s = self._direction[inner].T
        turn = np.stack([np.stack([c, -s], axis=-1), np.stack([s, c], axis=-1)], axis=-2)
        rates = fold_curvature_rates(np.einsum("eab,ecb->eca", turn, flat)) * np.array([1.0, 1.0, 0.5])
        return inner, rates, np.column_stack([s * s, c * c, -2 * c * s])

    @property
    def _hinges(self) -> Array:
        inner, rates, _ = self._folds
        covered = self.shared[inner].sum() / 3  # edges of the rim have no hinge, which is no matter of directions
        weight = self.mesh.edge_lengths[inner] ** 2 / self.shared[inner] / covered
        return np.asarray(np.einsum("e,ei,ej->ij", weight, rates, rates))

    @property
    def bending(self) -> Range:
        """Rigidity of hinges against cylinders."""
        return _rigidity(self._hinges, -ISOTROPIC, bent_along(DIRECTIONS))

    @property
    def twisting(self) -> Range:
        """Rigidity of hinges against twist, over that of hinges in all directions."""
        return _rigidity(self._hinges, -ISOTROPIC, twisted_along(DIRECTIONS))

    @cached_property
    def _facets(self) -> Array:
        mesh = self.mesh
        inner, rates, dyads = self._folds
        dyads = dyads * (mesh.edge_lengths[inner] / self.shared[inner])[:, None]
        facet = mesh.edge_facets[inner].T.ravel()
        whole = np.flatnonzero(np.bincount(facet, minlength=len(mesh.triangles)) == 3)
        if not len(whole):  # facets with free edges say nothing of others
            return _plate(self.nu)
        order = np.argsort(facet, kind="stable")
        fold = (order % len(inner))[np.isin(facet[order], whole)].reshape(-1, 3)
        found = np.einsum("fca,fci->fai", dyads[fold], rates[fold])
        area = mesh.facet_areas[whole]
        bent = _plate(self.nu) @ found
        return np.asarray(np.einsum("f,fai,faj->ij", area / area.sum(), found, bent))

    @property
    def facet_bending(self) -> Range:
        """Rigidity of flat facets against cylinders."""
        return _rigidity(self._facets, self.nu, bent_along(DIRECTIONS))

    @property
    def facet_twisting(self) -> Range:
        """Rigidity of flat facets against twist."""
        return _rigidity(self._facets, self.nu, twisted_along(DIRECTIONS))


def free_compliance(mesh: TriMesh) -> Array:
    """Matrix (3, 3) from stress over E to the mean strain (exx, eyy, gamma) of bars on a flat mesh with free edges."""
    from scipy.sparse import csr_matrix

    n, edges = len(mesh.nodes), mesh.edges
    x = mesh.nodes[:, :2] - mesh.nodes[:, :2].mean(axis=0)
    vector = x[edges[:, 1]] - x[edges[:, 0]]
    unit = vector / mesh.edge_lengths[:, None]
    shared = np.append(mesh.facet_areas, 0.0)[mesh.edge_facets].sum(axis=1)
    stiffness = shared / mesh.edge_lengths**2
    rows = np.repeat(np.arange(len(edges)), 4)
    columns = (2 * edges[:, :, None] + np.array([0, 1])).reshape(-1)
    lengthening = csr_matrix((np.stack([-unit, unit], axis=1).ravel(), (rows, columns)), shape=(len(edges), 2 * n))
    scaled = lengthening.multiply(stiffness[:, None]).tocsr()
    dyad = np.column_stack([unit[:, 0] ** 2, unit[:, 1] ** 2, unit[:, 0] * unit[:, 1]])
    area = float(mesh.facet_areas.sum())
    affine = np.linalg.inv(np.einsum("e,ei,ej->ij", shared / area, dyad, dyad))
    fields = np.zeros((n, 2, 3))  # displacements under the three strains exx, eyy and gamma
    fields[:, 0, 0], fields[:, 1, 1] = x[:, 0], x[:, 1]
    fields[:, :, 2] = 0.5 * x[:, ::-1]
    # Forces at the nodes of a uniform stress: half the edge opposite, turned outward, for each corner of a facet.
    load = np.zeros((n, 2, 3))
    corners = x[mesh.triangles]
    for k in range(3):
        opposite = corners[:, (k + 2) % 3] - corners[:, (k + 1) % 3]
        push = 0.5 * np.column_stack([-opposite[:, 1], opposite[:, 0]])
        for axis, stress, part in ((0, 0, 0), (1, 1, 1), (0, 2, 1), (1, 2, 0)):
            load[:, axis, stress] += np.bincount(mesh.triangles[:, k], push[:, part], n)
    force = load.reshape(2 * n, 3)
    u = fields.reshape(2 * n, 3) @ affine
    weight = 1 / np.maximum(np.asarray(lengthening.multiply(scaled).sum(axis=0)).ravel(), 1e-300)[:, None]
    residual = force - lengthening.T @ (scaled @ u)
    ahead = weight * residual
    search, norm = ahead, (residual * ahead).sum(axis=0)
    for _ in range(STEPS):
        push = lengthening.T @ (scaled @ search)
        work = (search * push).sum(axis=0)
        step = np.divide(norm, work, out=np.zeros(3), where=work > 1e-14 * area)
        u = u + step * search
        residual = residual - step * push
        ahead = weight * residual
        before, norm = norm, (residual * ahead).sum(axis=0)
        search = ahead + np.divide(norm, before, out=np.zeros(3), where=before > 0) * search
    return np.asarray(force.T @ u / area)


# Stress, curvature and their directions, each (d, 3): (xx, yy, xy) of stress, (xx, yy, 2 xy) of curvature.


def stress_along(angle: Array) -> Array:
    """A pull of one."""
    c, s = np.cos(angle), np.sin(angle)
    return np.column_stack([c * c, s * s, c * s])


def stress_across(angle: Array) -> Array:
    """A shear of one."""
    c, s = np.cos(angle), np.sin(angle)
    return np.column_stack([-2 * c * s, 2 * c * s, c * c - s * s])


def bent_along(angle: Array) -> Array:
    """A cylinder of curvature one."""
    return np.asarray(stress_along(angle) * (1.0, 1.0, 2.0))


def twisted_along(angle: Array) -> Array:
    """A twist of one."""
    return np.asarray(stress_across(angle) * (1.0, 1.0, 2.0))


def _plate(nu: float) -> Array:
    """Moments of a plate with D = 1 by (kxx, kyy, 2 kxy)."""
    return np.array([[1.0, nu, 0.0], [nu, 1.0, 0.0], [0.0, 0.0, 0.5 * (1 - nu)]])


def _compliance(matrix: Array, stress: Array) -> Array:
    return np.asarray(np.einsum("di,ij,dj->d", stress, np.linalg.pinv(matrix), stress))


def _rigidity(matrix: Array, nu: float, fields: Array) -> Range:
    return _range(
        np.einsum("di,ij,dj->d", fields, matrix, fields) / np.einsum("di,ij,dj->d", fields, _plate(nu), fields)
    )


def _range(values: Array) -> Range:
    return float(values.min()), float(values.max())
