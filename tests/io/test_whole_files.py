"""Every file the package writes is the old one or the new one, whole; what is no plain file is fed, never replaced."""

from __future__ import annotations

import ast
import os
import resource
import signal
import stat
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest
import shapely

import kirigami as kg
from kirigami.files import whole_file
from kirigami.lattice.picture import animate_path
from kirigami.study.imperfections import Case, ImperfectionStudy


@pytest.fixture(scope="module")
def run() -> kg.Results:
    sheet = kg.Sheet(
        shapely.box(0, 0, 1, 0.3), [shapely.LineString([(0.5, 0.1), (0.5, 0.2)])], thickness=0.01,
        material=kg.Material(E=1e9),
    )  # fmt: skip
    m = kg.Model.from_mesh(sheet.mesh(0.1))
    m.add(kg.Fix(m.select(boundary="left")), kg.Fix(m.select(boundary="right"), "yz"))
    m.add(kg.Prescribe(m.select(boundary="right"), x=0.01))
    return kg.LinearStatic(m).run()


def _study(run: kg.Results, path: Path) -> Any:
    return ImperfectionStudy(run.model, [], [Case(1, 1, 0.1)], [None]).table(path)


def _lattice(run: kg.Results, path: Path) -> Any:
    tiling = kg.tilings.rotating_squares(2, 2)
    flat = tiling.vertices * 0
    return animate_path(tiling, [flat, flat], path, frames=2)


WRITERS: dict[str, tuple[str, Callable[[kg.Results, Path], Any]]] = {
    "save": (".npz", lambda run, path: run.save(path)),
    "to_csv": (".csv", lambda run, path: run.to_csv(path)),
    "to_html": (".html", lambda run, path: run.to_html(path)),
    "to_surface": (".stl", lambda run, path: run.to_surface(path)),
    "animate": (".gif", lambda run, path: run.animate(path, frames=2)),
    "to_abaqus": (".inp", lambda run, path: run.model.to_abaqus(path)),
    "to_openseespy": (".py", lambda run, path: run.model.to_openseespy(path)),
    "to_svg": (".svg", lambda run, path: _sheet().to_svg(path)),
    "to_dxf": (".dxf", lambda run, path: _sheet().to_dxf(path)),
    "to_geojson": (".geojson", lambda run, path: _sheet().to_geojson(path)),
    "table of a study": (".csv", _study),
    "film of a lattice": (".gif", _lattice),
}


def _sheet() -> kg.Sheet:
    return kg.Sheet(shapely.box(0, 0, 1, 0.3))


def written(name: str, run: kg.Results, path: Path) -> Path:
    pytest.importorskip("ezdxf") if name == "to_dxf" else None
    pytest.importorskip("plotly") if name == "to_html" else None
    WRITERS[name][1](run, path)
    return path


@pytest.mark.parametrize("name", list(WRITERS))
def test_a_link_goes_on_pointing_to_its_file(name: str, run: kg.Results, tmp_path: Path) -> None:
    ending = WRITERS[name][0]
    expected = written(name, run, tmp_path / f"plain{ending}").stat().st_size
    (tmp_path / "other").mkdir()
    for behind in (tmp_path / "other" / f"behind{ending}", tmp_path / "other" / f"not_there_yet{ending}"):
        if "behind" in behind.name:
            behind.write_text("old")
            behind.chmod(0o640)
        link = tmp_path / f"link_to_{behind.name}"
        link.symlink_to(behind)
        written(name, run, link)
        assert link.is_symlink() and not behind.is_symlink()
        assert behind.stat().st_size == pytest.approx(expected, rel=0.05)
        if "behind" in behind.name:
            assert stat.S_IMODE(behind.stat().st_mode) == 0o640
    left = {p.name for p in (*tmp_path.iterdir(), *(tmp_path / "other").iterdir())}
    assert not any(".part" in p for p in left)


@pytest.mark.parametrize("name", list(WRITERS))
def test_a_pipe_is_fed(name: str, run: kg.Results, tmp_path: Path) -> None:
    pipe = tmp_path / f"pipe{WRITERS[name][0]}"
    expected = written(name, run, tmp_path / f"plain{WRITERS[name][0]}").stat().st_size
    os.mkfifo(pipe)
    with pytest.raises(kg.KirigamiError, match="nobody reads"):
        written(name, run, pipe)
    reader = os.open(pipe, os.O_RDONLY | os.O_NONBLOCK)
    os.set_blocking(reader, True)
    got: list[bytes] = []

    def read() -> None:
        with open(reader, "rb") as file:
            got.append(file.read())

    # The reader has to wait for the writer, as a program at the other end would.
    keep = os.open(pipe, os.O_WRONLY)
    thread = threading.Thread(target=read)
    thread.start()
    written(name, run, pipe)
    os.close(keep)
    thread.join(timeout=60)
    assert stat.S_ISFIFO(os.stat(pipe).st_mode)
    assert len(got[0]) == pytest.approx(expected, rel=0.05)


def test_devices_stay_devices(run: kg.Results) -> None:
    run.to_csv("/dev/null")
    assert stat.S_ISCHR(os.stat("/dev/null").st_mode)


def test_further_names_of_a_file_are_kept(run: kg.Results, tmp_path: Path) -> None:
    file, other = tmp_path / "curves.csv", tmp_path / "other_name.csv"
    file.write_text("old")
    os.link(file, other)
    run.to_csv(file)
    assert other.read_text().startswith("step,") and file.stat().st_ino == other.stat().st_ino


@pytest.mark.parametrize("name", list(WRITERS))
def test_what_cannot_be_written_is_told(name: str, run: kg.Results, tmp_path: Path) -> None:
    ending = WRITERS[name][0]
    (tmp_path / "file").write_text("old")
    (tmp_path / f"folder{ending}").mkdir()
    for place in (tmp_path / f"folder{ending}", tmp_path / "file" / f"below{ending}", Path("/proc") / f"x{ending}"):
        with pytest.raises(kg.KirigamiError):
            written(name, run, place)
    assert (tmp_path / "file").read_text() == "old"


@pytest.mark.parametrize("name", ["save", "to_csv", "to_html", "to_surface", "to_abaqus"])
@pytest.mark.parametrize("path", ["", ".", "a\0b", 5, None, ["a"]], ids=repr)
def test_names_that_are_none(name: str, path: Any, run: kg.Results) -> None:
    with pytest.raises(kg.KirigamiError):
        written(name, run, path)


@contextmanager
def small_disk() -> Iterator[None]:
    """Files of at most 100 bytes, as on a disk that is full; also for pytest's own, so not for longer than a call."""
    handler = signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (100, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
        signal.signal(signal.SIGXFSZ, handler)


@pytest.mark.parametrize("name", list(WRITERS))
def test_a_full_disk_loses_nothing(name: str, run: kg.Results, tmp_path: Path) -> None:
    path = tmp_path / f"kept{WRITERS[name][0]}"
    path.write_text("old")
    with pytest.raises(kg.KirigamiError, match="cannot write"), small_disk():
        written(name, run, path)
    assert path.read_text() == "old"
    assert [entry.name for entry in tmp_path.iterdir()] == [path.name]


def test_two_threads_may_write_one_file(tmp_path: Path) -> None:
    path = tmp_path / "both.txt"

    def write(letter: str) -> None:
        for _ in range(50):
            with whole_file(path) as unfinished:
                unfinished.write_text(letter * 10_000)

    threads = [threading.Thread(target=write, args=(letter,)) for letter in "ab"]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    text = path.read_text()
    assert len(text) == 10_000 and len(set(text)) == 1
    assert [entry.name for entry in tmp_path.iterdir()] == ["both.txt"]


def test_results_read_from_something_else(tmp_path: Path) -> None:
    text = tmp_path / "notes.npz"
    text.write_text("shopping list\n")
    os.mkfifo(tmp_path / "pipe.npz")
    cases = (
        (text, "not a results file"), (tmp_path, "cannot read"), (tmp_path / "no.npz", "no results file"),
        (tmp_path / "pipe.npz", "no plain file"),
    )  # fmt: skip
    for path, words in cases:
        with pytest.raises(kg.AnalysisError, match=words) as told:
            kg.load(path)
        assert "allow_pickle" not in str(told.value)


def test_every_writer_goes_through_whole_file() -> None:
    """No file is opened for writing but the unfinished one that ``whole_file`` hands out."""
    root = Path(kg.__file__).parent
    found = []
    for file in root.rglob("*.py"):
        if file.name == "files.py":
            continue
        for node in ast.walk(ast.parse(file.read_text())):
            if not isinstance(node, ast.Call):
                continue
            called = node.func.attr if isinstance(node.func, ast.Attribute) else getattr(node.func, "id", "")
            text = ast.unparse(node)
            if called in ("replace", "rename") and text.startswith("os."):
                writes = "unfinished" not in text
            elif called in ("write_text", "write_bytes", "savefig"):
                writes = "unfinished" not in text
            elif called == "open":
                mode = next((a.value for a in node.args[1:2] if isinstance(a, ast.Constant)), "r")
                writes = str(mode)[0] in "wax" and "unfinished" not in text
            else:
                continue
            if writes:
                found.append(f"{file.relative_to(root)}:{node.lineno}: {text}")
    assert not found, found


def _square(x: float) -> dict[str, float]:
    return {"y": x * x}


def test_what_is_read_back_must_be_a_plain_file(tmp_path: Path, run: kg.Results) -> None:
    """A pipe would be waited on for ever."""
    os.mkfifo(tmp_path / "log.jsonl")
    with pytest.raises(kg.KirigamiError, match="no plain file"):
        kg.Sweep(_square, [{"x": 1}, {"x": 2}], tmp_path / "log.csv").run()
    os.mkfifo(tmp_path / "checkpoint.npz")
    with pytest.raises(kg.KirigamiError, match="no plain file"):
        kg.DisplacementControl(run.model).run(checkpoint=tmp_path / "checkpoint.npz")
