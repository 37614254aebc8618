"""A topologically polarised lattice: equilateral and scalene triangles, twisted from one hard edge to a soft one.

Sides 1 and (0.8, 0.6, 1); lengths and forces in units of side and of EA = 1; joints are a million times softer than
panels. The lattice ends at both edges on rows with one hinge per cell, so that no edge cuts a triangle.

Pushed gently at one hinge, one edge is far softer than the other while the twist is in the polarised interval, and
the more so the larger the lattice. It is a contrast of small pushes: at 1.92 rad and 15 x 10 cells the hard edge takes
9 times the force at a thousandth of a side, 5 times at a tenth, and no more than the soft one at a half.

Pushed along the whole edge at once, the published contrast is not there. Gripped (the edge moves as one, the opposite
edge is pinned) both edges are equally stiff exactly, at every angle and size: which of the two grips moves is only a
matter of the observer. Free to slide along itself, the edge that is hard at one hinge is even the softer one in the
polarised interval. And if the edges end on rows with two hinges per cell, loose corners make both of them soft.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

import kirigami as kg

JOINT = 1e-6
ANGLES = (1.08, 1.25, 1.40, 1.52, 1.63, 1.72, 1.75, 1.92, 2.00, 2.20, 2.30, 2.40)


def lattice(
    angle: float, columns: int, rows: int, clean: bool = True
) -> tuple[kg.tilings.Tiling, list[int], list[int]]:
    """The tiling, and the vertices along its bottom and top edges."""
    cell = kg.tilings.kagome(angle)
    if clean:  # a scalene triangle stands on each hinge of the bottom row, an equilateral one hangs from the top row
        piece = cell.patch(columns, rows + 1, keep=lambda a, b, panel: b > 0 if panel == 0 else b < rows)
    else:
        piece = cell.patch(columns, rows)
    row, up = cell.lattice
    ends = [np.zeros(2), rows * up] if clean else [cell.points[2], cell.points[2] + rows * up]
    bottom, top = (
        [int(np.argmin(np.linalg.norm(piece.vertices - start - a * row, axis=1))) for a in range(columns)]
        for start in ends
    )
    return piece, bottom, top


def edge_stiffness(piece: kg.tilings.Tiling, pushed: list[int], held: list[int], uniform: bool = False) -> float:
    """Stiffness of an edge while the opposite one is pinned.

    At one hinge: one over the largest compliance of the middle hinge in any direction. Uniform: force per
    displacement of all hinges of the edge, moved together across it and free to slide along it.
    """
    model = piece.model(EA=1.0, stiffness=JOINT)
    model.add(kg.Fix([model.nodes[k] for k in held]))
    if uniform:
        edge = [model.nodes[k] for k in pushed]
        model.add(kg.Prescribe(edge, y=1.0))
        return float(kg.LinearStatic(model).run().reaction(edge, "y")[-1])
    middle = model.nodes[pushed[len(pushed) // 2]]
    compliance = np.zeros((2, 2))
    for axis, force in enumerate(np.eye(2)):
        load = model.add(kg.NodalLoad(middle, force))
        compliance[:, axis] = kg.LinearStatic(model).run().u[-1, model.index(middle)[0], :2]
        model.remove(load)
    return float(1 / np.linalg.eigvalsh(0.5 * (compliance + compliance.T))[-1])


def push_forces(angle: float, columns: int, rows: int, pushes: Sequence[float]) -> list[list[float]]:
    """Forces at the middle hinge of the bottom edge and of the top edge, pushed inwards by given ascending amounts."""
    piece, bottom, top = lattice(angle, columns, rows)
    return [push(piece, *ends, pushes)[0] for ends in ((bottom, top, 1.0), (top, bottom, -1.0))]


def push(
    piece: kg.tilings.Tiling, pushed: list[int], held: list[int], inward: float, pushes: Sequence[float]
) -> tuple[list[float], kg.Results]:
    """Force on the middle hinge of an edge, driven along y and free along x, at each of the pushes."""
    model = piece.model(EA=1.0, stiffness=JOINT)
    middle = model.nodes[pushed[len(pushed) // 2]]
    model.add(kg.Fix([model.nodes[k] for k in held]), kg.Prescribe(middle, y=inward * pushes[-1]))
    targets = np.asarray(pushes) / pushes[-1]
    results = kg.DisplacementControl(model, targets=targets, tol=1e-7).run()
    force = inward * results.reaction(middle, "y")
    return [float(force[results.nearest(target)]) for target in targets], results


def contrast(angle: float, columns: int, rows: int, uniform: bool = False, clean: bool = True) -> float:
    """Stiffness of the bottom edge over that of the top edge."""
    piece, bottom, top = lattice(angle, columns, rows, clean)
    return edge_stiffness(piece, bottom, top, uniform) / edge_stiffness(piece, top, bottom, uniform)


def main(angles: Sequence[float] = ANGLES) -> float:
    """Growth of the contrast from 15 x 10 to 30 x 16 cells at the angle nearest to 1.92 rad, inside the interval."""
    critical = kg.tilings.critical_angles()
    print("critical twist angles:", ", ".join(f"{angle:.4f}" for angle in critical))
    print("angle  polarisation   15x10   30x16   uniform 15x10   loose corners 15x10")
    growth = 0.0
    for angle in angles:
        toward = kg.bloch.polarization(kg.Framework.from_tiling(kg.tilings.kagome(angle))) + 0.0
        small, large = contrast(angle, 15, 10), contrast(angle, 30, 16)
        together, loose = contrast(angle, 15, 10, uniform=True), contrast(angle, 15, 10, clean=False)
        toward_text = f"({toward[0]:4.1f},{toward[1]:4.1f})"
        print(f"{angle:5.2f}  {toward_text} {small:9.2f} {large:7.2f} {together:12.2f} {loose:16.2f}")
        if angle == min(angles, key=lambda other: abs(other - 1.92)):
            growth = large / small
    forces = push_forces(1.92, 15, 10, [0.001, 0.1, 0.5])
    print("15x10 at 1.92, forces [EA] at pushes of 0.001, 0.1 and 0.5 sides, hard and soft edge:")
    print("\n".join("  " + "  ".join(f"{force:.2e}" for force in row) for row in forces))
    print(
        "Polarised lattices grow their contrast with size. At 2.20 the lattice is not polarised, but 0.1 rad from the "
        "border: at this size it still looks so."
    )
    return growth


def pictures() -> None:
    """Hard and soft edge pushed at one hinge, the stiffness of both edges over the twist, and the twist itself."""
    import matplotlib.pyplot as plt

    from kirigami.lattice.picture import animate_path, plot_tiling

    figure, axes = plt.subplots(2, 1, figsize=(6.5, 6.2), layout="constrained")
    piece, bottom, top = lattice(1.92, 15, 10)
    for ax, pushed, held, inward, title in (
        (axes[0], bottom, top, 1.0, "hard edge"),
        (axes[1], top, bottom, -1.0, "soft edge"),
    ):
        (force,), results = push(piece, pushed, held, inward, [0.1])
        middle = pushed[len(pushed) // 2]
        plot_tiling(piece, 4 * results.u[-1], ax=ax, supports=held, forces=[(middle, (0, inward))])
        ax.set_title(f"{title}: force {force:.2g} EA at 0.1 sides (drawn 4 times larger)", fontsize="medium")
    figure.savefig("polarised_lattice.png", dpi=150)
    plt.close(figure)
    figure, ax = plt.subplots(figsize=(5.5, 3.6), layout="constrained")
    for (columns, rows), style in (((15, 10), "--"), ((30, 16), "-")):
        both = np.array([
            [edge_stiffness(piece, bottom, top), edge_stiffness(piece, top, bottom)]
            for piece, bottom, top in (lattice(angle, columns, rows) for angle in ANGLES)
        ])  # fmt: skip
        ax.semilogy(ANGLES, both[:, 0], style, color="#0072b2", label=f"bottom, {columns} x {rows}")
        ax.semilogy(ANGLES, both[:, 1], style, color="#d55e00", label=f"top, {columns} x {rows}")
    low, _, high = kg.tilings.critical_angles()
    ax.axvspan(low, high, color="#eeeeee", zorder=0)
    ax.text((low + high) / 2, 1.02, "polarised", ha="center", transform=ax.get_xaxis_transform(), fontsize="small")
    ax.set(xlabel="twist angle [rad]", ylabel="stiffness at one hinge [EA / side]")
    ax.legend(fontsize="small", frameon=False)
    figure.savefig("polarised_lattice_sweep.png", dpi=150)
    plt.close(figure)

    start = kg.tilings.kagome(1.08).patch(6, 5)
    twist = [kg.tilings.kagome(angle).patch(6, 5).vertices - start.vertices for angle in np.linspace(1.08, 2.40, 30)]
    animate_path(start, twist, "polarised_lattice_twist.gif", frames=30)


if __name__ == "__main__":
    value = main()
    pictures()
    print(f"contrast at 1.92 rad grows {value:.2f} times from 15 x 10 to 30 x 16 cells")
