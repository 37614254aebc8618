"""A nonreciprocal lattice: pushed from the left it answers otherwise than pushed from the right.

Squares stand corner on corner in columns, the lowest corners pinned; rhombi that lean by pi/16 link the columns. For
small forces the stiffness matrix is symmetric, so both ways transmit alike (Maxwell and Betti); at finite turns the
lean makes the difference. State A pushes the middle of the left edge and reads the right one, state B the reverse.

Side 6.75 mm and E = 3.5 GPa are published values; sheet, ligament and arrangement are choices made here: 5 columns of
3 squares, sheet 1 mm, ligaments 0.6 mm wide and 1.5 mm long (0.042 N m / rad).
"""

from __future__ import annotations

import math

import numpy as np

import kirigami as kg

SIDE, E, THICKNESS = 6.75e-3, 3.5e9, 1e-3
JOINT = kg.tilings.Ligament(E, THICKNESS, width=0.6e-3, length=1.5e-3).stiffness
COLUMNS, ROWS = 5, 3


def lattice(angle: float) -> tuple[kg.tilings.Tiling, list[int], int, int]:
    """The tiling, its pinned vertices, and the middles of the left and the right edge."""
    cell = kg.tilings.square_rhombus(angle, SIDE)
    piece = cell.patch(COLUMNS, ROWS, keep=lambda a, b, panel: panel == 0 or a < COLUMNS - 1)
    row, up = cell.lattice
    middle = ROWS // 2 * up

    def nearest(point: np.ndarray) -> int:
        return int(np.argmin(np.linalg.norm(piece.vertices - point, axis=1)))

    pins = [nearest(a * row) for a in range(COLUMNS)]
    return piece, pins, nearest(cell.points[2] + middle), nearest(cell.points[1] + (COLUMNS - 1) * row + middle)


def transmit(angle: float, state: str, force: float = 10.0, joint: float = JOINT, step: float = 0.1) -> kg.Results:
    """Push the left (state "A") or the right edge ("B") inwards, with a force [N] that grows to its full size."""
    piece, pins, left, right = lattice(angle)
    model = piece.model(EA=E * THICKNESS * SIDE / 2, stiffness=joint, springs="both", name=f"state {state}")
    pushed, inward = (left, 1.0) if state == "A" else (right, -1.0)
    model.add(kg.Fix([model.nodes[k] for k in pins]), kg.NodalLoad(model.nodes[pushed], (inward * force, 0)))
    return kg.LoadControl(model, targets=np.linspace(0, 1, 11)[1:], step=step).run()


def outputs(angle: float, force: float = 10.0, joint: float = JOINT) -> np.ndarray:
    """Rows (F, u21, u12): displacements in the sense of the push, at the right in state A, at the left in B [m]."""
    _, _, left, right = lattice(angle)
    rows = []
    for state, read, inward in (("A", right, 1.0), ("B", left, -1.0)):
        results = transmit(angle, state, force, joint)
        kept = [results.nearest(target) for target in np.linspace(0, 1, 11)]
        rows.append(inward * results.u[kept, read, 0])
    return np.column_stack([force * np.linspace(0, 1, 11), *rows])


def main() -> float:
    """(u12 - u21) over the larger of them at 10 N and a lean of pi/16."""
    table = outputs(math.pi / 16)
    print("  F [N]   u21 [mm]   u12 [mm]   difference [mm]")
    for force, u21, u12 in table:
        print(f"{force:7.1f} {1e3 * u21:10.4f} {1e3 * u12:10.4f} {1e3 * (u12 - u21):12.4f}")
    print("joint stiffness over two decades, at 10 N:")
    for factor in (0.5, 1, 2, 5, 20, 50):
        _, u21, u12 = outputs(math.pi / 16, joint=factor * JOINT)[-1]
        print(f"  {factor * JOINT:8.4f} N m/rad: u21 {1e3 * u21:8.4f} mm, u12 {1e3 * u12:8.4f} mm")
    _, u21, u12 = table[-1]
    return float((u12 - u21) / max(abs(u12), abs(u21)))


def pictures() -> None:
    """Both states, and the difference over the force."""
    import matplotlib.pyplot as plt

    from kirigami.lattice.picture import plot_tiling

    figure, axes = plt.subplots(2, 1, figsize=(6.5, 6), layout="constrained")
    piece, pins, left, right = lattice(math.pi / 16)
    for ax, state, force in ((axes[0], "A", (left, (1, 0))), (axes[1], "B", (right, (-1, 0)))):
        results = transmit(math.pi / 16, state)
        plot_tiling(piece, results.u[-1], ax=ax, supports=pins, forces=[force], legend=state == "B")
        ax.set_title(f"state {state}, 10 N", fontsize="medium")
    figure.savefig("nonreciprocal_lattice.png", dpi=150)
    plt.close(figure)
    figure, ax = plt.subplots(figsize=(5, 3.4), layout="constrained")
    for angle, label, color in (
        (math.pi / 16, r"$\theta = \pi/16$", "#0072b2"),
        (0.0, r"$\theta = 0$", "#9aa0a6"),
        (-math.pi / 16, r"$\theta = -\pi/16$", "#d55e00"),
    ):
        force, u21, u12 = outputs(angle).T
        ax.plot(force, 1e3 * (u21 - u12), ".-", color=color, label=label)
    ax.set(xlabel="force [N]", ylabel="u21 - u12 [mm]")
    ax.legend(frameon=False)
    figure.savefig("nonreciprocal_lattice_curve.png", dpi=150)
    plt.close(figure)


if __name__ == "__main__":
    value = main()
    pictures()
    print(f"difference over the larger displacement at 10 N: {value:.3f}")
