"""A disc with one radial cut, in a flow: it rolls up into a cone, and its drag falls far below that of a flat one.

Schouveiler and Boudaoud (J. Fluid Mech. 563 (2006), 71) hold a disc of radius R, cut along one radius, at its middle
in a steady flow. It rolls up into a cone. Their model takes a round cone of half-angle a, the pressure q cos^2 of the
angle between normal and flow on what faces the flow, where layers that overlap count once, and the bending energy
pi D cot^2(a) ln(R / r) of the sheet beyond the radius r of the holder. Virtual work then gives

    C = q R^3 / (D ln(R / r)) = 3 cos(a) / sin^6(a),        drag = sin^4(a) times that of the flat disc,

which is 0.998, 0.875, 0.362 and 0.098 at C = 0.1, 0.93, 8.7 and 81. `FlowPressure` knows no lee and presses on both of
two layers, which takes one power off each sine; `ShelteredFlow` below is an effect of one's own that has a lee.

What is assumed: no wake, no pressure behind the disc but what q has of it, and two layers that lie in each other
without touch or friction. Half a disc is modelled, since cut and flow leave a plane of symmetry. The inner rim keeps
round and level, as spokes to a stem hold it, and is free to get narrower: so the cone is round but for its lips.

    python examples/disc_in_a_flow.py           some twenty seconds: a picture, and what it prints
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

import kirigami as kg
from kirigami.model.flow_pressure import FlowPressureKernel

RADIUS, HOLDER, THICKNESS = 0.1, 0.01, 1e-4
STANDING = 0.03  # height of the cone of the spokes at rest over the holder's radius
PET = kg.Material(E=4e9, nu=0.35)
BENDING = PET.E * THICKNESS**3 / (12 * (1 - PET.nu**2))
FLAT = BENDING * np.log(RADIUS / HOLDER) / RADIUS**3  # the pressure that is C = 1
PUBLISHED = {0.1: 0.998, 0.93: 0.875, 8.7: 0.362, 81.0: 0.098}


def drag_of_cone(c: float, powers: int = 6) -> float:
    """Drag ratio of the round cone; one power less where both of two layers are pressed on."""
    sine = brentq(lambda sine: 3 * np.sqrt(1 - sine**2) / sine**powers - c, 1e-3, 1.0)
    return float(sine ** (powers - 2))


class Sheltered(FlowPressureKernel):
    """A flow along z that presses on what faces it alone: of the half of the disc not on what has rolled in beneath the
    other half, which is its mirror image, through the plane y = 0."""

    def exposed(self, x: NDArray[np.float64]) -> NDArray[np.float64]:
        """Share (n,) of each facet on which the flow presses; it fades as the facet goes through the plane."""
        across = np.asarray(x)[self.conn][:, :, 1]
        share = (across.max(axis=1) / np.ptp(across, axis=1)).clip(0, 1)
        return np.asarray(share**2 * (3 - 2 * share))

    def force_on(self, x: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.asarray(self.exposed(x)[:, None] * super().force_on(x))

    def evaluate(self, x: NDArray[np.float64], lam: float = 1.0, need: int = 2) -> kg.Contribution:
        found = super().evaluate(x, lam, need)
        if need < 2:
            return found
        assert found.hessian is not None
        return kg.Contribution(found.energy, found.gradient, found.hessian * self.exposed(x)[:, None, None, None, None])


class ShelteredFlow(kg.FlowPressure):
    """`FlowPressure` with that shelter."""

    @classmethod
    def lower(cls, objects: Sequence[ShelteredFlow], numbering: kg.Numbering) -> list[kg.Kernel]:
        return [Sheltered(numbering.rest, **kernel.arrays()) for kernel in super().lower(objects, numbering)]


def half_disc(rings: int = 8, rays: int = 24) -> kg.TriMesh:
    """Half of the disc beyond its holder, the cut along -x; facets keep their shape from the holder to the rim."""
    radius, angle = np.geomspace(HOLDER, RADIUS, rings + 1), np.linspace(0, np.pi, rays + 1)
    nodes = np.stack([np.outer(np.cos(angle), radius), np.outer(np.sin(angle), radius)], axis=2).reshape(-1, 2)
    corner = (np.arange(rays)[:, None] * (rings + 1) + np.arange(rings)).ravel()
    a, b, c, d = corner, corner + 1, corner + rings + 2, corner + rings + 1
    even = (corner // (rings + 1) + corner % (rings + 1)) % 2 == 0  # diagonals alternate
    first = np.where(even[:, None], np.stack([a, b, c], axis=1), np.stack([a, b, d], axis=1))
    second = np.where(even[:, None], np.stack([a, c, d], axis=1), np.stack([b, c, d], axis=1))
    return kg.TriMesh(nodes, np.concatenate([first, second]), thickness=THICKNESS, material=PET)


def model(c: float, flow: type[kg.FlowPressure] = kg.FlowPressure, rings: int = 8, rays: int = 24) -> kg.Model:
    """Half of the disc on its ring, in a flow."""
    m = kg.Model.from_mesh(half_disc(rings, rays), stiffness="shell")
    middle = m.select(where=lambda x, y, z: (x > 0) & (y < 1e-9))
    holder = m.select(where=lambda x, y, z: np.hypot(x, y) < 1.001 * HOLDER)
    apex = m.add(kg.Node(0, 0, -STANDING * HOLDER))
    m.add(kg.Symmetry(middle, "y"), kg.Fix(holder, "z"), kg.Fix(apex, "xy"))
    m.add(*[kg.Bar(apex, node, EA=PET.E * THICKNESS * HOLDER) for node in holder])  # a round holder
    m.add(flow(c * FLAT, (0, 0, 1)))
    return m


def blown(flow: type[kg.FlowPressure], targets: Sequence[float] = tuple(PUBLISHED), **size: int) -> kg.Results:
    """The disc at several C; the load factor is C over the last one."""
    return kg.LoadControl(model(targets[-1], flow, **size), targets=np.divide(targets, targets[-1])).run()


def drag(results: kg.Results, c: float) -> float:
    """Drag over that of the flat disc, at one of the C of a run."""
    (kernel,) = [kernel for kernel in results.kernels if isinstance(kernel, FlowPressureKernel)]
    whole = kernel.q / FLAT
    step = int(np.argmin(np.abs(results.lam * whole - c)))
    force = kernel.force_on(results.position()[step])[:, 2].sum()
    return float(force / (kernel.q * results.mesh.facet_areas.sum()))


def main() -> None:
    runs = {flow: blown(flow) for flow in (ShelteredFlow, kg.FlowPressure)}
    print("      C   published   with a lee   both layers pressed   round cone of both")
    for c, known in PUBLISHED.items():
        lee, both = (drag(results, c) for results in runs.values())
        print(f"{c:7.2f}   {known:9.3f}   {lee:10.3f}   {both:19.3f}   {drag_of_cone(c, 5):18.3f}")
    draw(runs[ShelteredFlow], runs[kg.FlowPressure])


def draw(results: kg.Results, without_lee: kg.Results) -> None:
    """The disc and its mirror image, seen from where the flow goes, and its drag."""
    from matplotlib import pyplot as plt
    from mpl_toolkits.mplot3d.art3d import Poly3DCollection

    figure = plt.figure(figsize=(12, 3.8))
    whole = list(PUBLISHED)[-1]
    for place, c in enumerate((0.93, 8.7, whole)):
        ax = figure.add_axes((0.235 * place - 0.03, -0.1, 0.32, 1.15), projection="3d")
        corners = results.position()[np.argmin(np.abs(results.lam * whole - c))][results.mesh.triangles]
        halves = np.concatenate([corners, corners * [1, -1, 1]])
        normal = np.cross(halves[:, 1] - halves[:, 0], halves[:, 2] - halves[:, 0])
        light = np.abs(normal @ (-0.6, 0.3, 0.74)) / np.linalg.norm(normal, axis=1)
        color = np.array(plt.get_cmap("viridis")(0.2 + 0.8 * halves[:, :, 2].mean(axis=1) / RADIUS))[:, :3]
        lit = color * (0.5 + 0.5 * light[:, None])
        ax.add_collection3d(Poly3DCollection(halves, facecolors=lit, edgecolors=lit, linewidths=0.3))
        ax.set(xlim=(-RADIUS, RADIUS), ylim=(-RADIUS, RADIUS), zlim=(-0.2 * RADIUS, RADIUS))
        ax.set_box_aspect((2, 2, 1.2), zoom=1.12)
        ax.view_init(35, 150)
        ax.set_axis_off()
        ax.patch.set_visible(False)
        ax.set_title(f"C = {c:g}", y=0.8)
    ax = figure.add_axes((0.77, 0.15, 0.22, 0.8))
    smooth = np.geomspace(0.1, whole, 100)
    ax.loglog(smooth, [drag_of_cone(c) for c in smooth], color="C0", label="published law")
    ax.loglog(smooth, [drag_of_cone(c, 5) for c in smooth], "--", color="C1", label="both layers pressed")
    for number, run in enumerate((results, without_lee)):
        ax.loglog(list(PUBLISHED), [drag(run, c) for c in PUBLISHED], "o", color=f"C{number}")
    ax.plot([], [], "o", color="0.4", label="computed")
    ax.set(xlabel=r"$C = q R^3 / (D \ln(R / r))$", ylabel="drag over that of the flat disc", ylim=(0.05, 1.3))
    ax.legend(frameon=False, loc="lower left")
    figure.savefig("disc_in_a_flow.png", dpi=120)


if __name__ == "__main__":
    main()
