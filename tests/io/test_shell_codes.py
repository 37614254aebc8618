"""The same sheet in shell codes: what the writers hand over, and runs of CalculiX and OpenSeesPy where installed."""

from __future__ import annotations

import csv
import importlib.util
import re
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import kirigami as kg
from kirigami.io.abaqus import to_abaqus
from kirigami.io.opensees import to_openseespy

MATERIAL = kg.Material(E=2e9, nu=1 / 3, density=1400.0)  # bars of equilateral facets have a Poisson ratio of 1/3


def equilateral_strip(columns: int, rows: int) -> kg.TriMesh:
    """Edges of length 1 along x; half facets close the ends, so the outline is a rectangle."""
    height = np.sqrt(3) / 2
    nodes: list[tuple[float, float]] = []
    layers = []
    for j in range(rows + 1):
        xs = np.arange(columns + 1.0) if j % 2 == 0 else np.r_[0.0, np.arange(columns) + 0.5, float(columns)]
        layers.append(range(len(nodes), len(nodes) + len(xs)))
        nodes += [(x, height * j) for x in xs]
    facets = []
    for j in range(rows):
        whole, staggered = layers[j], layers[j + 1]
        if j % 2:
            whole, staggered = staggered, whole
        facets += [(whole[i], whole[i + 1], staggered[i + 1]) for i in range(columns)]
        facets += [(whole[i], staggered[i + 1], staggered[i]) for i in range(columns + 1)]
    return kg.TriMesh(nodes, facets)


def pulled(stretch: float = 1e-3) -> kg.Model:
    """Uniaxial stress: free sides, ends that may contract."""
    m = kg.Model.from_mesh(equilateral_strip(8, 4), 0.02, MATERIAL)
    m.name = "pulled patch"
    left, right = m.select(boundary="left"), m.select(boundary="right")
    m.add(kg.Fix(left, "xz"), kg.Fix(m.select(index=0), "y"), kg.Prescribe(right, x=8 * stretch, z=0.0))
    return m


def bent(lift: float = 0.02) -> kg.Model:
    """A cantilever, clamped at the left, lifted at the right."""
    m = kg.Model.from_mesh(equilateral_strip(20, 4), 0.02, MATERIAL)
    m.add(kg.Fix(m.select(boundary="left"), clamp=True), kg.Prescribe(m.select(boundary="right"), z=lift))
    return m


def disc() -> kg.Model:
    """A disc with one slit, its upper lip bulged, two small grips pulled apart by 0.1 per cent of the radius."""
    outline, cuts = kg.cuts.single_slit_disc(radius=3, length=2.58)
    mesh = kg.Sheet(outline, cuts, 0.003, kg.Material(E=760000, nu=0.34)).mesh(0.45, cut_edge=0.2)
    m = kg.Model.from_mesh(mesh)
    x, y, _ = mesh.nodes.T
    upper = mesh.nodes[mesh.triangles, 1].mean(axis=1) > 0
    above = np.isin(np.arange(len(x)), mesh.triangles[upper]) & ~np.isin(np.arange(len(x)), mesh.triangles[~upper])
    bump = np.where(above & (np.abs(x) < 1.29), 0.05 * (1 - (x / 1.29) ** 2) ** 2 * np.exp(-((y / 2.95) ** 2)), 0.0)
    m.perturb(bump)
    for side, pull in ((1, 5e-5), (-1, -5e-5)):
        grip = m.select(boundary="outer", where=lambda x, y, z, s=side: (np.abs(x) <= 0.25) & (s * y > 2))
        m.add(kg.Prescribe(grip, x=0, y=pull, z=0))
    return m


# ------------------------------------------------------------------------------------------- what is written


def blocks(text: str) -> list[tuple[str, list[str]]]:
    """Keyword lines of an input file with the data lines below each."""
    found: list[tuple[str, list[str]]] = []
    for line in text.splitlines():
        if line.startswith("**"):
            continue
        if line.startswith("*"):
            found.append((line, []))
        else:
            found[-1][1].append(line)
    return found


def test_abaqus_file_says_all_that_the_model_says(tmp_path: Path) -> None:
    m = bent()
    m.perturb(np.random.default_rng(0).normal(size=len(m.nodes)), amplitude=1e-3)
    m.add(kg.NodalLoad(m.nodes[7], (0, 0, -2.5)))
    text = to_abaqus(m, tmp_path / "bent.inp", targets=[0.5, 1.0]).read_text()
    found = blocks(text)
    rows = {keyword.partition(",")[0]: data for keyword, data in found}
    places = np.array([row.split(",") for row in rows["*NODE"]], dtype=float)
    assert places[:, 1:] == pytest.approx(m.positions(), abs=1e-12)
    facets = np.array([row.split(",") for row in rows["*ELEMENT"]], dtype=int)
    assert np.array_equal(facets[:, 1:] - 1, m.mesh.triangles)
    assert [float(value) for value in rows["*ELASTIC"][0].split(",")] == pytest.approx([2e9, 1 / 3])
    assert float(rows["*DENSITY"][0]) == 1400 and float(rows["*SHELL SECTION"][0]) == 0.02
    first, *steps = (data for keyword, data in found if keyword == "*BOUNDARY")
    left = m.index(m.select(boundary="left")) + 1
    assert set(first) == {f"{n}, {a}, {a}" for n in left for a in (1, 2, 3)} | {f"{n}, 4, 5" for n in left}
    right = m.index(m.select(boundary="right")) + 1
    assert [set(data) for data in steps] == [{f"{n}, 3, 3, {0.02 * lam:.13g}" for n in right} for lam in (0.5, 1.0)]
    assert [data for keyword, data in found if keyword == "*CLOAD"] == [["8, 3, -1.25"], ["8, 3, -2.5"]]
    assert max(len(field) for row in text.splitlines() if row[:1].isdigit() for field in row.split(", ")) <= 20


def test_quadratic_elements_share_the_nodes_between(tmp_path: Path) -> None:
    m = bent()
    found = blocks(to_abaqus(m, tmp_path / "bent.inp", element="S6").read_text())
    rows = {keyword: data for keyword, data in found}
    places = np.array([row.split(",")[1:] for row in rows["*NODE, NSET=ALL"]], dtype=float)
    facets = np.array([row.split(",")[1:] for row in rows["*ELEMENT, TYPE=S6, ELSET=SHEET"]], dtype=int) - 1
    assert len(places) == len(m.nodes) + len(m.mesh.edges)
    for corner in range(3):
        ends = facets[:, [corner, (corner + 1) % 3]]
        assert places[facets[:, 3 + corner]] == pytest.approx(places[ends].mean(axis=1), abs=1e-12)
    left = np.flatnonzero(places[:, 0] == 0)
    named = [int(number) - 1 for row in rows["*NSET, NSET=FIXED_0"] for number in row.split(",")]
    assert sorted(named) == left.tolist() and len(left) == 9


def test_what_acts_from_the_start_has_a_step_of_its_own(tmp_path: Path) -> None:
    m = pulled()
    m.add(kg.NodalLoad(m.nodes[20], (0, 0, 1.0), constant=True))
    text = to_abaqus(m, tmp_path / "held.inp").read_text()
    assert re.findall(r"load factor (\S+)", text) == ["0", "1"]
    script = to_openseespy(m, tmp_path / "held.py").read_text()
    assert "(20, (0.0, 0.0, 1.0), (0.0, 0.0, 0.0))," in script


@pytest.mark.parametrize("write", [to_abaqus, to_openseespy])
def test_what_cannot_be_handed_over_is_refused(write, tmp_path: Path) -> None:
    path = tmp_path / "model"
    m = pulled()
    for item, message in (
        (kg.Bar(m.nodes[0], m.nodes[30], EA=1.0), "1 Bar beyond the sheet"),
        (kg.Tie(m.nodes[15], m.nodes[16], "y"), "Tie.* only Fix and Prescribe"),
    ):
        m.add(item)
        with pytest.raises(kg.ModelError, match=message):
            write(m, path)
        m.remove(item)
    with pytest.raises(kg.ModelError, match="needs a three-dimensional model made by Model.from_mesh"):
        write(kg.Model(), path)
    for material, message in (
        (kg.Material(E=1e9, yield_stress=1e6), "cannot hand over that Material.* yields"),  # was elastic there
        (kg.NeoHookean(E=1e6), "cannot hand over NeoHookean.* writes sheets of Material"),
    ):
        soft = kg.Model.from_mesh(m.mesh, 0.01, material, "shell")
        with pytest.raises(kg.ModelError, match=message):
            write(soft, path)
    with pytest.raises(kg.ModelError, match="targets must be finite load factors"):
        write(m, path, targets=[0.5, 0.5])
    with pytest.raises(kg.ModelError, match="increments must be a whole number of at least 1"):
        write(m, path, increments=0)
    with pytest.raises(kg.ModelError, match="element must be one of 'S3'"):
        to_abaqus(m, path, element="S4")
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("write", [to_abaqus, to_openseespy])
@pytest.mark.parametrize("rung", kg.stiffness.RUNGS)
def test_the_sheet_is_handed_over_whatever_its_elements(rung: str, write, tmp_path: Path) -> None:
    """Nothing of the rung is in the file: it is the same for all, perturbed and supported alike."""
    texts = []
    for stiffness in ("plate", rung):
        m = kg.Model.from_mesh(equilateral_strip(4, 2), 0.02, MATERIAL, stiffness=stiffness)
        m.perturb(np.linspace(0, 0.1, len(m.mesh.nodes)))
        m.add(kg.Fix(m.select(boundary="left"), clamp=True), kg.Prescribe(m.select(boundary="right"), z=0.1))
        m.add(kg.NodalLoad(m.select(boundary="top"), (0, 0, 1.0)))
        texts.append(write(m, tmp_path / "sheet").read_text())
    assert texts[1] == texts[0]


@pytest.mark.parametrize("write", [to_abaqus, to_openseespy])
@pytest.mark.parametrize("rung", kg.stiffness.RUNGS)
def test_a_model_that_is_not_the_sheet_is_refused(rung: str, write, tmp_path: Path) -> None:
    """A sheet with elements gone, swapped, or added is not what a shell on its mesh would be."""

    def fresh() -> kg.Model:
        m = kg.Model.from_mesh(equilateral_strip(4, 2), 0.02, MATERIAL, stiffness=rung)
        m.add(kg.Fix(m.select(boundary="left")), kg.Prescribe(m.select(boundary="right"), x=0.1))
        return m

    def gone(m: kg.Model) -> None:
        m.remove(*m.elements[:5])

    def swapped(m: kg.Model) -> None:
        m.remove(m.elements[0])
        m.add(kg.Bar(m.nodes[0], m.nodes[2], 1e9))

    def tendon(m: kg.Model) -> None:
        m.add(kg.Bar(m.nodes[0], m.nodes[3], 1e9))

    def contact(m: kg.Model) -> None:
        m.add(kg.Contact(m.nodes[7], kg.Plane((0, 0, -1))))

    def grip(m: kg.Model) -> None:
        node = m.add(kg.Node(9, 9))
        m.add(kg.Fix(node))

    write(fresh(), tmp_path / "whole").unlink()
    for edit in (gone, swapped, tendon, contact, grip):
        m = fresh()
        edit(m)
        with pytest.raises(kg.ModelError, match="cannot hand over"):
            write(m, tmp_path / edit.__name__)
    m = fresh()
    m.remove(m.elements[0])
    m.add(m.sheet_elements[0])  # what comes back is the sheet's own
    write(m, tmp_path / "back").unlink()
    assert not list(tmp_path.iterdir())


PLY = {"E1": 8e9, "E2": 1e9, "nu12": 0.3, "G12": 0.6e9}
LAID = kg.Laminate([
    (kg.Orthotropic(**PLY, angle=0.6, density=900.0), 0.006), (kg.Material(3e9, 0.3), 0.008),
    (kg.Orthotropic(**PLY, angle=-0.2), 0.006),
])  # fmt: skip
CROSS = kg.Laminate([(kg.Orthotropic(**PLY, angle=angle), 0.01) for angle in (0.0, np.pi / 2)])


def laid(material: Any, thickness: float | None, upright: bool = False, **moves: float) -> kg.Model:
    """A strip of a material with directions, clamped at one end and moved at the other."""
    x, y = np.meshgrid(np.linspace(0, 4, 13), np.linspace(0, 1, 4))
    corners = [13 * row + column for row in range(3) for column in range(12)]
    facets = np.array([facet for a in corners for facet in ((a, a + 1, a + 14), (a, a + 14, a + 13))])
    places = np.column_stack([x.ravel(), y.ravel(), 0.0 * x.ravel()])
    mesh = kg.TriMesh(places[:, [0, 2, 1]] if upright else places, facets)
    m = kg.Model.from_mesh(mesh, thickness, material, "shell")
    left, right = m.select(where=lambda x, y, z: x < 1e-9), m.select(where=lambda x, y, z: x > 4 - 1e-9)
    m.add(kg.Fix(left, clamp=True), kg.Prescribe(right, **moves))
    return m


def test_layers_and_directions_are_handed_over_to_abaqus(tmp_path: Path) -> None:
    text = to_abaqus(laid(LAID, None, x=1e-3), tmp_path / "laid.inp").read_text()
    _, _, section = text.partition("*SHELL SECTION, ELSET=SHEET, COMPOSITE\n")
    assert section.splitlines()[:3] == [  # from the lower face
        "0.006, 3, SHEET_0, AXES_SHEET_0", "0.008, 3, SHEET_1", "0.006, 3, SHEET_2, AXES_SHEET_2"
    ]
    for number, angle in ((0, 0.6), (2, -0.2)):
        axes = text.partition(f"*ORIENTATION, NAME=AXES_SHEET_{number}, SYSTEM=RECTANGULAR\n")[2].splitlines()
        first = np.array(axes[0].split(","), dtype=float)[:2]
        assert first == pytest.approx([np.cos(angle), np.sin(angle)]) and axes[1] == "3, 0."
    constants = text.partition("*ELASTIC, TYPE=ENGINEERING CONSTANTS\n")[2].splitlines()[0].split(",")
    assert [float(value) for value in constants][:4] == [8e9, 1e9, 1e9, 0.3]
    paper = to_abaqus(laid(kg.Orthotropic(**PLY, angle=0.5), 0.02, x=1e-3), tmp_path / "paper.inp").read_text()
    assert "*SHELL SECTION, ELSET=SHEET, MATERIAL=SHEET, ORIENTATION=AXES_SHEET\n0.02\n" in paper
    with pytest.raises(kg.ModelError, match="does not face"):
        to_abaqus(laid(CROSS, None, upright=True, x=1e-3), tmp_path / "upright.inp")
    with pytest.raises(kg.ModelError, match="to_abaqus cannot hand over NeoHookean"):
        to_abaqus(laid(kg.NeoHookean(1e6), 0.02, x=1e-3), tmp_path / "rubber.inp")
    with pytest.raises(kg.ModelError, match="to_openseespy cannot hand over Laminate"):
        to_openseespy(laid(CROSS, None, x=1e-3), tmp_path / "laid.py")


# ------------------------------------------------------------------------------------------- runs


def calculix(model: kg.Model, folder: Path, name: str, axis: int) -> float:
    """Reaction of the first driven support at load factor 1."""
    program = shutil.which("ccx")
    if program is None:
        pytest.skip("CalculiX is not installed (Debian: calculix-ccx)")
    to_abaqus(model, folder / "sheet.inp", increments=2, element="S6")
    run = subprocess.run([program, "sheet"], cwd=folder, capture_output=True, text=True, timeout=120, check=False)
    assert "Job finished" in run.stdout, run.stdout[-2000:]
    printed = re.findall(rf"total force .* for set {name} .*\n\n(.*)\n", (folder / "sheet.dat").read_text())
    return float(printed[-1].split()[axis])


def opensees(model: kg.Model, folder: Path, name: str, axis: int) -> float:
    """The same from a run of OpenSeesPy, in a process of its own."""
    if importlib.util.find_spec("openseespy") is None:
        pytest.skip("OpenSeesPy is not installed")
    script = to_openseespy(model, folder / "sheet.py", increments=4)
    run = subprocess.run(
        [sys.executable, script.name, "out.csv"], cwd=folder, capture_output=True, text=True, timeout=120, check=False
    )
    assert run.returncode == 0, run.stderr[-2000:]
    with open(folder / "out.csv") as file:
        return float(list(csv.DictReader(file))[-1][f"{name.lower()}_{'xyz'[axis]}"])


@pytest.mark.external
@pytest.mark.parametrize("code, tolerance", [(calculix, 3e-3), (opensees, 0.04)])
def test_plate_patch_in_tension(code, tolerance: float, tmp_path: Path) -> None:
    """Force E t W strain, to first order in a strain of 1e-3.

    ShellNLDKGT does not pass this patch test: its drilling rotations make it 2.8 per cent soft on this mesh, and with
    all of them held it is right within 0.1 per cent.
    """
    m = pulled()
    ours = float(kg.DisplacementControl(m).run().reaction(m.select(boundary="right"), "x")[-1])
    exact = 2e9 * 0.02 * 4 * np.sqrt(3) / 2 * 1e-3
    assert ours == pytest.approx(exact, rel=1e-2)  # the half facets at the ends are not equilateral
    assert code(m, tmp_path, "DRIVEN_0", 0) == pytest.approx(exact, rel=tolerance)


@pytest.mark.external
@pytest.mark.parametrize("material, thickness", [(kg.Orthotropic(**PLY, angle=0.5), 0.02), (CROSS, None), (LAID, None)])
@pytest.mark.parametrize("up", [1e-3, -1e-3])
def test_layers_bear_in_calculix_what_they_bear_here(
    material: Any, thickness: float | None, up: float, tmp_path: Path
) -> None:
    """Pulled, and lifted or pushed, which tells the lower face from the upper one."""
    m = laid(material, thickness, x=4e-4, z=up)
    ours = kg.DisplacementControl(m, on_instability="follow").run().reaction("driven_0")[-1]
    assert calculix(m, tmp_path, "DRIVEN_0", 0) == pytest.approx(ours[0], rel=0.01)
    assert calculix(m, tmp_path, "DRIVEN_0", 2) == pytest.approx(ours[2], abs=0.01 * np.abs(ours[2]) + 0.06)


@pytest.mark.external
@pytest.mark.parametrize("code", [calculix, opensees])
def test_plate_patch_in_bending(code, tmp_path: Path) -> None:
    """Tip force of a cantilever strip, 3 E I w / L^3, a little more where the clamp keeps the strip from arching."""
    m = bent()
    ours = float(kg.DisplacementControl(m).run().reaction(m.select(boundary="right"), "z")[-1])
    beam = 3 * 2e9 * (4 * np.sqrt(3) / 2 * 0.02**3 / 12) * 0.02 / 20**3
    assert ours == pytest.approx(beam, rel=0.05)
    assert code(m, tmp_path, "DRIVEN_0", 2) == pytest.approx(ours, rel=0.05)


@pytest.mark.external
@pytest.mark.parametrize("code", [calculix, opensees])
def test_disc_with_one_slit(code, tmp_path: Path) -> None:
    """At the onset of buckling, on a coarse mesh, three discretisations of one sheet agree within 10 per cent.

    CalculiX falls by 12 per cent when the mesh is refined from 306 to 555 nodes, to 2 per cent below ours, which stays.
    """
    m = disc()
    ours = float(kg.DisplacementControl(m).run().reaction(m.constraints[0].group, "y")[-1])
    assert code(m, tmp_path, "DRIVEN_0", 1) == pytest.approx(ours, rel=0.10)
