"""The page in a browser and the surfaces in other programs show the sheet that was computed."""

from __future__ import annotations

import base64
import copy
import json
import re
import shutil
import subprocess
import zlib
from pathlib import Path

import numpy as np
import pytest
import shapely

import kirigami as kg
from kirigami.io.surface import write_surface
from kirigami.io.table import curves
from kirigami.results import smooth
from kirigami.results.fields import energy_density, facet_strain
from kirigami.results.sheet_state import StateReader
from kirigami.results.smooth import sectors, surface_stress
from kirigami.results.stress import sheet_stress

pytest.importorskip("plotly")
from kirigami.io.html import to_html


def contents(page: str) -> tuple[dict, bytes]:
    head, body = (re.search(rf'id="{name}">([^<]*)</script>', page)[1] for name in ("head", "body"))
    return json.loads(head), zlib.decompress(base64.b64decode(body))


def test_stress_of_a_step_is_computed_once(strip: kg.Results, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Whatever shows it: a page, files for ParaView, and pictures; by one reader, which looks at the mesh once."""
    results, computed, readers = copy.copy(strip), [], []
    monkeypatch.setattr(smooth, "sheet_stress", lambda of, step: computed.append(step) or sheet_stress(of, step))
    looked = StateReader.__init__
    monkeypatch.setattr(StateReader, "__init__", lambda self, *of: readers.append(self) or looked(self, *of))
    to_html(results, tmp_path / "strip.html")
    results.to_vtk(tmp_path)
    results.plot(color="stress")
    assert computed == list(range(len(results)))
    assert len(readers) == 1


def test_page_holds_positions_curves_and_colours(strip: kg.Results, tmp_path: Path) -> None:
    """Read back as the page's own script does: byte planes of differences from step to step."""
    page = to_html(strip, tmp_path / "strip.html").read_text(encoding="utf-8")
    head, body = contents(page)
    frames, nodes, facets = len(strip), len(strip.rest), len(strip.mesh.triangles)
    count = 3 * nodes * (frames + 1)
    data = np.frombuffer(body, np.uint8)
    change = data[:count].astype(np.uint16) | data[count : 2 * count].astype(np.uint16) << 8
    levels = np.cumsum(change.reshape(frames + 1, 3, nodes), axis=0, dtype=np.uint16).transpose(0, 2, 1)
    extent = np.array(head["extent"])
    positions = head["low"] + levels / 65535 * extent
    assert np.abs(positions[:-1] - strip.position()).max() <= 0.51 / 65535 * extent.max()
    assert np.abs(positions[-1] - strip.rest).max() <= 0.51 / 65535 * extent.max()
    planes = data[2 * count : 2 * count + 12 * facets].reshape(4, -1).astype(np.int64)
    assert np.array_equal(planes.T @ [1, 256, 65536, 2**24], strip.mesh.triangles.ravel())
    at = 2 * count + 12 * facets + 8 * head["lines"]
    parts = sectors(strip)
    strain = parts.means(facet_strain(strip))
    exact = {"stress": surface_stress(strip), "strain": strain, "energy": energy_density(strip)}
    assert list(head["fields"]) == list(exact)
    for name, field in head["fields"].items():
        shades = np.cumsum(data[at : at + frames * nodes].reshape(frames, nodes), axis=0, dtype=np.uint8)
        values = field["low"] + shades / 255 * (field["high"] - field["low"])
        wanted = np.clip(exact[name], field["low"], field["high"])
        assert np.abs(values - wanted).max() <= 0.51 / 255 * (field["high"] - field["low"])
        at += frames * nodes
    assert at == len(data)
    assert head["curves"]["force on the driven nodes along z"] == curves(strip)["reaction_driven_0_z"].tolist()


def test_page_of_a_stretched_sheet_has_units_and_names(tmp_path: Path) -> None:
    """What is known to be SI is shown in millimetres and megapascals, and curves say what they are and of what."""
    slit = shapely.LineString([(0.01, 0.05), (0.04, 0.05)])
    sheet = kg.Sheet(shapely.box(0, 0, 0.05, 0.1), (slit,), 1e-4, kg.Material(E=2e9, nu=0.3))
    case = kg.LoadCase(strain=0.002, twist=20)
    res = kg.stretch(sheet, case=case, accuracy="draft", max_edge=0.02, stiffness="shell")
    plain, _ = contents(to_html(res, tmp_path / "plain.html").read_text(encoding="utf-8"))
    assert {"strain [%]", "force of the grip", "twist [degrees]", "torque of the grip"} <= set(plain["curves"])
    res.units = "SI"
    head, _ = contents(to_html(res, tmp_path / "si.html").read_text(encoding="utf-8"))
    assert head["unit"] == "mm" and head["extent"] == pytest.approx([1e3 * side for side in plain["extent"]])
    assert (head["main"], head["over"]) == ("force of the grip [N]", "strain [%]")
    for name in ("torque of the grip [N mm]", "height (largest less smallest z) [mm]", "energy of shell [J]"):
        assert name in head["curves"]
    assert not any(name.startswith("reaction") for name in head["curves"])
    assert head["curves"]["strain [%]"] == pytest.approx((0.2 * res.lam).tolist())
    assert head["fields"]["stress"]["title"] == "von Mises stress [MPa]"
    factor = head["fields"]["stress"]["high"] / plain["fields"]["stress"]["high"]
    assert factor == pytest.approx(1e-6) and head["fields"]["energy"]["title"].startswith("energy / area [")
    bands = {"force of the grip [N]": "force", "open area of the cuts [mm²]": "open_area"}
    bands["height (largest less smallest z) [mm]"] = "height"
    assert set(head["bands"]) == set(bands)
    for name, quantity in bands.items():
        curve = np.abs(head["curves"][name])
        share = np.array(head["bands"][name]) / (curve.max() if quantity != "force" else np.maximum(curve, 1e-300))
        assert share[1:] == pytest.approx(res.error[quantity][1:])


def test_page_stands_alone_and_escapes_its_title(strip: kg.Results, tmp_path: Path) -> None:
    page = to_html(strip, tmp_path / "strip.html", title="</script><b>&", frames=2).read_text(encoding="utf-8")
    assert "%%" not in page and "</script><b>" not in page
    assert not re.search(r"(src|href)\s*=|https?://|import\(|fetch\(", page)
    head, _ = contents(page)
    assert head["shown"] == [0, len(strip) - 1] and head["title"] == "</script><b>&"


@pytest.mark.long
def test_page_of_a_large_result_stays_below_ten_megabytes(tmp_path: Path) -> None:
    """10,000 nodes and 50 steps, with noise in all displacements, which hardly packs."""
    side = 100
    x, y = (part.ravel() for part in np.meshgrid(np.linspace(0, 1, side), np.linspace(0, 1, side)))
    corner = (np.arange(side - 1)[:, None] * side + np.arange(side - 1)).ravel()
    facets = np.concatenate([corner[:, None] + [0, 1, side + 1], corner[:, None] + [0, side + 1, side]])
    m = kg.Model.from_mesh(kg.TriMesh(np.column_stack([x, y]), facets), 0.01, kg.Material(E=1e9))
    results = kg.Results(kg.System(m))
    noise = np.random.default_rng(0)
    for lam in np.linspace(0, 1, 50):
        lift = 0.2 * lam * np.sin(9 * x + 3 * lam) * np.sin(7 * y)
        smooth = np.column_stack([-0.05 * lam * x, 0.3 * lam * y, lift])
        results.append(kg.Step.at(m, lam, smooth + 1e-4 * noise.normal(size=(side**2, 3))))
    assert to_html(results, tmp_path / "large.html").stat().st_size < 10e6


def test_bad_arguments_of_the_page(strip: kg.Results, tmp_path: Path) -> None:
    with pytest.raises(kg.ModelError, match="frames must be a whole number of at least 2"):
        to_html(strip, tmp_path / "x.html", frames=1)
    with pytest.raises(kg.AnalysisError, match="no steps"):
        to_html(kg.Results(kg.System(strip.model)), tmp_path / "x.html")
    assert not list(tmp_path.iterdir())


BROWSER = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")


@pytest.mark.external
@pytest.mark.skipif(BROWSER is None, reason="no Chromium (Debian: chromium)")
@pytest.mark.parametrize("case", ["strip", "folded", "truss"])
def test_page_in_a_browser(case: str, tmp_path: Path, request: pytest.FixtureRequest) -> None:
    """The page says what it shows, and the picture holds a coloured sheet; without a network. A node may be picked."""
    results = request.getfixturevalue(case)
    page = to_html(results, tmp_path / "page.html")
    options = ["--headless=new", "--no-sandbox", "--disable-gpu", "--use-angle=swiftshader"]
    options += ["--enable-unsafe-swiftshader"]
    options += ["--window-size=1200,800", "--virtual-time-budget=15000", "--host-resolver-rules=MAP * ~NOTFOUND"]
    address = f"{page.as_uri()}?frame=1&node=1"
    start = {"capture_output": True, "text": True, "timeout": 120}
    run = subprocess.run([BROWSER, *options, "--dump-dom", address], check=True, **start)
    assert 'data-ready="yes"' in run.stdout
    assert f"step 1 of {len(results) - 1}, load factor {results.lam[1]:.5g}" in run.stdout
    assert ">displacement z of the picked node</option>" in run.stdout or results.dim == 2
    for name in ("rest state", "node 1", "bars" if case == "truss" else "rims and cuts"):
        assert f">{name}</text>" in run.stdout  # the legend
    picture = tmp_path / "page.png"
    subprocess.run([BROWSER, *options, f"--screenshot={picture}", address], check=True, **start)
    image = pytest.importorskip("matplotlib.image").imread(picture)[100:600, :640, :3]
    colored = np.ptp(image, axis=2) > 0.15
    assert colored.mean() > (0.002 if case == "truss" else 0.02)


# ------------------------------------------------------------------------------------------- surfaces


SINGLE, DOUBLE = 1e-6, 1e-9  # precision of the format


@pytest.mark.parametrize(
    "ending, near", [(".stl", SINGLE), (".obj", DOUBLE), (".ply", SINGLE), (".glb", SINGLE), (".gltf", SINGLE)]
)
def test_surfaces_are_read_back(ending: str, near: float, strip: kg.Results, tmp_path: Path) -> None:
    trimesh = pytest.importorskip("trimesh")
    path = write_surface(strip, tmp_path / f"strip{ending}")
    read = trimesh.load(path, force="mesh", process=False)
    facets = strip.position()[-1][strip.mesh.triangles]
    assert read.triangles == pytest.approx(facets, abs=near * 4)
    assert list(tmp_path.iterdir()) == [path]


def test_a_surface_with_thickness_is_a_closed_body(strip: kg.Results, tmp_path: Path) -> None:
    """Watertight, faces outwards, and its volume is area times thickness (to first order in thickness over radius)."""
    trimesh = pytest.importorskip("trimesh")
    flat = trimesh.load(write_surface(strip, tmp_path / "flat.ply", step=0, thickness=1e-3), process=False)
    assert flat.is_watertight and flat.is_winding_consistent
    assert flat.volume == pytest.approx(strip.mesh.facet_areas.sum() * 1e-3, rel=1e-4)
    bent = trimesh.load(write_surface(strip, tmp_path / "bent.stl", thickness=1e-3))  # joined where corners coincide
    corners = strip.position()[-1][strip.mesh.triangles]
    area = 0.5 * np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1).sum()
    assert bent.is_watertight and bent.volume == pytest.approx(area * 1e-3, rel=0.02)


def test_surfaces_have_units(strip: kg.Results, tmp_path: Path) -> None:
    """STL of what is known to be metres is in millimetres, as printers take it; other formats as said."""
    trimesh = pytest.importorskip("trimesh")
    size = np.ptp(strip.position()[-1], axis=0)
    known = copy.copy(strip)
    known.units = "SI"
    for results, name, unit, factor in (
        (strip, "any.stl", None, 1.0), (known, "known.stl", None, 1e3), (known, "known.ply", None, 1.0),
        (known, "inch.obj", "in", 1 / 0.0254), (known, "metres.stl", "m", 1.0),
    ):  # fmt: skip
        read = trimesh.load(write_surface(results, tmp_path / name, unit=unit), force="mesh", process=False)
        assert np.ptp(read.vertices, axis=0) == pytest.approx(factor * size, rel=1e-5)
    with pytest.raises(kg.ModelError, match="unit of length"):
        write_surface(known, tmp_path / "x.stl", unit="cubit")
    with pytest.raises(kg.ModelError, match="must be positive"):
        write_surface(known, tmp_path / "x.stl", thickness=0.0)
    assert not (tmp_path / "x.stl").exists()


def test_surfaces_that_cannot_be_written(strip: kg.Results, truss: kg.Results, tmp_path: Path) -> None:
    with pytest.raises(kg.ModelError, match=r"not 'x\.step'"):
        write_surface(strip, tmp_path / "x.step")
    with pytest.raises(kg.AnalysisError, match="from_mesh"):
        write_surface(truss, tmp_path / "x.stl")
    with pytest.raises(kg.AnalysisError, match="no step 99"):
        write_surface(strip, tmp_path / "x.stl", step=99)
    assert not list(tmp_path.iterdir())
