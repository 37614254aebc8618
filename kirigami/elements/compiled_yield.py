"""The compiled twin of the layers of a sheet that yields, for Numba (extra "fast")."""

from __future__ import annotations

import numpy as np

from kirigami.elements import yield_loops
from kirigami.elements.layers import PLACES, WEIGHTS, Layers
from kirigami.primitives.kernel import Array


class CompiledLayers(Layers):
    """As :class:`kirigami.elements.layers.Layers`, layer by layer in compiled loops."""

    def passed(self, fields: Array) -> Array:
        found = np.empty(len(fields), dtype=bool)
        yield_loops.passed(
            np.ascontiguousarray(fields), self.thickness, self._equal, self._shear, self.hardening.first, PLACES[-1],
            found,
        )  # fmt: skip
        return found

    def respond(
        self, fields: Array, state: Array, tangent: bool = True
    ) -> tuple[Array, Array, Array | None, Array]:
        n, hardening = len(fields), self.hardening
        energy, borne, new = np.zeros((n, 3)), np.zeros((n, 3, 6)), np.empty_like(state)
        section = np.zeros((n if tangent else 0, 3, 6, 6))
        yield_loops.respond(
            np.ascontiguousarray(fields), np.ascontiguousarray(state), self.thickness, self.E, self.nu,
            hardening.strain, hardening.stress, hardening.slope, hardening.work, hardening.back, hardening.rise,
            hardening.store, PLACES, WEIGHTS, tangent, energy, borne, section, new,
        )  # fmt: skip
        return energy, borne, section if tangent else None, new
