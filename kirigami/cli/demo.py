"""``kirigami demo``: the curved-cell sheet of the published study, stretched."""

from __future__ import annotations

import argparse
import time
from pathlib import Path
from typing import Any

import kirigami as kg
from kirigami.cli.options import add_command, print_json, speaker
from kirigami.files import whole_file

DESCRIPTION = """\
Stretch a sheet of 2 x 2.4 m with 2 x 5 curved cells (3 mm thick, E = 2.5 GPa, nu = 0.34) by 0.4 m.

Writes cut_sheet.png, deformed.png, curves.png, stretch.gif and results.npz, which kirigami.load
reads back."""

EPILOG = """\
examples:
  kirigami demo                    pictures and numbers in ./demo
  kirigami demo --full             the same on the fine mesh of the published study
  kirigami demo --folder out -q    say nothing, write to ./out"""


def add(commands: Any) -> None:
    """Options of ``kirigami demo``."""
    parser = add_command(
        commands,
        "demo",
        run,
        help="stretch a built-in sheet and write pictures, an animation and the numbers",
        description=DESCRIPTION,
        epilog=EPILOG,
    )
    parser.add_argument("--full", action="store_true", help="a mesh of about 7,500 nodes instead of 2,500")
    parser.add_argument("--folder", type=Path, default=Path("demo"), help="where to write (default: %(default)s)")
    parser.add_argument(
        "--frames", type=_frames, default=40, metavar="N", help="pictures in the animation (default: %(default)s)"
    )


def run(options: argparse.Namespace) -> int:
    """Stretch the curved-cell sheet of the published study."""

    pull, cut_length = 0.4, 2.0  # m
    model, top = demo_model(max_edge=0.0575 if options.full else 0.15, pull=pull)
    say = speaker(options)
    options.folder.mkdir(parents=True, exist_ok=True)
    say(f"Stretching a sheet of 2 x 5 curved cells by {pull} m, {len(model.nodes)} nodes")
    knee = [0.002, 0.005, 0.01, 0.02, 0.035]  # buckling begins here: points for a smooth curve
    results = kg.DisplacementControl(model, targets=knee).run(progress=not options.quiet)
    solved = time.perf_counter()
    written = write_demo(options, model, results, top, strain=results.lam * pull / cut_length)
    seconds = time.perf_counter() - solved

    force, area = results.reaction(top, "y"), results.open_area(union=True)
    z = results.position()[-1, :, 2]
    peak = int(force.argmax())
    unknowns = int((~results.constrained).sum())
    stats, last = results.stats, results.lam[-1] * pull
    table = {
        "nodes": f"{len(model.nodes):,}, {unknowns:,} unknowns",
        "steps": f"{len(results)} stored, {int(results.stable.sum())} of them stable, "
        f"residual at most {results.residual.max():.0e}",
        "factorisations": f"{stats['factorizations']:,} ({stats['backend']})",
        "wall time": f"{stats['seconds']['total']:.1f} s for the path, {seconds:.1f} s for pictures and files",
        "strain": f"{last / cut_length:.3g} = {last:.3g} m of grip displacement / {cut_length:g} m of cut region "
        f"({last / 2.21:.3g} over the 2.21 m between the grips)",
        "peak force": f"{force[peak]:.4g} N at strain {results.lam[peak] * pull / cut_length:.3g}",
        "open area": f"{area[-1]:.4g} m^2, from {area[0]:.2g} m^2 at rest",
        "height": f"{z.min():.3g} m to {z.max():.3g} m",
    }
    say("\n".join(f"  {name:<15} {value}" for name, value in table.items()))
    for event in results.events:
        say(f"  {'event':<15} {event}")
    say(f"Written to {options.folder}: {', '.join(path.name for path in written)}")
    numbers = {
        "nodes": len(model.nodes),
        "strain": last / cut_length,
        "displacement": last,
        "cut_length": cut_length,
        "largest_force": float(force[peak]),
        "strain_at_largest_force": results.lam[peak] * pull / cut_length,
        "open_area": float(area[-1]),
        "height": float(z.max() - z.min()),
        "steps": len(results),
        "stable_steps": int(results.stable.sum()),
        "largest_residual": float(results.residual.max()),
        "seconds": stats["seconds"]["total"],
        "folder": options.folder,
    }
    print_json(options, numbers)
    return 130 if any(event.kind == "interrupted" for event in results.events) else 0


def demo_model(max_edge: float, pull: float) -> tuple[kg.Model, list[kg.Node]]:
    """The curved-cell sheet between its grips, and the nodes of the upper grip."""
    import numpy as np
    from shapely import LineString, box

    sheet = kg.Sheet(
        box(0, 0, 2, 2.4),
        kg.cuts.curved_cells(2, 5, opening=0.005),
        thickness=0.003,
        material=kg.Material(E=2.5e9, nu=0.34),
    )
    grips = {"lower grip": LineString([(0, 0.095), (2, 0.095)]), "upper grip": LineString([(0, 2.305), (2, 2.305)])}
    model = kg.Model.from_mesh(sheet.mesh(max_edge, lines=grips))
    model.name = "sheet of 2 x 5 curved cells"
    bottom, top = model.select(box=(0, 0, 2, 0.095)), model.select(box=(0, 2.305, 2, 2.4))
    x, y, _ = model.positions().T
    model.perturb(0.05 * np.exp(-((x - 1) ** 2) - (y - 1.2) ** 2))
    model.add(kg.Fix(bottom), kg.Fix(top, "xz"), kg.Prescribe(top, y=pull))
    return model, top


def write_demo(options: argparse.Namespace, model: kg.Model, results: kg.Results, top: Any, strain: Any) -> list[Path]:
    """Write the files of the demo; returns their paths."""
    import matplotlib

    from kirigami.progress import progress_bar

    matplotlib.use("Agg")  # files only: no window, no display needed
    folder: Path = options.folder
    written = [
        save_picture(model.plot(view="top"), folder / "cut_sheet.png"),
        save_picture(results.plot(), folder / "deformed.png"),
        save_picture(draw_curves(results, top, strain), folder / "curves.png"),
    ]
    if len(results) > 1:
        with progress_bar(not options.quiet, "Animation") as bar:
            bar.start(0.0)
            gif = results.animate(
                folder / "stretch.gif", frames=options.frames, on_frame=lambda done: bar.move(done / options.frames)
            )
        written.append(gif)
    written.append(results.save(folder / "results.npz"))
    return written


def draw_curves(results: kg.Results, top: Any, strain: Any) -> Any:
    """Force and open area side by side; returns the last axes."""
    from matplotlib import pyplot

    from kirigami.plot.style import styled

    left, right = styled(pyplot.subplots)(1, 2, figsize=(7.6, 3.1), layout="constrained")[1]
    kg.plot.plot_curve(results, top, "y", x=strain, ax=left)
    kg.plot.plot_open_area(results, x=strain, ax=right)
    left.set_ylabel("force [N]")
    right.set_ylabel("open area [m$^2$]")
    for ax in (left, right):
        ax.set_xlabel("strain (grip displacement / length of cut region)")
    return right


def save_picture(ax: Any, path: Path) -> Path:
    """Write the figure of some axes to a file, and close the figure."""
    from matplotlib import pyplot

    try:
        with whole_file(path) as unfinished:
            ax.figure.savefig(unfinished, dpi=200, format="png")
    finally:
        pyplot.close(ax.figure)
    return path


def _frames(text: str) -> int:
    number = int(text)
    if number < 2:
        raise argparse.ArgumentTypeError("an animation needs at least 2 pictures")
    return number
