"""A pop-up folded flat, a spiral pressed back into its plane, a fan whose lips collide: sheets that touch themselves.

* A card of PET with a row of windows is folded about it by 180 degrees until its halves lie on each other, pressed to
  nine tenths of the thickness. The ligaments between the windows have yielded; what the halves press each other with
  balances.
* A disc with a spiral slit is pulled out by its middle beyond yield, and pressed back. Lips of the slit meet on the
  way, and hold. What the pull works is stored, or lost to plastic flow.
* A fan, strips between slits on a spine, is bent in its plane. Opened it is the spine alone. Closed its lips meet at
  once, and it is as stiff as if nothing had been cut: with the ends turning about the middle of the spine by the angle
  a in all, its energy is that of fibres, E b / 2 (a / L)^2 L times the second moment of the height about that axis.

Chosen: PET of E = 3.5 GPa, nu = 0.34, that yields at 60 MPa and hardens to 65 MPa at 5 % and 120 MPa at 30 % plastic
strain. Units are SI. Needs the extra ``contact``.

    python examples/folded_and_pressed.py           half a minute: a picture, and what it prints
"""

from __future__ import annotations

import warnings

import numpy as np
import shapely

import kirigami as kg

DRAWN = 6  # times the movements of the fan in its picture
PET = kg.Material(E=3.5e9, nu=0.34, yield_stress=60e6, hardening=[(0.05, 65e6), (0.3, 120e6)])
ELASTIC = kg.Material(E=3.5e9, nu=0.34)
CARD, BAND, WINDOW, SHEET = 0.012, 0.010, 0.004, 1e-4  # half of the card, its width, length of the windows, thickness
RADIUS, INNER, TURNS, RISE, DISC = 0.03, 0.006, 2, 0.05, 1e-3
BEND = 2.0  # degrees by which the ends of the fan turn against each other
FAN, SPINE, STRIP, STRIPS, BOARD = 0.06, 0.005, 0.015, 6, 2e-3  # length, height of the spine and strips, thickness


def folded(max_edge: float = 0.0025, rung: str = "plate") -> kg.Results:
    """The card folded until its halves are nine tenths of the thickness apart."""
    places = (np.arange(3) + 0.5) * BAND / 3
    windows = [shapely.box(-0.5 * WINDOW, y - 0.0012, 0.5 * WINDOW, y + 0.0012) for y in places]
    sheet = kg.Sheet(shapely.box(-CARD, 0, CARD, BAND), windows, SHEET, PET)
    m = kg.Model.from_mesh(sheet.mesh(max_edge=max_edge), stiffness=rung)
    left = m.select(where=lambda x, y, z: x < -0.5 * WINDOW - 1e-9)
    right = m.select(where=lambda x, y, z: x > 0.5 * WINDOW + 1e-9)
    m.add(kg.Fix(left), kg.Turn(right, -180, axis="y", about=(0, 0, 0.45 * SHEET)), kg.SelfContact())
    return kg.DisplacementControl(m, targets=np.linspace(0.05, 1, 20)).run()


def spiral(nodes: int = 220) -> kg.Results:
    """The disc pulled out by its middle, and pressed back."""
    angle = np.linspace(0, 2 * np.pi * TURNS, 40 * TURNS)
    radius = INNER + (0.85 * RADIUS - INNER) * angle / angle[-1]
    slit = shapely.LineString(np.column_stack([radius * np.cos(angle), radius * np.sin(angle)]))
    sheet = kg.Sheet(shapely.Point(0, 0).buffer(RADIUS, quad_segs=12), [slit], DISC, PET)
    m = kg.Model.from_mesh(sheet.mesh(nodes=nodes), stiffness="shell")
    middle = m.select(where=lambda x, y, z: np.hypot(x, y) < 0.7 * INNER)
    rim = m.select(where=lambda x, y, z: np.hypot(x, y) > 0.99 * RADIUS)
    m.add(kg.Fix(rim, clamp=True), kg.Prescribe(middle, x=0, y=0, z=RISE), kg.SelfContact())
    return kg.DisplacementControl(m, targets=[*np.linspace(0.1, 1, 10), *np.linspace(0.9, 0.1, 9)], to=0.0).run()


def fan(closing: bool, cut: bool = True, max_edge: float = 0.005) -> kg.Results:
    """The fan, or the board it is cut from, bent by its ends, which turn as rigid edges."""
    gaps = (np.arange(STRIPS - 1) + 1) * FAN / STRIPS if cut else []
    slits = [shapely.LineString([(x, SPINE), (x, SPINE + STRIP)]) for x in gaps]
    sheet = kg.Sheet(shapely.box(0, 0, FAN, SPINE + STRIP), slits, BOARD, ELASTIC)
    m = kg.Model.from_mesh(sheet.mesh(max_edge=max_edge), stiffness="facet")
    ends = [m.select(boundary=side) for side in ("left", "right")]
    turn = (1.0 if closing else -1.0) * BEND / 2
    held = set(ends[0]) | set(ends[1])
    m.add(kg.Fix([node for node in m.nodes if node not in held], "z"), kg.SelfContact(thickness=2e-5))
    for nodes, sign, x in zip(ends, (-1.0, 1.0), (0.0, FAN)):
        m.add(kg.Turn(nodes, sign * turn, axis="z", about=(x, 0.5 * SPINE, 0)))
    return kg.DisplacementControl(m, targets=np.linspace(0.2, 1, 5)).run()


def pressed(card: kg.Results) -> tuple[float, float]:
    """Force that the halves of the folded card press each other with, and what is left of both together."""
    force = card.force("self-contact")[-1, :, 2]
    return float(force[card.rest[:, 0] > 0].sum()), float(abs(force.sum()))


def work(disc: kg.Results) -> float:
    """Work of the pull, there and back, by the trapezium rule."""
    middle = np.flatnonzero(np.hypot(*disc.rest[:, :2].T) < 0.7 * INNER)
    force = disc.reaction(middle, "z")
    return float((0.5 * (force[1:] + force[:-1]) * np.diff(RISE * disc.lam)).sum())


def of_fibres() -> float:
    """Energy of the uncut board whose ends turn about the middle of the spine."""
    high, low = STRIP + 0.5 * SPINE, 0.5 * SPINE
    return 0.5 * PET.E * BOARD * np.radians(BEND) ** 2 / FAN * (high**3 + low**3) / 3


def stored(res: kg.Results) -> float:
    """Energy at the end, the contact's with it."""
    return float(sum(res.energy.values())[-1])


def picture(card: kg.Results, disc: kg.Results, shut: kg.Results, wide: kg.Results, path: str) -> None:
    """The card on its way and folded, the disc pulled and pressed back, the fan opened and closed."""
    import matplotlib.pyplot as plt

    figure = plt.figure(figsize=(12, 7))
    half = int(np.argmin(np.abs(card.lam - 0.6)))
    out = int(np.argmax(disc.lam))
    for place, (res, step, title) in enumerate([
        (card, half, "a card on its way"), (disc, out, "a spiral pulled out"),
        (card, len(card) - 1, "folded flat"), (disc, len(disc) - 1, "pressed back"),
    ]):  # fmt: skip
        ax = figure.add_subplot(2, 3, (1, 2, 4, 5)[place], projection="3d")
        res.plot(step, ax=ax, color="plastic strain")
        ax.set_title(title)
    for place, res, title in ((3, wide, "a fan opened: its spine bends"), (6, shut, "closed: as if uncut")):
        ax = figure.add_subplot(2, 3, place)
        x, y, _ = (res.rest + DRAWN * res.u[-1]).T
        assert res.mesh is not None
        force = np.linalg.norm(res.force("self-contact")[-1], axis=1)[res.mesh.triangles].mean(axis=1)
        ax.tripcolor(x, y, res.mesh.triangles, force, cmap="Blues", edgecolors="0.7", vmax=4.0, vmin=0.0)
        ax.set_title(f"{title}\n(movements x {DRAWN}; blue: force of contact)", fontsize="medium")
        ax.set_aspect("equal")
        ax.set_axis_off()
    figure.tight_layout()
    figure.savefig(path, dpi=110)


def main(pictures: bool = False) -> float:
    """Energy of the closed fan over that of the board it is cut from: 1 where lips that meet hold as if uncut."""
    warnings.simplefilter("ignore", kg.KirigamiWarning)  # that meshes are coarse
    shut = fan(closing=True)
    if pictures:
        wide = fan(closing=False)
        print(f"fan: {stored(shut):.4g} J closed, {of_fibres():.4g} J uncut, {stored(wide):.4g} J opened")
        card = folded()
        force, left = pressed(card)
        print(f"card: its halves press each other with {force:.3g} N, and together with {left:.1g} N")
        disc = spiral()
        lost = disc.energy["dissipated"][-1]
        print(f"spiral: work {work(disc):.4g} J, {lost:.4g} J of it lost, {stored(disc):.4g} J with what is stored")
        for res in (shut, card, disc):
            print("       ", *(event.message for event in res.events if event.kind in ("contact", "crossing")))
        picture(card, disc, shut, wide, "folded_and_pressed.png")
    return stored(shut) / of_fibres()


if __name__ == "__main__":
    print(f"closed fan over uncut board: {main(True):.4f}")
