"""The residual of stored steps a second time, from the objects of a model alone; no formula of the package is used."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

import kirigami as kg

Floats = NDArray[np.float64]


def residuals(m: kg.Model, results: kg.Results) -> list[float]:
    """Relative residual of every stored step from the objects of the model: energies differentiated by complex steps.

    Bars have the energy EA L e^2 / 2 with e the Green strain, hinges k (theta - theta_0)^2 / 2 with the cosine and
    sine of theta from the normals of the wings. The slope of a clamped edge is that of its only facet.
    """
    rest = m.positions()
    bars = [item for item in m.elements if isinstance(item, kg.Bar)]
    hinges = [item for item in m.elements if isinstance(item, kg.BendHinge)]
    ends = np.array([m.index(bar.nodes) for bar in bars])
    corners = np.array([m.index(hinge.nodes) for hinge in hinges])
    EA, rigidity = np.array([bar.EA for bar in bars]), np.array([hinge.stiffness for hinge in hinges])
    span = rest[ends[:, 1]] - rest[ends[:, 0]]
    length = np.linalg.norm(span, axis=1)
    clamps, clamp_rigidity = _clamped_edges(m)
    free = np.ones(rest.shape, dtype=bool)
    prescribed = np.zeros(rest.shape)
    for item in m.constraints:
        for axis, values in item.values.items():
            at = m.index(item.group), "xyz".index(axis)
            free[at] = False
            prescribed[at] = 0.0 if item.constant else values
    rest_angle = _angle(rest[corners])
    found = []
    angle, slope = rest_angle, np.zeros(len(clamps))
    for step in results.steps:
        if not np.isfinite(step.u).all() or np.abs(step.u - step.lam * prescribed)[~free].max() > 1e-12:
            return [np.inf]
        force, squares = np.zeros(rest.shape), 0.0
        change = step.u[ends[:, 1]] - step.u[ends[:, 0]]
        strain = (np.einsum("na,na->n", span, change) + 0.5 * np.einsum("na,na->n", change, change)) / length**2
        pull = (EA * strain / length)[:, None] * (span + change)
        parts = [(ends, np.stack([-pull, pull], axis=1))]
        points = (rest + step.u)[corners]
        angle = _unwrapped(_angle(points), angle)
        turning = _angle_gradient(points)
        parts.append((corners, (rigidity * (angle - rest_angle))[:, None, None] * turning))
        if len(clamps):
            # the mirror image of the facet stands still next to an edge that moves without turning
            points = _with_mirror_image(rest[clamps], step.u[clamps])
            slope = _unwrapped(_angle(points), slope)
            gradient = _angle_gradient(points)
            gradient[:, 1] += gradient[:, 3]
            parts.append((clamps, (clamp_rigidity * slope)[:, None, None] * gradient[:, :3]))
        for nodes, gradient in parts:
            np.add.at(force, nodes, gradient)
            squares += float((gradient**2).sum())
        unbalanced = float(np.linalg.norm(force[free]))
        # What rounding alone may leave: a strain, and an angle whose corners are places as large as the sheet.
        blur = np.finfo(float).eps * np.abs(rest).max()
        rounding = 2e-15 * float(np.linalg.norm(EA))
        rounding += blur * float(np.linalg.norm(rigidity * (turning**2).sum(axis=(1, 2))))
        found.append(unbalanced / np.sqrt(squares) if unbalanced > rounding else 0.0)
    return found


def _angle(points: NDArray[Any]) -> Floats:
    """Fold angle (n,) of hinges (n, 4, 3), nodes i, j, k, l: 0 when flat."""
    cosine, sine = _cosine_and_sine(points)
    return np.arctan2(sine, cosine)


def _cosine_and_sine(points: NDArray[Any]) -> tuple[NDArray[Any], NDArray[Any]]:
    """Cosine and sine of the angle between the normals of the wings, both times the same factor."""
    i, j, k, l = points.swapaxes(0, 1)
    edge = k - j
    one, other = np.cross(edge, i - j), np.cross(l - j, edge)
    size = np.sqrt((edge * edge).sum(axis=1))
    return (one * other).sum(axis=1), (np.cross(one, other) * edge).sum(axis=1) / -size


def _angle_gradient(points: Floats) -> Floats:
    """Derivative (n, 4, 3) of the angle by complex steps, which leave no difference to round."""
    cosine, sine = _cosine_and_sine(points)
    gradient = np.empty(points.shape)
    for node in range(4):
        for axis in range(3):
            moved = points.astype(complex)
            moved[:, node, axis] += 1e-30j
            by_cosine, by_sine = (part.imag / 1e-30 for part in _cosine_and_sine(moved))
            gradient[:, node, axis] = (cosine * by_sine - sine * by_cosine) / (cosine**2 + sine**2)
    return gradient


def _unwrapped(angle: Floats, before: Floats) -> Floats:
    return angle + 2 * np.pi * np.round((before - angle) / (2 * np.pi))


def _clamped_edges(m: kg.Model) -> tuple[NDArray[np.int64], Floats]:
    """Wing and ends (n, 3) of boundary edges within a clamped group, and D L^2 / A of each."""
    assert m.mesh is not None and m.mesh.material is not None and m.mesh.thickness is not None
    mesh, material = m.mesh, m.mesh.material
    rigidity = material.E * mesh.thickness**3 / (12 * (1 - material.nu**2))
    rows = []
    for group in (m.index(item.group) for item in m.constraints if item.clamp):
        rows += [k for k in np.flatnonzero(mesh.edge_facets[:, 1] < 0) if np.isin(mesh.edges[k], group).all()]
    edges = np.array(sorted(set(rows)), dtype=np.int64)
    area = mesh.facet_areas[mesh.edge_facets[edges, 0]]
    nodes = np.column_stack([mesh.edge_wings[edges, 0], mesh.edges[edges]])
    return nodes, rigidity * mesh.edge_lengths[edges] ** 2 / area


def _with_mirror_image(rest: Floats, u: Floats) -> Floats:
    """Facets (n, 3, 3) at displacements, with their mirror images at rest carried along by the edge."""
    i, j, k = rest.swapaxes(0, 1)
    edge = k - j
    foot = j + edge * (((i - j) * edge).sum(axis=1) / (edge**2).sum(axis=1))[:, None]
    return np.concatenate([rest + u, (2 * foot - i + u[:, 1])[:, None]], axis=1)
