"""Thickness and material by facet, region and place: what is refused and told, saved and handed over."""

import warnings

import numpy as np
import pytest
import shapely

import kirigami as kg

STEEL, SOFT = kg.Material(1e9, 0.3, density=2.0), kg.Material(1e8, 0.4, density=1.0)
PAPER = kg.Orthotropic(6e9, 3e9, 0.3, 1.7e9, density=800.0)
BOX = [(0, 0), (4, 0), (4, 1), (0, 1)]
PATCH = [(1, 0), (2, 0), (2, 1), (1, 1)]


def mesh(**options):
    return kg.Sheet(BOX, regions={"patch": PATCH, "end": [(3, 0), (4, 0), (4, 1), (3, 1)]}, **options).mesh(0.4)


@pytest.mark.parametrize("thickness, words", [
    ({"nowhere": 1.0}, "a region 'nowhere', which the mesh does not have"),
    ({"patch": 1.0}, r"no thickness for facet \d+ at \("),
    ({None: 1.0, "patch": -1.0}, "thickness of region 'patch' must be"),
    (lambda x, y, z: 1 - x, r"thickness of facet \d+ at \("),
    (lambda x, y, z: x[:2], "what thickness"),
    ([1.0, 2.0], "thickness must be"),
    (0.0, "thickness must be"),
    (1e99, "overflows"),
])  # fmt: skip
def test_wrong_thickness_is_refused_with_the_place(thickness, words):
    with pytest.raises(kg.ModelError, match=words):
        kg.Model.from_mesh(mesh(), thickness, kg.Material(1e99, 0.3) if thickness == 1e99 else STEEL, "shell")


@pytest.mark.parametrize("material, words", [
    ({"nowhere": STEEL}, "a region 'nowhere'"),
    ({"patch": STEEL}, r"no material for facet \d+ at \("),
    ({None: STEEL, "patch": 3.0}, "material must be"),
    ([STEEL, SOFT], "2 materials for the"),
    ("steel", "material must be"),
    (lambda x, y, z: STEEL, "material must be"),
])  # fmt: skip
def test_wrong_materials_are_refused_with_the_place(material, words):
    with pytest.raises(kg.ModelError, match=words):
        kg.Model.from_mesh(mesh(), 0.01, material, "shell")


def test_regions_that_overlap_or_are_empty_are_named():
    both = kg.TriMesh([(0, 0), (1, 0), (1, 1), (0, 1)], [(0, 1, 2), (0, 2, 3)], regions={"a": [0, 1], "b": [1]})
    with pytest.raises(kg.ModelError, match="regions 'a' and 'b' overlap at facet 1"):
        kg.Model.from_mesh(both, {"a": 0.1, "b": 0.2}, STEEL)
    assert kg.Model.from_mesh(both, {"a": 0.1}, STEEL).sheet_constants.thickness == 0.1
    for regions, words in (
        ({"hole": []}, "'hole' is empty"),
        ({"far": [7]}, "'far' holds index 7"),
        ({3: [0]}, "regions must map names"),
    ):
        with pytest.raises(kg.GeometryError, match=words):
            kg.TriMesh(both.nodes, both.triangles, regions=regions)
    for region, words in (
        ([(9, 9), (10, 9), (9, 10)], "'a' lies outside"),
        ([(0, 0), (1, 1), (1, 0), (0, 1)], "'a' is not a simple polygon"),
        ([(0, 0), (1, 1)], "'a' must be a polygon"),
        ([(0, 0), (1, 1), (2, 2)], "'a'"),
        ("all", "region 'a'"),
    ):
        with pytest.raises(kg.GeometryError, match=words):
            kg.Sheet(BOX, regions={"a": region})
    inside = {"a": [(1.2, 0.4), (1.8, 0.4), (1.5, 0.6)]}
    opening = kg.Sheet(BOX, [shapely.box(1, 0.2, 2, 0.8)], regions=inside)
    with pytest.raises(kg.GeometryError, match="region 'a' is empty"):
        opening.mesh(0.3)


def test_borders_of_regions_are_edges_of_the_mesh_with_and_without_a_budget():
    for options in ({"max_edge": 0.3}, {"nodes": 300}):
        regions = {"patch": PATCH, "far": [(3, -1), (5, -1), (5, 9), (3, 9)]}
        found = kg.Sheet(BOX, [[(0.5, 0.5), (2.5, 0.5)]], regions=regions).mesh(**options)
        for name, area in (("patch", 1.0), ("far", 1.0)):
            assert found.facet_areas[found.regions[name]].sum() == pytest.approx(area, rel=1e-9)
        assert found.with_sets(some=[0]).regions.keys() == found.scaled(2.0).regions.keys() == {"patch", "far"}
        assert len(found.cuts) == 1


@pytest.mark.parametrize("rung", ["plate", "paper", "facet"])
def test_only_shells_stand_for_materials_with_directions(rung):
    with pytest.raises(kg.ModelError, match="use stiffness='shell'"):
        kg.Model.from_mesh(mesh(), {None: 0.01}, {None: STEEL, "patch": PAPER}, rung)


def test_laminates_have_a_thickness_of_their_own():
    pair = kg.Laminate([(STEEL, 0.01), (PAPER, 0.02)])
    assert kg.Model.from_mesh(mesh(), material=pair, stiffness="shell").sheet_constants.thickness == pytest.approx(0.03)
    assert kg.Sheet(BOX, material=pair).thickness == pytest.approx(0.03)
    with pytest.raises(kg.ModelError, match="are 0.03 thick together, but the thickness given is 0.04"):
        kg.Model.from_mesh(mesh(), 0.04, pair, "shell")
    mixed = kg.Model.from_mesh(mesh(thickness=0.01, material=STEEL), material={"patch": pair}, stiffness="shell")
    assert sorted(set(mixed.sheet_constants.thickness.tolist())) == pytest.approx([0.01, 0.03])
    for layers in ((), [STEEL], [(STEEL, 0.0)], [(STEEL, 1.0, 2.0)], 3.0, [("steel", 1.0)]):
        with pytest.raises(kg.ModelError, match="Laminate"):
            kg.Laminate(layers)
    assert pair.density == pytest.approx((2.0 * 0.01 + 800.0 * 0.02) / 0.03)
    upright = kg.TriMesh(np.array([[0, 0, 0], [0, 1, 0], [0, 1, 1], [0, 0, 1.0]]), [[0, 1, 2], [0, 2, 3]])
    paper = kg.Orthotropic(2.0, 1.0, 0.3, 0.5, angle=0.3)
    with pytest.raises(kg.ModelError, match="stands on it: give another axis"):  # nothing to count the angle from
        kg.System(kg.Model.from_mesh(upright, 0.01, paper, "shell"))
    with pytest.raises(kg.ModelError, match="nu12 must lie between"):
        kg.Orthotropic(1.0, 4.0, 0.6, 1.0)


def test_a_thickness_that_jumps_by_more_than_a_hundred_is_told_with_its_place():
    with pytest.warns(kg.KirigamiWarning, match=r"the thickness jumps at \((0.9|1.)"):
        kg.Model.from_mesh(kg.Sheet(BOX, regions={"patch": [(1, 0), (4, 0), (4, 1), (1, 1)]}).mesh(0.4),
                           {None: 1e-4, "patch": 0.1}, STEEL, "shell")  # fmt: skip
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        kg.Model.from_mesh(mesh(), {None: 1e-3, "patch": 0.1, "end": 1e-3}, STEEL, "shell")


@pytest.mark.parametrize("stiffness", ["plate", "facet", "shell"])
def test_a_uniform_property_is_one_however_it_is_given(stiffness):
    """The same model, bit by bit, whether told once, for each facet, by region or by place."""
    m = mesh()
    count = len(m.triangles)
    found = []
    for thickness, material in (
        (0.01, STEEL),
        (np.full(count, 0.01), [STEEL] * count),
        ({None: 0.01, "patch": 0.01}, {None: STEEL, "end": STEEL}),
        (lambda x, y, z: 0.01 + 0 * x, lambda x, y, z: [STEEL] * len(x)),
    ):
        model = kg.Model.from_mesh(m, thickness, material, stiffness)
        assert model.sheet_constants.thickness == 0.01 and model.sheet_constants.material == STEEL
        found.append(kg.System(model).stiffness(constrained=False))
    for other in found[1:]:
        assert abs(found[0] - other).max() == 0


def test_saved_and_handed_over(tmp_path):
    """Results files, Abaqus and OpenSees keep what each facet has."""
    sheet = mesh()
    model = kg.Model.from_mesh(sheet, {None: 0.01, "patch": 0.02}, {None: STEEL, "end": SOFT}, "shell")
    left, right = model.select(boundary="left"), model.select(boundary="right")
    model.add(kg.Fix(left, clamp=True), kg.Prescribe(right, x=0.01, y=0, z=0))
    results = kg.LinearStatic(model).run()
    again = kg.load(results.save(tmp_path / "results.npz"))
    np.testing.assert_array_equal(again.thickness, results.thickness)
    assert again.material == results.material and again.mesh.regions.keys() == sheet.regions.keys()
    np.testing.assert_allclose(again.stress(-1).tensor("top"), results.stress(-1).tensor("top"))
    text = model.to_abaqus(tmp_path / "sheet.inp").read_text()
    lines = text.splitlines()
    sections = {}
    for number, line in enumerate(lines):
        if line.startswith("*SHELL SECTION"):
            words = dict(word.split("=") for word in line.split(", ")[1:])
            material = lines[lines.index(f"*MATERIAL, NAME={words['MATERIAL']}") + 2]
            first = lines.index(f"*ELSET, ELSET={words['ELSET']}") + 1
            numbers = []
            for row in lines[first:]:
                if row.startswith("*"):
                    break
                numbers += [int(word) - 1 for word in row.split(",")]
            for facet in numbers:
                sections[facet] = (float(lines[number + 1]), material)
    expected = {facet: (0.01, "1000000000, 0.3") for facet in range(len(sheet.triangles))}
    expected |= {facet: (0.02, "1000000000, 0.3") for facet in sheet.regions["patch"].tolist()}
    expected |= {facet: (0.01, "100000000, 0.4") for facet in sheet.regions["end"].tolist()}
    assert sections == expected
    script = model.to_openseespy(tmp_path / "sheet.py").read_text()
    names: dict = {}
    exec(script[script.index("SECTIONS") : script.index("HELD")], names)
    told = [names["SECTIONS"][row[3]] for row in names["TRIANGLES"]]
    assert [(height, E) for E, _, height, _ in told] == [
        (height, float(material.split(",")[0])) for height, material in (expected[k] for k in range(len(told)))
    ]
    paper = kg.Model.from_mesh(sheet, 0.01, PAPER, "shell")
    with pytest.raises(kg.ModelError, match="sheets of Material only"):
        paper.to_openseespy(tmp_path / "no.py")


def test_laminates_are_saved(tmp_path):
    pair = kg.Laminate([(STEEL, 0.01), (PAPER, 0.02)])
    model = kg.Model.from_mesh(mesh(material=pair), stiffness="shell")
    left, right = model.select(boundary="left"), model.select(boundary="right")
    model.add(kg.Fix(left, clamp=True), kg.Prescribe(right, x=0.01))
    results = kg.LinearStatic(model).run()
    again = kg.load(results.save(tmp_path / "results.npz"))
    assert again.material == pair == again.mesh.material
    np.testing.assert_allclose(again.stress(-1).tensor("bottom"), results.stress(-1).tensor("bottom"))


@pytest.mark.filterwarnings("ignore:the mesh is biased", "ignore:bars lose stiffness")
@pytest.mark.parametrize("rung", ["plate", "facet", "shell"])
def test_varied_sheets_are_the_same_however_they_are_stated(rung):
    """Facets in another order, nodes in another, millimetres and kilonewtons: no two facets are alike."""
    base = kg.Sheet(BOX).mesh(0.6)
    count = len(base.triangles)
    share, stiff = np.linspace(1.0, 2.0, count), np.linspace(2.0, 1.0, count)
    random = np.random.default_rng(1)
    found = []
    for shuffled, length, force in ((False, 1.0, 1.0), (True, 1.0, 1.0), (False, 1e3, 1e-3)):
        order = random.permutation(count) if shuffled else np.arange(count)
        place = random.permutation(len(base.nodes)) if shuffled else np.arange(len(base.nodes))
        new = np.argsort(place)
        mesh = kg.TriMesh(base.nodes[place] * length, new[base.triangles[order]])
        materials = [kg.Material(1e6 * E * force / length**2, 0.3) for E in stiff[order].tolist()]
        model = kg.Model.from_mesh(mesh, 0.02 * share[order] * length, materials, rung)
        model.add(kg.Fix(model.select(boundary="left"), clamp=True))
        model.add(kg.NodalLoad(model.select(boundary="right"), np.array([0, 0, 1e-2]) * force))
        results = kg.LoadControl(model, step=0.5, on_instability="follow").run()
        assert len(results) == 3
        stress = results.stress(-1).tensor("top")
        found.append((results.u[-1][new] / length, stress[np.argsort(order)] * length**2 / force))
    for u, stress in found[1:]:
        np.testing.assert_allclose(u, found[0][0], atol=1e-8)
        np.testing.assert_allclose(stress, found[0][1], atol=1e-5 * np.abs(stress).max())
