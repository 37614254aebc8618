"""Typed errors: each names the thing, the place and what to do, and none of them loses results already computed."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any


def nearest_name(word: str, known: Iterable[str]) -> str | None:
    """The name that was meant by a misspelt one: the same letters in another order, or else the one most alike.

    Examples
    --------
    >>> from kirigami.errors import nearest_name
    >>> nearest_name("Modle", ["Mode", "Model"]), nearest_name("standart", ["draft", "standard"])
    ('Model', 'standard')
    """
    from difflib import get_close_matches

    names = [*known]
    swapped = [name for name in names if sorted(name.lower()) == sorted(word.lower())]
    return next(iter(swapped or get_close_matches(word, names, n=1)), None)


class KirigamiError(Exception):
    """Base of every error this package raises on purpose.

    Examples
    --------
    >>> import kirigami as kg
    >>> try:
    ...     kg.Material(E=-1.0)
    ... except kg.KirigamiError as error:
    ...     print(error)
    Material: E must be positive, got -1.0
    """


class GeometryError(KirigamiError, ValueError):
    """The outline, the cuts or the mesh cannot be used as given.

    Examples
    --------
    >>> import kirigami as kg
    >>> try:
    ...     kg.TriMesh([[0, 0], [1, 0], [2, 0]], [[0, 1, 2]])
    ... except kg.GeometryError as error:
    ...     print("refused:", "area" in str(error))
    refused: True
    """


class ModelError(KirigamiError, ValueError):
    """An object of the model, or a request about it, is invalid.

    Examples
    --------
    >>> import kirigami as kg
    >>> try:
    ...     kg.Fix([])
    ... except kg.ModelError as error:
    ...     print(error)
    Fix: the node selection is empty
    """


class MechanismError(KirigamiError):
    """The structure can move without resistance.

    Attributes
    ----------
    motion : str
        The motion in words, for example ``"translation along y"``.
    nodes : list of int
        Indices of the nodes that move most.
    shape : ndarray, shape (n, 3), or None
        The free motion itself, largest component 1, where it was computed.

    Examples
    --------
    >>> import kirigami as kg
    >>> m = kg.Model(dim=2)
    >>> a, b = m.add(kg.Node(0, 0), kg.Node(1, 0))
    >>> objects = m.add(kg.Bar(a, b, EA=1.0), kg.Fix([a, b], "y"), kg.NodalLoad(b, (1, 0)))
    >>> try:
    ...     kg.LinearStatic(m).run()
    ... except kg.MechanismError as error:
    ...     print(error.motion)
    translation along x
    """

    def __init__(self, message: str, *, motion: str = "", nodes: Sequence[int] = (), shape: Any = None) -> None:
        super().__init__(message)
        self.motion = motion
        self.nodes = list(nodes)
        self.shape = shape


class AnalysisError(KirigamiError):
    """An analysis could not be carried out; ``results`` holds what was computed before.

    Examples
    --------
    >>> import kirigami as kg
    >>> try:
    ...     kg.load("no such file")
    ... except kg.AnalysisError as error:
    ...     print(error)
    no results file at no such file
    """

    def __init__(self, message: str, *, results: Any = None) -> None:
        super().__init__(message)
        self.results = results


class ConvergenceError(AnalysisError):
    """Equilibrium was not found at the smallest allowed increment.

    Attributes
    ----------
    results : Results
        Every step that converged before the failure.
    history : list of float
        Relative residuals of the last attempt, iteration by iteration.
    worst_nodes : list of int
        Nodes with the largest residual force in the last attempt.
    hint : str
        What to try next.

    Examples
    --------
    >>> import kirigami as kg
    >>> m = kg.Model(dim=2)
    >>> left, apex, right = m.add(kg.Node(-1, 0), kg.Node(0, 1), kg.Node(1, 0))
    >>> bars = m.add(kg.Bar(left, apex, EA=1.0), kg.Bar(apex, right, EA=1.0))
    >>> rest = m.add(kg.Fix([left, right]), kg.Fix(apex, "x"), kg.NodalLoad(apex, (0, -0.2)))
    >>> try:
    ...     kg.LoadControl(m, on_instability="follow").run()
    ... except kg.ConvergenceError as error:
    ...     print(error.worst_nodes[0], error.hint)
    1 past a limit point no equilibrium exists at a higher load: use DisplacementControl or ArcLength
    """

    def __init__(
        self,
        message: str,
        *,
        results: Any = None,
        history: Sequence[float] = (),
        worst_nodes: Sequence[int] = (),
        hint: str = "",
    ) -> None:
        super().__init__(f"{message}\nHint: {hint}" if hint else message, results=results)
        self.history = list(history)
        self.worst_nodes = list(worst_nodes)
        self.hint = hint


class KirigamiWarning(UserWarning):
    """Something was repaired or looks wrong, and the work went on.

    Examples
    --------
    Turned into an error, so that nothing is repaired unseen:

    >>> import shapely, warnings
    >>> import kirigami as kg
    >>> slit = shapely.LineString([(0.3, 0.5), (0.7, 0.5)])
    >>> with warnings.catch_warnings():
    ...     warnings.simplefilter("error", kg.KirigamiWarning)
    ...     try:
    ...         mesh = kg.Sheet(shapely.box(0, 0, 1, 1), [slit, slit]).mesh(0.5)
    ...     except kg.KirigamiWarning as warning:
    ...         print("the same cut twice:", "merged" in str(warning))
    the same cut twice: True
    """
