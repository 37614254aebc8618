"""A periodic cell of a sheet in space as a constraint: its border repeats, up to a mean strain that is given or free.

Of two nodes a lattice vector R apart, u_image - u_source = E R, with E the mean strain of the infinite sheet in its
plane: the deformation is x = (1 + E) X + a part that repeats, without mean rotation. So the sheet may bend and buckle
with the period of the cell, and its mean plane stays flat. What repeats is eliminated, and E is a row of unknowns of
its own (:mod:`kirigami.primitives.cell_rows`); its components are driven, held or free, and what is free is free of
mean stress.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from kirigami.elements.seams import CellBorder, seam_kernels
from kirigami.errors import ModelError
from kirigami.model.constraints import Constraint
from kirigami.primitives.cell_rows import CellRows
from kirigami.primitives.checks import require_finite
from kirigami.primitives.kernel import Array, Kernel
from kirigami.primitives.node import Node
from kirigami.primitives.parts import Numbering
from kirigami.words import counted

Index = NDArray[np.int64]
NEAR = 1e-6  # of the lattice vectors, within which places are the same
NAMES = {1: ("e",), 3: ("exx", "eyy", "gxy")}


class Periodic(Constraint):
    """Repeats a cell of a sheet; :meth:`kirigami.PeriodicCell.impose` makes it.

    Parameters
    ----------
    images, leaders : sequence of Node
        Nodes on the border that repeat others, and these.
    border : CellBorder
        The same by number, with steps and edges.
    strain : sequence of float or None
        Mean strain at load factor 1: (exx, eyy, gxy) of a sheet, (e,) along the lattice vector of a strip; None is
        free.
    held : ndarray of int, shape (h, 2)
        Nodes and axes that are held, to stop the motions of the whole.
    constant : bool
        Holds the strain at full size whatever the load factor.
    """

    __slots__ = ("border", "held_dofs", "strain")
    border: CellBorder
    held_dofs: Index
    strain: tuple[float | None, ...]

    def __init__(
        self,
        images: Sequence[Node],
        leaders: Sequence[Node],
        border: CellBorder,
        strain: Sequence[float | None],
        held: Index,
        constant: bool = False,
    ) -> None:
        super().__init__(tuple(images), {}, constant=constant, leaders=tuple(leaders))
        names = NAMES[2 * len(border.lattice) - 1]
        values = tuple(
            None if value is None else require_finite(value, f"strain {name}", "PeriodicCell.impose")
            for name, value in zip(names, strain)
        )
        for name, value in (("border", border), ("strain", values), ("held_dofs", held)):
            object.__setattr__(self, name, value)

    @property
    def drives(self) -> bool:
        return not self.constant and any(self.strain)

    def held(self, lam: float) -> Constraint:
        """The same, constant at load factor `lam`."""
        lam = require_finite(lam, "lam", "Periodic.held")
        if not self.drives:
            return self
        strain = [None if value is None else lam * value for value in self.strain]
        return Periodic(self.group, self.leaders, self.border, strain, self.held_dofs, constant=True)

    def known(self, rows: CellRows, dim: int) -> tuple[Index, Array]:
        """Numbers of the displacements that are held or driven, and their values at load factor 1."""
        given = np.array([value is not None for value in self.strain])
        values = np.array([rows.scale * value for value in self.strain if value is not None])
        at = rows.strain * dim + np.flatnonzero(given)
        held = self.held_dofs[:, 0] * dim + self.held_dofs[:, 1]
        return np.concatenate([at, held]), np.concatenate([values, np.zeros(len(held))])

    # ---- rows and members

    @classmethod
    def reserve(cls, objects: Sequence[Periodic], numbering: Numbering) -> None:
        for item in objects:
            numbering.grips[id(item)] = item._rows(numbering)

    @classmethod
    def lower(cls, objects: Sequence[Periodic], numbering: Numbering) -> list[Kernel]:
        """The members that bend across the border."""
        item = objects[0]
        rows = numbering.grips[id(item)]
        assert isinstance(rows, CellRows)
        others = [other for group in numbering.objects.values() for other in group]
        if numbering.edges is None and any(other.clamp for other in others):
            raise ModelError(
                "a clamp does not go with a periodic cell of bars and hinges or of flat facets: take stiffness='shell'"
            )
        if any(each.yields for each in numbering.sheet.materials) and numbering.edges is None:
            raise ModelError(
                "PeriodicCell: hinges across the border of a cell do not yield: take stiffness='shell', or give the "
                "material hardening=None"
            )
        return seam_kernels(item.border, rows.beyond, numbering)

    def _rows(self, numbering: Numbering) -> CellRows:
        border = self.border
        vectors = border.lattice
        scale = float(np.linalg.norm(vectors, axis=1).mean())
        repeats, sources, steps = border.images[:, 0], border.images[:, 1], border.images[:, 2:]
        off = np.linalg.norm(numbering.rest[repeats] - numbering.rest[sources] - steps @ vectors, axis=1)
        if off.max() > NEAR * scale:
            worst = int(off.argmax())
            raise ModelError(
                f"the cell at rest does not repeat: {numbering.describe(int(repeats[worst]))} is {off[worst]:.3g} from "
                f"where {numbering.describe(int(sources[worst]))} is repeated; perturb a cell by a shape that repeats, "
                "as imperfect() does"
            )
        on_border = len(repeats)
        beyond = np.empty((0, 2), np.int64)
        behind = [np.empty(0, np.int64)] * 2
        behind_steps = np.empty((0, len(vectors)), np.int64)
        if numbering.edges is None and numbering.dim == 3:
            beyond, more, more_steps = self._copies(numbering)
            repeats = np.concatenate([repeats, beyond.ravel()])
            sources, steps = np.concatenate([sources, more]), np.concatenate([steps, more_steps])
        elif numbering.edges is not None:
            edges = numbering.edges
            image, source = edges.seams.T
            angle = edges.seam_angles
            behind = [np.concatenate([edges.middle[one], angle[:, k]]) for k, one in enumerate((image, source))]
            behind_steps = np.tile(border.edges[:, 4:], (2, 1))
        idle = np.zeros((1, 3), dtype=bool)
        idle[0, len(self.strain):] = True
        row = int(numbering.add_rows(np.zeros((1, 3)), np.array([np.inf]), idle)[0])
        return CellRows(
            np.concatenate([repeats, behind[0]]),
            np.concatenate([sources, behind[1]]),
            _slopes(steps @ vectors, len(self.strain)) / scale,
            row,
            scale,
            on_border,
            steps @ vectors,
            np.concatenate([steps, behind_steps]),
            beyond,
        )

    def _copies(self, numbering: Numbering) -> tuple[Index, Index, Index]:
        """New rows (s, 2) for the far corners beyond the edges on the border; what each repeats, in how many steps."""
        mesh, border = numbering.mesh, self.border
        seams = border.numbers(mesh.edges)
        wings = mesh.edge_wings[seams[:, ::-1], 0]  # beyond an edge lies a copy of the facet at the other one
        across = np.stack([border.edges[:, 4:], -border.edges[:, 4:]], axis=1).reshape(-1, len(border.lattice))
        leader, own = border.lead(wings.ravel(), numbering.points)
        rest = numbering.rest[wings.ravel()] + across @ border.lattice
        reach = np.repeat(mesh.edge_lengths[seams[:, 0]], 2)
        return numbering.add_rows(rest, reach).reshape(-1, 2), leader, own + across

    def __repr__(self) -> str:
        names = NAMES[len(self.strain)]
        said = ", ".join(f"{n}={'free' if v is None else format(v, 'g')}" for n, v in zip(names, self.strain))
        return f"Periodic({counted(len(self.group), 'node')}, {said})"


def _slopes(vectors: Array, strains: int) -> Array:
    """Derivatives (k, 3, 3) of the displacement E R of lattice vectors (k, 3) by the strains (exx, eyy, gxy), or by the
    one strain along the vector of a strip."""
    found = np.zeros((len(vectors), 3, 3))
    if strains == 1:
        found[:, :, 0] = vectors
        return found
    x, y, _ = vectors.T
    found[:, 0, 0], found[:, 1, 1] = x, y
    found[:, 0, 2], found[:, 1, 2] = 0.5 * y, 0.5 * x
    return found
