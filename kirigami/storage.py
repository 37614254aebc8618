"""Results files: one compressed numpy archive with a JSON head; no code is stored and none is run on reading."""

from __future__ import annotations

import importlib
import json
import os
import zipfile
import zlib
from pathlib import Path
from typing import Any

import numpy as np

from kirigami.errors import AnalysisError
from kirigami.results import Event, Results, Step

FORMAT = 1  # version of the results file


def save(results: Results, path: str | os.PathLike[str]) -> Path:
    """Write `results` under another name and then rename, so that no broken file is left behind."""
    target = Path(path)
    arrays: dict[str, Any] = {name: getattr(results, name) for name in ("rest", "constrained", "u", "lam")}
    kernels = []
    for position, kernel in enumerate(results.kernels):
        plain: dict[str, Any] = {}
        for key, value in kernel.arrays().items():
            if isinstance(value, np.ndarray):
                arrays[f"kernel{position}.{key}"] = value
            else:
                plain[key] = value
        kernels.append({"module": type(kernel).__module__, "class": type(kernel).__name__, "values": plain})
        if results.steps and all(len(s.history) > position and s.history[position] is not None for s in results.steps):
            arrays[f"history{position}"] = np.array([step.history[position] for step in results.steps])
    head = {
        "format": FORMAT,
        "name": results.name,
        "dim": results.dim,
        "linear": results.linear,
        "kernels": kernels,
        "stats": results.stats,
        "steps": [
            [s.negative, s.residual, s.residual_over_reaction, s.iterations, s.stage] for s in results.steps
        ],
        "events": [[e.kind, e.lam, e.step, e.message, list(e.bracket)] for e in results.events],
        "mesh": None,
    }
    for position, event in enumerate(results.events):
        if event.u is not None:
            arrays[f"event{position}"] = event.u
    if results.mesh is not None:
        head["mesh"] = {
            "sets": list(results.mesh.sets),
            "cuts": [[list(cut.members), bool(cut.open)] for cut in results.mesh.cuts],
        }
        arrays["mesh.nodes"], arrays["mesh.triangles"] = results.mesh.nodes, results.mesh.triangles
        for position, nodes in enumerate(results.mesh.sets.values()):
            arrays[f"mesh.set{position}"] = nodes
        for position, cut in enumerate(results.mesh.cuts):
            arrays[f"mesh.cut{position}"] = np.asarray(cut.loop)
    target.parent.mkdir(parents=True, exist_ok=True)
    unfinished = target.with_name(target.name + ".part")
    try:
        with open(unfinished, "wb") as file:
            np.savez_compressed(file, head=np.array(json.dumps(head)), **arrays)
        os.replace(unfinished, target)
    finally:
        unfinished.unlink(missing_ok=True)
    return target


def load(path: str | os.PathLike[str]) -> Results:
    """Read results that :meth:`Results.save` wrote.

    Parameters
    ----------
    path : path
        The file.

    Returns
    -------
    Results
        As saved; nodes are addressed by index, since the model itself is not stored.

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
    >>> float(round(res.position(1)[-1, 0], 9))
    1.1
    """
    try:
        with np.load(path, allow_pickle=False) as file:
            data = {key: file[key] for key in file.files}
        head = json.loads(str(data["head"]))
        version = head["format"]
    except FileNotFoundError:
        raise AnalysisError(f"no results file at {path}") from None
    except (OSError, ValueError, KeyError, EOFError, TypeError, zipfile.BadZipFile, zlib.error) as error:
        raise AnalysisError(f"{path} is not a results file of this package, or it is damaged ({error})") from None
    if version != FORMAT:
        raise AnalysisError(f"{path} has file format {version}, this version of kirigami reads format {FORMAT}")
    try:
        return _rebuild(head, data)
    except (KeyError, IndexError, TypeError, ValueError) as error:
        raise AnalysisError(f"{path} is damaged or incomplete ({error!r})") from None


def _rebuild(head: dict[str, Any], data: dict[str, Any]) -> Results:
    results = Results.__new__(Results)
    results.model = None
    results.name, results.dim, results.linear = head["name"], head["dim"], head["linear"]
    results.rest, results.constrained, results.stats = data["rest"], data["constrained"], head["stats"]
    results.mesh = None
    results.kernels = []
    rest = np.ascontiguousarray(results.rest[:, : results.dim])
    for position, entry in enumerate(head["kernels"]):
        prefix = f"kernel{position}."
        values = {key[len(prefix) :]: value for key, value in data.items() if key.startswith(prefix)}
        if entry["module"].split(".")[0] != "kirigami":
            raise AnalysisError(
                f"the results hold a kernel of {entry['module']}, which this package does not import from a file"
            )
        cls = getattr(importlib.import_module(entry["module"]), entry["class"])
        results.kernels.append(cls(rest, **values, **entry["values"]))
    results.steps = []
    for index, (negative, residual, over_reaction, iterations, stage) in enumerate(head["steps"]):
        history = tuple(
            data[f"history{position}"][index] if f"history{position}" in data else None
            for position in range(len(results.kernels))
        )
        results.steps.append(
            Step(
                lam=float(data["lam"][index]),
                u=data["u"][index],
                negative=negative,
                residual=residual,
                residual_over_reaction=over_reaction,
                iterations=iterations,
                history=history,
                stage=stage,
            )
        )
    results.events = [
        Event(kind, lam, step, message, (bracket[0], bracket[1]), data.get(f"event{position}"))
        for position, (kind, lam, step, message, bracket) in enumerate(head["events"])
    ]
    if head["mesh"] is not None:
        from kirigami.geometry.mesh import CutLoop, TriMesh

        sets = {name: data[f"mesh.set{position}"] for position, name in enumerate(head["mesh"]["sets"])}
        cuts = [
            CutLoop(data[f"mesh.cut{position}"], tuple(members), is_open)
            for position, (members, is_open) in enumerate(head["mesh"]["cuts"])
        ]
        results.mesh = TriMesh(data["mesh.nodes"], data["mesh.triangles"], sets, cuts=cuts)
    return results
