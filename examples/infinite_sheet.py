"""A sheet of staggered slits without end, from one cell: its law, where it buckles, and in which wave (SI units).

The cell is 20 mm x 10 mm with two slits of 12 mm, of which one runs through its sides; the sheet is 0.1 mm thick,
E = 4 GPa, nu = 0.3. Pulled across the slits and free to contract it stretches in its plane up to the strain at which a
Bloch wave loses its stiffness, and opens into space from there. That strain goes with the thickness squared, as long as
the strain before is small: bending resists with t^3, what compresses the lips grows with t.
"""

from __future__ import annotations

import warnings

import numpy as np

import kirigami as kg

MM = 1e-3
LATTICE = MM * np.array([[20.0, 0.0], [0.0, 10.0]])
SLITS = [MM * np.array(slit) for slit in ([(-6, 2.5), (6, 2.5)], [(4, 7.5), (16, 7.5)])]
PULL = (None, 0.2, 0.0)  # strains along x, along y, and of shear: free, driven, none


def cell_of(thickness: float, max_edge: float, stiffness: str = "shell") -> kg.PeriodicCell:
    """One cell of the sheet."""
    sheet = kg.CellSheet(LATTICE, [slit.tolist() for slit in SLITS], thickness, kg.Material(E=4e9, nu=0.3))
    model = kg.Model.from_mesh(sheet.mesh(max_edge, max_edge / 2), stiffness=stiffness)
    return kg.PeriodicCell(model, sheet.lattice)


def main(pictures: bool = False, max_edge: float = 6 * MM, stiffness: str = "shell") -> float:
    """Buckling strain of the sheet over that of one half as thick."""
    strains = {}
    for thickness in (0.1 * MM, 0.05 * MM):
        found = cell_of(thickness, max_edge, stiffness).buckling(PULL)
        strains[thickness] = float(found.strain[1])
    if pictures:
        draw(max_edge)
    return strains[0.1 * MM] / strains[0.05 * MM]


def draw(max_edge: float) -> None:
    """The law of the cell up to a fifth, and 3 x 5 cells there."""
    import matplotlib.pyplot as plt

    cell = cell_of(0.1 * MM, max_edge)
    section = cell.section()
    t, E = 0.1 * MM, 4e9
    print(f"stretching along and across the slits, over E t: {section[0, 0] / E / t:.3f}, {section[1, 1] / E / t:.3f}")
    found = cell.buckling(PULL)
    print(found)
    cell.impose(PULL)
    cell.model.imperfect()
    res = kg.DisplacementControl(cell.model).run()
    print(res.summary())
    law = cell.law(res)
    print(f"{law}; Poisson's ratio {law.poisson[-1]:.3f}")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", kg.KirigamiWarning)
        sheet = cell.patch(res, (3, 5))
        sheet.units = "SI"  # so that the picture says millimetres
    figure = plt.figure(figsize=(11, 4.5))
    left = figure.add_axes((0.07, 0.12, 0.38, 0.78))
    secant = law.stress[1:, 1] / law.strain[1:, 1] / (E * t)
    left.plot(law.strain[1:, 1], secant, ".-")
    left.axvline(found.strain[1], color="0.6", linestyle="--")
    left.set(xscale="log", xlabel="mean strain along the pull", ylabel="stress over strain, over E t", ylim=(0, None))
    left.set_title("one cell; dashed, where the flat sheet buckles")
    right = figure.add_axes((0.47, 0.0, 0.5, 0.9), projection="3d")
    sheet.plot(ax=right)
    right.set_title(f"3 x 5 cells at a mean strain of {law.strain[-1, 1]:.2f}")
    figure.savefig("infinite_sheet.png", dpi=110)


if __name__ == "__main__":
    print(f"twice as thick, {main(pictures=True):.2f} times the strain at buckling (bending: 4)")
