"""Rotating squares: Poisson's ratio -1 at every strain, the force of the springs, and contact as an optional effect.

Squares of side l joined at their corners by angle springs k; neighbours turn by phi and -phi, the lattice spacing is
l (cos phi + sin phi). N columns with J joints pulled at their outer corners by the total force

    F = 2 J (M0 + 2 k (phi - phi0)) / (N l (cos phi - sin phi)),

M0 a moment that presses the joints shut (Grima and Evans, J. Mater. Sci. Lett. 19, 1563 (2000), for the kinematics).
"""

from __future__ import annotations

import math

import numpy as np

import kirigami as kg

SIDE, JOINT, EA = 1.0, 1.0, 1e6


def square_lattice(
    angle: float, cells: int, limit: bool = False, closing_moment: float = 0.0
) -> tuple[kg.tilings.Tiling, kg.Model, dict[str, list[kg.Node]]]:
    """2 cells x 2 cells squares, held at the left: the tiling, the model, and the corners along its four edges."""
    piece = kg.tilings.rotating_squares(angle, SIDE).patch(cells, cells)
    model = piece.model(EA=EA, stiffness=JOINT, closing_moment=closing_moment)
    if limit:
        model.add(*piece.angle_limits(model, stiffness=200 * JOINT, width=0.002))
    # Closed squares have whole sides on the border; opened a little, they show which corners lead.
    x, y = kg.tilings.rotating_squares(max(angle, 0.1), SIDE).patch(cells, cells).vertices.T
    edges = {
        name: [model.nodes[k] for k in np.flatnonzero(np.abs(values - at) < 1e-9)]
        for name, values, at in (("left", x, x.min()), ("right", x, x.max()), ("low", y, y.min()), ("high", y, y.max()))
    }
    model.add(kg.Fix(edges["left"], "x"), kg.Fix(edges["low"][0], "y"))
    return piece, model, edges


def stretch(
    angle: float, strain: float, cells: int = 2, limit: bool = False
) -> tuple[kg.tilings.Tiling, kg.Results, np.ndarray, np.ndarray, np.ndarray]:
    """Drive the right edge: tiling, results, total force, and nominal strains along x and y."""
    piece, model, edges = square_lattice(angle, cells, limit)
    length = float(np.ptp(piece.vertices[:, 0]))
    model.add(kg.Prescribe(edges["right"], x=strain * length))
    results = kg.DisplacementControl(model, step=0.02).run()
    high, low = (results.position(edges[name])[..., 1].mean(axis=1) for name in ("high", "low"))
    return piece, results, results.reaction(edges["right"], "x"), results.lam * strain, (high - low) / length - 1


def open_closed(closing_moment: float, strain: float, cells: int = 2) -> tuple[np.ndarray, np.ndarray]:
    """Pull closed squares open by a force, with contact between them: total forces and strains along x."""
    piece, model, edges = square_lattice(0.0, cells, limit=True, closing_moment=closing_moment)
    length = float(np.ptp(piece.vertices[:, 0]))
    leader, *others = edges["right"]
    model.add(kg.Tie(others, leader, "x"), kg.NodalLoad(leader, (1.0, 0)))
    # Walked by the displacement: at the threshold the force has a small maximum, as in buckling.
    results = kg.DisplacementControl(model, to=strain * length, control=(leader, "x"), step=0.002 * length).run()
    return results.lam, results.u[:, model.index(leader)[0], 0] / length


def expected_force(angle: float, along: np.ndarray, cells: int = 2, closing_moment: float = 0.0) -> np.ndarray:
    """The closed form for rigid squares, at nominal strains."""
    count = 2 * cells
    joints = 2 * count * (count - 1)
    start = angle / 2
    spacing = (1 + along) * (math.cos(start) + math.sin(start))
    phi = math.pi / 4 - np.arccos(spacing / math.sqrt(2))
    moment = closing_moment + 2 * JOINT * (phi - start)
    return 2 * joints * moment / (count * SIDE * (np.cos(phi) - np.sin(phi)))


def main() -> float:
    """Largest error of the force against the closed form, relative to its largest value."""
    _, _, force, along, across = stretch(angle=0.3, strain=0.22)
    wanted = expected_force(0.3, along)
    print("strain along, across, Poisson's ratio, force, closed form")
    for row in zip(along[1:], across[1:], -across[1:] / along[1:], force[1:], wanted[1:]):
        print("  ".join(f"{value:9.5f}" for value in row))

    _, _, free, squeezed, _ = stretch(angle=0.3, strain=-0.13)
    _, _, stopped, _, _ = stretch(angle=0.3, strain=-0.13, limit=True)
    print(f"squeezed by {-squeezed[-1]:.2f}: force {free[-1]:.2f} through each other, {stopped[-1]:.2f} with contact")

    pulled, opened = open_closed(closing_moment=0.2, strain=0.05)
    threshold, after = expected_force(0.0, np.array([0.0, opened[-1]]), closing_moment=0.2)
    shut = float(np.interp(0.8 * threshold, pulled, opened))
    print(
        f"pressed shut, rigid squares open at the force {threshold:.3f}: strain {shut:.5f} at 0.8 of it; "
        f"at strain {opened[-1]:.2f} force {pulled[-1]:.3f}, closed form {after:.3f}"
    )
    return float(np.abs(force - wanted).max() / np.abs(wanted).max())


def pictures() -> None:
    """States at three strains, the opening of the closed state, and an animation."""
    import matplotlib.pyplot as plt

    from kirigami.lattice.picture import animate_path, plot_results_panels

    piece, results, _, along, _ = stretch(angle=0.3, strain=0.22, cells=3)
    figure, axes = plt.subplots(1, 3, figsize=(10, 3.8), layout="constrained")
    for ax, part in zip(axes, (0.0, 0.3, 1.0)):
        step = results.nearest(part)
        plot_results_panels(piece, results, step, ax=ax)
        ax.set_title(f"strain {along[step]:.2f}", fontsize="medium")
    figure.savefig("rotating_squares.png", dpi=150)
    plt.close(figure)
    animate_path(piece, results.u, "rotating_squares.gif")

    figure, ax = plt.subplots(figsize=(5, 3.4), layout="constrained")
    opening = np.linspace(0, 0.1, 50)
    for moment, color in ((0.0, "#9aa0a6"), (0.1, "#d55e00"), (0.2, "#0072b2")):
        force, along = open_closed(moment, strain=0.1)
        ax.plot(along, force, ".-", ms=4, color=color, label=f"closing moment {moment:g} k")
        ax.plot(opening, expected_force(0.0, opening, closing_moment=moment), "--", color=color, lw=0.8)
    ax.plot([], [], "k--", lw=0.8, label="closed form")
    ax.set(xlabel="strain", ylabel="force [k / side]", ylim=(0, None))
    ax.legend(frameon=False, fontsize="small")
    figure.savefig("rotating_squares_opening.png", dpi=150)
    plt.close(figure)


if __name__ == "__main__":
    value = main()
    pictures()
    print(f"largest error of the force against the closed form: {value:.1e}")
