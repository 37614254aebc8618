"""Periodic cells: ties with a prescribed mean strain, effective stiffness and mean stress, in the plane and in space.

In a periodic body the displacements of two points that are a lattice vector R apart differ by H R, H the mean
displacement gradient. Ties say so for all pairs of nodes of one cell; the energy per cell then depends on H alone,
and its derivatives over the measure of the cell (length, area or volume) are mean stress and effective stiffness.
"""

from __future__ import annotations

import copy
import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kirigami.errors import MechanismError, ModelError
from kirigami.model.constraints import Fix, Tie
from kirigami.model.model import Model
from kirigami.primitives.checks import require_array, require_boolean, require_instance, require_whole_array
from kirigami.primitives.groups import first_of_group
from kirigami.primitives.kernel import Array
from kirigami.primitives.node import AXES
from kirigami.results.results import Results

VOIGT = {1: [(0, 0)], 2: [(0, 0), (1, 1), (0, 1)], 3: [(0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1)]}


class PeriodicCell:
    """One cell of a periodic model: which nodes repeat which others.

    Parameters
    ----------
    model : Model
        A model of one cell, with nodes on both sides of its border. What lies on the border is to be modelled once.
    lattice : array_like, shape (m, dim) or (m, 2)
        Lattice vectors, one a row [length]: one, two, or in 3D three. Two make a sheet, free to move in z.
    images : array_like of int, shape (k, 2 + m), optional
        Rows (node, node it repeats, steps along each lattice vector), as in ``Tiling.images``; None finds the pairs by
        their positions.

    Attributes
    ----------
    images : ndarray of int, shape (k, 2 + m)
        The pairs; every repeated node is one that repeats none itself.

    Raises
    ------
    ModelError
        Lattice vectors that depend on each other, images that are not where the lattice puts them, or none at all.

    Examples
    --------
    >>> from kirigami import tilings
    >>> from kirigami.lattice.periodic import PeriodicCell
    >>> squares = tilings.rotating_squares(angle=0.6)
    >>> m = squares.model(EA=1e4, stiffness=1.0)
    >>> cell = PeriodicCell(m, squares.lattice, squares.images)
    >>> stiffness = cell.stiffness()
    >>> poisson = stiffness[0, 1] / stiffness[0, 0]      # a soft dilation and a stiff rest: -1 with rigid squares
    >>> bool(-1 < poisson < -0.99)
    True
    """

    def __init__(self, model: Model, lattice: ArrayLike, images: ArrayLike | None = None) -> None:
        self.model = require_instance(model, Model, "model", "PeriodicCell")
        self.dim = model.dim
        given = np.atleast_2d(require_array(lattice, name="lattice", owner="PeriodicCell"))
        if given.ndim != 2 or given.shape[1] > self.dim or not 1 <= len(given) <= self.dim:
            raise ModelError(f"PeriodicCell: lattice must hold up to {self.dim} vectors, one a row, got {given.shape}")
        self.lattice = np.zeros((len(given), self.dim))
        self.lattice[:, : given.shape[1]] = given
        self.measure = math.sqrt(abs(np.linalg.det(self.lattice @ self.lattice.T)))
        if not self.measure > 1e-9 * np.prod(np.linalg.norm(self.lattice, axis=1)):
            raise ModelError("PeriodicCell: the lattice vectors must not depend on each other")
        self._axes = _strained_axes(self.lattice)
        position = model.positions()[:, : self.dim]
        self._near = 1e-6 * float(np.linalg.norm(self.lattice, axis=1).max())
        self.images = self._found(position) if images is None else _checked_images(images, len(given), len(position))
        if self.images.ndim != 2 or self.images.shape[1] != 2 + len(given) or not len(self.images):
            raise ModelError("PeriodicCell: no node repeats another one; are the lattice vectors right?")
        off = position[self.images[:, 0]] - position[self.images[:, 1]] - self.shift_vectors
        worst = int(np.argmax(np.linalg.norm(off, axis=1)))
        if np.linalg.norm(off[worst]) > self._near:
            node, leader = (model.nodes[k] for k in self.images[worst, :2])
            raise ModelError(f"PeriodicCell: {node!r} is not where the lattice puts the image of {leader!r}")

    @property
    def shift_vectors(self) -> Array:
        """Lattice vector (k, dim) between each image and what it repeats."""
        vectors: Array = self.images[:, 2:] @ self.lattice
        return vectors

    def _found(self, position: Array) -> NDArray[np.int64]:
        """Pairs of nodes an integer number of lattice vectors apart; the first of each class leads."""
        from scipy.spatial import cKDTree

        inverse = np.linalg.pinv(self.lattice)
        part = position @ inverse
        cell = np.floor(part + 1e-6)
        wrapped = position - cell @ self.lattice
        leader = first_of_group(len(position), cKDTree(wrapped).query_pairs(self._near, output_type="ndarray"))
        followers = np.flatnonzero(leader != np.arange(len(position)))
        steps = np.rint((position[followers] - position[leader[followers]]) @ inverse).astype(int)
        return np.column_stack([followers, leader[followers], steps])

    # ---- nonlinear: ties

    def gradient(self, strain: ArrayLike) -> Array:
        """A mean displacement gradient (dim, dim) from itself, or from strains in the order of :meth:`stiffness`."""
        given = require_array(strain, name="strain", owner="PeriodicCell")
        pairs = self._pairs()
        if given.shape == (self.dim, self.dim):
            return given
        if given.shape != (len(pairs),):
            raise ModelError(
                f"PeriodicCell: the mean strain must be a gradient ({self.dim}, {self.dim}) or {len(pairs)} strains, "
                f"got shape {given.shape}"
            )
        full = np.zeros((self.dim, self.dim))
        for (a, b), value in zip(pairs, given):
            full[a, b] = full[b, a] = value if a == b else value / 2
        return full

    def _pairs(self) -> list[tuple[int, int]]:
        return [(self._axes[a], self._axes[b]) for a, b in VOIGT[len(self._axes)]]

    def impose(self, strain: ArrayLike, constant: bool = False) -> tuple[Any, ...]:
        """Add to the model the ties of the cell, with a mean strain at load factor 1, and hold one node.

        Parameters
        ----------
        strain : array_like, shape (dim, dim) or (3,) for a sheet, (6,) in space
            Mean displacement gradient H, or small strains in the order of :meth:`stiffness`. Only ``H @ R`` of lattice
            vectors R enters.
        constant : bool
            The strain acts in full whatever the load factor.

        Returns
        -------
        tuple
            The objects added: ties, and the Fix of a node that none repeats.
        """
        constant = require_boolean(constant, "constant", "PeriodicCell.impose")
        gradient = self.gradient(strain)
        difference = self.shift_vectors @ gradient.T
        nodes = self.model.nodes
        dofs = AXES[: self.dim]
        tie = Tie(
            [nodes[k] for k in self.images[:, 0]], [nodes[k] for k in self.images[:, 1]], dofs,
            **{axis: difference[:, number] for number, axis in enumerate(dofs)}, constant=constant,
        )  # fmt: skip
        held = Fix(nodes[int(self.images[0, 1])], dofs)
        self.model.add(tie, held)
        return tie, held

    def mean_stress(self, results: Results) -> Array:
        """Mean nominal stress (s, dim, dim) of each step: derivative of the energy by the mean displacement gradient.

        Component (i, j) is the force along i on the face whose normal was j, over the undeformed measure of that
        face: [force / length] for a sheet or planar model.
        """
        require_instance(results, Results, "results", "PeriodicCell.mean_stress")
        if results.rest.shape != (len(self.model.nodes), 3):
            raise ModelError("PeriodicCell.mean_stress: these results belong to another model")
        force = np.stack([results.reaction([int(k)]) for k in self.images[:, 0]], axis=1)[..., : self.dim]
        stress: Array = np.einsum("ski,kj->sij", force, self.shift_vectors) / self.measure
        return stress

    # ---- linear: effective stiffness

    def stiffness(self, u: ArrayLike | None = None) -> Array:
        """Effective stiffness of the cell.

        Second derivative of the energy per measure of the cell by the mean strain, all else relaxed and periodic.

        Parameters
        ----------
        u : array_like, shape (n, 3), optional
            Displacements about which it is taken, an equilibrium without mean rotation; None is the rest state.

        Returns
        -------
        ndarray, shape (3, 3) for a sheet or planar model, (6, 6) in space, (1, 1) for a chain along x
            In the order (xx, yy, xy) or (xx, yy, zz, yz, xz, xy), with engineering shear strain
            [force / length^(m - 1)] for m lattice vectors.

        Raises
        ------
        MechanismError
            The state is at the brink of a periodic instability, so nothing balances the strain. A motion that costs
            nothing is no error: where a mean strain can follow it, its stiffness is zero.
        """
        from scipy.sparse import csc_matrix

        from kirigami.system.system import System

        matrix = System(self._bare()).stiffness(u, constrained=False)
        count, strains = len(self.model.nodes), np.eye(len(self._pairs()))
        leader = np.arange(count)
        leader[self.images[:, 0]] = self.images[:, 1]
        kept, column = np.unique(leader, return_inverse=True)
        full = (column[:, None] * self.dim + np.arange(self.dim)).ravel()
        copies = csc_matrix((np.ones(full.size), (np.arange(full.size), full)), shape=(full.size, kept.size * self.dim))
        steps = np.zeros((count, self.dim))
        steps[self.images[:, 0]] = self.shift_vectors
        affine = np.stack([(steps @ self.gradient(strain).T).ravel() for strain in strains], axis=1)
        still = slice(self.dim, None)  # all but the first node, which stops the translations
        relaxed = np.zeros((kept.size * self.dim, len(strains)))
        inner = (copies.T @ matrix @ copies).tocsc()[still, still].tocsc()
        relaxed[still] = _relax(inner, copies.T[still] @ (matrix @ affine))
        field = affine + copies @ relaxed
        found = field.T @ (matrix @ field) / self.measure
        symmetric: Array = 0.5 * (found + found.T)
        return symmetric

    def _bare(self) -> Model:
        """The model without loads, held by the ties of the cell alone."""
        bare = copy.copy(self.model)
        bare.remove(*bare.constraints, *bare.loads)
        nodes = bare.nodes
        bare.add(Tie([nodes[k] for k in self.images[:, 0]], [nodes[k] for k in self.images[:, 1]], AXES[: self.dim]))
        return bare


def _checked_images(images: ArrayLike, vectors: int, nodes: int) -> NDArray[np.int64]:
    given = require_whole_array(images, (None, 2 + vectors), name="images", owner="PeriodicCell")
    if given[:, :2].min() < 0 or given[:, :2].max() >= nodes:
        raise ModelError(f"PeriodicCell: images must hold indices of nodes below {nodes} in their first two columns")
    return given


def _relax(stiffness: Any, load: Array) -> Array:
    """Fluctuations (free, k) that balance loads (free, k); motions that cost nothing are driven by nothing."""
    from scipy.sparse import identity

    from kirigami.linalg import SingularMatrixError, factorize

    if not load.size:
        return np.zeros_like(load)
    scale = float(stiffness.diagonal().max(initial=0.0))
    for shift in (0.0, 1e-12 * scale):
        try:
            factor = factorize((stiffness + shift * identity(stiffness.shape[0])).tocsc())
            found = np.column_stack([factor.solve(-column) for column in load.T])
        except SingularMatrixError:
            continue
        if np.abs(stiffness @ found + load).max() <= 1e-6 * np.abs(load).max():
            return found
    raise MechanismError(
        "no periodic motion balances the mean strain: the cell is at the brink of an instability; take its stiffness "
        "about a state before it",
        motion="periodic",
    )


def _strained_axes(lattice: Array) -> Sequence[int]:
    """Axes that the lattice vectors span; they must be coordinate axes."""
    dim = lattice.shape[1]
    used = [axis for axis in range(dim) if np.abs(lattice[:, axis]).max() > 1e-12 * np.abs(lattice).max()]
    if len(used) != len(lattice):
        raise ModelError(
            f"PeriodicCell: {len(lattice)} lattice vectors must span as many coordinate axes, not {len(used)}"
        )
    return used
