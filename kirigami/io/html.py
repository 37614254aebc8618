"""Results as one HTML page that turns under the mouse and opens without a network; plotly.js draws."""

from __future__ import annotations

import base64
import html
import importlib.resources
import json
import os
import zlib
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kirigami.errors import AnalysisError
from kirigami.files import library, whole_file
from kirigami.io.table import Nodes, curves
from kirigami.primitives.checks import require_path, require_text, require_whole
from kirigami.primitives.kernel import Array
from kirigami.results.fields import energy_density, facet_strain
from kirigami.results.results import Results

LEVELS = 65535  # positions are stored in so many parts of the extent of each axis
SHADES = 255  # colours in so many shades
OUTLIERS = 99.5  # per cent of the values that the colours span, so that one sharp tip does not grey out the sheet
TITLES = {
    "load_factor": "load factor",
    "height": "height (largest less smallest z)",
    "open_area": "open area of the cuts",
}


def to_html(
    results: Results,
    path: str | os.PathLike[str],
    *,
    reactions: Mapping[str, Nodes] | None = None,
    frames: int = 60,
    title: str | None = None,
) -> Path:
    """Write a page of its own: the sheet turns under the mouse, a slider runs the load, curves move along.

    Colours show height, strain or stored energy. Everything lies in the file, the drawing program too, all compressed:
    10,000 nodes and 50 steps take about 4 MB. Positions are rounded to 1/65535 of the extent, for looking only. Needs a
    browser of 2023 or later.

    Parameters
    ----------
    results : Results
        Of a sheet, or of bars.
    path : path
        The file.
    reactions : mapping of str to nodes, optional
        Supports whose reaction is drawn, as for :func:`kirigami.io.table.curves`.
    frames : int
        Largest number of steps in the page; of more, evenly spread ones are taken. The curves keep all.
    title : str, optional
        Heading; None takes the name of the model.

    Raises
    ------
    AnalysisError
        There are no steps.
    ModelError
        Fewer than two frames asked for.
    KirigamiError
        plotly is not installed, or the file cannot be written.

    Examples
    --------
    >>> import tempfile, kirigami as kg
    >>> m = kg.Model(dim=2)
    >>> a, b = m.add(kg.Node(0, 0), kg.Node(2, 0))
    >>> objects = m.add(kg.Bar(a, b, EA=10.0), kg.Fix(a), kg.Fix(b, "y"), kg.NodalLoad(b, (1, 0)))
    >>> page = to_html(kg.LinearStatic(m).run(), Path(tempfile.mkdtemp()) / "bar.html")
    >>> "http-equiv" in page.read_text(encoding="utf-8")[:1000]
    True
    """
    target = require_path(path, "path", "to_html")
    frames = require_whole(frames, "frames", "to_html", least=2)
    if not len(results):
        raise AnalysisError("there are no steps to show", results=results)
    plotly = library("plotly.offline", "writing an HTML page")
    heading = require_text(title, "title", "to_html") if title is not None else results.name or "kirigami"
    shown = np.unique(np.linspace(0, len(results) - 1, min(frames, len(results))).round().astype(int))
    head, body = _contents(results, shown)
    head["title"], head["told"] = heading, results.shape_words
    head["curves"] = {
        TITLES.get(name, name.replace("_", " ")): [value if np.isfinite(value) else None for value in values.tolist()]
        for name, values in curves(results, reactions).items()
        if name not in ("stable", "residual")
    }
    stable = [None if step.negative is None else step.stable for step in results.steps]
    head["stable"], head["shown"] = stable, shown.tolist()
    page = importlib.resources.files("kirigami.io").joinpath("page.html").read_text(encoding="utf-8")
    parts = {
        "TITLE": html.escape(heading),
        "HEAD": json.dumps(head).replace("<", "\\u003c"),
        "BODY": _packed(body),
        "PLOTLY": _packed(plotly.get_plotlyjs().encode()),
    }
    with whole_file(target) as unfinished, open(unfinished, "w", encoding="utf-8") as file:
        file.writelines(parts[piece] if number % 2 else piece for number, piece in enumerate(page.split("%%")))
    return target


def _packed(data: bytes) -> str:
    return base64.b64encode(zlib.compress(data, 9)).decode("ascii")


def _contents(results: Results, shown: NDArray[np.int64]) -> tuple[dict[str, Any], bytes]:
    """What the page must know, and the bytes of its arrays, one after the other."""
    positions = results.position()[shown]
    low, extent = positions.min(axis=(0, 1)), np.ptp(positions, axis=(0, 1))
    extent[extent == 0] = 1.0
    levels = np.round((positions - low) / extent * LEVELS).astype(np.uint16)
    blocks: list[bytes] = []
    head: dict[str, Any] = {
        "nodes": positions.shape[1], "frames": len(shown), "low": low.tolist(), "extent": extent.tolist(),
        "flat": results.dim == 2, "lam": results.lam.tolist(), "time": results.time.tolist() if results.moves else None,
    }  # fmt: skip
    # Differences from step to step, low and high bytes apart: that is what packs well.
    change = np.diff(levels, axis=0, prepend=np.zeros_like(levels[:1])).transpose(0, 2, 1)
    blocks += [(change & 255).astype(np.uint8).tobytes(), (change >> 8).astype(np.uint8).tobytes()]
    fields: dict[str, tuple[Array, str]] = {}
    if results.mesh is not None:
        mesh = results.mesh
        head["triangles"] = len(mesh.triangles)
        blocks.append(_planes(mesh.triangles))
        lines = mesh.edges[mesh.boundary_edges]
        fields["strain"] = (facet_strain(results)[shown], "facet")
        fields["energy"] = (energy_density(results)[shown], "node")
    else:
        head["triangles"] = 0
        lines = results.bars
        if len(lines):
            fields["strain"] = (results.bar_strain[shown], "line")
        fields["energy"] = (energy_density(results)[shown], "node")
    head["lines"] = len(lines)
    blocks.append(_planes(lines))
    head["fields"] = {}
    for name, (values, where) in fields.items():
        smallest, largest = _span(values)
        shades = np.clip(np.round((values - smallest) / (largest - smallest) * SHADES), 0, SHADES).astype(np.uint8)
        blocks.append(np.diff(shades, axis=0, prepend=np.zeros_like(shades[:1])).tobytes())
        head["fields"][name] = {"where": where, "low": smallest, "high": largest}
    return head, b"".join(blocks)


def _span(values: Array) -> tuple[float, float]:
    finite = values[np.isfinite(values)]
    low, high = (float(value) for value in np.percentile(finite, [100 - OUTLIERS, OUTLIERS])) if finite.size else (0, 1)
    return (low, high) if high > low else (low, low + (abs(low) or 1.0))


def _planes(integers: Iterable[Any]) -> bytes:
    """32-bit integers (k, columns) as four byte planes."""
    flat = np.ascontiguousarray(np.asarray(integers).ravel(), dtype="<u4")
    planes: bytes = flat.view(np.uint8).reshape(-1, 4).T.tobytes()
    return planes
