"""Problems with exact answers, for every rung of accuracy: how near, on which mesh, and how fast it converges.

Each case returns the ratio of the computed value to the exact one. Meshes are regular (squares with alternating
diagonals) or random (from the mesher), with a number of facets across the width.

    python benchmarks/closed_forms.py            # table on two meshes of each kind
    python benchmarks/closed_forms.py --rates    # rates of convergence on random meshes
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
import shapely

import kirigami as kg
from kirigami.primitives.kernel import displacement_of
from kirigami.primitives.parts import ModelObject, Numbering

RUNGS = ("paper", "plate", "facet", "shell")
E, NU, THICKNESS = 1e6, 0.34, 0.02


def sheet_mesh(length: float, width: float, across: int, random: bool) -> kg.TriMesh:
    """Rectangle from the origin, its short edges at x = 0 and x = length."""
    edge = width / across
    if random:
        return kg.Sheet(shapely.box(0, 0, length, width), thickness=THICKNESS).mesh(max_edge=1.15 * edge)
    columns = round(length / edge)
    x, y = np.meshgrid(np.linspace(0, length, columns + 1), np.linspace(0, width, across + 1))
    a = (np.arange(across)[:, None] * (columns + 1) + np.arange(columns)).ravel()
    b, c, d = a + 1, a + columns + 2, a + columns + 1
    rising = ((a // (columns + 1) + a % (columns + 1)) % 2 == 0)[:, None]
    first = np.where(rising, np.column_stack([a, b, c]), np.column_stack([a, b, d]))
    second = np.where(rising, np.column_stack([a, c, d]), np.column_stack([b, c, d]))
    return kg.TriMesh(np.column_stack([x.ravel(), y.ravel()]), np.concatenate([first, second]))


def sheet(
    length: float, width: float, across: int, random: bool, rung: str, nu: float = NU, thickness: float = THICKNESS
) -> tuple[kg.Model, Callable[[str], list[kg.Node]]]:
    """Model of a rectangle and a selector of its sides."""
    mesh = sheet_mesh(length, width, across, random)
    model = kg.Model.from_mesh(mesh, thickness=thickness, material=kg.Material(E, nu), stiffness=rung)
    return model, lambda side: model.select(boundary=side)


def tension(rung: str, across: int, random: bool) -> float:
    """Force of a strip between rollers."""
    model, side = sheet(2.0, 1.0, across, random, rung)
    model.add(kg.Fix(side("left"), "x"), kg.Prescribe(side("right"), x=2e-6), kg.Fix(model.nodes[0], "y"))
    model.add(kg.Fix([node for node in model.select(boundary="outer")], "z"))
    return float(kg.LinearStatic(model).run().reaction(side("right"), "x")[-1]) / (E * THICKNESS * 1e-6)


def shear(rung: str, across: int, random: bool) -> float:
    """Energy of a square whose edges are sheared by u_x = gamma y."""
    model, _ = sheet(1.0, 1.0, across, random, rung)
    edge = model.select(boundary="outer")
    model.add(kg.Prescribe(edge, x=[1e-6 * node.y for node in edge], y=0.0, z=0.0))
    energy = sum(values[-1] for values in kg.LinearStatic(model).run().energy.values())
    return float(energy) / (0.5 * E / (2 * (1 + NU)) * THICKNESS * 1e-12)


def cantilever(rung: str, across: int, random: bool) -> float:
    """Tip force of a narrow strip, F = 3 E I w / L^3 at nu = 0."""
    model, side = sheet(8.0, 1.0, across, random, rung, nu=0.0)
    model.add(kg.Fix(side("left"), clamp=True), kg.Prescribe(side("right"), z=1e-4))
    force = float(kg.LinearStatic(model).run().reaction(side("right"), "z")[-1])
    return force / (3 * E * THICKNESS**3 / 12 * 1e-4 / 8.0**3)


def cylinder(rung: str, across: int, random: bool) -> float:
    """Middle deflection of a plate four times as wide as long, simply supported at its long edges, under pressure.

    The exact value is the Levy series of a plate with two free edges, at its centre.
    """
    length, width = 1.0, 4.0
    mesh = sheet_mesh(length, width, across * 4, random)
    model = kg.Model.from_mesh(mesh, thickness=THICKNESS, material=kg.Material(E, NU), stiffness=rung)
    model.add(kg.Fix(model.select(boundary="left") + model.select(boundary="right"), "z"))
    pressure(model, mesh, 1e-3)
    hold_in_plane(model)
    deflection = at_point(kg.LinearStatic(model).run(), mesh, (length / 2, width / 2))
    return deflection / levy_two_free_edges(length, width, 1e-3)


def twist(rung: str, across: int, random: bool) -> float:
    """Corner deflection of a square held at three corners, P a^2 / (2 (1 - nu) D)."""
    model, _ = sheet(1.0, 1.0, across, random, rung)
    x = model.positions()[:, :2]
    corner = {at: model.nodes[int(np.argmin(np.hypot(*(x - at).T)))] for at in ((0, 0), (1, 0), (0, 1), (1, 1))}
    model.add(kg.Fix([corner[0, 0], corner[1, 0], corner[0, 1]], "z"), kg.NodalLoad(corner[1, 1], (0, 0, 1e-6)))
    hold_in_plane(model)
    deflection = kg.LinearStatic(model).run().u[-1][model.index(corner[1, 1])[0], 2]
    return float(deflection) / (1e-6 / (2 * (1 - NU) * rigidity()))


def plate(rung: str, across: int, random: bool) -> float:
    """Middle deflection of a simply supported square under pressure, 0.00406235 q a^4 / D (Navier)."""
    mesh = sheet_mesh(1.0, 1.0, across, random)
    model = kg.Model.from_mesh(mesh, thickness=THICKNESS, material=kg.Material(E, NU), stiffness=rung)
    model.add(kg.Fix(model.select(boundary="outer"), "z"))
    pressure(model, mesh, 1e-3)
    hold_in_plane(model)
    deflection = at_point(kg.LinearStatic(model).run(), mesh, (0.5, 0.5))
    return deflection / (0.00406235266 * 1e-3 / rigidity())


def euler(rung: str, across: int, random: bool) -> float:
    """Buckling load of a narrow clamped-free strip, (pi / 2)^2 E I / L^2 at nu = 0."""
    model, side = sheet(8.0, 1.0, across, random, rung, nu=0.0)
    model.add(kg.Fix(side("left"), clamp=True))
    end = side("right")
    end = sorted(end, key=lambda node: node.y)
    share = np.gradient([node.y for node in end])
    share[[0, -1]] *= 0.5  # the outer nodes carry half an edge
    share /= share.sum()
    model.add(*(kg.NodalLoad(node, (-float(part), 0, 0)) for node, part in zip(end, share)))
    value = float(kg.Buckling(model, n=1).run().values[0])
    return value / ((math.pi / 2) ** 2 * E * THICKNESS**3 / 12 / 8.0**2)


def roll_up(rung: str, across: int, random: bool) -> float:
    """Length of the gap between the ends of a strip that an end moment 2 pi E I / L rolls up, as 1 - gap / length.

    The strip is held in its plane: beyond three quarters of a circle it would buckle sideways under such a moment.
    """
    model, side = sheet(8.0, 1.0, across, random, rung, nu=0.0)
    model.add(kg.Fix(side("left"), "xz", clamp=True), kg.Fix(model.select(where=lambda x, y, z: x > -1.0), "y"))
    ends = side("right")
    x = model.positions()
    arms = []
    for node in ends:
        at = int(model.index(node)[0])
        inner = model.mesh.edges[(model.mesh.edges == at).any(axis=1)].sum(axis=1) - at
        arms.append((model.nodes[int(inner[np.argmin(x[inner, 0])])], node))
    widths = np.gradient(np.sort([node.y for node in ends]))
    order = np.argsort(np.argsort([node.y for node in ends]))
    widths[[0, -1]] *= 0.5
    share = (widths / widths.sum())[order]
    moment = -2 * math.pi * E * THICKNESS**3 / 12 / 8.0
    model.add(*(EndMoment(a, b, float(moment * part)) for (a, b), part in zip(arms, share)))
    results = kg.LoadControl(model, on_instability="follow").run()
    end = results.position(ends)[-1].mean(axis=0)
    return 1 - float(np.linalg.norm(end - [0.0, 0.5, 0.0])) / 8.0


CASES = {
    "tension": tension,
    "shear": shear,
    "cylinder": cylinder,
    "twist": twist,
    "plate": plate,
    "strip": cantilever,
    "Euler load": euler,
    "roll-up": roll_up,
}


# ---- what the cases share


def rigidity() -> float:
    return E * THICKNESS**3 / (12 * (1 - NU**2))


def hold_in_plane(model: kg.Model) -> None:
    """Support the middle plane against rigid motion in it."""
    x = model.positions()[: len(model.mesh.nodes)]
    low = model.nodes[int(np.argmin(x[:, 0] + x[:, 1]))]
    right = model.nodes[int(np.argmax(x[:, 0] - x[:, 1]))]
    model.add(kg.Fix(low, "xy"), kg.Fix(right, "y"))


def pressure(model: kg.Model, mesh: kg.TriMesh, q: float) -> None:
    """Transverse pressure, a third of each facet's share on each of its corners and, where they are, its middles."""
    share = np.bincount(mesh.triangles.ravel(), np.repeat(mesh.facet_areas / 3, 3), len(mesh.nodes))
    model.add(*(kg.NodalLoad(node, (0, 0, q * part)) for node, part in zip(model.nodes, share.tolist())))
    if isinstance(model.elements[0], kg.ShellFacet):
        model.add(MiddleLoad(model.nodes[0], mesh, q))


@dataclass(frozen=True, eq=False)
class MiddleLoad(ModelObject):
    """What a pressure q does on the middles of the edges of shell facets: integral of 4 l_a l_b over each facet."""

    kind: ClassVar[str] = "load"
    node: kg.Node
    mesh: kg.TriMesh
    q: float

    @property
    def nodes(self) -> tuple[kg.Node, ...]:
        return (self.node,)

    @classmethod
    def lower(cls, objects: Any, numbering: Numbering) -> list[kg.Kernel]:
        return [MiddleLoadKernel(item, numbering.edges) for item in objects]


class MiddleLoadKernel(kg.Kernel):
    """Forces along z on the rows of middles."""

    name, pairs, scaled = "pressure", (), True

    def __init__(self, item: MiddleLoad, edges: Any) -> None:
        self.conn = edges.middle[edges.edge].reshape(-1, 1)
        self.force = np.repeat(item.q * item.mesh.facet_areas / 3, 3)

    def evaluate(self, x: Any, lam: float = 1.0, need: int = 2) -> kg.Contribution:
        gradient = np.zeros((len(self.conn), 1, 3))
        gradient[:, 0, 2] = -lam * self.force
        return kg.Contribution(-lam * self.force * np.asarray(x)[self.conn[:, 0], 2], gradient)


def at_point(results: kg.Results, mesh: kg.TriMesh, point: tuple[float, float]) -> float:
    """Deflection at a point, by a quadratic through the twelve nodes around it."""
    x = mesh.nodes[:, :2] - point
    near = np.argsort((x**2).sum(axis=1))[:12]
    terms = np.column_stack([np.ones(12), x[near], x[near] ** 2, x[near].prod(axis=1)])
    return float(np.linalg.lstsq(terms, results.u[-1][near, 2], rcond=None)[0][0])


def levy_two_free_edges(length: float, width: float, q: float) -> float:
    """Centre deflection of a plate supported along x = 0 and x = length, free at y = +-width / 2 (Timoshenko)."""
    total = 0.0
    for m in range(1, 60, 2):
        k = m * math.pi / length
        h = k * width / 2
        particular = 4 * q * length**4 / (rigidity() * (m * math.pi) ** 5)
        # w = particular (1 + a cosh ky + b ky sinh ky) sin kx; no moment and no shear at the free edges.
        scale = math.exp(-h) if h < 300 else 0.0
        cosh, sinh = 0.5 * (1 + scale**2), 0.5 * (1 - scale**2)  # over exp(h)
        moment = [(1 - NU) * cosh, 2 * cosh + (1 - NU) * h * sinh]
        thrust = [-(1 - NU) * sinh, (1 + NU) * sinh - (1 - NU) * h * cosh]
        a, _ = np.linalg.solve(np.array([moment, thrust]), [NU * scale, 0.0])
        total += particular * (1 + a) * math.sin(m * math.pi / 2)
    return total


@dataclass(frozen=True, eq=False)
class EndMoment(ModelObject):
    """Moment about y that turns the direction from node `i` to node `j` in the plane y = 0, and stays a pure moment.

    Potential -lam M phi with phi the angle of the direction, counted over whole turns.
    """

    kind: ClassVar[str] = "load"
    i: kg.Node
    j: kg.Node
    moment: float

    @property
    def nodes(self) -> tuple[kg.Node, ...]:
        return (self.i, self.j)

    @classmethod
    def lower(cls, objects: Any, numbering: Numbering) -> list[kg.Kernel]:
        return [
            EndMomentKernel(numbering.rest, numbering.connectivity(objects), np.array([o.moment for o in objects]))
        ]


class EndMomentKernel(kg.Kernel):
    """All end moments; the turns are counted against the last committed state."""

    name = "loads"
    scaled = True

    def __init__(self, rest: Any, conn: Any, moment: Any) -> None:
        self.rest, self.conn, self.moment = rest, conn, moment
        self._committed = self._angle(rest)
        self._first = self._committed

    def _arm(self, x: Any) -> Any:
        u = displacement_of(x, self.rest)
        rest = self.rest[self.conn[:, 1]] - self.rest[self.conn[:, 0]]
        return rest + (u[self.conn[:, 1]] - u[self.conn[:, 0]])

    def _angle(self, x: Any) -> Any:
        arm = self._arm(x)
        return np.arctan2(arm[:, 2], arm[:, 0])

    def commit(self, x: Any) -> None:
        angle = self._angle(x)
        self._committed = angle + 2 * np.pi * np.round((self._committed - angle) / (2 * np.pi))

    @property
    def history(self) -> Any:
        return self._committed

    @history.setter
    def history(self, value: Any) -> None:
        self._committed = self._first if value is None else np.array(value)

    def evaluate(self, x: Any, lam: float = 1.0, need: int = 2) -> kg.Contribution:
        arm, angle = self._arm(x), self._angle(x)
        angle = angle + 2 * np.pi * np.round((self._committed - angle) / (2 * np.pi))
        force = lam * self.moment
        square = arm[:, 0] ** 2 + arm[:, 2] ** 2
        turn = np.zeros_like(arm)
        turn[:, 0], turn[:, 2] = -arm[:, 2] / square, arm[:, 0] / square
        signs = np.array([-1.0, 1.0])
        gradient = -force[:, None, None] * signs[None, :, None] * turn[:, None]
        second = np.zeros((len(arm), 3, 3))
        xx = 2 * arm[:, 0] * arm[:, 2] / square**2
        xz = (arm[:, 2] ** 2 - arm[:, 0] ** 2) / square**2
        second[:, 0, 0], second[:, 2, 2], second[:, 0, 2], second[:, 2, 0] = xx, -xx, xz, xz
        hessian = -force[:, None, None, None, None] * (signs[:, None] * signs)[None, :, :, None, None]
        return kg.Contribution(-force * (angle - self._first), gradient, hessian * second[:, None, None])


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rates", action="store_true", help="rates of convergence on random meshes")
    options = parser.parse_args()
    meshes = [(4, False), (8, False), (4, True), (8, True)]
    if options.rates:
        meshes = [(across, True) for across in (4, 8, 16)]
    heads = [f"{'random' if random else 'regular'} {across}" for across, random in meshes]
    print(f"{'error in percent':24s}" + "".join(f"{head:>14s}" for head in heads) + ("  rate" if options.rates else ""))
    for name, case in CASES.items():
        for rung in RUNGS:
            errors = []
            for across, random in meshes:
                try:
                    errors.append(100 * (case(rung, across, random) - 1))
                except kg.KirigamiError as error:
                    print(f"{name}, {rung}: {str(error)[:90]}")
                    errors.append(math.nan)
            rate = f"{math.log2(abs(errors[-2] / errors[-1])):6.1f}" if options.rates and errors[-1] else ""
            print(f"{name:14s}{rung:10s}" + "".join(f"{error:14.3f}" for error in errors) + rate, flush=True)


if __name__ == "__main__":
    main()
