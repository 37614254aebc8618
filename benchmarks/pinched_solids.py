"""The pinched cylinder of Sze, Liu and Lo (3.6) as a solid, run by CalculiX: which of their table and ours it is with.

    python benchmarks/pinched_solids.py [around] [along] [deflection]     minutes; needs the program ccx

An octant of 20-node bricks with reduced integration, one over the thickness: no theory of shells in them, but Green's
strain and Hooke's law. The crown is pushed in by its middle; what it bears is told at the deflections of the table. The
default mesh has nodes as far apart as the shell facets of tests/validation/test_sze.py have.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "tests" / "validation"))
RADIUS, HALF, THICKNESS, E, NU, FULL = 100.0, 100.0, 1.0, 30e3, 0.3, 12000.0
CORNERS = ((0, 0), (2, 0), (2, 2), (0, 2))
MIDDLES = ((1, 0), (2, 1), (1, 2), (0, 1))


def deck(around: int, along: int, deflection: float) -> str:
    """The input file; nodes are told by half steps around, along and through."""
    numbers: dict[tuple[int, int, int], int] = {}
    places = []

    def node(i: int, j: int, k: int) -> int:
        if (i, j, k) not in numbers:
            numbers[i, j, k] = len(numbers) + 1
            angle, radius = np.pi / 2 * i / (2 * around), RADIUS + THICKNESS * (k - 1) / 2
            places.append((HALF * j / (2 * along), radius * np.cos(angle), radius * np.sin(angle)))
        return numbers[i, j, k]

    lines = ["*ELEMENT, TYPE=C3D20R, ELSET=ALL"]
    for number in range(around * along):
        i, j = 2 * (number // along), 2 * (number % along)
        rows = [(CORNERS, 0), (CORNERS, 2), (MIDDLES, 0), (MIDDLES, 2), (CORNERS, 1)]
        nodes = [str(node(i + a, j + b, k)) for places_of, k in rows for a, b in places_of]
        lines += [f"{number + 1}," + ",".join(nodes[:10]) + ",", ",".join(nodes[10:])]
    held, tied = [], []
    for (i, j, k), number in numbers.items():  # planes of symmetry, and the diaphragm, which holds the middle surface
        held += [(number, axis) for axis, on in ((1, j == 0), (2, i == 2 * around), (3, i == 0)) if on]
        if j == 2 * along and k == 1:
            held += [(number, axis) for axis, free in ((2, i != 2 * around), (3, i != 0)) if free]
        if j == 2 * along and k == 0 and i % 2:
            tied += [(number, numbers[i, j, 2], axis) for axis in (2, 3)]
    crown = numbers[2 * around, 0, 1]
    for one, other, axis in tied:
        lines += ["*EQUATION", "2", f"{one},{axis},1.,{other},{axis},1."]
    lines += ["*NSET, NSET=CROWN", str(crown), "*MATERIAL, NAME=M", "*ELASTIC", f"{E},{NU}"]
    lines += ["*SOLID SECTION, ELSET=ALL, MATERIAL=M", "*BOUNDARY", *(f"{n},{axis},{axis},0." for n, axis in held)]
    lines += ["*STEP, NLGEOM, INC=600", "*STATIC", "0.01,1.,1e-6,0.02", "*BOUNDARY", f"{crown},3,3,{-deflection}"]
    lines += ["*NODE PRINT, NSET=CROWN", "U,RF", "*END STEP"]
    head = ["*NODE", *(f"{n},{x:.10g},{y:.10g},{z:.10g}" for n, (x, y, z) in enumerate(places, 1))]
    return "\n".join([*head, *lines]) + "\n"


def curve(text: str) -> tuple[np.ndarray, np.ndarray]:
    """Deflections and load factors of all increments."""
    found: dict[str, list[float]] = {"displacements": [], "forces": []}
    kind = ""
    for line in text.splitlines():
        kind = next((name for name in found if name in line), kind)
        words = line.split()
        if len(words) == 4 and words[0].isdigit():
            found[kind].append(float(words[3]))
    return -np.array(found["displacements"]), -4 / FULL * np.array(found["forces"])


def main() -> None:
    from test_sze import PINCHED

    given = [*sys.argv[1:], *("30", "16", "66")[len(sys.argv) - 1 :]]
    around, along, deflection = int(given[0]), int(given[1]), float(given[2])
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "pinched.inp").write_text(deck(around, along, deflection))
        subprocess.run(["ccx", "-i", "pinched"], cwd=folder, stdout=subprocess.DEVNULL, check=False)
        at, load = curve((Path(folder) / "pinched.dat").read_text())
    print(f"{around} x {along} bricks, {len(at)} increments, up to a deflection of {at[-1]:.4g}")
    for factor, wanted in PINCHED:
        if wanted <= at[-1]:
            print(f"deflection {wanted:7.3f}: table {factor:.3f}, solid {np.interp(wanted, at, load):.4f}, "
                  f"{100 * (np.interp(wanted, at, load) / factor - 1):+.1f} %")  # fmt: skip


if __name__ == "__main__":
    main()
