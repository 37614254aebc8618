"""A piece of the infinite sheet to look at: many cells in the shape that one was found in, or in a wave over them."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from kirigami.errors import KirigamiWarning, ModelError
from kirigami.geometry.border import tiled
from kirigami.lattice.cell_system import require_sheet
from kirigami.lattice.waves import BlochBuckling
from kirigami.model.model import Model
from kirigami.primitives.checks import require_instance, require_items, require_positive, require_whole
from kirigami.primitives.kernel import Array
from kirigami.results.results import Results
from kirigami.results.step import Step
from kirigami.system.system import System
from kirigami.words import counted

if TYPE_CHECKING:
    from kirigami.lattice.periodic import PeriodicCell

MOST = 10_000  # cells


def patch(
    cell: PeriodicCell, of: Results | BlochBuckling, counts: Sequence[int], height: float | None = None
) -> Results:
    """A piece of the infinite sheet, to be looked at as any results are.

    Parameters
    ----------
    of : Results or BlochBuckling
        Of this cell: all of the steps, or the wave in which it buckles, about the flat sheet.
    counts : sequence of int, shape (m,)
        Cells along each lattice vector.
    height : float, optional
        Largest displacement of a wave [length]; None is a twentieth of the lattice vectors. Not used for results.

    Returns
    -------
    Results
        Positions of the nodes of a sheet of so many cells, with the stress and energy that belong to them on its rung;
        how shells bend between the nodes is guessed, as in ``Step.at``. Its rim is no free edge. Not equilibria of that
        sheet with supports of its own.

    Raises
    ------
    ModelError
        The cell is no sheet in space, counts are not whole numbers from 1, or what is given belongs to another model.

    Examples
    --------
    >>> import kirigami as kg
    >>> sheet = kg.CellSheet([(1, 0), (0, 1)], thickness=0.01, material=kg.Material(E=1e6, nu=0.3))
    >>> cell = kg.PeriodicCell(kg.Model.from_mesh(sheet.mesh(0.4), stiffness="shell"), sheet.lattice)
    >>> imposed = cell.impose((0.1, None, None))
    >>> many = cell.patch(kg.LinearStatic(cell.model).run(), (3, 2))
    >>> round(float(many.position()[-1, :, 0].max() - many.position()[-1, :, 0].min()), 9)
    3.3
    """
    require_sheet(cell, "patch")
    assert cell.border is not None and cell.model.mesh is not None
    numbers = [require_whole(v, "counts", "PeriodicCell.patch", least=1)
               for v in require_items(counts, "counts", "PeriodicCell.patch")]  # fmt: skip
    if len(numbers) != len(cell.lattice) or np.prod(numbers) > MOST:
        raise ModelError(
            f"PeriodicCell.patch: counts must be {counted(len(cell.lattice), 'number')}, one for each lattice vector, "
            f"of at most {MOST} cells, got {numbers}"
        )
    tall = None if height is None else require_positive(height, "height", "PeriodicCell.patch")
    mesh, node, steps = tiled(cell.model.mesh, cell.images, cell.border.lattice, numbers)
    constants = cell.model.sheet_constants
    assert constants is not None
    copies = len(mesh.triangles) // len(cell.model.mesh.triangles)
    one = len(cell.model.mesh.triangles)
    number, materials = constants.material_of_facets(one)
    thickness = np.tile(constants.thickness_of_facets(one), copies)
    material = [materials[k] for k in number.tolist()] * copies
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", KirigamiWarning)  # of the mesh, which the cell has told of
        rung = constants.calibration if constants.rung == "calibration" else constants.rung
        model = Model.from_mesh(mesh, thickness, material, rung)
    found = Results(System(model))
    for lam, u in _shapes(cell, of, node, steps, tall):
        found.append(Step.at(model, lam, u))
    return found


def _shapes(
    cell: PeriodicCell, of: Results | BlochBuckling, node: np.ndarray, steps: np.ndarray, height: float | None
) -> list[tuple[float, Array]]:
    """Load factors and displacements (n, 3) of the nodes of the patch."""
    lattice = cell.lattice
    away = steps @ lattice
    if isinstance(of, BlochBuckling):
        tall = 0.05 * float(np.linalg.norm(lattice, axis=1).mean()) if height is None else height
        turn = np.exp(1j * (steps @ of.phases))
        wave = (of.shape[node] * turn[:, None]).real
        return [(0.0, np.zeros_like(wave)), (of.factor, tall * wave / (np.abs(wave).max() or 1.0))]
    results = require_instance(of, Results, "of", "PeriodicCell.patch")
    strain = cell._plane_tensors(cell.law(results).strain * ([1.0, 1.0, 0.5] if len(lattice) == 2 else 1.0))
    return [(step.lam, step.u[node] + away @ mean) for step, mean in zip(results.steps, strain)]
