"""The one contract for everything that makes force, and a checker for it.

A *kernel* is a struct of arrays for many alike objects: bars, hinges, springs, loads, contact. It says which
nodes each member touches and evaluates energy, gradient and Hessian blocks at a configuration. Whoever assembles
kernels knows no element; whoever writes an element knows no solver.
"""

from __future__ import annotations

from typing import Any, ClassVar, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]


class Configuration(np.ndarray[Any, np.dtype[np.float64]]):
    """Current node positions, shape (n, dim), that remember the displacement they came from.

    Small strains of a large sheet drown in the rounding of ``rest + displacement``; a kernel that measures strain
    reads ``displacement`` (n, dim) instead. ``scalars`` (p,) holds unknowns that are not translations.
    """

    displacement: Array | None
    scalars: Array | None

    def __new__(cls, rest: Array, displacement: Array, scalars: Array | None = None) -> Configuration:
        positions = (rest + displacement).view(cls)
        positions.displacement = displacement
        positions.scalars = scalars
        return positions

    def __array_finalize__(self, source: Any) -> None:
        self.displacement = None
        self.scalars = None


def displacement_of(x: ArrayLike, rest: Array) -> Array:
    """Displacement (n, dim) of positions `x` from `rest`, exact where `x` is a Configuration."""
    stored = getattr(x, "displacement", None)
    return np.asarray(x, dtype=float) - rest if stored is None else stored


class Contribution(NamedTuple):
    """What a kernel returns: member by member, ``None`` where it was not asked for.

    ``energy`` (n,); ``gradient`` (n, k, dim); ``hessian`` (n, k, k, dim, dim), or (n, pairs, dim, dim) for the
    kernels that list their local node ``pairs``.

    Examples
    --------
    >>> import numpy as np
    >>> import kirigami as kg
    >>> kg.Contribution(energy=np.array([0.5])).gradient is None
    True
    """

    energy: Array
    gradient: Array | None = None
    hessian: Array | None = None


class Kernel:
    """Base class of all kernels; a new effect overrides :meth:`evaluate` and little else.

    Attributes
    ----------
    name : str
        Key under which energy and seconds are reported, for example ``"bars"``.
    conn : ndarray of int, shape (n, k)
        Node indices of each member.
    pairs : tuple of (int, int), or None
        Local node pairs (a, b), a <= b, of the Hessian blocks that are returned; the blocks (b, a) follow by
        symmetry. None means all k * k blocks are returned; an empty tuple means the Hessian is zero.
    translation_invariant : bool
        True where shifting all nodes of a member changes nothing: then only pairs a < b are listed, since the block
        (a, a) is minus the sum of the blocks (a, b).
    scaled : bool
        True where the potential depends on the load factor, which it must do linearly.
    members : ndarray of int, shape (n,), or None
        Position of each member among the model's objects of its type.

    Examples
    --------
    Weights that hang on two nodes:

    >>> import numpy as np
    >>> import kirigami as kg
    >>> class Weights(kg.Kernel):
    ...     name, pairs, conn = "weights", (), np.array([[0], [1]])
    ...     def evaluate(self, x, lam=1.0, need=2):
    ...         return kg.Contribution(energy=x[:, 2], gradient=np.array([[[0.0, 0.0, 1.0]]] * 2))
    >>> kg.check_kernel(Weights(), [[0, 0, 0], [1, 0, 1]])["gradient"] < 1e-6
    True
    """

    name: ClassVar[str] = "kernel"
    pairs: tuple[tuple[int, int], ...] | None = None
    translation_invariant: bool = False
    measures_displacement: bool = False  # True where strain comes from displacements alone, and rounds as they do
    scaled: bool = False
    conn: NDArray[np.int64]
    anchored: bool = False  # True where rigid motions of its members cost energy, as for a support
    members: NDArray[np.int64] | None = None
    normals: tuple[NDArray[np.int64], NDArray[np.int64]] | None = None  # nodes and tips of their normals, if it has any
    convexity: float = 0.0  # 0: the exact Hessian; 1: a positive semi-definite one; between: their mixture

    def evaluate(self, x: Array, lam: float = 1.0, need: int = 2) -> Contribution:
        """Energy (need 0), also the gradient (need 1), also the Hessian (need 2) at positions `x` (n_nodes, dim)."""
        raise NotImplementedError

    def commit(self, x: Array) -> None:
        """Accept `x` as an equilibrium: history-dependent state moves on."""

    def revert(self) -> None:
        """Forget everything since the last commit."""

    def update(self, x: Array) -> bool:
        """Look for new or lost members at `x`; True when ``conn`` changed."""
        return False

    def linearize(self, x: Array, change: Array | None) -> None:
        """Take the stress of the next geometric stiffness from a linear step `change` (n, dim) off `x`, not from the
        position reached; None goes back to the exact stress. Kernels without a stiff stress ignore it."""

    @property
    def history(self) -> Array | None:
        """State that must be stored with a step to go on from it, or None."""
        return None

    @history.setter
    def history(self, value: Array | None) -> None:
        pass

    def arrays(self) -> dict[str, Any]:
        """Constructor arguments, so that results can be saved and rebuilt."""
        raise NotImplementedError(f"{type(self).__name__} does not say how to save itself: define arrays()")


def full_hessian(kernel: Kernel, contribution: Contribution) -> Array:
    """All k * k Hessian blocks, shape (n, k, k, dim, dim), of a contribution that may list only some pairs."""
    listed = contribution.hessian
    if kernel.pairs is None:
        assert listed is not None
        return listed
    n, k = kernel.conn.shape
    assert contribution.gradient is not None
    dim = contribution.gradient.shape[2]
    full = np.zeros((n, k, k, dim, dim))
    for slot, (a, b) in enumerate(kernel.pairs):
        assert listed is not None
        full[:, a, b] = listed[:, slot]
        if a != b:
            full[:, b, a] = listed[:, slot].swapaxes(-1, -2)
    if kernel.translation_invariant:
        own = np.arange(k)
        full[:, own, own] = -full.sum(axis=2)
    return full


def hessian_product(kernel: Kernel, contribution: Contribution, vectors: Array) -> Array:
    """Product of the Hessian of each member with its nodes' vectors, both (n, k, dim)."""
    blocks = contribution.hessian
    assert blocks is not None
    if kernel.pairs is None:
        return np.asarray(np.einsum("nklab,nlb->nka", blocks, vectors))
    product = np.zeros_like(vectors)
    for slot, (a, b) in enumerate(kernel.pairs):
        block = blocks[:, slot]
        if kernel.translation_invariant:  # only relative vectors count, which stands for the blocks (a, a)
            apart = vectors[:, b] - vectors[:, a]
            product[:, a] += np.einsum("nij,nj->ni", block, apart)
            product[:, b] -= np.einsum("nji,nj->ni", block, apart)
        else:
            product[:, a] += np.einsum("nij,nj->ni", block, vectors[:, b])
            if a != b:
                product[:, b] += np.einsum("nji,nj->ni", block, vectors[:, a])
    return product
