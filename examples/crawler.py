"""The skin of a kirigami crawler: folded, stretched until its fins pop out, pushed on a fin, pressed on the ground.

Khawale, Mehdizadeh, Brigham and Filipov ("Rapid kirigami simulation using the bar and hinge approach") fold a cut
sheet into a three-sided body, stretch it along its length and compare three patterns of cuts. They state neither sizes
nor material, fold angle, crease stiffness, strain, nor the constants of the friction law: what stands under "Chosen"
is ours, and the straight slit is added as a control. The constants of the friction law are arbitrary, so that mu is no
result, only how it grows; with one surface factor S_f for all patterns they differ little, and their order would hang
on what S_f stands for. What sets the patterns apart is how much stiffer a fin is one way than the other: there the
triangle leads, close before the trapezoid. The slit is not alike both ways either: of its two lips one stands out.

The sheet is meshed flat, with the creases as lines of mesh edges; then its nodes are moved to where folding puts them.
No distance changes, and a bending hinge takes the angle it has at rest as its rest angle, so that the folded body is
free of stress, creases included. A crease is as stiff in bending as the sheet.

Run plainly it takes 5 of the 20 rows of cuts on a coarse mesh and a few minutes; --full takes all on a finer one.
"""

from __future__ import annotations

import sys
from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray

import kirigami as kg
from kirigami.post.friction import friction_coefficient
from kirigami.results.contact import normal_forces, penetration

# ---- Chosen: lengths in mm, forces in N
WIDTH, LENGTH, GRIP = 51.0, 140.0, 3.5  # developed sheet, and what is held of it at either end
THICKNESS, PET = 0.1, kg.Material(E=3500.0, nu=0.34)
COLUMNS, ROWS = 4, 20  # cuts across and along; every other row is shifted by half a column
FOLD = np.pi / 2  # a bottom face of 25.5 mm between side faces of 12.75 mm
STRAIN = 0.05  # of the length between the grips
LEAN = 0.2  # the tips of the fins stand out by so much at rest, free of stress: it decides which way they pop
PUSH = 0.5  # on the last third of a fin, each way along the body
GROUND = 1.0  # of the bottom face over the ground when the body is pressed on it
BASE_FRICTION, ENGAGEMENT, SURFACE_FACTOR = 0.2, 10.0, 1.0  # mu0, K_f [mm] and S_f

PITCH, SPACING = WIDTH / COLUMNS, (LENGTH - 2 * GRIP) / ROWS
CREASES = np.array([PITCH, WIDTH - PITCH])
HALF, REACH = 0.375 * PITCH, 0.5 * SPACING  # a cut is 3/4 of a column wide, and reaches over half a row

ARC = np.linspace(0, np.pi, 13)
SHAPES = {  # cuts, by across / HALF and along / REACH; the fin is what they enclose, its tip points to +x
    "triangle": ((-1, 0, 1), (0, 1, 0)),
    "circle": (-np.cos(ARC), np.sin(ARC)),
    "trapezoid": ((-1, -0.5, 0, 0.5, 1), (0, 1, 1, 1, 0)),
    "slit": ((-1, 0, 1), (0, 0, 0)),
}
Floats = NDArray[np.float64]


@dataclass
class Skin:
    """A folded sheet with its grips, and the fins of its bottom face: nodes of their tips and of the lips opposite.

    ``pads`` are the nodes of the last third of each of these fins, by which they are pushed.
    """

    model: kg.Model
    left: list[kg.Node]
    right: list[kg.Node]
    tips: NDArray[np.int64]
    lips: NDArray[np.int64]
    pads: list[NDArray[np.int64]]
    share: float  # of the area of the sheet that is fins

    def height(self, res: kg.Results) -> Floats:
        """How far the tips stand out of the bottom face, over the lips they left, on average over the fins (s,)."""
        z = res.position()[..., 2]
        return (z[:, self.lips] - z[:, self.tips]).mean(axis=1)

    @property
    def middle(self) -> list[kg.Node]:
        """Pad of the fin nearest to the middle of the body."""
        x = self.model.positions()[self.tips]
        return self.model.select(index=self.pads[np.argmin(((x - x.mean(axis=0)) ** 2).sum(axis=1))])


def folded(s: Floats) -> tuple[Floats, Floats]:
    """Place (n, 2) in the section of the body for places across the sheet (n,), and the direction outwards (n, 2)."""
    beyond = s - s.clip(*CREASES)  # past a crease, negative on the left
    turn = FOLD * np.sign(np.round(s[:, None] - CREASES, 9)).mean(axis=1)  # half a fold on a crease
    place = np.column_stack([s - beyond - WIDTH / 2 + beyond * np.cos(FOLD), np.abs(beyond) * np.sin(FOLD)])
    return place, np.column_stack([np.sin(turn), -np.cos(turn)])


def skin(shape: str, rows: int, max_edge: float, lean: float = LEAN) -> Skin:
    """Draw, mesh and fold the sheet, and hold its ends; the left one is pulled."""
    length = 2 * GRIP + rows * SPACING
    outline = shapely.box(0, 0, length, WIDTH)
    across, along = np.array(SHAPES[shape])
    places = [
        (GRIP + SPACING * (row + 0.5) - REACH / 2 * along.max(), PITCH * (column + 0.5 - 0.5 * (row % 2)), row)
        for row in range(rows)
        for column in range(COLUMNS + row % 2)
    ]
    cuts = [shapely.LineString(np.column_stack([x + REACH * along, s + HALF * across])) for x, s, _ in places]
    lines = [shapely.LineString([(0, s), (length, s)]) for s in CREASES]
    lines += [shapely.LineString([(x, 0), (x, WIDTH)]) for x in (GRIP, length - GRIP)]
    depth = REACH * along.any() - REACH / 3  # of the pads; beside a slit, one lip stands for the fin
    lines += [shapely.LineString([(x + depth, s - HALF / 3), (x + depth, s + HALF / 3)])
              for x, s, _ in places if HALF < s < WIDTH - HALF]  # fmt: skip
    sheet = kg.Sheet(outline, [cut.intersection(outline) for cut in cuts], THICKNESS, PET)
    flat = sheet.mesh(max_edge, max_edge, lines=lines)
    x, s, _ = flat.nodes.T
    place, outwards = folded(s)
    mesh = kg.TriMesh(np.column_stack([x, place]), flat.triangles, cuts=flat.cuts, thickness=THICKNESS, material=PET)
    model = kg.Model.from_mesh(mesh)

    standing = np.zeros(len(x))
    centres = flat.nodes[flat.triangles].mean(axis=1)
    tips, lips, pads = [], [], []
    for (x0, s0, row), cut in zip(places, cuts):
        base = x0 if along.any() else x0 - REACH
        fin = shapely.Polygon(cut) if along.any() else shapely.box(base, s0 - HALF, x0, s0 + HALF)
        nodes = np.unique(flat.triangles[shapely.contains_xy(fin, *centres.T[:2])])
        standing[nodes] = ((x[nodes] - base) / REACH * (1 - ((s[nodes] - s0) / HALF) ** 2)).clip(0)
        if 0 < row < rows - 1 and CREASES[0] < s0 - HALF and s0 + HALF < CREASES[1]:
            tips.append(nodes[np.argmax(standing[nodes])])
            twins = np.flatnonzero((x == x[tips[-1]]) & (s == s[tips[-1]]))
            lips.append(twins[twins != tips[-1]][0])
            end = (x[nodes] > x0 + depth - 1e-9) & (np.abs(s[nodes] - s0) < HALF / 3 + 1e-9)
            pads.append(nodes[end])
    if lean:
        model.perturb(lean * standing[:, None] * np.column_stack([0 * x, outwards]))
    left, right = model.select(index=np.flatnonzero(x <= GRIP)), model.select(index=np.flatnonzero(x >= length - GRIP))
    model.add(kg.Fix(right), kg.Fix(left, "yz"), kg.Prescribe(left, x=-STRAIN * rows * SPACING))
    fin_area = shapely.Polygon(cuts[0]).area if along.any() else 0.0
    return Skin(model, left, right, np.array(tips), np.array(lips), pads, fin_area / (PITCH * SPACING))


def stretched(body: Skin) -> kg.Results:
    """Stretch the body; strain is STRAIN times the load factor."""
    return kg.DisplacementControl(body.model, targets=np.linspace(0.1, 1, 10)).run()


def pushed(body: Skin, at: kg.Step, push: float = PUSH) -> Floats:
    """Force on the middle fin along the body, with its tip (+x) and against it, at tenths of the push; shape (2, 11).

    The body is held as it is at the step `at`; the pad of the fin is free to move sideways and out.
    """
    m, pad = body.model, body.middle
    m.hold(at)
    forces = []
    for way in (1, -1):
        drive = m.add(kg.Prescribe(pad, x=at.u[m.index(pad), 0] + way * push))
        tenths = np.linspace(0, 1, 11)
        res = kg.DisplacementControl(m, start=at, targets=tenths[1:]).run()
        forces.append([way * res.reaction(pad, "x")[np.isclose(res.lam, lam, atol=1e-12)][0] for lam in tenths])
        m.remove(drive)
    return np.array(forces)


def pressed(shape: str, rows: int, max_edge: float) -> tuple[kg.Results, Floats, Floats]:
    """Stretch the body with its ends held GROUND over a plane: results, force on the ground, its deepest dent."""
    body = skin(shape, rows, max_edge)
    ground = body.model.add(kg.Contact(body.model.nodes, kg.Plane((0, 0, -GROUND))))
    res = stretched(body)
    return res, normal_forces(res, ground).sum(axis=1), penetration(res, ground)


def main(
    pictures: bool = False, rows: int = 5, max_edge: float = 3.0, shapes: tuple[str, ...] = tuple(SHAPES)
) -> dict[str, dict[str, float]]:
    """For each shape of cut: pop-out height and friction at full strain, forces on a fin at the full push."""
    law = {"base": BASE_FRICTION, "engagement": ENGAGEMENT}
    found, paths, curves = {}, {}, {}
    for shape in shapes:
        body = skin(shape, rows, max_edge)
        paths[shape] = res = stretched(body)
        height = body.height(res) - body.height(res)[0]
        friction, by_area = (
            friction_coefficient(height.clip(0), 1 / (PITCH * SPACING), factor, **law)
            for factor in (SURFACE_FACTOR, body.share)
        )
        push = pushed(body, res[-1])
        curves[shape] = res.lam * STRAIN, height, push
        found[shape] = {"height": height[-1], "friction": friction[-1], "friction by area": by_area[-1],
                        "with the tip": push[0, -1], "against it": push[1, -1]}  # fmt: skip
        if pictures:
            print(f"{shape}: " + ", ".join(f"{name} {value:.3f}" for name, value in found[shape].items()), flush=True)
    if pictures:
        draw(paths, curves, pressed(shapes[0], rows, max_edge))
    return found


def draw(
    paths: dict[str, kg.Results], curves: dict[str, tuple[Floats, ...]], press: tuple[kg.Results, Floats, Floats]
) -> None:
    """The bodies seen from below; pop-out and friction, a fin pushed both ways, the force on the ground."""
    from matplotlib import pyplot as plt

    figure = plt.figure(figsize=(13.5, 6.6))
    for column, shape in enumerate(list(paths)[:3]):
        ax = figure.add_axes((column / 3, 0.46, 1 / 3, 0.5), projection="3d")
        paths[shape].plot(ax=ax, view=(-30, -68), colorbar=False)
        ax.set_title(f"{shape}, strain {STRAIN:.0%}, from below", y=0.97)
    out, fin, ratio, ground = (figure.add_axes((left, 0.1, 0.155, 0.34)) for left in (0.045, 0.335, 0.585, 0.835))
    tenths = np.linspace(0, PUSH, 11)
    for number, (shape, (strain, height, push)) in enumerate(curves.items()):
        color = f"C{number}"
        out.plot(100 * strain, height, color=color, label=shape)
        fin.plot(tenths, push[0], color=color)
        fin.plot(tenths, push[1], "--", color=color)
        ratio.plot(tenths[1:], push[0, 1:] / push[1, 1:], color=color)
    ratio.axhline(1, color="0.6", lw=0.8)
    res, force, _ = press
    ground.plot(100 * STRAIN * res.lam, force, color="C0")
    out.set(xlabel="strain [%]", ylabel="pop-out height $h$ [mm]")
    per_mm = ENGAGEMENT * SURFACE_FACTOR / (PITCH * SPACING)
    scale = (lambda h: BASE_FRICTION + per_mm * h, lambda mu: (mu - BASE_FRICTION) / per_mm)
    out.secondary_yaxis("right", functions=scale).set_ylabel(rf"$\mu$ for $K_f$ = {ENGAGEMENT:g} mm, $S_f$ = 1")
    out.legend(frameon=False, loc="lower right")
    fin.set(xlabel="push of a fin [mm]", ylabel="force on a fin with its tip [N]\n(dashed: against it)")
    ratio.set(xlabel="push of a fin [mm]", ylabel="force with the tip\nover force against it")
    ground.set(xlabel="strain [%]", ylabel=f"force on a ground\n{GROUND:g} mm below [N]")
    for ax in (out, fin, ratio, ground):
        ax.set_xlim(0)
        ax.set_ylim(0)
    figure.savefig("crawler.png", dpi=110)


if __name__ == "__main__":
    main(True, ROWS, 2.0) if "--full" in sys.argv else main(True)
