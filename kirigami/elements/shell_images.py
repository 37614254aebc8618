"""Mirror planes of shells: the rest state at a plane is that of the sheet together with its image."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from kirigami.primitives.kernel import Array
from kirigami.primitives.node import AXES
from kirigami.primitives.parts import Numbering

Index = NDArray[np.int64]
IN_PLANE = 1e-9  # distance from a mirror plane, over the size of the structure, that is none


class Images:
    """A sheet of shell facets with its images in the mirror planes of a model, one plane after the other.

    Attributes
    ----------
    points : ndarray, shape (p, 3)
        Nodes, then their images.
    triangles : ndarray of int, shape (k m, 3)
        Facets, then their images, which run the other way round.
    normals : list
        Given normals (3, 3) at the corners of each, or None.
    planes : list of (int, ndarray of int)
        Axis of each mirror plane, and the nodes in it.
    """

    def __init__(self, numbering: Numbering, triangles: Index, normals: list[Any]) -> None:
        self.points, self.triangles, self.normals = numbering.rest, triangles, list(normals)
        self.planes = mirror_planes(numbering)
        for axis, nodes in self.planes:
            self._reflect(axis, nodes, numbering.size)

    def _reflect(self, axis: int, nodes: Index, size: float) -> None:
        place = self.points[nodes[0], axis]
        beyond = np.abs(self.points[:, axis] - place) > IN_PLANE * size
        image = np.arange(len(self.points))
        image[beyond] = len(self.points) + np.arange(int(beyond.sum()))
        turned = self.points[beyond].copy()
        turned[:, axis] = 2 * place - turned[:, axis]
        self.points = np.concatenate([self.points, turned])
        self.triangles = np.concatenate([self.triangles, image[self.triangles][:, [0, 2, 1]]])
        flip = np.ones(3)
        flip[axis] = -1.0
        self.normals += [None if given is None else (given * flip)[[0, 2, 1]] for given in self.normals]

    def edges(self, known: Index) -> tuple[Index, Index]:
        """Edges (k m, 3) of all facets, numbered so that those of the first facets keep their `known` (m, 3) numbers;
        and which of the known edges each is or is an image of."""
        count = int(known.max()) + 1
        following = np.roll(self.triangles, -1, axis=1)
        pairs = np.sort(np.stack([self.triangles, following], axis=2).reshape(-1, 2), axis=1)
        ends, place = np.unique(pairs, axis=0, return_inverse=True)
        place = place.ravel()
        number = np.full(len(ends), -1)
        number[place[: known.size]] = known.ravel()
        new = np.flatnonzero(number < 0)
        number[new] = count + np.arange(len(new))
        edge = number[place].reshape(-1, 3)
        source = np.empty(count + len(new), np.int64)
        of_facets = known
        while len(of_facets) < len(edge):  # corners 0, 2, 1: edges 01, 12, 20 of an image are 20, 12, 01 of the facet
            of_facets = np.concatenate([of_facets, of_facets[:, [2, 1, 0]]])
        source[edge.ravel()] = of_facets.ravel()
        source[: count] = np.arange(count)
        return edge, source


def mirror_planes(numbering: Numbering) -> list[tuple[int, Index]]:
    """Axis of each mirror plane of a model, and the nodes in it."""
    found = [item for items in numbering.objects.values() for item in items if item.mirror]
    return [(AXES.index(item.mirror), numbering.index(item.group)) for item in found]


def plane_normals(planes: list[tuple[int, Index]], ends: Index, edge: Index) -> Array | None:
    """Normal (m, 3, 3) of the mirror plane that each edge of a facet lies in, zero where there is none."""
    if not planes:
        return None
    found = np.zeros((len(ends), 3))
    for axis, nodes in planes:
        found[np.isin(ends, nodes).all(axis=1) & (np.bincount(edge.ravel(), minlength=len(ends)) == 1), axis] = 1.0
    return np.asarray(found[edge])
