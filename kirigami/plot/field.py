"""What colours of a picture stand for: values of facets, nodes or bars, their names and kinds."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kirigami.errors import ModelError
from kirigami.plot import style
from kirigami.primitives.checks import require_array
from kirigami.results.fields import energy_density
from kirigami.results.smooth import sectors, surface_stress
from kirigami.results.yielding import facet_plastic_strain
from kirigami.words import counted

if TYPE_CHECKING:
    from kirigami.results.results import Results

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

LABELS = {
    "height": "height z",
    "displacement": "displacement",
    "energy": "energy per area",
    "force": "bar force",
    "strain": "bar strain",
    "stress": "von Mises stress",
    "plastic strain": "plastic strain",
}
OF_SHEETS = ("stress", "plastic strain")
PEAKED = ("stress", "plastic strain", "energy")  # at the tips of cuts, where colours leave out the highest values
KINDS = {
    "height": "length", "displacement": "length", "energy": "energy per area", "force": "force", "stress": "stress",
}  # fmt: skip


class Field:
    """What colour stands for: values per facet of a sheet, or per bar of another structure."""

    def __init__(self, results: Results, color: str | ArrayLike | None, smooth: bool = False) -> None:
        self.results = results
        mesh = results.mesh
        self.smooth = smooth and mesh is not None  # values belong to sectors of nodes, not to facets
        self.sectors = sectors(results) if mesh is not None else None
        self.cells: Integers = results.bars if mesh is None else mesh.triangles
        given: Any = color
        if color is None:
            given = "force" if mesh is None else "height" if results.dim == 3 else "displacement"
        self.key = given if isinstance(given, str) else "given"
        self.label = LABELS.get(self.key, "")
        if self.key == "energy" and mesh is None:
            self.label = "energy"
        self.kind = KINDS.get(self.key, "")
        if self.label == "energy":
            self.kind = "energy"
        self._given: Floats | None = None
        if self.key == "given":
            values = require_array(given, name="color", owner="plot")
            if mesh is not None and values.shape == (len(mesh.triangles),) != (len(results.rest),):
                self.smooth = False
            self._given = self._per_cell(values)
            return
        of_bars = [name for name in LABELS if name not in OF_SHEETS]
        known = [*of_bars, "none"] if mesh is None else ["height", "displacement", "energy", *OF_SHEETS, "none"]
        if self.key not in known:
            raise ModelError(f"color {color!r} is unknown: use one of {', '.join(known)}, or an array of values")

    def span(self, values: Floats) -> tuple[float, float]:
        """Smallest and largest value (...) that the colours tell apart."""
        if self.key in PEAKED and self.sectors is not None and values.shape == self.sectors.node.shape:
            return self.sectors.span(values[None])
        return float(values.min()), float(values.max())

    @property
    def diverging(self) -> bool:
        return self.key in ("force", "strain")

    def map(self) -> Any:
        """The colours of its own."""
        if self.diverging:
            return style.diverging_map()
        return style.rising_map() if self.key in PEAKED else style.sequential_map()

    def at(self, number: int) -> Floats | None:
        """Values per cell, or of a smooth field per sector, at a stored step; None for plain colour."""
        results = self.results
        if self.key == "none":
            return None
        if self._given is not None:
            return self._given
        if self.key == "force":
            return np.asarray(results.bar_force[number])
        if self.key == "strain":
            return np.asarray(results.bar_strain[number])
        if self.key == "stress":
            assert self.sectors is not None
            means = surface_stress(results, number)
            return means if self.smooth else np.asarray(self.sectors.over_facets(means[None])[0])
        if self.key == "plastic strain":
            assert self.sectors is not None
            strain = facet_plastic_strain(results, number)
            return np.asarray(self.sectors.means(strain[None])[0] if self.smooth else strain)
        if self.key == "energy":
            return self._per_cell(energy_density(self.results, number))
        u = results[number].u
        return self._per_cell(results.rest[:, 2] + u[:, 2] if self.key == "height" else np.linalg.norm(u, axis=1))

    def _per_cell(self, values: Floats) -> Floats:
        """Values given per node as means over the nodes of each cell; values given per cell as they are. Of a smooth
        field values given per node or sector stand at the sectors."""
        if self.smooth and self.sectors is not None:
            if values.shape == (len(self.results.rest),):
                values = values[self.sectors.node]
            if values.shape == self.sectors.node.shape and np.isfinite(values).all():
                return values
        if values.shape == (len(self.results.rest),):
            values = values[self.cells].mean(axis=1)
        if values.shape != (len(self.cells),) or not np.isfinite(values).all():
            cell = "bars" if self.results.mesh is None else "facets"
            raise ModelError(
                f"color: give one finite value for each of the {counted(len(self.results.rest), 'node')} or "
                f"{len(self.cells)} {cell}, got shape {values.shape}"
            )
        return values
