"""What a load case does, by name, and what it takes: kept with results."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from kirigami.primitives.kernel import Array
from kirigami.scale import Scale
from kirigami.words import counted

if TYPE_CHECKING:
    from kirigami.results.results import Results

SHAPES = {2: "point", 3: "disc", 4: "box"}  # that so many coordinates mean


@dataclass(frozen=True, eq=False)
class Drive:
    """One thing that a load case does to a sheet, and the force or torque that this takes.

    Its own weight alone moves nothing: it is taken as what is done, and the sag is the answer to it.

    Attributes
    ----------
    motion : str
        "strain", "shear", "twist", "lift" or "weight".
    name : str
        What moves, in words: "moved grip", "lifted centre", "sheet".
    group : str
        Its nodes, in ``results.grips``.
    kind : str
        What the motion is measured in: "ratio", "angle" [degrees] or "length".
    whole : float
        The motion at load factor 1.
    direction : ndarray, shape (3,)
        Of the force, or the axis of the torque.
    """

    motion: str
    name: str
    group: str
    kind: str
    whole: float
    direction: Array

    @property
    def turns(self) -> bool:
        """Whether it takes a torque."""
        return self.kind == "angle"

    @property
    def answer(self) -> str:
        """What it takes: "force", "torque", or for a weight "sag"."""
        return "sag" if self.motion == "weight" else "torque" if self.turns else "force"

    @property
    def answer_kind(self) -> str:
        """What that is measured in: "length", "torque" or "force"."""
        return "length" if self.answer == "sag" else self.answer

    def travel(self, results: Results) -> Array:
        """The motion at each step (s,)."""
        travelled: Array = self.whole * results.lam
        return travelled

    def force(self, results: Results) -> Array:
        """Force [force], or torque [force length], that the support puts on what moves, at each step (s,).

        Of a weight the sag [length]: how far the point that falls most has fallen.
        """
        if self.answer == "sag":
            fallen: Array = np.maximum(-results.u[:, :, 2].min(axis=1), 0.0)
            return fallen
        nodes = results.grips[self.group]
        if not self.turns:
            along: Array = results.reaction(nodes, self.direction)
            return along
        index = results.node_index(nodes)
        arms = results.position()[:, index]
        arms = arms - arms.mean(axis=1, keepdims=True)
        # A rigid group has no offsets of edges in the plane of the turn, so its nodes bear the whole torque.
        moments: Array = np.cross(arms, results._gradients[:, index]).sum(axis=1) @ self.direction
        return moments

    @property
    def column(self) -> str:
        """The motion as the name of a column: "strain", "twist", "lift_centre"."""
        return f"lift_{self.place}" if self.motion == "lift" else self.motion

    @property
    def response(self) -> str:
        """What it takes as the name of a column: "force", "force_shear", "torque", "force_centre"."""
        if self.motion == "lift":
            return f"force_{self.place}"
        return {"strain": "force", "shear": "force_shear", "twist": "torque", "weight": "sag"}[self.motion]

    @property
    def place(self) -> str:
        """Where, for a name: "centre", "0.03_0.04"."""
        words = self.name.removeprefix("lifted ").replace(":", " ").replace(",", " ").split()
        return "_".join(words)

    def where(self, scale: Scale, named: bool = True) -> str:
        """The place in words: "centre", "the disc (0, 0, 6) mm"; coordinates alone say little. The unit need not be
        named where it follows."""
        name = self.name.removeprefix("lifted ")
        with suppress(ValueError):
            numbers = [float(part) for part in name.split(",")]
            return f"the {SHAPES.get(len(numbers), 'place')} {scale.place(numbers, named=named)}"
        return name

    def named(self, scale: Scale) -> str:
        """The motion as the beginning of a sentence: "strain", "lifted centre by"."""
        return f"lifted {self.where(scale)} by" if self.motion == "lift" else self.motion

    def title(self, scale: Scale) -> str:
        """The motion in words, as an axis has it whose unit follows: "strain", "lift of the point (60, 20)"."""
        return f"lift of {self.where(scale, named=False)}" if self.motion == "lift" else self.motion

    def takes(self, scale: Scale) -> str:
        """What it takes in words: "force of the grip", "torque of the grip", "force at centre"."""
        if self.motion == "lift":
            return f"force at {self.where(scale)}"
        named = {"shear": "force across the pull", "twist": "torque of the grip", "weight": "sag"}
        return named.get(self.motion, "force of the grip")

    @property
    def share(self) -> float:
        """By which the motion is multiplied for people: strains are told in per cent."""
        return 100.0 if self.kind == "ratio" else 1.0

    def titles(self, scale: Scale) -> tuple[str, str]:
        """Motion and response as titles of axes, with their units as far as these are known."""
        unit = {"ratio": " [%]", "angle": " [degrees]", "length": ""}[self.kind]
        return scale.title(f"{self.title(scale)}{unit}", self.kind), scale.title(self.takes(scale), self.answer_kind)

    def says(self, share: float, scale: Scale) -> str:
        """The motion at a load factor, in words."""
        value = self.whole * share
        if self.kind == "ratio":
            return f"{100 * value:.4g} %"
        if self.kind == "angle":
            return counted(value, "degree", spec=".4g")
        return scale.show(value, "length")

    def plain(self) -> list[Any]:
        """What a results file keeps."""
        return [self.motion, self.name, self.group, self.kind, self.whole, self.direction.tolist()]

    @classmethod
    def from_plain(cls, kept: list[Any]) -> Drive:
        """The drive that a results file keeps."""
        motion, name, group, kind, whole, direction = kept
        return cls(motion, name, group, kind, whole, np.array(direction, dtype=float))
