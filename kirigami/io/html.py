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
from kirigami.results.scale import scale_of
from kirigami.results.smooth import known_stress, sectors
from kirigami.results.yielding import facet_plastic_strain
from kirigami.units import unit_for

LEVELS = 65535  # positions are stored in so many parts of the extent of each axis
SHADES = 255  # colours in so many shades
TITLES = {
    "load_factor": "load factor",
    "height": "height (largest less smallest z)",
    "open_area": "open area of the cuts",
}
KINDS = {"height": "length", "open_area": "area"}
LABELS = {
    "stress": "von Mises stress", "strain": "strain", "plastic strain": "plastic strain", "energy": "energy / area",
    "force": "force",
}  # fmt: skip


def to_html(
    results: Results,
    path: str | os.PathLike[str],
    *,
    reactions: Mapping[str, Nodes] | None = None,
    frames: int = 60,
    title: str | None = None,
) -> Path:
    """Write a page of its own: the sheet turns under the mouse, a slider runs the load, curves move along.

    Colours show height, stress, strain or stored energy as means round each node, with the jumps kept across folds and
    cuts; the rest state lies beside it, and a click on a node draws its displacement. Of sheets a band round the force,
    the height and the open area is their estimated error, ``results.error``. Everything lies in the file, the drawing
    program too, all compressed: 10,000 nodes and 50 steps take about 4 MB. Positions are rounded to 1/65535 of the
    extent, for looking only. Needs a browser of 2023 or later.

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
    >>> from pathlib import Path
    >>> from kirigami.io.html import to_html
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
    head["curves"] = titled_curves(results, reactions)
    if results.drives:
        motion, response = results.drives[0].titles(scale_of(results))
        head["main"], head["over"] = response, motion
    head["bands"] = _bands(results, head["curves"])
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


def titled_curves(results: Results, reactions: Mapping[str, Nodes] | None = None) -> dict[str, list[float | None]]:
    """The curves of :func:`kirigami.io.table.curves` by titles for people, with units where these are known.

    Of stretched sheets the reactions of driven nodes are left out, since they are there as force or torque.

    Examples
    --------
    >>> from kirigami.io.html import titled_curves
    >>> import kirigami as kg
    >>> m = kg.Model(dim=2)
    >>> a, b = m.add(kg.Node(0, 0), kg.Node(2, 0))
    >>> objects = m.add(kg.Bar(a, b, EA=10.0), kg.Fix(a), kg.Fix(b, "y"), kg.Prescribe(b, x=0.1))
    >>> list(titled_curves(kg.LinearStatic(m).run()))
    ['load factor', 'energy of bars', 'force on the driven nodes along x']
    """
    scale, known = scale_of(results), curves(results, reactions)
    titles = {name: _raised(scale.title(title, KINDS.get(name, ""))) for name, title in TITLES.items()}
    sizes = {name: scale.unit(kind)[1] for name, kind in KINDS.items()}
    for drive in results.drives:
        titles |= zip((drive.column, drive.response), drive.titles(scale))
        sizes |= {
            drive.column: scale.unit(drive.kind)[1] / drive.share, drive.response: scale.unit(drive.answer_kind)[1]
        }  # fmt: skip
    driven = [support.name for support in results.supports if support.driven]
    found: dict[str, list[float | None]] = {}
    for name, values in known.items():
        if name in ("stable", "residual") or (results.drives and reactions is None and name.startswith("reaction_")):
            continue
        title = titles.get(name, "")
        if name.startswith("reaction_"):
            where, axis = name.removeprefix("reaction_").rsplit("_", 1)
            number = f" {driven.index(where) + 1}" if where in driven and len(driven) > 1 else ""
            title = f"force on {f'the driven nodes{number}' if where in driven else where} along {axis}"
            title = scale.title(title, "force")
        elif name.startswith("energy_"):
            title = scale.title(f"energy of {name.removeprefix('energy_')}", "energy")
        scaled = values / sizes.get(name, 1.0)
        found[title] = [value if np.isfinite(value) else None for value in scaled.tolist()]
    return found


def _bands(results: Results, drawn: Mapping[str, list[float | None]]) -> dict[str, list[float | None]]:
    """Estimated errors of the curves by their titles, in the units of these; none of what is no sheet."""
    try:
        error = results.error
    except AnalysisError:
        return {}
    scale = scale_of(results)
    titles = {_raised(scale.title(TITLES[name], kind)): name for name, kind in KINDS.items()}
    if results.drives:
        titles[results.drives[0].titles(scale)[1]] = "force"
    bands: dict[str, list[float | None]] = {}
    for title in drawn.keys() & titles.keys():
        values = np.array(drawn[title], dtype=float)
        # The force's error is a share of its value there, those of heights and areas of the largest on the path.
        whole = np.abs(values) if titles[title] == "force" else np.nanmax(np.abs(values), initial=0.0)
        band = error[titles[title]] * whole
        bands[title] = [value if np.isfinite(value) else None for value in band.tolist()]
    return bands


def _contents(results: Results, shown: NDArray[np.int64]) -> tuple[dict[str, Any], bytes]:
    """What the page must know, and the bytes of its arrays, one after the other."""
    # Round a fold a node has a vertex for each of its sides, so that colours and light may jump there.
    parts = None if results.mesh is None else sectors(results)
    node = np.arange(len(results.rest)) if parts is None else parts.node
    unit, factor = scale_of(results).unit("length")
    positions = np.concatenate([results.position()[shown], results.rest[None]])[:, node] / factor
    low, extent = positions.min(axis=(0, 1)), np.ptp(positions, axis=(0, 1))
    extent[extent == 0] = 1.0
    levels = np.round((positions - low) / extent * LEVELS).astype(np.uint16)
    blocks: list[bytes] = []
    head: dict[str, Any] = {
        "nodes": positions.shape[1], "frames": len(shown), "low": low.tolist(), "extent": extent.tolist(),
        "flat": results.dim == 2, "lam": results.lam.tolist(), "time": results.time.tolist() if results.moves else None,
        "unit": unit,
        "node": None if parts is None or len(node) == len(results.rest) else node.tolist(),
    }  # fmt: skip
    # Differences from step to step, low and high bytes apart: that is what packs well. The last one is the rest state.
    change = np.diff(levels, axis=0, prepend=np.zeros_like(levels[:1])).transpose(0, 2, 1)
    blocks += [(change & 255).astype(np.uint8).tobytes(), (change >> 8).astype(np.uint8).tobytes()]
    fields: dict[str, tuple[Array, str, str]] = {}
    if results.mesh is not None and parts is not None:
        mesh = results.mesh
        head["triangles"] = len(mesh.triangles)
        blocks.append(_planes(parts.corner))
        vertex = np.zeros(len(results.rest), dtype=np.int64)
        vertex[node[::-1]] = np.arange(len(node))[::-1]
        lines = vertex[mesh.edges[mesh.boundary_edges]]
        stress = known_stress(results)
        if stress is not None:
            fields["stress"] = (stress[shown], "node", "stress")
        fields["strain"] = (parts.means(facet_strain(results)[shown]), "node", "")
        if np.nan_to_num(results.yielded).any():
            fields["plastic strain"] = (parts.means(facet_plastic_strain(results)[shown]), "node", "")
        fields["energy"] = (energy_density(results)[shown][:, node], "node", "energy per area")
    else:
        head["triangles"] = 0
        lines = results.bars
        if len(lines):
            fields["force"] = (results.bar_force[shown], "line", "force")
            fields["strain"] = (results.bar_strain[shown], "line", "")
        fields["energy"] = (energy_density(results)[shown], "node", "energy")
    head["lines"] = len(lines)
    blocks.append(_planes(lines))
    head["fields"] = {}
    for name, (values, where, kind) in fields.items():
        smallest, largest = (values.min(), values.max()) if parts is None else parts.span(values)
        largest = largest if largest > smallest else smallest + (abs(smallest) or 1.0)
        shades = np.clip(np.round((values - smallest) / (largest - smallest) * SHADES), 0, SHADES).astype(np.uint8)
        blocks.append(np.diff(shades, axis=0, prepend=np.zeros_like(shades[:1])).tobytes())
        title, size = LABELS[name], 1.0
        if name == "energy" and results.mesh is None:
            title = "energy"
        if kind and results.units:
            of, size = unit_for(max(abs(smallest), abs(largest)), kind)
            title += _raised(f" [{of}]")
        head["fields"][name] = {"where": where, "low": smallest / size, "high": largest / size, "title": title}
    return head, b"".join(blocks)


def _raised(words: str) -> str:
    """Words with the squares of their units raised."""
    return words.replace("m2", "m²")


def _planes(integers: Iterable[Any]) -> bytes:
    """32-bit integers (k, columns) as four byte planes."""
    flat = np.ascontiguousarray(np.asarray(integers).ravel(), dtype="<u4")
    planes: bytes = flat.view(np.uint8).reshape(-1, 4).T.tobytes()
    return planes
