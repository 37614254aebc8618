"""How the forces of a kernel change with its own numbers: by differences, where it does not know better."""

from __future__ import annotations

import inspect
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from kirigami.primitives.kernel import Array, Kernel

STEP = 1e-5  # of the size of a number, in a central difference


def member_work(kernel: Kernel, x: Array, lam: float, v: Array, energy: float = 0.0) -> Array:
    """v times the gradient of each member, plus `energy` times its energy, (n,)."""
    found = kernel.evaluate(x, lam, 1)
    assert found.gradient is not None
    work: Array = np.einsum("nka,nka->n", found.gradient, v[kernel.conn])
    if energy and kernel.stores_energy:
        work = work + energy * found.energy
    return work


def rebuilt(kernel: Kernel, **changed: Any) -> Kernel:
    """A kernel with some of its arrays changed and the history it had."""
    arrays = {**kernel.arrays(), **changed}
    takes_rest = "rest" in inspect.signature(type(kernel)).parameters
    twin = type(kernel)(kernel.rest, **arrays) if takes_rest else type(kernel)(**arrays)  # type: ignore[attr-defined, call-arg]
    if kernel.history is not None:
        twin.history = kernel.history
    return twin


def by_differences(kernel: Kernel, x: Array, lam: float, v: Array, energy: float = 0.0) -> dict[str, Array]:
    """Derivatives of :func:`member_work` by every array of numbers that a kernel has one row a member of.

    A number of one member changes that member alone, so that two evaluations serve all members at once.
    """
    count = len(kernel.conn)
    found: dict[str, Array] = {}
    for name, values in kernel.arrays().items():
        if not isinstance(values, np.ndarray) or values.dtype.kind != "f" or values.shape[:1] != (count,):
            continue
        columns = values.reshape(count, -1)
        rates = np.zeros_like(columns)
        for column in range(columns.shape[1]):
            given = columns[:, column]
            if not np.isfinite(given).any():
                continue
            size = float(np.nanmax(np.abs(given))) or 1.0
            step = STEP * np.where(np.abs(given) > 1e-6 * size, np.abs(given), size)
            sides = []
            for sign in (1.0, -1.0):
                moved = columns.copy()
                moved[:, column] += sign * step
                sides.append(member_work(rebuilt(kernel, **{name: moved.reshape(values.shape)}), x, lam, v, energy))
            rates[:, column] = np.where(np.isfinite(given), (sides[0] - sides[1]) / (2 * step), 0.0)
        found[name] = rates.reshape(values.shape)
    return found


def by_rest_differences(kernel: Kernel, x: Array, lam: float, fields: Array, energies: Array) -> Array:
    """As :meth:`Kernel.by_rest`, for kernels made of a rest state and arrays of their members alone.

    Every member is given nodes of its own, so that two evaluations serve one coordinate of all of them.
    """
    from kirigami.primitives.kernel import Configuration, displacement_of

    rest: Array = kernel.rest  # type: ignore[attr-defined]
    arrays = kernel.arrays()
    given: NDArray[np.int64] = arrays["conn"]
    count, nodes = given.shape
    apart = np.arange(count * nodes).reshape(count, nodes)
    own, moved = rest[given.ravel()], displacement_of(x, rest)[given.ravel()]
    at_nodes = fields[:, given.ravel()]
    step = STEP * np.linalg.norm(np.ptp(own.reshape(count, nodes, -1), axis=1), axis=1)
    found = np.zeros((len(fields), *rest.shape))
    for local in range(nodes):
        for axis in range(rest.shape[1]):
            sides = []
            for sign in (1.0, -1.0):
                places = own.copy()
                places[apart[:, local], axis] += sign * step
                twin = type(kernel)(places, **{**arrays, "conn": apart})  # type: ignore[call-arg]
                if kernel.history is not None:
                    twin.history = kernel.history
                told = twin.evaluate(Configuration(places, moved), lam, 1)
                assert told.gradient is not None
                work = np.einsum("nka,tnka->tn", told.gradient, at_nodes[:, twin.conn])
                sides.append(work + energies[:, None] * told.energy)
            for total, rate in zip(found, (sides[0] - sides[1]) / (2 * step)):
                np.add.at(total[:, axis], given[:, local], rate)
    return found
