"""Six meshes of the disc with one cut: what converges, how fast, and what it costs.

Fig. 4a-c of Khawale, Mehdizadeh, Brigham, Filipov, "Rapid Kirigami Simulation using the Bar & Hinge Approach": a disc
of radius 3 with one cut, longest edges from 0.13 to 0.35, the dimensionless force f_c over the strain in logarithms.
What the paper does not say, and what is chosen:

* the sizes between: 0.17, 0.21, 0.25 and 0.30. Edges along the cut are 0.4 of the longest (the paper refines there
  automatically, by how much it does not say);
* f_c = F R / (E t^3), with F the force on one grip (the published script adds both grips, which doubles it);
* final strain: 0.036, past the 0.02 of Fig. 6, to show the force turn up;
* cut, thickness, material, grips, strain: those of single_cut_disc.py, which says why;
* imperfection: upper lip up, lower lip down by one thickness, 0.003. The paper says 1e-2 unit length in a caption and
  1e-2 of the radius in the text, which is 3 and 10 thicknesses. With these the disc bends from the first load, the
  buckling point of the curve is rounded off, and the first slope is that of a bent sheet; all else stays.

    python examples/mesh_size_study.py           the four coarser meshes, some minutes
    python examples/mesh_size_study.py --full    all six
"""

from __future__ import annotations

import argparse
import time
from dataclasses import dataclass

import numpy as np
from single_cut_disc import GRIP, MATERIAL, RADIUS, THICKNESS, Pulled, disc, inextensible_limits, pull

import kirigami as kg

EDGES, FULL_EDGES = (0.35, 0.30, 0.25, 0.21), (0.35, 0.30, 0.25, 0.21, 0.17, 0.13)
PER_DECADE = 6  # strains at which all meshes are compared
FINAL = 0.036
SHOWN = 0.02  # strain of the shapes, as in Fig. 6 of the paper


@dataclass(frozen=True)
class Meshed:
    """One mesh and what came of it."""

    max_edge: float
    pulled: Pulled
    seconds: float  # of the processor, with meshing and building

    @property
    def nodes(self) -> int:
        return len(self.pulled.results.rest)

    @property
    def facets(self) -> int:
        return len(self.pulled.results.mesh.triangles)

    def scaled(self, strain: float) -> float:
        """f_c at any strain, by interpolation in logarithms."""
        line = self.pulled
        return float(np.exp(np.interp(np.log(strain), np.log(line.strain[1:]), np.log(line.scaled_force[1:]))))

    @property
    def force(self) -> float:
        """f_c at the strain shown."""
        return float(self.pulled.at(self.pulled.scaled_force, SHOWN))

    @property
    def open_area(self) -> float:
        return float(self.pulled.at(self.pulled.results.open_area()[:, 0], SHOWN))

    @property
    def height(self) -> float:
        return float(self.pulled.at(self.pulled.results.height(), SHOWN))

    @property
    def buckled(self) -> float:
        """Strain at which the slope in logarithms, 1 for a flat sheet, falls through 0.6."""
        return self.pulled.crossing(0.6, rising=False)

    @property
    def stiffened(self) -> float:
        """Strain beyond which the force grows faster than in proportion: the slope rises through 1."""
        return self.pulled.crossing(1.0, rising=True)


def strains(final: float) -> np.ndarray:
    """Strains from the linear regime on, the one shown among them."""
    count = int(np.ceil(PER_DECADE * np.log10(final / 1e-6))) + 1
    return np.unique(np.append(np.geomspace(1e-6, final, count), SHOWN if final > SHOWN else final))


def study(edges: tuple[float, ...], final: float = FINAL, progress: bool = False, **options: float) -> list[Meshed]:
    """The same disc on meshes with these longest edges."""
    found = []
    bump = options.pop("bump", THICKNESS)
    for max_edge in edges:
        start = time.process_time()
        pulled = pull(max_edge, strains(final), progress, bumps=(bump, -bump), **options)
        found.append(Meshed(max_edge, pulled, time.process_time() - start))
    return found


def spread(values: list[float]) -> float:
    """Largest minus smallest over the mean."""
    return (max(values) - min(values)) / float(np.mean(values))


def first_slope(max_edge: float, bump: float) -> float:
    """Force over strain at the first load, over that of the flat sheet in its plane, on one mesh."""
    strain = 1e-6
    bent, upper = disc(max_edge, strain, (bump, -bump))
    flat, grip = disc(max_edge, strain, dim=2)
    in_plane = kg.LinearStatic(flat).run().reaction(grip, "y")[-1]
    return float(kg.DisplacementControl(bent).run().reaction(upper, "y")[-1] / in_plane)


def report(found: list[Meshed]) -> str:
    """The table of the study, and what it says."""
    lines = ["L_max  nodes facets   f_c(0.02)  open area  height  buckles at  stiffens at  CPU s"]
    for one in found:
        lines.append(
            f"{one.max_edge:5.2f} {one.nodes:6d} {one.facets:6d} {one.force:10.3f} {one.open_area:10.4f} "
            f"{one.height:8.4f} {one.buckled:11.3e} {one.stiffened:11.4f} {one.seconds:7.1f}"
        )
    fine = found[-3:]
    point, grips = inextensible_limits()
    slope = found[-1].pulled.slope
    lines += [
        f"three finest: f_c within {100 * spread([one.force for one in fine]):.1f} %, "
        f"buckling strain within {100 * spread([one.buckled for one in fine]):.1f} %",
        f"two finest: open area within {100 * spread([one.open_area for one in found[-2:]]):.2f} %",
        "f_c against the finest: " + ", ".join(f"{100 * (one.force / found[-1].force - 1):+.1f} %" for one in found),
        f"slopes in logarithms on the finest: first {slope[1]:.3f}, least {slope.min():.3f}, last {slope[-1]:.2f}",
        f"stiffening at {found[-1].stiffened:.4f}; an inextensible sheet ends at {point:.4f} between points, at "
        f"{grips:.4f} between grips of half-width {GRIP:g}",
    ]
    return "\n".join(lines)


def picture(found: list[Meshed], path: str) -> None:
    """Four shapes, the force in logarithms, the convergence, and the time."""
    import matplotlib
    from matplotlib import pyplot

    from kirigami.plot.style import BLUE, GREY, INK, SETTINGS, VERMILION

    with matplotlib.rc_context(SETTINGS):
        figure = pyplot.figure(figsize=(10.5, 6.0))
        shown = [found[k] for k in np.linspace(0, len(found) - 1, 4).round().astype(int)]
        for place, one in zip(np.linspace(0, 0.75, 4), shown):
            ax = figure.add_axes([place, 0.55, 0.24, 0.4], projection="3d")
            step = int(np.argmin(np.abs(one.pulled.strain - SHOWN)))
            one.pulled.results.plot(step, ax=ax, view=(34, -58), colorbar=False, edges="all")
            ax.collections[0].set_linewidth(0.25)
            title = f"$L_{{max}}$ = {one.max_edge:g}, {one.facets} facets"
            figure.text(place + 0.12, 0.955, title, ha="center", color=INK)
        colors = pyplot.get_cmap("viridis_r")(np.linspace(0.08, 1, len(found)))
        ax = figure.add_axes([0.07, 0.1, 0.38, 0.4])
        for one, color in zip(found, colors):
            line = one.pulled
            ax.loglog(line.strain[1:], line.scaled_force[1:], color=color, linewidth=1.1, label=f"{one.max_edge:g}")
        line = found[-1].pulled
        ax.loglog(line.strain[1:9], line.scaled_force[1] * line.strain[1:9] / line.strain[1], color=GREY, linewidth=0.7,
                  linestyle=(0, (3, 2)), zorder=0)  # fmt: skip
        for limit in inextensible_limits()[1:]:
            ax.axvline(limit, color=GREY, linewidth=0.8, linestyle=(0, (3, 2)))
            ax.text(0.9 * limit, 0.42, "inextensible", rotation=90, ha="right", va="bottom", fontsize=7, color=INK)
        ax.set(xlabel="strain", ylabel="$f_c = F R / E t^3$")
        ax.legend(title="$L_{max}$", ncols=2, loc="lower center", bbox_to_anchor=(0.55, 0))
        h = np.array([one.max_edge for one in found])
        ax = figure.add_axes([0.53, 0.1, 0.2, 0.4])
        final = found[-1]
        ax.plot(h, [one.force / final.force for one in found], "o-", color=VERMILION, ms=3, label="force")
        ax.plot(h, [one.height / final.height for one in found], "o-", color=BLUE, ms=3, label="height")
        ax.plot(h, [one.open_area / final.open_area for one in found], "o-", color=INK, ms=3, label="open area")
        ax.set(xlabel="$L_{max}$", ylabel=f"over the finest, strain {SHOWN:g}", xlim=(0, None))
        ax.legend()
        ax = figure.add_axes([0.81, 0.1, 0.17, 0.4])
        facets, seconds = [one.facets for one in found], [one.seconds for one in found]
        ax.plot(facets, seconds, "o-", color=BLUE, ms=3)
        ax.set(xlabel="facets", ylabel="seconds of one processor", xlim=(0, None), ylim=(0, 1.1 * max(seconds)))
        figure.savefig(path, dpi=130)


def main(edges: tuple[float, ...] = EDGES, final: float = FINAL, pictures: bool = False) -> list[Meshed]:
    """The meshes with these longest edges, from coarse to fine, pulled to a final strain."""
    found = study(edges, final, progress=pictures)
    if pictures:
        print(report(found))
        for bump in (THICKNESS, 0.1 * THICKNESS):
            print(f"first slope over that of the flat sheet, imperfection {bump:g}: {first_slope(edges[0], bump):.4f}")
        (thin,) = study(edges[-1:], final, thickness=0.5 * THICKNESS, bump=0.5 * THICKNESS)
        thick = found[-1]
        changes = [f"{100 * (thin.scaled(e) / thick.scaled(e) - 1):+.1f} % at strain {e:g}" for e in (1e-3, 5e-3, 2e-2)]
        print(
            f"half the thickness, L_max = {thick.max_edge:g}: f_c changes by {', '.join(changes)}, "
            f"first F / (E t R) by {100 * _stiffness_ratio(thin.pulled, thick.pulled):+.1f} %"
        )
        picture(found, "mesh_size_study.png")
    return found


def _stiffness_ratio(one: Pulled, other: Pulled) -> float:
    """Relative difference of F / (E t R) at the first strain."""
    scaled = [pulled.force[1] / (MATERIAL.E * pulled.thickness * RADIUS) for pulled in (one, other)]
    return float(scaled[0] / scaled[1] - 1)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--full", action="store_true", help="all six meshes")
    main(FULL_EDGES if parser.parse_args().full else EDGES, pictures=True)
