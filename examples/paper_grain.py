"""A sheet of paper with a slit, cut along its grain and across it: how readily the slit would tear on.

Paper is stiffer along the grain, in which its fibres came to lie, than across it: E1 = 2 E2 here, with the shear
modulus that papers have, G12 = 0.387 sqrt(E1 E2) (Baum, Brennan and Habeger, Tappi 64 (1981), 97). A slit of length
2 a across the pull sets free, per area of new crack, under the stress S,

    G = pi a S^2 sqrt(a11 a22 / 2) sqrt(sqrt(a22 / a11) + (2 a12 + a66) / (2 a11))     (Sih, Paris and Irwin, 1965)

with the compliances a_ij along the slit (1) and across it (2): for a slit along the grain sqrt(E1 / E2) times what one
across the grain sets free, whatever the shear modulus is. Grain at any other angle is in the complex roots of the
compliances. The sheet is twenty slits wide, which adds 0.3 % (Feddersen, 1966, for isotropic sheets).

Pulled on, the lips of a long slit are pressed together along the slit and stand up out of the sheet: the picture.

    python examples/paper_grain.py           some forty seconds: a picture, and what it prints
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import shapely

import kirigami as kg

SIDE, SLIT, THICKNESS = 0.4, 0.02, 1e-4
E1, E2, NU12 = 6e9, 3e9, 0.3
G12 = 0.387 * np.sqrt(E1 * E2)
STRESS = 1e6  # at both ends
ANGLES = (0.0, 22.5, 45.0, 67.5, 90.0)  # of the grain to the slit [degrees]
LONG_SLIT, STRAIN = 0.2, 0.006  # of the sheets in the picture
MAGNIFIED = 5.0


def paper(angle: float) -> kg.Orthotropic:
    """Paper with its grain at an angle [degrees] to the slit, which lies along x."""
    return kg.Orthotropic(E1, E2, NU12, G12, np.radians(angle))


def sheet(slit: float, angle: float) -> kg.Sheet:
    """The sheet with a slit in its middle."""
    cut = shapely.LineString([(-slit / 2, 0), (slit / 2, 0)])
    return kg.Sheet(shapely.box(-SIDE / 2, -SIDE / 2, SIDE / 2, SIDE / 2), cut, THICKNESS, paper(angle))


def released(angle: float, nodes: int = 800) -> float:
    """Energy set free per area of new crack, the mean of both tips, while the ends of the sheet bear STRESS."""
    model = kg.Model.from_mesh(sheet(SLIT, angle).mesh(nodes=nodes), stiffness="shell")
    bottom, top = (model.select(boundary=name) for name in ("bottom", "top"))
    pull = STRESS * THICKNESS
    model.add(kg.Fix(model.nodes, "z"), kg.Fix(bottom[0], "xy"), kg.Fix(bottom[-1], "y"))  # a rigid body's motions
    model.add(kg.EdgeLoad(top, (0, pull)), kg.EdgeLoad(bottom, (0, -pull)))
    return float(kg.LinearStatic(model).run().energy_release(0)[-1].mean())


def released_by_theory(angle: float) -> float:
    """The same of an infinite sheet with grain at an angle [degrees], with the correction for its width."""
    compliance = np.linalg.inv(paper(angle).elasticity())
    (a11, a12, a16), (_, a22, a26), (_, _, a66) = compliance
    roots = np.roots([a11, -2 * a16, 2 * a12 + a66, -2 * a26, a22])
    first, second = roots[roots.imag > 0]
    intensity = STRESS**2 * np.pi * SLIT / 2 / np.cos(np.pi * SLIT / (2 * SIDE))
    return float(-0.5 * a22 * ((first + second) / (first * second)).imag * intensity)


def pulled(angle: float, strain: float = STRAIN, nodes: int = 350) -> kg.Results:
    """A sheet with a long slit, its ends gripped and pulled apart."""
    return kg.stretch(sheet(LONG_SLIT, angle), strain, nodes=nodes)


def main(angles: Sequence[float] = ANGLES) -> None:
    found = [released(angle) for angle in angles]
    theory = [released_by_theory(angle) for angle in angles]
    for angle, energy, known in zip(angles, found, theory):
        print(f"grain at {angle:4.1f} degrees to the slit: G = {energy:.4f} J/m^2, theory {known:.4f}")
    print(f"along over across the grain: {found[0] / found[-1]:.4f}, sqrt(E1 / E2) = {np.sqrt(E1 / E2):.4f}")
    sheets = [pulled(angle) for angle in (0.0, 90.0)]
    for angle, results in zip((0, 90), sheets):
        print(f"grain at {angle} degrees: {results.energy_release(0)[-1].mean():.0f} J/m^2 pulled by {STRAIN:.1%}")
    draw(angles, found, sheets)


def draw(angles: Sequence[float], found: Sequence[float], sheets: Sequence[kg.Results]) -> None:
    """Both sheets, coloured by stress, and the energy set free over the angle of the grain."""
    from matplotlib import pyplot as plt

    figure = plt.figure(figsize=(12, 4))
    for place, (results, name) in enumerate(zip(sheets, ("along", "across"))):
        ax = figure.add_axes((0.355 * place - 0.01, -0.08, 0.37, 1.1), projection="3d")
        results.plot(ax=ax, view=(48, -70), color="stress", magnify=MAGNIFIED, colorbar=False)
        ax.set_axis_off()
        ax.patch.set_visible(False)
        ax.set_title(f"slit {name} the grain", y=0.97)
    figure.text(0.36, 0.03, "colours: von Mises stress, pale where it is least, dark where it is largest", ha="center")
    ax = figure.add_axes((0.75, 0.15, 0.23, 0.78))
    smooth = np.linspace(0, 90, 91)
    ax.plot(smooth, [released_by_theory(angle) for angle in smooth], label="complex roots")
    ax.plot(angles, found, "o", label="shell facets")
    ax.set(xlabel="grain to slit [degrees]", ylabel="energy set free [J/m²]", xticks=[0, 30, 60, 90], ylim=0)
    ax.legend(frameon=False)
    figure.savefig("paper_grain.png", dpi=120)


if __name__ == "__main__":
    main()
