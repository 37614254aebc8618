"""Pin-jointed frameworks: which motions stretch no bar, and which bar forces balance without load.

The compatibility matrix C takes displacements to bar elongations, e = C u; its transpose takes bar forces to nodal
forces. Its null space holds the zero modes, that of C' the states of self-stress, and

    unknowns - bars = zero modes - states of self-stress                (Maxwell 1864, Calladine 1978).

Angle springs count for nothing here: they are what makes a mechanism cost a little.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kirigami.errors import AnalysisError, ModelError
from kirigami.primitives.checks import require_array, require_instance, require_positive, require_whole
from kirigami.primitives.kernel import Array
from kirigami.words import counted

if TYPE_CHECKING:
    from kirigami.lattice.tilings.tiling import Tiling
    from kirigami.model.model import Model

RANK = 1e-9  # singular values below this share of the largest are zero


@dataclass(frozen=True, eq=False, repr=False)
class Framework:
    """Points joined by bars, finite or periodic.

    Attributes
    ----------
    points : ndarray, shape (n, dim)
        Positions [length].
    bars : ndarray of int, shape (b, 2)
        End points of each bar.
    unknown : ndarray of int, shape (n, dim)
        Number of the unknown that each displacement follows, -1 where it is held.
    lattice : ndarray, shape (m, dim)
        Lattice vectors, one a row; none for a finite framework.
    shifts : ndarray of int, shape (b, m)
        Lattice vectors by which the second end of each bar is moved.

    Examples
    --------
    >>> import kirigami as kg
    >>> m = kg.Model(dim=2)
    >>> a, b, c, d = m.add(kg.Node(0, 0), kg.Node(1, 0), kg.Node(1, 1), kg.Node(0, 1))
    >>> bars = m.add(*(kg.Bar(p, q, EA=1.0) for p, q in ((a, b), (b, c), (c, d), (d, a))))
    >>> print(kg.Framework.from_model(m).rigidity())
    8 unknowns, 4 bars: 4 zero modes (3 rigid, 1 internal), 0 states of self-stress
    """

    points: Array
    bars: NDArray[np.int64]
    unknown: NDArray[np.int64]
    lattice: Array
    shifts: NDArray[np.int64]

    @classmethod
    def from_model(cls, model: Model) -> Framework:
        """The bars of a model, with its supports and ties; everything else in the model is left out.

        Raises
        ------
        ModelError
            The model has no bars, or cannot be lowered.
        """
        from kirigami.elements.bar import Bar
        from kirigami.model.model import Model
        from kirigami.system.system import System

        require_instance(model, Model, "model", "Framework.from_model")
        bars = [element for element in model.elements if isinstance(element, Bar)]
        if not bars:
            raise ModelError("Framework.from_model: the model has no bars")
        system = System(model)
        ends = model.index(node for bar in bars for node in bar.nodes).reshape(-1, 2)
        return cls(
            system.rest, ends, system.unknown.reshape(system.rest.shape), np.zeros((0, system.dim)),
            np.zeros((len(bars), 0), dtype=int),
        )  # fmt: skip

    @classmethod
    def from_tiling(cls, tiling: Tiling, bracing: str = "single") -> Framework:
        """The bars of the panels of a tiling, unsupported; a periodic one gives the framework of its cell."""
        from kirigami.lattice.tilings.tiling import Tiling

        require_instance(tiling, Tiling, "tiling", "Framework.from_tiling")
        found: dict[tuple[int, ...], None] = {}
        for bar in tiling.bars(bracing):
            (i, a, b), (j, c, d) = sorted(tiling.corners[end] for end in bar)
            found[i, j, c - a, d - b] = None
        rows = np.array(list(found))
        lattice = np.zeros((0, 2)) if tiling.lattice is None else tiling.lattice
        unknown = np.arange(tiling.points.size).reshape(-1, 2)
        return cls(tiling.points, rows[:, :2], unknown, lattice, rows[:, 2 : 2 + len(lattice)])

    @property
    def unknowns(self) -> int:
        """Number of free displacements."""
        return int(self.unknown.max(initial=-1)) + 1

    def vectors(self, points: Array | None = None) -> Array:
        """Vectors (b, dim) from the first to the second end of each bar."""
        x = self.points
        if points is not None:
            x = require_array(points, self.points.shape, name="points", owner="Framework")
        return x[self.bars[:, 1]] + self.shifts @ self.lattice - x[self.bars[:, 0]]

    def compatibility(self, points: Array | None = None, phases: ArrayLike | None = None) -> NDArray[Any]:
        """The compatibility matrix C, shape (bars, unknowns).

        Parameters
        ----------
        points : ndarray, shape (n, dim), optional
            Positions at which it is taken; None takes those of the framework.
        phases : array_like, shape (m,), optional
            Bloch phases q.a along the lattice vectors [rad]: displacements of a cell moved by (n1, n2) are those of
            the first cell times exp(i (n1 phase1 + n2 phase2)), and C is complex. None is phase zero.
        """
        direction = self.vectors(points)
        direction = direction / np.linalg.norm(direction, axis=1, keepdims=True)
        turn: NDArray[Any] = np.ones(len(self.bars))
        if phases is not None:
            turn = np.exp(1j * (self.shifts @ self._checked_phases(phases)))
        matrix = np.zeros((len(self.bars), self.unknowns), dtype=turn.dtype)
        rows = np.arange(len(self.bars))
        for axis in range(self.points.shape[1]):
            for end, weight in ((0, -direction[:, axis]), (1, turn * direction[:, axis])):
                column = self.unknown[self.bars[:, end], axis]
                moving = column >= 0
                np.add.at(matrix, (rows[moving], column[moving]), weight[moving])
        return matrix

    def _checked_phases(self, phases: ArrayLike) -> Array:
        return require_array(phases, (len(self.lattice),), name="phases", owner="Framework")

    def field(self, unknowns: Array) -> Array:
        """Displacements (n, 3) of all points for values (unknowns,) of the unknowns."""
        unknowns = require_array(unknowns, (self.unknowns,), name="unknowns", owner="Framework.field")
        moving = self.unknown >= 0
        field = np.zeros((len(self.points), 3))
        field[:, : self.points.shape[1]][moving] = unknowns[self.unknown[moving]]
        return field

    def rigidity(self, phases: ArrayLike | None = None) -> Rigidity:
        """Zero modes and states of self-stress from one singular value decomposition of C.

        Parameters
        ----------
        phases : array_like, optional
            Bloch phases, as for :meth:`compatibility`; modes are then complex.
        """
        matrix = self.compatibility(phases=phases)
        left, size, right = np.linalg.svd(matrix)
        rank = int(np.count_nonzero(size > RANK * size.max(initial=0.0)))
        modes, stresses = right[rank:].conj(), left[:, rank:].T.conj()
        rigid = self._rigid_motions(matrix, phases)
        # What is left of the zero modes when the rigid motions are taken out, in an orthonormal basis.
        inner = modes - (modes @ rigid.conj().T) @ rigid
        _, kept, basis = np.linalg.svd(inner, full_matrices=False)
        return Rigidity(self, rank, modes, stresses, len(rigid), basis[kept > 0.5])

    def _rigid_motions(self, matrix: NDArray[Any], phases: ArrayLike | None) -> Array:
        """Orthonormal basis (motions, unknowns) of the rigid motions that supports and lattice leave."""
        from kirigami.primitives.rigid import rigid_motions

        if phases is not None and np.any(np.remainder(self._checked_phases(phases), 2 * np.pi)):
            return np.zeros((0, self.unknowns))
        dim = self.points.shape[1]
        fields, _ = rigid_motions(self.points)
        fields = fields[: dim if len(self.lattice) else len(fields)].reshape(-1, self.points.size)
        unknown = self.unknown.ravel()
        carried = np.zeros((len(fields), self.unknowns))
        carried[:, unknown[unknown >= 0]] = fields[:, unknown >= 0]
        back = np.where(unknown >= 0, carried[:, unknown], 0.0)
        _, lost, mix = np.linalg.svd((fields - back).T, full_matrices=True)
        lost = np.append(lost, np.zeros(len(mix) - len(lost)))
        allowed = mix[lost < 1e-9] @ carried
        _, size, basis = np.linalg.svd(allowed, full_matrices=False)
        return basis[size > 1e-9]

    def follow(self, mode: ArrayLike, distance: float, steps: int = 40) -> Array:
        """Follow a mechanism at zero energy: every bar keeps its length while the framework moves far.

        Each step goes along the zero mode nearest to the last direction and returns to the constraint by least
        squares (Gauss-Newton), so no stiffness enters.

        Parameters
        ----------
        mode : array_like, shape (n, dim) or (n, 3)
            Direction in which to start.
        distance : float
            Length of the path: root sum of squares of the point displacements, added up [length].
        steps : int
            Points on the path.

        Returns
        -------
        ndarray, shape (steps + 1, n, 3)
            Displacements from the start.

        Raises
        ------
        AnalysisError
            The direction stretches bars, or the motion comes to an end on the way.

        Examples
        --------
        >>> import kirigami as kg, numpy as np
        >>> m = kg.Model(dim=2)
        >>> a, b = m.add(kg.Node(0, 0), kg.Node(1, 0))
        >>> objects = m.add(kg.Bar(a, b, EA=1.0), kg.Fix(a))
        >>> path = kg.Framework.from_model(m).follow([[0, 0], [0, 1]], distance=np.pi / 2, steps=90)
        >>> bool(np.allclose(path[-1, 1], [-1, 1, 0], atol=1e-3))
        True
        """
        count, dim = self.points.shape
        start = require_array(mode, (count, dim), (count, 3), name="mode", owner="Framework.follow")[:, :dim]
        distance = require_positive(distance, "distance", "Framework.follow")
        steps = require_whole(steps, "steps", "Framework.follow", least=1)
        moving = self.unknown >= 0
        direction = np.zeros(self.unknowns)
        direction[self.unknown[moving]] = start[moving]
        if start.shape != self.points.shape or not np.linalg.norm(direction) > 0:
            raise ModelError(f"follow: mode must be a motion of shape {self.points.shape}, not zero")
        direction /= np.linalg.norm(direction)
        rest = np.linalg.norm(self.vectors(), axis=1)
        q = np.zeros(self.unknowns)
        path = [self.field(q)]
        weight = np.bincount(self.unknown[moving], minlength=self.unknowns)
        for number in range(steps):
            matrix = self.compatibility(self._moved(q))
            along = direction - np.linalg.lstsq(matrix, matrix @ direction, rcond=RANK)[0]
            if np.linalg.norm(along) < 0.5:
                raise AnalysisError(
                    f"follow: the motion ends after {number} of {counted(steps, 'step')}" if number else
                    "follow: the starting direction stretches bars; take it from the zero modes"
                )  # fmt: skip
            step = along * (distance / steps / np.sqrt(weight @ along**2))
            moved = q + step
            for _ in range(20):
                gap = np.linalg.norm(self.vectors(self._moved(moved)), axis=1) - rest
                if np.abs(gap).max() <= 1e-13 * rest.max():
                    break
                moved -= np.linalg.lstsq(self.compatibility(self._moved(moved)), gap, rcond=RANK)[0]
            else:
                raise AnalysisError(
                    f"follow: the motion cannot be continued after {number} of {counted(steps, 'step')}"
                )
            direction = (moved - q) / np.linalg.norm(moved - q)
            q = moved
            path.append(self.field(q))
        return np.array(path)

    def _moved(self, q: Array) -> Array:
        return self.points + self.field(q)[:, : self.points.shape[1]]

    def __repr__(self) -> str:
        return (
            f"<Framework: {counted(len(self.points), 'point')}, {counted(len(self.bars), 'bar')}, "
            f"{counted(len(self.lattice), 'lattice vector')}>"
        )


@dataclass(frozen=True, eq=False, repr=False)
class Rigidity:
    """What a framework can do without stretching, and carry without load.

    Attributes
    ----------
    rank : int
        Rank of the compatibility matrix.
    zero_modes : ndarray, shape (k, unknowns)
        Orthonormal motions that stretch no bar to first order, rigid ones included.
    self_stresses : ndarray, shape (s, bars)
        Orthonormal bar forces in balance without load.
    rigid : int
        Number of rigid motions among the zero modes.
    internal : ndarray, shape (k - rigid, unknowns)
        Zero modes orthogonal to the rigid motions.

    Examples
    --------
    >>> import kirigami as kg
    >>> m = kg.Model(dim=2)
    >>> a, b, c = m.add(kg.Node(0, 0), kg.Node(1, 0), kg.Node(2, 0))
    >>> objects = m.add(kg.Bar(a, b, EA=1.0), kg.Bar(b, c, EA=1.0), kg.Fix([a, c]))
    >>> rigidity = kg.Framework.from_model(m).rigidity()     # straight: the middle node can move sideways
    >>> rigidity.maxwell, len(rigidity.zero_modes), len(rigidity.self_stresses)
    (0, 1, 1)
    """

    framework: Framework
    rank: int
    zero_modes: NDArray[Any]
    self_stresses: NDArray[Any]
    rigid: int
    internal: NDArray[Any]

    @property
    def maxwell(self) -> int:
        """Unknowns minus bars, which equals zero modes minus states of self-stress."""
        return self.framework.unknowns - len(self.framework.bars)

    @property
    def shapes(self) -> Array:
        """Internal zero modes as displacements (k - rigid, n, 3), the largest component 1."""
        fields = [self.framework.field(mode.real) for mode in self.internal]
        scaled = [field / field.ravel()[np.argmax(np.abs(field))] for field in fields]
        return np.array(scaled).reshape(-1, len(self.framework.points), 3)

    def __str__(self) -> str:
        zero, stress = len(self.zero_modes), len(self.self_stresses)
        return (
            f"{counted(self.framework.unknowns, 'unknown')}, {counted(len(self.framework.bars), 'bar')}: "
            f"{counted(zero, 'zero mode')} ({self.rigid} rigid, {zero - self.rigid} internal), "
            f"{counted(stress, 'state')} of self-stress"
        )

    def __repr__(self) -> str:
        return f"<Rigidity: {self}>"
