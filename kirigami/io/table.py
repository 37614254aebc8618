"""Results as tables: an xarray.Dataset (and so NetCDF), and a CSV file of the curves."""

from __future__ import annotations

import csv
import json
import os
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from kirigami.errors import AnalysisError
from kirigami.files import library, whole_file
from kirigami.primitives.checks import require_mapping, require_path
from kirigami.primitives.kernel import Array
from kirigami.primitives.node import AXES, Node
from kirigami.results.results import Results

Nodes = Node | int | Iterable[Node | int]


def curves(results: Results, reactions: Mapping[str, Nodes] | None = None) -> dict[str, Array]:
    """What is one number per step, by name.

    Parameters
    ----------
    results : Results
        The results.
    reactions : mapping of str to nodes, optional
        Supports whose reaction is wanted, by the name to give it. None takes those that were driven in the run
        (``Prescribe``), named ``driven_0`` and on, along the axes they drive.

    Returns
    -------
    dict of str to ndarray, shape (s,)
        ``load_factor``; of :func:`kirigami.stretch` what was moved and what it takes, such as ``strain`` and ``force``,
        ``twist`` [degrees] and ``torque``, ``lift_centre`` and ``force_centre``; ``stable`` (1, 0, or nan where not
        counted), ``residual``, ``height`` (largest less smallest z) in 3D, ``energy_KIND`` for each kind of element,
        ``reaction_NAME_AXIS``, and ``open_area`` (sum over the cuts) where the mesh has cuts.

    Raises
    ------
    ModelError
        A selection of nodes is empty or not of this model.

    Examples
    --------
    >>> from kirigami.io.table import curves
    >>> import kirigami as kg
    >>> m = kg.Model(dim=2)
    >>> a, b, c = m.add(kg.Node(0, 0), kg.Node(1, 0), kg.Node(2, 0))
    >>> bars = m.add(kg.Bar(a, b, EA=10.0), kg.Bar(b, c, EA=10.0))
    >>> held = m.add(kg.Fix(a), kg.Fix([b, c], "y"), kg.Prescribe(c, x=0.2))
    >>> found = curves(kg.LinearStatic(m).run())
    >>> list(found)
    ['load_factor', 'stable', 'residual', 'energy_bars', 'reaction_driven_0_x']
    >>> found["reaction_driven_0_x"].round(12).tolist()
    [0.0, 1.0]
    """
    found = {"time": results.time} if results.moves else {}
    found |= {"load_factor": results.lam}
    for drive in results.drives:
        found |= {drive.column: drive.travel(results), drive.response: drive.force(results)}
    found |= {
        "stable": np.array([np.nan if step.negative is None else float(step.stable) for step in results.steps]),
        "residual": results.residual,
    }
    if results.dim == 3:
        found["height"] = results.height()
    found |= {f"energy_{kind}": values for kind, values in results.energy.items()}
    if reactions is not None:
        named = require_mapping(reactions, "reactions", "curves")
        wanted = [(name, nodes, AXES[: results.dim]) for name, nodes in named.items()]
    else:
        wanted = [(support.name, support.nodes, support.dofs) for support in results.supports if support.driven]
    for name, nodes, axes in wanted:
        found |= {f"reaction_{name}_{axis}": results.reaction(nodes, axis) for axis in axes}
    if results.mesh is not None and results.mesh.cuts:
        found["open_area"] = results.open_area().sum(axis=1)
    return found


def to_csv(
    results: Results, path: str | os.PathLike[str], reactions: Mapping[str, Nodes] | None = None
) -> Path:
    """Write the curves, one row per step, every digit kept.

    Parameters
    ----------
    results : Results
        The results.
    path : path
        The file.
    reactions : mapping of str to nodes, optional
        As for :func:`curves`, which lists the columns.

    Raises
    ------
    AnalysisError
        There are no steps.
    KirigamiError
        The file cannot be written.

    Examples
    --------
    >>> from pathlib import Path
    >>> from kirigami.io.table import to_csv
    >>> import tempfile, kirigami as kg
    >>> m = kg.Model(dim=2)
    >>> a, b = m.add(kg.Node(0, 0), kg.Node(2, 0))
    >>> objects = m.add(kg.Bar(a, b, EA=10.0), kg.Fix(a), kg.Fix(b, "y"), kg.NodalLoad(b, (1, 0)))
    >>> file = to_csv(kg.LinearStatic(m).run(), Path(tempfile.mkdtemp()) / "curves.csv", {"left": a})
    >>> file.read_text().splitlines()[0]
    'step,load_factor,stable,residual,energy_bars,reaction_left_x,reaction_left_y'
    """
    target = require_path(path, "path", "to_csv")
    if not len(results):
        raise AnalysisError("there are no steps to write", results=results)
    columns = curves(results, reactions)
    with whole_file(target) as unfinished, open(unfinished, "w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(["step", *columns])
        for index, row in enumerate(zip(*(values.tolist() for values in columns.values()))):
            writer.writerow([index, *row])
    return target


def to_xarray(results: Results) -> Any:
    """The results as an xarray.Dataset with named dimensions, ready for ``to_netcdf``.

    Dimensions: ``step``, ``node``, ``axis``, and where they exist ``bar``, ``hinge``, ``spring``, ``facet``, ``cut``.
    ``load_factor`` is a coordinate of ``step``. Events and name are attributes.

    Parameters
    ----------
    results : Results
        The results.

    Raises
    ------
    KirigamiError
        xarray is not installed.

    Examples
    --------
    >>> from kirigami.io.table import to_xarray
    >>> import kirigami as kg
    >>> m = kg.Model(dim=2)
    >>> a, b = m.add(kg.Node(0, 0), kg.Node(2, 0))
    >>> objects = m.add(kg.Bar(a, b, EA=10.0), kg.Fix(a), kg.Fix(b, "y"), kg.NodalLoad(b, (1, 0)))
    >>> data = to_xarray(kg.LinearStatic(m).run())
    >>> round(float(data.displacement.sel(node=1, axis="x")[-1]), 12)
    0.2
    """
    xarray = library("xarray", "making an xarray.Dataset")
    variables: dict[str, Any] = {
        "rest": (("node", "axis"), results.rest),
        "displacement": (("step", "node", "axis"), results.u),
        "stable": ("step", results.stable),
        "residual": ("step", results.residual),
        "iterations": ("step", np.array([step.iterations for step in results.steps], dtype=np.int64)),
    }
    if len(results):
        variables["gradient"] = (
            ("step", "node", "axis"),
            results._gradients,
            {"long_name": "gradient of the potential: support reactions at held displacements, about zero elsewhere"},
        )
    variables |= {f"energy_{kind}": ("step", values) for kind, values in results.energy.items()}
    kinds = {kernel.name for kernel in results.kernels}
    if "bars" in kinds:
        variables["bar_strain"] = (("step", "bar"), results.bar_strain)
        variables["bar_force"] = (("step", "bar"), results.bar_force)
    if "hinges" in kinds:
        variables["hinge_angle"] = (("step", "hinge"), results.hinge_angle)
        variables["hinge_moment"] = (("step", "hinge"), results.hinge_moment)
    if "springs" in kinds:
        variables["spring_angle"] = (("step", "spring"), results.spring_angle)
        variables["spring_moment"] = (("step", "spring"), results.spring_moment)
    if results.mesh is not None:
        variables["triangles"] = (("facet", "corner"), results.mesh.triangles)
        if results.mesh.cuts and len(results):
            variables["open_area"] = (("step", "cut"), results.open_area())
    coordinates: dict[str, Any] = {
        "step": np.arange(len(results)),
        "load_factor": ("step", results.lam),
        "node": np.arange(len(results.rest)),
        "axis": list(AXES),
    }
    if results.moves:
        coordinates["time"] = ("step", results.time)
        variables["velocity"] = (("step", "node", "axis"), results.velocity)
    events = [{"kind": event.kind, "load_factor": event.lam, "message": event.message} for event in results.events]
    attributes = {"name": results.name, "dim": results.dim, "events": json.dumps(events)}
    return xarray.Dataset(variables, coordinates, attributes)
