"""Words for motions that nothing resists: rigid ones of a connected part, and floppy ones inside it."""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np

from kirigami.errors import MechanismError
from kirigami.linalg import Factor, SingularMatrixError, factorize
from kirigami.linalg.checked import terms
from kirigami.primitives.kernel import Array, full_hessian
from kirigami.primitives.node import AXES
from kirigami.primitives.rigid import rigid_motions
from kirigami.words import counted

if TYPE_CHECKING:
    from kirigami.system.assembly import Index
    from kirigami.system.system import System

FREE = 1e-14  # energy of a motion over that of its members one by one; rounding leaves about 1e-16
AT_REST = 1e-10  # forces that a rigid motion calls for over those of its terms, below which it costs nothing


def connected_parts(system: System) -> list[Index]:
    """Rows of each part that elements or ties hold together: its nodes, then those behind them."""
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components

    n = len(system.rest)
    first, second = [], []
    for kernel in system.kernels:
        for other in range(1, kernel.conn.shape[1]):
            first.append(kernel.conn[:, 0])
            second.append(kernel.conn[:, other])
    if system.grips is not None:
        follower, lead, _ = system.grips.links
        first.append(follower)
        second.append(lead)
    tied = np.flatnonzero((system.unknown >= 0) & (system.leader != np.arange(system.leader.size)))
    first.append(tied // system.dim)
    second.append(system.leader[tied] // system.dim)
    rows, columns = np.concatenate(first), np.concatenate(second)
    graph = coo_matrix((np.ones(len(rows)), (rows, columns)), shape=(n, n))
    count, label = connected_components(graph, directed=False)
    return [np.flatnonzero(label == part) for part in range(count)]


class _PartMotions:
    """Which rigid motions of one part its supports allow, about displacements `u` (n, dim)."""

    def __init__(self, system: System, part: Index, u: Array) -> None:
        fields, self.names = rigid_fields(system, part, u)
        motions = fields.reshape(len(fields), -1)
        # The motion that the constraints allow is the part of the field that T can carry; what is left over is held.
        full = np.zeros((len(motions), system.rest.size))
        self.at = (part[:, None] * system.dim + np.arange(system.dim)).ravel()
        full[:, self.at] = motions
        allowed = np.zeros_like(full)
        moving = system.unknown >= 0
        allowed[:, moving] = full[:, system.leader[moving]]
        if system.grips is not None:
            for field in allowed.reshape(len(motions), -1, system.dim):
                system.grips.follow(field, u)
        # Tall matrices are reduced to square ones first, which have the same singular values and cost nothing.
        tall, square = np.linalg.qr(motions.T)
        _, sizes, basis = np.linalg.svd(square.T)
        basis = basis @ tall.T
        rank = int(np.sum(sizes > 1e-9 * sizes[0])) if sizes[0] > 0 else 0
        # Coordinates in an orthonormal basis of the part's true motions (a straight chain has no spin of its own).
        self.basis = basis[:rank]
        self.coordinates = motions @ self.basis.T
        violation = np.linalg.pinv(self.coordinates) @ (full - allowed)[:, self.at]
        rows = [violation.T, _resistance(system, self.basis, self.at, u)]
        _, self.held, directions = np.linalg.svd(np.linalg.qr(np.concatenate(rows), mode="r"))
        self.free = directions[self.held <= 1e-9]

        unit = self.coordinates / np.maximum(np.linalg.norm(self.coordinates, axis=1, keepdims=True), 1e-300)
        self._pure = [
            row
            for row, coordinate in enumerate(self.coordinates)
            if np.linalg.norm(coordinate) > 1e-9 and np.linalg.norm(self.free @ unit[row]) > 1 - 1e-6
        ]
        self._motions = motions

    @property
    def fields(self) -> Array:
        """A basis of the motions that are free, (motions, displacements of the part): translations and rotations as
        they are where they are free by themselves, since a mixture of bending and stretching drowns the one."""
        pure = self.coordinates[self._pure] @ self.free.T  # in the coordinates of the free motions
        left = self.free
        if len(pure):
            _, sizes, rows = np.linalg.svd(pure)
            pure_rank = int(np.sum(sizes > 1e-9 * sizes[0]))
            left = rows[pure_rank:] @ self.free
            if pure_rank < len(pure):  # motions that are not independent, as all of those of one point
                return np.asarray(np.concatenate([rows[:pure_rank] @ self.free, left]) @ self.basis)
        return np.concatenate([self._motions[self._pure], left @ self.basis])

    def in_words(self) -> str:
        """The names of the motions that are free."""
        said = [self.names[row] for row in self._pure]
        if len(said) < len(self.free):
            said.append("a rotation about an axis through its supports" if not said else "combinations of these")
        return ", ".join(said)


def free_rigid_motions(system: System) -> tuple[str, list[int], str] | None:
    """The first part with free rigid motions: the motion, its nodes, and a message in words; None if all are held."""
    parts = connected_parts(system)
    for part in parts:
        found = _PartMotions(system, part, np.zeros_like(system.rest))
        if not len(found.free):
            continue
        nodes = part[part < system.points]
        motion = found.in_words()
        where = "the structure" if len(parts) == 1 else (
            f"a part of {counted(len(nodes), 'node')} (one of {len(parts)}) around "
            f"({', '.join(f'{c:.6g}' for c in system.rest[nodes].mean(axis=0))})"
        )
        support = "it has no support" if not found.held.any() else "its supports do not hold it"
        message = (
            f"{where} can move as a rigid body: {motion}; {support}. "
            "Add Fix or Prescribe objects that stop the motion named."
        )
        if system.model.mesh is not None and found.held.any() and "about an axis" in motion:
            message += " A sheet held along a straight line turns about it unless Fix(..., clamp=True) holds its slope."
        return motion, nodes.tolist(), message
    return None


def rigid_fields(system: System, part: Index, u: Array) -> tuple[Array, list[str]]:
    """Rigid motions of a part about displacements `u`, on all its rows (motions, rows, dim) of size about 1, and their
    names."""
    nodes = part[part < system.points]
    here = system.rest + u
    points = here[nodes]
    fields, names = rigid_motions(points)
    if len(nodes) == len(part):
        return fields, names
    rate = 1.0 / (float(np.abs(points - points.mean(axis=0)).max(initial=0.0)) or 1.0)
    full = np.zeros((len(fields), *system.rest.shape))
    full[:, nodes] = fields
    for number, field in enumerate(full):
        spin = np.zeros(3)
        if number >= system.dim:
            spin[number - system.dim if system.dim == 3 else 2] = rate
            if system.edges is not None:
                system.edges.turn(here, spin, field)
        if system.grips is not None:
            system.grips.lead(field, spin, u)
    return full[:, part], names


def rigid_unknowns(system: System, u: Array, matrix: Any) -> Array:
    """Rigid motions (free, motions) about displacements `u` (n, dim) that cost nothing, part by part.

    What the supports allow still costs something where loads, contacts or the stress of a state out of balance turn
    along or not: the stiffness `matrix` of the state has the last word.
    """
    found = []
    for part in connected_parts(system):
        motions = _PartMotions(system, part, u)
        if len(motions.free):
            full = np.zeros((len(motions.free), system.rest.size))
            full[:, motions.at] = motions.fields
            found.append(full[:, system.heads])
    if not found:
        return np.zeros((system.free, 0))
    fields = np.concatenate(found).T
    size = np.linalg.norm(terms(matrix, fields), axis=0)
    fields = fields / np.where(size == 0, 1.0, size)
    forces = matrix @ fields
    still = np.linalg.norm(forces, axis=0) <= AT_REST
    # Among those that cost something by themselves there may be mixtures that do not.
    _, cost, directions = np.linalg.svd(np.linalg.qr(forces[:, ~still], mode="r"))
    return np.hstack([fields[:, still], fields[:, ~still] @ directions[cost <= AT_REST].T])


def costs_energy(system: System, vector: Array) -> bool:
    """Whether a motion (free,) off the rest state costs energy, however little, in proportion to its square.

    Strains and angles tell it where the stiffness, which adds up what stretching and bending cost, has lost the smaller
    one in rounding. The energy of a mechanism is of higher order, or the rounding of angles.
    """
    shape = system.motion(vector)
    turn = system.largest_rotation(shape)
    if turn == 0:
        return False
    costs = []
    for size in (1e-7, 1e-8, 1e-9, 1e-10):
        small = size / turn * shape
        costs.append(sum(sum(system.energies(sign * small).values()) for sign in (1, -1)) / size**2)
    return any(before > 0 and abs(after / before - 1) < 0.1 for before, after in pairwise(costs))


def _resistance(system: System, motions: Array, at: Index, u: Array) -> Array:
    """Rows whose squares sum to the energy that anchored kernels put against `motions` (m, dofs `at` of the part)."""
    full = np.zeros((len(motions), system.rest.size))
    full[:, at] = motions
    fields = full.reshape(len(motions), -1, system.dim)
    here = system.configuration(u)
    energy = np.zeros((len(motions), len(motions)))
    for kernel in system.kernels:
        if kernel.anchored:
            hessian = full_hessian(kernel, kernel.evaluate(here, 0.0, 2))
            members = fields[:, kernel.conn]
            energy += np.einsum("pnka,nklab,qnlb->pq", members, hessian, members)
    values, vectors = np.linalg.eigh(energy / system.stiffness_scale)
    rows: Array = np.sqrt(np.maximum(values, 0.0))[:, None] * vectors.T
    return rows


def check_floppy(system: System, matrix: Any, factor: Factor | None) -> None:
    """Raise a MechanismError, in words, if some motion of the unknowns costs no energy.

    `factor` is the factorised `matrix`, or None if it could not be factorised.
    """
    if matrix.shape[0] == 0:
        return
    if factor is None or not _factor_is_sound(matrix, factor):
        from scipy.sparse import identity

        shift = 1e-10 * float(np.abs(matrix.diagonal()).mean() or system.stiffness_scale)
        try:
            factor = factorize((matrix + shift * identity(matrix.shape[0], format="csc")).tocsc())
        except SingularMatrixError:
            raise MechanismError("the stiffness matrix is singular: some motion costs no energy") from None
    vector = np.random.default_rng(0).normal(size=matrix.shape[0])
    for _ in range(3):
        with np.errstate(all="ignore"):
            vector = factor.solve(vector)
        largest = np.abs(vector).max(initial=0.0)
        if not np.isfinite(largest) or largest == 0:
            return
        vector /= largest
    one_by_one = float(np.abs(vector) @ terms(matrix, vector))
    # The second bound serves motions of displacements that have no stiffness at all, so that both sides vanish.
    none_at_all = 1e-6 * float(vector @ vector) * system.stiffness_scale
    if abs(float(vector @ (matrix @ vector))) > FREE * max(one_by_one, none_at_all):
        return
    shape = system.motion(vector)
    motion, nodes = describe_motion(system, shape)
    full = np.zeros((len(shape), 3))
    full[:, : system.dim] = shape
    raise MechanismError(
        f"the structure has a floppy motion that costs no energy: {motion}. "
        "Fix these nodes in that direction, or add members that resist it.",
        motion=motion,
        nodes=nodes,
        shape=full,
    )


def _factor_is_sound(matrix: Any, factor: Factor) -> bool:
    probe = np.ones(matrix.shape[0])
    try:
        with np.errstate(all="ignore"):
            solution = factor.solve(probe)
    except SingularMatrixError:
        return False
    return bool(np.isfinite(solution).all())


def describe_motion(system: System, shape: Array) -> tuple[str, list[int]]:
    """A motion (n, dim) in words: which nodes move most, and along which axis."""
    size = np.linalg.norm(shape[: system.points], axis=1)
    moving = np.flatnonzero(size > 0.1 * size.max())
    order = moving[np.argsort(-size[moving], kind="stable")]
    share = np.sqrt((shape[moving] ** 2).sum(axis=0))
    share /= np.linalg.norm(share)
    axis = int(np.argmax(share))
    direction = f"along {AXES[axis]}" if share[axis] > 0.99 else "in the directions " + ", ".join(
        AXES[a] for a in range(system.dim) if share[a] > 0.1
    )
    shown = ", ".join(f"{node} {system.model.nodes[node]!r}" for node in order[:4].tolist())
    more = f" and {len(order) - 4} more" if len(order) > 4 else ""
    moves = "node {} moves" if len(order) == 1 else "nodes {} move"
    return f"{moves.format(shown + more)} {direction}", order.tolist()
