"""Searches from several designs: one after the other, or side by side in processes of their own."""

from __future__ import annotations

import json
import tempfile
import warnings
from concurrent.futures import FIRST_COMPLETED, wait
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from kirigami.design.answer import InverseResult
from kirigami.design.design import Design
from kirigami.design.search import Search
from kirigami.errors import AnalysisError, GeometryError, KirigamiWarning
from kirigami.sweep.workers import runner_for

if TYPE_CHECKING:
    from kirigami.design.inverse import Inverse

LOOK = 1.0  # longest time without a look at Ctrl-C [s]


def spread(design: Design, count: int, seed: int) -> list[Design]:
    """Designs to start from beside the one given, spread over the ranges; those that do not exist are left out."""
    from scipy.stats import qmc

    if not count:
        return []
    ends = np.array([design.bounds[name] for name in design.free])
    found = []
    for share in qmc.LatinHypercube(len(ends), seed=seed).random(count):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", KirigamiWarning)
            try:
                found.append(design.at(ends[:, 0] + share * (ends[:, 1] - ends[:, 0])))
            except GeometryError:
                continue
    return found


def better(one: InverseResult, other: InverseResult) -> bool:
    """Whether an answer beats another."""
    return (one.verified, -one.worth) > (other.verified, -other.worth)


def one_by_one(problem: Inverse, designs: list[Design], progress: Any) -> InverseResult:
    """The best answer of searches from designs, of which the first must be walkable."""
    search = Search(problem, designs[0], problem.path, progress)
    scales, best = search.scales, search.run()
    for number, design in enumerate(designs[1:], start=1):
        if best.status == "interrupted":
            break
        path = None if problem.path is None else problem.path.with_stem(f"{problem.path.stem}_{number}")
        try:
            found = Search(problem, design, path, progress, scales).run()
        except AnalysisError:
            continue
        if better(found, best):
            best = found
    return best


def side_by_side(problem: Inverse, designs: list[Design], workers: int, progress: Any) -> InverseResult:
    """The same in processes, each of which keeps what it tries in a file; the best of them is taken up here."""
    with tempfile.TemporaryDirectory() as folder:
        whole = Path(folder) / "search.json" if problem.path is None else problem.path
        paths = [whole, *(whole.with_stem(f"{whole.stem}_{number}") for number in range(1, len(designs)))]
        tell = progress if callable(progress) else _say if progress else _nothing
        found: dict[int, dict[str, Any]] = {}
        try:
            with runner_for(None, partial(search_from, problem), workers, len(designs)) as runner:
                scales = common_scales(problem, designs, paths)
                out = {
                    runner.submit(
                        runner.function,  # type: ignore[attr-defined]
                        {"values": design.vector.tolist(), "path": str(path), "scales": scales},
                    ): number
                    for number, (design, path) in enumerate(zip(designs, paths))
                }
                while out:
                    for future in wait(out, LOOK, FIRST_COMPLETED).done:
                        number = out.pop(future)
                        row = runner.outcome(future)
                        if row is not None and row["status"] == "done":
                            found[number] = row["values"]
                            tell(number, dict(zip(problem.design.free, json.loads(row["values"]["x"]))),
                                 row["values"]["error"])  # fmt: skip
        except KeyboardInterrupt:
            pass  # every search has kept what it tried
        if not found and not any(path.exists() for path in paths):
            raise AnalysisError("Inverse: none of the designs to start from can be walked")
        rank = sorted(found, key=lambda number: (not found[number]["verified"], found[number]["worth"]))
        for number in rank or [k for k, path in enumerate(paths) if path.exists()]:
            try:
                return Search(problem, designs[number], paths[number], False).run()
            except AnalysisError:
                continue
        raise AnalysisError("Inverse: none of the designs to start from can be walked")


def common_scales(problem: Inverse, designs: list[Design], paths: list[Path]) -> list[float]:
    """By what the errors of each target are divided, so that answers from all starts may be compared."""
    if not any(np.isnan(target.scale) for target in problem.targets):
        return [target.scale for target in problem.targets]
    for design, path in zip(designs, paths):
        try:
            return Search(problem, design, path, False).scales
        except AnalysisError:
            continue
    raise AnalysisError("Inverse: none of the designs to start from can be walked")


def search_from(problem: Inverse, values: list[float], path: str, scales: list[float]) -> dict[str, Any]:
    """One search, in a worker."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", KirigamiWarning)
        found = Search(problem, problem.design.at(values), Path(path), False, scales).run()
    return {
        "x": json.dumps(list(found.values.values())), "verified": found.verified, "worth": found.worth,
        "error": found.error,
    }  # fmt: skip


def _say(number: int, values: dict[str, float], error: float) -> None:
    print(f"start {number}: error {error:.3e}, {', '.join(f'{name}={value:.6g}' for name, value in values.items())}")


def _nothing(number: int, values: dict[str, float], error: float) -> None:
    """In the place of telling."""
