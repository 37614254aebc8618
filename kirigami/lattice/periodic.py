"""Periodic cells: ties with a prescribed mean strain, effective stiffness and mean stress, in the plane and in space.

In a periodic body the displacements of two points that are a lattice vector R apart differ by H R, H the mean
displacement gradient. Ties say so for all pairs of nodes of one cell; the energy per cell then depends on H alone,
and its derivatives over the measure of the cell (length, area or volume) are mean stress and effective stiffness.

Cells of sheets in space bend across their border as well, and their mean strain may be free
(:mod:`kirigami.model.periodic`); what they make of a sheet is in :mod:`kirigami.lattice.law`, and their waves in
:mod:`kirigami.lattice.waves`.
"""

from __future__ import annotations

import copy
import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kirigami.deferred import deferred
from kirigami.elements.seams import CellBorder
from kirigami.errors import MechanismError, ModelError
from kirigami.geometry.border import repeated_border
from kirigami.model.constraints import Fix, Tie
from kirigami.model.model import Model
from kirigami.model.periodic import NAMES, Periodic
from kirigami.primitives.checks import (
    require_array,
    require_boolean,
    require_finite,
    require_instance,
    require_items,
    require_whole_array,
)
from kirigami.primitives.groups import first_of_group
from kirigami.primitives.kernel import Array
from kirigami.primitives.node import AXES
from kirigami.results.results import Results
from kirigami.results.step import Step
from kirigami.words import counted

if TYPE_CHECKING:
    from kirigami.geometry.mesh import TriMesh

VOIGT = {1: [(0, 0)], 2: [(0, 0), (1, 1), (0, 1)], 3: [(0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1)]}


class PeriodicCell:
    """One cell of a periodic model: which nodes repeat which others.

    Parameters
    ----------
    model : Model
        A model of one cell, with nodes on both sides of its border. What lies on the border is to be modelled once,
        but in models that were made from a mesh, such as that of a :class:`kirigami.CellSheet`.
    lattice : array_like, shape (m, dim) or (m, 2)
        Lattice vectors, one a row [length]: one, two, or in 3D three. Two make a sheet, one makes a strip, both free to
        move in z.
    images : array_like of int, shape (k, 2 + m), optional
        Rows (node, node it repeats, steps along each lattice vector), as in ``Tiling.images``; None finds the pairs by
        the edges on the border of a mesh, else by positions.

    Attributes
    ----------
    images : ndarray of int, shape (k, 2 + m)
        The pairs; every repeated node is one that repeats none itself.

    Raises
    ------
    ModelError
        Lattice vectors that depend on each other, images that are not where the lattice puts them, or none at all.
    GeometryError
        Opposite sides of a mesh that do not have the same nodes.

    Examples
    --------
    >>> import kirigami as kg
    >>> squares = kg.tilings.rotating_squares(angle=0.6)
    >>> m = squares.model(EA=1e4, stiffness=1.0)
    >>> cell = kg.PeriodicCell(m, squares.lattice, squares.images)
    >>> stiffness = cell.stiffness()
    >>> poisson = stiffness[0, 1] / stiffness[0, 0]      # a soft dilation and a stiff rest: -1 with rigid squares
    >>> bool(-1 < poisson < -0.99)
    True

    A cell of an uncut sheet, pulled along y and free to contract:

    >>> sheet = kg.CellSheet([(1, 0), (0, 1)], thickness=0.01, material=kg.Material(E=1e6, nu=0.3))
    >>> cell = kg.PeriodicCell(kg.Model.from_mesh(sheet.mesh(0.4), stiffness="shell"), sheet.lattice)
    >>> imposed = cell.impose((None, 1e-6, None))
    >>> law = cell.law(kg.LinearStatic(cell.model).run())
    >>> round(float(law.poisson[-1]), 9), round(float(law.stress[-1, 1]), 9)  # nu and E t times the strain
    (0.3, 0.01)
    """

    def __init__(self, model: Model, lattice: ArrayLike, images: ArrayLike | None = None) -> None:
        self.model = require_instance(model, Model, "model", "PeriodicCell")
        self.dim = model.dim
        given = np.atleast_2d(require_array(lattice, name="lattice", owner="PeriodicCell"))
        if given.ndim != 2 or given.shape[1] > self.dim or not 1 <= len(given) <= self.dim:
            raise ModelError(
                f"PeriodicCell: lattice must hold up to {counted(self.dim, 'vector')}, one a row, got {given.shape}"
            )
        self.lattice = np.zeros((len(given), self.dim))
        self.lattice[:, : given.shape[1]] = given
        self.measure = math.sqrt(abs(np.linalg.det(self.lattice @ self.lattice.T)))
        if not self.measure > 1e-9 * np.prod(np.linalg.norm(self.lattice, axis=1)):
            raise ModelError("PeriodicCell: the lattice vectors must not depend on each other")
        self._axes = _strained_axes(self.lattice)
        position = model.positions()[:, : self.dim]
        self._near = 1e-6 * float(np.linalg.norm(self.lattice, axis=1).max())
        self.border: CellBorder | None = None  # of a sheet in space, which bends across it
        if images is not None:
            self.images = _checked_images(images, len(given), len(position))
        elif model.mesh is not None and model.sheet_constants is not None:
            self.images = self._of_mesh(model.mesh)
        else:
            self.images = self._found(position)
        if self.images.ndim != 2 or self.images.shape[1] != 2 + len(given) or not len(self.images):
            raise ModelError("PeriodicCell: no node repeats another one; are the lattice vectors right?")
        off = position[self.images[:, 0]] - position[self.images[:, 1]] - self.shift_vectors
        worst = int(np.argmax(np.linalg.norm(off, axis=1)))
        if np.linalg.norm(off[worst]) > self._near:
            node, leader = (model.nodes[k] for k in self.images[worst, :2])
            raise ModelError(
                f"PeriodicCell: {node!r} is not where the lattice puts the image of {leader!r}; a cell is perturbed by "
                "a shape that repeats"
            )

    @property
    def shift_vectors(self) -> Array:
        """Lattice vector (k, dim) between each image and what it repeats."""
        vectors: Array = self.images[:, 2:] @ self.lattice
        return vectors

    def _of_mesh(self, mesh: TriMesh) -> NDArray[np.int64]:
        """Pairs of nodes by the edges on the border of a sheet."""
        vectors = np.zeros((len(self.lattice), 3))
        vectors[:, : self.dim] = self.lattice
        if len(vectors) > 2 or vectors[:, 2].any():
            raise ModelError("PeriodicCell: a sheet repeats along one or two vectors in the plane z = 0")
        images, edges = repeated_border(mesh, vectors)
        if self.dim == 3:
            self.border = CellBorder(images, edges, vectors)
        return images

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
                f"PeriodicCell: the mean strain must be a gradient ({self.dim}, {self.dim}) or "
                f"{counted(len(pairs), 'strain')}, "
                f"got shape {given.shape}"
            )
        full = np.zeros((self.dim, self.dim))
        for (a, b), value in zip(pairs, given):
            full[a, b] = full[b, a] = value if a == b else value / 2
        return full

    def _pairs(self) -> list[tuple[int, int]]:
        return [(self._axes[a], self._axes[b]) for a, b in VOIGT[len(self._axes)]]

    def impose(
        self, strain: ArrayLike | Sequence[float | None], constant: bool = False, hold: bool = True
    ) -> tuple[Any, ...]:
        """Add to the model what repeats the cell, with a mean strain at load factor 1, and hold one node.

        Parameters
        ----------
        strain : sequence of float or None, or array_like, shape (3,) for a sheet, (6,) in space, (1,) for a strip
            Small strains in the order of :meth:`stiffness`, or the mean displacement gradient H, (dim, dim). Only
            ``H @ R`` of lattice vectors R enters. None leaves a strain of a sheet in space free, so that the mean
            stress along it vanishes; what such sheets are given is (1 + E), however large, without mean rotation.
        constant : bool
            The strain acts in full whatever the load factor.
        hold : bool
            Whether a node is held, which stops the motions of the whole and bears nothing. False is for modes and
            motions, where it would bear the forces of inertia.

        Returns
        -------
        tuple
            The objects added: of a sheet in space one constraint, else ties, and the Fix of a node that none repeats.

        Raises
        ------
        ModelError
            A strain of a wrong shape, that is not finite, or that is free where the cell is no sheet in space.
        """
        constant = require_boolean(constant, "constant", "PeriodicCell.impose")
        hold = require_boolean(hold, "hold", "PeriodicCell.impose")
        if self.border is not None:
            item = self._constraint(self._strains(strain), constant, hold)
            self.model.add(item)
            return (item,)
        gradient = self.gradient(strain)  # type: ignore[arg-type]
        difference = self.shift_vectors @ gradient.T
        nodes = self.model.nodes
        dofs = AXES[: self.dim]
        tie = Tie(
            [nodes[k] for k in self.images[:, 0]], [nodes[k] for k in self.images[:, 1]], dofs,
            **{axis: difference[:, number] for number, axis in enumerate(dofs)}, constant=constant,
        )  # fmt: skip
        held = [Fix(nodes[int(self.images[0, 1])], dofs)] if hold else []
        self.model.add(tie, *held)
        return (tie, *held)

    def _strains(self, strain: Any) -> list[float | None]:
        """The strains of a sheet in space, None where they are free."""
        names = NAMES[2 * len(self.lattice) - 1]
        items = require_items(strain, "strain", "PeriodicCell.impose")
        if len(items) == len(names) and any(value is None for value in items):
            return [None if v is None else require_finite(v, f"strain {n}", "PeriodicCell.impose")
                    for v, n in zip(items, names)]  # fmt: skip
        H = require_array(strain, (len(names),), (3, 3), name="strain", owner="PeriodicCell.impose")
        if H.ndim == 1:
            return list(H)
        size = np.abs(H).max(initial=0.0)
        if np.abs(H - H.T).max() > 1e-12 * size or H[2].any():
            raise ModelError(
                "PeriodicCell.impose: the mean gradient of a sheet in space must be symmetric and in its plane: a "
                "rotation costs nothing"
            )
        return [H[0, 0], H[1, 1], 2 * H[0, 1]] if len(names) == 3 else [H[self._axes[0], self._axes[0]]]

    def _constraint(self, strain: Sequence[float | None], constant: bool = False, hold: bool = True) -> Periodic:
        """What :meth:`impose` adds to the model of a sheet in space; `hold` stops the motions of the whole."""
        assert self.border is not None
        nodes = self.model.nodes
        images, leaders = ([nodes[k] for k in self.images[:, column]] for column in (0, 1))
        held = self._held() if hold else np.empty((0, 2), np.int64)
        return Periodic(images, leaders, self.border, strain, held, constant)

    def _held(self) -> NDArray[np.int64]:
        """Nodes and axes that stop the motions of the whole, as far as no support of the model does."""
        supports = [item for item in self.model.constraints if not item.leaders]
        assert self.model.mesh is not None
        position = self.model.positions()[: len(self.model.mesh.nodes)]
        inside = np.setdiff1d(np.arange(len(position)), self.images[:, :2])  # however nodes are numbered
        own = inside if inside.size else np.setdiff1d(np.arange(len(position)), self.images[:, 0])
        first = own[int(np.argmin(np.linalg.norm(position[own] - position.mean(axis=0), axis=1)))]
        held = [(first, axis) for axis in range(3) if not any(AXES[axis] in item.values for item in supports)]
        if len(self.lattice) == 1 and (first, 2) in held:  # a strip may turn about its own axis
            leaders = np.setdiff1d(np.arange(len(position)), self.images[:, 0])
            across = np.linalg.norm(np.cross(position[leaders] - position[first], self.lattice[0]), axis=1)
            held.append((leaders[int(np.argmax(across))], 2))
        return np.array(held, dtype=np.int64).reshape(-1, 2)

    def mean_stress(self, results: Results) -> Array:
        """Mean nominal stress (s, dim, dim) of each step: derivative of the energy by the mean displacement gradient.

        Component (i, j) is the force along i on the face whose normal was j, over the undeformed measure of that
        face: [force / length] for a sheet or planar model.
        """
        require_instance(results, Results, "results", "PeriodicCell.mean_stress")
        if results.rest.shape != (len(self.model.nodes), 3):
            raise ModelError("PeriodicCell.mean_stress: these results belong to another model")
        if self.border is not None:
            return self._plane_tensors(self.law(results).stress)
        force = np.stack([results.reaction([int(k)]) for k in self.images[:, 0]], axis=1)[..., : self.dim]
        stress: Array = np.einsum("ski,kj->sij", force, self.shift_vectors) / self.measure
        return stress

    def _plane_tensors(self, values: Array) -> Array:
        """Tensors (s, 3, 3) of forces per length (s, 3) in the plane, or of the one along a strip."""
        found = np.zeros((len(values), 3, 3))
        for (a, b), value in zip(self._pairs(), values.T):
            found[:, a, b] = found[:, b, a] = value
        return found

    law = deferred("kirigami.lattice.law:law")
    patch = deferred("kirigami.lattice.patch:patch")
    section = deferred("kirigami.lattice.law:section")
    waves = deferred("kirigami.lattice.waves:waves")
    buckling = deferred("kirigami.lattice.waves:buckling")

    # ---- linear: effective stiffness

    def stiffness(self, u: ArrayLike | Step | None = None) -> Array:
        """Effective stiffness of the cell.

        Second derivative of the energy per measure of the cell by the mean strain, all else relaxed and periodic.

        Parameters
        ----------
        u : Step or array_like, shape (n, 3), optional
            Step, or displacements, about which it is taken, an equilibrium without mean rotation; None is the rest
            state.

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
        if self.border is not None:
            from kirigami.lattice.law import tangent

            return tangent(self, u)
        from scipy.sparse import csc_matrix

        from kirigami.system.system import System

        if isinstance(u, Step):
            u = u.u
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
            f"PeriodicCell: {counted(len(lattice), 'lattice vector')} must span as many coordinate axes, not "
            f"{len(used)}"
        )
    return used
