"""A kernel held against finite differences, symmetry and rigid motion."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kirigami.errors import ModelError
from kirigami.primitives.checks import require_array, require_finite, require_instance, require_positive
from kirigami.primitives.kernel import Array, Kernel, full_hessian
from kirigami.words import counted

LARGEST_STEP = 0.1  # differences over more say nothing of a derivative


def check_kernel(kernel: Kernel, x: ArrayLike, lam: float = 1.0, step: float = 1e-6) -> dict[str, float]:
    """Hold a kernel against finite differences, symmetry and rigid motion at one configuration.

    Parameters
    ----------
    kernel : Kernel
        The kernel to check.
    x : array_like, shape (n_nodes, dim)
        Positions at which to check, in the unit of length of the model.
    lam : float
        Load factor.
    step : float
        Difference step, as a fraction of the size of the members.

    Returns
    -------
    dict of float
        Largest relative errors: ``gradient`` and ``hessian`` against central differences (about 1e-7 is right),
        ``symmetry`` of the Hessian, ``force`` and ``moment`` resultants of each member, ``rigid`` change of energy
        under a large rotation and a translation. The last three are meant for elements; a load need not
        meet them.

    Examples
    --------
    >>> import numpy as np, kirigami as kg
    >>> m = kg.Model()
    >>> a, b = m.add(kg.Node(0, 0), kg.Node(1, 0))
    >>> bar = m.add(kg.Bar(a, b, EA=10.0))
    >>> kernel, = kg.System(m).kernels
    >>> errors = kg.check_kernel(kernel, [[0, 0, 0], [1.2, 0.3, -0.1]])
    >>> max(errors.values()) < 1e-6
    True
    """
    require_instance(kernel, Kernel, "kernel", "check_kernel")
    lam, step = require_finite(lam, "lam", "check_kernel"), require_positive(step, "step", "check_kernel")
    if step > LARGEST_STEP:
        raise ModelError(f"check_kernel: step must be at most {LARGEST_STEP:g}, got {step:g}")
    x = require_array(x, (None, 2), (None, 3), name="x", owner="check_kernel")
    conn = kernel.conn
    if len(x) <= conn.max(initial=-1):
        raise ModelError(
            f"check_kernel: x must have a row for each node, up to node {conn.max()}, got {counted(len(x), 'row')}"
        )
    n, k = conn.shape
    dim = x.shape[1]
    exact = kernel.evaluate(x, lam, 2)
    assert exact.gradient is not None
    hessian = full_hessian(kernel, exact)
    size = np.abs(x[conn] - x[conn].mean(axis=1, keepdims=True)).max() or 1.0
    h = step * size
    # One member at a time would be slow and all at once would mix members that share a node, so the members are
    # evaluated on a copy in which no two of them share one.
    gradient_error = hessian_error = 0.0
    gradient_size = np.abs(exact.gradient).max() + np.abs(exact.energy).max() / size + 1e-300
    hessian_size = np.abs(hessian).max() + gradient_size / size
    for a in range(k):
        for axis in range(dim):
            energies, gradients = [], []
            for sign in (1.0, -1.0):
                moved_energy = np.empty(n)
                moved_gradient = np.empty((n, k, dim))
                for color in _independent(conn):
                    y = x.copy()
                    y[conn[color, a], axis] += sign * h
                    moved = kernel.evaluate(y, lam, 1)
                    assert moved.gradient is not None
                    moved_energy[color], moved_gradient[color] = moved.energy[color], moved.gradient[color]
                energies.append(moved_energy)
                gradients.append(moved_gradient)
            by_energy = (energies[0] - energies[1]) / (2 * h)
            by_gradient = (gradients[0] - gradients[1]) / (2 * h)
            gradient_error = max(gradient_error, np.abs(by_energy - exact.gradient[:, a, axis]).max())
            hessian_error = max(hessian_error, np.abs(by_gradient - hessian[:, :, a, :, axis]).max())
    # What rigid motions do to the rows of the members is the kernel's to say: not every row is a point.
    shifts = [kernel.rigidly_moved(x, np.eye(dim), size * axis) - x for axis in np.eye(dim)]
    force = [np.einsum("nka,nka->n", exact.gradient, shift[conn]) / size for shift in shifts]
    angle = 1e-4
    moment = []
    for first, second in ((0, 1), (1, 2), (2, 0))[: 1 if dim == 2 else 3]:
        turns = [kernel.rigidly_moved(x, _turn(dim, first, second, way * angle), np.zeros(dim)) for way in (1, -1)]
        rate = (turns[0] - turns[1]) / (2 * np.sin(angle))
        moment.append(np.einsum("nka,nka->n", exact.gradient, rate[conn]))
    rotation = np.linalg.qr(np.random.default_rng(1).normal(size=(dim, dim)))[0]
    rotation[:, 0] *= np.sign(np.linalg.det(rotation))
    turned = kernel.evaluate(kernel.rigidly_moved(x, rotation, np.full(dim, size)), lam, 0).energy
    energy_size = np.abs(exact.energy).max() + gradient_size * size
    return {
        "gradient": float(gradient_error / gradient_size),
        "hessian": float(hessian_error / hessian_size),
        "symmetry": float(np.abs(hessian - hessian.transpose(0, 2, 1, 4, 3)).max() / hessian_size),
        "force": float(np.abs(force).max() / gradient_size),
        "moment": float(np.abs(moment).max() / (gradient_size * max(size, float(np.abs(x).max())))),
        "rigid": float(np.abs(turned - exact.energy).max() / energy_size),
    }


def _turn(dim: int, first: int, second: int, angle: float) -> Array:
    """Rotation in the plane of two axes."""
    turn = np.eye(dim)
    turn[first, first] = turn[second, second] = np.cos(angle)
    turn[second, first] = np.sin(angle)
    turn[first, second] = -np.sin(angle)
    return turn


def _independent(conn: NDArray[np.int64]) -> list[NDArray[np.int64]]:
    """Members grouped so that no two of a group share a node (greedy colouring)."""
    groups: list[list[int]] = []
    used: list[set[int]] = []
    for member, nodes in enumerate(conn.tolist()):
        for group, taken in zip(groups, used):
            if taken.isdisjoint(nodes):
                group.append(member)
                taken.update(nodes)
                break
        else:
            groups.append([member])
            used.append(set(nodes))
    return [np.array(group) for group in groups]
