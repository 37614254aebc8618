"""A sheet with 2 x 5 curved cells, stretched until the cells pop out of the plane and open (SI units).

The sheet is 2 m wide and 2.4 m high between grips of 0.095 m, 3 mm thick, E = 2.5 GPa, nu = 0.34. The upper grip moves
up by 0.4 m, a fifth of the 2 m in which the cuts lie. The cuts are 5 mm wide. A smooth bump of 0.05 m is the
stress-free imperfection. Open area is counted over the 16 cuts that do not reach the sides.
"""

from __future__ import annotations

import numpy as np
from shapely import LineString, box

import kirigami as kg

PULL, GRIP = 0.4, 0.095


def sheet_model(max_edge: float) -> tuple[kg.Model, list[kg.Node]]:
    """The model and the nodes of its upper grip."""
    cuts = kg.cuts.curved_cells(2, 5, opening=0.005)
    sheet = kg.Sheet(box(0, 0, 2, 2.4), cuts, 0.003, kg.Material(E=2.5e9, nu=0.34))
    lines = [LineString([(0, y), (2, y)]) for y in (GRIP, 2.4 - GRIP)]  # the grips end on edges of the mesh
    m = kg.Model.from_mesh(sheet.mesh(max_edge, lines=lines))
    x, y, _ = m.positions().T
    m.perturb(0.05 * np.exp(-((x - 1) ** 2) - (y - 1.2) ** 2))
    bottom, top = m.select(box=(0, 0, 2, GRIP)), m.select(box=(0, 2.4 - GRIP, 2, 2.4))
    m.add(kg.Fix(bottom), kg.Fix(top, "xz"), kg.Prescribe(top, y=PULL))
    return m, top


def main(pictures: bool = False, max_edge: float = 0.15) -> float:
    """Open area at full stretch [m^2]."""
    m, top = sheet_model(max_edge)
    res = kg.DisplacementControl(m).run(progress=pictures)
    if pictures:
        print(res.summary())
        res.units = "SI"  # so that pictures name units
        m.plot().figure.savefig("curved_cell_sheet.png")
        res.plot().figure.savefig("curved_cell_sheet_open.png")
        ax = res.plot_curve(top, "y", x=res.lam * PULL / 2.0)
        ax.set(xlabel="strain", ylabel="force [N]")
        ax.figure.savefig("curved_cell_sheet_force.png")
        res.animate("curved_cell_sheet.gif")
    inner = [number for number, cut in enumerate(m.mesh.cuts) if not cut.open]
    return float(res.open_area()[-1, inner].sum())


if __name__ == "__main__":
    print(f"open area at strain 0.2: {main(pictures=True):.3f} m^2 (shell model: 1.028 m^2)")
