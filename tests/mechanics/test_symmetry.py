"""Half a sheet and its mirror plane against the whole sheet; clamps that mean the same on every rung."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import shapely

import kirigami as kg

RUNGS = ("plate", "facet", "shell")


def halves(slit: bool = False) -> tuple[kg.TriMesh, kg.TriMesh]:
    """A sheet in x >= 0, and the same together with its mirror image; nodes of the first come first in both."""
    cuts = [[(0.3, 0.06), (0.3, 0.34)], [(0.7, 0.1), (0.7, 0.3)]] if slit else []
    half = kg.Sheet(shapely.box(0, 0, 1, 0.4), cuts).mesh(0.14 if slit else 0.15)
    n = len(half.nodes)
    rest = np.flatnonzero(half.nodes[:, 0] > 1e-12)
    twin = np.arange(n)
    twin[rest] = n + np.arange(len(rest))
    nodes = np.vstack([half.nodes, half.nodes[rest] * [-1, 1, 1]])
    return half, kg.TriMesh(nodes, np.vstack([half.triangles, twin[half.triangles][:, ::-1]]))


def models(rung: str, pull: dict[str, object], bump: float = 0.0, slit: bool = False) -> list[kg.Model]:
    """Half and whole, moved at their outer ends by the same in y and z and by the mirror image of it in x."""
    found = []
    for mesh in halves(slit):
        m = kg.Model.from_mesh(mesh, 0.004, kg.Material(E=1e9, nu=0.3), stiffness=rung)
        x, y = mesh.nodes[:, 0], mesh.nodes[:, 1]
        m.perturb(bump * np.cos(9 * x) * np.cos(7 * y - 0.3))
        for side in (1, -1):
            end = [node for node, place in zip(m.nodes, x) if abs(place - side) < 1e-9]
            if end:
                at = np.array([node.y for node in end])
                moves = {axis: value(at) if callable(value) else value for axis, value in pull.items()}
                m.add(kg.Prescribe(end, x=side * moves["x"], y=moves.get("y", 0.0), z=moves.get("z", 0.0)))
        if mesh.nodes[:, 0].min() == 0:
            m.add(kg.Symmetry(m.select(boundary="left"), "x"))
        found.append(m)
    return found


CASES = {
    "bent": ({"x": -0.05, "z": 0.3}, 0.0, False),
    "tilted": ({"x": 0.01, "z": lambda y: 0.8 * (y - 0.1)}, 0.0, False),
    "stretched": ({"x": 0.05}, 0.0, False),
    "buckled": ({"x": 0.05}, 0.004, True),
    "pressed": ({"x": -0.02}, 0.004, False),
}


PAIRS = [
    pytest.param(case, rung, marks=pytest.mark.long if rung == "shell" and case != "stretched" else ())
    for case in CASES
    for rung in RUNGS
]


@pytest.mark.parametrize(("case", "rung"), PAIRS)
def test_half_a_sheet_does_what_the_whole_one_does(case: str, rung: str) -> None:
    pull, bump, slit = CASES[case]
    ends = []
    for m in models(rung, pull, bump, slit):
        res = kg.DisplacementControl(m, tol=1e-11, targets=np.linspace(0.1, 1, 10)).run()
        ends.append((res, m))
    (half, m), (whole, _) = ends
    n = len(half.rest)
    for lam in (0.5, 1.0):
        one, other = (res[int(np.argmin(np.abs(res.lam - lam)))].u for res in (half, whole))
        assert one == pytest.approx(other[:n], abs=1e-6 * np.abs(other).max())
    if case == "tilted":  # the edges in the plane have turned in it
        rows = [k for k, node in enumerate(m.nodes) if node.x == 0]
        assert np.ptp(half.u[-1][rows, 2]) > 0.1
    energy, double = (sum(res.energy.values())[-1] for res, _ in ends)
    assert 2 * energy == pytest.approx(double, rel=1e-6)
    right = np.flatnonzero(np.abs(half.rest[:, 0] - 1) < 1e-9)
    force, twice = (res.reaction(right.tolist())[-1] for res, _ in ends)
    assert force == pytest.approx(twice, rel=1e-6, abs=1e-6 * np.abs(twice).max())


@pytest.mark.parametrize("rung", RUNGS)
def test_a_quarter_of_a_plate_under_load(rung: str) -> None:
    """Two planes that meet in a corner facet."""
    half, _ = halves()
    n = len(half.nodes)
    rest = np.flatnonzero(half.nodes[:, 1] > 1e-12)
    twin = np.arange(n)
    twin[rest] = n + np.arange(len(rest))
    whole = kg.TriMesh(
        np.vstack([half.nodes, half.nodes[rest] * [1, -1, 1]]),
        np.vstack([half.triangles, twin[half.triangles][:, ::-1]]),
    )
    deflections = []
    for mesh in (half, whole):
        m = kg.Model.from_mesh(mesh, 0.01, kg.Material(E=1e9, nu=0.3), stiffness=rung)
        m.add(kg.Symmetry(m.select(boundary="left"), "x"))
        m.add(kg.Fix(m.select(boundary="right"), "z"))
        if mesh is half:
            m.add(kg.Symmetry(m.select(boundary="bottom"), "y"))
        else:
            m.add(kg.Fix(m.select(where=lambda x, y, z: np.abs(y) < 1e-12), "y"))
        shared = 1.0 if mesh is whole else 0.5  # loads in the second plane
        m.add(*(kg.NodalLoad(node, (0, 0, 1.0 if abs(node.y) > 1e-12 else shared)) for node in m.nodes[:n]))
        m.add(*(kg.NodalLoad(node, (0, 0, 1)) for node in m.nodes[n : len(mesh.nodes)]))
        deflections.append(kg.LinearStatic(m).run().u[-1][:n, 2])
    assert deflections[0] == pytest.approx(deflections[1], rel=1e-6)


@pytest.mark.parametrize("rung", RUNGS)
def test_across_every_axis_and_in_files(rung: str, tmp_path: Path) -> None:
    """A half beam stood up along z, its plane across z; saved results tell the same."""
    half, _ = halves()
    found = []
    for turn in (np.eye(3), np.array([[0, 1, 0], [0, 0, 1], [1, 0, 0.0]])):
        m = kg.Model.from_mesh(
            kg.TriMesh(half.nodes @ turn.T, half.triangles), 0.01, kg.Material(1e9, 0.3), stiffness=rung
        )
        normal = "xyz"[int(np.argmax(turn[:, 0]))]
        middle, end = (
            [node for node, point in zip(m.nodes, half.nodes) if abs(point[0] - place) < 1e-12] for place in (0, 1)
        )
        lift = dict(zip("xyz", (turn @ [0.0, 0.0, 0.4]).tolist()))
        m.add(kg.Symmetry(middle, normal), kg.Prescribe(end, **lift))
        res = kg.DisplacementControl(m, tol=1e-11).run()
        found.append(res.u[-1] @ turn)
        loaded = kg.load(res.save(tmp_path / "half.npz"))
        assert np.array_equal(loaded.energy["clamps"] if "clamps" in res.energy else 0, res.energy.get("clamps", 0))
        assert loaded.supports[0].kind == "Symmetry"
        with pytest.raises(kg.ModelError, match="only Fix and Prescribe"):
            m.to_abaqus(tmp_path / "half.inp")
        m.hold(res[-1])
        m.add(kg.NodalLoad(m.nodes[5], (1e-9, 0, 0)))
        kept = kg.LoadControl(m, start=res[-1]).run()
        assert kept.u[-1] == pytest.approx(res.u[-1], abs=1e-6)
    assert found[0] == pytest.approx(found[1], abs=1e-8)


def test_what_is_no_plane_of_symmetry_is_refused() -> None:
    half, _ = halves()
    sheet = kg.Model.from_mesh(half, 0.01, kg.Material(1e9))
    left, bottom = sheet.select(boundary="left"), sheet.select(boundary="bottom")
    with pytest.raises(kg.ModelError, match="normal must be 'x', 'y' or 'z'"):
        kg.Symmetry(left, (1, 0, 0))  # type: ignore[arg-type]
    refused = {
        "do not lie in one plane across x": kg.Symmetry(left + bottom, "x"),
        "lies in the mirror plane": kg.Symmetry(left, "z"),
        "hold no edge on the boundary": kg.Symmetry(left[0], "x"),
    }
    for words, item in refused.items():
        m = kg.Model.from_mesh(half, 0.01, kg.Material(1e9))
        nodes = [m.nodes[sheet.index([node])[0]] for node in item.group]
        m.add(kg.Symmetry(nodes, item.mirror), kg.NodalLoad(m.nodes[-1], (0, 0, 1)))
        with pytest.raises(kg.ModelError, match=words):
            kg.System(m)
    truss = kg.Model()
    a, b = truss.add(kg.Node(0, 0), kg.Node(1, 0))
    truss.add(kg.Bar(a, b, 1.0), kg.Symmetry(a, "x"))
    with pytest.raises(kg.ModelError, match="Model.from_mesh"):
        kg.System(truss)


# ---- clamps


@pytest.mark.parametrize("rung", RUNGS)
def test_a_clamp_that_may_rise_is_a_plane_of_symmetry(rung: str) -> None:
    """Held across the plane only, a clamped edge rises and tilts with the sheet, and keeps its direction across."""
    half, _ = halves()
    ends = []
    for mirrored in (True, False):
        m = kg.Model.from_mesh(half, 0.004, kg.Material(1e9, 0.3), stiffness=rung)
        left, right = m.select(boundary="left"), m.select(boundary="right")
        m.add(kg.Symmetry(left, "x") if mirrored else kg.Fix(left, "x", clamp=True))
        y = np.array([node.y for node in right])
        m.add(kg.Prescribe(right, x=0.01, y=0, z=0.8 * (y - 0.1)))
        ends.append(kg.DisplacementControl(m, tol=1e-11).run().u[-1])
    assert ends[0] == pytest.approx(ends[1], abs=1e-8)


@pytest.mark.parametrize("rung", RUNGS)
@pytest.mark.parametrize("axis", [0, 2])
def test_a_clamp_takes_its_direction_along(rung: str, axis: int) -> None:
    """A strip clamped at both ends that are turned together, tilted or in the plane: nothing is strained at the end."""
    half, _ = halves()
    m = kg.Model.from_mesh(half, 0.01, kg.Material(1e6, 0.3), stiffness=rung)
    grips = m.select(boundary="left") + m.select(boundary="right")
    points = np.array([[node.x, node.y, node.z] for node in grips])
    angle = 1.2
    c, s = np.cos(angle), np.sin(angle)
    turn = np.eye(3)
    one, two = [k for k in range(3) if k != axis]
    turn[[one, one, two, two], [one, two, one, two]] = c, -s, s, c
    moves = points @ turn.T - points
    m.add(kg.Prescribe(grips, x=moves[:, 0], y=moves[:, 1], z=moves[:, 2], clamp=True))
    u = half.nodes @ turn.T - half.nodes
    system = kg.System(m)
    if rung != "shell":
        rows = np.zeros_like(system.rest)
        rows[: len(u)] = u
        assert sum(system.energies(rows, 1.0).values()) < 1e-12
    end = kg.DisplacementControl(m, tol=1e-11).run()
    assert sum(end.energy.values())[-1] < 1e-9 * sum(end.energy.values()).max()


@pytest.mark.parametrize("rung", RUNGS)
def test_a_clamp_that_holds_nothing_is_refused(rung: str) -> None:
    """Nodes on a line inside the sheet, a single corner: no boundary edge and no whole facet."""
    mesh = kg.Sheet(shapely.box(0, 0, 1, 0.2)).mesh(0.07, lines={"mid": shapely.LineString([(0.5, 0), (0.5, 0.2)])})
    for choose in ("mid", "corner"):
        m = kg.Model.from_mesh(mesh, 0.01, kg.Material(1e9, 0.3), stiffness=rung)
        nodes = m.select(boundary="mid") if choose == "mid" else [m.select(boundary="left")[0]]
        m.add(kg.Fix(nodes, clamp=True), kg.NodalLoad(m.select(boundary="right"), (0, 0, 1)))
        with pytest.raises(kg.ModelError, match="no edge on the boundary and no whole facet"):
            kg.LinearStatic(m).run()


@pytest.mark.parametrize("rung", RUNGS)
def test_a_held_region_clamps_what_is_beyond_it(rung: str) -> None:
    """Three columns of nodes held, whole facets among them: near P L^3 / 3 E I of what is beyond."""
    x = np.linspace(-0.1, 1, 23)
    nodes = np.array([(a, b, 0) for a in x for b in (0, 0.05, 0.1)])
    triangles = []
    for i in range(22):
        for j in range(2):
            a, b, c, d = 3 * i + j, 3 * i + j + 1, 3 * i + j + 3, 3 * i + j + 4
            triangles += [(a, c, d), (a, d, b)] if j else [(a, c, b), (c, d, b)]
    m = kg.Model.from_mesh(kg.TriMesh(nodes, triangles), 0.01, kg.Material(1e9, 0.0), stiffness=rung)
    end = m.select(boundary="right")
    m.add(kg.Fix(m.select(where=lambda x, y, z: x < 1e-9), clamp=True), kg.NodalLoad(end, (0, 0, 0.1 / len(end))))
    tip = kg.LinearStatic(m).run().u[-1][m.index(end), 2].mean()
    assert tip == pytest.approx(0.1 / (3 * 1e9 * 0.1 * 0.01**3 / 12), rel=0.1)


@pytest.mark.parametrize("rung", RUNGS)
def test_what_is_held_twice_at_zero_is_held_once(rung: str) -> None:
    """A corner that lies in the plane of symmetry and in a support: each says the same of it, whichever comes first."""

    def pulled(*supports: tuple[str, str]) -> kg.Results:
        m = kg.Model.from_mesh(halves()[0], 0.004, kg.Material(E=1e9, nu=0.3), stiffness=rung)
        left, bottom = m.select(boundary="left"), m.select(boundary="bottom")
        corner = [node for node in left if node in bottom]
        rest = [node for node in bottom if node not in corner]
        chosen = {
            "plane": lambda axes: kg.Symmetry(left, "x"), "all": lambda axes: kg.Fix(bottom, axes),
            "rest": lambda axes: kg.Fix(rest, axes), "corner": lambda axes: kg.Fix(corner, axes),
            "still": lambda axes: kg.Prescribe(corner, x=0.0),
        }  # fmt: skip
        m.add(*(chosen[name](axes) for name, axes in supports))
        m.add(kg.Fix(m.select(boundary="top"), "z"), kg.NodalLoad(m.select(boundary="right"), (10.0, 0.0, 0.5)))
        return kg.LinearStatic(m).run()

    apart = [("plane", ""), ("rest", "xyz"), ("corner", "yz")]
    if rung == "shell":  # where a support holds the middle of an edge of its own nodes alone
        apart = [("plane", ""), ("all", "xyz")]
    once = pulled(*apart)
    for supports in (
        [("all", "xyz"), ("plane", "")],
        [("plane", ""), ("all", "xyz"), ("still", ""), ("corner", "xy")],
    ):  # fmt: skip
        twice = pulled(*supports)
        assert np.array_equal(twice.u, once.u)
        assert np.array_equal(twice.reaction(twice.nodes), once.reaction(once.nodes))
    with pytest.raises(kg.ModelError, match="both constrain x"):
        m = kg.Model.from_mesh(halves()[0], 0.004, kg.Material(E=1e9, nu=0.3), stiffness=rung)
        m.add(kg.Symmetry(m.select(boundary="left"), "x"), kg.Prescribe(m.select(boundary="bottom"), x=0.1))
        kg.System(m)
