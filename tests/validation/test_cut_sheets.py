"""Cut sheets that a shell code followed: Kratos Multiphysics 10.4.4, corotational thin-shell triangles, static Newton.

The claims of the publication of the bar-and-hinge model (Khawale, Mehdizadeh, Brigham, Filipov) held against them: the
force within 10 %, the open area within 6 % of shells. On the coarse mesh of the shell code, with its imperfection; a
sheet is computed once for both rows. The force of the code is that of its finest mesh less the error that refinement
shows to remain, 2 to 7 % on the disc, 3 on the strip, 1 on the cells (benchmarks/shell_references.py). Rung `paper` is
bars and hinges with the published constants.
"""

import sys
from functools import cache, partial
from pathlib import Path

from case import Bound, Case, Found, each_rung

sys.path.insert(0, str(Path(__file__).parents[2] / "benchmarks"))
from shell_references import CASES as SHEETS
from shell_references import reference, run

FOLDED = "a flat facet has to strain where the sheet folds along a curve; the error falls with the mesh"
FLAT = "facets of constant strain are stiff on the ligaments beside a slit; the error falls with the mesh"
SOFT = "the published constants make a sheet about 36 times softer in bending than its material"

THIN = "the published constants take 0.85 of the stiffness along the sheet, and ligaments in tension bear the force"
LIPS = "of what is not known: the slit opens by three hundredths of its length, and the reference itself is sure to 2 %"

solved = cache(run)


def values(sheet, quantity, rung):
    row = solved(sheet, "coarse", rung)
    return Found([row[f"{quantity} at {at:g}"] for at in SHEETS[sheet].at], nodes=int(row["nodes"]))


def case(sheet, told, quantity, words, claimed, bounds):
    listed = {rung: Bound(*bound, long=True) for rung, bound in bounds.items()}
    return Case(f"{told}, {words}", reference(sheet)[quantity], words, partial(values, sheet, quantity), listed,
                SHEETS[sheet].at, holds=claimed, most=4700)  # fmt: skip


CASES = [
    case("disc", "disc with a slit", "force", "force", 0.1, {
        "shell": (0.1,), "facet": (0.22, FOLDED), "plate": (0.25, FOLDED), "paper": (0.99, SOFT)}),
    case("disc", "disc with a slit", "open_area", "open area", 0.06, {
        "shell": (0.06,), "facet": (0.06,), "plate": (0.06,), "paper": (0.06,)}),
    case("strip", "strip with a slit", "force", "force", 0.1, {
        "shell": (0.1,), "facet": (0.15, FLAT), "plate": (0.1,), "paper": (0.22, THIN)}),
    case("strip", "strip with a slit", "open_area", "open area", 0.06, {
        "shell": (0.06,), "facet": (0.08, LIPS), "plate": (0.07, LIPS), "paper": (0.06,)}),
    case("cells", "curved cells", "force", "force", 0.1, {
        "shell": (0.1,), "facet": (0.1,), "plate": (0.1,), "paper": (0.99, SOFT)}),
    case("cells", "curved cells", "open_area", "open area", 0.06, {
        "shell": (0.06,), "facet": (0.06,), "plate": (0.06,), "paper": (0.06,)}),
]  # fmt: skip


@each_rung(CASES)
def test_as_the_shell_code(case, rung):
    case.check(rung)
