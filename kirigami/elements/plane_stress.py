"""Von Mises plasticity in plane stress, with isotropic and kinematic hardening.

With the plane-stress matrix C, P = [[2, -1, 0], [-1, 2, 0], [0, 0, 6]] / 3 and the stress n = s - b_0 beyond the back
stress before an increment, the sheet flows where sqrt(3/2 n'P n) reaches sigma_y(a) + H(a) - H(a_0), see
:mod:`kirigami.primitives.hardening`. At the end of the increment

    e_p = e_p0 + g P n,    a = a_0 + g sqrt(2/3 n'P n),    s = C (e - e_p),
    b = b_0 + (H(a) - H(a_0)) n / sqrt(3/2 n'P n),

in one scalar equation for g, since C and P have the same eigenvectors: equal stretch, shear at 45 degrees, and shear.
These are the conditions of a minimum over e_p and a, which must not fall, of the energy

    W = (e - e_p)'C(e - e_p) / 2 + b_0'(e_p - e_p0) + int (H - H(a_0)) da + int sigma_y da,

so that W after minimising is a potential of the stress, with the symmetric consistent tangent

    ds/de = X - t m m' / (2/3 h n'P n + t m'P n),    h = sigma_y' + H',
    t = 1 - 2/3 h g,    X = (C^-1 + g P)^-1,    m = X P n.

(Simo and Taylor, Int. J. Numer. Methods Eng. 22 (1986); Simo and Hughes, Computational Inelasticity, 1998, ch. 3.)
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from kirigami.primitives.hardening import Hardening, increasing_root
from kirigami.primitives.kernel import Array

P = np.array([[2.0, -1.0, 0.0], [-1.0, 2.0, 0.0], [0.0, 0.0, 6.0]]) / 3
STATE = 8  # numbers of a point: plastic strain (3), its accumulated size, back stress (3), and the energy it has stored


class PlaneStress:
    """Points (n,) of sheets, each with its constants.

    Parameters
    ----------
    E, nu : ndarray, shape (n,)
        Elastic constants.
    hardening : Hardening
        Their yield curves.
    """

    def __init__(self, E: Array, nu: Array, hardening: Hardening) -> None:
        self.E, self.nu, self.hardening = E, nu, hardening
        self._shear, self._stretch = E / (2 * (1 + nu)), E / (1 - nu)

    def elastic(self, strain: Array) -> Array:
        """Stress (n, 3) of elastic strains (n, 3)."""
        mean, half = 0.5 * (strain[:, 0] + strain[:, 1]), 0.5 * (strain[:, 0] - strain[:, 1])
        both, apart = self._stretch * mean, 2 * self._shear * half
        return np.stack([both + apart, both - apart, self._shear * strain[:, 2]], axis=1)

    def elasticity(self) -> Array:
        """The matrices C (n, 3, 3)."""
        return _matrix(self._stretch, 2 * self._shear)

    def energy(self, strain: Array, state: Array) -> Array:
        """The energy W (n,) at a state (n, 8)."""
        beyond = strain - state[:, :3]
        stored: Array = 0.5 * (beyond * self.elastic(beyond)).sum(axis=1)
        return stored + state[:, 7] + self.hardening.dissipated(state[:, 3])

    def flow(self, strain: Array, state: Array, tangent: bool = True) -> tuple[Array, Array | None, Array]:
        """Stress (n, 3), its tangent (n, 3, 3) and the state (n, 8) at the end of an increment from `state`."""
        stress = self.elastic(strain - state[:, :3])
        beyond = stress - state[:, 4:7]
        limit = self.hardening.at(state[:, 3])[0]
        size = np.sqrt(1.5 * np.maximum(((beyond @ P) * beyond).sum(axis=1), 0.0))
        matrices = self.elasticity() if tangent else None
        on = np.flatnonzero(size > limit * (1 + 1e-12))
        if not on.size:
            return stress, matrices, state
        g, n, some = self._solve(on, beyond[on], state[on, 3], size[on], limit[on])
        flown = n @ P
        square = (flown * n).sum(axis=1)
        new = state.copy()
        new[on, :3] += g[:, None] * flown
        new[on, 3] += g * np.sqrt(2 / 3 * square)
        if some.moves:
            moved, stored = some.moved(state[on, 3], new[on, 3])
            new[on, 4:7] += (moved / np.sqrt(1.5 * square))[:, None] * n
            new[on, 7] += stored + g * (state[on, 4:7] * flown).sum(axis=1)
        stress[on] = self._at(on).elastic(strain[on] - new[on, :3])
        if matrices is not None:
            matrices[on] = self._tangent(on, g, flown, square, some.both_at(new[on, 3])[1])
        return stress, matrices, new

    def _at(self, which: NDArray[np.int64]) -> PlaneStress:
        found = object.__new__(PlaneStress)
        found.E, found.nu = self.E[which], self.nu[which]
        found._shear, found._stretch = self._shear[which], self._stretch[which]
        return found

    def _solve(
        self, on: NDArray[np.int64], trial: Array, before: Array, size: Array, limit: Array
    ) -> tuple[Array, Array, Hardening]:
        """Multipliers g (k,), and the stress beyond the back stress (k, 3) there, of the points that flow.

        The equation is 1 / q(g) = 1 / (sigma_y + H - H_0)(a(g)), q von Mises' size: the left is nearly linear in g.
        """
        hardening = self.hardening.select(on)
        slow, fast = self._stretch[on] / 3, 2 * self._shear[on]
        start = hardening.back_at(before)
        both = (trial[:, 0] + trial[:, 1]) ** 2 / 6
        apart = (trial[:, 0] - trial[:, 1]) ** 2 / 2 + 2 * trial[:, 2] ** 2

        def apart_from_yield(g: Array, which: NDArray[np.int64]) -> tuple[Array, Array]:
            u, v = 1 + slow[which] * g, 1 + fast[which] * g
            square = both[which] / u**2 + apart[which] / v**2
            fall = both[which] * slow[which] / u**3 + apart[which] * fast[which] / v**3  # -(square)' / 2
            root = np.sqrt(square)
            rows = hardening if len(which) == len(on) else hardening.select(which)
            stress, slope = rows.both_at(before[which] + np.sqrt(2 / 3) * g * root)
            stress = stress - start[which]
            growth = np.sqrt(2 / 3) * (root - g * fall / root)
            value = 1 / (np.sqrt(1.5) * root) - 1 / stress
            return value, fall / (np.sqrt(1.5) * root**3) + slope * growth / stress**2

        # in units of the largest that g can be, and of the first yield stress
        high = (size / limit - 1) / np.minimum(slow, fast)
        g = increasing_root(apart_from_yield, high)
        mean, half = 0.5 * (trial[:, 0] + trial[:, 1]), 0.5 * (trial[:, 0] - trial[:, 1])
        u, v = 1 / (1 + slow * g), 1 / (1 + fast * g)
        n = np.stack([u * mean + v * half, u * mean - v * half, v * trial[:, 2]], axis=1)
        return g, n, hardening

    def _tangent(self, on: NDArray[np.int64], g: Array, flown: Array, square: Array, slope: Array) -> Array:
        t = 1 - 2 / 3 * slope * g
        X = _matrix(1 / (1 / self._stretch[on] + g / 3), 1 / (1 / (2 * self._shear[on]) + g))
        m = np.einsum("nab,nb->na", X, flown)
        below = 2 / 3 * slope * square + t * (m * flown).sum(axis=1)
        return np.asarray(X - (t / below)[:, None, None] * m[:, :, None] * m[:, None])


def _matrix(stretch: Array, shear: Array) -> Array:
    """Matrices (n, 3, 3) with these eigenvalues for equal stretch and for shear, whose engineering value counts."""
    found = np.zeros((len(stretch), 3, 3))
    found[:, 0, 0] = found[:, 1, 1] = 0.5 * (stretch + shear)
    found[:, 0, 1] = found[:, 1, 0] = 0.5 * (stretch - shear)
    found[:, 2, 2] = 0.5 * shear
    return found
