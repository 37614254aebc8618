"""The state of every facet of a sheet, as its elements hold it: strain, forces and moments per length, stored energy.

Whatever the elements are, forces and energy are theirs, so that the stress belongs to the state that the analysis
found, and does its work:

* Shell facets tell strain, curvature, force N and moment M themselves, and flat facets strain and N.
* A bar of rest length L with force S and direction n in a facet of area A adds N = s S L n n' / A, and a hinge, fold or
  clamp with moment m adds M = s m R / A, where R : K is its angle under a uniform curvature K
  (:mod:`kirigami.geometry.folds`) and s is the share of the facet in the area of the one or two facets at the edge; a
  fold of a flat facet is its own. So the sum of A (N : dE + M : dK) over the sheet is the work of all its elements
  under uniform changes dE and dK, whatever the mesh.

Tensors have the axes of :func:`kirigami.geometry.folds.facet_axes`, in the plane of each facet as drawn. Where a sheet
is not drawn flat, the R of an edge are those of its two facets laid out in the plane of one.

Bars and hinges do not keep Poisson's ratio: their moments across a bend are about -1/3 of those round it, which is what
holds them in balance, but not what a plate would have. Curvature and, with bars, strain are measured on the surface.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from kirigami.elements.surface import SurfaceKernel, squares_over, surfaces_of
from kirigami.elements.triangle import ENDS, STARTS, SurfaceStrain, edge_vectors
from kirigami.geometry.folds import facet_axes, fold_curvature_rates, laid_out
from kirigami.post.curvature import CurvatureFit
from kirigami.primitives.kernel import Array, Kernel
from kirigami.results.results import Results
from kirigami.results.step import Step

if TYPE_CHECKING:
    from kirigami.elements.bar import BarKernel
    from kirigami.elements.clamp_hinge import HeldEdgeKernel
    from kirigami.elements.seams import SeamHingeKernel
    from kirigami.geometry.mesh import TriMesh

Index = NDArray[np.int64]
SMALL = 1e-4  # displacement over size from which the rate of curvature of a linear analysis is taken


@dataclass(eq=False)
class SheetState:
    """Strain, curvature, force and moment of each facet (m, 2, 2) in its axes as drawn, and energies (m,).

    ``natural`` (m, 6) are the strain and curvature (exx, eyy, gamma_xy, kxx, kyy, 2 kxy) at which facets bear nothing,
    nan where they are known of their edges alone, and ``heat`` (m, 2) that at the lower and upper faces in them.
    """

    strain: Array
    curvature: Array
    force: Array
    moment: Array
    membrane_energy: Array
    bending_energy: Array
    natural: Array
    heat: Array


class StateReader:
    """Reads the states of one sheet off its results."""

    def __init__(self, results: Results, mesh: TriMesh) -> None:
        self.results, self.mesh = results, mesh
        triangles = mesh.triangles
        self.surface = SurfaceStrain(results.rest, triangles)
        self.flat, self.area = self.surface.flat, self.surface.area
        # the facet laid out flat, against its drawing: the rotation of the gradient, without the stretch
        self.axes = facet_axes(mesh.nodes[triangles])
        drawn = edge_vectors(mesh.nodes, triangles) @ self.axes.transpose(0, 2, 1)
        gradient = np.linalg.solve(drawn[:, :2], self.flat[:, :2]).transpose(0, 2, 1)
        angle = np.arctan2(gradient[:, 1, 0] - gradient[:, 0, 1], gradient[:, 0, 0] + gradient[:, 1, 1])
        cosine, sine = np.cos(angle), np.sin(angle)
        self.turn = np.stack([np.stack([cosine, -sine], axis=-1), np.stack([sine, cosine], axis=-1)], axis=-2)
        self.surfaces = surfaces_of(results.kernels, "stress")
        self._laid_out: dict[int, Any] = {}  # what of the members of a kernel is the same at every step

    def at(self, step: Step) -> SheetState:
        """The state at a step; of a linear analysis to first order."""
        m = len(self.area)
        shapes: list[tuple[int, ...]] = [(2, 2)] * 4 + [(), (), (6,), (2,)]
        state = SheetState(*(np.zeros((m, *shape)) for shape in shapes))
        if self._bends_by_angles:
            state.curvature = self._surface_curvature(step)
        state.strain = self._drawn(_tensor(self.surface.at(step.u, self.results.linear), half_shear=True))
        for kernel in self.surfaces:
            self._add_facets(state, kernel, step)
        adders: dict[str, Callable[[SheetState, Any, Step], None]] = {"held edges": self._add_held_edges}
        if not self.surfaces:
            adders |= {"bars": self._add_bars, "hinges": self._add_hinges, "seams": self._add_seams}
        for part in self.results.kernels:
            if part.sheet_part in adders:
                adders[part.sheet_part](state, part, step)
        return state

    def layers(self, step: Step, elastic: Array) -> Array:
        """Stress (3, m, 2, 2) at the lower face, in the middle and at the upper face: that of an `elastic` sheet, but
        in facets that have yielded that of their outermost layers and of those beside the middle."""
        found: Array = elastic.copy()
        for kernel in self.surfaces:
            flown, stress = self.results.evaluate_at(kernel, step, lambda x: kernel.layer_stress(x, step.lam))  # noqa: B023
            if not len(flown):
                continue
            at = placed(kernel.conn[flown, :3], self.mesh.triangles)
            half = stress.shape[1] // 2
            middle = stress[:, half - 1 : half + 1].mean(axis=1)
            for place, values in enumerate((stress[:, 0], middle, stress[:, -1])):
                found[place, at[at >= 0]] = self._drawn(_tensor(values), at)[at >= 0]
        return found

    # ---- by kind of element

    def _add_facets(self, state: SheetState, kernel: SurfaceKernel, step: Step) -> None:
        results = self.results
        rows, at = self._facets(kernel)
        felt, borne = results.member_deformation(kernel, step)[rows], results.member_force(kernel, step)[rows]
        state.strain[at] = self._drawn(_tensor(felt[:, :3], half_shear=True), at)
        state.force[at] = self._drawn(_tensor(borne[:, :3]), at)
        if kernel.bends_by_folds:
            moments = results.told(kernel, step, lambda x: kernel.fold_moments(x, step.lam))
            state.moment[at] = self._of_folds(moments[rows], at)
        else:
            state.curvature[at] = self._drawn(_tensor(felt[:, 3:], half_shear=True), at)
            state.moment[at] = self._drawn(_tensor(borne[:, 3:]), at)
        energy = results.member_energy(kernel, step)[rows]
        fields = felt[:, None] if kernel.uniform else results.told(kernel, step, kernel.corner_deformation)[rows]
        natural = kernel.natural_deformation(step.lam)
        if natural is not None:  # energies are those of what is beyond it
            fields = fields - natural[rows, None]
            state.natural[at] = self._drawn_components(natural[rows], at)
        self._warm(state, kernel.heat(step.lam), rows, at)
        fields = squares_over(fields)
        forces = np.einsum("nab,nkb->nka", kernel.section[rows, :3], fields)
        stretching = 0.5 * self.area[at] * (fields[..., :3] * forces).sum(axis=(1, 2))
        if not results.linear:
            own = results.evaluate_at(kernel, step, lambda x: kernel.membrane_energy(x, step.lam))[rows]
            stretching = np.where(np.isnan(own), stretching, own)
        state.membrane_energy[at] = stretching
        state.bending_energy[at] = np.maximum(energy - stretching, 0.0)

    def _facets(self, kernel: Kernel) -> tuple[Index, Index]:
        """Which members of a kernel are facets of the mesh, and which these are."""
        found: tuple[Index, Index] = self._once(kernel, lambda: matched(kernel.conn[:, :3], self.mesh.triangles))
        return found

    def _drawn_components(self, values: Array, at: Index) -> Array:
        """Strain and curvature (k, 6) from the axes of facets to those of the drawing."""
        parts = [self._drawn(_tensor(part, half_shear=True), at) for part in (values[:, :3], values[:, 3:])]
        columns = [part[:, [0, 1, 0], [0, 1, 1]] * [1.0, 1.0, 2.0] for part in parts]
        return np.concatenate(columns, axis=1)

    @staticmethod
    def _warm(state: SheetState, heat: Array | None, rows: Index, at: Index) -> None:
        if heat is not None:
            state.heat[at] = heat[rows]

    def _of_folds(self, moments: Array, facets: Index) -> Array:
        """Moments (k, 2, 2) of facets whose folds, opposite their corners, have moments (k, 3)."""
        work = (moments[..., None] * self._fold_rates[facets]).sum(axis=1) / self.area[facets, None]
        return _tensor(work, half_shear=True)

    @cached_property
    def _fold_rates(self) -> Array:
        """Rates (m, 3, 3) of the angles of the folds opposite the corners of facets with the curvature."""
        mesh = self.mesh
        sides = np.sort(mesh.triangles[:, np.array([STARTS, ENDS]).T], axis=2)  # (m, 3, 2)
        edge = placed(sides.reshape(-1, 2), np.sort(mesh.edges, axis=1)).reshape(-1, 3)
        facet, corner = np.nonzero(mesh.edge_facets[edge, 1] >= 0)
        inner = edge[facet, corner]
        quads = np.column_stack([mesh.edge_wings[inner, 0], mesh.edges[inner], mesh.edge_wings[inner, 1]])
        rate = np.zeros((*edge.shape, 3))
        rate[facet, corner] = self._fold_rates_of(mesh.nodes[quads], facet, mesh.edge_facets[inner, 0] == facet)
        return rate

    def _fold_rates_of(self, places: Array, facets: Index, first: NDArray[np.bool_]) -> Array:
        """Rates (k, 3) of the angles at edges with `places` (k, 4, 3), as wing, edge nodes, wing, with the curvature in
        the axes of `facets` (k,), which are those of the `first` wing or of the last."""
        return fold_curvature_rates(laid_out(places, self.axes[facets], first))

    def _add_bars(self, state: SheetState, kernel: BarKernel, step: Step) -> None:
        rows, sides = self._once(kernel, lambda: self._beside(kernel.conn))
        strain = kernel.beyond(self.results.member_deformation(kernel, step), step.lam)[rows]
        if kernel.natural(step.lam) is not None:
            state.natural[:] = np.nan  # of edges, not of facets
        line_force = kernel.EA[rows] * strain * kernel.rest_length[rows]  # force times length
        energy = self.results.member_energy(kernel, step)[rows]
        for facet, corner, share, chosen in sides:
            n = self.flat[facet, corner] / np.sqrt(self.surface.square[facet, corner])[:, None]
            dyad = n[:, :, None] * n[:, None, :]
            pull = (share * line_force[chosen] / self.area[facet])[:, None, None]
            np.add.at(state.force, facet, self._drawn(pull * dyad, facet))
            np.add.at(state.membrane_energy, facet, share * energy[chosen])

    def _add_hinges(self, state: SheetState, kernel: Kernel, step: Step) -> None:
        # the hinges of folds are no part of the sheet between them
        rows, sides = self._once(kernel, lambda: self._beside(kernel.conn[:, 1:3], folded=False))
        quads = kernel.conn[rows]
        moment = self.results.member_force(kernel, step)[rows]
        energy = self.results.member_energy(kernel, step)[rows]
        for facet, corner, share, chosen in sides:
            first = self.mesh.triangles[facet, corner] == quads[chosen, 0]
            rate = self._fold_rates_of(self.mesh.nodes[quads[chosen]], facet, first)
            work = share * moment[chosen] / self.area[facet]
            np.add.at(state.moment, facet, _tensor(rate, half_shear=True) * work[:, None, None])
            np.add.at(state.bending_energy, facet, share * energy[chosen])

    def _add_seams(self, state: SheetState, kernel: SeamHingeKernel, step: Step) -> None:
        """Hinges across the border of a periodic cell, with one facet on each side of it."""
        moment, energy = self.results.member_force(kernel, step), self.results.member_energy(kernel, step)
        area = self.area[kernel.facets]
        shares = (area / area.sum(axis=1, keepdims=True)).T
        for facet, share, first in zip(kernel.facets.T, shares, (True, False)):
            rate = self._fold_rates_of(self._places[kernel.conn], facet, np.full(len(facet), first))
            work = share * moment / self.area[facet]
            np.add.at(state.moment, facet, _tensor(rate, half_shear=True) * work[:, None, None])
            np.add.at(state.bending_energy, facet, share * energy)

    @cached_property
    def _places(self) -> Array:
        """Places (rows, 3) in the drawing: of the mesh, and of what stands behind the nodes."""
        rows = np.concatenate([self.results.rest, self.results.inner_rest])
        rows[: len(self.mesh.nodes)] = self.mesh.nodes
        return rows

    def _add_held_edges(self, state: SheetState, kernel: HeldEdgeKernel, step: Step) -> None:
        mesh = self.mesh
        facet = self._once(
            kernel, lambda: placed(np.sort(kernel.conn[:, :3], axis=1), np.sort(mesh.triangles, axis=1))
        )
        moment, energy = self.results.member_force(kernel, step), self.results.member_energy(kernel, step)
        turning = mesh.nodes[kernel.conn[kernel.turn_of[:, None], kernel.turn_at]]
        whole = turning[:, [0, 1, 2, 0]]  # the fold against the mirror image, laid out beyond the edge
        folding = kernel.conn[kernel.fold_of[:, None], kernel.fold_at]
        own = (folding[:, :1] == kernel.conn[kernel.fold_of, :3]).any(axis=1)  # whether the first wing is the facet's
        for member, weight, places, first in (
            (kernel.turn_of, 0.5 * kernel.turn_weight, whole, np.ones(len(whole), bool)),
            (kernel.fold_of, kernel.fold_weight, self._places[folding], own),
        ):
            rate = self._fold_rates_of(places, facet[member], first)
            work = weight * moment[member] / self.area[facet[member]]
            np.add.at(state.moment, facet[member], _tensor(rate, half_shear=True) * work[:, None, None])
        np.add.at(state.bending_energy, facet, energy)

    def _once(self, kernel: Kernel, lay_out: Callable[[], Any]) -> Any:
        """How the members of a kernel lie on the mesh, found when its first step is read."""
        if id(kernel) not in self._laid_out:
            self._laid_out[id(kernel)] = lay_out()
        return self._laid_out[id(kernel)]

    def _beside(self, ends: Index, folded: bool = True) -> tuple[Index, list[tuple[Index, Index, Array, Index]]]:
        """Which members with ends (n, 2) lie on edges of the mesh, if need be of folds, and the sides of these."""
        rows, edges = matched(np.sort(ends, axis=1), np.sort(self.mesh.edges, axis=1))
        chosen = folded | ~self.mesh.edge_folded[edges]
        return rows[chosen], self._sides(edges[chosen])

    def _sides(self, edges: Index) -> list[tuple[Index, Index, Array, Index]]:
        """For both sides of edges: facet, corner opposite, share in the area there, which of the edges these are."""
        mesh = self.mesh
        facets = mesh.edge_facets[edges]
        area = np.where(facets >= 0, self.area[facets], 0.0)
        found = []
        for side in (0, 1):
            chosen = np.flatnonzero(facets[:, side] >= 0)
            facet = facets[chosen, side]
            opposite = mesh.edge_wings[edges[chosen], side]
            corner = np.argmax(mesh.triangles[facet] == opposite[:, None], axis=1)
            found.append((facet, corner, area[chosen, side] / area[chosen].sum(axis=1), chosen))
        return found

    # ---- of the surface

    @cached_property
    def _bends_by_angles(self) -> bool:
        """Whether there are facets whose curvature only the angles at their edges tell."""
        known = np.zeros(len(self.area), dtype=bool)
        for kernel in self.surfaces:
            if not kernel.bends_by_folds:
                known[self._facets(kernel)[1]] = True
        return self.results.dim == 3 and not known.all()

    @cached_property
    def _curvature(self) -> tuple[CurvatureFit, Array]:
        """What makes curvature of positions, and that at rest."""
        fit = CurvatureFit(self.mesh)
        return fit, fit.tensor(self.results.rest[: len(self.mesh.nodes)])

    def _surface_curvature(self, step: Step) -> Array:
        """Change of curvature (m, 2, 2) in the axes of the facets that the angles at the edges make."""
        mesh, (fit, at_rest) = self.mesh, self._curvature
        rest, u = self.results.rest[: len(mesh.nodes)], step.u[: len(mesh.nodes)]
        if not self.results.linear:
            return np.asarray(fit.tensor(rest + u) - at_rest)
        largest = float(np.abs(u).max())
        share = min(1.0, SMALL * mesh.size / largest) if largest > 0 else 1.0
        ahead, back = (fit.tensor(rest + sign * share * u) for sign in (1, -1))
        return np.asarray(0.5 / share * (ahead - back))

    def _drawn(self, tensor: Array, facets: Index | slice = slice(None)) -> Array:
        """From the axes of facets laid out flat to those of the drawing."""
        turn = self.turn[facets]
        return np.asarray(turn.transpose(0, 2, 1) @ tensor @ turn)


def state_reader(results: Results, mesh: TriMesh) -> StateReader:
    """What reads the states of the sheet of some results; one for all who ask."""
    return results.once("state reader", lambda: StateReader(results, mesh))


def placed(given: Index, known: Index) -> Index:
    """Where the rows (n, k) of `given` are among those of `known` (m, k), -1 where they are not."""
    every, code = np.unique(np.concatenate([known, given]), axis=0, return_inverse=True)
    place = np.full(len(every), -1)
    place[code[: len(known)]] = np.arange(len(known))
    return np.asarray(place[code[len(known) :]])


def matched(given: Index, known: Index) -> tuple[Index, Index]:
    """Rows of `given` (n, k) that are rows of `known` (m, k), each the first of its kind, and where they are there."""
    place = placed(given, known)
    found, first = np.unique(place, return_index=True)
    return first[found >= 0], found[found >= 0]


def _tensor(components: Array, half_shear: bool = False) -> Array:
    """Symmetric tensors (n, 2, 2) of (xx, yy, xy), or of (xx, yy, 2 xy)."""
    xx, yy, xy = components.T
    xy = 0.5 * xy if half_shear else xy
    return np.stack([np.stack([xx, xy], axis=-1), np.stack([xy, yy], axis=-1)], axis=-2)
