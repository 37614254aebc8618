"""The crawler dragged over a floor, both ways: the anisotropy of its friction as a force that is computed.

The paper that `crawler.py` follows estimates friction by a formula in the height of the fins, and shows the anisotropy
of one fin that is pushed. Here the stretched body, its fins out, is lowered onto a floor with Coulomb's friction, the
same both ways, and dragged along it. While it is kept at its height, friction presses a fin down that leans towards
where it is dragged to, and lifts one that leans back. With the slope s of its compliance, how far it rises where it is
pushed along over how far where it is pushed up, the force N on it becomes N / (1 - m s) or N / (1 + m s), so that

    drag with the tips ahead / drag with the tips behind = (1 + m s) / (1 - m s)

for the coefficient m, with one s for all m. Where it is the weight on the floor that is given, and not the height,
Coulomb's law leaves no anisotropy: both ways the drag is m times what presses on the floor.

    python examples/crawler_drag.py           some ten seconds: a picture, and what it prints
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import crawler
import numpy as np
from numpy.typing import NDArray

import kirigami as kg
from kirigami.results.contact import normal_forces

ROWS, MAX_EDGE = 5, 4.0
FLOOR, DOWN, WAY = -3.0, 0.6, 0.3  # height of the floor, how far the body is lowered and dragged [mm]
FRICTION = (0.1, 0.3, 0.5)
SHARES = np.array([0.01, 0.02, 0.04, 0.07, 0.1, 0.15, 0.2, 0.3, 0.4, 0.5, 0.6, 0.8, 1.0])


@dataclass(frozen=True)
class Drag:
    """One way over the floor: displacement of the body, drag and force on the floor, at each step (s,)."""

    way: NDArray[np.float64]
    drag: NDArray[np.float64]
    pressing: NDArray[np.float64]
    results: kg.Results


def dragged(friction: float, shape: str = "triangle") -> tuple[Drag, Drag]:
    """Stretch the body, lower it onto the floor, and drag it from there, its tips ahead and its tips behind."""
    body = crawler.skin(shape, ROWS, MAX_EDGE)
    model = body.model
    floor = model.add(kg.Contact(model.nodes, kg.Plane((0, 0, FLOOR)), friction=friction))
    stretched = crawler.stretched(body)

    def ends(along: float, up: float) -> None:
        """Bring both ends there, as they are stretched apart."""
        model.remove(*model.constraints)
        apart = -crawler.STRAIN * ROWS * crawler.SPACING
        model.add(kg.Prescribe(body.left, x=apart + along, y=0, z=up), kg.Prescribe(body.right, x=along, y=0, z=up))

    model.hold(stretched[-1])
    ends(0, -DOWN)
    lowered = kg.DisplacementControl(model, start=stretched[-1], targets=[0.25, 0.5, 0.75, 1]).run()
    model.hold(lowered[-1])
    found = []
    for way in (1, -1):
        ends(way * WAY, -DOWN)
        results = kg.DisplacementControl(model, start=lowered[-1], targets=SHARES).run()
        force = way * (results.reaction(body.left, "x") + results.reaction(body.right, "x"))
        found.append(Drag(results.lam * WAY, force, normal_forces(results, floor).sum(axis=1), results))
    return found[0], found[1]


def slope(ahead: Drag, behind: Drag, friction: float) -> float:
    """The slope s that the ratio of the drags has, by the law above."""
    ratio = ahead.drag[-1] / behind.drag[-1]
    return float((ratio - 1) / (ratio + 1) / friction)


def main(frictions: Sequence[float] = FRICTION) -> None:
    found = {friction: dragged(friction) for friction in frictions}
    for friction, (ahead, behind) in found.items():
        print(f"friction {friction:g}: drag {1e3 * ahead.drag[-1]:.1f} and {1e3 * behind.drag[-1]:.1f} mN, ", end="")
        print(f"ratio {ahead.drag[-1] / behind.drag[-1]:.3f}, slope {slope(ahead, behind, friction):.4f}; ", end="")
        coulomb = [drag.drag[-1] / drag.pressing[-1] for drag in (ahead, behind)]
        print(f"over what presses on the floor {coulomb[0]:.4f} and {coulomb[1]:.4f}")
    draw(found)


def draw(found: dict[float, tuple[Drag, Drag]]) -> None:
    """The body on the floor from below, the drag over the way, and its ratio over the friction."""
    from matplotlib import pyplot as plt

    figure = plt.figure(figsize=(12, 4))
    frictions = list(found)
    ax = figure.add_axes((0.0, -0.12, 0.44, 1.24), projection="3d")
    found[frictions[-1]][0].results.plot(ax=ax, view=(-24, -62), colorbar=False)
    ax.set_title("from below the floor", y=0.84)
    over, ratio = figure.add_axes((0.52, 0.15, 0.2, 0.75)), figure.add_axes((0.78, 0.15, 0.2, 0.75))
    for number, (friction, (ahead, behind)) in enumerate(found.items()):
        over.plot(ahead.way, 1e3 * ahead.drag, color=f"C{number}", label=f"{friction:g}")
        over.plot(behind.way, 1e3 * behind.drag, "--", color=f"C{number}")
        ratio.plot(friction, ahead.drag[-1] / behind.drag[-1], "o", color=f"C{number}")
    s, smooth = slope(*found[frictions[0]], frictions[0]), np.linspace(0, 1.1 * max(frictions), 50)
    ratio.plot(smooth, (1 + smooth * s) / (1 - smooth * s), color="0.5", lw=1, zorder=0)
    over.set(xlabel="way of the body [mm]", ylabel="drag [mN] (dashed: tips behind)", xlim=0)
    over.legend(title="friction", frameon=False)
    ratio.set(xlabel="friction", ylabel="drag, tips ahead / tips behind", xlim=0)
    figure.savefig("crawler_drag.png", dpi=120)


if __name__ == "__main__":
    main()
