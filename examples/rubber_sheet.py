"""A sheet of rubber with rows of slits, pulled to three times its length: first it bends, then it stretches.

A sheet of neo-Hookean rubber, 8 by 12 cm and 1 mm thick, with slits shifted from row to row. By defaults: one call
pulls it, through buckling and to a strain of 200 %. At first the slits open and the strips between them turn out of the
plane, at little force; in the end the strips lie along the pull and must stretch, the ligaments between slits most.

Two things hold whatever the shape is: the work of the grip is the energy that is stored, and that is less than in the
same sheet without slits, held at its ends and pulled as a whole, of which each piece is stretched by a = 3 along the
pull, 1 across it and 1 / a in thickness: E (a^2 + 1 / a^2 - 2) / 6 per volume, the most that any equilibrium of least
energy can have.

    python examples/rubber_sheet.py           half a minute: a picture, and what it prints
"""

from __future__ import annotations

import numpy as np
import shapely

import kirigami as kg

WIDTH, LENGTH, THICKNESS = 0.08, 0.12, 1e-3
RUBBER = kg.NeoHookean(E=1.5e6)
ROWS, SLIT = 4, 0.04
STRAIN = 2.0


def sheet() -> kg.Sheet:
    """The sheet; every other row has two half slits that end in the rims."""
    cuts = []
    for row in range(ROWS):
        y, half = LENGTH * (row + 1) / (ROWS + 1), SLIT / 2
        spans = [(WIDTH / 2 - half, WIDTH / 2 + half)] if row % 2 == 0 else [(0, half), (WIDTH - half, WIDTH)]
        cuts += [shapely.LineString([(start, y), (end, y)]) for start, end in spans]
    return kg.Sheet(shapely.box(0, 0, WIDTH, LENGTH), cuts, THICKNESS, RUBBER)


def energy_without_slits(strain: float) -> float:
    """What the sheet stores as a whole."""
    a = 1 + strain
    return WIDTH * LENGTH * THICKNESS * RUBBER.E / 6 * (a**2 + 1 / a**2 - 2)


def work_and_energy(results: kg.Results, strain: float) -> tuple[np.ndarray, np.ndarray]:
    """Work of the moved grip up to each step (s,), and the energy stored there (s,)."""
    way, force = results.lam * strain * LENGTH, results.reaction("driven_0", "y")
    work = np.append(0.0, np.cumsum(np.diff(way) * (force[1:] + force[:-1]) / 2))
    return work, sum(results.energy.values())


def main(strain: float = STRAIN, nodes: int = 350) -> None:
    results = kg.stretch(sheet(), strain, nodes=nodes)
    print(results.summary())
    work, energy = work_and_energy(results, strain)
    print(f"work of the grip {work[-1]:.4f} J, energy stored {energy[-1]:.4f} J", end="")
    print(f", {energy[-1] / energy_without_slits(strain):.0%} of that without slits")
    draw(results, strain)


def draw(results: kg.Results, strain: float) -> None:
    """The sheet on the way, and its force beside that of the sheet without slits."""
    from matplotlib import pyplot as plt

    figure = plt.figure(figsize=(12, 4.6))
    for place, share in enumerate((0.1, 0.5, 1.0)):
        ax = figure.add_axes((0.235 * place, 0.0, 0.25, 0.95), projection="3d")
        step = int(np.argmin(np.abs(results.lam - share)))
        results.plot(step, ax=ax, view=(35, -70), color="stress", colorbar=False)
        ax.set_axis_off()
        ax.patch.set_visible(False)
        ax.set_title(f"{share * strain:.0%}", y=1.08)
    figure.text(0.37, 0.03, "colours: von Mises stress, pale where it is least, dark where it is largest", ha="center")
    ax = figure.add_axes((0.75, 0.13, 0.23, 0.8))
    ax.plot(100 * results.lam * strain, results.reaction("driven_0", "y"), label="slit")
    stretch = np.linspace(1, 1 + strain, 60)
    whole = WIDTH * THICKNESS * RUBBER.E / 3 * (stretch - stretch**-3)
    ax.plot(100 * (stretch - 1), whole, "--", label="without slits")
    ax.set(xlabel="strain [%]", ylabel="force [N]", xlim=0, ylim=0)
    ax.legend(frameon=False)
    figure.savefig("rubber_sheet.png", dpi=120)


if __name__ == "__main__":
    main()
