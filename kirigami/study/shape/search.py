"""A search for shapes from its trials to what is known of each shape: see :func:`kirigami.study.shapes`."""

from __future__ import annotations

import re
import time
import warnings
from collections.abc import Sequence
from concurrent.futures import Executor
from dataclasses import replace
from pathlib import Path
from typing import Any

from kirigami.analysis.base import require_drive
from kirigami.analysis.path.checkpoint import fingerprint
from kirigami.errors import AnalysisError, KirigamiError, KirigamiWarning, ModelError
from kirigami.model.from_mesh import on_rung
from kirigami.model.model import Model
from kirigami.primitives.kernel import Array
from kirigami.progress import ProgressBar
from kirigami.results.step import Step
from kirigami.study.shape.known import Kind, KnownShapes
from kirigami.study.shape.links import Branch, Link, follow
from kirigami.study.shape.moves import Moves
from kirigami.study.shape.relaxation import Relaxed, Relaxer
from kirigami.study.shape.study import Shape, ShapeStudy
from kirigami.study.shape.trials import Descents, TrialLog, from_text, running, start_of
from kirigami.words import counted

CHEAP, TRUSTED = "plate", "shell"
OWN = ("", CHEAP, "paper", "calibration")  # searched as they are: no sheets, cheap ones, and other constants
LESSER = ("plate", "facet")  # with the constants of the trusted rung
ROUND = 4  # trials whose starts do not know of each other, however many run at a time
PARENTS = 8  # lowest shapes from which moves start
TOL, TOL_SEARCH = 1e-8, 1e-6  # of what is listed, and of what is looked through
LOOKING, FOLLOWING = 0.5, 0.75  # shares of the budget after which no trial, and no path, is begun


class ShapeSearch:
    """One search.

    Attributes
    ----------
    model : Model
        What the shapes are of.
    searched, trusted : Model
        The same sheet on the rung that is searched, and on the one that is trusted, where these are others.
    notes : list of str
        What was met.
    """

    def __init__(
        self,
        model: Model,
        at: float,
        seed: int,
        budget: float,
        starts: Sequence[Step],
        mirrors: str,
        alike: float,
        confirm: bool,
    ) -> None:
        if model.mesh is not None and model.dim == 2:
            raise ModelError(
                "shapes: the model lies in its plane (dim=2), and the shapes of a sheet are out of it: use dim=3"
            )
        self.model, self.at, self.seed, self.budget, self.starts = model, at, seed, budget, starts
        self.mirrors, self.alike = mirrors, alike
        self.notes: list[str] = []
        self.bar = ProgressBar(False, "")
        self._began, self._elsewhere = time.process_time(), 0.0
        self._own = Relaxer(model, at, TOL)
        if at != 0:
            require_drive(self._own.system, "shapes")
        for step in starts:
            if len(step.u) != len(model.nodes) or abs(step.lam - at) > 1e-9 * max(abs(at), 1.0):
                raise ModelError(
                    f"shapes: a start has {counted(len(step.u), 'node')} at load factor {step.lam:.6g}, but the model "
                    f"has {len(model.nodes)} and is looked at at {at:.6g}"
                )
        rung = "" if model.sheet_constants is None else model.sheet_constants.rung
        self.searched = (_twin(model, CHEAP) if rung not in OWN else None) or model
        self.trusted = _twin(model, TRUSTED) if confirm and rung in LESSER else None
        self._relaxer = self._own if self.searched is model else Relaxer(self.searched, at, TOL_SEARCH)
        self._known = KnownShapes(self._relaxer.system, mirrors, alike)
        self._listed = KnownShapes(self._own.system, mirrors, alike)
        self._steps: dict[int, Relaxed] = {}  # of the listed shapes, by number
        self._carried: dict[int, int] = {}  # from the number of a searched shape to that of the listed one
        self._confirmed: dict[int, tuple[Relaxed, float, int]] = {}
        self._branches: list[Branch] = []
        self._links: list[Link] = []
        self._rows: list[dict[str, Any]] = []

    @property
    def spent(self) -> float:
        """CPU seconds so far."""
        return time.process_time() - self._began + self._elsewhere

    # ---- looking

    def look(self, trials: int, path: Path | None, executor: Executor | None, workers: int | None) -> None:
        """Run the trials, round by round, and sort what comes out."""
        system = self._relaxer.system
        moves = Moves(self.searched, system)
        if self.model.mesh is not None and not moves.lips:
            self.notes.append("the sheet has no cut whose lips could pop: starts are fields, modes and parts of shapes")
        header: dict[str, Any] = {"seed": self.seed, "at": self.at, "mirrors": self.mirrors, "alike": self.alike}
        if path is not None:
            header["model"] = fingerprint(system, self._relaxer.settings)
            header["starts"] = [float(abs(step.u).sum()) for step in self.starts]
        log = TrialLog(path, header)
        for number, step in enumerate(self.starts, start=1):
            told = "given" if len(self.starts) == 1 else f"given, number {number}"
            relaxed = self._try(self._own, step.u)
            if relaxed is not None:
                listed = self._list(relaxed, told)
                there = relaxed if self.searched is self.model else self._try(self._relaxer, step.u)
                if there is not None:
                    kind = self._known.add(there.step.u, there.energy, there.force, told)
                    self._carried.setdefault(kind.number, listed.number)
        descents = Descents(self.searched, self.at, TOL if self.searched is self.model else TOL_SEARCH)
        done = 0
        with running(descents, executor, workers) as run:
            while done < trials:
                parents = self._known.ordered()[:PARENTS]
                shapes, names = [kind.u for kind in parents], [kind.number for kind in parents]
                numbers = range(done, min(done + ROUND, trials))
                # What an earlier call has written down is taken from there; a start costs little beside its descent.
                missing = [number for number in numbers if number >= len(log.rows)]
                if missing and self.spent > LOOKING * self.budget and self._known.kinds:
                    self.notes.append(
                        f"the budget of {self.budget:g} CPU seconds ended the search after {counted(done, 'trial')}"
                    )
                    break
                tried = {row["told"] for row in log.rows[: numbers.stop]}
                starts = []
                for number in missing:
                    starts.append(start_of(number, self.seed, moves, shapes, names, tried))
                    tried.add(starts[-1].told)
                for start, row in zip(starts, run(starts)):
                    if executor is not None or workers not in (None, 1):
                        self._elsewhere += float(row.get("values", {}).get("cpu", 0.0))
                    log.append({"told": start.told, **{key: row.get(key) for key in ("status", "values", "error")}})
                for number in numbers:
                    self._sort(number, log.rows[number])
                done = numbers.stop
                self.bar.move(0.5 * done / trials)
        if not self._known.kinds:
            raise AnalysisError(
                f"shapes: none of {counted(done, 'start')} led to a stable shape, the last one: {self._why()}"
            )

    def _sort(self, number: int, row: dict[str, Any]) -> None:
        """Count the shape of a trial."""
        kept = {"trial": number + 1, "reached_by": row["told"], "status": row["status"]}
        if row["status"] == "done":
            values = row["values"]
            force = float("nan") if values["force"] == "" else values["force"]
            kind = self._known.add(from_text(values["u"]), values["energy"], force, row["told"])
            kept |= {"energy": values["energy"], "force": force, "kind": kind.number}
            kept |= {"factorizations": values["factorizations"], "cpu": values["cpu"]}
        else:
            kept["error"] = row["error"]
        self._rows.append(kept)

    def _why(self) -> str:
        return str(self._rows[-1].get("error")) if self._rows else "there was none"

    # ---- from the rung of the search to that of the model, and to the trusted one

    def follow(self, most: int) -> None:
        """Follow the lowest shapes down and up in the pull; what their snaps lead to joins the shapes."""
        if self.at == 0:
            return
        for kind in self._known.ordered()[:most]:
            if self.spent > FOLLOWING * self.budget:
                self.notes.append("the budget left no time to follow more shapes in the pull")
                return
            try:
                relaxed = self._relaxer.relax(kind.u)
                branch, links = follow(self.searched, relaxed.step, kind.number, TOL_SEARCH, self._recognise)
            except KirigamiError as error:
                self.notes.append(f"a shape could not be followed in the pull: {error}")
                continue
            self._branches.append(branch)
            self._links += links
            self.bar.move(0.5 + 0.2 * len(self._branches) / most)

    def _recognise(self, step: Step) -> int:
        energy, force = self._relaxer.energy_and_force(step)
        return self._known.add(step.u, energy, force, "a snap").number

    def carry(self, most: int) -> None:
        """Relax the shapes on the rung of the model: all where it was searched itself, else the lowest ones."""
        same = self.searched is self.model
        for count, kind in enumerate(self._known.ordered()):
            if not same and count >= most:
                break
            if not same and self._listed.kinds and self.spent > self.budget:
                self.notes.append(f"the budget left no time to carry over more than {counted(count, 'shape')}")
                break
            relaxed = self._try(self._own, kind.u)
            if relaxed is None:
                self.notes.append(f"shape at {kind.energy:.6g} on {self._rung(self.searched)} is lost on the model")
                continue
            self._carried[kind.number] = self._list(relaxed, kind.reached_by).number
            self.bar.move(0.7 + 0.2 * count / most)

    def trust(self, most: int) -> None:
        """Relax the lowest shapes on the trusted rung as well."""
        if self.trusted is None:
            return
        trusted = Relaxer(self.trusted, self.at, TOL)
        sure = KnownShapes(trusted.system, self.mirrors, self.alike)
        first: dict[int, int] = {}
        for count, kind in enumerate(self._listed.ordered()[:most]):
            if count and self.spent > self.budget:
                done = counted(count, "shape")
                self.notes.append(f'the budget left no time to relax more than {done} on "{TRUSTED}"')
                return
            relaxed = self._try(trusted, kind.u)
            if relaxed is None:
                self.notes.append(f'shape {count + 1}: no stable shape was found from it on "{TRUSTED}"')
            else:
                there = sure.add(relaxed.step.u, relaxed.energy, relaxed.force, kind.reached_by)
                same = first.setdefault(there.number, kind.number)
                self._confirmed[kind.number] = relaxed, self._listed.distance(kind.u, relaxed.step.u), same

    def _list(self, relaxed: Relaxed, told: str) -> Kind:
        kind = self._listed.add(relaxed.step.u, relaxed.energy, relaxed.force, told)
        if kind.number not in self._steps or kind.energy < self._steps[kind.number].energy:
            self._steps[kind.number] = relaxed
        return kind

    def _try(self, relaxer: Relaxer, u: Array) -> Relaxed | None:
        try:
            return relaxer.relax(u)
        except KirigamiError:
            return None

    def _rung(self, model: Model) -> str:
        return "" if model.sheet_constants is None else model.sheet_constants.rung

    # ---- what came of it

    def study(self) -> ShapeStudy:
        """The shapes, lowest energy first."""
        if not self._listed.kinds:
            self.carry(1)
        if not self._listed.kinds:
            raise AnalysisError("shapes: none of the shapes found is stable on the rung of the model")
        ordered = self._listed.ordered()
        number_of = {kind.number: place for place, kind in enumerate(ordered, start=1)}
        places = {searched: number_of[listed] for searched, listed in self._carried.items()}
        times, arrangements = ({kind.number: 0 for kind in ordered} for _ in range(2))
        for searched in self._known.kinds:
            if searched.number in self._carried:
                times[self._carried[searched.number]] += searched.times
                arrangements[self._carried[searched.number]] += len(searched.arrangements)
        links = [
            replace(link, shape=places[link.shape], leads_to=places.get(link.leads_to or 0))
            for link in self._links
            if link.shape in places
        ]

        def in_order(told: str) -> str:
            """Words with the numbers that shapes have in the order of energy."""
            return re.sub("#([0-9]+)", lambda found: str(places.get(int(found[1])) or "that is not listed"), told)

        shapes = []
        for kind in ordered:
            relaxed, place = self._steps[kind.number], number_of[kind.number]
            confirmed, off, same = self._confirmed.get(kind.number, (None, float("nan"), 0))
            mine = tuple(link for link in links if link.shape == place)
            shapes.append(
                Shape(
                    place, relaxed.energy, relaxed.force, relaxed.step, in_order(kind.reached_by), times[kind.number],
                    arrangements[kind.number], confirmed, off, number_of.get(same), mine,
                )
            )  # fmt: skip
        branches = [replace(branch, shape=places[branch.shape]) for branch in self._branches if branch.shape in places]
        rows = []
        for row in map(dict, self._rows):
            found = places.get(row.pop("kind", 0))
            rows.append({**row, "reached_by": in_order(row["reached_by"]), "shape": found or ""})
        return ShapeStudy(
            self.model, self.at, shapes, branches, links, rows, self.notes, self.spent,
            self._rung(self.searched), len(self._known.kinds), self.trusted, self._listed, number_of,
        )  # fmt: skip


def _twin(model: Model, stiffness: str) -> Model | None:
    """The model on another rung; None where it holds what that rung cannot take."""
    try:
        twin = on_rung(model, stiffness)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", KirigamiWarning)
            Relaxer(twin, 0.0, TOL)
    except KirigamiError:
        return None
    return twin
