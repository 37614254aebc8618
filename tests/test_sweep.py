"""Sweeps: nothing is lost, nothing is computed twice, and every design ends in a row."""

from __future__ import annotations

import csv
import json
import os
import signal
import subprocess
import sys
import time
import warnings
from collections.abc import Iterator
from concurrent.futures import Executor, Future, ProcessPoolExecutor, ThreadPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import kirigami as kg

# ---- functions under study, at the top of the module so that other processes find them


def line(x: float, slope: float = 2.0) -> dict[str, float]:
    return {"y": slope * x}


def fragile(x: int) -> dict[str, Any]:
    if x == 1:
        raise kg.ConvergenceError("no equilibrium\nat all")
    if x == 2:
        raise SystemExit(3)
    return {"y": float("nan")} if x == 3 else {"y": [1]} if x == 4 else {"y": x}  # type: ignore[dict-item]


def drawn(x: int, seed: int) -> float:
    return float(np.random.default_rng(seed).normal()) + x


def noted(x: int, folder: str, pause: float = 0.0) -> float:
    """Leaves a mark for each call, with the process that made it."""
    handle = os.open(Path(folder) / f"call-{x}", os.O_APPEND | os.O_CREAT | os.O_WRONLY)
    os.write(handle, f"{os.getpid()}\n".encode())
    os.close(handle)
    time.sleep(pause)
    return x**2


def gated(x: int, folder: str) -> float:
    """From number 6 on it takes a file "go" to finish, so that an interruption is never too late."""
    value = noted(x, folder)
    end = time.monotonic() + 60
    while x >= 6 and not (Path(folder) / "go").exists() and time.monotonic() < end:
        time.sleep(0.05)
    return value


def deadly(x: int, folder: str) -> float:
    """Number 2 kills its process each time, number 4 only the first time."""
    value = noted(x, folder)
    if x == 2 or (x == 4 and calls(folder)[x] == 1):
        os.kill(os.getpid(), signal.SIGTERM)
        time.sleep(30)
    return value


def calls(folder: str | Path) -> dict[int, int]:
    return {int(path.name[5:]): len(path.read_text().splitlines()) for path in Path(folder).glob("call-*")}


class Inline(Executor):
    """Does the work at once, in this process."""

    _max_workers = 1

    def submit(self, function: Any, /, *args: Any, **options: Any) -> Future[Any]:
        future: Future[Any] = Future()
        future.set_result(function(*args, **options))
        return future


def many(n: int, **constants: Any) -> list[dict[str, Any]]:
    return [{"x": x, **constants} for x in range(n)]


def log_of(path: Path) -> list[dict[str, Any]]:
    return [json.loads(text) for text in path.with_suffix(".jsonl").read_text().splitlines()]


# ---- the table


def test_table_in_memory_and_in_files(tmp_path: Path) -> None:
    table = kg.Sweep(line, [{"x": 0.1}, {"x": 1 / 3}], tmp_path / "a.csv", seed=5).run(Inline())
    assert table.columns == ["design", "x", "seed", "y", "status", "error", "seconds", "version"]
    assert table["y"].tolist() == [0.2, 2 / 3] and table["design"].tolist() == [0, 1]
    assert set(table["version"]) == {kg.__version__} and (table["seconds"] >= 0).all()
    with open(tmp_path / "a.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    assert list(rows[0]) == table.columns
    assert [float(row["y"]) for row in rows] == table["y"].tolist()  # to the last digit
    assert kg.SweepTable.read(tmp_path / "a").rows == table.rows
    parquet = pytest.importorskip("pyarrow.parquet")
    assert parquet.read_table(tmp_path / "a.parquet").to_pylist() == table.rows


def test_failures_are_rows(tmp_path: Path) -> None:
    table = kg.Sweep(fragile, many(6), tmp_path / "f").run(Inline())
    assert [row["status"] for row in table] == ["done", "failed", "failed", "failed", "failed", "done"]
    assert table.done["y"].tolist() == [0, 5]
    errors = table.failed["error"].tolist()
    assert errors[0] == "ConvergenceError: no equilibrium at all" and errors[1] == "SystemExit: 3"
    assert "not a finite number" in errors[2] and "must be a number or a word" in errors[3]
    assert "2 done, 4 failed, 0 missing" in table.summary() and "design 1 failed: Convergence" in table.summary()
    with pytest.raises(kg.ModelError, match="no value in 4 of 6 rows, the first of design 1"):
        table["y"]
    with pytest.raises(kg.ModelError, match="did you mean 'status'"):
        table["statu"]


def test_designs_as_columns_and_as_data_frame(tmp_path: Path) -> None:
    pandas = pytest.importorskip("pandas")
    columns = {"x": np.array([1.0, 2.0]), "slope": [3, 4]}
    one = kg.Sweep(line, columns, tmp_path / "one").run(Inline())
    other = kg.Sweep(line, pandas.DataFrame(columns), tmp_path / "other").run(Inline())
    assert one["y"].tolist() == other["y"].tolist() == [3.0, 8.0]


def test_numbers_among_words(tmp_path: Path) -> None:
    designs = [{"x": 1.0, "kind": "a"}, {"x": 2.0, "kind": 7}]
    table = kg.Sweep(lambda x, kind: {"note": f"{kind}, {x}"}, designs, tmp_path / "words").run(Inline())
    assert table["note"].tolist() == ["a, 1.0", "7, 2.0"] and (tmp_path / "words.csv").exists()


def test_seeds_follow_from_the_number_of_the_design(tmp_path: Path) -> None:
    one = kg.Sweep(drawn, many(6), tmp_path / "one", seed=3).run(Inline())
    with ThreadPoolExecutor(3) as pool:
        other = kg.Sweep(drawn, many(6), tmp_path / "other", seed=3).run(pool)
    assert one["value"].tolist() == other["value"].tolist() and one["seed"].tolist() == other["seed"].tolist()
    assert len(set(one["seed"])) == 6
    third = kg.Sweep(drawn, many(6), tmp_path / "third", seed=4).run(Inline())
    assert not set(one["seed"]) & set(third["seed"])
    given = kg.Sweep(drawn, [{"x": 1, "seed": 11}], tmp_path / "given").run(Inline())
    assert given["seed"].tolist() == [11] and given.columns.count("seed") == 1
    assert given["value"][0] == 1 + np.random.default_rng(11).normal()


# ---- interruption


def test_goes_on_where_it_was(tmp_path: Path) -> None:
    designs = many(5, folder=str(tmp_path))
    sweep = kg.Sweep(noted, designs, tmp_path / "n")
    with pytest.warns(kg.KirigamiWarning, match="time limit: 5 of 5 designs missing"):
        assert len(sweep.run(Inline(), time_limit=-1).missing) == 5
    lines = [*log_of(tmp_path / "n")]
    sweep.run(Inline())
    whole = (tmp_path / "n.jsonl").read_bytes()
    assert whole.startswith(json.dumps(lines[0]).encode())
    # As if killed while the fourth record was being written.
    (tmp_path / "n.jsonl").write_bytes(b"\n".join(whole.split(b"\n")[:4]) + b"\n" + whole.split(b"\n")[4][:17])
    with pytest.warns(kg.KirigamiWarning, match="cut off by an interruption"):
        table = kg.Sweep(noted, designs, tmp_path / "n").run(Inline())
    assert table["value"].tolist() == [0, 1, 4, 9, 16]
    assert calls(tmp_path) == {0: 1, 1: 1, 2: 1, 3: 2, 4: 2}
    sweep.run(Inline())
    assert calls(tmp_path) == {0: 1, 1: 1, 2: 1, 3: 2, 4: 2}


def test_failed_designs_are_tried_again_on_demand(tmp_path: Path) -> None:
    patient = {"now": False}

    def function(x: int) -> float:
        if x == 1 and not patient["now"]:
            raise ValueError("not yet")
        return 10.0 * x

    sweep = kg.Sweep(function, many(3), tmp_path / "p")
    assert len(sweep.run(Inline()).failed) == 1
    patient["now"] = True
    assert len(sweep.run(Inline()).failed) == 1
    assert sweep.run(Inline(), retry_failed=True)["value"].tolist() == [0, 10, 20]
    assert len(log_of(tmp_path / "p")) == 5  # the failure stays in the log


DESIGNS = 12
SCRIPT = """
import sys, kirigami as kg
sys.path.insert(0, {tests!r})
from test_sweep import gated, many
if __name__ == "__main__":
    table = kg.Sweep(gated, many({designs}, folder={folder!r}), {path!r}).run(workers=2)
    print("missing", len(table.missing))
"""


@pytest.mark.skipif(os.name == "nt", reason="signals as on POSIX")
@pytest.mark.parametrize("kind", [signal.SIGINT, signal.SIGKILL])
def test_interrupted_and_killed(tmp_path: Path, kind: signal.Signals) -> None:
    """The script goes down in the middle with its workers; run again, it computes what is missing and no more."""
    path = tmp_path / "k"
    script = tmp_path / "script.py"
    tests = str(Path(__file__).parent)
    script.write_text(SCRIPT.format(designs=DESIGNS, tests=tests, folder=str(tmp_path), path=str(path)))
    process = subprocess.Popen(
        [sys.executable, str(script)],
        stdout=subprocess.PIPE,
        text=True,
        start_new_session=True,
        # A process started in the background ignores the signal, and would hand that on to its children.
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
    )
    wait_until(lambda: path.with_suffix(".jsonl").exists() and len(log_of(path)) >= 3)
    os.kill(process.pid, kind)
    out, _ = process.communicate(timeout=60)
    saved = {record["design"] for record in log_of(path)[1:]}
    assert len(saved) < DESIGNS
    assert process.returncode == (0 if kind == signal.SIGINT else -signal.SIGKILL)
    assert out == (f"missing {DESIGNS - len(saved)}\n" if kind == signal.SIGINT else "")
    workers = {int(pid) for mark in tmp_path.glob("call-*") for pid in mark.read_text().split()}
    wait_until(lambda: not any(is_alive(pid) for pid in workers))
    before = calls(tmp_path)
    (tmp_path / "go").touch()
    table = kg.Sweep(gated, many(DESIGNS, folder=str(tmp_path)), path).run(ThreadPoolExecutor(8))
    assert table["value"].tolist() == [x**2 for x in range(DESIGNS)]
    again = {x for x, count in calls(tmp_path).items() if count > before.get(x, 0)}
    assert again == set(range(DESIGNS)) - saved


def wait_until(true: Any, seconds: float = 60.0) -> None:
    end = time.monotonic() + seconds
    while not true():
        assert time.monotonic() < end, "waited in vain"
        time.sleep(0.05)


def is_alive(pid: int) -> bool:
    try:
        state = Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()[0]
        return state != "Z"
    except OSError:
        pass
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    return not Path("/proc").exists()


# ---- what runs the designs


@pytest.mark.skipif(os.name == "nt", reason="signals as on POSIX")
def test_a_design_that_kills_its_process_costs_only_its_own_row(tmp_path: Path) -> None:
    table = kg.Sweep(deadly, many(6, folder=str(tmp_path)), tmp_path / "d").run(workers=2)
    assert table.failed["design"].tolist() == [2] and "ended without an answer" in table.failed["error"][0]
    assert table.done["value"].tolist() == [0, 1, 9, 16, 25]


def test_a_broken_executor_is_an_error_and_nothing_is_lost(tmp_path: Path) -> None:
    class Breaking(Inline):
        left = 2

        def submit(self, function: Any, /, *args: Any, **options: Any) -> Future[Any]:
            self.left -= 1
            if self.left < 0:
                future: Future[Any] = Future()
                future.set_exception(BrokenProcessPool("a process died"))
                return future
            return super().submit(function, *args, **options)

    sweep = kg.Sweep(noted, many(5, folder=str(tmp_path)), tmp_path / "b")
    with pytest.raises(kg.AnalysisError, match="every finished design is saved"):
        sweep.run(Breaking())
    assert kg.SweepTable.read(tmp_path / "b").done["value"].tolist() == [0, 1]
    assert len(sweep.run(Inline()).done) == 5 and calls(tmp_path) == dict.fromkeys(range(5), 1)


def test_an_executor_that_is_shut_down(tmp_path: Path) -> None:
    pool = ThreadPoolExecutor(1)
    pool.shutdown()
    with pytest.raises(kg.AnalysisError, match="make a new executor"):
        kg.Sweep(line, [{"x": 1.0}], tmp_path / "s").run(pool)


@pytest.fixture(scope="module")
def client() -> Iterator[Any]:
    """A real scheduler with two workers, in processes of their own."""
    distributed = pytest.importorskip("distributed")
    with (
        distributed.LocalCluster(
            n_workers=2, threads_per_worker=1, host="127.0.0.1", dashboard_address=None, worker_dashboard_address=None,
            silence_logs=50,
        ) as cluster,
        distributed.Client(cluster) as connected,
    ):  # fmt: skip
        yield connected


def test_dask_executor(tmp_path: Path, client: Any) -> None:
    table = kg.Sweep(fragile, many(6), tmp_path / "e").run(client.get_executor(pure=False))
    assert table.done["y"].tolist() == [0, 5] and len(table.failed) == 4


def test_dask_client_with_a_worker_killed_on_the_way(tmp_path: Path, client: Any) -> None:
    killed: list[int] = []

    def kill_one() -> None:
        wait_until(lambda: len({pid for mark in tmp_path.glob("call-*") for pid in mark.read_text().split()}) == 2)
        wait_until(lambda: len(calls(tmp_path)) >= 4)
        killed.append(sorted(client.run(os.getpid).values())[0])
        os.kill(killed[0], getattr(signal, "SIGKILL", signal.SIGTERM))

    with ThreadPoolExecutor(1) as side:
        killing = side.submit(kill_one)
        table = kg.Sweep(noted, many(14, folder=str(tmp_path), pause=0.25), tmp_path / "dask").run(client)
        killing.result()
    assert table["value"].tolist() == [x**2 for x in range(14)] and len(killed) == 1
    assert len(log_of(tmp_path / "dask")) == 15
    assert str(killed[0]) in "".join(mark.read_text() for mark in tmp_path.glob("call-*"))


# ---- refusals


@pytest.mark.parametrize(
    ("designs", "words"),
    [
        ([], "there are no designs"),
        ({"x": []}, "there are no designs"),
        ([{"x": 1.0}, {"x": 1.0, "slope": 2.0}], "'slope' is not in both of design 0 and design 1"),
        ([{"z": 1.0}], "cannot be called with the parameters z"),
        ([{"x": 1.0, "status": 2.0}], "cannot be called 'status'"),
        ([{"x": float("inf")}], "'x' of design 0 is inf"),
        ([{"x": None}], "must be a number or a word"),
        ([3.0], "design 0 must be a mapping"),
        ({"x": [1, 2], "slope": [1]}, "differ in length"),
    ],
)
def test_designs_that_make_no_sense(tmp_path: Path, designs: Any, words: str) -> None:
    with pytest.raises(kg.ModelError, match=words):
        kg.Sweep(line, designs, tmp_path / "w")
    assert not list(tmp_path.iterdir())


def test_duplicate_columns(tmp_path: Path) -> None:
    pandas = pytest.importorskip("pandas")
    frame = pandas.DataFrame([[1.0, 2.0]], columns=["x", "x"])
    with pytest.raises(kg.ModelError, match="the same name"):
        kg.Sweep(line, frame, tmp_path / "w")
    with pytest.raises(kg.ModelError, match="returns 'x', already a column"):
        kg.Sweep(lambda x: {"x": x}, [{"x": 1.0}], tmp_path / "w").run(Inline())


def test_wrong_calls(tmp_path: Path) -> None:
    with pytest.raises(kg.ModelError, match="must be a function"):
        kg.Sweep("line", [{"x": 1.0}], tmp_path / "w")  # type: ignore[arg-type]
    with pytest.raises(kg.ModelError, match="seed"):
        kg.Sweep(line, [{"x": 1.0}], tmp_path / "w", seed=-1)
    with pytest.raises(kg.ModelError, match="the name of a file"):
        kg.Sweep(line, [{"x": 1.0}], "")
    sweep = kg.Sweep(line, [{"x": 1.0}], tmp_path / "w")
    with pytest.raises(kg.ModelError, match="workers"):
        sweep.run(workers=0)
    with pytest.raises(kg.ModelError, match="must be a concurrent.futures.Executor or a Dask client"):
        sweep.run("local")
    with pytest.raises(kg.ModelError, match="cannot be sent to other processes"):
        kg.Sweep(lambda x: x, [{"x": 1.0}], tmp_path / "v").run()
    with ProcessPoolExecutor(1) as pool, pytest.raises(kg.ModelError, match="cannot be sent to other processes"):
        kg.Sweep(lambda x: x, [{"x": 1.0}], tmp_path / "u").run(pool)


def test_a_script_without_its_guard_is_told_so(tmp_path: Path) -> None:
    script = tmp_path / "script.py"
    script.write_text(
        "import kirigami as kg\ndef f(x):\n    return x\n"
        f"kg.Sweep(f, [{{'x': 1.0}}], {str(tmp_path / 'g')!r}).run(workers=1)\n"
    )
    done = subprocess.run([sys.executable, str(script)], capture_output=True, text=True, timeout=120)
    assert done.returncode != 0 and "under `if __name__ == '__main__':`" in done.stderr
    assert "bootstrapping phase" not in done.stderr  # multiprocessing's own words for it


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda text: "", "is not the log of a sweep"),
        (lambda text: "x,y\n1,2\n", "is not the log of a sweep"),
        (lambda text: text.replace('"status": "done"', '"status": "odd"', 1), "line 2 is not the record"),
        (lambda text: text.replace('"design": 1', '"design": 9', 1), "line 3 is not the record"),
        (lambda text: "\n\n".join(text.split("\n", 1)), "line 2 is not the record"),
    ],
)
def test_damaged_log(tmp_path: Path, change: Any, words: str) -> None:
    sweep = kg.Sweep(line, [{"x": 1.0}, {"x": 2.0}], tmp_path / "d")
    sweep.run(Inline())
    log = tmp_path / "d.jsonl"
    log.write_text(change(log.read_text()))
    left = log.read_text()
    for action in (lambda: sweep.run(Inline()), lambda: kg.SweepTable.read(tmp_path / "d.csv")):
        with pytest.raises(kg.AnalysisError, match=words):
            action()
    assert log.read_text() == left


def test_the_log_of_another_sweep(tmp_path: Path) -> None:
    path = tmp_path / "o"
    kg.Sweep(line, [{"x": 1.0}, {"x": 2.0}], path).run(Inline())
    before = path.with_suffix(".jsonl").read_bytes()
    for other, words in (
        (kg.Sweep(line, [{"x": 1.0}], path), "a sweep of 2 designs, not of 1"),
        (kg.Sweep(line, [{"x": 1.0}, {"x": 3.0}], path), "design 1 has x = 2.0 there and 3.0 here"),
        (kg.Sweep(line, [{"x": 1.0}, {"x": 2.0}], path, seed=1), "another seed"),
        (kg.Sweep(partial(line, slope=3.0), [{"x": 1.0}, {"x": 2.0}], path), r"belongs to line, not to line\(slope=3"),
    ):
        with pytest.raises(kg.AnalysisError, match=words):
            other.run(Inline())
    assert path.with_suffix(".jsonl").read_bytes() == before


def test_no_log_and_nowhere_to_write(tmp_path: Path) -> None:
    with pytest.raises(kg.AnalysisError, match="cannot read the log"):
        kg.SweepTable.read(tmp_path / "none")
    (tmp_path / "folder.csv").mkdir()
    with pytest.raises(kg.KirigamiError, match="is a folder"):
        kg.Sweep(noted, many(1, folder=str(tmp_path)), tmp_path / "folder").run(Inline())
    assert not calls(tmp_path)  # nothing was computed in vain


@pytest.mark.skipif(os.name == "nt", reason="no locks there")
def test_two_runs_at_once(tmp_path: Path) -> None:
    inner: list[str] = []

    def function(x: int) -> float:
        try:
            kg.Sweep(function, many(2), tmp_path / "t").run(Inline())
        except kg.AnalysisError as error:
            inner.append(str(error))
        return float(x)

    assert len(kg.Sweep(function, many(2), tmp_path / "t").run(Inline()).done) == 2
    assert len(inner) == 2 and "is in use by another process" in inner[0]


# ---- Latin hypercube


def test_progress_is_shown(tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    kg.Sweep(line, [{"x": 1.0}, {"x": 2.0}], tmp_path / "a").run(Inline(), progress=True)
    assert "2/2" in capsys.readouterr().err
    monkeypatch.setitem(sys.modules, "tqdm.auto", None)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        kg.Sweep(line, [{"x": 1.0}, {"x": 2.0}], tmp_path / "b").run(Inline(), progress=True)
    assert capsys.readouterr().err.splitlines() == ["Sweep: 1 of 2 designs", "Sweep: 2 of 2 designs"]
