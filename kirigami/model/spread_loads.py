"""Dead loads that are spread over the sheet: along edges, over areas, and its own weight.

Each is the integral of the load with what the elements take displacements for between their nodes, so that its work is
exact for them: half an edge's load to each end and a third of a facet's to each corner where displacements are linear.
On shell facets the middle of an edge, at w from the mean of its ends, takes the integrals of 4 l_a l_b as well: two
thirds of an edge's load, and a third of that of each facet beside.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kirigami.elements.facet import Facet
from kirigami.elements.shell_facet import ShellFacet
from kirigami.errors import ModelError
from kirigami.geometry.topology import pair_numbers, paired_half_edges
from kirigami.model.loads import Load, NodalLoadKernel
from kirigami.primitives.checks import require_boolean, require_finite, require_whole_array, shown
from kirigami.primitives.kernel import Array, Kernel
from kirigami.primitives.node import Node, listed, vector_of
from kirigami.primitives.parts import Numbering
from kirigami.words import counted

Index = NDArray[np.int64]


class Surface:
    """The facets of a model as loads see them.

    Attributes
    ----------
    triangles : ndarray of int, shape (m, 3)
        Corners, in the order of the mesh, or in that in which facets were added by hand.
    area : ndarray, shape (m,)
        Area at rest.
    """

    def __init__(self, numbering: Numbering, owner: str) -> None:
        self.numbering = numbering
        self._facets = [item for kind in (Facet, ShellFacet) for item in numbering.objects.get(kind, ())]
        mesh = numbering.mesh
        if mesh is not None:
            self.triangles: Index = mesh.triangles
        elif self._facets:
            self.triangles = numbering.index(node for item in self._facets for node in item.nodes[:3]).reshape(-1, 3)
        else:
            raise ModelError(f"{owner} needs facets: a model made by Model.from_mesh, or facets added by hand")
        corner = np.zeros((len(self.triangles), 3, 3))
        corner[..., : numbering.dim] = numbering.rest[self.triangles]
        self.area: Array = 0.5 * np.linalg.norm(
            np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]), axis=1
        )

    def chosen(self, facets: Any, owner: str) -> Index:
        """Numbers of facets given by number, by the name of a region, or None for all."""
        count = len(self.triangles)
        if facets is None:
            return np.arange(count)
        if isinstance(facets, str):
            regions = {} if self.numbering.mesh is None else self.numbering.mesh.regions
            if facets not in regions:
                known = ", ".join(map(repr, regions)) or "none"
                raise ModelError(f"{owner}: the mesh has no region {facets!r}; there are: {known}")
            return np.asarray(regions[facets])
        if facets.max() >= count or facets.min() < 0:
            raise ModelError(f"{owner}: facets must be numbers from 0 to {count - 1}, got {shown(facets)}")
        return np.unique(facets)

    def over_facets(self, facets: Index, per_area: Array) -> Array:
        """Weights (rows,) of a load per area (k,) of facets."""
        weight = np.zeros(len(self.numbering.rest))
        share = self.area[facets] * per_area / 3
        np.add.at(weight, self.triangles[facets], share[:, None])
        for local in range(3):
            ends = self.triangles[facets][:, [local, (local + 1) % 3]]
            self._to_middles(weight, ends, share)
        return weight

    def along_edges(self, nodes: Index, owner: str) -> Array:
        """Weights (rows,) of a load of one per length on the boundary edges between nodes; where there are none, on
        those inside the sheet."""
        first, second = paired_half_edges(self.triangles)
        ends = np.stack([self.triangles[first // 3, first % 3], self.triangles[first // 3, (first + 1) % 3]], axis=1)
        both = np.isin(ends, nodes).all(axis=1)
        found = both & (second < 0) if (both & (second < 0)).any() else both
        if not found.any():
            raise ModelError(
                f"{owner}: no edge of the sheet joins two of the {counted(len(nodes), 'node')}, the first of which is "
                f"{self.numbering.describe(int(nodes[0]))}: select both ends of edges"
            )
        ends = ends[found]
        rest = self.numbering.rest
        length = np.linalg.norm(rest[ends[:, 1]] - rest[ends[:, 0]], axis=1)
        weight = np.zeros(len(rest))
        np.add.at(weight, ends, 0.5 * length[:, None])
        self._to_middles(weight, ends, 2 / 3 * length)
        return weight

    def _to_middles(self, weight: Array, ends: Index, share: Array) -> None:
        """Add to the rows of the middles of edges (k, 2), where elements have such."""
        if self.numbering.edges is None:
            return
        rows = self.middles(ends)
        there = rows >= 0  # not so where an element was taken out
        np.add.at(weight, rows[there], share[there])

    def middles(self, ends: Index) -> Index:
        """Rows (k,) of the middles of edges (k, 2) of shell facets, -1 where there is none."""
        edges = self.numbering.edges
        assert edges is not None
        at = pair_numbers(ends, edges.ends, self.numbering.points)
        return np.where(at >= 0, edges.middle[at], -1)

    def mass_per_area(self, owner: str) -> Array:
        """Mass per area (m,) of each facet."""
        sheet = self.numbering.sheet
        found: list[float | None]
        if sheet is not None:
            known = sheet.mass_per_area(len(self.triangles))
            found = [None] if known is None else known.tolist()
        else:
            found = [item.material.mass_per_area(item.thickness) for item in self._facets]
        masses = [mass for mass in found if mass is not None]
        if len(masses) < len(found):
            raise ModelError(f"{owner} needs the mass of the sheet: give its material a density")
        return np.array(masses)


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class SpreadLoad(Load):
    """Base of the loads that are spread: a force per amount of what they act on, in a fixed direction."""

    force: tuple[float, float, float]
    constant: bool

    def weights(self, surface: Surface) -> Array:
        """What each row (rows,) takes of the force."""
        raise NotImplementedError

    @classmethod
    def lower(cls, objects: Sequence[Any], numbering: Numbering) -> list[Kernel]:
        surface = Surface(numbering, cls.__name__)
        kernels: list[Kernel] = []
        for constant in (False, True):
            total = np.zeros((len(numbering.rest), 3))
            for load in objects:
                if numbering.dim == 2 and load.force[2] != 0:
                    raise ModelError(f"{load!r} has a force along z, but the model has dim=2")
                if load.constant == constant:
                    total += load.weights(surface)[:, None] * np.asarray(load.force)
            rows = np.flatnonzero(total.any(axis=1))
            if rows.size:
                force = total[rows, : numbering.dim]
                kernels.append(NodalLoadKernel(numbering.rest, rows[:, None], force, constant))
        return kernels

    def _described(self, what: str) -> str:
        x, y, z = self.force
        constant = ", constant=True" if self.constant else ""
        return f"{type(self).__name__}({what}({x:g}, {y:g}, {z:g}){constant})"


def _facets(value: Any, owner: str) -> Index | str | None:
    if value is None or isinstance(value, str):
        return value
    return require_whole_array(value, (None,), name="facets", owner=owner)


@dataclass(frozen=True, slots=True, eq=False, repr=False, init=False)
class EdgeLoad(SpreadLoad):
    """A dead force per length along edges of the sheet.

    Parameters
    ----------
    nodes : sequence of Node
        The load acts on the boundary edges with both ends among these; where there are none, on edges inside the sheet.
    force : array_like, shape (2,) or (3,)
        Force per length at rest, at load factor 1 [force / length].
    constant : bool
        The force acts at full size whatever the load factor.

    Raises
    ------
    ModelError
        Empty selection or a force that is not two or three finite numbers; in a run nodes without an edge between
        them, or a model without facets.

    Examples
    --------
    >>> import kirigami as kg
    >>> mesh = kg.Sheet([(0, 0), (4, 0), (4, 1), (0, 1)]).mesh(0.5)
    >>> m = kg.Model.from_mesh(mesh, thickness=0.1, material=kg.Material(E=1e6, nu=0.0), stiffness="shell")
    >>> held = m.add(kg.Fix(m.select(boundary="left"), clamp=True))
    >>> load = m.add(kg.EdgeLoad(m.select(boundary="right"), (0, 0, 1e-3)))
    >>> tip = kg.LinearStatic(m).run().position("right")[-1, :, 2].mean()
    >>> round(float(tip / (1e-3 * 4**3 / (3 * 1e6 * 0.1**3 / 12))), 3)      # P L^3 / (3 E I)
    1.0
    """

    group: tuple[Node, ...]

    def __init__(self, nodes: Iterable[Node], force: ArrayLike, constant: bool = False) -> None:
        object.__setattr__(self, "group", listed(nodes, "EdgeLoad", once=True))
        object.__setattr__(self, "force", vector_of(force, "force", "EdgeLoad"))
        object.__setattr__(self, "constant", require_boolean(constant, "constant", "EdgeLoad"))

    @property
    def nodes(self) -> tuple[Node, ...]:
        return self.group

    def held(self, lam: float) -> EdgeLoad:
        """The same, constant at load factor `lam`."""
        lam = require_finite(lam, "lam", "EdgeLoad.held")
        return self if self.constant else EdgeLoad(self.group, np.multiply(lam, self.force), constant=True)

    def weights(self, surface: Surface) -> Array:
        return surface.along_edges(surface.numbering.index(self.group), repr(self))

    def __repr__(self) -> str:
        return self._described(f"{counted(len(self.group), 'node')}, force=")


@dataclass(frozen=True, slots=True, eq=False, repr=False, init=False)
class AreaLoad(SpreadLoad):
    """A dead force per area of the sheet; it keeps its direction where the sheet turns.

    Parameters
    ----------
    force : array_like, shape (2,) or (3,)
        Force per area at rest, at load factor 1 [force / length^2].
    facets : str or array_like of int, optional
        Name of a region of the mesh, or numbers of facets; None is the whole sheet.
    constant : bool
        The force acts at full size whatever the load factor.

    Raises
    ------
    ModelError
        A force that is not two or three finite numbers; in a run a region or facet that is not there, or a model
        without facets.

    Examples
    --------
    >>> import kirigami as kg
    >>> mesh = kg.Sheet([(0, 0), (4, 0), (4, 1), (0, 1)]).mesh(0.5)
    >>> m = kg.Model.from_mesh(mesh, thickness=0.1, material=kg.Material(E=1e6, nu=0.0), stiffness="shell")
    >>> held = m.add(kg.Fix(m.select(boundary="left"), clamp=True), kg.AreaLoad((0, 0, -1e-3)))
    >>> round(float(kg.LinearStatic(m).run().reaction("fixed_0", "z")[-1]), 9)
    0.004
    """

    facets: Index | str | None

    def __init__(self, force: ArrayLike, facets: str | ArrayLike | None = None, constant: bool = False) -> None:
        object.__setattr__(self, "force", vector_of(force, "force", "AreaLoad"))
        object.__setattr__(self, "facets", _facets(facets, "AreaLoad"))
        object.__setattr__(self, "constant", require_boolean(constant, "constant", "AreaLoad"))

    @property
    def nodes(self) -> tuple[Node, ...]:
        return ()

    def held(self, lam: float) -> AreaLoad:
        """The same, constant at load factor `lam`."""
        lam = require_finite(lam, "lam", "AreaLoad.held")
        return self if self.constant else AreaLoad(np.multiply(lam, self.force), self.facets, constant=True)

    def weights(self, surface: Surface) -> Array:
        facets = surface.chosen(self.facets, repr(self))
        return surface.over_facets(facets, np.ones(len(facets)))

    def __repr__(self) -> str:
        return self._described(f"{_where(self.facets)}force=")


@dataclass(frozen=True, slots=True, eq=False, repr=False, init=False)
class Gravity(SpreadLoad):
    """The weight of the sheet, from the density of its material; of nothing else.

    Parameters
    ----------
    g : array_like, shape (2,) or (3,)
        Acceleration at load factor 1 [length / time^2].
    facets : str or array_like of int, optional
        Name of a region of the mesh, or numbers of facets; None is the whole sheet.
    constant : bool
        The weight acts in full whatever the load factor.

    Raises
    ------
    ModelError
        An acceleration that is not two or three finite numbers; in a run a material without density, a region or facet
        that is not there, or a model without facets.

    Examples
    --------
    >>> import kirigami as kg
    >>> mesh = kg.Sheet([(0, 0), (4, 0), (4, 1), (0, 1)]).mesh(0.5)
    >>> paper = kg.Material(E=3e9, nu=0.3, density=800.0)
    >>> m = kg.Model.from_mesh(mesh, thickness=1e-3, material=paper, stiffness="shell")
    >>> held = m.add(kg.Fix(m.select(boundary="left"), clamp=True), kg.Gravity())
    >>> round(float(kg.LinearStatic(m).run().reaction("fixed_0", "z")[-1]), 6)
    31.392
    """

    facets: Index | str | None

    def __init__(
        self, g: ArrayLike = (0, 0, -9.81), facets: str | ArrayLike | None = None, constant: bool = False
    ) -> None:
        object.__setattr__(self, "force", vector_of(g, "g", "Gravity"))
        object.__setattr__(self, "facets", _facets(facets, "Gravity"))
        object.__setattr__(self, "constant", require_boolean(constant, "constant", "Gravity"))

    @property
    def nodes(self) -> tuple[Node, ...]:
        return ()

    def held(self, lam: float) -> Gravity:
        """The same, constant at load factor `lam`."""
        lam = require_finite(lam, "lam", "Gravity.held")
        return self if self.constant else Gravity(np.multiply(lam, self.force), self.facets, constant=True)

    def weights(self, surface: Surface) -> Array:
        facets = surface.chosen(self.facets, repr(self))
        return surface.over_facets(facets, surface.mass_per_area("Gravity")[facets])

    def __repr__(self) -> str:
        return self._described(f"{_where(self.facets)}g=")


def _where(facets: Index | str | None) -> str:
    if facets is None:
        return ""
    return f"region {facets!r}, " if isinstance(facets, str) else f"{counted(len(facets), 'facet')}, "
