"""Cuts that reach an edge, ligaments of one facet, pieces that hang by one node or by nothing."""

from __future__ import annotations

import meshes
import numpy as np
import pytest
import shapely

import kirigami as kg

MATERIAL = kg.Material(2.0)


def pull(m: kg.Model, strain: float, axis: str = "x") -> tuple[kg.Results, list[kg.Node]]:
    """Stretch a flat sheet uniformly: rollers at both ends, free to contract."""
    k = "xyz".index(axis)
    place = m.positions()[:, k]
    low = m.select(index=np.flatnonzero(place < place.min() + 1e-9))
    high = m.select(index=np.flatnonzero(place > place.max() - 1e-9))
    other = "y" if axis == "x" else "x"
    m.add(kg.Fix(low, axis), kg.Fix(low[0], other), kg.Prescribe(high, **{axis: strain * np.ptp(place)}))
    m.add(kg.Fix(m.nodes, "z"))
    return kg.DisplacementControl(m).run(), high


@pytest.mark.parametrize("reaching", ["both tips inside", "open to the end"])
def test_slit_along_the_pull_changes_nothing(reaching: str) -> None:
    """Cut between two rows, each row still carries E t e of its width: the uniform state is the solution.

    Rows of equilateral triangles with edges along the pull are exact strips at any width. F = E A e (1 + e_end).
    """
    columns, rows, thickness, end = 8, 4, 0.01, 0.01
    nodes, triangles = meshes.equilateral_strip(columns, rows)
    level = 2 * meshes.SIXTY_DEGREES
    on_line = np.flatnonzero(np.abs(nodes[:, 1] - level) < 1e-9)
    on_line = on_line[np.argsort(nodes[on_line, 0])]
    chain = on_line[2:-2].tolist() if reaching == "both tips inside" else on_line[3:].tolist()
    opened, cut = meshes.open_slit(nodes, triangles, chain + ([-1] if reaching != "both tips inside" else []))
    m = kg.Model.from_mesh(kg.TriMesh(opened, cut), thickness, MATERIAL)
    assert len(m.nodes) == len(nodes) + len(chain) - (2 if reaching == "both tips inside" else 1)
    res, high = pull(m, end)
    strain = end * (1 + end / 2)
    width = rows * meshes.SIXTY_DEGREES
    # Triangles halved at the two ends carry along their edges only, which costs the end cells a little.
    whole = kg.Model.from_mesh(kg.TriMesh(nodes, triangles), thickness, MATERIAL)
    uncut, high_uncut = pull(whole, end)
    assert uncut.reaction(high_uncut, "x")[-1] == pytest.approx(2.0 * thickness * width * strain * (1 + end), rel=0.006)
    assert res.reaction(high, "x")[-1] == pytest.approx(uncut.reaction(high_uncut, "x")[-1], rel=1e-3)


@pytest.mark.parametrize("rows", [1, 2, 4])
def test_ligament_of_few_facets(rows: int) -> None:
    """A narrow bridge between two wide grips, one facet wide and more: E t e of its width, exact for uniform strips."""
    columns, thickness, end = 24, 0.01, 1e-4
    nodes, triangles = meshes.equilateral_strip(columns, rows)
    m = kg.Model.from_mesh(kg.TriMesh(nodes, triangles), thickness, MATERIAL)
    res, high = pull(m, end)
    expected = 2.0 * thickness * rows * meshes.SIXTY_DEGREES * end * (1 + end / 2) * (1 + end)
    assert res.reaction(high, "x")[-1] == pytest.approx(expected, rel=2e-3)
    inner = [bar for bar in m.elements if isinstance(bar, kg.Bar) and all(4 < n.x < columns - 4 for n in bar.nodes)]
    level = [m.elements.index(bar) for bar in inner if abs(bar.nodes[0].y - bar.nodes[1].y) < 1e-9]
    assert np.ptp(res.bar_strain[-1, level]) < 0.02 * end  # uniform away from the ends


def test_ligament_one_facet_wide_in_a_cut_sheet() -> None:
    """Two slits that leave one facet between them: stretched past buckling, both grips pull alike."""
    slits = [shapely.LineString([(-0.01, 0.5), (0.48, 0.5)]), shapely.LineString([(0.52, 0.5), (1.01, 0.5)])]
    with pytest.warns(kg.KirigamiWarning, match="beyond the edge"):
        mesh = kg.Sheet(shapely.box(0, 0, 1, 1), slits, thickness=2e-3, material=MATERIAL).mesh(0.2, cut_edge=0.045)
    m = kg.Model.from_mesh(mesh)
    across = [k for k, (a, b) in enumerate(mesh.edges) if mesh.edge_facets[k, 1] >= 0
              and abs(mesh.nodes[[a, b], 1] - 0.5).max() < 1e-9]  # fmt: skip
    assert len(across) == 1  # the bridge is one edge of the mesh
    x, y, _ = m.positions().T
    m.perturb(1e-5 * np.sin(np.pi * y) * (1 + x))
    bottom, top = m.select(boundary="bottom"), m.select(boundary="top")
    m.add(kg.Fix(bottom), kg.Fix(top, "xz"), kg.Prescribe(top, y=0.05))
    res = kg.DisplacementControl(m).run()
    force = res.reaction(top, "y")
    assert res.lam[-1] == 1.0 and res.residual.max() <= 1e-8 and np.all(force[1:] > 0)
    assert res.reaction(bottom, "y") == pytest.approx(-force, abs=1e-6 * force.max())


def test_two_sheets_joined_by_one_node() -> None:
    """Joined at a corner only, the upper part turns about that point: refused, with the motion; held, it carries."""
    nodes = np.array([[0, 0], [1, 0], [0, 1], [1, 1], [2, 1], [1, 2], [2, 2]], float)
    m = kg.Model.from_mesh(kg.TriMesh(nodes, [[0, 1, 2], [1, 3, 2], [3, 4, 5], [4, 6, 5]]), 0.01, MATERIAL)
    upper = m.select(box=(1.5, 0.5, 2.5, 2.5))
    m.add(kg.Fix(m.select(box=(-0.1, -0.1, 1.1, 0.9))), kg.Fix(m.select(index=[2])))
    drive = m.add(kg.NodalLoad(upper, (1e-6, 0, 0)))
    with pytest.raises(kg.MechanismError) as caught:
        kg.LoadControl(m).run()
    assert 6 in caught.value.nodes
    m.remove(drive)
    m.add(kg.Prescribe(m.nodes[6], x=0.01, y=0.01, z=0.0), kg.Fix(m.nodes[4], "z"), kg.Fix(m.nodes[5], "z"))
    res = kg.DisplacementControl(m).run()
    assert res.lam[-1] == 1.0
    pulled = res.reaction(6)[-1]
    assert pulled[0] > 0 and pulled[1] > 0 and abs(pulled[2]) < 1e-12  # it is pulled along its diagonal


@pytest.mark.parametrize("drawing", ["across", "loop", "crossing"])
def test_severed_sheets_are_refused_with_their_parts(drawing: str) -> None:
    cuts = {
        "across": [[(0, 0.4), (1, 0.6)]],
        "loop": [[(0.3, 0.3), (0.7, 0.3), (0.7, 0.7), (0.3, 0.7), (0.3, 0.3)]],
        "crossing": [[(0.35, 0), (0.35, 0.6)], [(0, 0.35), (0.6, 0.35)]],
    }[drawing]
    sheet = kg.Sheet(shapely.box(0, 0, 1, 1), [shapely.LineString(cut) for cut in cuts])
    with pytest.raises(kg.GeometryError, match="sever the sheet into 2 parts"):
        sheet.mesh(0.2)
    mesh = sheet.mesh(0.2, allow_parts=True)
    assert mesh.facet_parts.max() == 1 and mesh.facet_areas.sum() == pytest.approx(1.0, rel=1e-10)
    m = kg.Model.from_mesh(mesh, 1e-3, MATERIAL)
    bottom = m.select(boundary="bottom")
    m.add(kg.Fix(bottom), kg.NodalLoad(bottom[0], (0, 0, 0)), kg.NodalLoad(m.nodes[-1], (1e-9, 0, 0)))
    with pytest.raises((kg.MechanismError, kg.ModelError)):
        kg.LinearStatic(m).run()


def test_slits_that_meet_end_to_end_or_lie_on_each_other() -> None:
    """A slit in two pieces is the slit in one piece, and a repeated one is cut once."""
    whole = kg.Sheet(shapely.box(0, 0, 1, 1), [shapely.LineString([(0.2, 0.5), (0.8, 0.5)])]).mesh(0.2)
    pieces = [shapely.LineString([(0.2, 0.5), (0.5, 0.5)]), shapely.LineString([(0.5, 0.5), (0.8, 0.5)])]
    split = kg.Sheet(shapely.box(0, 0, 1, 1), pieces).mesh(0.2)
    assert len(split.cuts) == len(whole.cuts) == 1 and split.cuts[0].members == (0, 1)
    with pytest.warns(kg.KirigamiWarning, match="merged"):
        twice = kg.Sheet(shapely.box(0, 0, 1, 1), [pieces[0], pieces[0]]).mesh(0.2)
    assert len(twice.cuts) == 1
