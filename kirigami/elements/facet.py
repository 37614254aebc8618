"""The facet: a triangle of sheet that stretches as one and bends against its neighbours, without further unknowns.

* Membrane: the Green strains e of the three edges determine the strain of the facet, energy
  (A t / 2) e' N^-T C N^-1 e; see :mod:`kirigami.elements.triangle`. Uniform strain is exact for any Poisson ratio on
  any mesh: three bars coupled by a 3 x 3 matrix.
* Bending: the fold angles theta of the three edges, each shared with the neighbour in the ratio of the areas, give
  the curvature of the facet, (kxx, kyy, 2 kxy) = sum over edges of L / (A + A') theta (n_x^2, n_y^2, 2 n_x n_y) with
  n across the edge; energy (A / 2) kappa' D_b kappa. Cylinders along mesh lines are exact, spheres and saddles cost
  what they should, which single hinges get wrong by their Poisson ratio of -1/3.
* Where thickness or material change at an edge, both facets bend by the same moment: A' counts by D / D' of the two.
* A free or cut edge has no fold angle. It carries no moment either, so its angle is eliminated by that condition.

On irregular meshes the mean curvature is right within some percent, not in the limit: that is what
:class:`kirigami.ShellFacet` is for.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from kirigami.elements.bend_hinge import BendHingeKernel
from kirigami.elements.surface import SurfaceKernel
from kirigami.elements.triangle import (
    ENDS,
    STARTS,
    check_areas,
    corner_mass,
    edge_vectors,
    flat_edges,
    membrane_stiffness,
    section_matrices,
    strain_from_edges,
    warn_of_jumps,
    without_compression,
)
from kirigami.errors import ModelError
from kirigami.geometry.topology import paired_half_edges
from kirigami.primitives.checks import require_instance, require_items, require_positive
from kirigami.primitives.kernel import EXACT, Array, Contribution, Kernel, Tangent, displacement_of, full_hessian
from kirigami.primitives.material import Material
from kirigami.primitives.node import Node, require_nodes
from kirigami.primitives.parts import ModelObject, Numbering
from kirigami.primitives.sensitivity import by_rest_differences


@dataclass(frozen=True, slots=True, eq=False)
class Facet(ModelObject):
    """Triangle of an elastic sheet that stretches, and bends against its neighbours.

    Parameters
    ----------
    i, j, k : Node
        Corners, counter-clockwise seen from the side towards which fold angles are positive.
    thickness : float
        Sheet thickness [length].
    material : Material
        Elastic constants.
    neighbours : tuple of three Nodes or None
        Far corner of the facet across the edge opposite i, opposite j and opposite k; None where the edge is free.

    Raises
    ------
    ModelError
        A repeated corner, a neighbour that is a corner, a thickness that is not positive.

    Examples
    --------
    >>> import kirigami as kg
    >>> m = kg.Model()
    >>> a, b, c, d = m.add(kg.Node(0, 0), kg.Node(1, 0), kg.Node(1, 1), kg.Node(0, 1))
    >>> steel = kg.Material(E=2e11, nu=0.3)
    >>> facets = m.add(
    ...     kg.Facet(a, b, c, 0.001, steel, neighbours=(None, d, None)),
    ...     kg.Facet(a, c, d, 0.001, steel, neighbours=(None, None, b)),
    ... )
    >>> print(m)
    Model in 3D: 4 nodes, 2 Facet
    """

    kind: ClassVar[str] = "element"
    i: Node
    j: Node
    k: Node
    thickness: float
    material: Material
    neighbours: tuple[Node | None, Node | None, Node | None] = (None, None, None)

    def __post_init__(self) -> None:
        require_nodes("Facet", i=self.i, j=self.j, k=self.k)
        require_instance(self.material, Material, "material", "Facet")
        corners = (self.i, self.j, self.k)
        neighbours = tuple(require_items(self.neighbours, "neighbours", "Facet"))
        object.__setattr__(self, "neighbours", neighbours)
        require_nodes("Facet", **{f"neighbour {c}": node for c, node in enumerate(neighbours) if node is not None})
        if len({id(corner) for corner in corners}) < 3:
            raise ModelError(f"Facet on {corners}: the three corners must differ")
        if len(neighbours) != 3 or any(node is corner for node in neighbours for corner in corners):
            raise ModelError(f"Facet on {corners}: neighbours must be three nodes or None, none of them a corner")
        object.__setattr__(self, "thickness", require_positive(self.thickness, "thickness", "Facet"))

    @property
    def nodes(self) -> tuple[Node, ...]:
        """Corners, then the neighbours there are."""
        return (self.i, self.j, self.k) + tuple(node for node in self.neighbours if node is not None)

    @classmethod
    def lower(cls, objects: Sequence[Facet], numbering: Numbering) -> list[Kernel]:
        corners = numbering.index(node for facet in objects for node in facet.nodes[:3]).reshape(-1, 3)
        check_areas("Facet", corners, numbering)
        if numbering.mesh is None:  # else it was said of the mesh
            warn_of_jumps("Facet", corners, np.array([facet.thickness for facet in objects]), numbering.rest, 2)
        groups: dict[int, list[int]] = {}
        for position, facet in enumerate(objects):
            groups.setdefault(len(facet.nodes), []).append(position)
        constants = np.array([(facet.thickness, facet.material.E, facet.material.nu) for facet in objects]).T
        beyond = softness_beyond(corners, rigidity_of(*constants))
        kernels: list[Kernel] = []
        for _, positions in sorted(groups.items()):
            chosen = [objects[position] for position in positions]
            bends = np.array([[node is not None for node in facet.neighbours] for facet in chosen])
            thickness = np.array([facet.thickness for facet in chosen])
            E = np.array([facet.material.E for facet in chosen])
            nu = np.array([facet.material.nu for facet in chosen])
            per_area = [facet.material.mass_per_area(facet.thickness) for facet in chosen]
            density = np.array([np.nan if value is None else value for value in per_area])
            conn, members = numbering.connectivity(chosen), np.array(positions)
            share = None if beyond is None else beyond[positions]
            kernels.append(FacetKernel(numbering.rest, conn, bends, thickness, E, nu, members, share, density))
        return kernels


def softness_beyond(corners: NDArray[np.int64], rigidity: Array) -> Array | None:
    """How much softer (n, 3) than a facet its neighbour across each edge is, None where all are alike.

    Both bend by the same moment, so that the softer one takes more of the fold between them.
    """
    if np.ptp(rigidity) <= 1e-12 * rigidity.max():
        return None
    first, second = paired_half_edges(corners)
    both = second >= 0
    beyond = np.ones(3 * len(corners))  # by half-edges, from each corner to the next
    one, two = first[both] // 3, second[both] // 3
    beyond[first[both]], beyond[second[both]] = rigidity[one] / rigidity[two], rigidity[two] / rigidity[one]
    return np.asarray(beyond.reshape(-1, 3)[:, [1, 2, 0]])  # by the opposite corner


def rigidity_of(thickness: Array, E: Array, nu: Array) -> Array:
    """Bending stiffness D of plates."""
    return np.asarray(E * thickness**3 / (12 * (1 - nu**2)))


class FacetKernel(SurfaceKernel):
    """All facets with one number of neighbours; see the module's text for the formulas.

    Local nodes: three corners, then the neighbours across those edges that `bends` (n, 3) marks, in their order.
    """

    name = "facets"
    bends_by_folds = True
    approximates = True

    def __init__(
        self,
        rest: Array,
        conn: NDArray[np.int64],
        bends: NDArray[np.bool_],
        thickness: Array,
        E: Array,
        nu: Array,
        members: NDArray[np.int64] | None = None,
        beyond: Array | None = None,
        density: Array | None = None,
        natural: Array | None = None,
    ) -> None:
        self.rest, self.members, self.softness = rest, members, beyond
        self._natural = natural  # strains of the edges and angles of the folds (2, n, 6)
        self._scale()
        self.density = density  # mass per area (n,), nan where unknown
        self.thickness, self.E, self.nu = thickness, E, nu
        dim = rest.shape[1]
        self._given, self.bends = conn, bends
        self.conn = conn if dim == 3 else conn[:, :3]
        self._rest_edges = edge_vectors(rest, conn)
        flat, self.area = flat_edges(self._rest_edges)
        self._square = (flat**2).sum(axis=2)
        self._to_strain = strain_from_edges(flat)
        self._membrane = membrane_stiffness(self._to_strain, self.area, thickness, E, nu)
        self.section = section_matrices(thickness, E, nu)
        self.hinge_facet, self.hinge_edge = np.nonzero(bends & (dim == 3))
        self._hinges: BendHingeKernel | None = None
        if self.hinge_facet.size:
            f, c = self.hinge_facet, self.hinge_edge
            starts, ends = np.array(STARTS)[c], np.array(ENDS)[c]
            wing = 2 + np.cumsum(bends, axis=1)[f, c]
            self._places = np.stack([c, starts, ends, wing], axis=1)  # local nodes of each hinge
            lines = conn[f[:, None], self._places]
            ones = np.ones(len(f))
            self._hinges = BendHingeKernel(rest, lines, ones, np.full(len(f), np.nan))
            neighbour = rest[lines[:, [1, 2, 3]]]
            across = np.zeros((len(conn), 3))
            across[f, c] = 0.5 * np.linalg.norm(
                np.cross(neighbour[:, 1] - neighbour[:, 0], neighbour[:, 2] - neighbour[:, 0]), axis=1
            )
            if beyond is not None:
                across *= beyond
            self._to_curvature = curvature_from_folds(flat, self.area, across)
            self._bending = fold_stiffness(self._to_curvature, self.area, thickness, E, nu)
            for edge in range(3):  # no moment at a free edge
                self._bending = without_fold(self._bending, edge, ~bends[:, edge])[0]

    def arrays(self) -> dict[str, Any]:
        names = ("bends", "thickness", "E", "nu", "members", "density")
        own = {"conn": self._given, "beyond": self.softness} | {name: getattr(self, name) for name in names}
        return self.with_natural(own)

    def on_rest(self, rest: Array) -> FacetKernel:
        """Isotropic, so that nothing lies along an axis."""
        return type(self)(rest, **self.arrays())

    def actuate_facets(self, members: NDArray[np.int64], values: Array, folds: Array, constant: bool) -> None:
        """Edges take the strain, and folds their angles."""
        edges = np.linalg.solve(self._to_strain[members], values[:, :3, None])[..., 0]
        self.actuate(members, np.concatenate([edges, folds * self.bends[members]], axis=1), constant)

    def natural_deformation(self, lam: float) -> Array | None:
        """Strain and curvature (n, 6), as :meth:`deformation` has them, at which facets bear nothing."""
        natural = self.natural(lam)
        if natural is None:
            return None
        found = np.zeros((len(self.conn), 6))
        found[:, :3] = np.einsum("nac,nc->na", self._to_strain, natural[:, :3])
        if self._hinges is not None:
            found[:, 3:] = self._curvature(natural[:, 3:])
        return found

    def mass(self, lumped: bool = False) -> Array | None:
        """Mass matrices (n, k, k), of the corners alone; None where a density is unknown."""
        if self.density is None or not np.isfinite(self.density).all():
            return None
        full = np.zeros((*self.conn.shape, self.conn.shape[1]))
        full[:, :3, :3] = corner_mass(self.density * self.area, lumped)
        return full

    @property
    def history(self) -> Array | None:
        return None if self._hinges is None else self._hinges.history

    @history.setter
    def history(self, value: Array | None) -> None:
        if self._hinges is not None:
            self._hinges.history = value

    def commit(self, x: Array) -> None:
        if self._hinges is not None:
            self._hinges.commit(x)

    def _stretch(self, x: Array) -> tuple[Array, Array]:
        """Edge vectors (n, 3, dim) and their Green strains (n, 3)."""
        change = edge_vectors(displacement_of(x, self.rest), self._given)
        strain = ((self._rest_edges + 0.5 * change) * change).sum(axis=2) / self._square
        return self._rest_edges + change, strain

    def deformation(self, x: Array) -> Array:
        """Strain and curvature of each facet (n, 6): (exx, eyy, gamma_xy, kxx, kyy, 2 kxy), the first axis along the
        edge from corner i to j; the curvature is the one whose moments the fold angles meet."""
        found = np.zeros((len(self.conn), 6))
        found[:, :3] = np.einsum("nac,nc->na", self._to_strain, self._stretch(x)[1])
        if self._hinges is not None:
            found[:, 3:] = self._curvature(self.fold_angles(x))
        return found

    def _curvature(self, angles: Array) -> Array:
        """Curvature (n, 3) whose moments M the fold angles (n, 3) meet: m = A B' M at the folds, curvature = B angles
        where none of them is free."""
        moment = np.einsum("ncd,nd->nc", self._bending, angles) / self.area[:, None]
        plate = np.linalg.solve(self._to_curvature.transpose(0, 2, 1), moment[..., None])
        return np.asarray(np.linalg.solve(self.section[:, 3:, 3:], plate)[..., 0])

    def force(self, deformation: Array) -> Array:
        """Forces and moments per length (n, 6): (Nxx, Nyy, Nxy, Mxx, Myy, Mxy) of a deformation (n, 6)."""
        return np.asarray(np.einsum("nab,nb->na", self.section, deformation))

    def force_at(self, deformation: Array, lam: float) -> Array:
        natural = self.natural_deformation(lam)
        return self.force(deformation if natural is None else deformation - natural)

    def fold_angles(self, x: Array) -> Array:
        """Change (n, 3) of the fold angle of each edge against rest [rad]; 0 where the edge is free."""
        angles = np.zeros((len(self.conn), 3))
        if self._hinges is not None:
            angles[self.hinge_facet, self.hinge_edge] = self._hinges.deformation(x) - self._hinges.rest_angle
        return angles

    def _felt(self, x: Array, lam: float) -> tuple[Array, Array]:
        """Edge vectors (n, 3, dim) and the strains (n, 3) of edges that facets bear something at."""
        edges, strain = self._stretch(x)
        natural = self.natural(lam)
        return edges, strain if natural is None else strain - natural[:, :3]

    def _force_ahead(self, x: Array, change: Array, lam: float) -> Array:
        """Derivatives of the membrane energy by the edge strains (n, 3) after a linear step `change` off `x`."""
        edges, strain = self._felt(x, lam)
        rate = np.einsum("nca,nca->nc", edges, edge_vectors(change, self._given)) / self._square
        return np.asarray(np.einsum("ncd,nd->nc", self._membrane, strain + rate))

    def _turned(self, x: Array, lam: float) -> Array:
        """Fold angles (n, 3) that facets bear something at."""
        natural = self.natural(lam)
        return self.fold_angles(x) if natural is None else self.fold_angles(x) - natural[:, 3:]

    def by_rest(self, x: Array, lam: float, fields: Array, energies: Array) -> Array | None:
        """By differences, one for each coordinate of a facet: those of all facets at once."""
        return None if self._natural is not None else by_rest_differences(self, x, lam, fields, energies)

    def fold_moments(self, x: Array, lam: float) -> Array:
        """Moment (n, 3) of each facet on its folds, the derivatives of its energy by the fold angles."""
        if self._hinges is None:
            return np.zeros((len(self.conn), 3))
        return np.asarray(np.einsum("ncd,nd->nc", self._bending, self._turned(x, lam)))

    def evaluate(self, x: Array, lam: float = 1.0, need: int = 2, tangent: Tangent = EXACT) -> Contribution:
        edges, strain = self._felt(x, lam)
        n, dim = len(edges), edges.shape[2]
        nodes = self.conn.shape[1]
        force = np.einsum("ncd,nd->nc", self._membrane, strain)
        energy = 0.5 * (force * strain).sum(axis=1)
        moment = np.zeros((n, 3))
        if self._hinges is not None:
            angles = self._turned(x, lam)
            moment = np.einsum("ncd,nd->nc", self._bending, angles)
            energy += 0.5 * (moment * angles).sum(axis=1)
        if need == 0:
            return Contribution(energy)
        # First derivatives of the half squared lengths and, in three dimensions, of the fold angles.
        chain = np.zeros((n, 3 if self._hinges is None else 6, nodes, dim))
        for c, (a, b) in enumerate(zip(STARTS, ENDS)):
            chain[:, c, b], chain[:, c, a] = edges[:, c], -edges[:, c]
        if self._hinges is not None:
            vectors = self._hinges.vectors(x)
            wings, turn = self._hinges.first_derivatives(*vectors)
            f, line = self.hinge_facet, self.hinge_edge
            chain[f[:, None], 3 + line[:, None], self._places] = turn.transpose(2, 1, 0)
        pull = force / self._square
        generalized = np.concatenate([pull, moment], axis=1)[:, : chain.shape[1]]
        gradient = np.einsum("nz,nzka->nka", generalized, chain)
        if need == 1:
            return Contribution(energy, gradient)
        if tangent.ahead is not None:
            force = self._force_ahead(*tangent.ahead, lam)
        if tangent.convexity:
            force = force + tangent.convexity * (without_compression(force, self._to_strain) - force)
        pull = force / self._square
        inner = np.zeros((n, chain.shape[1], chain.shape[1]))
        inner[:, :3, :3] = self._membrane / (self._square[:, :, None] * self._square[:, None])
        if self._hinges is not None:
            inner[:, 3:, 3:] = self._bending
        rows = chain.reshape(n, -1, nodes * dim)
        hessian = (rows.transpose(0, 2, 1) @ inner @ rows).reshape(n, nodes, dim, nodes, dim)
        hessian = hessian.transpose(0, 1, 3, 2, 4).copy()
        eye = np.eye(dim)
        for edge, (a, b) in enumerate(zip(STARTS, ENDS)):
            block = pull[:, edge, None, None] * eye
            for p, q, sign in ((a, a, 1), (b, b, 1), (a, b, -1), (b, a, -1)):
                hessian[:, p, q] += sign * block
        if self._hinges is not None:
            curved = np.empty((3, 3, len(self._hinges.pairs), f.size))
            bending = (1 - tangent.convexity) * moment[f, line]
            self._hinges.second_derivatives(curved, np.zeros(f.size), bending, vectors[0], wings, turn)
            found = Contribution(bending, turn.transpose(2, 1, 0), curved.transpose(3, 2, 0, 1))
            blocks = full_hessian(self._hinges, found)
            for edge in range(3):  # a facet has one hinge on an edge, so no entry is hit twice
                on = line == edge
                places = self._places[on]
                hessian[f[on, None, None], places[:, :, None], places[:, None]] += blocks[on]
        return Contribution(energy, gradient, hessian)


def curvature_from_folds(flat: Array, area: Array, across: Array) -> Array:
    """Matrix (n, 3, 3) from the fold angles at the three edges, with the areas `across` (n, 3) beyond them, to the
    curvature (kxx, kyy, 2 kxy)."""
    length = np.linalg.norm(flat, axis=2)
    normal = np.stack([flat[..., 1], -flat[..., 0]], axis=-1) / length[..., None]
    columns = np.stack([normal[..., 0] ** 2, normal[..., 1] ** 2, 2 * normal[..., 0] * normal[..., 1]], axis=1)
    return np.asarray(columns * (length / (area[:, None] + across))[:, None])


def fold_stiffness(to_curvature: Array, area: Array, thickness: Array, E: Array, nu: Array) -> Array:
    """Energy matrix (n, 3, 3) of the fold angles: plane stress over the thickness, t^3 / 12 in the place of t."""
    return membrane_stiffness(to_curvature, area, thickness**3 / 12, E, nu)


def without_fold(matrix: Array, c: int, which: NDArray[np.bool_]) -> tuple[Array, Array, Array]:
    """Energy matrices (n, 3, 3) where edge c of `which` facets carries no moment, so that its angle is eliminated.

    Also what was taken away, as pivots (n,) and rows (n, 3): pivot / 2 times the square of the rows' product with the
    angles. Both are zero where the edge carries none anyway.
    """
    pivot = matrix[:, c, c]
    there = which & (pivot > 1e-12 * np.abs(matrix).max(axis=(1, 2), initial=0.0))
    row = np.where(there[:, None], matrix[:, c] / np.where(there, pivot, 1.0)[:, None], 0.0)
    left = matrix - np.where(there, pivot, 0.0)[:, None, None] * row[:, :, None] * row[:, None]
    left[which, c] = left[which, :, c] = 0.0
    return left, np.where(there, pivot, 0.0), row
