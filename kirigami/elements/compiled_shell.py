"""The compiled twin of shell facets, for Numba (extra "fast")."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from kirigami.elements import shell_lanes, shell_loops, shell_sections
from kirigami.elements.compiled_yield import CompiledLayers
from kirigami.elements.shell_derivatives import SHARE
from kirigami.elements.shell_lane_rows import LANES
from kirigami.primitives.kernel import Array, CompiledKernel, Configuration, Tangent, displacement_of
from kirigami.primitives.processors import processors

if TYPE_CHECKING:
    from kirigami.elements.shell_kernel import ShellFacetKernel
    from kirigami.elements.shell_yield import YieldingShellKernel

Index = NDArray[np.int64]
NOTHING = np.empty((0, 6))
NONE = np.empty(0, np.int64), np.empty((0, 18)), np.empty((0, 3, 6, 6))  # no facet that answers by another law
MANY = 4000  # facets from which on threads gain more than they cost


class CompiledShell(CompiledKernel):
    """Twin of :class:`kirigami.elements.shell_kernel.ShellFacetKernel`, with each facet's numbers side by side."""

    _kernel: ShellFacetKernel

    def __init__(self, kernel: ShellFacetKernel) -> None:
        self._kernel = kernel
        membrane, bending = kernel._membrane, kernel._bending
        self._rest = _by_facet(kernel._rest_vectors)
        self._membrane = _by_facet(membrane.per_square), _by_facet(membrane.mean_forms)
        self._matrices = np.ascontiguousarray(membrane.to_strain), np.ascontiguousarray(bending.to_curvature)
        self._section = (
            _by_facet(bending.second), np.ascontiguousarray(kernel.section), kernel.chart.area,
            _by_facet(kernel._rest_angles), _by_facet(kernel._rest_curvatures),
        )  # fmt: skip
        self._stored, self._scale = _by_facet(kernel._stored), _by_facet(kernel._angle_scale)
        root = _root(kernel.section, kernel.chart.area)
        stretch, couple, bend = _weighted(root, membrane.to_strain, bending.to_curvature)
        lanes = (
            *map(_in_lanes, (kernel._rest_vectors, membrane.per_square, membrane.mean_forms, stretch)),
            _in_lanes(couple) if kernel.coupled else np.empty((0, 9, 15, LANES)),
            *map(_in_lanes, (bend, bending.second, kernel._rest_angles, kernel._rest_curvatures)),
        )
        self._lanes = (*lanes, _in_lanes(kernel._angle_scale))
        self._tangents = _in_lanes(np.moveaxis(kernel.chart.tangent, 0, -1))

    @cached_property
    def _root(self) -> Array:
        return _root(self._kernel.section, self._kernel.chart.area)

    def _at(self, x: Array, lam: float) -> tuple[Any, ...]:
        """What the loops in lanes are given."""
        kernel = self._kernel
        u = np.ascontiguousarray(displacement_of(x, kernel.rest), dtype=float)
        return (
            kernel.conn, np.ascontiguousarray(x, dtype=float), u, self._lanes, kernel._directors, kernel._edge,
            kernel._stored, self._released(lam),
        )  # fmt: skip

    def _one_by_one(self, x: Array, lam: float) -> tuple[Any, ...]:
        """What loops that take one facet after the other are given."""
        kernel = self._kernel
        u = np.ascontiguousarray(displacement_of(x, kernel.rest), dtype=float)
        directors = _by_facet(kernel._local_directors())
        return (
            kernel.conn, np.ascontiguousarray(x, dtype=float), u, self._rest, *self._membrane, *self._matrices,
            *self._section, directors, self._stored, self._scale, self._natural(lam),
        )  # fmt: skip

    def _natural(self, lam: float) -> Array:
        natural = self._kernel.natural(lam)
        return NOTHING if natural is None else np.ascontiguousarray(natural)

    def _released(self, lam: float) -> Array:
        """What facets bear nothing at, weighted as the measures are, in lanes (count, 18, LANES), or nothing."""
        natural = self._natural(lam)
        if not len(natural):
            return np.empty((0, 18, LANES))
        # it is the same at all corners, so that each row of SHARE counts as its sum
        weighted = SHARE[0].sum() * np.einsum("nab,nb->an", self._root, natural)
        return np.asarray(_in_lanes(np.concatenate([np.tile(part, (3, 1)) for part in (weighted[:3], weighted[3:])])))

    def _side_by_side(self, work: Callable[[int, int, Array], float | None], count: int, total: Array) -> float:
        """Let threads add a part of `count` pieces each to `total`; the same for a given number of threads."""
        threads = processors() if len(self._kernel.conn) >= MANY else 1
        bounds = np.linspace(0, count, threads + 1).astype(np.int64).tolist()
        if threads == 1:
            return float(work(0, count, total) or 0.0)
        targets = [total, *(np.zeros_like(total) for _ in range(threads - 1))]
        with ThreadPoolExecutor(threads) as pool:
            found = list(pool.map(work, bounds[:-1], bounds[1:], targets))
        for target in targets[1:]:
            total += target
        return float(sum(value or 0.0 for value in found))

    def _answers(self, x: Array, lam: float, tangent: bool) -> tuple[Index, Array, Array]:
        """Which facets answer by a law of their own, as places (n,) or nothing, with derivatives by the fields (k, 18)
        and sections (k, 3, 6, 6)."""
        return NONE

    def energy(self, x: Configuration, lam: float) -> float:
        return float(shell_lanes.energy(*self._at(x, lam), 0, len(self._tangents)))

    def add_forces(self, x: Configuration, lam: float, total: Array) -> float:
        state = *self._at(x, lam), *self._answers(x, lam, False)[:2], *self._matrices
        return self._side_by_side(
            lambda first, last, target: shell_lanes.forces(*state, first, last, target), len(self._tangents), total
        )

    def add_blocks(self, x: Configuration, lam: float, tangent: Tangent, slots: Index, blocks: Array) -> None:
        kernel, ahead = self._kernel, np.empty((0, 9))
        convexity = float(tangent.convexity)
        if tangent.ahead is not None:
            start, change = tangent.ahead
            u = np.ascontiguousarray(displacement_of(start, kernel.rest), dtype=float)
            curvature = np.ascontiguousarray(kernel.curvature(start)) if kernel.coupled else np.zeros((len(u), 3, 3))
            ahead = np.empty((len(kernel.conn), 9))
            shell_loops.pull_ahead(
                kernel.conn, u, np.ascontiguousarray(change, dtype=float), self._rest, *self._membrane,
                self._matrices[0], self._section[1], self._section[2], curvature, self._natural(lam), ahead,
            )  # fmt: skip
        place, answers, sections = self._answers(x, lam, True)
        *state, released = self._at(x, lam)

        def work(first: int, last: int, target: Array) -> None:
            shell_lanes.blocks(*state, self._tangents, released, place, first, last, ahead, convexity, slots, target)

        self._side_by_side(work, len(self._tangents), blocks)
        if not len(place):
            return
        facets = np.flatnonzero(place >= 0)  # in the order of their answers
        second, _, area = self._section[:3]
        described = (
            facets, answers, sections, kernel.conn, state[2], self._rest, *self._membrane, *self._matrices, second,
            area, _by_facet(kernel._local_directors()), self._stored, self._scale,
        )  # fmt: skip

        def one_by_one(first: int, last: int, target: Array) -> None:
            shell_sections.blocks(*described, first, last, kernel.chart.tangent, convexity, slots, target)

        self._side_by_side(one_by_one, len(facets), blocks)


class CompiledYieldingShell(CompiledShell):
    """Twin of :class:`kirigami.elements.shell_yield.YieldingShellKernel`."""

    _kernel: YieldingShellKernel

    def __init__(self, kernel: YieldingShellKernel) -> None:
        super().__init__(kernel)
        own = kernel.layers
        self._layers = CompiledLayers(own.thickness, own.E, own.nu, own.hardening)

    def energy(self, x: Configuration, lam: float) -> float:
        return CompiledKernel.energy(self, x, lam)  # layers that have flown store other energies

    def _answers(self, x: Array, lam: float, tangent: bool) -> tuple[Index, Array, Array]:
        kernel = self._kernel
        fields = np.empty((len(kernel.conn), 3, 6))
        shell_loops.fields_at(*self._one_by_one(x, lam), fields.reshape(-1, 18))
        flown = kernel.flow(fields, tangent, self._layers)
        if not len(flown.facets):
            return NONE
        place = np.full(len(kernel.conn), -1)
        place[flown.facets] = np.arange(len(flown.facets))
        section = NONE[2] if flown.section is None else np.ascontiguousarray(flown.section)
        return place, flown.at_corners.reshape(-1, 18), section


def _by_facet(values: Any) -> Any:
    """The facets' numbers side by side: the last axis first, in memory too."""
    return np.ascontiguousarray(np.moveaxis(values, -1, 0))


def _in_lanes(values: Any) -> Any:
    """Numbers (..., n) of the facets in batches (count, ..., LANES); the last one is repeated to fill its batch."""
    more = [(0, 0)] * (values.ndim - 1) + [(0, -values.shape[-1] % LANES)]
    filled = np.pad(values, more, mode="edge")
    return np.ascontiguousarray(np.moveaxis(filled.reshape(*values.shape[:-1], -1, LANES), -2, 0))


def _root(section: Array, area: Array) -> Array:
    """Matrices (n, 6, 6), upper triangles, whose squares are the sections by the area over 12."""
    return np.asarray(np.linalg.cholesky(section).transpose(0, 2, 1) * np.sqrt(area / 12)[:, None, None])


def _weighted(root: Array, to_strain: Array, to_curvature: Array) -> tuple[Array, Array, Array]:
    """Matrices (9, k, n) from the measures to numbers whose squares are twice the energy: stretch and couple add up
    to nine of them, bend makes the other nine."""

    def weighted(part: Array, fields: Array) -> Array:
        at_corners = part[:, None] @ fields.reshape(len(part), 3, 3, -1)
        shared = SHARE @ at_corners.reshape(len(part), 3, -1)
        return np.asarray(shared.reshape(len(part), 9, -1).transpose(1, 2, 0))

    return (
        weighted(root[:, :3, :3], to_strain), weighted(root[:, :3, 3:], to_curvature),
        weighted(root[:, 3:, 3:], to_curvature),
    )  # fmt: skip
