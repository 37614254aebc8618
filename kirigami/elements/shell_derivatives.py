"""Derivatives of the energy of shell facets by the rows, a few facets after the other: all at once fill the memory."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from kirigami.elements.shell_bending import (
    AreaFrames,
    EdgeFrames,
    angle_derivatives,
    angle_second,
    area_frames,
    edge_frames,
)
from kirigami.elements.shell_geometry import EDGE_OF_POINT, by_measures, corner_fields, facet_vectors
from kirigami.primitives.kernel import EXACT, Array, Tangent

if TYPE_CHECKING:
    from kirigami.elements.shell_kernel import ShellFacetKernel

CHUNK = 512  # facets whose Hessians are made at a time, so that they stay in the processor's cache
SHARE = np.eye(3) + 1 / 3  # its square is 1 + the unit matrix: the mass of the barycentric coordinates


class Answer(NamedTuple):
    """What facets answer to strain and curvature at their corners: energy (n,), its derivatives (n, 3, 6), the tangent
    sections (n, 1 or 3, 6, 6) at the points inside, and which facets do so by another law than the elastic one."""

    energy: Array
    resultants: Array
    sections: Array
    own: NDArray[np.int64] | None = None


class _State(NamedTuple):
    """A chunk of facets: vectors v, frames and directors, and which facets they are."""

    vectors: Array
    area: AreaFrames
    edges: EdgeFrames
    directors: Array
    part: slice


def piece_by_piece(
    kernel: ShellFacetKernel, x: Array, lam: float, need: int, answer: Answer, tangent: Tangent = EXACT
) -> Iterator[tuple[slice, Array, Array | None]]:
    """Which facets, their gradient and, where needed, their Hessian blocks."""
    _, resultants, sections, own = answer
    pull, bend = _by_measures(kernel, resultants)
    geometric = pull
    if tangent.ahead is not None and need == 2:
        geometric = _pull_ahead(kernel, *tangent.ahead, lam)
        if own is not None:  # what yields pumps up no false stress
            geometric[:, own] = pull[:, own]
    for state in _chunks(kernel, x):
        part = state.part
        membrane, bending = _chains(kernel, state)
        local = _local_forces(membrane, bending, pull, bend, part)
        blocks = None
        if need == 2:
            forces = geometric[:, part], bend[:, part]
            blocks = _hessian(kernel, state, membrane, bending, *forces, sections[part], tangent)
        yield part, _to_rows(local), blocks


def pulled_back(kernel: ShellFacetKernel, x: Array, resultants: Array) -> Array:
    """Forces on the rows (n, 9, 3) by derivatives (n, 3, 6) of an energy by strain and curvature at the corners."""
    gradient = np.empty((len(kernel.conn), 9, 3))
    pull, bend = _by_measures(kernel, resultants)
    for state in _chunks(kernel, x):
        gradient[state.part] = _to_rows(_local_forces(*_chains(kernel, state), pull, bend, state.part))
    return gradient


def _by_measures(kernel: ShellFacetKernel, resultants: Array) -> tuple[Array, Array]:
    """Derivatives of an energy by the membrane measures (9, n) and the bending measures (15, n)."""
    pull = by_measures(kernel._membrane.to_strain, resultants[..., :3])
    return pull, by_measures(kernel._bending.to_curvature, resultants[..., 3:])


def _chunks(kernel: ShellFacetKernel, x: Array) -> Iterator[_State]:
    vectors, directors = kernel._vectors(x)[0], kernel._local_directors()
    for start in range(0, len(kernel.conn), CHUNK):
        part = slice(start, start + CHUNK)
        v = vectors[..., part]
        yield _State(v, area_frames(v), edge_frames(v), directors[..., part], part)


def _local_forces(membrane: Array, bending: Array, pull: Array, bend: Array, part: slice) -> Array:
    """Derivatives (m, 24) by the vectors v and the stored angles."""
    local = np.einsum("mzn,mn->nz", bending, bend[:, part])
    local[:, :15] += np.einsum("mzn,mn->nz", membrane, pull[:, part])
    return np.asarray(local)


def _pull_ahead(kernel: ShellFacetKernel, x: Array, change: Array, lam: float) -> Array:
    """Membrane forces by the measures (9, n) after a linear step `change` off `x`."""
    vectors, moved = kernel._vectors(x)
    rate = np.empty((9, len(kernel.conn)))
    ahead = facet_vectors(change, kernel.conn)
    for start in range(0, len(kernel.conn), CHUNK):
        part = slice(start, start + CHUNK)
        chain = kernel._membrane.derivatives(vectors[..., part], part)
        rate[:, part] = np.einsum("mpan,pan->mn", chain, ahead[..., part])
    fields = np.zeros((len(kernel.conn), 3, 6)) if not kernel.coupled else kernel._fields(x)
    fields[..., :3] = corner_fields(kernel._membrane.to_strain, kernel._membrane.measures(moved) + rate)
    return by_measures(kernel._membrane.to_strain, kernel._resultants(kernel._elastic(fields, lam))[..., :3])


def _chains(kernel: ShellFacetKernel, state: _State) -> tuple[Array, Array]:
    """First derivatives of the membrane measures by v, (9, 15, m), and of the bending measures by v and the stored
    angles, (15, 24, m)."""
    m = state.vectors.shape[-1]
    membrane = kernel._membrane.derivatives(state.vectors, state.part).reshape(9, 15, m)
    bending = np.zeros((15, 24, m))
    inside = kernel._bending.curvature_derivatives(state.vectors, state.area, state.part)
    bending[:9, :15] = inside.reshape(9, 15, m)
    bending[9:, :15] = angle_derivatives(state.edges, state.directors).reshape(6, 15, m)
    point, facet = np.indices((6, m))
    column = 15 + 3 * EDGE_OF_POINT[:, None] + kernel._stored[:, state.part]
    bending[9 + point, column, facet] = -kernel._angle_scale[:, state.part]
    return membrane, bending


def _hessian(
    kernel: ShellFacetKernel, state: _State, membrane: Array, bending: Array, pull: Array, bend: Array, sections: Array,
    tangent: Tangent,
) -> Array:  # fmt: skip
    part, m = state.part, membrane.shape[-1]
    exact = 1.0 - tangent.convexity
    rows = np.zeros((m, 3, 6, 24))
    rows[:, :, :3, :15] = (kernel._membrane.to_strain[part] @ membrane.transpose(2, 0, 1)).reshape(m, 3, 3, 15)
    rows[:, :, 3:] = (kernel._bending.to_curvature[part] @ bending.transpose(2, 0, 1)).reshape(m, 3, 3, 24)
    rows = (SHARE @ rows.reshape(m, 3, -1)).reshape(m, 3, 6, 24)
    stiff = (sections * (kernel.chart.area[part] / 12)[:, None, None, None]) @ rows
    total = rows.reshape(m, 18, 24).transpose(0, 2, 1) @ stiff.reshape(m, 18, 24)
    form = kernel._membrane.second_derivatives(exact * pull, part)
    if tangent.convexity:
        form += tangent.convexity * kernel._membrane.tension_form(pull, part)
    curved = (form.reshape(25, m)[:, None, None] * np.eye(3)[:, :, None]).reshape(25, 3, 3, m)
    if exact:
        bend = exact * bend
        curved += kernel._bending.curvature_second(bend[:9], state.vectors, state.area, part)
        curved += angle_second(bend[9:], state.edges, state.directors)
    total[:, :15, :15] += curved.reshape(5, 5, 3, 3, m).transpose(4, 0, 2, 1, 3).reshape(m, 15, 15)
    return _to_blocks(total)


def _to_rows(local: Array) -> Array:
    """From derivatives (n, 24) by the vectors v and the stored angles to those by the rows, (n, 9, 3)."""
    rows = np.empty((len(local), 9, 3))
    rows[:, 1:] = local.reshape(-1, 8, 3)
    rows[:, 0] = -rows[:, 1] - rows[:, 2]
    return rows


def _to_blocks(local: Array) -> Array:
    """The same for second derivatives (n, 24, 24): blocks (n, 9, 9, 3, 3)."""
    blocks = np.empty((len(local), 9, 9, 3, 3))
    blocks[:, 1:, 1:] = local.reshape(-1, 8, 3, 8, 3).transpose(0, 1, 3, 2, 4)
    blocks[:, 0, 1:] = -blocks[:, 1, 1:] - blocks[:, 2, 1:]
    blocks[:, :, 0] = -blocks[:, :, 1] - blocks[:, :, 2]
    return blocks
