"""A design for the cutter and for the command line."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING

from kirigami.errors import ModelError
from kirigami.files import make_folder
from kirigami.primitives.checks import require_path, require_positive
from kirigami.primitives.material import Material
from kirigami.study.job import Job

if TYPE_CHECKING:
    from kirigami.design.design import Design


def export(design: Design, folder: str | os.PathLike[str], finer: float = 2.0) -> Path:
    """Write the sheet and what is done to it: ``sheet.dxf`` and ``case.json``, all lengths in metres.

    ``kirigami stretch case.json`` reads the drawing, meshes it anew and walks it again.

    Parameters
    ----------
    folder : path
        Where to; made if it is missing.
    finer : float
        How many times shorter the edges of that mesh are than those of the design.

    Returns
    -------
    Path
        The case file.

    Raises
    ------
    ModelError
        The supports are no :class:`LoadCase`, or the material is none that a case file keeps.

    Examples
    --------
    >>> import shapely, tempfile, kirigami as kg
    >>> design = kg.Design((), outline=shapely.box(0, 0, 0.05, 0.1), supports=kg.LoadCase(strain=0.001),
    ...                    thickness=(1e-4, 5e-5, 2e-4), material=kg.Material(3.5e9, 0.3), mesh={"max_edge": 0.025})
    >>> case = design.export(tempfile.mkdtemp())
    >>> sorted(file.name for file in case.parent.iterdir())
    ['case.json', 'sheet.dxf']
    >>> kg.study.Job.load(case).max_edge
    0.0125
    """
    factor = require_positive(finer, "finer", "Design.export")
    if design.case is None:
        raise ModelError("Design.export: a case file keeps a LoadCase: give one as supports=LoadCase(...)")
    sheet = design.sheet()
    if not isinstance(sheet.material, Material) or sheet.thickness is None:
        raise ModelError("Design.export: a case file keeps a thickness and a Material, with E and nu")
    target = require_path(folder, "folder", "Design.export")
    make_folder(target)
    longest = design.mesh_settings.get("max_edge")
    return Job(
        sheet.to_dxf(target / "sheet.dxf"), float(sheet.thickness), sheet.material.E, sheet.material.nu, design.case,
        nodes=None if longest else int(design.mesh_settings.get("nodes", 1000) * factor**2),
        max_edge=longest / factor if longest else None, stiffness=design.stiffness, imperfection=design._amplitude,
        seed=design._seed,
    ).save(target / "case.json")  # fmt: skip
