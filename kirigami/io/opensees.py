"""A sheet model as a script for OpenSeesPy."""

from __future__ import annotations

import os
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from kirigami.errors import ModelError
from kirigami.files import whole_file
from kirigami.io.shell import checked_targets, shell_of
from kirigami.model.model import Model
from kirigami.primitives.checks import require_path, require_whole

SCRIPT = '''\
"""{title}: a sheet of shell triangles, stretched step by step. Run: python {name} [reactions.csv]"""

import sys

import openseespy.opensees as ops

SECTIONS = [  # E, Poisson's ratio, thickness, density
{sections}]
TARGETS = {targets}  # load factors to store
INCREMENT = {increment!r}  # of the load factor; halved where no equilibrium is found

NODES = [  # x, y, z
{nodes}]
TRIANGLES = [  # nodes and section, counted from 0
{triangles}]
HELD = [  # node, axis (0, 1, 2), displacement at load factor 0, its growth with the load factor
{held}]
CLAMPED = [  # nodes that keep their rotations about x and y
{clamped}]
DRILL = {drill}  # the element stores no energy where all nodes turn alike about z: one of each part is held
LOADS = [  # node, force at load factor 0 (x, y, z), its growth with the load factor (x, y, z)
{loads}]
SETS = {{  # supported nodes
{sets}}}


def build():
    ops.wipe()
    ops.model("basic", "-ndm", 3, "-ndf", 6)
    for number, place in enumerate(NODES, 1):
        ops.node(number, *place)
    for number, constants in enumerate(SECTIONS, 1):
        ops.section("ElasticMembranePlateSection", number, *constants)
    for number, (i, j, k, section) in enumerate(TRIANGLES, 1):
        ops.element("ShellNLDKGT", number, i + 1, j + 1, k + 1, section + 1)
    for node in CLAMPED:
        ops.fix(node + 1, 0, 0, 0, 1, 1, 0)
    for node in DRILL:
        ops.fix(node + 1, 0, 0, 0, 0, 0, 1)
    ops.timeSeries("Constant", 1)
    ops.timeSeries("Linear", 2)
    for series in (1, 2):
        ops.pattern("Plain", series, series)
        for node, *forces in LOADS:
            force = forces[series - 1]
            if any(force):
                ops.load(node + 1, *force, 0.0, 0.0, 0.0)
        for node, axis, constant, driven in HELD:
            # Each displacement has one owner: the growing pattern, unless it is constant and not zero.
            if (series == 1) == (constant != 0.0):
                ops.sp(node + 1, axis + 1, constant if series == 1 else driven)
    ops.constraints("Transformation")
    ops.numberer("RCM")
    ops.system("UmfPack")
    ops.test("NormDispIncr", {tolerance!r}, 40)
    ops.algorithm("Newton")


def advance(target):
    """Go to a load factor, in smaller increments where needed."""
    increment = INCREMENT
    while abs(target - ops.getTime()) > 1e-12:
        left = target - ops.getTime()
        trial = left if abs(left) < 1.5 * increment else increment * (1 if left > 0 else -1)
        ops.integrator("LoadControl", trial)
        ops.analysis("Static", "-noWarnings")
        if ops.analyze(1) == 0:
            increment = min(1.5 * increment, INCREMENT)
        else:
            increment = abs(trial) / 2
            if increment < 1e-6 * INCREMENT:
                raise SystemExit(f"no equilibrium beyond load factor {{ops.getTime():.6g}}")


def main(path=None):
    build()
    header = ["load_factor"] + [f"{{name}}_{{axis}}" for name in SETS for axis in "xyz"]
    rows = []
    for target in TARGETS:
        advance(target)
        ops.reactions()
        forces = [sum(ops.nodeReaction(n + 1, a) for n in group) for group in SETS.values() for a in (1, 2, 3)]
        rows.append([target] + forces)
    lines = [",".join(header)] + [",".join(repr(float(value)) for value in row) for row in rows]
    print("\\n".join(lines))
    if path:
        with open(path, "w") as file:
            file.write("\\n".join(lines) + "\\n")


if __name__ == "__main__":
    main(*sys.argv[1:2])
'''


def to_openseespy(
    model: Model, path: str | os.PathLike[str], *, targets: Sequence[float] = (1.0,), increments: int = 20
) -> Path:
    """Write the same sheet as a shell model in OpenSeesPy, a script that runs by itself.

    Mesh, thickness, material, stress-free imperfection, supports and dead loads are handed over; the elements of
    `stiffness` are not, and a sheet that has lost or gained some is refused. The element is ShellNLDKGT, a thin
    triangle with large displacements; its free drilling rotations make it a few per cent soft in tension on coarse
    meshes. The script prints the support reactions at the targets and writes them to a CSV file if it is given a
    name.

    Parameters
    ----------
    model : Model
        Made by ``Model.from_mesh``, in three dimensions.
    path : path
        The script, by custom ending in .py.
    targets : sequence of float
        Load factors to store.
    increments : int
        Increments from load factor 0 to the largest target; they are halved where needed.

    Raises
    ------
    ModelError
        The model has no mesh, holds ties, effects or elements beyond the sheet, or an argument is wrong.
    KirigamiError
        The file cannot be written.

    Examples
    --------
    >>> from pathlib import Path
    >>> from kirigami.io.opensees import to_openseespy
    >>> import tempfile, kirigami as kg
    >>> mesh = kg.TriMesh([[0, 0], [1, 0], [1, 1], [0, 1]], [[0, 1, 2], [0, 2, 3]])
    >>> m = kg.Model.from_mesh(mesh, thickness=0.01, material=kg.Material(E=1e9))
    >>> held = m.add(kg.Fix(m.select(boundary="bottom")), kg.Prescribe(m.select(boundary="top"), y=0.1))
    >>> script = to_openseespy(m, Path(tempfile.mkdtemp()) / "square.py").read_text()
    >>> compiled = compile(script, "square.py", "exec")
    """
    target = require_path(path, "path", "to_openseespy")
    increments = require_whole(increments, "increments", "to_openseespy", least=1)
    listed = checked_targets(targets, "to_openseespy")
    shell = shell_of(model, "to_openseespy")
    for key, (constant, driven) in shell.held.items():
        if constant and driven:
            raise ModelError(f"to_openseespy: node {key[0]} is both held off its place and driven along one axis")
    size = float(shell.nodes.max(axis=0).max() - shell.nodes.min())
    section = np.zeros(len(shell.triangles), np.int64)
    for part, (_, _, facets) in enumerate(shell.parts):
        section[facets] = part
    nodes_loaded = sorted({node for node, _ in shell.loads})
    loads = [
        (node, *(tuple(shell.loads.get((node, axis), (0.0, 0.0))[part] for axis in range(3)) for part in (0, 1)))
        for node in nodes_loaded
    ]
    script = SCRIPT.format(
        title=(model.name or "sheet").replace("\\", "/").replace('"', "'"),
        name=target.name,
        sections=_rows((m.E, m.nu, thickness, m.density or 0.0) for thickness, m, _ in shell.parts),
        targets=listed,
        increment=max(map(abs, listed)) / increments,
        tolerance=1e-9 * size,
        nodes=_rows(map(tuple, shell.nodes.tolist())),
        triangles=_rows(map(tuple, np.column_stack([shell.triangles, section]).tolist())),
        held=_rows((*key, *value) for key, value in shell.held.items()),
        clamped=_rows(shell.clamped.tolist()),
        drill=_first_of_parts(shell.triangles, len(shell.nodes)),
        loads=_rows(loads),
        sets="".join(f"    {name!r}: {group.tolist()},\n" for name, group in shell.sets.items()),
    )
    with whole_file(target) as unfinished:
        unfinished.write_text(script, encoding="utf-8")
    return target


def _first_of_parts(triangles: NDArray[np.int64], count: int) -> list[int]:
    """First node of each connected part of the sheet."""
    ends = triangles[:, [0, 1, 1, 2]].reshape(-1, 2).T
    graph = coo_array((np.ones(ends.shape[1], np.int8), ends), shape=(count, count))
    first = np.unique(connected_components(graph, directed=False)[1], return_index=True)[1]
    return sorted(first.tolist())


def _rows(items: Iterable[Any]) -> str:
    return "".join(f"    {item!r},\n" for item in items)
