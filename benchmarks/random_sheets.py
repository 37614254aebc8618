"""A thousand random cut sheets, stretched by a tenth: none may crash, hang, or store a step that is no equilibrium.

    python benchmarks/random_sheets.py --table random_sheets.csv            # a thousand sheets; goes on where it was
    python benchmarks/random_sheets.py --corrector descent --table ...      # the same in a fifth of the time
    python benchmarks/random_sheets.py --seeds 50 --small                   # the fifty of the test suite

Each seed draws a sheet one unit wide and one thousandth thick with slits, crossing slits, slots and holes, or lines
drawn at random that may reach the edges, enclose pieces or sever the sheet. It is meshed, given an imperfection of a
hundredth of its thickness, held at both ends and stretched by 10 %. Workers are processes of their own with a limit on
the time of a sheet, so that a process that dies or runs on is an outcome like any other:

    reached       the last load factor was reached
    typed error   a KirigamiError; its class and message are in the table
    crash         the worker died, or raised anything else
    hang          the sheet took longer than the limit
    wrong step    a stored step is no equilibrium, by a residual computed here from the objects of the model alone

Whether the cuts sever the sheet is found apart from the package, from the faces of the drawing (shapely.polygonize): a
severed sheet must end in a GeometryError and a connected one must reach the end.
"""

from __future__ import annotations

import argparse
import contextlib
import csv
import json
import os
import signal
import subprocess
import sys
import threading
import time
import warnings
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np
import shapely
from numpy.typing import NDArray

import kirigami as kg

Floats = NDArray[np.float64]

KINDS = ("slits", "crossing slits", "slits and openings", "wild")
THICKNESS = 1e-3
STRETCH = 0.1
TOLERANCE = 1e-8
COLUMNS = (
    "seed", "kind", "clamped", "cuts", "parts", "nodes", "min_angle", "outcome", "error", "last_load_factor", "steps",
    "factorizations", "cutbacks", "relaxations", "unstable_steps", "worst_residual", "seconds", "message",
)  # fmt: skip


# ------------------------------------------------------------------------------------------------------- drawings


def drawing(seed: int, small: bool = False) -> tuple[shapely.Polygon, list[Any], np.random.Generator]:
    """Outline and cuts of a seed, only the first five for a small sheet, and the generator to go on with."""
    random = np.random.default_rng(seed)
    height = float(random.uniform(0.7, 1.5))
    outline = shapely.box(0.0, 0.0, 1.0, height)
    kind = KINDS[seed % len(KINDS)]
    if kind == "wild":
        return outline, _wild_cuts(random, outline)[: 5 if small else None], random
    cuts: list[Any] = []
    if kind == "slits and openings":
        for _ in range(int(random.integers(1, 5))):
            opening = _opening(random, outline)
            if outline.buffer(-0.03).contains(opening) and all(opening.distance(cut) > 0.03 for cut in cuts):
                cuts.append(opening)
    count = int(random.integers(1, 26))
    longest = float(random.uniform(0.15, 0.6))
    gap = float(random.uniform(0.01, 0.04))
    while True:
        try:
            slits = kg.cuts.random_slits(
                count, 1.0, height, (0.3 * longest, longest), seed=int(random.integers(2**31)), gap=gap,
                crossing=kind == "crossing slits",
            )  # fmt: skip
            break
        except kg.GeometryError:
            count = max(1, count // 2)
            longest = max(0.8 * longest, 0.1)
    cuts += [slit for slit in slits if all(slit.distance(cut) > gap for cut in cuts)]
    return outline, cuts[: 5 if small else None], random


def _opening(random: np.random.Generator, outline: shapely.Polygon) -> Any:
    """A round hole or a slot at any place and angle."""
    centre = shapely.Point(random.uniform(outline.bounds[:2], outline.bounds[2:]))
    if random.random() < 0.5:
        return centre.buffer(random.uniform(0.02, 0.15))
    length, width = random.uniform(0.1, 0.4), random.uniform(0.01, 0.05)
    slot = shapely.box(centre.x - length / 2, centre.y - width / 2, centre.x + length / 2, centre.y + width / 2)
    return shapely.affinity.rotate(slot, random.uniform(0, 180))


def _wild_cuts(random: np.random.Generator, outline: shapely.Polygon) -> list[Any]:
    """Lines, bent lines and openings that cross, reach the edge, enclose pieces or pass close to one another."""
    low, high = np.array(outline.bounds[:2]), np.array(outline.bounds[2:])
    cuts: list[Any] = []
    for _ in range(int(random.integers(1, 13))):
        start = random.uniform(low - 0.05, high + 0.05)
        if random.random() < 0.15:
            cut = _opening(random, outline)
        else:
            turns = np.cumsum(random.normal(0.0, 0.8, int(random.integers(1, 5)))) + random.uniform(0, 2 * np.pi)
            steps = random.uniform(0.08, 0.35, len(turns))[:, None] * np.column_stack([np.cos(turns), np.sin(turns)])
            cut = shapely.LineString(np.vstack([start, start + np.cumsum(steps, axis=0)]))
        inside = shapely.intersection(cut, outline)
        if inside.geom_type == cut.geom_type and not inside.is_empty:
            cuts.append(inside)
    return cuts


def parts_of(outline: shapely.Polygon, cuts: list[Any]) -> int:
    """Number of pieces of the sheet: the faces of the drawing that are no opening."""
    openings = shapely.union_all([cut for cut in cuts if cut.geom_type == "Polygon"])
    lines = [cut.exterior if cut.geom_type == "Polygon" else cut for cut in cuts]
    faces = shapely.polygonize([shapely.union_all([outline.exterior, *lines])])
    return sum(not openings.covers(face.representative_point()) for face in faces.geoms)


# ------------------------------------------------------------------------------------------------------ one sheet


def mesh_of(outline: shapely.Polygon, cuts: list[Any], fewest: int, most: int, target: float) -> kg.TriMesh:
    """A mesh of about so many nodes, between the bounds where the drawing allows it."""
    sheet = kg.Sheet(outline, cuts, thickness=THICKNESS, material=kg.Material(E=3.5e9, nu=0.34))
    edge = float(np.sqrt(sheet.area / (0.87 * target)))
    for _ in range(4):
        mesh = sheet.mesh(edge, cut_edge=0.6 * edge)
        nodes = len(mesh.nodes)
        if fewest <= nodes <= most:
            break
        edge *= float(np.clip(np.sqrt(nodes / target), 0.5, 2.0))
    return mesh


def stretch(seed: int, small: bool, corrector: str = "newton") -> dict[str, Any]:
    """Mesh and stretch the sheet of a seed; a row of the table."""
    outline, cuts, random = drawing(seed, small)
    clamped = bool(seed // len(KINDS) % 2)
    row: dict[str, Any] = {
        "seed": seed, "kind": KINDS[seed % len(KINDS)], "clamped": clamped, "cuts": len(cuts),
        "parts": parts_of(outline, cuts),
    }  # fmt: skip
    began = time.process_time()
    try:
        fewest, most = (50, 150) if small else (300, 1500)
        mesh = mesh_of(outline, cuts, fewest, most, np.exp(random.uniform(np.log(1.2 * fewest), np.log(0.8 * most))))
        row.update(nodes=len(mesh.nodes), min_angle=round(mesh.min_angle, 2))
        m = kg.Model.from_mesh(mesh)
        x, y, _ = m.positions().T
        waves = sum(
            random.normal() * np.sin(kx * np.pi * x + random.uniform(0, 2 * np.pi)) * np.sin(ky * np.pi * y / y.max())
            for kx in range(1, 4) for ky in range(1, 4)
        )  # fmt: skip
        m.perturb(waves, amplitude=0.01 * THICKNESS)
        bottom, top = m.select(boundary="bottom"), m.select(boundary="top")
        m.add(kg.Fix(bottom, clamp=clamped), kg.Fix(top, "xz"))
        m.add(kg.Prescribe(top, y=STRETCH * float(np.ptp(y)), clamp=clamped))
        analysis = kg.DisplacementControl(m, tol=TOLERANCE, corrector=corrector)
        try:
            results = analysis.run()
            row["outcome"] = "reached" if results.lam[-1] == 1.0 else "stopped short"
        except kg.ConvergenceError as error:
            assert error.results is not None
            results = error.results
            row.update(outcome="typed error", error=type(error).__name__, message=str(error))
        row["seconds"] = round(time.process_time() - began, 2)
        if results.steps:
            stats = results.stats
            row.update({name: stats[name] for name in ("steps", "factorizations", "cutbacks", "relaxations")})
            row.update(last_load_factor=float(results.lam[-1]), unstable_steps=int(np.sum(~results.stable)))
            row["worst_residual"] = float(f"{max(residuals(m, results)):.3g}")
            # A thousandth of the tolerance is left for the rounding of another order of summation.
            if not row["worst_residual"] <= 1.001 * TOLERANCE:
                row["outcome"] = "wrong step"
    except kg.KirigamiError as error:
        row.update(outcome="typed error", error=type(error).__name__, message=str(error))
    row.setdefault("seconds", round(time.process_time() - began, 2))
    return row


def as_expected(row: dict[str, Any]) -> bool:
    """A severed sheet ends in a GeometryError, a connected one at the last load factor."""
    if int(row["parts"]) > 1:
        return bool(row["outcome"] == "typed error" and row["error"] == "GeometryError")
    return bool(row["outcome"] == "reached")


# ------------------------------------------------------------------------------------- the residual, a second time


def residuals(m: kg.Model, results: kg.Results) -> list[float]:
    """Relative residual of every stored step from the objects of the model: energies differentiated by complex steps.

    Bars have the energy EA L e^2 / 2 with e the Green strain, hinges k (theta - theta_0)^2 / 2 with the cosine and
    sine of theta from the normals of the wings. The slope of a clamped edge is that of its only facet.
    """
    rest = m.positions()
    bars = [item for item in m.elements if isinstance(item, kg.Bar)]
    hinges = [item for item in m.elements if isinstance(item, kg.BendHinge)]
    ends = np.array([m.index(bar.nodes) for bar in bars])
    corners = np.array([m.index(hinge.nodes) for hinge in hinges])
    EA, rigidity = np.array([bar.EA for bar in bars]), np.array([hinge.stiffness for hinge in hinges])
    span = rest[ends[:, 1]] - rest[ends[:, 0]]
    length = np.linalg.norm(span, axis=1)
    clamps, clamp_rigidity = _clamped_edges(m)
    free = np.ones(rest.shape, dtype=bool)
    prescribed = np.zeros(rest.shape)
    for item in m.constraints:
        for axis, values in item.values.items():
            at = m.index(item.group), "xyz".index(axis)
            free[at] = False
            prescribed[at] = 0.0 if item.constant else values
    rest_angle = _angle(rest[corners])
    found = []
    angle, slope = rest_angle, np.zeros(len(clamps))
    for step in results.steps:
        if not np.isfinite(step.u).all() or np.abs(step.u - step.lam * prescribed)[~free].max() > 1e-12:
            return [np.inf]
        force, squares = np.zeros(rest.shape), 0.0
        change = step.u[ends[:, 1]] - step.u[ends[:, 0]]
        strain = (np.einsum("na,na->n", span, change) + 0.5 * np.einsum("na,na->n", change, change)) / length**2
        pull = (EA * strain / length)[:, None] * (span + change)
        parts = [(ends, np.stack([-pull, pull], axis=1))]
        points = (rest + step.u)[corners]
        angle = _unwrapped(_angle(points), angle)
        parts.append((corners, (rigidity * (angle - rest_angle))[:, None, None] * _angle_gradient(points)))
        if len(clamps):
            # the mirror image of the facet stands still next to an edge that moves without turning
            points = _with_mirror_image(rest[clamps], step.u[clamps])
            slope = _unwrapped(_angle(points), slope)
            gradient = _angle_gradient(points)
            gradient[:, 1] += gradient[:, 3]
            parts.append((clamps, (clamp_rigidity * slope)[:, None, None] * gradient[:, :3]))
        for nodes, gradient in parts:
            np.add.at(force, nodes, gradient)
            squares += float((gradient**2).sum())
        unbalanced = float(np.linalg.norm(force[free]))
        rounding = 2e-15 * float(np.linalg.norm(EA))  # a strain that rounding alone may leave
        found.append(unbalanced / np.sqrt(squares) if unbalanced > rounding else 0.0)
    return found


def _angle(points: NDArray[Any]) -> Floats:
    """Fold angle (n,) of hinges (n, 4, 3), nodes i, j, k, l: 0 when flat."""
    cosine, sine = _cosine_and_sine(points)
    return np.arctan2(sine, cosine)


def _cosine_and_sine(points: NDArray[Any]) -> tuple[NDArray[Any], NDArray[Any]]:
    """Cosine and sine of the angle between the normals of the wings, both times the same factor."""
    i, j, k, l = points.swapaxes(0, 1)
    edge = k - j
    one, other = np.cross(edge, i - j), np.cross(l - j, edge)
    size = np.sqrt((edge * edge).sum(axis=1))
    return (one * other).sum(axis=1), (np.cross(one, other) * edge).sum(axis=1) / -size


def _angle_gradient(points: Floats) -> Floats:
    """Derivative (n, 4, 3) of the angle by complex steps, which leave no difference to round."""
    cosine, sine = _cosine_and_sine(points)
    gradient = np.empty(points.shape)
    for node in range(4):
        for axis in range(3):
            moved = points.astype(complex)
            moved[:, node, axis] += 1e-30j
            by_cosine, by_sine = (part.imag / 1e-30 for part in _cosine_and_sine(moved))
            gradient[:, node, axis] = (cosine * by_sine - sine * by_cosine) / (cosine**2 + sine**2)
    return gradient


def _unwrapped(angle: Floats, before: Floats) -> Floats:
    return angle + 2 * np.pi * np.round((before - angle) / (2 * np.pi))


def _clamped_edges(m: kg.Model) -> tuple[NDArray[np.int64], Floats]:
    """Wing and ends (n, 3) of boundary edges within a clamped group, and D L^2 / A of each."""
    assert m.mesh is not None and m.mesh.material is not None
    mesh, material = m.mesh, m.mesh.material
    rigidity = material.E * THICKNESS**3 / (12 * (1 - material.nu**2))
    rows = []
    for group in (m.index(item.group) for item in m.constraints if item.clamp):
        rows += [k for k in np.flatnonzero(mesh.edge_facets[:, 1] < 0) if np.isin(mesh.edges[k], group).all()]
    edges = np.array(sorted(set(rows)), dtype=np.int64)
    area = mesh.facet_areas[mesh.edge_facets[edges, 0]]
    nodes = np.column_stack([mesh.edge_wings[edges, 0], mesh.edges[edges]])
    return nodes, rigidity * mesh.edge_lengths[edges] ** 2 / area


def _with_mirror_image(rest: Floats, u: Floats) -> Floats:
    """Facets (n, 3, 3) at displacements, with their mirror images at rest carried along by the edge."""
    i, j, k = rest.swapaxes(0, 1)
    edge = k - j
    foot = j + edge * (((i - j) * edge).sum(axis=1) / (edge**2).sum(axis=1))[:, None]
    return np.concatenate([rest + u, (2 * foot - i + u[:, 1])[:, None]], axis=1)


# -------------------------------------------------------------------------------------------------------- workers


def work() -> None:
    """Answer each request on standard input, a line of JSON, by a row of the table."""
    warnings.simplefilter("ignore", kg.KirigamiWarning)
    for line in sys.stdin:
        request = json.loads(line)
        seed, limit = request["seed"], request["limit"]
        _limit_processor_time(limit)
        try:
            row = stretch(seed, request["small"], request["corrector"])
        except Exception as error:
            row = {"outcome": "crash", "error": type(error).__name__, "message": str(error)}
        print(json.dumps(row), flush=True)


def _limit_processor_time(seconds: float) -> None:
    """Let the kernel end this process after so much more processor time, where it can."""
    try:
        import resource
    except ImportError:
        return
    _, hardest = resource.getrlimit(resource.RLIMIT_CPU)
    resource.setrlimit(resource.RLIMIT_CPU, (int(time.process_time() + seconds) + 1, hardest))


class Worker:
    """A process that stretches one sheet after another, replaced when it dies."""

    def __init__(self, corrector: str) -> None:
        self.corrector = corrector
        self.process: subprocess.Popen[str] | None = None

    def ask(self, seed: int, small: bool, limit: float) -> dict[str, Any]:
        process = self.process
        if process is None:
            command = [sys.executable, "-W", "ignore", __file__, "--work"]
            # One thread each: workers that share the processors must not wait for one another in small matrices.
            alone = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", **os.environ}
            process = subprocess.Popen(
                command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=alone
            )
            self.process = process
        assert process.stdin is not None and process.stdout is not None and process.stderr is not None
        # Sleeping without end would not use up processor time.
        late = threading.Timer(20 * limit, process.kill)
        late.start()
        request = {"seed": seed, "small": small, "limit": limit, "corrector": self.corrector}
        process.stdin.write(json.dumps(request) + "\n")
        process.stdin.flush()
        answer = process.stdout.readline()
        late.cancel()
        if answer:
            row: dict[str, Any] = json.loads(answer)
        else:
            code = process.wait()
            self.process = None
            timed_out = -code in (getattr(signal, "SIGXCPU", None), getattr(signal, "SIGKILL", None))
            outcome = "hang" if timed_out else "crash"
            row = {"outcome": outcome, "seconds": limit, "message": f"exit {code}: {process.stderr.read()[-300:]}"}
        if "parts" not in row:
            outline, cuts, _ = drawing(seed, small)
            row.update(seed=seed, kind=KINDS[seed % len(KINDS)], cuts=len(cuts), parts=parts_of(outline, cuts))
        return row

    def close(self) -> None:
        if self.process is not None:
            self.process.kill()
            self.process.wait()


def survey(
    seeds: list[int], table: Path | None, workers: int, small: bool, limit: float, seconds: float,
    corrector: str = "newton",
) -> list[dict[str, Any]]:
    """Rows of all seeds; each is appended to the table at once. No sheet is begun after so many seconds."""
    rows: list[dict[str, Any]] = []
    waiting = list(reversed(seeds))
    lock = threading.Lock()
    stop = time.monotonic() + seconds

    def serve() -> None:
        with contextlib.closing(Worker(corrector)) as worker:
            while time.monotonic() < stop:
                with lock:
                    if not waiting:
                        return
                    seed = waiting.pop()
                row = worker.ask(seed, small, limit)
                with lock:
                    rows.append(row)
                    if table is not None:
                        with table.open("a", newline="", encoding="utf-8") as file:
                            csv.DictWriter(file, COLUMNS, lineterminator="\n").writerow(row)
                    if not as_expected(row):
                        print(f"seed {row['seed']}: {row['outcome']} {row.get('error', '')} "
                              f"{str(row.get('message', '')).splitlines()[:1]}", flush=True)  # fmt: skip

    threads = [threading.Thread(target=serve) for _ in range(workers)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    return sorted(rows, key=lambda row: int(row["seed"]))


def summary(rows: list[dict[str, Any]]) -> str:
    """The figures that count."""
    count = Counter(row["outcome"] for row in rows)
    connected = [row for row in rows if int(row["parts"]) == 1]
    severed = [row for row in rows if int(row["parts"]) > 1]
    reached = sum(map(as_expected, connected))
    nodes = [int(row["nodes"]) for row in rows if row.get("nodes")]
    worst = max((float(row["worst_residual"]) for row in rows if row.get("worst_residual")), default=0.0)
    lines = [
        f"{len(rows)} sheets, {min(nodes, default=0)} to {max(nodes, default=0)} nodes, "
        f"{sum(float(row['seconds']) for row in rows):.0f} s of processor time",
        f"crashes {count['crash']}, hangs {count['hang']}, stored steps above tolerance {count['wrong step']} "
        f"(worst residual {worst:.2e})",
        f"connected: {reached} of {len(connected)} reached the end ({100 * reached / max(len(connected), 1):.1f} %)",
        f"severed: {sum(map(as_expected, severed))} of {len(severed)} were refused with a GeometryError",
    ]
    for kind in KINDS:
        of_kind = [row for row in connected if row["kind"] == kind]
        lines.append(f"   {kind}: {sum(map(as_expected, of_kind))} of {len(of_kind)}")
    failed = Counter(f"{row['outcome']} {row.get('error') or ''}".strip() for row in rows if not as_expected(row))
    lines += [f"   not as expected: {name} {number}" for name, number in failed.most_common()]
    return "\n".join(lines)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", type=int, default=1000, help="how many, from --first on")
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--table", type=Path, help="CSV file to append to; seeds found there are not run again")
    parser.add_argument("--workers", type=int, default=2, help="processes at a time")
    parser.add_argument("--limit", type=float, default=300.0, help="seconds of processor time allowed for one sheet")
    parser.add_argument("--seconds", type=float, default=np.inf, help="begin no sheet after this time")
    parser.add_argument("--corrector", default="newton", help="newton, the default of the package, descent or viscous")
    parser.add_argument("--small", action="store_true", help="at most five cuts, and 50 to 150 nodes where they allow")
    parser.add_argument("--work", action="store_true", help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.work:
        work()
        return 0
    seeds = list(range(arguments.first, arguments.first + arguments.seeds))
    before: list[dict[str, Any]] = []
    if arguments.table is not None:
        if arguments.table.exists():
            with arguments.table.open(newline="", encoding="utf-8") as file:
                before = [row for row in csv.DictReader(file) if int(row["seed"]) in set(seeds)]
        else:
            arguments.table.write_text(",".join(COLUMNS) + "\n", encoding="utf-8")
    known = {int(row["seed"]) for row in before}
    todo = [seed for seed in seeds if seed not in known]
    rows = survey(
        todo, arguments.table, arguments.workers, arguments.small, arguments.limit, arguments.seconds,
        arguments.corrector,
    )  # fmt: skip
    print(summary(before + rows))
    return 0 if all(map(as_expected, before + rows)) else 1


if __name__ == "__main__":
    raise SystemExit(main())
