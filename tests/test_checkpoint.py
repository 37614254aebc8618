"""Nothing is lost: a run that is killed, at whatever moment, goes on and finds the same curve to the last bit."""

from __future__ import annotations

import json
import multiprocessing
import os
import signal
import sys
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import kirigami as kg
from kirigami.primitives.parts import ModelObject

Build = Callable[[], kg.DisplacementControl | kg.ArcLength]


def pulled_sheet(thickness: float = 0.3e-3) -> kg.DisplacementControl:
    """A flat sheet of 5 x 5 squares with a slit in the middle, whose path is left where the lips of the slit buckle."""
    slit = [(2, 2), (3, 2)]
    x, y = np.meshgrid(np.arange(6.0), np.arange(6.0))
    points = np.column_stack([x.ravel(), y.ravel()])
    squares = [(6 * row + column) for row in range(5) for column in range(5)]
    triangles = [t for a in squares for t in ((a, a + 1, a + 7), (a, a + 7, a + 6))]
    upper = {6 * 2 + 2: 36, 6 * 2 + 3: 37}  # the nodes of the slit once more, for the facets above it
    points = np.vstack([points, slit])
    centre = np.array([points[list(t)][:, 1].mean() for t in triangles])
    triangles = [tuple(upper.get(n, n) for n in t) if h > 2 else t for t, h in zip(triangles, centre)]
    m = kg.Model.from_mesh(kg.TriMesh(0.04 * points, triangles), thickness, kg.Material(E=3.5e9, nu=0.34))
    bottom, top = m.select(boundary="bottom"), m.select(boundary="top")
    m.add(kg.Fix(bottom), kg.Fix(top, "xz"), kg.Prescribe(top, y=0.01))
    return kg.DisplacementControl(m, targets=[0.3], step=0.02)


def snapping_dome() -> kg.ArcLength:
    """Six bars from a ring of supports to an apex, past both limit points."""
    m = kg.Model()
    turn = np.pi / 3 * np.arange(6)
    apex = m.add(kg.Node(0, 0, 0.5))
    base = m.add(*(kg.Node(np.cos(q), np.sin(q), 0) for q in turn))
    m.add(*(kg.Bar(apex, node, 1.0) for node in base), kg.Fix(base), kg.NodalLoad(apex, (0.001, 0, -0.1)))
    return kg.ArcLength(m, step=0.05, stop=lambda step: step.u[0, 2] < -1.1)


def same_curve(found: kg.Results, whole: kg.Results) -> None:
    """The same numbers, bit by bit, in steps, events and counts."""
    assert np.array_equal(found.lam, whole.lam) and np.array_equal(found.u, whole.u)
    assert np.array_equal(found.residual, whole.residual)
    for one, other in zip(found.steps, whole.steps):
        assert (one.negative, one.iterations, one.stage) == (other.negative, other.iterations, other.stage)
        for mine, theirs in zip(one.history, other.history):
            np.testing.assert_array_equal(mine, theirs)
    assert [str(event) for event in found.events] == [str(event) for event in whole.events]
    for event, other_event in zip(found.events, whole.events):
        np.testing.assert_array_equal(event.u, other_event.u)
        np.testing.assert_array_equal(event.mode, other_event.mode)
    counts = ("iterations", "factorizations", "steps", "cutbacks", "relaxations")
    assert [found.stats[name] for name in counts] == [whole.stats[name] for name in counts]


class Crash(Exception):
    """What a recorder raises in the middle of a run."""


def crash_at(count: int) -> Callable[[kg.Step], None]:
    seen: list[kg.Step] = []

    def record(step: kg.Step) -> None:
        seen.append(step)
        if len(seen) == count:
            raise Crash

    return record


@pytest.mark.parametrize("build", [pulled_sheet, snapping_dome])
@pytest.mark.parametrize("count", [1, 2, 7])
def test_a_crashed_run_goes_on_to_the_same_curve(build: Build, count: int, tmp_path: Path) -> None:
    whole = build().run()
    assert len(whole) > 12 and len(whole.events) >= 1
    file = tmp_path / "run.npz"
    for _ in range(2):  # crashes twice
        with pytest.raises(Crash):
            build().run(checkpoint=file, recorders=[crash_at(count)])
    same_curve(build().run(checkpoint=file), whole)
    assert not list(tmp_path.glob("*.part"))


def _run_to_be_killed(file: str) -> None:
    pulled_sheet().run(checkpoint=file)


@pytest.mark.skipif(sys.platform == "win32", reason="kill -9 is a signal of Unix")
@pytest.mark.parametrize("seed", range(10))
def test_killed_at_a_random_moment(seed: int, tmp_path: Path, uninterrupted: tuple[kg.Results, float]) -> None:
    whole, seconds = uninterrupted
    file = tmp_path / "run.npz"
    child = multiprocessing.get_context("fork").Process(target=_run_to_be_killed, args=(str(file),))
    child.start()
    time.sleep(np.random.default_rng(seed).uniform(0.05, 1.0) * seconds)
    assert child.pid is not None
    os.kill(child.pid, signal.SIGKILL)
    child.join()
    assert child.exitcode in (-signal.SIGKILL, 0)
    same_curve(pulled_sheet().run(checkpoint=file), whole)


@pytest.fixture(scope="module")
def uninterrupted(tmp_path_factory: pytest.TempPathFactory) -> tuple[kg.Results, float]:
    """The whole run, and the seconds it takes with a checkpoint."""
    started = time.perf_counter()
    res = pulled_sheet().run(checkpoint=tmp_path_factory.mktemp("whole") / "run.npz")
    return res, time.perf_counter() - started


def test_a_checkpoint_reads_as_results(tmp_path: Path) -> None:
    file = tmp_path / "run.npz"
    with pytest.raises(Crash):
        pulled_sheet().run(checkpoint=file, recorders=[crash_at(6)])
    found, whole = kg.load(file), pulled_sheet().run()
    assert 1 < len(found) < 6
    assert np.array_equal(found.u, whole.u[: len(found)])
    np.testing.assert_allclose(found.energy["bars"], whole.energy["bars"][: len(found)], rtol=1e-14)


def test_interrupted_by_hand_and_finished(tmp_path: Path) -> None:
    file = tmp_path / "run.npz"

    def stop(step: kg.Step) -> None:
        if step.lam > 0.3:
            raise KeyboardInterrupt

    with pytest.warns(kg.KirigamiWarning, match="interrupted"):
        part = pulled_sheet().run(checkpoint=file, recorders=[stop])
    assert part.events[-1].kind == "interrupted" and part.lam[-1] < 1
    assert len(kg.load(file)) >= len(part) - 1  # whatever the time since the last writing
    same_curve(pulled_sheet().run(checkpoint=file), pulled_sheet().run())


def test_a_finished_run_is_read_back_and_can_be_begun_anew(tmp_path: Path) -> None:
    file = tmp_path / "run.npz"
    whole = snapping_dome().run(checkpoint=file)
    seen: list[kg.Step] = []
    again = snapping_dome().run(checkpoint=file, recorders=[seen.append])
    same_curve(again, whole)
    assert not seen
    anew = snapping_dome().run(checkpoint=file, resume=False, recorders=[seen.append])
    same_curve(anew, whole)
    assert len(seen) == len(whole)


def test_the_end_of_an_arc_length_run_may_move(tmp_path: Path) -> None:
    """`stop` and `max_steps` do not belong to the fingerprint: a run can be made longer."""
    file = tmp_path / "run.npz"
    short = snapping_dome()
    short.max_steps = 5
    assert short.run(checkpoint=file).events[-1].kind == "step limit"
    same_curve(snapping_dome().run(checkpoint=file), snapping_dome().run())


def test_another_model_is_refused_and_the_file_kept(tmp_path: Path) -> None:
    file = tmp_path / "run.npz"
    pulled_sheet().run(checkpoint=file)
    before = file.read_bytes()
    with pytest.raises(kg.AnalysisError, match="another model or analysis"):
        pulled_sheet(thickness=0.31e-3).run(checkpoint=file)
    other = pulled_sheet()
    other.to = 0.9
    with pytest.raises(kg.AnalysisError, match="another model or analysis"):
        other.run(checkpoint=file)
    with pytest.raises(kg.AnalysisError, match="another model or analysis"):
        snapping_dome().run(checkpoint=file)
    assert file.read_bytes() == before


@pytest.mark.parametrize("share", [0.0, 0.3, 0.99])
def test_a_truncated_file_is_refused_and_kept(share: float, tmp_path: Path) -> None:
    file = tmp_path / "run.npz"
    snapping_dome().run(checkpoint=file)
    broken = file.read_bytes()[: int(share * file.stat().st_size)]
    file.write_bytes(broken)
    with pytest.raises(kg.AnalysisError, match=r"run\.npz"):
        snapping_dome().run(checkpoint=file)
    assert file.read_bytes() == broken


def test_flipped_bytes_and_plain_results_are_refused(tmp_path: Path) -> None:
    file = tmp_path / "run.npz"
    snapping_dome().run(checkpoint=file)
    whole = bytearray(file.read_bytes())
    for place in np.random.default_rng(0).integers(0, len(whole), 20):
        whole[place] ^= 0xFF
    file.write_bytes(whole)
    with pytest.raises(kg.AnalysisError, match=r"run\.npz"):
        snapping_dome().run(checkpoint=file)
    snapping_dome().run().save(file)
    with pytest.raises(kg.AnalysisError, match="no checkpoint"):
        snapping_dome().run(checkpoint=file)
    with pytest.raises(kg.ModelError, match="folder"):
        snapping_dome().run(checkpoint=tmp_path)


def test_writing_that_fails_leaves_the_old_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file = tmp_path / "run.npz"
    with pytest.raises(Crash):
        snapping_dome().run(checkpoint=file, recorders=[crash_at(5)])
    before = file.read_bytes()

    def full(*_: object, **__: object) -> None:
        raise OSError("no space left on device")

    whole = snapping_dome().run()
    monkeypatch.setattr(np, "savez", full)
    with pytest.warns(kg.KirigamiWarning, match="no space left") as caught:
        same_curve(snapping_dome().run(checkpoint=file), whole)  # the run itself does not suffer
    assert sum("no space" in str(warning.message) for warning in caught) == 1
    assert file.read_bytes() == before and [path.name for path in tmp_path.iterdir()] == ["run.npz"]


class Ballast(kg.Kernel):
    """A weight that a user hangs on a node, whose size is kept in an object of the user's own."""

    name, pairs = "ballast", ()

    def __init__(self, conn: np.ndarray, size: object) -> None:
        self.conn, self.size = conn, size

    def evaluate(self, x: np.ndarray, lam: float = 1.0, need: int = 2) -> kg.Contribution:
        return kg.Contribution(energy=0.0 * x[:1, 2], gradient=np.zeros((1, 1, 3)))


@dataclass
class Grams:
    value: float


class Opaque:
    pass


@dataclass(eq=False)
class Hung(ModelObject):
    """What lowers to a Ballast."""

    node: kg.Node
    size: object

    @property
    def nodes(self) -> tuple[kg.Node, ...]:
        return (self.node,)

    @classmethod
    def lower(cls, items: list[Any], numbering: Any) -> list[kg.Kernel]:
        return [Ballast(numbering.connectivity(items), items[0].size)]


def weighted_dome(size: object) -> kg.ArcLength:
    analysis = snapping_dome()
    analysis.model.add(Hung(analysis.model.nodes[0], size))
    return analysis


def test_two_objects_of_one_type_do_not_look_alike(tmp_path: Path) -> None:
    """What a kernel holds counts, not the name of its type; what cannot be told apart is refused in words."""
    file = tmp_path / "run.npz"
    with pytest.raises(Crash):
        weighted_dome(Grams(5.0)).run(checkpoint=file, recorders=[crash_at(3)])
    with pytest.raises(kg.AnalysisError, match="another model or analysis"):
        weighted_dome(Grams(6.0)).run(checkpoint=file)
    with pytest.raises(kg.AnalysisError, match="does not know what a Opaque holds"):
        weighted_dome(Opaque()).run(checkpoint=tmp_path / "other.npz")


def test_a_checkpoint_of_an_earlier_version_is_refused_in_words(tmp_path: Path) -> None:
    file = tmp_path / "run.npz"
    snapping_dome().run(checkpoint=file)
    with np.load(file) as data:
        arrays = dict(data)
    walk = json.loads(str(arrays["walk"]))
    del walk["version"]  # as it was written before versions were
    arrays["walk"] = np.array(json.dumps(walk))
    np.savez(file, **arrays)
    with pytest.raises(kg.AnalysisError, match="another version"):
        snapping_dome().run(checkpoint=file)
    assert len(kg.load(file)) > 3


def test_one_analysis_runs_in_several_threads_and_again() -> None:
    """An analysis only describes: what a run needs is its own, so runs side by side give the same bits."""
    for build in (pulled_sheet, snapping_dome):
        analysis = build()
        settings = dict(vars(analysis))
        with ThreadPoolExecutor(3) as pool:
            found = [job.result() for job in [pool.submit(analysis.run) for _ in range(3)]]
        for results in [*found, analysis.run()]:
            same_curve(results, found[0])
        assert {name: value for name, value in vars(analysis).items() if name != "results"} == {
            name: value for name, value in settings.items() if name != "results"
        }
    modes = kg.Eigen(pulled_sheet().model, n=3)
    with ThreadPoolExecutor(3) as pool:
        shapes = [job.result().shapes for job in [pool.submit(modes.run) for _ in range(3)]]
    assert all(np.array_equal(shape, shapes[0]) for shape in shapes)
