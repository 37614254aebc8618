"""Yield stress over plastic strain: what hardens, and how far a member flows.

A member yields where the size of its stress beyond the back stress reaches sigma_y(a), piecewise linear in the
accumulated plastic strain a (isotropic hardening). The back stress is K p for a plastic strain p, so that the
direction loaded first hardens and the opposite one softens (linear kinematic hardening, Prager). The same laws serve
stress and strain, force and strain of a bar, moment and angle of a hinge.

Of the plastic work the part int sigma_y da is dissipated and K p^2 / 2 is stored.
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
        Modulus K of kinematic hardening.
    """

    strain: tuple[float, ...]
    stress: tuple[float, ...]
    beyond: float = 0.0
    kinematic: float = 0.0

    def scaled(self, stress: float, strain: float = 1.0) -> YieldCurve:
        """The curve of a member whose force and deformation are multiples of stress and strain."""
        ratio = stress / strain
        strains, stresses = tuple(strain * a for a in self.strain), tuple(stress * s for s in self.stress)
        return YieldCurve(strains, stresses, ratio * self.beyond, ratio * self.kinematic)


def checked_table(given: Any, owner: str) -> float | tuple[tuple[float, float], ...]:
    """Hardening as it is kept: a modulus, or a table of plastic strain and stress."""
    if not isinstance(given, (list, tuple, np.ndarray)) or (isinstance(given, np.ndarray) and given.ndim == 0):
        return require_not_negative(given, "hardening", owner)
    rows = require_array(given, (None, 2), name="hardening", owner=owner)
    return tuple((float(strain), float(stress)) for strain, stress in rows)


def checked_curve(yields_at: float, hardening: Any, kinematic: float, owner: str, name: str) -> YieldCurve:
    """The curve of arguments as users give them, or a ModelError that says what is wrong with them."""
    first = require_positive(yields_at, name, owner)
    back = require_not_negative(kinematic, "kinematic", owner)
    table = checked_table(hardening, owner)
    if isinstance(table, float):
        return YieldCurve((0.0,), (first,), table, back)
    strain, stress = [0.0], [first]
    for number, (a, value) in enumerate(table):
        if number == 0 and a == 0:
            if abs(value - first) > 1e-9 * first:
                raise ModelError(
                    f"{owner}: hardening starts at plastic strain 0 with {value:.6g}, but {name} is {first:.6g}: "
                    "they must be the same"
                )
            continue
        if not a > strain[-1]:
            raise ModelError(
                f"{owner}: row {number} of hardening: plastic strain must grow from row to row and start at 0 or "
                f"above, got {a:.6g} after {strain[-1]:.6g}"
            )
        if value < stress[-1]:
            raise ModelError(
                f"{owner}: row {number} of hardening: the stress falls from {stress[-1]:.6g} to {value:.6g}, but a "
                "material that softens has no answer of its own: what yields would depend on the mesh. Give a table "
                "that does not fall"
            )
        strain.append(a)
        stress.append(value)
    return YieldCurve(tuple(strain), tuple(stress), 0.0, back)


def member_curve(yields_at: float | None, hardening: Any, kinematic: float, owner: str, name: str) -> YieldCurve | None:
    """The curve of a member, None where it never yields."""
    if yields_at is not None:
        return checked_curve(yields_at, hardening, kinematic, owner, name)
    if checked_table(hardening, owner) != 0.0 or require_not_negative(kinematic, "kinematic", owner):
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
    stress = np.interp(factor * curvature[:, None] * z, curve.strain, curve.stress)
    moment = np.maximum.accumulate([first * curve.stress[0], *(factor * (stress * z) @ w)])
    return YieldCurve((0.0, *curvature.tolist()), tuple(moment.tolist()), 0.0, slope * curve.kinematic)


class Hardening:
    """The curves of many members as arrays.

    Attributes
    ----------
    strain, stress : ndarray, shape (n, k)
        Points of each curve; what is missing is filled up with infinite strain. Members that never yield have infinite
        stress.
    beyond, kinematic : ndarray, shape (n,)
        Slope after the last point, and modulus of kinematic hardening.
    slope, work : ndarray, shape (n, k)
        Slope after each point, and plastic work up to it.
    """

    def __init__(self, strain: Array, stress: Array, beyond: Array, kinematic: Array) -> None:
        self.strain, self.stress, self.beyond, self.kinematic = strain, stress, beyond, kinematic
        count = strain.shape[1]
        self.slope = np.repeat(beyond[:, None], count, axis=1)
        self.work = np.zeros_like(strain)
        for k in range(count - 1):
            there = np.isfinite(strain[:, k + 1])
            apart = np.where(there, strain[:, k + 1] - strain[:, k], 1.0)
            rise = np.where(there, stress[:, k + 1] - stress[:, k], 0.0)
            self.slope[there, k] = (rise / apart)[there]
            mean = 0.5 * (stress[:, k] + stress[:, k + 1])
            self.work[:, k + 1] = np.where(there, self.work[:, k] + mean * apart, self.work[:, k])

    @classmethod
    def of(cls, curves: Sequence[YieldCurve | None]) -> Hardening:
        """The curves of members, None where a member never yields."""
        count = max((len(curve.strain) for curve in curves if curve is not None), default=1)
        strain, stress = np.full((len(curves), count), np.inf), np.full((len(curves), count), np.inf)
        strain[:, 0] = 0.0
        beyond, kinematic = np.zeros((2, len(curves)))
        for row, curve in enumerate(curves):
            if curve is not None:
                k = len(curve.strain)
                strain[row, :k], stress[row, :k], stress[row, k:] = curve.strain, curve.stress, curve.stress[-1]
                beyond[row], kinematic[row] = curve.beyond, curve.kinematic
        return cls(strain, stress, beyond, kinematic)

    @property
    def packed(self) -> Array:
        """All in one array (n, 2 k + 2), as kernels keep it in files."""
        return np.column_stack([self.strain, self.stress, self.beyond, self.kinematic])

    @classmethod
    def unpacked(cls, values: Array) -> Hardening:
        """From what :attr:`packed` made."""
        count = values.shape[1] // 2 - 1
        return cls(values[:, :count], values[:, count:-2], values[:, -2], values[:, -1])

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

    def dissipated(self, a: Array) -> Array:
        """Work per volume (n,), int sigma_y da up to a."""
        point = self._point(a)
        way = a - self.strain[point]
        with np.errstate(invalid="ignore"):
            found = self.work[point] + way * (self.stress[point] + 0.5 * self.slope[point] * way)
        return np.where(np.isfinite(self.first), found, 0.0)


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


def flow(
    stiffness: Array, hardening: Hardening, strain: Array, plastic: Array, accumulated: Array
) -> tuple[Array, Array, Array, Array]:
    """Stress, its slope, plastic strain and its accumulated size (n,) of members in one dimension.

    The state at the end of an increment from `plastic` and `accumulated`: (Simo and Hughes, Computational Inelasticity,
    1998, ch. 1) with the trial stress beyond the back stress s = k (e - p) - K p,

        |s| - (k + K) g = sigma_y(a + g),    p + g sign(s),    a + g.
    """
    stress = stiffness * (strain - plastic)
    beyond = stress - hardening.kinematic * plastic
    limit = hardening.at(accumulated)[0]
    slope = np.array(stiffness)
    on = np.flatnonzero(np.abs(beyond) > limit * (1 + 1e-12))
    if not on.size:
        return stress, slope, plastic, accumulated
    some, size, before = hardening.select(on), np.abs(beyond[on]), accumulated[on]
    elastic = stiffness[on] + some.kinematic

    def excess(g: Array, which: NDArray[np.int64]) -> tuple[Array, Array]:
        at, rise = (some if len(which) == len(on) else some.select(which)).at(before[which] + g)
        return at + elastic[which] * g - size[which], rise + elastic[which]

    g = increasing_root(excess, (size - limit[on]) / elastic)
    plastic, accumulated = plastic.copy(), accumulated.copy()
    plastic[on] += g * np.sign(beyond[on])
    accumulated[on] += g
    stress[on] = stiffness[on] * (strain[on] - plastic[on])
    rise = some.at(accumulated[on])[1] + some.kinematic
    slope[on] = stiffness[on] * rise / (stiffness[on] + rise)
    return stress, slope, plastic, accumulated
