"""What runs are judged by, and how wrong that may be itself: given values, or the limit of finer and finer meshes."""

from __future__ import annotations

import csv
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from kirigami.errors import ModelError
from kirigami.primitives.checks import require_array, require_mapping, require_path
from kirigami.primitives.kernel import Array
from kirigami.scale import UNKNOWN, Scale
from kirigami.study.convergence import limit_of
from kirigami.words import percent

QUANTITIES = ("force", "open_area", "height")


@dataclass(frozen=True)
class Reference:
    """Values that runs are judged by.

    Attributes
    ----------
    named : str
        What they are.
    values : dict of ndarray, each shape (k,)
        ``"force"``, ``"open_area"`` and ``"height"`` at the load factors; nan where nothing is known.
    errors : dict of ndarray, each shape (k,)
        How far each value may be from the truth, as far as is known [same unit]; 0 where nothing is said.
    stated : bool
        Whether the errors are known at all.
    sizes : tuple of float
        Of a limit the longest edges of its meshes [length].
    remark : str
        What is to be said of them.
    """

    named: str
    values: dict[str, Array]
    errors: dict[str, Array] = field(default_factory=dict)
    stated: bool = True
    sizes: tuple[float, ...] = ()
    remark: str = ""

    def scale(self, quantity: str) -> Array:
        """What differences are divided by (k,): forces by themselves, areas and heights by their largest value."""
        size = np.abs(self.values[quantity])
        known = size[np.isfinite(size)]
        return size if quantity == "force" else np.full(len(size), known.max() if known.size else np.nan)

    def own_error(self, quantity: str) -> float:
        """Largest relative error that the reference itself may have; 0 where nothing is known of it."""
        if quantity not in self.errors:
            return 0.0
        scale = self.scale(quantity)
        compared = scale > 0
        shares = self.errors[quantity][compared] / scale[compared]
        return float(shares[np.isfinite(shares)].max(initial=0.0))

    def __str__(self) -> str:
        return self.told(UNKNOWN)

    def told(self, scale: Scale) -> str:
        """What it is and its own error, in the units of a report."""
        meshes = f", max_edge {', '.join(scale.show(size, 'length') for size in self.sizes)}" if self.sizes else ""
        named = f"{self.named}{meshes}{self.remark}"
        if not self.stated:
            return f"{named} (its own error is not stated)"
        told = [
            f"{percent(self.own_error(quantity))} in {quantity.replace('_', ' ')}"
            for quantity in QUANTITIES
            if np.isfinite(self.values[quantity]).any()
        ]
        return f"{named} (its own error: {', '.join(told)})" if told else f"{named} (it says nothing)"


def limit_reference(
    named: str, sizes: Sequence[float], runs: Sequence[Mapping[str, Array]], one_shape: bool = True, remark: str = ""
) -> Reference:
    """The limit of runs on finer and finer meshes, and what was added to the last of them as its error.

    Where runs do not converge evenly, or not to one shape, the last one stands, and its error is the spread of the runs
    or its last change as if of order one, whichever is larger.

    Examples
    --------
    >>> import numpy as np
    >>> from kirigami.study.reference import QUANTITIES, limit_reference
    >>> runs = [{name: np.array([value]) for name in QUANTITIES} for value in (10.0, 5.0, 2.0)]
    >>> limit = limit_reference("three runs", [3.0, 2.0, 1.0], runs)
    >>> round(float(limit.values["force"][0]), 9), round(limit.own_error("force"), 9)
    (1.0, 1.0)
    """
    values, errors = {}, {}
    for quantity in QUANTITIES:
        columns = np.array([run[quantity] for run in runs])
        found = []
        for column in columns.T:
            if not np.isfinite(column).all():
                found.append((float("nan"), float("nan")))
                continue
            limit, order, distance = limit_of(sizes, column)
            if np.isnan(order) or not one_shape:
                limit, distance = float(column[-1]), max(distance, float(np.ptp(column)))
            found.append((limit, distance))
        values[quantity], errors[quantity] = np.array(found).reshape(-1, 2).T
    return Reference(named, values, errors, sizes=tuple(sizes), remark=remark)


def read_reference(
    reference: str | os.PathLike[str] | Mapping[str, Sequence[float]], load_factors: Array
) -> Reference:
    """Given values at the load factors, between those given by linear interpolation.

    Columns ``load_factor`` and any of ``force``, ``open_area``, ``height``; and of ``force_error`` and its kin, the
    relative errors of these.
    """
    if isinstance(reference, Mapping):
        given = require_mapping(reference, "reference", "accuracy")
        columns = {name: require_array(values, (None,), name=name, owner="accuracy") for name, values in given.items()}
        owner, named = "the reference", "given values"
    else:
        path = require_path(reference, "reference", "accuracy")
        owner, named = str(path), path.name
        try:
            with open(path, newline="") as file:
                rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
            columns = {name: np.array([float(row[name]) for row in rows]) for name in (rows[0] if rows else {})}
        except OSError as error:
            raise ModelError(f"accuracy: cannot read {owner}: {error.strerror or error}") from None
        except (ValueError, TypeError) as error:
            raise ModelError(f"accuracy: {owner} cannot be read as a table of numbers ({error})") from None
    lam = columns.get("load_factor")
    if lam is None or not set(QUANTITIES) & set(columns):
        raise ModelError(f"accuracy: {owner} needs columns load_factor and at least one of {', '.join(QUANTITIES)}")
    if load_factors.max() > lam.max() * (1 + 1e-9) or load_factors.min() < lam.min() * (1 - 1e-9):
        raise ModelError(
            f"accuracy: {owner} spans load factors {lam.min():g} to {lam.max():g}, not all of {load_factors.tolist()}"
        )
    order = np.argsort(lam)

    def at_load_factors(name: str) -> Array:
        if name not in columns:
            return np.full(len(load_factors), np.nan)
        return np.asarray(np.interp(load_factors, lam[order], columns[name][order]), dtype=float)

    values = {name: at_load_factors(name) for name in QUANTITIES}
    errors = {
        name: np.abs(values[name]) * at_load_factors(f"{name}_error")
        for name in QUANTITIES
        if f"{name}_error" in columns
    }
    return Reference(named, values, errors, stated=bool(errors))
