"""Snap-through of the von Mises truss: two limit points, by displacement control and by arc length.

Two bars of unit EA rise from supports at x = -1 and 1 to an apex at height 1, which is pushed down through to the
other side. In Green strain, P = 2 EA z (h^2 - z^2) / (2 L^3) at apex height z, L the length of a bar at rest; the
limit load is 2 EA h^3 / (3 sqrt(3) L^3).
"""

from __future__ import annotations

import kirigami as kg


def truss() -> tuple[kg.Model, kg.Node]:
    """The truss and its apex."""
    m = kg.Model(dim=2, name="von Mises truss")
    left, apex, right = m.add(kg.Node(-1, 0), kg.Node(0, 1, name="apex"), kg.Node(1, 0))
    m.add(kg.Bar(left, apex, EA=1.0), kg.Bar(apex, right, EA=1.0))
    m.add(kg.Fix([left, right]), kg.Fix(apex, "x"), kg.NodalLoad(apex, (0, -1)))
    return m, apex


def main(pictures: bool = False) -> float:
    """Limit load over EA; both methods must find it."""
    m, apex = truss()
    driven = kg.DisplacementControl(m, to=-2.2, control=(apex, "y")).run()
    walked = kg.ArcLength(m, step=0.02, stop=lambda step: step.u[1, 1] < -2.2).run()
    loads = [event.lam for res in (driven, walked) for event in res.events if event.kind == "limit point"]
    for name, res in (("displacement control", driven), ("arc length", walked)):
        print(f"{name}: {len(res)} steps, " + "; ".join(str(event) for event in res.events))
    if pictures:
        m.plot().figure.savefig("von_mises_truss.png")
        walked.plot_curve(x=(apex, "y")).figure.savefig("von_mises_truss_path.png")
        walked.animate("von_mises_truss.gif")
    return max(loads)


if __name__ == "__main__":
    print(f"limit load P/EA = {main(pictures=True):.7f} (closed form {1 / (3 * 3**0.5 * 2**0.5):.7f})")
