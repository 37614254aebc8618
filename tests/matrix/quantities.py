"""What results tell, and how each quantity must change with the statement of the problem."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from changes import Change
from structures import BUILT, FOLDED, PLANE, SHEETS, STRUCTURES

import kirigami as kg

SHEET_NAMES = {*SHEETS, *PLANE, *FOLDED}


@dataclass(frozen=True)
class Quantity:
    """One quantity of results.

    ``tell(results, change)`` is an array; ``kind`` says how it goes over: "scalar" as it is, "place" and "force" as
    vectors in the last axis, "moment" as axial ones,
    "members" and "facets" as values in another order, "nodes" with the nodes in the second
    axis, "node places" as vectors of nodes. ``length`` and ``force`` are the powers of the units. ``order`` is that of
    the quantity in a linear analysis under a doubled load, None where it is not asked.
    """

    tell: Callable[[kg.Results, Change], Any]
    kind: str = "scalar"
    length: int = 0
    force: int = 0
    served: frozenset[str] = frozenset(STRUCTURES)
    order: int | None = 1
    flat: bool = False  # where the drawing must stay in its plane


def sheets(*names: str) -> frozenset[str]:
    return frozenset(SHEET_NAMES if not names else names)


WITH_BARS = frozenset({"paper", "plate", "paper in the plane", "plate in the plane", *BUILT} & set(STRUCTURES))
WITH_HINGES = frozenset({"paper", "plate", "hinged strip"} & set(STRUCTURES))
WITH_SPRINGS = frozenset({"chain of springs", "stayed mast"})
SUPPORTS = ("driven_0", "fixed_0")


def member_names(results: kg.Results) -> list[str]:
    names = sorted({kernel.name for kernel in results.kernels})
    return [name for name in names if name in ("bars", "hinges", "springs")] or ["bars"]


QUANTITIES: dict[str, Quantity] = {
    "lam": Quantity(lambda r, c: r.lam, order=0),
    "u": Quantity(lambda r, c: r.u, "node places", length=1),
    "position": Quantity(lambda r, c: r.position(), "node places", length=1, order=None),
    "reaction": Quantity(lambda r, c: np.stack([r.reaction(name) for name in SUPPORTS]), "force", force=1),
    "moment": Quantity(
        lambda r, c: np.stack([r.moment(name) for name in SUPPORTS]), "moment", force=1, length=1,
    ),
    "energy": Quantity(lambda r, c: sum(r.energy.values()), length=1, force=1, order=2),
    "energy_shares": Quantity(lambda r, c: np.stack([s for _, s in sorted(r.energy_shares().items())]), order=None),
    "stable": Quantity(lambda r, c: r.stable.astype(float), order=0),
    "deformation": Quantity(
        lambda r, c: np.concatenate([np.sort(r.deformation(name), axis=1) for name in member_names(r)], axis=1),
        served=WITH_BARS,
        order=None,
    ),
    "force": Quantity(
        lambda r, c: np.concatenate(
            [np.sort(r.force(n), axis=1) / (1 if n == "bars" else c.length) for n in member_names(r)], axis=1
        ),
        force=1,
        served=WITH_BARS,
    ),
    "bar_strain": Quantity(lambda r, c: r.bar_strain, "members", served=WITH_BARS),
    "bar_force": Quantity(lambda r, c: r.bar_force, "members", force=1, served=WITH_BARS),
    "hinge_angle": Quantity(lambda r, c: r.hinge_angle, "members", served=WITH_HINGES, order=None),
    "hinge_moment": Quantity(lambda r, c: r.hinge_moment, "members", force=1, length=1, served=WITH_HINGES),
    "spring_angle": Quantity(lambda r, c: r.spring_angle, "members", served=WITH_SPRINGS, order=None),
    "spring_moment": Quantity(lambda r, c: r.spring_moment, "members", force=1, length=1, served=WITH_SPRINGS),
    "height": Quantity(lambda r, c: r.height(), length=1, flat=True, order=None),
    "width": Quantity(
        lambda r, c: r.width(c.axis("y")), length=1, served=sheets(), flat=True, order=None
    ),
    "poisson_ratio": Quantity(
        lambda r, c: r.poisson_ratio(c.axis("y"))[1:], served=sheets(), flat=True, order=None
    ),
    "open_area": Quantity(lambda r, c: r.open_area(union=True), length=2, served=sheets(), flat=True, order=None),
    "curvature": Quantity(
        lambda r, c: r.curvature("principal", per="node"), "nodes", length=-1, served=sheets(), flat=True, order=None
    ),
    "stress": Quantity(
        lambda r, c: r.stress().principal("top").reshape(len(r), -1), "members", force=1, length=-2, served=sheets(),
        flat=True,
    ),
    "error": Quantity(
        lambda r, c: np.nan_to_num(np.stack([r.error[name] for name in r.error]), nan=-1.0), served=sheets(),
        flat=True, order=None,
    ),
    "yielded": Quantity(lambda r, c: np.nan_to_num(r.yielded, nan=-1.0), order=0),
    "plastic_strain": Quantity(lambda r, c: r.plastic_strain(), "members", served=sheets()),
    "thickness": Quantity(lambda r, c: np.array(r.thickness or 0.0), length=1, order=0),
}  # fmt: skip

# Public names of Results that are no such quantity, and why.
NO_QUANTITY: dict[str, str] = {
    **dict.fromkeys(
        """append configuration evaluate_at forget_model member_deformation member_dissipation member_energy
        member_force node_index object_number once row_gradients rows step_number told""".split(),
        "for the package and for authors of effects; the quantities above are made of it",
    ),
    **dict.fromkeys(["model", "material", "bars", "grips"], "hands out what the run was made of"),
    **dict.fromkeys(["time", "velocity", "moves"], "of a motion; tested in test_dynamics.py"),
    **dict.fromkeys(["nearest"], "a look-up among the steps"),
    **dict.fromkeys(["gradient"], "held against Taylor series, on every structure, in test_gradients.py"),
    **dict.fromkeys(["residual", "summary"], "tells how the computation went, which differs in rounding"),
    **dict.fromkeys(["energy_release"], "of slits, which these have none of; in mechanics/test_energy_release.py"),
    **dict.fromkeys(["plot", "plot_curve", "plot_stress", "animate"], "pictures, tested in tests/plot"),
    **dict.fromkeys(
        ["save", "to_csv", "to_html", "to_surface", "to_vtk", "to_xarray"], "files, in test_exporters.py"
    ),
}


def carried_over(quantity: Quantity, values: Any, change: Change) -> np.ndarray:
    """What a quantity of the problem as it stood must be after the change."""
    values = np.asarray(values, dtype=float)
    values = values * change.length**quantity.length * change.force**quantity.force
    if quantity.kind in ("force", "node places"):
        values = values @ change.turn.T
    if quantity.kind == "moment":  # a mirror turns the sense of rotations
        values = values @ change.turn.T * np.sign(np.linalg.det(change.turn))
    if quantity.kind in ("nodes", "node places"):
        values = values[:, change.order(values.shape[1])]
    if quantity.kind == "members":
        values = np.sort(values, axis=1)
    return values


def told(quantity: Quantity, results: kg.Results, change: Change) -> np.ndarray:
    values = np.asarray(quantity.tell(results, change), dtype=float)
    return np.sort(values, axis=1) if quantity.kind == "members" else values
