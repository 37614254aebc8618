"""Yield stress over plastic strain: what hardens, and how far a member flows.

A member yields where the size of its stress beyond the back stress reaches sigma_y(a), piecewise linear in the
accumulated plastic strain a (isotropic hardening). The back stress moves with the plastic strain by H'(a) dp, with H
piecewise linear as well, so that the direction loaded first hardens and the opposite one softens (kinematic hardening,
Prager; where H is straight the back stress is K p). The same laws serve stress and strain, force and strain of a bar,
moment and angle of a hinge.

Over one increment the plastic strain grows in one direction, so that the back stress grows by H(a) - H(a_0) along it:
what flows feels nothing but the back stress at the beginning and the curve sigma_y(a) + H(a) - H(a_0), and its energy
is a potential (Simo and Hughes, Computational Inelasticity, 1998, sections 1.4 and 3.3). Of the plastic work the part
int sigma_y da is dissipated, and that of the back stress is stored.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kirigami.errors import ModelError
from kirigami.primitives.checks import require_array, require_not_negative, require_positive
from kirigami.primitives.kernel import Array

MOST = 100  # corrections of a root, which bisection bounds
ROUNDING = 4e-16


@dataclass(frozen=True)
class YieldCurve:
    """One piecewise linear curve.

    Attributes
    ----------
    strain, stress : tuple of float
        Accumulated plastic strain, from 0, and the yield stress there.
    beyond : float
        Slope after the last point.
    kinematic : float
        Slope H' of the back stress after the last point, and before it unless `back` is given.
    back : tuple of float
        The back stress H at each point, from 0.
    """

    strain: tuple[float, ...]
    stress: tuple[float, ...]
    beyond: float = 0.0
    kinematic: float = 0.0
    back: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        if not self.back:
            object.__setattr__(self, "back", tuple(self.kinematic * a for a in self.strain))

    def scaled(self, stress: float, strain: float = 1.0) -> YieldCurve:
        """The curve of a member whose force and deformation are multiples of stress and strain."""
        ratio = stress / strain
        strains = tuple(strain * a for a in self.strain)
        stresses, back = (tuple(stress * s for s in values) for values in (self.stress, self.back))
        return YieldCurve(strains, stresses, ratio * self.beyond, ratio * self.kinematic, back)


def checked_table(given: Any, owner: str, name: str = "hardening") -> float | tuple[tuple[float, float], ...]:
    """Hardening as it is kept: a modulus, or a table of plastic strain and stress."""
    if not isinstance(given, (list, tuple, np.ndarray)) or (isinstance(given, np.ndarray) and given.ndim == 0):
        return require_not_negative(given, name, owner)
    rows = require_array(given, (None, 2), name=name, owner=owner)
    return tuple((float(strain), float(stress)) for strain, stress in rows)


def checked_curve(yields_at: float, hardening: Any, kinematic: Any, owner: str, name: str) -> YieldCurve:
    """The curve of arguments as users give them, or a ModelError that says what is wrong with them."""
    first = require_positive(yields_at, name, owner)
    strain, stress, beyond = _points(first, hardening, owner, "hardening", name)
    along, back, behind = _points(0.0, kinematic, owner, "kinematic", "the back stress")
    both = sorted({*strain, *along})
    return YieldCurve(
        tuple(both), tuple(_follow(strain, stress, beyond, both).tolist()), beyond, behind,
        tuple(_follow(along, back, behind, both).tolist()),
    )  # fmt: skip


def _points(first: float, given: Any, owner: str, name: str, begins: str) -> tuple[list[float], list[float], float]:
    """Plastic strains and stresses of one of the two curves, and its slope after the last of them."""
    table = checked_table(given, owner, name)
    strain, stress = [0.0], [first]
    if isinstance(table, float):
        return strain, stress, table
    for number, (a, value) in enumerate(table):
        if number == 0 and a == 0:
            if abs(value - first) > 1e-9 * first:
                raise ModelError(
                    f"{owner}: {name} starts at plastic strain 0 with {value:.6g}, but {begins} is {first:.6g}: "
                    "they must be the same"
                )
            continue
        if not a > strain[-1]:
            raise ModelError(
                f"{owner}: row {number} of {name}: plastic strain must grow from row to row and start at 0 or "
                f"above, got {a:.6g} after {strain[-1]:.6g}"
            )
        if value < stress[-1]:
            raise ModelError(
                f"{owner}: row {number} of {name}: the stress falls from {stress[-1]:.6g} to {value:.6g}, but a "
                "material that softens has no answer of its own: what yields would depend on the mesh. Give a table "
                "that does not fall"
            )
        strain.append(a)
        stress.append(value)
    return strain, stress, 0.0


def _follow(strain: Sequence[float], stress: Sequence[float], beyond: float, at: Any) -> Array:
    """A piecewise linear curve, with its slope after the last point."""
    past = np.maximum(np.asarray(at) - strain[-1], 0.0)
    return np.asarray(np.interp(at, strain, stress) + beyond * past)


def member_curve(yields_at: float | None, hardening: Any, kinematic: Any, owner: str, name: str) -> YieldCurve | None:
    """The curve of a member, None where it never yields; `hardening` may be one that is made already."""
    if isinstance(hardening, YieldCurve):
        return hardening
    if yields_at is not None:
        return checked_curve(yields_at, hardening, kinematic, owner, name)
    if checked_table(hardening, owner) != 0.0 or checked_table(kinematic, owner, "kinematic") != 0.0:
        raise ModelError(f"{owner}: hardening needs a {name}, at which it begins")
    return None


def bent(curve: YieldCurve, thickness: float) -> YieldCurve:
    """Moment per length over plastic curvature of a sheet in cylindrical bending, where all of it flows.

    A fibre at the height z has the plastic strain k z, in von Mises' measure 2 / sqrt(3) of it, and the stress
    2 / sqrt(3) sigma_y: M = 2 / sqrt(3) int |z| sigma_y(2 / sqrt(3) k |z|) dz, which is
    2 / sqrt(3) sigma_y t^2 / 4 at first. A table is followed at a few curvatures.
    """
    factor, half = 2 / np.sqrt(3), 0.5 * thickness
    first, slope = factor * thickness**2 / 4, factor**2 * thickness**3 / 12
    if len(curve.strain) == 1:
        return YieldCurve((0.0,), (first * curve.stress[0],), slope * curve.beyond, slope * curve.kinematic)
    at_face = [a * share for a, b in zip(curve.strain[1:], (*curve.strain[2:], 4 * curve.strain[-1]))
               for share in np.linspace(1, b / a, 5)[:-1]]  # fmt: skip
    places, weights = np.polynomial.legendre.leggauss(40)
    z, w = 0.5 * half * (places + 1), half * weights  # both halves
    inner = [curve.strain[1] * share for share in (0.25, 0.5, 0.75)]
    curvature = np.array([*inner, *at_face, 4 * curve.strain[-1], 16 * curve.strain[-1]]) / (factor * half)
    at = factor * curvature[:, None] * z
    moments = []
    for values, beyond in ((curve.stress, curve.beyond), (curve.back, curve.kinematic)):
        through = factor * (_follow(curve.strain, values, beyond, at) * z) @ w
        moments.append(tuple(np.maximum.accumulate([first * values[0], *through]).tolist()))
    return YieldCurve((0.0, *curvature.tolist()), moments[0], slope * curve.beyond, slope * curve.kinematic, moments[1])


class Hardening:
    """The curves of many members as arrays.

    Attributes
    ----------
    strain, stress, back : ndarray, shape (n, k)
        Points of each curve, with yield stress and back stress; what is missing is filled up with infinite strain.
        Members that never yield have infinite stress.
    beyond, kinematic : ndarray, shape (n,)
        Slopes of both after the last point.
    slope, rise : ndarray, shape (n, k)
        Slopes of both after each point.
    work, store : ndarray, shape (n, k)
        Integrals of both up to it.
    """

    def __init__(self, strain: Array, stress: Array, back: Array, beyond: Array, kinematic: Array) -> None:
        self.strain, self.stress, self.back = strain, stress, back
        self.beyond, self.kinematic = beyond, kinematic
        self.slope, self.work = _slopes(strain, stress, beyond)
        self.rise, self.store = _slopes(strain, back, kinematic)

    @classmethod
    def of(cls, curves: Sequence[YieldCurve | None]) -> Hardening:
        """The curves of members, None where a member never yields."""
        count = max((len(curve.strain) for curve in curves if curve is not None), default=1)
        strain, stress = np.full((len(curves), count), np.inf), np.full((len(curves), count), np.inf)
        strain[:, 0] = 0.0
        back = np.zeros((len(curves), count))
        beyond, kinematic = np.zeros((2, len(curves)))
        for row, curve in enumerate(curves):
            if curve is not None:
                k = len(curve.strain)
                strain[row, :k], stress[row, :k], stress[row, k:] = curve.strain, curve.stress, curve.stress[-1]
                back[row, :k], back[row, k:] = curve.back, curve.back[-1]
                beyond[row], kinematic[row] = curve.beyond, curve.kinematic
        return cls(strain, stress, back, beyond, kinematic)

    @property
    def packed(self) -> Array:
        """All in one array (n, 3 k + 2), as kernels keep it in files."""
        return np.column_stack([self.strain, self.stress, self.back, self.beyond, self.kinematic])

    @classmethod
    def unpacked(cls, values: Array) -> Hardening:
        """From what :attr:`packed` made."""
        strain, stress, back = np.split(values[:, :-2], 3, axis=1)
        return cls(strain, stress, back, values[:, -2], values[:, -1])

    def select(self, members: NDArray[Any]) -> Hardening:
        """Those of some members, in the order given, also with repetitions."""
        found = object.__new__(Hardening)
        for name, value in vars(self).items():
            setattr(found, name, value[members])
        return found

    @property
    def first(self) -> Array:
        """Yield stress (n,) of what has not yielded yet."""
        return np.asarray(self.stress[:, 0])

    def _point(self, a: Array) -> Any:
        if self.strain.shape[1] == 1:
            return slice(None), 0
        return np.arange(len(a)), (a[:, None] >= self.strain[:, 1:]).sum(axis=1)

    def at(self, a: Array) -> tuple[Array, Array]:
        """Yield stress and its slope (n,) at accumulated plastic strains (n,)."""
        point = self._point(a)
        return self.stress[point] + self.slope[point] * (a - self.strain[point]), self.slope[point]

    @property
    def moves(self) -> bool:
        """Whether any back stress moves."""
        return bool(self.rise.any())

    def back_at(self, a: Array) -> Array:
        """Back stress H (n,) there, in one direction."""
        point = self._point(a)
        return np.asarray(self.back[point] + self.rise[point] * (a - self.strain[point]))

    def both_at(self, a: Array) -> tuple[Array, Array]:
        """Sum of yield and back stress, and its slope (n,)."""
        point = self._point(a)
        slope = self.slope[point] + self.rise[point]
        return self.stress[point] + self.back[point] + slope * (a - self.strain[point]), slope

    def moved(self, before: Array, after: Array) -> tuple[Array, Array]:
        """By how much the back stress (n,) moves along the flow from one accumulated plastic strain to another, and the
        energy (n,) that this stores beside the work on the back stress as it was."""
        start, work = self.back_at(before), []
        for a in (before, after):
            point = self._point(a)
            way = a - self.strain[point]
            work.append(self.store[point] + way * (self.back[point] + 0.5 * self.rise[point] * way))
        return self.back_at(after) - start, work[1] - work[0] - start * (after - before)

    def dissipated(self, a: Array) -> Array:
        """Work per volume (n,), int sigma_y da up to a."""
        point = self._point(a)
        way = a - self.strain[point]
        with np.errstate(invalid="ignore"):
            found = self.work[point] + way * (self.stress[point] + 0.5 * self.slope[point] * way)
        return np.where(np.isfinite(self.first), found, 0.0)


def _slopes(strain: Array, stress: Array, beyond: Array) -> tuple[Array, Array]:
    """Slope after each point (n, k) of curves, and their integral up to it."""
    count = strain.shape[1]
    slope, work = np.repeat(beyond[:, None], count, axis=1), np.zeros_like(strain)
    for k in range(count - 1):
        there = np.isfinite(strain[:, k + 1])
        apart = np.where(there, strain[:, k + 1] - strain[:, k], 1.0)
        rise = np.where(there, stress[:, k + 1] - stress[:, k], 0.0)
        slope[there, k] = (rise / apart)[there]
        mean = 0.5 * (stress[:, k] + stress[:, k + 1])
        work[:, k + 1] = np.where(there, work[:, k] + mean * apart, work[:, k])
    return slope, work


def increasing_root(evaluate: Callable[[Array, NDArray[np.int64]], tuple[Array, Array]], high: Array) -> Array:
    """Roots (n,) between 0 and `high` of functions that increase from below zero to above it.

    ``evaluate(x, which)`` gives values and slopes of the functions `which`. Newton's method, with bisection where it
    leaves what is known to hold the root.
    """
    low, high, x = np.zeros_like(high), high.copy(), np.zeros_like(high)
    which = np.arange(len(high))
    for _ in range(MOST):
        value, slope = evaluate(x[which], which)
        here = x[which]
        below = value <= 0
        low[which[below]], high[which[~below]] = here[below], here[~below]
        with np.errstate(divide="ignore", invalid="ignore"):
            step = here - value / slope
        inside = (step >= low[which]) & (step <= high[which])
        x[which] = np.where(inside, step, 0.5 * (low[which] + high[which]))
        which = which[np.abs(x[which] - here) > ROUNDING * high[which]]
        if not which.size:
            break
    return x


def flow(stiffness: Array, hardening: Hardening, strain: Array, state: Array) -> tuple[Array, Array, Array]:
    """Stress and its slope (n,) and the state (n, 4) of members in one dimension: plastic strain, its accumulated size,
    back stress, and the energy that this has stored.

    The state at the end of an increment: with the trial stress beyond the back stress s = k (e - p) - b,

        |s| - k g = sigma_y(a + g) + H(a + g) - H(a),    p + g sign(s),    a + g.
    """
    plastic, accumulated, back, _ = state.T
    stress = stiffness * (strain - plastic)
    beyond = stress - back
    limit = hardening.at(accumulated)[0]
    slope = np.array(stiffness)
    on = np.flatnonzero(np.abs(beyond) > limit * (1 + 1e-12))
    if not on.size:
        return stress, slope, state
    some, size, before, elastic = hardening.select(on), np.abs(beyond[on]), accumulated[on], stiffness[on]
    start = some.back_at(before)

    def excess(g: Array, which: NDArray[np.int64]) -> tuple[Array, Array]:
        at, rise = (some if len(which) == len(on) else some.select(which)).both_at(before[which] + g)
        return at - start[which] + elastic[which] * g - size[which], rise + elastic[which]

    g = increasing_root(excess, (size - limit[on]) / elastic)
    way = g * np.sign(beyond[on])
    moved, stored = some.moved(before, before + g)
    new = state.copy()
    new[on] += np.stack([way, g, moved * np.sign(way), back[on] * way + stored], axis=1)
    stress[on] = elastic * (strain[on] - new[on, 0])
    rise = some.both_at(before + g)[1]
    slope[on] = elastic * rise / (elastic + rise)
    return stress, slope, new
