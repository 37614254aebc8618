"""The package beside other public codes: the same meshes, supports and tolerances, each run a process of its own.

    cracked      a sheet with a slit across its middle, pulled in its plane by 1e-5: quadratic triangles of scikit-fem,
                 refined and extrapolated (benchmarks/default_mesh.py)
    slits        a sheet with 52 slits, the same
    cantilever   a strip whose end is lifted by 0.67 of its length: the force of Sze, Liu and Lo (2004), table 1
    column       a clamped strip shortened by a fifth of its length, far beyond buckling: the elastica, in closed form

All codes get the same triangles and corner nodes; quadratic ones (shell, S6, P2) put more between. The error is that of
the support's force. Seconds are CPU seconds and memory the largest of the whole process, from its start to the
number; writing the input is left out. Runs of all codes are made by turns, and the table has medians. A run that ends
without its number, or takes longer than the limit, has failed, and is not repeated. Tolerances: the residual over the
forces below 1e-6 here and in CalculiX (*CONTROLS), in OpenSees the displacement correction that its script demands.

    python -m venv /tmp/peers && /tmp/peers/bin/pip install openseespy scikit-fem
    python benchmarks/peers.py --python /tmp/peers/bin/python --repeats 3 --table peers.csv
"""

from __future__ import annotations

import argparse
import csv
import json
import os
import re
import shutil
import signal
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path
from statistics import median
from typing import Any

import numpy as np
import shapely
from scipy.optimize import brentq
from scipy.special import ellipe, ellipk

import kirigami as kg
from kirigami.io.abaqus import to_abaqus
from kirigami.io.opensees import to_openseespy

HERE = Path(__file__).parent
TOLERANCE = 1e-6
OURS = ("shell", "facet", "plate")
SHELLS = ("CalculiX S6", "OpenSees ShellNLDKGT")
PLANE = ("scikit-fem P1", "scikit-fem P2")
FILM = kg.Material(E=4e9, nu=0.38)
FIGURES = ("error", "seconds", "megabytes")
# A process of its own that starts the code: what a child takes is counted from the memory of who starts it.
STARTER = """
import json, os, subprocess, sys
with open("printed", "w") as printed:
    child = subprocess.Popen(sys.argv[1:], stdout=printed, stderr=subprocess.STDOUT)
used = os.wait4(child.pid, 0)[2]
print(json.dumps([used.ru_utime + used.ru_stime, used.ru_maxrss / 1024]))
"""
COLUMNS = ("case", "code", "nodes", "repeat", "force", "error", "seconds", "megabytes", "message")


@dataclass(frozen=True)
class Case:
    """A sheet, how its driven edge moves, the force that this takes, and whether it is pulled in its plane."""

    force: float
    axis: str
    plane: bool
    increments: int = 10


def column_force() -> float:
    """Force of a clamped inextensible strip of length 10, EI = 12.5, shortened by 2: the elastica."""
    modulus = brentq(lambda m: 2 * (1 - ellipe(m) / ellipk(m)) - 0.2, 1e-6, 0.9)
    return float(4 * np.pi**2 * 12.5 / 10**2 * (2 * ellipk(modulus) / np.pi) ** 2)


CASES = {
    "cracked": Case(164.3e3 * 2e-6, "y", True, 1),
    "slits": Case(52.28e3 * 0.6e-6, "y", True, 1),
    "cantilever": Case(4.0, "z", False),
    "column": Case(column_force(), "x", False),
}


def mesh_of(case: str) -> tuple[kg.TriMesh, float, kg.Material]:
    """Mesh, thickness and material."""
    if case == "cracked":
        sheet = kg.Sheet(shapely.box(0, 0, 0.1, 0.2), [[(0.025, 0.1), (0.075, 0.1)]])
        return sheet.mesh(nodes=3000), 1e-4, FILM
    if case == "slits":
        cuts = kg.cuts.parallel_slits(columns=6, rows=8, width=0.1, height=0.024, length=0.012, margin=0.018)
        return kg.Sheet(shapely.box(0, 0, 0.1, 0.06), cuts).mesh(nodes=4000), 0.125e-3, FILM
    if case == "cantilever":
        return kg.Sheet(shapely.box(0, 0, 10, 1)).mesh(0.3), 0.1, kg.Material(E=1.2e6, nu=0.0)
    return kg.Sheet(shapely.box(0, 0, 10, 1)).mesh(0.2), 0.05, kg.Material(E=1.2e6, nu=0.0)


def model_of(case: str, stiffness: str, mesh: kg.TriMesh, thickness: float, material: kg.Material) -> kg.Model:
    """The sheet with its supports; its driven edge is that of the last constraint."""
    m = kg.Model.from_mesh(mesh, thickness, material, stiffness)
    if CASES[case].plane:
        bottom, top = m.select(boundary="bottom"), m.select(boundary="top")
        pull = CASES[case].force / {"cracked": 164.3e3, "slits": 52.28e3}[case]
        between = np.setdiff1d(np.arange(len(m.nodes)), m.index(bottom))
        m.add(kg.Fix(bottom), kg.Fix([m.nodes[k] for k in between], "z"), kg.Fix(top, "x"), kg.Prescribe(top, y=pull))
        return m
    left, right = m.select(boundary="left"), m.select(boundary="right")
    if case == "cantilever":
        m.add(kg.Fix(left, clamp=True), kg.Prescribe(right, z=6.698))
        return m
    x = m.positions()[:, 0]
    m.perturb(0.005 * (1 - np.cos(2 * np.pi * x / 10.0)))
    m.add(kg.Fix(left, clamp=True), kg.Prescribe(right, x=-2.0, y=0.0, z=0.0, clamp=True))
    return m


# ------------------------------------------------------------------------------------------------- one run


def solve(folder: Path, case: str, stiffness: str) -> float:
    """The force by this package, from the mesh in the folder."""
    with np.load(folder / "sheet.npz") as file:
        mesh = kg.TriMesh(file["points"], file["triangles"])
        material = kg.Material(E=float(file["E"]), nu=float(file["nu"]))
        m = model_of(case, stiffness, mesh, float(file["t"]), material)
    driven = m.constraints[-1]
    if CASES[case].plane:
        return float(kg.LinearStatic(m).run().reaction(driven.group, "y")[-1])
    return float(kg.DisplacementControl(m, tol=TOLERANCE).run().reaction(driven.group, CASES[case].axis)[-1])


def prepare(case: str, folder: Path) -> int:
    """Write the mesh and the inputs of all codes; number of corner nodes."""
    mesh, thickness, material = mesh_of(case)
    m = model_of(case, "plate", mesh, thickness, material)
    pull = m.constraints[-1].values.get("y", 0.0) if CASES[case].plane else 0.0
    np.savez(folder / "sheet.npz", points=mesh.nodes[:, :2], triangles=mesh.triangles, E=material.E, nu=material.nu,
             t=thickness, pull=float(np.max(pull)))  # fmt: skip
    increments = CASES[case].increments
    text = to_abaqus(m, folder / "sheet.inp", increments=increments, element="S6").read_text()
    control = f"*CONTROLS, PARAMETERS=FIELD\n{TOLERANCE}, 1e-2, 0., , 2e-2, 1e-5, 1e-3, 1e-8\n"
    (folder / "sheet.inp").write_text(re.sub(r"(\*STATIC\n.*\n)", lambda found: found[0] + control, text))
    to_openseespy(m, folder / "opensees.py", increments=increments)
    return len(mesh.nodes)


def command(code: str, case: str, folder: Path, python: str) -> list[str]:
    """What runs a code in the folder."""
    if code in OURS:
        return [sys.executable, str(Path(__file__).resolve()), "--solve", str(folder), case, code]
    if code == "CalculiX S6":
        return [shutil.which("ccx") or "ccx", "sheet"]
    if code in PLANE:
        return [python, str(HERE.resolve() / "peers_plane.py"), "sheet.npz", code.split()[-1]]
    return [python, "opensees.py", "out.csv"]


def number(code: str, case: str, folder: Path, printed: str) -> float:
    """The force of the driven edge that a run has found."""
    axis, name = "xyz".index(CASES[case].axis), f"driven_{0}"
    if code in OURS or code in PLANE:
        return float(re.findall(r"FORCE (\S+)", printed)[-1])
    if code == "CalculiX S6":
        assert "Job finished" in printed, printed[-200:]
        totals = re.findall(rf"total force .* for set {name.upper()} .*\n\n(.*)\n", (folder / "sheet.dat").read_text())
        return float(totals[-1].split()[axis])
    with (folder / "out.csv").open() as file:
        return float(list(csv.DictReader(file))[-1][f"{name}_{'xyz'[axis]}"])


def timed(code: str, case: str, folder: Path, python: str, limit: float) -> dict[str, Any]:
    """One run, measured by the kernel: force, CPU seconds, largest memory."""
    alone = {**os.environ, "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
    for left in ("sheet.dat", "out.csv"):
        (folder / left).unlink(missing_ok=True)
    starter = subprocess.Popen(
        [sys.executable, "-I", "-S", "-c", STARTER, *command(code, case, folder, python)],
        cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=alone, start_new_session=True,
    )  # fmt: skip
    try:
        answer, failure = starter.communicate(timeout=limit)
    except subprocess.TimeoutExpired:
        os.killpg(starter.pid, signal.SIGKILL)
        starter.communicate()
        return {"message": f"longer than {limit:g} s"}
    if not answer:
        return {"message": f"not installed: {failure[-80:]}"}
    text = (folder / "printed").read_text(errors="replace")
    seconds, megabytes = json.loads(answer)
    row: dict[str, Any] = {"seconds": seconds, "megabytes": megabytes}
    try:
        row["force"] = abs(number(code, case, folder, text))
        row["error"] = row["force"] / CASES[case].force - 1
    except (AssertionError, IndexError, OSError, ValueError, KeyError):
        row["message"] = " ".join(text.split())[-160:]
    return row


# ---------------------------------------------------------------------------------------------- the table


def shown(rows: list[dict[str, Any]]) -> str:
    """Medians by case and code, as Markdown."""
    lines = ["| case, nodes | code | error | CPU s | MB | runs that ended |", "| --- | --- | --- | --- | --- | --- |"]
    for case in CASES:
        for code in (*OURS, *SHELLS, *PLANE):
            mine = [row for row in rows if row["case"] == case and row["code"] == code]
            if not mine:
                continue
            well = [row for row in mine if row.get("force") not in (None, "")]
            cells = ["-"] * 3
            if well:
                error, seconds, size = (median(float(row[key]) for row in well) for key in FIGURES)
                cells = [f"{100 * error:+.2f} %", f"{seconds:.1f}", f"{size:.0f}"]
            lines.append(f"| {case}, {mine[0]['nodes']} | {code} | {' | '.join(cells)} | {len(well)} of {len(mine)} |")
    return "\n".join(lines)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--python", default=sys.executable, help="interpreter that has openseespy and scikit-fem")
    parser.add_argument("--cases", nargs="+", default=list(CASES), choices=list(CASES))
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--limit", type=float, default=600.0, help="seconds after which a run is ended")
    parser.add_argument("--table", type=Path, help="CSV file for the rows")
    parser.add_argument("--show", type=Path, help="only print the table of this CSV file")
    parser.add_argument("--solve", nargs=3, help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.solve:
        print("FORCE", solve(Path(arguments.solve[0]), *arguments.solve[1:]))
        return
    if arguments.show:
        with arguments.show.open(newline="", encoding="utf-8") as file:
            print(shown(list(csv.DictReader(file))))
        return
    rows: list[dict[str, Any]] = []
    for case in arguments.cases:
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name)
            nodes = prepare(case, folder)
            codes = (*OURS, *SHELLS, *(PLANE if CASES[case].plane else ()))
            for repeat in range(arguments.repeats):
                for code in codes:  # by turns, so that what else the machine does meets all alike
                    if any(row["case"] == case and row["code"] == code and "message" in row for row in rows):
                        continue  # it failed: it would again
                    row = {"case": case, "code": code, "nodes": nodes, "repeat": repeat}
                    row |= timed(code, case, folder, arguments.python, arguments.limit)
                    rows.append(row)
                    print({key: row.get(key) for key in COLUMNS if row.get(key) is not None}, flush=True)
                    if arguments.table:
                        new = not arguments.table.exists()
                        with arguments.table.open("a", newline="", encoding="utf-8") as file:
                            writer = csv.DictWriter(file, COLUMNS, lineterminator="\n")
                            if new:
                                writer.writeheader()
                            writer.writerow(row)
    print(shown(rows))


if __name__ == "__main__":
    main()
