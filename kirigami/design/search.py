"""One search for the parameters of a design: trials, what is kept of them, corrections by a finer mesh, the answer."""

from __future__ import annotations

import json
import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from kirigami.design.answer import InverseResult
from kirigami.design.asked import carries_over, combined
from kirigami.design.branch import Branch, rates
from kirigami.design.design import Design
from kirigami.design.methods import GoodEnoughError, OutOfEvaluationsError, optimise
from kirigami.design.targets import critical_events, load_factors
from kirigami.errors import AnalysisError, KirigamiError, KirigamiWarning, ModelError
from kirigami.files import make_folder, whole_file
from kirigami.primitives.kernel import Array
from kirigami.results.gradients.equilibrium import weighted
from kirigami.results.gradients.fields import of_sheet

if TYPE_CHECKING:
    from kirigami.design.inverse import Inverse

WORST = 10.0  # smallest angle [deg] of a moved mesh that is still used


@dataclass
class Trial:
    """One design tried: its parameters, errors by target, values of the bounds, and derivatives of both."""

    x: Array
    told: Array
    errors: Array
    slopes: Array
    bounds: Array
    bound_slopes: Array
    worth: float


class Search:
    """One run of an inverse problem."""

    def __init__(
        self, problem: Inverse, design: Design, path: Path | None, progress: Any, scales: Sequence[float] | None = None
    ) -> None:
        """`scales`: by what errors of each target are divided, where another search has found that already."""
        self.problem, self.design, self.path, self.progress = problem, design, path, progress
        self.scales = [target.scale for target in problem.targets] if scales is None else list(scales)
        self.history: list[dict[str, Any]] = []
        self.begun = 0  # designs tried before this round
        self.best: Trial | None = None
        self.shift = [np.zeros(len(target.lam)) for target in problem.targets]
        self.lams = load_factors(problem.targets, problem.constraints)
        self.carries = all(carries_over(target.functional) for target in problem.targets)
        self._resume()
        self.critical = critical_events(problem.targets, problem.constraints)
        self.branch = Branch(self.design, self.lams, self.critical)
        for number, target in enumerate(problem.targets):
            if np.isnan(self.scales[number]):  # a wish is measured by what the start does
                told = self.branch.asked([(target.functional, float(target.lam[0]))], slopes=False)[0].value
                self.scales[number] = abs(told) or 1.0

    # ---- one design

    def trial(self, x: Array) -> Trial | None:
        """A design by its parameters; None where it does not exist or cannot be walked."""
        if self.best is not None and np.array_equal(x, self.best.x) and self.best.told.size:
            return self.best
        if self.best is not None and self._enough(self.best):
            raise GoodEnoughError
        if len(self.history) - self.begun >= self.problem.evaluations:
            raise OutOfEvaluationsError
        poor = False
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", KirigamiWarning)
                design = self.design.at(self._inside(x))
                poor = design.mesh.min_angle < WORST
                if poor:
                    design = self._mesh_anew(design)
                self.branch.go_to(design)
            failed = ""
        except KirigamiError as error:
            failed = str(error)
        if poor:
            warnings.warn("Inverse: the mesh got poor and was made anew", KirigamiWarning, stacklevel=2)
        if not failed:
            try:
                found = self._evaluated(x)
            except (AnalysisError, ModelError) as error:
                if isinstance(error, ModelError) and self.best is None:
                    raise  # asked for wrongly, which is no matter of the design
                failed = str(error)
        if failed:
            self._note(x, float("nan"), float("nan"), failed)
            return None
        if self.best is None or found.worth < self.best.worth:
            self.best = found
            self._draw(found)
        self._note(x, float(np.abs(found.errors).max(initial=0.0)), found.worth)
        return found

    def _enough(self, trial: Trial) -> bool:
        """Whether nothing better need be looked for."""
        met = float(np.abs(trial.errors).max(initial=0.0)) <= self.problem.enough
        return met and not any(target.wish for target in self.problem.targets) and self._within(trial)

    def _within(self, trial: Trial) -> bool:
        """Whether a design keeps its constraints."""
        return all(
            bound.low - 1e-6 * abs(value) <= value <= bound.high + 1e-6 * abs(value)
            for bound, value in zip(self.problem.constraints, trial.bounds)
        )

    def _inside(self, x: Array) -> Array:
        ends = np.array([self.design.bounds[name] for name in self.design.free])
        return np.clip(x, ends[:, 0], ends[:, 1])

    def _mesh_anew(self, design: Design) -> Design:
        design = design.remeshed()
        branch = Branch(design, self.lams, self.critical)
        branch.walks += self.branch.walks
        branch.factorizations += self.branch.factorizations
        self.design, self.branch = design, branch
        return design

    def _evaluated(self, x: Array) -> Trial:
        problem, branch = self.problem, self.branch
        asked = self._asked
        count = len(asked)
        asked += [(bound.what, bound.lam) for bound in problem.constraints if not bound.drawn]
        pieces = branch.asked(asked)
        told = [piece.value for piece in pieces[:count]]
        errors, scales, row = [], [], 0
        for target, shift, size in zip(problem.targets, self.shift, self.scales):
            scale = (target.wish or 1.0) / size
            for wanted, moved in zip(target.values, shift):
                scales.append(scale)
                errors.append(np.nan if target.wish else (told[row] - wanted + moved) * scale)
                row += 1
        slopes = combined(pieces, rates(branch.design, [part for piece in pieces for _, part in piece.parts]))
        bounds, bound_slopes, row = [], [], count
        for bound in problem.constraints:
            if bound.drawn:
                bounds.append(bound.of(branch.design))
                bound_slopes.append(bound.rates_of(branch.design))
            else:
                bounds.append(pieces[row].value)
                bound_slopes.append(slopes[row])
                row += 1
        values, by_size = np.array(errors), np.array(scales)
        wishes = np.isnan(values)
        wished = float((np.array(told)[wishes] * by_size[wishes]).sum())
        outside = sum(
            max(bound.low - value, value - bound.high, 0.0) / (abs(value) or 1.0)
            for bound, value in zip(problem.constraints, bounds)
        )
        worth = 0.5 * float((values[~wishes] ** 2).sum()) + wished + 1e3 * outside
        return Trial(
            x.copy(), np.array(told), np.where(wishes, 0.0, values), slopes[:count] * by_size[:, None],
            np.array(bounds), np.array(bound_slopes).reshape(len(bounds), len(x)), worth,
        )  # fmt: skip

    def wishes(self, trial: Trial) -> tuple[float, Array]:
        """What is to be small, and its derivatives: half the squared errors, and what is wished for."""
        scales, pull = self._pull(trial)
        wished = float((trial.told * scales)[self._wished].sum())
        return 0.5 * float((trial.errors**2).sum()) + wished, pull @ trial.slopes

    @property
    def _wished(self) -> NDArray[np.bool_]:
        """Which values are wished to be large or small."""
        return np.concatenate([np.full(len(target.lam), target.wish != 0) for target in self.problem.targets])

    def _pull(self, trial: Trial) -> tuple[Array, Array]:
        """What makes errors or wishes of the values asked for, and the derivatives of what is to be small by these."""
        scales = [
            np.full(len(target.lam), (target.wish or 1.0) / size)
            for target, size in zip(self.problem.targets, self.scales)
        ]
        return np.concatenate(scales), np.where(self._wished, 1.0, trial.errors)

    @property
    def _asked(self) -> list[tuple[Any, float]]:
        """The functional and load factor of each value that is wanted."""
        return [(target.functional, lam) for target in self.problem.targets for lam in target.lam.tolist()]

    def _thicker(self, design: Design, trial: Trial) -> Array | None:
        """Derivatives (facets,) of what is to be small by the thickness of each facet, over its area."""
        total = np.zeros(len(design.mesh.triangles))
        try:
            self.branch.go_to(design)
            parts = [
                (weight * share, adjoint)
                for weight, piece in zip(np.prod(self._pull(trial), axis=0).tolist(), self.branch.asked(self._asked))
                for share, adjoint in piece.parts
            ]
            for at in {id(adjoint.at): adjoint.at for _, adjoint in parts}.values():
                weights, adjoints = zip(*(part for part in parts if part[1].at is at))
                total += weighted(weights, of_sheet(adjoints, "thickness", "Inverse"))
        except KirigamiError:
            return None
        return total / design.mesh.facet_areas

    # ---- what is kept

    def _note(self, x: Array, error: float, worth: float, why: str = "") -> None:
        values = dict(zip(self.design.free, map(float, x)))
        self.history.append({"values": values, "error": error, "worth": worth, "why": why})
        if self.path is not None:
            text = json.dumps({"names": list(values), "scales": self.scales, "history": self.history})
            with whole_file(self.path) as unfinished:
                unfinished.write_text(text)
        if callable(self.progress):
            self.progress(len(self.history), values, error)
        elif self.progress:
            told = ", ".join(f"{name}={value:.6g}" for name, value in values.items())
            print(f"{len(self.history):4d}  error {error:.3e}  {told}" + (f"  ({why})" if why else ""))

    def _draw(self, trial: Trial) -> None:
        """Leave a picture of the best design so far."""
        if self.problem.pictures is None or not self.branch.at:
            return
        from kirigami.design.picture import plot_trial

        folder = self.problem.pictures
        make_folder(folder)
        design = self.branch.design
        with whole_file(folder / f"design_{len(self.history) + 1:04d}.png") as unfinished:
            plot_trial(design, self.branch.at[-1], trial.errors, self.names).savefig(unfinished, dpi=100)

    @property
    def names(self) -> list[str]:
        """What each error is of."""
        return [
            f"{target.name} at {lam:g}".replace("_", " ")
            for target in self.problem.targets for lam in target.lam.tolist()
        ]  # fmt: skip

    def _resume(self) -> None:
        path = self.path
        if path is None or not Path(path).exists():
            return
        try:
            stored = json.loads(Path(path).read_text())
            history, names = stored["history"], stored["names"]
        except (ValueError, KeyError, TypeError):
            raise AnalysisError(f"Inverse: {path} is no file of an earlier search: give another path") from None
        if names != self.design.free:
            raise AnalysisError(f"Inverse: {path} is of a design with other parameters: {', '.join(names)}")
        known = [entry for entry in history if entry["error"] == entry["error"]]
        if known:
            best = min(known, key=lambda entry: float(entry.get("worth", entry["error"])))  # older files have no worth
            self.design = self.design.at(best["values"])
        self.history, self.scales = history, stored.get("scales", self.scales)

    # ---- the search

    def run(self) -> InverseResult:
        problem, self.begun = self.problem, len(self.history)
        status, first = "closest", self.trial(self.design.vector)
        if first is None:
            raise AnalysisError(f"Inverse: the design it starts from fails: {self.history[-1]['why']}")
        start, before = self.design, first
        fine: list[Array] = []
        error = float("nan")
        corrected = 0
        try:
            while True:
                self.begun = len(self.history)
                try:
                    status = optimise(problem.method, self)
                except OutOfEvaluationsError:
                    status = "out of evaluations"
                assert self.best is not None
                if problem.corrections is None or not self.carries:
                    break
                fine, error = self._on_finer_mesh()
                if not fine or error <= problem.tolerance / 3 or corrected >= problem.corrections:
                    break
                corrected += 1
                self._correct(fine)
                fine, error = [], float("nan")  # they were those of the design that is searched on from
        except KeyboardInterrupt:
            status = "interrupted"
        return self._answer(status, start, before, fine, error)

    def _on_finer_mesh(self) -> tuple[list[Array], float]:
        assert self.best is not None
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", KirigamiWarning)
            design = self.design.at(self._inside(self.best.x)).finer(self.problem.finer)
            try:
                branch = Branch(design, self.lams, self.critical)
            except KirigamiError:
                return [], float("inf")
        self.branch.walks += branch.walks
        self.branch.factorizations += branch.factorizations
        found, worst = [], 0.0
        for target, size in zip(self.problem.targets, self.scales):
            asked = [(target.functional, lam) for lam in target.lam.tolist()]
            told = np.array([piece.value for piece in branch.asked(asked, slopes=False)])
            found.append(told)
            if not target.wish:
                worst = max(worst, float(np.abs(told - target.values).max() / size))
        return found, worst

    def _correct(self, fine: list[Array]) -> None:
        """Ask of the coarse mesh what the finer one lacks."""
        assert self.best is not None
        split = np.cumsum([len(target.lam) for target in self.problem.targets])[:-1]
        self.shift = [
            there - here for there, here in zip(fine, np.split(self.best.told, split))
        ]
        before, self.best, self.begun = self.best, None, len(self.history)
        try:
            self.trial(before.x)
        finally:  # errors are counted anew, but an answer there must be
            self.best = self.best or before

    def _answer(
        self, status: str, start: Design, first: Trial, fine: list[Array], error: float
    ) -> InverseResult:
        problem, best = self.problem, self.best
        assert best is not None
        split = np.cumsum([len(target.lam) for target in problem.targets])[:-1]
        coarse = np.split(best.told, split)
        met = float(np.abs(best.errors).max(initial=0.0))
        inside = self._within(best)
        own = max(
            (float(np.abs(told - target.values).max() / size)
             for told, target, size in zip(coarse, problem.targets, self.scales) if not target.wish),
            default=0.0,
        )  # fmt: skip
        if status == "closest" and met <= max(1e-3, problem.enough) and inside:
            status = "met"
        messages = {
            "met": "the targets are met on the mesh of the design",
            "closest": f"the targets are out of reach: the nearest design misses them by {100 * met:.3g} %",
            "out of evaluations": f"the evaluations ran out at an error of {100 * met:.3g} %: allow more",
            "interrupted": f"interrupted; the best design so far misses its targets by {100 * met:.3g} %",
        }
        wished = all(target.wish for target in problem.targets)
        if wished and status == "closest":
            messages["closest"] = "nothing better was found"
        if any(shift.any() for shift in self.shift):
            messages[status] += "; that is of the targets as corrected by the finer mesh"
        if problem.corrections is not None and not self.carries:
            messages[status] += (
                "; not walked on a finer mesh, which numbers its nodes anew: give nodes by names of boundaries or "
                "supports"
            )
        if not inside:
            messages[status] += "; its constraints are not met"
        _, slope = self.wishes(best)
        design = self.design.at(self._inside(best.x))
        return InverseResult(
            design=design, start=start, thicker=None if status == "interrupted" else self._thicker(design, best),
            values=dict(zip(self.design.free, map(float, best.x))),
            error=error if fine else own, coarse_error=own,
            verified=bool(fine) and error <= problem.tolerance and inside,
            worth=best.worth, status=status, message=messages[status], lam=[target.lam for target in problem.targets],
            wanted=[target.values for target in problem.targets], reached=fine, coarse=coarse,
            before=np.split(first.told, split), names=[target.name for target in problem.targets], history=self.history,
            evaluations=len(self.history), walks=self.branch.walks, factorizations=self.branch.factorizations,
            sensitivities=dict(zip(self.design.free, map(float, slope))),
        )  # fmt: skip
