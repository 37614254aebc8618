"""Sheets with random cuts, apart and crossing, stretched by 12 %: irregular kirigami needs nothing of its own.

Fig. 7 of Khawale, Mehdizadeh, Brigham, Filipov, "Rapid Kirigami Simulation using the Bar & Hinge Approach" (SI units):
one edge fixed, the opposite one pulled to a strain of 12 %, height in colour. The paper shows two patterns and says
no more. All else is chosen:

* sheet: 100 mm wide, 116 mm long between the grips (strain is the pull over that), 0.2 mm thick, E = 3.5 GPa,
  nu = 0.34;
* cuts: straight, without width, of random place, length (15 to 40 mm) and direction, drawn from a seed. Apart: 26, at
  least 4.5 mm from each other, within 35 degrees of the direction across the pull. Crossing: 26, in any direction;
  groups that cross become one cut. They never enclose a piece and leave the sheet in one part; meshing a drawing that
  does not is an error;
* grips: the straight edges, held in all directions and free to turn;
* imperfection: the 20 softest shapes of the held sheet, with random weights from the same seed, one thickness high.

    python examples/irregular_cuts.py             two sheets, coarse meshes
    python examples/irregular_cuts.py --full      the same with half the edge length, beside the coarse ones
    python examples/irregular_cuts.py --seeds 10  how many of ten random sheets of each kind come to 12 %
"""

from __future__ import annotations

import argparse
import time
from dataclasses import dataclass

import numpy as np
import shapely

import kirigami as kg

WIDTH, PATTERN, MARGIN, THICKNESS = 0.1, 0.1, 0.008, 0.2e-3  # [m]
MATERIAL, STIFFNESS = kg.Material(E=3.5e9, nu=0.34), "plate"
COUNT, LENGTHS, GAP = 26, (0.015, 0.04), 0.0045
STRAIN, MODES = 0.12, 20
EDGE, FULL_EDGE, SURVEY_EDGE = 0.007, 0.0035, 0.01
SHOWN = {"apart": 0, "crossing": 0}  # seeds of the sheets in the picture


@dataclass(frozen=True)
class Stretched:
    """What came of one sheet."""

    results: kg.Results
    strain: np.ndarray  # (s,)
    force: np.ndarray  # (s,) [N]
    open_area: np.ndarray  # (s,) seen from above, of all cuts [m^2]
    seconds: float  # of the processor
    reached: bool  # the final strain
    why: str = ""  # it was not reached


def cut_sheet(kind: str, seed: int) -> kg.Sheet:
    """A sheet whose cuts are "apart" or "crossing"."""
    crossing = kind == "crossing"
    angles = (0.0, 180.0) if crossing else (-35.0, 35.0)
    cuts = kg.cuts.random_slits(
        COUNT, WIDTH, PATTERN, LENGTHS, seed=seed, gap=GAP, margin=MARGIN, crossing=crossing, angles=angles
    )
    return kg.Sheet(shapely.box(0, 0, WIDTH, PATTERN + 2 * MARGIN), cuts, THICKNESS, MATERIAL)


def sheet_model(kind: str, seed: int, max_edge: float) -> tuple[kg.Model, list[kg.Node]]:
    """The model, and the nodes of its upper edge."""
    m = kg.Model.from_mesh(cut_sheet(kind, seed).mesh(max_edge), stiffness=STIFFNESS)
    m.name = f"cuts {kind}, seed {seed}"
    bottom, top = m.select(boundary="bottom"), m.select(boundary="top")
    m.add(kg.Fix(bottom), kg.Fix(top, "xz"), kg.Prescribe(top, y=STRAIN * (PATTERN + 2 * MARGIN)))
    weights = np.random.default_rng(seed).uniform(-1, 1, MODES)
    shapes = [mode.shape for mode in kg.Eigen(m, n=MODES).run()]
    m.perturb(np.tensordot(weights, shapes, 1), amplitude=THICKNESS)
    return m, top


def stretch(kind: str, seed: int, max_edge: float = EDGE, final: float = STRAIN, progress: bool = False) -> Stretched:
    """Stretch one sheet; where that fails, keep what was reached."""
    start = time.process_time()
    m, top = sheet_model(kind, seed, max_edge)
    why = ""
    try:
        res = kg.DisplacementControl(m, to=final / STRAIN).run(progress=progress)
    except kg.ConvergenceError as error:
        res, why = error.results, str(error)
    reached = bool(len(res) and res.lam[-1] == final / STRAIN)
    seconds = time.process_time() - start
    return Stretched(
        res, res.lam * STRAIN, res.reaction(top, "y"), res.open_area(union=True), seconds, reached, why
    )


def survey(seeds: int, max_edge: float = SURVEY_EDGE) -> dict[str, list[Stretched]]:
    """Random sheets of both kinds, one after the other."""
    found: dict[str, list[Stretched]] = {}
    for kind in SHOWN:
        for seed in range(seeds):
            one = stretch(kind, seed, max_edge)
            found.setdefault(kind, []).append(one)
            print(f"{kind}, seed {seed}: {report(one)}", flush=True)
        print(f"{kind}: {sum(one.reached for one in found[kind])} of {seeds} reached strain {STRAIN:g}", flush=True)
    return found


def report(one: Stretched) -> str:
    """One sheet in words."""
    res = one.results
    words = [
        f"{len(res.rest)} nodes, {len(res.mesh.cuts)} cuts, strain {one.strain[-1]:.4f}, force {one.force[-1]:.1f} N",
        f"open area {1e6 * one.open_area[-1]:.0f} mm^2, height {1e3 * res.height()[-1]:.2f} mm",
        f"{np.count_nonzero(res.stable)} of {len(res)} steps stable, residual {np.nanmax(res.residual):.0e}",
        f"{one.seconds:.0f} s",
    ]
    return ", ".join(words) + ("; " + one.why[:200] if one.why else "")


def picture(found: dict[str, Stretched], path: str) -> None:
    """Both sheets from above and in space."""
    import matplotlib
    from matplotlib import pyplot

    from kirigami.plot.style import INK, SETTINGS, color_bar

    with matplotlib.rc_context(SETTINGS):
        figure = pyplot.figure(figsize=(10.5, 3.9))
        for place, (kind, one) in zip((0.0, 0.5), found.items()):
            height = 1e3 * one.results.position()[-1, :, 2]
            top = figure.add_axes([place + 0.005, 0.02, 0.2, 0.86])
            one.results.plot(ax=top, view="top", colorbar=False, color=height, cmap="viridis")
            top.set_axis_off()
            solid = figure.add_axes([place + 0.205, 0.1, 0.235, 0.75], projection="3d")
            solid.patch.set_visible(False)
            one.results.plot(ax=solid, view=(38, -60), colorbar=False, color=height, cmap="viridis")
            scale = matplotlib.cm.ScalarMappable(matplotlib.colors.Normalize(height.min(), height.max()), "viridis")
            color_bar(solid, scale, "height z [mm]", figure.add_axes([place + 0.444, 0.25, 0.007, 0.45]))
            title = f"{COUNT} cuts {kind}" + (f" in {len(one.results.mesh.cuts)} groups" if kind == "crossing" else "")
            words = f"{title}: force {one.force[-1]:.0f} N, open area {1e6 * one.open_area[-1]:.0f} mm$^2$"
            figure.text(place + 0.23, 0.94, words, ha="center", color=INK)
        figure.savefig(path, dpi=130)


def main(max_edge: float = EDGE, final: float = STRAIN, pictures: bool = False) -> dict[str, Stretched]:
    """One sheet of each kind."""
    found = {kind: stretch(kind, seed, max_edge, final, progress=pictures) for kind, seed in SHOWN.items()}
    if pictures:
        for kind, one in found.items():
            print(f"{kind}, edges of {1e3 * max_edge:g} mm: {report(one)}", flush=True)
        picture(found, "irregular_cuts.png")
    return found


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--full", action="store_true", help=f"also with edges of {1e3 * FULL_EDGE:g} mm")
    parser.add_argument("--seeds", type=int, metavar="N", help="stretch N random sheets of each kind, without pictures")
    options = parser.parse_args()
    if options.seeds:
        survey(options.seeds)
    else:
        coarse = main(pictures=not options.full)
        if options.full:
            fine = main(FULL_EDGE, pictures=True)
            for kind in SHOWN:
                force = coarse[kind].force[-1] / fine[kind].force[-1] - 1
                area = coarse[kind].open_area[-1] / fine[kind].open_area[-1] - 1
                print(f"{kind}: twice the edge length changes force by {100 * force:+.1f} %, area {100 * area:+.1f} %")
