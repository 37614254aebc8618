"""A slit ribbon of PET pulled, let go and pulled again, and a pop-up folded flat and opened: what yield leaves behind.

A ribbon with three slits is pulled beyond yield, brought back to where it bears nothing, and pulled again. Its force
goes round a loop, it stays longer than it was, and its slits stay open. A strip with a perforated fold line is folded
by 150 degrees and let open: the ligaments of the line have yielded, and it opens by little.

Chosen: PET of E = 3.5 GPa, nu = 0.34, that yields at 60 MPa and hardens to 65 MPa at 5 % and 120 MPa at 30 % plastic
strain; 0.5 mm thick. Units are SI.

    python examples/creased_ribbon.py            about a minute
    python examples/creased_ribbon.py --full     meshes twice as fine
"""

from __future__ import annotations

import argparse
from dataclasses import dataclass

import numpy as np
import shapely

import kirigami as kg

PET = kg.Material(E=3.5e9, nu=0.34, yield_stress=60e6, hardening=[(0.05, 65e6), (0.3, 120e6)])
THICKNESS = 0.5e-3
WIDTH, HEIGHT, SLIT, PULL = 0.03, 0.04, 0.022, 0.016  # of the ribbon
LENGTH, BAND, HOLE, FOLD = 0.03, 0.012, 0.0025, 150.0  # of the strip; the fold in degrees


@dataclass(frozen=True)
class Cycle:
    """One way there, back and there again.

    Attributes
    ----------
    results : Results
    way, force : ndarray, shape (s,)
        What is driven, a length or an angle, and the force or moment that works on it.
    """

    results: kg.Results
    way: np.ndarray
    force: np.ndarray

    @property
    def turn(self) -> int:
        """The step where it was furthest for the first time."""
        return int(np.argmax(self.way > 0.999 * self.way.max()))

    @property
    def back(self) -> int:
        """The step where it was back furthest after that."""
        return self.turn + int(np.argmin(self.way[self.turn :]))

    @property
    def left(self) -> float:
        """Where it bears nothing on the way back."""
        way, force = (values[self.turn : self.back + 1] for values in (self.way, self.force))
        if not (force <= 0).any():
            raise ValueError("it still bears something where it is back furthest")
        below = int(np.argmax(force <= 0))
        return float(np.interp(0.0, [force[below], force[below - 1]], [way[below], way[below - 1]]))

    @property
    def free(self) -> int:
        """The step that is nearest to that."""
        return self.turn + int(np.argmin(np.abs(self.way[self.turn : self.back + 1] - self.left)))

    @property
    def work(self) -> np.ndarray:
        """Work of the drive (s,), by the trapezium rule."""
        return np.concatenate([[0.0], np.cumsum(0.5 * (self.force[1:] + self.force[:-1]) * np.diff(self.way))])

    @property
    def energy(self) -> np.ndarray:
        """What is stored and what is lost (s,)."""
        return np.asarray(sum(self.results.energy.values()))


def ribbon(max_edge: float = 0.005) -> Cycle:
    """Pulled by the top, brought back to a fifth of the way, and pulled again."""
    slits = [
        shapely.LineString([(0.0, 0.25 * HEIGHT), (SLIT, 0.25 * HEIGHT)]),
        shapely.LineString([(WIDTH - SLIT, 0.5 * HEIGHT), (WIDTH, 0.5 * HEIGHT)]),
        shapely.LineString([(0.0, 0.75 * HEIGHT), (SLIT, 0.75 * HEIGHT)]),
    ]
    sheet = kg.Sheet(shapely.box(0, 0, WIDTH, HEIGHT), slits, THICKNESS, PET)
    m = kg.Model.from_mesh(sheet.mesh(max_edge=max_edge), stiffness="shell")
    m.imperfect(amplitude=0.5 * THICKNESS, seed=1)
    top = m.select(boundary="top")
    m.add(kg.Fix(m.select(boundary="bottom"), clamp=True), kg.Prescribe(top, x=0, y=PULL, z=0, clamp=True))
    results = kg.DisplacementControl(m, targets=[*np.linspace(0.05, 1, 20), *np.linspace(0.95, 0.2, 16), 0.6]).run()
    return Cycle(results, PULL * results.lam, results.reaction(top, "y"))


def popup(max_edge: float = 0.0022) -> Cycle:
    """Folded about a line of holes, and brought back until it bears nothing."""
    places = np.arange(0.5, 4) * BAND / 4
    holes = [shapely.box(-0.0004, y - 0.5 * HOLE, 0.0004, y + 0.5 * HOLE) for y in places]
    sheet = kg.Sheet(shapely.box(-0.5 * LENGTH, 0, 0.5 * LENGTH, BAND), holes, THICKNESS, PET)
    m = kg.Model.from_mesh(sheet.mesh(max_edge=max_edge), stiffness="shell")
    arm = 0.3 * LENGTH  # beyond it both halves are held
    left = m.select(where=lambda x, y, z: x < -arm)
    right = m.select(where=lambda x, y, z: x > arm)
    angle = np.radians(FOLD)
    m.add(kg.Grip(left), kg.Grip(right, move=(None, 0, None), turn=(0, -angle, 0)))
    results = kg.DisplacementControl(m, targets=[*np.linspace(0.04, 1, 25), *np.linspace(0.97, 0.7, 10)], to=0.65).run()
    moment = results.moment(right)[:, 1]
    return Cycle(results, angle * results.lam, moment * np.sign(moment[20]))


def picture(pulled: Cycle, folded: Cycle, path: str) -> None:
    """The ribbon at its furthest and let go, both coloured by plastic strain, and the two loops."""
    import matplotlib.pyplot as plt

    figure = plt.figure(figsize=(11, 7))
    for place, (cycle, step, title) in enumerate([
        (pulled, pulled.turn, "pulled"), (pulled, pulled.free, "let go"), (folded, folded.turn, "folded"),
        (folded, folded.free, "let open"),
    ]):  # fmt: skip
        ax = figure.add_subplot(2, 3, (1, 2, 4, 5)[place], projection="3d")
        cycle.results.plot(step, ax=ax, color="plastic strain")
        ax.set_title(title)
    for place, (cycle, across, up) in enumerate([
        (pulled, "pull [mm]", "force [N]"), (folded, "fold [degrees]", "moment [N mm]"),
    ]):  # fmt: skip
        ax = figure.add_subplot(2, 3, 3 * place + 3)
        scale = (1e3, 1.0) if place == 0 else (180 / np.pi, 1e3)
        ax.plot(scale[0] * cycle.way, scale[1] * cycle.force)
        ax.axhline(0, color="0.7", linewidth=0.8)
        ax.set_xlabel(across)
        ax.set_ylabel(up)
    figure.tight_layout()
    figure.savefig(path, dpi=110)


def main(pictures: bool = False, full: bool = False) -> float:
    """Work of the pull over what the ribbon stores and has lost in the loop: 1 where all is accounted for."""
    pulled = ribbon(0.0025 if full else 0.005)
    lost = pulled.results.energy["dissipated"][-1]
    if pictures:
        print(f"ribbon: {100 * pulled.left / PULL:.0f} % of the pull stays, {1e3 * pulled.left:.1f} mm")
        print(f"work {1e3 * pulled.work[-1]:.4g} mJ, {1e3 * lost:.4g} mJ of it lost, {1e3 * pulled.energy[-1]:.4g} mJ "
              "stored and lost together")  # fmt: skip
        folded = popup(0.0012 if full else 0.0022)
        print(f"pop-up: folded by {FOLD:.0f} degrees it comes to rest at {np.degrees(folded.left):.0f}")
        picture(pulled, folded, "creased_ribbon.png")
    return float(pulled.work[-1] / pulled.energy[-1])


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--full", action="store_true", help="meshes twice as fine")
    print(f"work over energy: {main(True, parser.parse_args().full):.4f}")
