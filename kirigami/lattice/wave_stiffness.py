"""The stiffness of a periodic cell against waves u_R = u_0 exp(i phase): small dense Hermitian matrices.

Only what stands on the border of a cell, and what it repeats, is turned by the phase. All else is condensed out, once
for a state of the cell and not for every wave: with border b and inside i,

    S = K_bb - K_bi K_ii^-1 K_ib,        S(phase) = T(phase)^H S T(phase),

T being 1 for what leads and exp(i phase . steps) for what repeats it. By Haynsworth's theorem the negative eigenvalues
of the whole K(phase) are those of K_ii and those of S(phase) (Linear Algebra and its Applications 1 (1968), 73-81).
"""

from __future__ import annotations

from typing import Any

import numpy as np

from kirigami.errors import AnalysisError, ModelError
from kirigami.lattice.cell_system import CellSystem
from kirigami.linalg import SingularMatrixError, factorize
from kirigami.primitives.kernel import Array

SAME = 1e-9  # phase, less whole turns, that is none


class WaveStiffness:
    """The condensed stiffness of a cell in one state.

    Parameters
    ----------
    known : CellSystem
        The cell, free to move as a whole.
    u : ndarray, shape (rows, 3)
        Displacements of all rows.
    lam : float
        Load factor.

    Attributes
    ----------
    unstable : int
        Negative eigenvalues inside the cell, with its border held still.
    """

    def __init__(self, known: CellSystem, u: Array, lam: float) -> None:
        from scipy.sparse import csc_matrix

        system = known.system
        assert system.grips is not None
        if len(system.grips.groups) > 1:
            raise ModelError("waves of a cell with a Grip or RigidLink are not known: hold its nodes by Fix instead")
        if not system.conservative:
            raise ModelError(
                "waves tell the stability of what has a potential; this cell has a load without one, such as a "
                "Pressure on a free rim"
            )
        unknown, follower, source, self.steps = known.without_strain()
        used = np.unique(unknown[unknown >= 0])
        border = np.unique(source)
        inside = np.setdiff1d(used, border)
        self.leader = np.searchsorted(border, source)
        self.border = len(border)
        order = np.full(system.free, -1)
        order[inside], order[border] = np.arange(len(inside)), len(inside) + np.arange(len(border))
        own = np.flatnonzero(unknown >= 0)
        columns = np.concatenate([order[unknown[own]], len(used) + np.arange(len(follower))])
        at = np.concatenate([own, follower])
        pick = csc_matrix((np.ones(len(at)), (at, columns)), shape=(unknown.size, len(used) + len(follower)))
        matrix = (pick.T @ system.stiffness(u, lam, constrained=False) @ pick).tocsc()
        cut = len(inside)
        edge = matrix[cut:, cut:].toarray()
        self._inside, self._coupling, self._factor = pick[:, :cut], matrix[:cut, cut:], None
        self._outside = pick[:, cut:]
        self.unstable = 0
        if cut:
            try:
                self._factor = factorize(matrix[:cut, :cut].tocsc())
            except SingularMatrixError:
                raise AnalysisError(
                    "the inside of the cell has a motion that costs nothing with its border held: it is at the brink "
                    "of an instability, or a mechanism"
                ) from None
            self.unstable = self._factor.negative
            coupling = self._coupling.toarray()
            moved = np.column_stack([self._factor.solve(column) for column in coupling.T])
            edge = edge - coupling.T @ moved
        self._shifts, self._parts = self._by_shift(0.5 * (edge + edge.T))
        self._alike = self._rigid(known)

    def _rigid(self, known: CellSystem) -> Array:
        """Motions (border, k) of the border, orthonormal, that every cell makes alike and nothing resists."""
        system = known.system
        fields = np.zeros((3, *system.rest.shape))
        for axis in range(3):
            fields[axis][known.positions, axis] = 1.0
        free = system.unknown.reshape(system.rest.shape) >= 0
        own = np.setdiff1d(np.arange(system.points), known.rows.repeats)
        moving = list(fields[free[own].all(axis=0)])
        if len(known.cell.lattice) == 1 and free[own].all():  # a strip turns about itself as well
            spin = known.cell.lattice[0] / np.linalg.norm(known.cell.lattice[0])
            turn = np.zeros_like(system.rest)
            turn[known.positions] = np.cross(spin, system.rest[known.positions])
            if system.edges is not None:
                system.edges.turn(system.rest, spin, turn)
            moving.append(turn)
        border = (self._outside.T @ np.array(moving).reshape(len(moving), -1).T)[: self.border]
        return np.asarray(np.linalg.qr(border)[0]) if moving else border

    def _by_shift(self, edge: Array) -> tuple[Array, Array]:
        """The border's stiffness, summed onto what leads (d, border, border) by the steps (d, m) between two places."""
        b, m = self.border, self.steps.shape[1]
        steps = np.concatenate([np.zeros((b, m), np.int64), self.steps])
        leader = np.concatenate([np.arange(b), self.leader])
        kinds, kind = np.unique(steps, axis=0, return_inverse=True)
        kind = kind.ravel()
        folded = np.zeros((len(kinds), b, len(edge)))
        for number in range(len(kinds)):
            np.add.at(folded[number], leader[kind == number], edge[kind == number])
        shifts, place = np.unique(
            (kinds[None] - kinds[:, None]).reshape(-1, m), axis=0, return_inverse=True
        )
        place = place.ravel().reshape(len(kinds), -1)
        parts = np.zeros((len(shifts), b, b))
        for one in range(len(kinds)):
            for other in range(len(kinds)):
                at = np.flatnonzero(kind == other)
                np.add.at(parts[place[one, other]].T, leader[at], folded[one][:, at].T)
        return shifts, parts

    def turned(self, phases: Array) -> Array:
        """S(phase) (border, border), complex; without phase, what moves the whole is given a stiffness."""
        angle = self._shifts @ phases
        found = np.tensordot(np.cos(angle), self._parts, 1) + 1j * np.tensordot(np.sin(angle), self._parts, 1)
        if np.abs(np.exp(1j * phases) - 1).max() < SAME and self._alike.size:
            found += float(np.abs(np.diag(found)).max()) * (self._alike @ self._alike.T)
        return np.asarray(0.5 * (found + found.conj().T))

    def lowest(self, rest: WaveStiffness, phases: Array) -> float:
        """Lowest eigenvalue of S(phase) over that of the cell at `rest`."""
        from scipy.linalg import LinAlgError, eigh

        try:
            return float(eigh(self.turned(phases), rest.turned(phases), subset_by_index=[0, 0], eigvals_only=True)[0])
        except LinAlgError:
            raise AnalysisError(
                f"waves with phases {phases.round(6).tolist()}: the cell at rest does not resist them, because they "
                "are too long, or a motion of the cell costs nothing"
            ) from None

    def shape(self, rest: WaveStiffness, phases: Array) -> Array:
        """Displacements (rows, 3), complex, of the wave that goes with it; largest component 1."""
        from scipy.linalg import eigh

        _, vectors = eigh(self.turned(phases), rest.turned(phases), subset_by_index=[0, 0])
        lead = vectors[:, 0]
        border: Any = np.concatenate([lead, np.exp(1j * (self.steps @ phases)) * lead[self.leader]])
        field = self._outside @ border
        if self._factor is not None:
            force = self._coupling @ border
            field = field - self._inside @ (self._factor.solve(force.real) + 1j * self._factor.solve(force.imag))
        return np.asarray((field / field[int(np.argmax(np.abs(field)))]).reshape(-1, 3))
