"""Which shapes there are: a search for the stable shapes of a structure at a given pull."""

from __future__ import annotations

import os
import warnings
from collections.abc import Sequence
from concurrent.futures import Executor

from kirigami.errors import KirigamiWarning
from kirigami.model.model import Model
from kirigami.primitives.checks import (
    require_axes,
    require_boolean,
    require_executor,
    require_finite,
    require_instance,
    require_items,
    require_path,
    require_positive,
    require_whole,
)
from kirigami.progress import progress_bar
from kirigami.results.step import Step
from kirigami.study.shape.search import ShapeSearch
from kirigami.study.shape.study import ShapeStudy


def shapes(
    model: Model,
    at: float = 1.0,
    seed: int = 0,
    *,
    trials: int = 80,
    budget: float = 300.0,
    starts: Sequence[Step] = (),
    most: int = 8,
    followed: int = 4,
    confirm: bool = True,
    mirrors: str = "xy",
    alike: float = 0.1,
    path: str | os.PathLike[str] | None = None,
    executor: Executor | None = None,
    workers: int | None = None,
    progress: bool = False,
) -> ShapeStudy:
    """Search for the stable shapes that a structure can take at a given pull.

    A thin cut sheet has many, and where a pull leads depends on its history: the search tells what else there is. It
    starts from random fields and modes a little beyond the first buckles, and goes on from the lowest shapes found by
    the moves such a sheet makes: a lip pops through, a row tilts the other way, one part takes the shape it has in
    another equilibrium or in its mirror image, all is shaken. Each start runs downhill. A sheet is searched on the
    rung "plate", whichever the model is on; the lowest shapes are then carried over to the model, relaxed there, and
    tested to be stable. It is a search, no proof: lower shapes may exist.

    Parameters
    ----------
    model : Model
        With its supports and what drives it, imperfect or not; it is not changed.
    at : float
        Load factor.
    seed : int
        Another number is another search. The same one finds the same shapes, unless the budget ends it.
    trials : int
        How many starts.
    budget : float
        CPU seconds after which nothing new is begun; half of them at most go into the search.
    starts : sequence of Step
        Shapes known already, at this load factor, as the end of a pull: they are listed, and the search goes on from
        them too.
    most : int
        How many shapes, the lowest ones, are carried over to the rung of the model and to the trusted one.
    followed : int
        How many of them are followed down to no pull and up by a quarter, to see which snaps join them.
    confirm : bool
        Whether shapes of a sheet on a lesser rung are also relaxed on "shell", on the same mesh.
    mirrors : str
        Axes along which shapes may be reflected and still count as one; then arrangements of equal cells count as one
        too. "" counts everything by itself.
    alike : float
        Relative distance of two shapes (root mean square over the area) below which they may be one.
    path : path, optional
        A file that keeps every trial as it is done: the same call goes on where it was stopped.
    executor : concurrent.futures.Executor, optional
        Runs the trials, four at a time.
    workers : int, optional
        Number of processes that do, without `executor`; by default everything runs in this one. Worth it from about a
        second a trial. A script must then stand under ``if __name__ == "__main__":``.
    progress : bool
        Show how far it is.

    Returns
    -------
    ShapeStudy
        The shapes, lowest energy first; after Ctrl-C those found until then.

    Raises
    ------
    ModelError
        A sheet in its plane, nothing that drives the model, or arguments that cannot be used.
    AnalysisError
        The file at `path` belongs to another search, or no start led to a stable shape.

    Examples
    --------
    A shallow truss that can stand up or hang down, with a small load on its apex:

    >>> import kirigami as kg
    >>> m = kg.Model(dim=2)
    >>> left, apex, right = m.add(kg.Node(-1, 0), kg.Node(0, 0.5), kg.Node(1, 0))
    >>> bars = m.add(kg.Bar(left, apex, EA=1.0), kg.Bar(apex, right, EA=1.0))
    >>> objects = m.add(kg.Fix([left, right]), kg.NodalLoad(apex, (0, -0.001)))
    >>> found = kg.study.shapes(m, at=1.0, trials=8)
    >>> [shape.step.stable for shape in found], found[0].energy < found[1].energy
    ([True, True], True)
    """
    owner = "shapes"
    require_instance(model, Model, "model", owner)
    at = require_finite(at, "at", owner)
    seed = require_whole(seed, "seed", owner, least=0)
    trials = require_whole(trials, "trials", owner, least=1)
    budget = require_positive(budget, "budget", owner)
    most, followed = require_whole(most, "most", owner, least=1), require_whole(followed, "followed", owner, least=0)
    confirm = require_boolean(confirm, "confirm", owner)
    if not isinstance(mirrors, str) or mirrors:
        require_axes(mirrors, owner, "mirrors")
    alike = require_positive(alike, "alike", owner)
    require_executor(executor, owner)
    workers = None if workers is None else require_whole(workers, "workers", owner, least=1)
    known = [require_instance(step, Step, "starts", owner) for step in require_items(starts, "starts", owner)]
    file = None if path is None else require_path(path, "path", owner)
    search = ShapeSearch(model, at, seed, budget, known, mirrors, alike, confirm)
    with progress_bar(require_boolean(progress, "progress", owner), "shapes") as search.bar:
        search.bar.start(0.0)
        try:
            search.look(trials, file, executor, workers)
            search.follow(followed)
            search.carry(most)
            search.trust(most)
        except KeyboardInterrupt:
            search.notes.append("interrupted: what was found until then")
            warnings.warn("the search for shapes was interrupted", KirigamiWarning, stacklevel=2)
    return search.study()
