"""The one contract for everything that makes force, and a checker for it.

A *kernel* is a struct of arrays for many alike objects: bars, hinges, springs, loads, contact. It says which
nodes each member touches and evaluates energy, gradient and Hessian blocks at a configuration. Whoever assembles
kernels knows no element; whoever writes an element knows no solver.
"""

from __future__ import annotations

import copy
from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kirigami.errors import ModelError

Array = NDArray[np.float64]


class Configuration(np.ndarray[Any, np.dtype[np.float64]]):
    """Current node positions, shape (n, dim), that remember the displacement they came from.

    Small strains of a large sheet drown in the rounding of ``rest + displacement``; a kernel that measures strain
    reads ``displacement`` (n, dim) instead.
    """

    displacement: Array | None

    def __new__(cls, rest: Array, displacement: Array) -> Configuration:
        positions = (rest + displacement).view(cls)
        positions.displacement = displacement
        return positions

    def __array_finalize__(self, source: Any) -> None:
        self.displacement = None


def displacement_of(x: ArrayLike, rest: Array) -> Array:
    """Displacement (n, dim) of positions `x` from `rest`: exact where a system hands the positions over.

    Parameters
    ----------
    x : array_like, shape (n, dim)
        Positions, as :meth:`Kernel.evaluate` is given them.
    rest : ndarray, shape (n, dim)
        Positions in the rest state, as :class:`Numbering` holds them.

    Examples
    --------
    >>> import numpy as np, kirigami as kg
    >>> kg.displacement_of([[1.5, 0.0]], np.array([[1.0, 0.0]]))
    array([[0.5, 0. ]])
    """
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


Ahead = tuple[Array, Array] | None  # a linear step: where it starts, and the change it makes


@dataclass(frozen=True, eq=False)
class Tangent:
    """Which tangent a corrector wants; energy and gradient are always exact.

    Attributes
    ----------
    convexity : float
        Share of the indefinite part of the Hessian that is faded out: 0 is the exact Hessian, 1 a positive
        semi-definite one, between them their mixture.
    ahead : tuple of ndarray, or None
        Positions x (n, dim) and a change (n, dim): the stress in the geometric stiffness is that of a linear step
        `change` off `x`, instead of that of the position reached. Kernels without a stiff stress ignore it.

    Examples
    --------
    >>> import kirigami as kg
    >>> kg.Tangent().convexity
    0.0
    """

    convexity: float = 0.0
    ahead: Ahead = None


EXACT = Tangent()


class CompiledKernel:
    """A kernel's fast twin: the same energy, forces and blocks, added in place by compiled loops."""

    _kernel: Kernel

    def energy(self, x: Configuration, lam: float) -> float:
        """Energy of all members together."""
        return float(self._kernel.evaluate(x, lam, 0).energy.sum())

    def add_forces(self, x: Configuration, lam: float, total: Array) -> float:
        """Add the gradient to `total` (n_nodes, dim); returns the sum of its squares, member by member."""
        raise NotImplementedError

    def add_blocks(
        self, x: Configuration, lam: float, tangent: Tangent, slots: NDArray[np.int64], blocks: Array
    ) -> None:
        """Add the Hessian to node blocks (blocks, dim, dim) at the `slots` of the assembly plan, pair by pair."""
        raise NotImplementedError


class Kernel:
    """Base class of all kernels; a new effect overrides :meth:`evaluate` and little else.

    Attributes
    ----------
    name : str
        Key under which energy, forces and seconds are reported, for example ``"bars"``.
    conn : ndarray of int, shape (n, k)
        Node indices of each member.
    places : ndarray of int, shape (n, p), or None
        Nodes at which each member lies, where the rows it works on are not those of nodes.
    members : ndarray of int, shape (n,), or None
        Position of each member among the model's objects of its type.
    pairs : tuple of (int, int), or None
        Local node pairs (a, b), a <= b, of the Hessian blocks that are returned; the blocks (b, a) follow by
        symmetry. None means all k * k blocks are returned; an empty tuple means the Hessian is zero.
    stores_energy : bool
        True where the energy is stored in the structure, as in an element, and False for the potential of a load. It
        is False for kernels that declare ``pairs = ()`` and say nothing else.
    conservative : bool
        False where the force has no potential, so that ``energy`` means nothing and stability cannot be counted.
    translation_invariant : bool
        True where shifting all nodes of a member changes nothing: then only pairs a < b are listed, since the block
        (a, a) is minus the sum of the blocks (a, b).
    measures_displacement : bool
        True where strain comes from displacements alone, and rounds as they do.
    scaled : bool
        True where the potential depends on the load factor: linearly, or in a way that :meth:`by_load` knows.
    anchored : bool
        True where rigid motions of its members cost energy, as for a support.
    compile_from : int
        Members from which a compiled twin pays.
    surface : bool
        True where the members are facets of a sheet, whose first three nodes are the corners: then the deformation is
        (exx, eyy, gamma_xy, kxx, kyy, 2 kxy) with the first axis along the edge between the first two, and the force
        (Nxx, Nyy, Nxy, Mxx, Myy, Mxy).
    sheet_part : str
        What of a sheet without facets the members stand for: "bars" its stretching, "hinges" its bending, "seams" that
        across the border of a periodic cell; and "held edges" of any sheet that at its supports.
    approximates : bool
        True where :meth:`evaluate` takes a further argument `tangent`, a :class:`Tangent`.
    path_dependent : bool
        True where ``history`` changes what members bear, as sliding or yield do, and is no mere count of turns: then
        an end state tells no gradients.
    across_border : bool
        True where the members bend across the border of a periodic cell.
    independent : bool
        True where the members take nothing from the rest state or the sheet, as forces on nodes: then no gradient by
        these asks for them.
    mesh_edges : ndarray of int, shape (n,), or None
        Edges of a mesh that the members take their constants from; None where these are all between two facets.
    begun : float
        Share that is there of what acts whatever the load factor, less than 1 while a start from rest grows into it.

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
    conn: NDArray[np.int64]
    places: NDArray[np.int64] | None = None
    members: NDArray[np.int64] | None = None
    pairs: tuple[tuple[int, int], ...] | None = None
    stores_energy: bool = True
    conservative: bool = True
    translation_invariant: bool = False
    measures_displacement: bool = False
    scaled: bool = False
    anchored: bool = False
    surface: bool = False
    sheet_part: str = ""
    approximates: bool = False
    path_dependent: bool = False
    across_border: bool = False
    independent: bool = False
    mesh_edges: NDArray[np.int64] | None = None
    compile_from: int = 5_000
    begun: float = 1.0

    def __init_subclass__(cls) -> None:
        if cls.__dict__.get("pairs") == () and "stores_energy" not in cls.__dict__:
            cls.stores_energy = False

    def evaluate(self, x: Array, lam: float = 1.0, need: int = 2) -> Contribution:
        """Energy (need 0), also the gradient (need 1), also the Hessian (need 2) at positions `x` (n_nodes, dim)."""
        raise NotImplementedError

    def by_load(self, x: Array, lam: float, need: int = 1) -> Contribution:
        """Change of energy (need 0) and gradient (need 1) with the load factor at positions `x`; asked where
        ``scaled``. A potential that is not linear in the load factor must override this."""
        after, before = self.evaluate(x, lam + 1.0, need), self.evaluate(x, lam, need)
        if need == 0:
            return Contribution(after.energy - before.energy)
        assert after.gradient is not None and before.gradient is not None
        return Contribution(after.energy - before.energy, after.gradient - before.gradient)

    def with_product(self, x: Array, lam: float, vectors: Array) -> tuple[Contribution, Array]:
        """Energy and gradient at positions `x`, and the product of the Hessian of each member with its nodes' vectors,
        both (n, k, dim); kernels of large Hessians override it and make them piece by piece."""
        found = self.evaluate(x, lam, 2)
        product = np.zeros_like(vectors) if self.pairs == () else hessian_product(self, found, vectors)
        return found._replace(hessian=None), product

    def stiffness_size(self, x: Array, lam: float) -> Array:
        """Root of the sum of squares (n,) of the Hessian of each member at positions `x`."""
        hessian = hessian_blocks(self, x, lam).reshape(len(self.conn), -1)
        return np.asarray(np.sqrt(np.einsum("nk,nk->n", hessian, hessian)))

    def stiffness_of_positions(self, stiffness: Array) -> Array:
        """The part of each member's `stiffness` (n,) at rest that acts on positions, and so on their rounding, instead
        of displacements: all or nothing of it, by ``measures_displacement``, unless a kernel knows better."""
        return np.asarray(0.0 * stiffness if self.measures_displacement else stiffness)

    def compiled(self) -> CompiledKernel | None:
        """The kernel's compiled twin, or None where it has none; asked for where Numba is installed and pays."""
        return None

    def part(self, members: NDArray[np.int64]) -> Kernel:
        """The kernel of some `members` (k,) alone, with their present history, to be evaluated beside others of its
        place; the whole kernel where it is not taken apart."""
        return self

    def _cut_out(self, members: NDArray[np.int64], axes: dict[str, int]) -> Any:
        """A copy with `members` (k,) alone in each of its arrays, by their axis of members."""
        part = copy.copy(self)
        for name, axis in axes.items():
            values = getattr(self, name)
            setattr(part, name, None if values is None else np.take(values, members, axis))
        return part

    # ---- what it tells of its members

    def deformation(self, x: Array) -> Array:
        """What the members feel (n, ...): strain, angle, gap, in an order and unit that the kernel states."""
        raise ModelError(f"{self.name!r} has no deformation to tell: its kernel defines none")

    def deformation_at(self, x: Array, lam: float) -> Array:
        """The same at a load factor, which counts where it moves what is felt, as a surface that is driven."""
        return self.deformation(x)

    def deformation_rate(self, x: Array, change: Array) -> Array:
        """First-order change of the deformation for a displacement change (n_nodes, dim); by default a difference."""
        size = float(np.abs(change).max(initial=0.0))
        if size == 0:
            return 0.0 * self.deformation(x)
        step = 1e-6 * (float(np.ptp(np.asarray(x), axis=0).max(initial=0.0)) or 1.0) / size
        plain = np.asarray(x)
        return (self.deformation(plain + step * change) - self.deformation(plain - step * change)) / (2 * step)

    def force(self, deformation: Array) -> Array:
        """What the members answer (n, ...) to a deformation: force, moment."""
        raise ModelError(f"{self.name!r} has no force to tell: its kernel defines none")

    def force_at(self, deformation: Array, lam: float) -> Array:
        """The same at a load factor, which counts where it changes the law, as a rest length that is driven does."""
        return self.force(deformation)

    def actuate(self, members: NDArray[np.int64], values: Array, constant: bool) -> None:
        """Add `values` (k, ...) to what `members` (k,) bear nothing at, whatever the load factor or, unless `constant`,
        growing with it; asked of the parts of a sheet."""
        raise ModelError(f"{self.name!r} takes no strain or angle of its own: its kernel defines no actuate")

    def mass(self, lumped: bool = False) -> Array | None:
        """Mass matrices (n, k, k) of the members, the same along every axis, or None where it has no mass."""
        return None

    def rigidly_moved(self, x: Array, rotation: Array, shift: Array) -> Array:
        """Rows `x` after a rotation (dim, dim) and a shift (dim,) of the structure: the points moved, and what stands
        behind them (see :class:`kirigami.Numbering`) as the kernel needs it for an energy that does not change."""
        return np.asarray(np.asarray(x) @ rotation.T + shift)

    def settle(self, x: Array) -> None:
        """Given where the nodes are, put a guess into the rows of `x` behind them, and take it as the state from which
        history goes on; kernels without such rows have nothing to do."""

    def rows_behind(self, inside: NDArray[np.bool_]) -> NDArray[np.int64]:
        """Rows behind the nodes (see :class:`kirigami.Numbering`) that what holds the nodes `inside` (n,) holds as
        well, so that the forces on them are part of its moment. One kernel must say so of every row."""
        return np.zeros(0, dtype=np.int64)

    # ---- members that come and go

    def coupling(self, x: Array, tangent: Tangent = EXACT) -> Any:
        """Hessian as a sparse matrix (rows * dim, rows * dim) at `x`, of kernels whose members come and go with it, so
        that their blocks stand in no plan; None where it is zero. Such a kernel declares ``pairs = ()``."""
        return None

    def admissible(self, x: Array, y: Array) -> float:
        """Largest share of the straight way from `x` to `y` that may be gone: less than 1 where the way leads through
        what the kernel forbids. Only kernels that override this are asked."""
        return 1.0

    def check_start(self, x: Array) -> None:
        """Raise a ModelError where an analysis must not start from `x`. Only kernels that override this are asked."""

    def held_surface(self, x: Array) -> tuple[Array, NDArray[np.int64], NDArray[np.int64]] | None:
        """Points, edges and triangles, at positions `x` of the nodes, of a surface that must not pass through itself,
        in the place of the sheet's own; None where the kernel holds none apart."""
        return None

    # ---- history

    def commit(self, x: Array) -> None:
        """Accept `x` as an equilibrium: history-dependent state moves on."""

    def commit_at(self, x: Array, lam: float) -> None:
        """The same at a load factor, which counts where history hangs on what that moves."""
        self.commit(x)

    def start_stage(self) -> None:
        """Let a new stage begin, whose load factor counts from 0 again, once history is that of the last one."""

    def revert(self) -> None:
        """Forget everything since the last commit."""

    def update(self, x: Array) -> bool:
        """Look for new or lost members at `x`; True when ``conn`` changed."""
        return False

    @property
    def history(self) -> Array | None:
        """State that must be stored with a step to go on from it, or None."""
        return None

    @history.setter
    def history(self, value: Array | None) -> None:
        pass

    def sensitivity(self, x: Array, lam: float, v: Array, energy: float = 0.0) -> dict[str, Array]:
        """Derivatives, by each of its :meth:`arrays` of numbers, of a field `v` (n_nodes, dim) times its gradient at
        fixed positions, and of its energy times `energy`; by default differences, so that nothing need be said."""
        from kirigami.primitives.sensitivity import by_differences

        return by_differences(self, x, lam, v, energy)

    def by_rest(self, x: Array, lam: float, fields: Array, energies: Array) -> Array | None:
        """Derivatives (k, rows, dim) by what the rows hold in the rest state of `fields` (k, rows, dim) times its
        gradient, and of its energy times `energies` (k,), at fixed displacements.

        Numbers that were taken from the rest state, as a rest length that nobody gave, follow it. None where that is
        not known: the structure is then lowered once more with its rest state changed.
        """
        return None

    def fits(self, history: Array) -> bool:
        """Whether `history` can be that of this kernel; it may be of another model."""
        own = self.history
        return own is not None and history.shape == own.shape

    def plastic(self) -> Array | None:
        """Accumulated plastic deformation (n,) of the members in the committed state; None where they never yield."""
        return None

    def dissipated(self, x: Array) -> Array | None:
        """The part (n,) of the energy at `x` that is lost to plastic work; None where nothing is."""
        return None

    def force_of(self, x: Array, lam: float) -> Array:
        """What the members answer (n, ...) at `x`, where history counts as well."""
        return self.force_at(self.deformation_at(x, lam), lam)

    def arrays(self) -> dict[str, Any]:
        """Constructor arguments, so that results can be saved and rebuilt."""
        raise NotImplementedError(f"{type(self).__name__} does not say how to save itself: define arrays()")


def hessian_blocks(kernel: Kernel, x: Array, lam: float, tangent: Tangent = EXACT) -> Array:
    """Hessian blocks of a kernel, by the tangent asked for where it knows more than the exact one."""
    if kernel.approximates and tangent is not EXACT:
        found = kernel.evaluate(x, lam, 2, tangent)  # type: ignore[call-arg]
    else:
        found = kernel.evaluate(x, lam, 2)
    assert found.hessian is not None
    return found.hessian


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
