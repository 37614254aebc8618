"""Branches: the final shapes that a structure can end in, found by seeding its eigenmodes."""

from __future__ import annotations

import os
from collections.abc import Sequence
from concurrent.futures import Executor

import numpy as np
from numpy.typing import ArrayLike

from kirigami.analysis.modes import Mode
from kirigami.analysis.path.methods import DisplacementControl
from kirigami.model.model import Model
from kirigami.primitives.checks import require_instance
from kirigami.study.imperfect import SHARE
from kirigami.study.imperfections import Build, ImperfectionStudy, imperfections


def branches(
    model: Model,
    modes: int | Sequence[Mode | ArrayLike] = 6,
    amplitude: float | None = None,
    analysis: Build = DisplacementControl,
    mirrors: str = "xy",
    alike: float = 0.2,
    folder: str | os.PathLike[str] | None = None,
    executor: Executor | None = None,
) -> ImperfectionStudy:
    """Find the final shapes of a structure: seed each eigenmode with both signs, run to the end, sort what comes out.

    An :func:`imperfections` study with one amplitude; see there for the arguments.

    Parameters
    ----------
    model : Model
        Without imperfection; it is not changed.
    modes : int or sequence of shapes
        Shapes to seed.
    amplitude : float, optional
        Largest offset [length]; by default that of :meth:`kirigami.Model.imperfect`.
    analysis : callable
        Makes the analysis of a model.
    mirrors : str
        Axes along which final shapes may be reflected and still count as the same.
    alike : float
        Relative distance below which two final shapes are the same.
    folder : path, optional
        Keeps every run, so that the study can go on.
    executor : concurrent.futures.Executor, optional
        Does the runs.

    Returns
    -------
    ImperfectionStudy
        ``study.branches`` maps the number of each final shape, in the order of energy, to the imperfections that lead
        to it; ``print(study)`` tells it, ``study.plot()`` shows it.

    Raises
    ------
    ModelError
        Amplitude or shapes that cannot be used.

    Examples
    --------
    A square plate on simple supports that is squeezed:

    >>> import numpy as np
    >>> import kirigami as kg
    >>> x, y = np.meshgrid(np.linspace(0, 1, 5), np.linspace(0, 1, 5))
    >>> corners = [5 * row + column for row in range(4) for column in range(4)]
    >>> facets = [t for a in corners for t in ((a, a + 1, a + 6), (a, a + 6, a + 5))]
    >>> mesh = kg.TriMesh(np.column_stack([x.ravel(), y.ravel()]), facets)
    >>> m = kg.Model.from_mesh(mesh, thickness=0.005, material=kg.Material(E=1e6, nu=1 / 3))
    >>> bottom, top = m.select(boundary="bottom"), m.select(boundary="top")
    >>> held = m.add(kg.Fix(m.select(boundary="outer"), "z"), kg.Fix(bottom, "xy"), kg.Fix(top, "x"))
    >>> squeeze = m.add(kg.Prescribe(top, y=-2e-4))
    >>> study = kg.study.branches(m, modes=1)
    >>> [case.branch for case in study.cases]
    [1, 1]
    """
    require_instance(model, Model, "model", "branches")
    amplitudes = None if amplitude is None else [amplitude]
    if amplitudes is None and model.sheet_constants is not None:
        amplitudes = [SHARE * float(np.min(model.sheet_constants.thickness))]
    return imperfections(model, modes, amplitudes, analysis, (1, -1), mirrors, alike, folder, executor)
