"""A kirigami sleeve blown up: a tube with slits that a soft skin fills, so that it bulges where the slits may open.

A tube of firm rubber, closed and glued to pipes at its ends, has eight columns of narrow slits along it, shifted
against each other and filled with a skin a hundred times as soft (after the kirigami inflatables of Jin and others,
Adv. Mater. 32 (2020), 2001863). Inside is pressure, which follows the walls wherever they go. Since the skin closes the
tube, it has a potential, and what is stored is what it works: energy = int p dV, V being the volume inside.

Without slits, and free to get wider at its ends, such a neo-Hookean tube, its length held, has the stretch a around it

    p R / t = (E / 3) (1 - 1 / a^4)

An eighth of the sleeve is modelled: three planes of symmetry, two of them through slits.

    python examples/blown_sleeve.py           some ten seconds: a picture, and what it prints
"""

from __future__ import annotations

import warnings

import numpy as np
import shapely
from numpy.typing import NDArray

import kirigami as kg

RADIUS, HALF, THICKNESS = 0.015, 0.05, 5e-4  # of the tube, its half length
FIRM, SOFT = kg.NeoHookean(E=1.2e7), kg.NeoHookean(E=1.2e5)
WIDTH, SLIT = np.pi / 2 * RADIUS, 1.5e-3  # of an eighth, developed, and of a slit
COLUMNS = ((0.0, ((0.007, 0.029),)), (WIDTH / 2, ((0.0, 0.011), (0.025, 0.047))), (WIDTH, ((0.007, 0.029),)))
PRESSURE = 1.35e4
VIEW = 0.6  # of the picture, round the sleeve [rad]


def eighth(slit: bool = True, nodes: int = 150) -> kg.Model:
    """An eighth of the sleeve, from the middle to its end, or of a tube without slits that may get wider there."""
    outline = shapely.box(0, 0, WIDTH, HALF)
    slits = [shapely.box(x - SLIT / 2, start, x + SLIT / 2, end) for x, spans in COLUMNS for start, end in spans]
    regions = {"skin": shapely.MultiPolygon([box & outline for box in slits])} if slit else {}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", kg.KirigamiWarning)  # narrow slits take more nodes, those between them few
        flat = kg.Sheet(outline, regions=regions).mesh(nodes=nodes)
    angle, z = flat.nodes[:, 0] / RADIUS, flat.nodes[:, 1]
    rolled = np.column_stack([RADIUS * np.cos(angle), RADIUS * np.sin(angle), z])
    mesh = kg.TriMesh(rolled, flat.triangles, regions=flat.regions)
    model = kg.Model.from_mesh(mesh, THICKNESS, {None: FIRM, "skin": SOFT} if slit else FIRM, "shell")
    planes = np.array([np.isclose(flat.nodes[:, 0], 0), np.isclose(flat.nodes[:, 0], WIDTH), np.isclose(z, 0)])
    for normal, plane in zip("yxz", planes):
        model.add(kg.Symmetry(model.select(index=np.flatnonzero(plane)), normal))
    end = np.isclose(z, HALF)
    model.add(kg.Pressure(PRESSURE))
    if slit:
        for axis, there in (("x", end & ~planes[1]), ("y", end & ~planes[0]), ("z", end)):
            model.add(kg.Fix(model.select(index=np.flatnonzero(there)), axis))
    else:
        model.add(kg.Symmetry(model.select(index=np.flatnonzero(end)), "z"))
    return model


def blown(slit: bool = True, nodes: int = 150, steps: int = 20) -> kg.Results:
    """Blown up in steps."""
    return kg.LoadControl(eighth(slit, nodes), targets=np.linspace(0, 1, steps + 1)[1:]).run()


def stretch_of_tube() -> float:
    """Stretch round the tube without slits, by the formula."""
    return float((1 - 3 * PRESSURE * RADIUS / (FIRM.E * THICKNESS)) ** -0.25)


def stretch_found(results: kg.Results) -> float:
    """The same of the model without slits."""
    return float(np.hypot(*results.position()[-1, :, :2].T).mean() / RADIUS)


def volume(results: kg.Results) -> NDArray[np.float64]:
    """Volume inside an eighth of the sleeve at each step (s,), between its curved facets and the middle."""
    return np.asarray(results.deformation("pressure").sum(axis=1))


def work(results: kg.Results) -> NDArray[np.float64]:
    """Work of the pressure up to each step (s,)."""
    pressure, inside = PRESSURE * results.lam, volume(results)
    return np.append(0.0, np.cumsum(np.diff(inside) * (pressure[1:] + pressure[:-1]) / 2))


def main() -> None:
    plain = blown(slit=False, nodes=150, steps=4)
    print(f"without slits: stretched by {stretch_found(plain):.4f}, by the formula {stretch_of_tube():.4f}")
    results = blown()
    print(results.summary())
    energy = sum(results.energy.values())
    print(f"with slits: work of the pressure {1e3 * work(results)[-1]:.3f} mJ, stored {1e3 * energy[-1]:.3f} mJ")
    draw(results)


def draw(results: kg.Results) -> None:
    """The whole sleeve, at rest and blown up, and pressure over volume."""
    from matplotlib import pyplot as plt
    from mpl_toolkits.mplot3d.art3d import Poly3DCollection

    mirrors = [(a, b, c) for a in (1, -1) for b in (1, -1) for c in (1, -1)]
    skin = np.isin(np.arange(len(results.mesh.triangles)), results.mesh.regions["skin"])
    colors = np.tile(np.where(skin[:, None], (1.0, 0.80, 0.50), (0.30, 0.52, 0.78)), (8, 1))
    figure = plt.figure(figsize=(11, 4.6))
    ax = figure.add_axes((0, -0.4, 0.72, 1.8), projection="3d", proj_type="ortho")
    aside, towards = np.array([-np.sin(VIEW), np.cos(VIEW), 0]), np.array([np.cos(VIEW), np.sin(VIEW), 0.5])
    for place, share in enumerate((0.0, 0.3, 1.0)):
        corners = results.position()[np.argmin(np.abs(results.lam - share))][results.mesh.triangles]
        whole = np.concatenate([corners * mirror for mirror in mirrors])
        normal = np.cross(whole[:, 1] - whole[:, 0], whole[:, 2] - whole[:, 0])
        light = np.abs(normal @ (towards - 0.3 * aside)) / np.linalg.norm(normal, axis=1)
        lit = np.clip(colors * (0.4 + 0.5 * light[:, None]), 0, 1)
        shift = 0.06 * (place - 1) * aside
        ax.add_collection3d(Poly3DCollection(whole + shift, facecolors=lit, edgecolors=lit, linewidths=0.3))
        ax.text(*shift[:2], 1.16 * HALF, f"{1e-3 * share * PRESSURE:.3g} kPa", ha="center")
    ax.set(xlim=(-0.06, 0.06), ylim=(-0.06, 0.06), zlim=(-HALF, HALF))
    ax.set_box_aspect((1.2, 1.2, 1), zoom=0.88)
    ax.view_init(18, np.degrees(VIEW))
    ax.set_axis_off()
    ax = figure.add_axes((0.76, 0.13, 0.22, 0.8))
    ax.plot(8e6 * volume(results), 1e-3 * PRESSURE * results.lam)
    ax.set(xlabel="volume inside [ml]", ylabel="pressure [kPa]", ylim=0)
    figure.savefig("blown_sleeve.png", dpi=120)


if __name__ == "__main__":
    main()
