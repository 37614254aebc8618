"""Results files: one compressed numpy archive with a JSON head; no code is stored and none is run on reading."""

from __future__ import annotations

import importlib
import json
import os
import zipfile
import zlib
from dataclasses import astuple, replace
from pathlib import Path
from typing import Any

import numpy as np

from kirigami.elements.stiffness import Calibration, SheetConstants
from kirigami.errors import AnalysisError
from kirigami.files import whole_file
from kirigami.primitives.checks import require_path
from kirigami.primitives.material_words import from_words, to_words
from kirigami.results.drives import Drive
from kirigami.results.results import Results
from kirigami.results.step import Event, Step
from kirigami.results.supports import Support
from kirigami.system.apart import ApartKernel

FORMAT = 3  # version of the results file; formats 1 and 2 are read as well

# Where the kernel classes of results files live, so that code can move without orphaning a file.
KERNELS = {
    "AngleLimitKernel": "effects.angle_limit",
    "BarKernel": "elements.bar",
    "BendHingeKernel": "elements.bend_hinge",
    "ClampHingeKernel": "elements.clamp_hinge",
    "HeldEdgeKernel": "elements.clamp_hinge",
    "ContactKernel": "effects.contact",
    "CreaseKernel": "elements.crease",
    "CurvedFacetKernel": "elements.curved_facet",
    "EdgeMomentKernel": "model.edge_moment",
    "FacetKernel": "elements.facet",
    "MovingContactKernel": "effects.moving",
    "MovingFrictionKernel": "effects.moving",
    "MassKernel": "elements.mass",
    "NodalLoadKernel": "model.loads",
    "FrictionKernel": "effects.friction",
    "FlowPressureKernel": "model.flow_pressure",
    "PressureKernel": "model.pressure",
    "RimPressureKernel": "model.pressure",
    "SeamFacetKernel": "elements.seams",
    "SeamHingeKernel": "elements.seams",
    "SelfContactKernel": "effects.self_contact",
    "SelfFrictionKernel": "effects.self_friction",
    "ShellFacetKernel": "elements.shell_kernel",
    "SpringKernel": "effects.spring",
    "TorsionSpring3Kernel": "elements.torsion_spring",
    "YieldingBarKernel": "elements.member_yield",
    "YieldingHingeKernel": "elements.member_yield",
    "YieldingShellKernel": "elements.shell_yield",
    "RubberShellKernel": "elements.shell_rubber",
}


def save(results: Results, path: str | os.PathLike[str]) -> Path:
    """Write everything to one compressed file that :func:`kirigami.load` reads back; never a partial file.

    Parameters
    ----------
    path : path
        The file, by custom ending in .npz.

    Raises
    ------
    KirigamiError
        The file cannot be written.
    AnalysisError
        An effect of the model does not say how to save itself.
    """
    try:
        return write(path, pack(results))
    except NotImplementedError as error:
        raise AnalysisError(f"these results cannot be saved: {error}", results=results) from None


def pack(results: Results, with_kernels: bool = True) -> dict[str, Any]:
    """Everything `results` hold as named arrays; what is no array is in the JSON text of ``head``."""
    arrays: dict[str, Any] = {"rest": results.rest, "constrained": results.constrained}
    kernels = []
    for position, kernel in enumerate(results.kernels if with_kernels else ()):
        plain: dict[str, Any] = {}
        for key, value in kernel.arrays().items():
            if isinstance(value, np.ndarray):
                arrays[f"kernel{position}.{key}"] = value
            else:
                plain[key] = value
        apart = isinstance(kernel, ApartKernel)
        plain_kernel = kernel.kernel if isinstance(kernel, ApartKernel) else kernel
        kernels.append({"class": type(plain_kernel).__name__, "values": plain, **({"apart": True} if apart else {})})
    # Located points of events are steps as well, kept behind those of the path.
    located = [event.located for event in results.events if event.located is not None]
    steps = [*results.steps, *located]
    arrays["u"] = np.array([step.u for step in steps]).reshape(len(steps), len(results.rest), 3)
    arrays["inner_rest"] = results.inner_rest
    arrays["inner"] = np.array([step.inner for step in steps]).reshape(len(steps), len(results.inner_rest), 3)
    arrays["lam"] = np.array([step.lam for step in steps])
    for position in range(max((len(step.history) for step in steps), default=0)):
        for number, step in enumerate(steps):
            value = step.history[position] if len(step.history) > position else None
            if value is not None:
                arrays[f"history{position}.{number}"] = value
    if any(step.velocity is not None for step in steps):
        for name, count in (("velocity", len(results.rest)), ("inner_velocity", len(results.inner_rest))):
            still = np.zeros((count, 3))
            rows = np.array([still if step.velocity is None else getattr(step, name) for step in steps])
            arrays[name] = rows.reshape(len(steps), count, 3)
        arrays["time"] = np.array([step.time for step in steps])
        arrays["kinetic"] = np.array([step.kinetic for step in steps])
        for name, count in (("forces", len(results.rest)), ("inner_forces", len(results.inner_rest))):
            unknown = np.full((count, 3), np.nan)
            told = [unknown if step.forces is None else getattr(step, name) for step in steps]
            arrays[name] = np.array(told).reshape(len(steps), count, 3)
    if not all(np.isnan(step.yielded) for step in steps):
        arrays["yielded"] = np.array([step.yielded for step in steps])
    for position, event in enumerate(results.events):
        if event.mode is not None:
            arrays[f"mode{position}"] = event.mode
    head = {
        "format": FORMAT,
        "name": results.name,
        "dim": results.dim,
        "linear": results.linear,
        "kernels": kernels if with_kernels else None,
        "stats": results.stats,
        "count": len(results.steps),
        "steps": [
            [s.negative, s.residual, s.residual_over_reaction, s.iterations, len(s.history), s.stage] for s in steps
        ],
        "events": [
            [e.kind, e.lam, e.step, e.message, list(e.bracket), e.located is not None, e.energy] for e in results.events
        ],
        "mesh": None,
        "node_names": results.node_names,
        "supports": [[s.name, s.kind, s.dofs, s.constant, s.clamp] for s in results.supports],
        "sheet": _sheet_words(results.sheet_constants),
        "grips": list(results.grip_nodes),
        "shapes": results.shape_words,
        "drives": [drive.plain() for drive in results.drives],
        "units": results.units,
    }
    for position, support in enumerate(results.supports):
        arrays[f"support{position}.nodes"], arrays[f"support{position}.leaders"] = support.nodes, support.leaders
        for axis, values in support.values.items():
            arrays[f"support{position}.{axis}"] = values
    for position, nodes in enumerate(results.grip_nodes.values()):
        arrays[f"grip{position}"] = nodes
    if results.mesh is not None:
        head["mesh"] = {
            "sets": list(results.mesh.sets),
            "regions": list(results.mesh.regions),
            "cuts": [[list(cut.members), bool(cut.open)] for cut in results.mesh.cuts],
            "thickness": results.mesh.thickness,
            "material": None if results.mesh.material is None else to_words(results.mesh.material),
            "folds": [[fold.angle, fold.stiffness] for fold in results.mesh.folds],
        }
        arrays["mesh.nodes"], arrays["mesh.triangles"] = results.mesh.nodes, results.mesh.triangles
        for position, nodes in enumerate(results.mesh.sets.values()):
            arrays[f"mesh.set{position}"] = nodes
        for position, facets in enumerate(results.mesh.regions.values()):
            arrays[f"mesh.region{position}"] = facets
        for position, cut in enumerate(results.mesh.cuts):
            arrays[f"mesh.cut{position}"] = np.asarray(cut.loop)
        for position, fold in enumerate(results.mesh.folds):
            arrays[f"mesh.fold{position}"] = fold.edges
    return {"head": np.array(json.dumps(head)), **arrays}


def write(path: str | os.PathLike[str], arrays: dict[str, Any], compressed: bool = True) -> Path:
    """Write named arrays to a file."""
    with whole_file(path) as unfinished, open(unfinished, "wb") as file:
        (np.savez_compressed if compressed else np.savez)(file, **arrays)
    return Path(path)


def read(path: str | os.PathLike[str]) -> tuple[dict[str, Any], dict[str, Any]]:
    """Head and arrays of a file, or an AnalysisError that says what is wrong with it."""
    path = require_path(path, "path", "kirigami.load", AnalysisError)
    if path.exists() and not path.is_file():
        raise AnalysisError(f"cannot read {path}: it is no plain file")
    try:
        with np.load(path, allow_pickle=False) as file:
            data = {key: file[key] for key in file.files}
        head = json.loads(str(data["head"]))
        version = head["format"]
    except FileNotFoundError:
        raise AnalysisError(f"no results file at {path}") from None
    except OSError as error:
        raise AnalysisError(f"cannot read {path}: {error.strerror or error}") from None
    except (ValueError, KeyError, EOFError, TypeError, AttributeError, zipfile.BadZipFile, zlib.error):
        raise AnalysisError(
            f"{path} is not a results file of this package, or it is damaged: results files are what Results.save wrote"
        ) from None
    if version not in range(1, FORMAT + 1):
        raise AnalysisError(f"{path} has file format {version!r}, this version of kirigami reads formats 1 to {FORMAT}")
    return head, data


def load(path: str | os.PathLike[str]) -> Results:
    """Read results that :meth:`Results.save` wrote.

    Parameters
    ----------
    path : path
        The file.

    Returns
    -------
    Results
        As saved, with mesh, thickness, material and supports. The model itself is not stored: give nodes by index, or
        by the name of a support ("driven_0") or of a boundary of the mesh ("top"). Files of versions before 0.2 know
        neither supports nor thickness and material.

    Raises
    ------
    AnalysisError
        No such file, or not a results file of a known version.

    Examples
    --------
    >>> import tempfile
    >>> from pathlib import Path
    >>> import kirigami as kg
    >>> m = kg.Model(dim=2)
    >>> a, b = m.add(kg.Node(0, 0), kg.Node(1, 0))
    >>> objects = m.add(kg.Bar(a, b, EA=10.0), kg.Fix(a), kg.Fix(b, "y"), kg.NodalLoad(b, (1, 0)))
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     res = kg.load(kg.LinearStatic(m).run().save(Path(folder) / "rod.npz"))
    >>> float(round(res.position(1)[-1, 0], 9)), float(round(res.reaction("fixed_0", "x")[-1], 9))
    (1.1, -1.0)
    """
    head, data = read(path)
    if head["kernels"] is None:
        raise AnalysisError(f"{path} is the checkpoint of a model whose effects do not say how to save themselves")
    try:
        return _rebuild(head, data)
    except (KeyError, IndexError, TypeError, ValueError) as error:
        raise AnalysisError(f"{path} is damaged or incomplete ({error!r})") from None


def _sheet_words(sheet: SheetConstants | None) -> dict[str, Any] | None:
    if sheet is None:
        return None
    count = len(sheet.material) if isinstance(sheet.material, tuple) else 1
    number, materials = sheet.material_of_facets(count)
    thickness = np.asarray(sheet.thickness).tolist()
    words = {"factors": astuple(sheet.calibration), "thickness": thickness, "rung": sheet.rung}
    if len(materials) == 1:
        return {**words, "material": to_words(materials[0])}
    return {**words, "materials": [to_words(material) for material in materials], "material_of": number.tolist()}


def _sheet(words: dict[str, Any] | None) -> SheetConstants | None:
    if words is None:
        return None
    thickness = words["thickness"] if isinstance(words["thickness"], float) else np.array(words["thickness"])
    calibration = Calibration(*words["factors"])
    if "materials" not in words:
        return SheetConstants(calibration, thickness, from_words(words["material"]), words["rung"])
    materials = [from_words(material) for material in words["materials"]]
    return SheetConstants(calibration, thickness, tuple(materials[k] for k in words["material_of"]), words["rung"])


def _supports(head: dict[str, Any], data: dict[str, Any]) -> tuple[Support, ...]:
    found = []
    for position, (name, kind, dofs, constant, clamp) in enumerate(head.get("supports", [])):
        at = f"support{position}."
        values = {axis: data[at + axis] for axis in dofs}
        found.append(Support(name, kind, data[at + "nodes"], values, data[at + "leaders"], constant, clamp))
    return tuple(found)


def _put_tips_behind(results: Results) -> None:
    """Files of versions before 0.2 have the tips of normals among the nodes: these go to the rows behind them."""
    from kirigami.elements.curved_facet import CurvedFacetKernel  # which no other file needs

    for kernel in results.kernels:
        if isinstance(kernel, CurvedFacetKernel):
            tips = np.unique(kernel.conn[:, 3:])
            count = len(results.rest) - len(tips)
            if not np.array_equal(tips, np.arange(count, len(results.rest))):
                return  # made by hand, in another order
            results.inner_rest, results.rest = results.rest[count:, : results.dim], results.rest[:count]
            results.steps = [_parted(step, count) for step in results.steps]
            results.events = [
                replace(
                    event,
                    located=event.located and _parted(event.located, count),
                    mode=None if event.mode is None else event.mode[:count],
                )
                for event in results.events
            ]
            return


def _parted(step: Step, count: int) -> Step:
    return replace(step, u=step.u[:count], inner=step.u[count:])


def _rebuild(head: dict[str, Any], data: dict[str, Any]) -> Results:
    results = Results.__new__(Results)
    results.forget_model()
    results.name, results.dim, results.linear = head["name"], head["dim"], head["linear"]
    results.rest, results.constrained, results.stats = data["rest"], data["constrained"], head["stats"]
    results.node_names = head.get("node_names", {})
    results.supports = _supports(head, data)
    results.sheet_constants = _sheet(head.get("sheet"))
    results.mesh = None
    results.shapes, results.shape_words = None, list(head.get("shapes", ()))
    results.grip_nodes = {name: data[f"grip{position}"] for position, name in enumerate(head.get("grips", ()))}
    results.drives = tuple(map(Drive.from_plain, head.get("drives", ())))
    results.units = head.get("units", "")
    results.kernels = []
    results.inner_rest = data.get("inner_rest", np.zeros((0, results.dim)))
    rest = np.concatenate([results.rest[:, : results.dim], results.inner_rest])
    for position, entry in enumerate(head["kernels"]):
        prefix = f"kernel{position}."
        values = {key[len(prefix) :]: value for key, value in data.items() if key.startswith(prefix)}
        if entry["class"] not in KERNELS:
            raise AnalysisError(
                f"the results hold a {entry['class']}, no kernel of this package: only those are read from files"
            )
        cls = getattr(importlib.import_module(f"kirigami.{KERNELS[entry['class']]}"), entry["class"])
        kernel = cls(rest, **values, **entry["values"])
        results.kernels.append(ApartKernel(kernel) if entry.get("apart") else kernel)
    results.steps, results.events = (_unpack_format_1 if head["format"] == 1 else unpack_path)(head, data)
    _put_tips_behind(results)
    if head["mesh"] is not None:
        from kirigami.geometry.fold_line import FoldEdges
        from kirigami.geometry.mesh import CutLoop, TriMesh

        sets = {name: data[f"mesh.set{position}"] for position, name in enumerate(head["mesh"]["sets"])}
        cuts = [
            CutLoop(data[f"mesh.cut{position}"], tuple(members), is_open)
            for position, (members, is_open) in enumerate(head["mesh"]["cuts"])
        ]
        folds = [
            FoldEdges(data[f"mesh.fold{position}"], *told)
            for position, told in enumerate(head["mesh"].get("folds", ()))
        ]
        names = enumerate(head["mesh"].get("regions", ()))
        regions = {name: data[f"mesh.region{position}"] for position, name in names}
        thickness, material = (head["mesh"].get(name) for name in ("thickness", "material"))
        results.mesh = TriMesh(
            data["mesh.nodes"], data["mesh.triangles"], sets,
            thickness=thickness, material=material and from_words(material), cuts=cuts,
            folds=folds, regions=regions,
        )  # fmt: skip
    return results


def unpack_path(head: dict[str, Any], data: dict[str, Any]) -> tuple[list[Step], list[Event]]:
    """The steps and events of a file."""
    steps = [
        Step(
            lam=float(data["lam"][index]),
            u=data["u"][index],
            negative=negative,
            residual=residual,
            residual_over_reaction=over_reaction,
            iterations=iterations,
            history=tuple(data.get(f"history{position}.{index}") for position in range(kernels)),
            stage=stage,
            inner=data["inner"][index] if "inner" in data else np.zeros((0, 3)),
            yielded=float(data["yielded"][index]) if "yielded" in data else float("nan"),
            **_motion(data, index),
        )
        for index, (negative, residual, over_reaction, iterations, kernels, stage) in enumerate(head["steps"])
    ]
    located = iter(steps[head["count"] :])
    events = [
        Event(kind, lam, step, message, (bracket[0], bracket[1]), next(located) if found else None,
              data.get(f"mode{position}"), *energy)
        for position, (kind, lam, step, message, bracket, found, *energy) in enumerate(head["events"])
    ]  # fmt: skip
    return steps[: head["count"]], events


def _motion(data: dict[str, Any], index: int) -> dict[str, Any]:
    """What a step of a motion has beyond an equilibrium."""
    if "time" not in data or not np.isfinite(data["time"][index]):
        return {}
    rows = {name: data[name][index] for name in ("velocity", "inner_velocity")}
    if "forces" in data and not np.isnan(data["forces"][index]).any():
        rows |= {name: data[name][index] for name in ("forces", "inner_forces")}
    return {"time": float(data["time"][index]), "kinetic": float(data["kinetic"][index]), **rows}


def _unpack_format_1(head: dict[str, Any], data: dict[str, Any]) -> tuple[list[Step], list[Event]]:
    """The steps and events of a file of format 1, which kept of a located event nothing but its displacements."""
    steps = []
    for index, (negative, residual, over_reaction, iterations, stage) in enumerate(head["steps"]):
        history = tuple(
            data[f"history{position}"][index] if f"history{position}" in data else None
            for position in range(len(head["kernels"]))
        )
        lam, u = float(data["lam"][index]), data["u"][index]
        steps.append(Step(lam, u, negative, residual, over_reaction, iterations, history, stage))
    events = []
    for position, (kind, lam, step, message, bracket) in enumerate(head["events"]):
        u = data.get(f"event{position}")
        located = None if u is None else Step(lam, u, stage=steps[0].stage if steps else 0)
        events.append(Event(kind, lam, step, message, (bracket[0], bracket[1]), located))
    return steps, events
