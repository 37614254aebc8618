"""Inverse problems: the parameters of a design that make its sheet do what is wanted."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from kirigami.design.answer import InverseResult
from kirigami.design.design import Design
from kirigami.design.methods import METHODS, chosen_method
from kirigami.design.starts import one_by_one, side_by_side, spread
from kirigami.design.targets import Bound, Target, bounds_of, targets_of
from kirigami.errors import ModelError
from kirigami.primitives.checks import (
    require_boolean,
    require_choice,
    require_instance,
    require_not_negative,
    require_path,
    require_positive,
    require_whole,
)

VERIFIED = 0.03  # error on the finer mesh up to which an answer counts as verified


class Inverse:
    """Find the parameters of a design that make its sheet do what is wanted.

    Each design goes on from the equilibria of the last one; where its branch ends, or the shape leaps, it is walked
    from flat once more. Derivatives are those of the adjoint method. The answer is walked from flat on a finer mesh,
    and the targets are corrected by the difference until it is met there. Many designs may do nearly the same: targets
    that are met within 1 % say little of how near the parameters are to those of another sheet that meets them.

    Parameters
    ----------
    design : Design
        Where to start.
    targets : tuple or sequence of tuples
        ``(functional, load factors, values)``, with functionals as of :meth:`Results.gradient`; of values "max" or
        "min" ask for as much or as little as can be. A fourth entry is the size by which its errors are divided,
        instead of the largest value. Values are met in the least-squares sense.
    constraints : sequence of tuples
        ``("ligament", low, high)``: least distance of cuts; ``("cut_area", low, high)``: area of all openings as drawn;
        ``(function of the design, low, high)``; ``(functional, load factor, low, high)``. None is no bound.
    method : {"auto", "least squares", "slsqp", "mma"}
        "auto" takes least squares, and with constraints or wishes "mma" where NLopt is installed (the extra `design`),
        else "slsqp".
    evaluations : int
        Most designs to try, in each round of correction.
    enough : float
        Error on the design's own mesh at which the search ends, if the constraints hold and nothing is wished for.
    tolerance : float
        Error on the finer mesh up to which the answer counts as verified.
    corrections : int
        How often the targets are corrected by the finer mesh; with None nothing is walked on a finer one.
    finer : float
        How many times shorter its edges are.
    path : str or Path, optional
        File in which every design tried is kept; a search that finds it goes on from the best of them.

    Raises
    ------
    ModelError
        Targets or constraints that say nothing, unknown methods, a design of which no parameter has a range.
    AnalysisError
        In a run: the design it starts from cannot be walked.

    Examples
    --------
    How thick a strip must be to bear 1.2 N when it is pulled by a hundredth:

    >>> import shapely, kirigami as kg
    >>> def pulled(m):
    ...     top = m.select(boundary="top")
    ...     m.add(kg.Fix(m.select(boundary="bottom")), kg.Fix(top, "xz"), kg.Prescribe(top, y=0.01))
    >>> design = kg.Design((), outline=shapely.box(0, 0, 0.3, 1), supports=pulled, thickness=(0.0005, 0.0001, 0.001),
    ...                    material=kg.Material(E=1e6), mesh={"max_edge": 0.4}, imperfection=0)
    >>> found = kg.Inverse(design, (("force", "driven_0", "y"), 1.0, 1.2), corrections=None).run()
    >>> found.status, round(found.values["thickness"] * 1e3, 2)
    ('met', 0.39)
    """

    def __init__(
        self,
        design: Design,
        targets: Any,
        constraints: Sequence[Any] = (),
        *,
        method: str = "auto",
        evaluations: int = 40,
        enough: float = 1e-6,
        tolerance: float = VERIFIED,
        corrections: int | None = 2,
        finer: float = 2.0,
        path: str | os.PathLike[str] | None = None,
    ) -> None:
        self.design = require_instance(design, Design, "design", "Inverse")
        if not self.design.free:
            raise ModelError("Inverse: no parameter of the design has a range: give one as name=(start, low, high)")
        self.targets: list[Target] = targets_of(targets)
        self.constraints: list[Bound] = bounds_of(constraints)
        self.method = chosen_method(
            require_choice(method, ("auto", *METHODS), "method", "Inverse"), design, self.targets, self.constraints
        )
        self.evaluations = require_whole(evaluations, "evaluations", "Inverse", 1)
        self.enough = require_not_negative(enough, "enough", "Inverse")
        self.tolerance = require_positive(tolerance, "tolerance", "Inverse")
        self.corrections = None if corrections is None else require_whole(corrections, "corrections", "Inverse", 0)
        self.finer = require_positive(finer, "finer", "Inverse")
        require_not_negative(self.finer - 1, "finer - 1", "Inverse")
        self.pictures: Path | None = None
        self.path = None if path is None else require_path(path, "path", "Inverse")

    def run(
        self,
        progress: bool | Callable[[int, dict[str, float], float], Any] = False,
        starts: int = 1,
        seed: int = 0,
        workers: int = 1,
        pictures: str | os.PathLike[str] | None = None,
    ) -> InverseResult:
        """Search.

        Parameters
        ----------
        progress : bool or callable
            True prints each design tried; ``progress(number, values, error)`` is called with it. Of searches side by
            side only the ends are told.
        starts : int
            From how many designs to search: the one given, and others spread over the ranges, of which those that
            cannot be walked are left out. The best answer counts.
        seed : int
            Another number is another spread.
        workers : int
            How many processes search side by side; functions of the design are then defined at the top of a module or
            script, which runs the search under ``if __name__ == "__main__":``.
        pictures : path, optional
            A folder, in which every design that is better than all before leaves a picture: the sheet, and how far
            each target is off. Not of searches side by side.
        """
        if not callable(progress):
            require_boolean(progress, "progress", "Inverse.run")
        count = require_whole(starts, "starts", "Inverse.run", 1) - 1
        seed = require_whole(seed, "seed", "Inverse.run", 0)
        require_whole(workers, "workers", "Inverse.run", 1)
        self.pictures = None if pictures is None else require_path(pictures, "pictures", "Inverse.run")
        designs = [self.design, *spread(self.design, count, seed)]
        if workers > 1 and len(designs) > 1:
            return side_by_side(self, designs, workers, progress)
        return one_by_one(self, designs, progress)
