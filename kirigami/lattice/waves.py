"""Buckling of infinite sheets in waves of any length: Bloch waves on a cell of sheet.

A cell that repeats forbids what repeats less often. Whether the sheet is stable against waves of all lengths is seen
from K(phase) of one cell (:mod:`kirigami.lattice.wave_stiffness`), phase running over the Brillouin zone; K(-phase) is
its conjugate, so half of the zone will do. The lowest eigenvalue mu over that at rest is 1 at rest, falls nearly
linearly with the load, and is zero where the sheet buckles (Geymonat, Mueller and Triantafyllidis, Archive for Rational
Mechanics and Analysis 122 (1993), 231-290, on microscopic and macroscopic instabilities of periodic bodies).
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from kirigami.errors import AnalysisError, ConvergenceError, KirigamiWarning, ModelError
from kirigami.lattice.cell_system import CellSystem, require_sheet
from kirigami.lattice.flat_cell import FlatCell
from kirigami.lattice.wave_stiffness import WaveStiffness
from kirigami.primitives.checks import require_array, require_positive, require_whole
from kirigami.primitives.kernel import Array
from kirigami.words import counted

if TYPE_CHECKING:
    from kirigami.lattice.periodic import PeriodicCell

GRID = 6  # phases from 0 to half a turn, from which the search for the worst wave starts
FIRST = 1e-6  # strain that tells how fast the stiffness falls
NOTHING = 1e-7  # fall of the stiffness over that strain, below which nothing buckles
NEAR = 0.2  # lowest eigenvalue over that at rest, from which on the worst wave is looked for between those of the grid
AHEAD = 0.7  # fall of the stiffness over the largest one, below which a wave is behind
CLOSE = 1e-6  # lowest eigenvalue over that at rest that is zero
LONGER = 0.01  # lowest eigenvalue over that at rest of the wave of twice the length that tells of long waves
MOST = 60  # states of the cell that a search looks at
WHOLE = 1 + 1e-9


def waves(cell: PeriodicCell, phases: ArrayLike, at: Any = None) -> Array:
    """Stability of the infinite sheet against waves, about an equilibrium of its cell.

    Parameters
    ----------
    phases : array_like, shape (..., m)
        Bloch phases along the lattice vectors, from -pi to pi [rad]: a wave of n cells has a phase of 2 pi / n. Zero is
        what every cell does alike, with the mean strain held.
    at : Step, or array_like, shape (n, 3), optional
        The equilibrium, a step of results of the cell; None is rest.

    Returns
    -------
    ndarray, shape (...)
        Lowest eigenvalue of the stiffness over that at rest: 1 at rest, 0 at the brink, negative where the sheet is
        unstable against such a wave; -inf where already a cell with its border held still is.

    Raises
    ------
    ModelError
        The cell is no sheet in space, phases of a wrong shape or out of range, a step of another model, a load without
        a potential.
    AnalysisError
        At rest the sheet does not resist such a wave.

    Examples
    --------
    >>> import kirigami as kg
    >>> sheet = kg.CellSheet([(1, 0), (0, 1)], thickness=0.1, material=kg.Material(E=12000.0, nu=0.0))
    >>> cell = kg.PeriodicCell(kg.Model.from_mesh(sheet.mesh(0.4), stiffness="shell"), sheet.lattice)
    >>> imposed = cell.impose((-1e-3, None, None))  # N = 1.2
    >>> step = kg.DisplacementControl(cell.model, corrector="newton").run()[-1]
    >>> round(float(cell.waves([0.5, 0.0], step)), 2)  # 1 - N / (D k^2), with D = 1
    -3.8
    """
    require_sheet(cell, "waves")
    given = require_array(phases, name="phases", owner="PeriodicCell.waves")
    if given.ndim == 0 or given.shape[-1] != len(cell.lattice):
        raise ModelError(
            f"PeriodicCell.waves: phases must have the shape (..., {len(cell.lattice)}), got {given.shape}"
        )
    if np.abs(given).max(initial=0.0) > math.pi * WHOLE:
        raise ModelError(
            f"PeriodicCell.waves: phases must lie from -pi to pi, got {np.abs(given).max():.6g}: others are the same "
            "waves once more"
        )
    known = CellSystem(cell, hold=False)
    rest = WaveStiffness(known, np.zeros_like(known.system.rest), 0.0)
    here = WaveStiffness(known, *known.state(at, "PeriodicCell.waves"))
    flat = given.reshape(-1, given.shape[-1])
    found = [-math.inf if here.unstable else here.lowest(rest, phase) for phase in flat]
    return np.array(found).reshape(given.shape[:-1])


@dataclass(frozen=True, eq=False, repr=False)
class BlochBuckling:
    """Where an infinite sheet buckles first, and in which wave.

    Attributes
    ----------
    factor : float
        Of the strain that was asked for.
    strain, stress : ndarray, shape (3,) for a sheet, (1,) for a strip
        Mean strain and mean stress there [force / length], of a strip its force.
    phases : ndarray, shape (m,)
        Bloch phases of the wave along the lattice vectors [rad].
    wave_vector : ndarray, shape (2,)
        The same as a wave vector k, phases = k . lattice vectors [1 / length].
    shape : ndarray, shape (n, 3)
        Complex displacements of the nodes of the cell; in the cell at a lattice vector R they are the real part of
        ``shape * exp(i k.R)``. Largest component 1.
    longest : bool
        Whether it is the longest wave that was looked at: then sheets that are longer buckle earlier.
    """

    factor: float
    strain: Array
    stress: Array
    phases: Array
    wave_vector: Array
    shape: Array
    longest: bool

    @property
    def wavelength(self) -> float:
        """Length of the wave [length]; inf where all cells buckle alike."""
        size = float(np.linalg.norm(self.wave_vector))
        return 2 * math.pi / size if size > 0 else math.inf

    def __repr__(self) -> str:
        strain, phases = (", ".join(f"{value:.4g}" for value in values + 0.0) for values in (self.strain, self.phases))
        length = f"wavelength={self.wavelength:.4g}" if math.isfinite(self.wavelength) else "all cells alike"
        return f"BlochBuckling(factor={self.factor:.6g}, strain=({strain}), phases=({phases}), {length})"


def buckling(cell: PeriodicCell, strain: Sequence[float | None], longest: int = 20, most: float = 0.5) -> BlochBuckling:
    """Mean strain at which the flat infinite sheet buckles first, among waves of up to `longest` cells.

    The cell is followed in its plane, at any strain; out of it, and in it, all waves are looked at.

    Parameters
    ----------
    strain : sequence of float or None
        Direction of the mean strain, as for :meth:`impose`: what is given grows in proportion, None is free.
    longest : int
        Cells in the longest wave. A sheet without end has no strength against compression as a whole: N = D k^2.
    most : float
        Largest strain to go to.

    Returns
    -------
    BlochBuckling

    Raises
    ------
    ModelError
        The cell is no flat sheet in space, or the strain drives nothing.
    AnalysisError
        It does not buckle up to that strain, or leaves its plane at once.
    ConvergenceError
        The equilibrium in the plane was lost.

    Warns
    -----
    KirigamiWarning
        The longest wave is the first to buckle.

    Examples
    --------
    A long strip, twenty cells of length 1 to the wave: Euler's load E I k^2 of a column.

    >>> import math, kirigami as kg
    >>> mesh = kg.TriMesh([(0, 0), (1, 0), (1, 1), (0, 1)], [(0, 1, 2), (0, 2, 3)])
    >>> m = kg.Model.from_mesh(mesh, thickness=0.01, material=kg.Material(E=12e6, nu=0.0), stiffness="shell")
    >>> found = kg.PeriodicCell(m, [[1, 0]]).buckling([-1.0], longest=19)
    >>> round(float(found.stress[0] / (2 * math.pi / 19) ** 2), 3)
    -1.0
    """
    require_sheet(cell, "buckling")
    longest = require_whole(longest, "longest", "PeriodicCell.buckling", least=2)
    most = require_positive(most, "most", "PeriodicCell.buckling")
    search = _Search(cell, cell._strains(strain), longest)
    factor, phases = search.critical(most)
    here, state = search.at(factor)
    system = search.known.system
    shape = here.shape(search.rest, phases)[: system.points]
    k: Array = np.asarray(np.linalg.lstsq(cell.lattice[:, :2], phases, rcond=None)[0], dtype=float)
    at_end = bool(0 < np.abs(phases).max() <= 2 * math.pi / longest * (1 + 1e-6))
    at_end = at_end and here.lowest(search.rest, 0.5 * phases) < -LONGER
    if at_end:
        warnings.warn(
            f"the longest wave that was looked at, {counted(longest, 'cell')}, is the first to buckle: longer sheets "
            "buckle earlier, since the mean stress compresses the sheet as a whole; give longest= the size of yours",
            KirigamiWarning,
            stacklevel=2,
        )
    return BlochBuckling(factor, state.strain, state.stress, phases, k, shape, at_end)


class _Search:
    """Looks for the strain and the wave of the lowest buckling load."""

    def __init__(self, cell: PeriodicCell, strain: Sequence[float | None], longest: int) -> None:
        self.flat = FlatCell(cell, strain)
        self.known = CellSystem(cell, hold=False)
        self.rest = WaveStiffness(self.known, np.zeros_like(self.known.system.rest), 0.0)
        self.shortest = 2 * math.pi / longest
        self.size = max(abs(value) for value in strain if value)
        m = len(cell.lattice)
        ticks = np.arange(-GRID, GRID + 1) * math.pi / GRID
        long = self.shortest * np.array([step for step in product((-1, 0, 1), repeat=m) if any(step)])
        grid = np.array([p for p in product(ticks, repeat=m) if any(p) and np.abs(p).max() >= self.shortest])
        both = np.concatenate([np.zeros((1, m)), long, grid])
        first = np.array([next((v for v in p if abs(v) > 1e-12), 0.0) for p in both])
        self.grid = both[first >= 0]  # the other half are conjugates
        self._known: dict[float, tuple[WaveStiffness, Any]] = {}

    def at(self, factor: float) -> tuple[WaveStiffness, Any]:
        """The stiffness of the cell in its plane, and what it bears."""
        if factor not in self._known:
            if len(self._known) >= MOST:
                raise ConvergenceError("PeriodicCell.buckling: the search for the strain at buckling came to no end")
            state = self.flat.at(factor)
            self._known[factor] = WaveStiffness(self.known, state.u, factor), state
        return self._known[factor]

    def worst(self, factor: float, among: Array) -> tuple[Array, Array]:
        """Lowest eigenvalue over that at rest (k,) of waves with phases `among` (k, m), the lowest first.

        Near zero it is sought between them as well; -inf where the inside is unstable.
        """
        here, _ = self.at(factor)
        if here.unstable:
            return np.full(len(among), -math.inf), among
        found = np.array([here.lowest(self.rest, phases) for phases in among])
        order = np.argsort(found, kind="stable")
        found, among = found[order], among[order].copy()
        if abs(found[0]) < NEAR:
            found[0], among[0] = self._refined(here, float(found[0]), among[0])
        return found, among

    def _refined(self, here: WaveStiffness, value: float, phases: Array) -> tuple[float, Array]:
        """The lowest value near a wave of the grid."""
        from scipy.optimize import minimize

        if not phases.any():
            return value, phases

        def low(trial: Array) -> float:
            return here.lowest(self.rest, self._admitted(trial))

        start = phases + math.pi / (4 * GRID) * np.vstack([np.zeros(len(phases)), np.eye(len(phases))])
        options = {"xatol": 1e-4, "fatol": 1e-9, "maxfev": 120, "initial_simplex": start}
        found = minimize(low, phases, method="Nelder-Mead", options=options)
        return (float(found.fun), self._admitted(found.x)) if found.fun < value else (value, phases)

    def _admitted(self, phases: Array) -> Array:
        """Phases within the zone, and no longer a wave than the longest."""
        inside = (phases + math.pi) % (2 * math.pi) - math.pi
        inside = np.where(np.abs(np.abs(inside) - math.pi) < 1e-9, math.pi, inside)
        size = float(np.abs(inside).max())
        return inside if size >= self.shortest else inside * (self.shortest / max(size, 1e-12))

    def critical(self, most: float) -> tuple[float, Array]:
        """Load factor at which the first wave has no stiffness left, and its phases.

        As the eigenvalues fall nearly in proportion to the load, only the waves that are ahead are followed; in the end
        all are looked at again.
        """
        factor = FIRST / self.size
        found, among = self.worst(factor, self.grid)
        if 1 - found[0] < NOTHING:
            factor *= 1e3
            found, among = self.worst(factor, self.grid)
        tried = [(0.0, 1.0)]
        while True:
            if abs(found[0]) <= CLOSE:
                whole, every = self.worst(factor, self.grid)
                if whole[0] >= -CLOSE:
                    return factor, among[0]
                found, among = whole, every
            tried = sorted([*tried, (factor, float(found[0]))])
            low = max(f for f, value in tried if value > 0)
            if low * self.size >= most * (1 - 1e-9):
                raise AnalysisError(
                    f"PeriodicCell.buckling: the sheet does not buckle in its waves up to a strain of {most:g}; is the "
                    "strain the other way round?"
                )
            high = min((f for f, value in tried if value <= 0), default=math.inf)
            if math.isfinite(high) and high - low <= 1e-9 * high:
                return factor, among[0]
            factor = self._next(tried, low, high, most / self.size)
            behind = among[1 - found <= AHEAD * (1 - found[0])] if np.isfinite(found[0]) else among[1:0]
            among = among[: len(among) - len(behind)] if len(behind) < len(among) else among
            found, among = self.worst(factor, among)

    @staticmethod
    def _next(tried: list[tuple[float, float]], low: float, high: float, most: float) -> float:
        """Where the lowest eigenvalue should vanish, on the line through the last two loads that tell."""
        known = [(f, value) for f, value in tried if math.isfinite(value)]
        place = known.index((low, dict(known)[low]))
        one, two = (known[place], known[place + 1]) if place + 1 < len(known) else (known[place - 1], known[place])
        guess = two[0] + two[1] * (two[0] - one[0]) / max(one[1] - two[1], 1e-12)
        if math.isinf(high):
            return min(max(guess, 1.0001 * low), 10 * low, most)
        margin = 1e-6 * (high - low)
        return guess if low + margin < guess < high - margin else 0.5 * (low + high)
