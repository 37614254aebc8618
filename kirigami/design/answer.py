"""What a search for a design answers."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from kirigami.deferred import deferred
from kirigami.primitives.kernel import Array
from kirigami.words import counted


@dataclass
class InverseResult:
    """The answer of an inverse problem.

    Attributes
    ----------
    design : Design
        The best design found.
    start : Design
        What the search began with.
    values : dict of str to float
        Its parameters, those that have a range.
    error : float
        Largest error of a target over its size on the finer mesh, walked from flat; that on the design's own mesh where
        it was not verified.
    coarse_error : float
        The same on the mesh of the design.
    verified : bool
        Whether the design, walked from flat on a finer mesh, meets its targets within ``tolerance`` and its bounds.
    status : str
        "met", "closest" (nothing nearer was found), "out of evaluations", "interrupted" or "failed".
    message : str
        The same in a sentence.
    lam, wanted, reached, coarse, before : list of ndarray
        For each target: load factors, what was wanted, what the design does on the finer mesh, on its own mesh, and
        what the start did.
    names : list of str
        What each target asks for.
    history : list of dict
        Every design tried: "values", "error".
    evaluations, walks, factorizations : int
        Designs tried, walks from flat, and tangents factorised.
    worth : float
        What was made small: half the squared errors, what is wished for, and what constraints are missed by.
    sensitivities : dict of str to float
        Derivative of the summed squares of errors by each parameter, at the answer.
    thicker : ndarray, shape (facets,), or None
        The same by the thickness of each facet of the design's mesh, over its area: negative where a thicker sheet
        would bring the targets nearer. None where thickness has no gradient.

    Examples
    --------
    >>> import kirigami as kg
    >>> result = kg.InverseResult(None, None, {"length": 0.5}, 0.01, 0.0, True, "met", "met within 1 %")
    >>> result.verified
    True
    """

    design: Any
    start: Any
    values: dict[str, float]
    error: float
    coarse_error: float
    verified: bool
    status: str
    message: str
    lam: list[Array] = field(default_factory=list)
    wanted: list[Array] = field(default_factory=list)
    reached: list[Array] = field(default_factory=list)
    coarse: list[Array] = field(default_factory=list)
    before: list[Array] = field(default_factory=list)
    names: list[str] = field(default_factory=list)
    history: list[dict[str, Any]] = field(default_factory=list)
    evaluations: int = 0
    walks: int = 0
    factorizations: int = 0
    worth: float = 0.0
    sensitivities: dict[str, float] = field(default_factory=dict)
    thicker: Array | None = None

    plot = deferred("kirigami.design.picture:plot_result")

    def summary(self) -> str:
        """The answer as text."""
        told = ", ".join(f"{name}={value:.6g}" for name, value in self.values.items())
        lines = [
            f"{self.status}: {told}",
            self.message,
            f"{counted(self.evaluations, 'design')} tried, {counted(self.walks, 'walk')} from flat, "
            f"{counted(self.factorizations, 'factorisation')}",
            f"error {self.coarse_error:.2e} on the design's mesh"
            + (f", {self.error:.2e} on a finer one" if len(self.reached) else ", not walked on a finer mesh")
            + (": verified" if self.verified else ": not verified"),
        ]
        return "\n".join(lines)
