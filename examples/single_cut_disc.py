"""A disc with one cut, pulled open: three regimes, two branches, and how close the shape and the force are to shells.

The disc of Fig. 6a-c of Khawale, Mehdizadeh, Brigham, Filipov, "Rapid Kirigami Simulation using the Bar & Hinge
Approach": radius 3, one cut through the middle, pulled across the cut to a strain of 0.02. The paper compares with an
experiment whose numbers it does not print; here the comparison is with an independent shell solution. What the paper
does not say, and what is chosen (units are consistent; any will do):

* cut 2.58 long and 0.1 wide, thickness 0.003, E = 760000, nu = 0.34: those of the published script;
* grips: arcs of half-width 0.25 at both ends, held in x and z, free to turn. The published script drives the five
  outermost nodes at each end, so its grips shrink with the mesh; these do not. Nothing else is held;
* strain: displacement of both grips together over the diameter;
* imperfection, stress-free: one lip raised and the other lowered, by 0.05 and 0.01 against shells. The paper's
  figure says 1e-2 unit length, its text 1e-2 of the radius, the script 0.05. The size matters only until the disc has
  buckled. The sign decides for good: with both lips raised, the disc takes the other branch and a third more energy.

    python examples/single_cut_disc.py           about two minutes
    python examples/single_cut_disc.py --full    finer, and on to the strain where the sheet itself must stretch
"""

from __future__ import annotations

import argparse
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import shapely

import kirigami as kg

RADIUS, LENGTH, OPENING, GRIP = 3.0, 2.58, 0.1, 0.25
THICKNESS, MATERIAL, STIFFNESS = 0.003, kg.Material(E=760000, nu=0.34), "plate"
BUMPS = (0.05, -0.01)  # of the upper and the lower lip; the shells had 0.05 and nothing
EDGE, FULL_EDGE = 0.25, 0.15
DATA = Path(__file__).parent / "data"


@dataclass(frozen=True)
class Pulled:
    """What came of one disc."""

    results: kg.Results
    strain: np.ndarray  # (s,)
    force: np.ndarray  # (s,) on the upper grip
    thickness: float

    @property
    def scaled_force(self) -> np.ndarray:
        """f_c = F R / (E t^3), the dimensionless force of the paper (s,)."""
        return self.force * RADIUS / (MATERIAL.E * self.thickness**3)

    @property
    def slope(self) -> np.ndarray:
        """Slope of the force over the strain in logarithms (s,), 1 for a linear structure; 1 at the first two steps."""
        slope = np.ones(len(self.strain))
        slope[1:] = np.gradient(np.log(self.force[1:]), np.log(self.strain[1:]))
        return slope

    def at(self, values: np.ndarray, strain: float) -> Any:
        """Values at a strain that is one of the steps."""
        return values[int(np.argmin(np.abs(self.strain - strain)))]

    def crossing(self, slope: float, rising: bool) -> float:
        """Strain at which the slope in logarithms first falls below a value, or rises above it after its least."""
        above = self.slope > slope
        change = np.flatnonzero(above[1:] & ~above[:-1] if rising else ~above[1:] & above[:-1])
        change = change[change >= np.argmin(self.slope)] if rising else change
        if not len(change):
            return float("nan")
        k = int(change[0])
        part = (slope - self.slope[k]) / (self.slope[k + 1] - self.slope[k])
        return float(np.exp((1 - part) * np.log(self.strain[k]) + part * np.log(self.strain[k + 1])))


def disc(
    max_edge: float, strain: float, bumps: tuple[float, float] = BUMPS, thickness: float = THICKNESS, dim: int = 3
) -> tuple[kg.Model, list[kg.Node]]:
    """The model, pulled to `strain` at load factor 1, and its upper grip."""
    corner = np.arccos(GRIP / RADIUS)  # the grips end in corners of the outline, whatever the mesh
    free = int(np.ceil(2 * corner * RADIUS / max_edge))  # edges along each side; five along each grip
    half = np.concatenate([np.linspace(-corner, corner, free + 1), np.linspace(corner, np.pi - corner, 6)[1:-1]])
    angle = np.concatenate([half, half + np.pi])
    outline = shapely.Polygon(RADIUS * np.column_stack([np.cos(angle), np.sin(angle)]))
    cut = shapely.box(-LENGTH / 2, -OPENING / 2, LENGTH / 2, OPENING / 2)
    m = kg.Model.from_mesh(kg.Sheet(outline, cut).mesh(max_edge), thickness, MATERIAL, STIFFNESS, dim)
    x, y, _ = m.positions().T
    if dim == 3:
        along = np.clip(1 - (2 * x / LENGTH) ** 2, 0, None) ** 2  # vanishes on the ligaments beside the cut
        away = np.exp(-(((np.abs(y) - OPENING / 2) / 2.95) ** 2))
        side = np.where(np.abs(y) < OPENING / 2 - 1e-9, 0, np.where(y > 0, *bumps))
        m.perturb(side * along * away)
    upper = m.select(boundary="outer", where=lambda x, y, z: (np.abs(x) < GRIP + 1e-9) & (y > 0))
    lower = m.select(boundary="outer", where=lambda x, y, z: (np.abs(x) < GRIP + 1e-9) & (y < 0))
    m.add(kg.Fix([*upper, *lower], "xz" if dim == 3 else "x"))
    m.add(kg.Prescribe(upper, y=strain * RADIUS), kg.Prescribe(lower, y=-strain * RADIUS))
    return m, upper


def pull(max_edge: float, strains: Any, progress: bool = False, **options: Any) -> Pulled:
    """Pull a disc through ascending strains; options as for :func:`disc`."""
    final = float(np.max(strains))
    m, upper = disc(max_edge, final, **options)
    targets = np.asarray(strains) / final
    res = kg.DisplacementControl(m, targets=targets, step=float(targets.min())).run(progress=progress)
    return Pulled(res, res.lam * final, res.reaction(upper, "y"), options.get("thickness", THICKNESS))


def three_regimes(max_edge: float, final: float = 0.036, bump: float = THICKNESS, progress: bool = False) -> Pulled:
    """From the first loading on, six strains a decade, with an imperfection of one thickness to see the buckling."""
    decades = np.log10(final / 1e-6)
    strains = np.unique(np.append(np.geomspace(1e-6, final, int(np.ceil(6 * decades)) + 1), 0.02))
    return pull(max_edge, strains, progress, bumps=(bump, -bump))


def inextensible_limits() -> tuple[float, float]:
    """Strains that an inextensible sheet cannot pass: the shortest way round a cut end has become straight.

    The first for point loads and a cut without width, sqrt(1 + (a/R)^2) - 1 (straight-geodesic limit; Chaudhary, Niu,
    Han, Lewicka, Mahadevan, "Geometric mechanics of ordered and disordered kirigami"); the second from end to end of
    the grips and round the two corners of the cut end.
    """
    reach, rise = np.sqrt(RADIUS**2 - GRIP**2), OPENING / 2
    way = 2 * np.hypot(LENGTH / 2 - GRIP, reach - rise) + OPENING
    return float(np.hypot(1, LENGTH / 2 / RADIUS) - 1), float((way - 2 * reach) / (2 * RADIUS))


def read(name: str) -> Any:
    """A table of the shell solution; its file says how it was made."""
    lines = (DATA / name).read_text().splitlines()
    return np.genfromtxt([line for line in lines if not line.startswith("#")], delimiter=",", names=True)


def against_shell(max_edge: float, progress: bool = False) -> tuple[Pulled, dict[str, np.ndarray]]:
    """The disc at the strains of the shell solution, and relative differences there; of heights, over the largest."""
    shell = read("single_cut_disc_shell.csv")[1:]
    found = pull(max_edge, shell["strain"], progress)
    here = [int(np.argmin(np.abs(found.strain - strain))) for strain in shell["strain"]]
    z = found.results.position()[here][..., 2]
    return found, {
        "strain": shell["strain"],
        "force": found.force[here] / shell["force"] - 1,
        "open area": found.results.open_area()[here, 0] / shell["open_area"] - 1,
        "height": found.results.height()[here] / (shell["max_z"] - shell["min_z"]) - 1,
        "upper lip": (z.max(axis=1) - shell["max_z"]) / shell["max_z"],
        "lower lip": (z.min(axis=1) - shell["min_z"]) / shell["min_z"],
    }


def picture(compared: Pulled, off: dict[str, np.ndarray], regimes: Pulled, together: Pulled, path: str) -> None:
    """Both branches in space, the lips beside those of shells, the force in logarithms, and where the energy is."""
    import matplotlib
    from matplotlib import pyplot

    from kirigami.plot.style import BLUE, GREEN, GREY, INK, SETTINGS, VERMILION

    shell, lips = read("single_cut_disc_shell.csv"), read("single_cut_disc_shell_lips.csv")
    with matplotlib.rc_context(SETTINGS):
        figure = pyplot.figure(figsize=(10.5, 6.2))
        for one, place, name in ((regimes, 0.0, "one lip up, one down"), (together, 0.33, "both lips on one side")):
            ax = figure.add_axes([place, 0.5, 0.32, 0.46], projection="3d")
            step = int(np.argmin(np.abs(one.strain - 0.02)))
            one.results.plot(step, ax=ax, view=(34, -58), colorbar=False)
            energy = sum(one.at(values, 0.02) for values in one.results.energy.values())
            figure.text(place + 0.16, 0.965, f"{name}: energy {energy * 1e3:.1f}e-3", ha="center", color=INK)
        ax = figure.add_axes([0.73, 0.61, 0.255, 0.36])
        for strain, color in ((0.0133333, BLUE), (0.0266667, VERMILION)):
            rows = np.abs(lips["strain"] - strain) < 1e-6
            ax.plot(lips["x"][rows], lips["z"][rows], ".", ms=2.5, color=GREY)
            at = compared.at(compared.results.position(), strain)
            loop = compared.results.mesh.cuts[0].loop
            drawn = compared.results.mesh.nodes[loop]
            for sign in (-1, 1):
                lip = loop[np.abs(drawn[:, 1] - sign * OPENING / 2) < 1e-9]
                lip = lip[np.argsort(compared.results.mesh.nodes[lip, 0])]
                ax.plot(at[lip, 0], at[lip, 2], color=color, label=f"strain {strain:.4f}" if sign > 0 else None)
        ax.plot([], [], ".", color=GREY, label="shells")
        ax.set(xlabel="x along the cut", ylabel="height of the lips z", ylim=(None, 1.35))
        ax.legend(loc="upper center", ncols=2, columnspacing=1, handlelength=1.2)

        ax = figure.add_axes([0.07, 0.09, 0.36, 0.36])
        ax.loglog(regimes.strain[1:], regimes.scaled_force[1:], color=BLUE, label="lips raised by one thickness")
        ax.loglog(together.strain[1:], together.scaled_force[1:], color=GREEN, label="both lips on one side")
        scale = RADIUS / (MATERIAL.E * THICKNESS**3)
        ax.loglog(compared.strain[1:], compared.scaled_force[1:], color=VERMILION, label="as the shells")
        ax.loglog(shell["strain"][1:], shell["force"][1:] * scale, "o", ms=3, mfc="none", color=INK, label="shells")
        limit = inextensible_limits()[1]
        ax.axvline(limit, color=GREY, linewidth=0.8, linestyle=(0, (3, 2)))
        ax.text(0.9 * limit, 0.42, "inextensible from grip to grip", rotation=90, ha="right", fontsize=7, color=INK)
        first, last = regimes.crossing(0.6, rising=False), regimes.crossing(1.0, rising=True)
        top = ax.get_ylim()[1]
        for name, strain in (("i", 3e-6), ("ii", np.sqrt(first * last)), ("iii", 1.35 * last)):
            ax.text(strain, 0.95 * top, name, ha="center", va="bottom", color=INK)
        for strain in (first, last):  # where the slope falls below 0.6 and rises above 1
            ax.axvline(strain, color=GREY, linewidth=0.5)
        ax.set(xlabel="strain", ylabel="$f_c = F R / E t^3$")
        ax.legend(loc="lower center", bbox_to_anchor=(0.55, 0.0))

        ax = figure.add_axes([0.5, 0.09, 0.2, 0.36])
        shares = regimes.results.energy_shares()
        ax.semilogx(regimes.strain[1:], shares["bars"][1:], color=BLUE)
        ax.semilogx(regimes.strain[1:], shares["hinges"][1:], color=VERMILION)
        ax.text(2e-5, 0.8, "bars", color=BLUE)
        ax.text(3e-3, 0.88, "hinges", color=VERMILION)
        ax.set(xlabel="strain", ylabel="share of the energy", ylim=(0, 1))

        ax = figure.add_axes([0.78, 0.09, 0.205, 0.36])
        for name, color in (("force", VERMILION), ("height", BLUE), ("open area", GREEN)):
            ax.plot(off["strain"], 100 * off[name], color=color, label=name)
        ax.axhline(0, color=GREY, linewidth=0.5)
        ax.set(xlabel="strain", ylabel="difference from shells [%]")
        ax.legend()
        figure.savefig(path, dpi=130)


def main(pictures: bool = False, max_edge: float = EDGE, final: float = 0.036) -> float:
    """Force at strain 0.0133 with the imperfection of the shell solution."""
    if not pictures:
        return float(pull(max_edge, [1e-4, 0.0133333]).force[-1])
    compared, off = against_shell(max_edge, progress=True)
    for name in ("force", "open area", "upper lip", "lower lip"):
        worst = int(np.argmax(np.abs(off[name])))
        print(
            f"{name}: {100 * off[name][off['strain'] == 0.02][0]:+.1f} % of the shells at strain 0.02, "
            f"at most {100 * off[name][worst]:+.1f} % at {off['strain'][worst]:.4f}"
        )
    regimes = three_regimes(max_edge, final, progress=True)
    together = pull(max_edge, np.geomspace(1e-4, 0.02, 16), True, bumps=(THICKNESS, THICKNESS))
    buckled, stiffened = regimes.crossing(0.6, rising=False), regimes.crossing(1.0, rising=True)
    point, grips = inextensible_limits()
    print(
        f"slope in logarithms {regimes.slope[1]:.3f} at first, below 0.6 from strain {buckled:.2e}, least "
        f"{regimes.slope.min():.3f}, above 1 from strain {stiffened:.4f}, {regimes.slope[-1]:.2f} at the end\n"
        f"an inextensible sheet ends at strain {point:.4f} between points, at {grips:.4f} between these grips"
    )
    for name, one in (("one lip up, one down", regimes), ("both lips on one side", together)):
        energy = {kind: one.at(values, 0.02) for kind, values in one.results.energy.items()}
        parts = ", ".join(f"{kind} {value:.5f}" for kind, value in energy.items())
        print(f"{name}, strain 0.02: force {one.at(one.force, 0.02):.4f}, energy {sum(energy.values()):.5f} ({parts})")
    picture(compared, off, regimes, together, "single_cut_disc.png")
    return float(compared.at(compared.force, 0.0133333))


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--full", action="store_true", help=f"edges of {FULL_EDGE} and strains up to 0.06")
    options = parser.parse_args()
    force = main(True, FULL_EDGE if options.full else EDGE, 0.06 if options.full else 0.036)
    print(f"force at strain 0.0133: {force:.4f} (fine shell model: 0.1097)")
