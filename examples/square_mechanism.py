"""Four rotating squares pulled open: a mechanism of rigid panels whose only stiffness is in its hinges.

Squares of side l, turned by +phi and -phi in turn, share corners. The one motion that costs no bar energy changes phi;
the block is then 2 l (cos phi + sin phi) wide, and four hinges of stiffness k open by 2 (phi - phi_0) each, so

    F = dE / d(width) = 8 k (phi - phi_0) / (l (cos phi - sin phi)).
"""

from __future__ import annotations

from itertools import product
from math import cos, sin

import kirigami as kg
from kirigami.plot import style

SIDE, HINGE, START, END = 1.0, 1.0, 0.2, 0.6  # l, k, phi_0 and phi [rad]


def width(phi: float) -> float:
    return 2 * SIDE * (cos(phi) + sin(phi))


def block() -> tuple[kg.Model, list[kg.Node], list[kg.Node]]:
    """The model, its two nodes furthest left, and the two furthest right."""
    m = kg.Model(dim=2, name="rotating squares")
    nodes: dict[tuple[float, float], kg.Node] = {}
    owners: dict[kg.Node, list[tuple[list[kg.Node], int]]] = {}
    for column, row in product((0, 1), repeat=2):
        turn = START if (column + row) % 2 == 0 else -START
        corners = []
        for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1)):
            place = (
                width(START) / 2 * column + SIDE / 2 * (x * cos(turn) - y * sin(turn)),
                width(START) / 2 * row + SIDE / 2 * (x * sin(turn) + y * cos(turn)),
            )
            key = (round(place[0], 9), round(place[1], 9))
            corners.append(nodes[key] if key in nodes else nodes.setdefault(key, m.add(kg.Node(*place))))
        for k, corner in enumerate(corners):
            m.add(kg.Bar(corner, corners[(k + 1) % 4], EA=1e6))  # so stiff that only the hinges count
            owners.setdefault(corner, []).append((corners, k))
        m.add(kg.Bar(corners[0], corners[2], EA=1e6), kg.Bar(corners[1], corners[3], EA=1e6))
    for pivot, sharing in owners.items():
        if len(sharing) == 2:  # a hinge: one spring across the gap between the two squares
            (first, k), (second, j) = sharing
            m.add(kg.TorsionSpring3(first[(k + 1) % 4], pivot, second[(j - 1) % 4], HINGE))
    by_x = sorted(m.nodes, key=lambda node: node.x)
    return m, by_x[:2], by_x[-2:]


def squares(m: kg.Model) -> list[list[int]]:
    """Nodes of each square, round it: those of its first four bars, before its two diagonals."""
    bars = m.index([node for bar in m.elements if isinstance(bar, kg.Bar) for node in bar.nodes]).reshape(-1, 6, 2)
    return [four[:4, 0].tolist() for four in bars]


def main(pictures: bool = False) -> float:
    """Force over its closed form."""
    m, left, right = block()
    m.add(kg.Fix(left, "x"), kg.Fix(left[0], "y"), kg.Prescribe(right, x=width(END) - width(START)))
    res = kg.DisplacementControl(m).run()
    if pictures:
        m.plot().figure.savefig("square_mechanism.png")
        ax = res.plot(color="none")
        for square in squares(m):
            ax.fill(*res.rest[square, :2].T, color=style.PALE, alpha=0.5, zorder=0.5)
            ax.fill(*res.position()[-1, square, :2].T, color=style.BLUE, alpha=0.4, zorder=1.5)
        ax.figure.savefig("square_mechanism_open.png")
        res.animate("square_mechanism.gif", color="none")
    return float(res.reaction(right, "x")[-1]) / (8 * HINGE * (END - START) / (SIDE * (cos(END) - sin(END))))


if __name__ == "__main__":
    print(f"force / closed form = {main(pictures=True):.5f}")
