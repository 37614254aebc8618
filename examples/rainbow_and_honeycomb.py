"""Two sheets of straight slits, pulled to half again their length: necking, height, open area and force (mm, N, MPa).

The sheets of Fig. 6d-g of Khawale, Mehdizadeh, Brigham, Filipov, "Rapid Kirigami Simulation using the Bar & Hinge
Approach": Mylar, cut by laser, clamped at both ends, strain 0.5. The paper gives no size, no thickness, no number of
cells and no measured value; its E = 3.5 GPa is that of another section. Chosen here:

* "rainbow", the parallel cuts: alternating rows of slits across the pull, whose strips rise to arcs;
* "honeycomb", the perpendicular cuts: slits along and across the pull in turn. With square cells no point of the upper
  edge could move by more than sqrt(1 + (0.7)^2) - 1 = 0.22 of the length before the sheet itself must stretch, so a
  strain of 0.5 says that the cells are longer across than along; here 14 by 6, which allows 0.9;
* thickness 0.127 (5 mil), nu = 0.34, rest of the sizes as below;
* imperfection: the lips of every slit across the pull are parted by half a thickness, all to the same side;
* strain is the pull over the free length; Poisson ratio is minus the change of the mean width of the middle half of
  the sheet over that strain; height is from the lowest to the highest point; open area is seen from above.

Edges half as long change Poisson ratio, height and open area by at most 4 %, and raise the force by 12 to 14 %
(honeycomb) and 21 to 25 % (rainbow, whose strips are then three facets wide instead of two; a third less once more
adds 7 %).

    python examples/rainbow_and_honeycomb.py           2,200 nodes each, some 15 seconds of one core
    python examples/rainbow_and_honeycomb.py --full    7,000 nodes each, some 45 seconds
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from shapely import LineString, affinity, box

import kirigami as kg
from kirigami.post.shape import height, poisson_ratio

MYLAR, THICKNESS, STIFFNESS = kg.Material(E=3500.0, nu=0.34), 0.127, "plate"
MARGIN, GRIP = 4.0, 2.0  # uncut strip at each end, of which the clamp holds the outer part
PARTED = 0.5  # of a thickness
STRAINS = (0.1, 0.3, 0.5)  # reached exactly, and these as well for the curves:
EARLY = (0.0005, 0.001, 0.002, 0.005, 0.01, 0.02, 0.05)
EDGE, FULL_EDGE = 3.0, 1.5


@dataclass(frozen=True)
class Pattern:
    """Slits in a rectangle that starts at (0, MARGIN)."""

    width: float
    height: float
    row: float  # distance of rows of slits
    cuts: Sequence[Any]

    @property
    def length(self) -> float:
        """Free length between the clamps."""
        return self.height + 2 * (MARGIN - GRIP)


def rainbow(columns: int = 3, rows: int = 15, pitch: float = 30.0, slit: float = 26.0, row: float = 4.0) -> Pattern:
    """Alternating rows of parallel slits."""
    width, height = columns * pitch, rows * row
    return Pattern(width, height, row, kg.cuts.parallel_slits(columns, rows, width, height, slit, margin=MARGIN))


def honeycomb(columns: int = 6, rows: int = 10, across: float = 14.0, along: float = 6.0, slit: float = 1.7) -> Pattern:
    """Perpendicular slits, `slit` cells long."""
    squares = kg.cuts.perpendicular_slits(columns, rows, cell=1.0, length=slit)
    cuts = [affinity.translate(affinity.scale(cut, across, along, origin=(0, 0)), 0, MARGIN) for cut in squares]
    return Pattern(columns * across, rows * along, along, cuts)


PATTERNS = {"rainbow": rainbow, "honeycomb": honeycomb}


def parted_lips(mesh: kg.TriMesh, pattern: Pattern) -> np.ndarray:
    """Height (n,) by which each node starts off the plane: 1 above and -1 below the middle of slits across the pull."""
    centre = mesh.nodes[mesh.triangles].mean(axis=1)  # a lip is told from the other by the facets it belongs to
    lift = np.zeros(len(centre))
    for cut in pattern.cuts:
        (left, low), (right, high) = cut.coords[0], cut.coords[-1]
        if low != high:
            continue
        middle, half = 0.5 * (left + right), 0.5 * (right - left)
        if left == 0 or right == pattern.width:  # half a slit, open to the side
            middle, half = (left if left == 0 else right), right - left
        along = np.clip(1 - ((centre[:, 0] - middle) / half) ** 2, 0, None) ** 2
        away = centre[:, 1] - low
        lift += np.sign(away) * along * np.clip(1 - np.abs(away) / pattern.row, 0, None)
    total, facets = np.zeros((2, len(mesh.nodes)))
    np.add.at(total, mesh.triangles, lift[:, None])
    np.add.at(facets, mesh.triangles, 1)
    mean: np.ndarray = total / facets
    return mean


def clamped_sheet(
    pattern: Pattern, max_edge: float, thickness: float = THICKNESS, strain: float = 0.5, parted: float = PARTED
) -> tuple[kg.Model, list[kg.Node]]:
    """The model and the nodes of its upper clamp."""
    end = pattern.height + 2 * MARGIN
    sheet = kg.Sheet(box(0, 0, pattern.width, end), pattern.cuts, thickness, MYLAR)
    lines = [LineString([(0, y), (pattern.width, y)]) for y in (GRIP, end - GRIP)]
    m = kg.Model.from_mesh(sheet.mesh(max_edge, cut_edge=max_edge / 1.5, lines=lines), stiffness=STIFFNESS)
    m.perturb(parted * thickness * parted_lips(m.mesh, pattern))
    bottom, top = m.select(box=(0, 0, pattern.width, GRIP)), m.select(box=(0, end - GRIP, pattern.width, end))
    m.add(kg.Fix(bottom), kg.Fix(top, "xz"), kg.Prescribe(top, y=strain * pattern.length))
    return m, top


@dataclass(frozen=True)
class Pulled:
    """What a test in the machine would measure, step by step (s,)."""

    results: kg.Results
    strain: np.ndarray
    force: np.ndarray
    poisson: np.ndarray
    height: np.ndarray
    area: np.ndarray
    seconds: float  # of one core, with meshing and building

    def at(self, strain: float) -> dict[str, float]:
        """The four quantities at one of STRAINS."""
        k = int(np.argmin(np.abs(self.strain - strain)))
        return {name: float(getattr(self, name)[k]) for name in ("poisson", "height", "area", "force")}


def pull(
    pattern: Pattern, max_edge: float = EDGE, strain: float = 0.5, thickness: float = THICKNESS, progress: bool = False
) -> Pulled:
    """Pull one sheet."""
    start = time.process_time()
    m, top = clamped_sheet(pattern, max_edge, thickness, strain)
    targets = [value / strain for value in (*EARLY, *STRAINS) if value < strain]
    res = kg.DisplacementControl(m, targets=targets).run(progress=progress)
    seconds = time.process_time() - start
    shapes, strains = res.position(), res.lam * strain
    return Pulled(
        res,
        strains,
        res.reaction(top, "y"),
        poisson_ratio(shapes, m.mesh, strain=strains),
        height(shapes),
        res.open_area(union=True),
        seconds,
    )


def report(name: str, found: Pulled) -> str:
    """One sheet in words."""
    lines = [
        f"{name}: {len(found.results.rest)} nodes, {len(found.strain)} steps to strain {found.strain[-1]:g}, "
        f"largest relative residual {np.nanmax(found.results.residual):.1e}, {found.seconds:.0f} s"
    ]
    for strain in (value for value in STRAINS if value <= found.strain[-1] + 1e-9):
        row = found.at(strain)
        lines.append(
            f"  strain {strain:g}: Poisson ratio {row['poisson']:+.3f}, height {row['height']:.2f} mm, "
            f"open area {row['area']:.0f} mm^2, force {row['force']:.3f} N"
        )
    return "\n".join(lines)


def picture(found: dict[str, Pulled], path: str) -> None:
    """Both sheets at the end, and what was measured over strain."""
    import matplotlib
    from matplotlib import pyplot

    from kirigami.plot.style import SETTINGS

    colors = dict(zip(PATTERNS, ("#0072b2", "#d55e00")))
    labels = {
        "poisson": "Poisson ratio", "height": "height [mm]", "area": "open area [mm$^2$]", "force": "force [N]"
    }  # fmt: skip
    with matplotlib.rc_context(SETTINGS):
        figure = pyplot.figure(figsize=(10.5, 6.6))
        for number, (name, one) in enumerate(found.items()):
            ax = figure.add_axes([0.5 * number - 0.05, 0.29, 0.6, 0.70], projection="3d")
            one.results.plot(ax=ax, view=(48, -74), colorbar=False)
            figure.text(
                0.5 * number + 0.25, 0.965, f"{name}, strain {one.strain[-1]:g}", color=colors[name], ha="center"
            )
        for number, (key, label) in enumerate(labels.items()):
            ax = figure.add_axes([0.06 + 0.245 * number, 0.08, 0.185, 0.25])
            for name, one in found.items():
                ax.plot(one.strain, getattr(one, key), color=colors[name], label=name)
            ax.set(xlabel="strain", ylabel=label, xlim=(0, None))
            if key == "poisson":
                ax.legend()
            else:
                ax.set_ylim(0, None)
        figure.savefig(path, dpi=100)


def main(
    names: Sequence[str] = tuple(PATTERNS), max_edge: float = EDGE, strain: float = 0.5, pictures: bool = False
) -> dict[str, Pulled]:
    """Pull the sheets of these names."""
    found = {}
    for name in names:
        found[name] = pull(PATTERNS[name](), max_edge, strain, progress=pictures)
        if pictures:
            print(report(name, found[name]), flush=True)
    if pictures:
        picture(found, "rainbow_and_honeycomb.png")
    return found


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--full", action="store_true", help=f"longest edge {FULL_EDGE} mm instead of {EDGE} mm")
    parser.add_argument("--edge", type=float, help="longest edge [mm]")
    options = parser.parse_args()
    main(max_edge=options.edge or (FULL_EDGE if options.full else EDGE), pictures=True)
