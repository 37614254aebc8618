"""A disc with one cut, pulled open: the lips buckle out of the plane, one up and one down.

Radius 3, cut 2.58 long and 0.1 wide, thickness 0.003, E = 760000, nu = 0.34 in consistent units. Arcs of half-width
0.25 at the top and the bottom are held in x and z and pulled apart by 0.16. The stress-free imperfection raises the
upper lip and lowers the lower one by 0.05; without it the disc would stay flat.
"""

from __future__ import annotations

import numpy as np
import shapely

import kirigami as kg

RADIUS, LENGTH, OPENING, PULL, GRIP = 3.0, 2.58, 0.1, 0.08, 0.25


def disc(max_edge: float) -> tuple[kg.Model, list[kg.Node]]:
    """The model and its upper grip."""
    corner = np.arccos(GRIP / RADIUS)  # the grips end in corners of the outline, whatever the mesh
    half = np.concatenate([np.linspace(-corner, corner, 89), np.linspace(corner, np.pi - corner, 6)[1:-1]])
    angle = np.concatenate([half, half + np.pi])
    outline = shapely.Polygon(RADIUS * np.column_stack([np.cos(angle), np.sin(angle)]))
    cut = shapely.box(-LENGTH / 2, -OPENING / 2, LENGTH / 2, OPENING / 2)
    m = kg.Model.from_mesh(kg.Sheet(outline, cut).mesh(max_edge), 0.003, kg.Material(E=760000, nu=0.34))
    x, y, _ = m.positions().T
    along = np.clip(1 - (2 * x / LENGTH) ** 2, 0, None) ** 2  # vanishes on the ligaments beside the cut
    away = np.exp(-(((np.abs(y) - OPENING / 2) / 2.95) ** 2))
    m.perturb(0.05 * np.where(np.abs(y) < OPENING / 2 - 1e-9, 0, np.sign(y)) * along * away)
    upper = m.select(boundary="outer", where=lambda x, y, z: (np.abs(x) < GRIP + 1e-9) & (y > 0))
    lower = m.select(boundary="outer", where=lambda x, y, z: (np.abs(x) < GRIP + 1e-9) & (y < 0))
    m.add(kg.Fix([*upper, *lower], "xz"), kg.Prescribe(upper, y=PULL), kg.Prescribe(lower, y=-PULL))
    return m, upper


def main(pictures: bool = False, max_edge: float = 0.25) -> float:
    """Force at strain 0.0133, half of the full pull."""
    m, upper = disc(max_edge)
    res = kg.DisplacementControl(m, to=1.0 if pictures else 0.5, targets=[0.5]).run(progress=pictures)
    strain = res.lam * PULL / RADIUS
    if pictures:
        print(res.summary())
        m.plot().figure.savefig("single_cut_disc.png")
        res.plot().figure.savefig("single_cut_disc_open.png")
        ax = res.plot_curve(upper, "y", x=strain)
        ax.set_xlabel("strain")
        ax.figure.savefig("single_cut_disc_force.png")
    return float(res.reaction(upper, "y")[res.lam == 0.5][0])


if __name__ == "__main__":
    print(f"force at strain 0.0133: {main(pictures=True):.4f} (fine shell model: 0.1097)")
