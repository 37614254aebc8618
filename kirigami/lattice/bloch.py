"""Periodic frameworks: bands over Bloch phases, guest modes of the cell, winding numbers and polarisation.

A periodic framework with as many bars as unknowns in its cell has a square compatibility matrix C(q). Where det C
does not vanish, the times its phase winds round zero while q goes round the zone along each lattice vector are
integers; they say at which edges the zero modes of a finite piece sit (Kane and Lubensky, Nature Physics 10, 39
(2014); Rocklin, Zhou, Sun and Mao, Nature Communications 8, 14201 (2017)).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from kirigami.errors import ModelError
from kirigami.lattice.framework import RANK, Framework
from kirigami.primitives.checks import require_array, require_finite, require_instance
from kirigami.primitives.kernel import Array
from kirigami.words import counted

TURN = 2 * math.pi


def bands(framework: Framework, phases: ArrayLike) -> Array:
    """Frequencies of a periodic framework, for unit masses and bars of unit spring constant.

    Parameters
    ----------
    framework : Framework
        A periodic one.
    phases : array_like, shape (..., m)
        Bloch phases q.a along the lattice vectors [rad].

    Returns
    -------
    ndarray, shape (..., unknowns)
        Ascending; a zero is a motion that stretches no bar.

    Examples
    --------
    >>> import kirigami as kg
    >>> cell = kg.Framework.from_tiling(kg.tilings.kagome(angle=1.75))
    >>> bool(kg.bloch.bands(cell, [1.0, 0.5])[0] > 0.01), round(abs(float(kg.bloch.bands(cell, [0.0, 0.0])[1])), 9)
    (True, 0.0)
    """
    _periodic(framework, "bands")
    at = require_array(phases, name="phases", owner="bands")
    if at.ndim == 0 or at.shape[-1] != len(framework.lattice):
        raise ModelError(f"bands: phases must have the shape (..., {len(framework.lattice)}), got {at.shape}")
    found = []
    for phase in at.reshape(-1, len(framework.lattice)):
        size = np.linalg.svd(framework.compatibility(phases=phase), compute_uv=False)
        found.append(np.append(np.zeros(max(framework.unknowns - len(size), 0)), size[::-1]))
    return np.array(found).reshape(*at.shape[:-1], framework.unknowns)


@dataclass(frozen=True, eq=False, repr=False)
class GuestMode:
    """A uniform motion that strains the cell and stretches no bar (Guest and Hutchinson 2003).

    ``strain`` (dim, dim) is symmetric, ``shape`` (n, dim) the motion of the points of the cell beside the mean
    strain; both share one scale, with the largest entry 1. For such a motion u = strain x + shape.
    """

    strain: Array
    shape: Array

    @property
    def poisson(self) -> float:
        """Poisson's ratio for a pull along x."""
        return float(-self.strain[1, 1] / self.strain[0, 0])

    def __repr__(self) -> str:
        return f"GuestMode(strain={np.round(self.strain, 6).tolist()})"


def guest_modes(framework: Framework) -> list[GuestMode]:
    """Uniform zero modes of a periodic framework whose lattice may strain.

    Parameters
    ----------
    framework : Framework
        A periodic one.

    Examples
    --------
    >>> import kirigami as kg
    >>> twist, = kg.bloch.guest_modes(kg.Framework.from_tiling(kg.tilings.rotating_triangles(angle=1.2)))
    >>> round(twist.poisson, 9)
    -1.0
    """
    _periodic(framework, "guest_modes")
    dim = framework.points.shape[1]
    along = framework.vectors()
    direction = along / np.linalg.norm(along, axis=1, keepdims=True)
    pairs = [(a, b) for a in range(dim) for b in range(a, dim)]
    strain = np.stack([direction[:, a] * along[:, b] * (1 if a == b else math.sqrt(2)) for a, b in pairs], axis=1)
    # Displacement = strain x + a periodic part, so the matrix of the cell at phase zero acts on the periodic part.
    matrix = np.hstack([framework.compatibility(), strain])
    _, size, right = np.linalg.svd(matrix)
    null = right[np.count_nonzero(size > RANK * size.max()) :]
    translation = np.zeros((dim, matrix.shape[1]))
    for axis in range(dim):
        translation[axis, framework.unknown[:, axis]] = 1 / math.sqrt(len(framework.points))
    null = null - (null @ translation.T) @ translation
    _, kept, basis = np.linalg.svd(null, full_matrices=False)
    modes = []
    for vector in basis[kept > 0.5]:
        tensor = np.zeros((dim, dim))
        for (a, b), value in zip(pairs, vector[framework.unknowns :]):
            tensor[a, b] = tensor[b, a] = value if a == b else value / math.sqrt(2)
        shape = framework.field(vector[: framework.unknowns])[:, :dim]
        entries = np.concatenate([tensor.ravel(), shape.ravel()])
        scale = entries[np.argmax(np.abs(entries))]
        modes.append(GuestMode(tensor / scale, shape / scale))
    return modes


def winding_numbers(framework: Framework, at: float = 1.0) -> tuple[int, ...]:
    """Turns of the phase of det C(q) as the phase along each lattice vector goes once round.

    They depend on which copies of points and bars make up the cell; see :func:`polarization` for what does not.

    Parameters
    ----------
    framework : Framework
        A periodic one with as many bars as unknowns.
    at : float
        Value of the other phases on the way [rad].

    Raises
    ------
    ModelError
        The framework is finite or not square, or det C vanishes on the way: two polarisations meet there.

    Examples
    --------
    >>> import kirigami as kg
    >>> [kg.bloch.winding_numbers(kg.Framework.from_tiling(kg.tilings.kagome(angle))) for angle in (1.08, 1.63)]
    [(0, 1), (1, 0)]
    """
    _periodic(framework, "winding_numbers")
    if len(framework.bars) != framework.unknowns:
        raise ModelError(
            f"winding_numbers: the cell has {counted(len(framework.bars), 'bar')} for "
            f"{counted(framework.unknowns, 'unknown')}; det C needs "
            "as many of both (for panels of four corners or more take bracing='single')"
        )
    at = require_finite(at, "at", "winding_numbers")
    numbers = []
    for axis in range(len(framework.lattice)):
        phases = np.full(len(framework.lattice), at)

        def phase(t: float, axis: int = axis, phases: Array = phases) -> complex:
            phases[axis] = t
            value = complex(np.linalg.det(framework.compatibility(phases=phases)))
            if abs(value) < 1e-9:
                raise ModelError(
                    f"winding_numbers: det C vanishes at phases {phases.round(6).tolist()}: the framework is at the "
                    "border between polarisations"
                )
            return value / abs(value)

        numbers.append(round(_turn(phase, 0.0, TURN, phase(0.0), phase(TURN), depth=0) / TURN))
    return tuple(numbers)


def _turn(
    phase: Callable[[float], complex], start: float, end: float, first: complex, last: complex, depth: int
) -> float:
    """Angle turned by a unit complex number between two parameters, halving intervals until each turn is small."""
    angle = math.atan2((last / first).imag, (last / first).real)
    if (depth >= 6 and abs(angle) < 0.5) or depth > 24:
        return angle
    middle = 0.5 * (start + end)
    at_middle = phase(middle)
    return _turn(phase, start, middle, first, at_middle, depth + 1) + _turn(
        phase, middle, end, at_middle, last, depth + 1
    )


def polarization(framework: Framework, at: float = 1.0) -> Array:
    """Topological polarisation in lattice vectors: which way the zero modes of finite pieces are pushed.

    The winding numbers, freed of what the choice of cell adds to them (twice the cell offsets of the points minus those
    of the bars), with the sign that points to the soft edge. It is the same for every choice of cell, and zero for a
    lattice with a threefold axis.

    Parameters
    ----------
    framework, at
        As for :func:`winding_numbers`.

    Returns
    -------
    ndarray, shape (m,)
        Components along the lattice vectors; the edge it points to is the soft one.

    Examples
    --------
    >>> import kirigami as kg
    >>> cells = [kg.Framework.from_tiling(kg.tilings.kagome(angle)) for angle in (1.08, 1.75)]
    >>> [(kg.bloch.polarization(cell) + 0).tolist() for cell in cells]
    [[0.0, 0.0], [0.0, 1.0]]
    """
    numbers = np.array(winding_numbers(framework, at))
    # The middle of a bar stands shifts / 2 from where its first end's cell has it; points stand in cell zero.
    found: Array = 0.5 * framework.shifts.sum(axis=0) - numbers
    return found


def _periodic(framework: Framework, owner: str) -> None:
    require_instance(framework, Framework, "framework", owner, "Framework.from_tiling makes one")
    if not len(framework.lattice):
        raise ModelError(f"{owner}: the framework is finite; take a periodic tiling")
