"""How much of a structure has yielded at a stored step, or is strained beyond a yield stress where it stays elastic.

Elements that yield say so themselves. Where a sheet stays elastic, by choice, on a rung that cannot yield or in a
linear analysis, von Mises' stress that plate theory makes of the deformation is held against the yield stress of the
material at both faces of every facet.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from kirigami.errors import AnalysisError
from kirigami.primitives.kernel import Array, Kernel
from kirigami.results.results import Results
from kirigami.results.step import Event, Step

if TYPE_CHECKING:
    from kirigami.results.recovery import Recovery

BARS = ("bars", "hinges")


class YieldWatch:
    """Looks at the steps of one run, each when it is stored."""

    def __init__(self, results: Results) -> None:
        self.results = results
        self.kernels = [] if results.linear else [k for k in results.kernels if k.plastic() is not None]
        self.limit = self._limits()
        self.watched = self.limit is not None and bool(np.isfinite(self.limit).any())
        self.recovery: Recovery | None = None

    def _limits(self) -> Array | None:
        """Yield stress (m,) of the facets that stay elastic, infinite where they have none."""
        results = self.results
        mesh, constants = results.mesh, results.sheet_constants
        if mesh is None or constants is None:
            return None
        number, materials = constants.material_of_facets(len(mesh.triangles))
        by_elements = bool(self.kernels)
        known = [
            np.inf if m.yield_stress is None or (by_elements and m.yields) else m.yield_stress
            for m in materials
        ]
        return np.array(known, dtype=float)[number]

    @property
    def looks(self) -> bool:
        """Whether there is anything to look at."""
        return bool(self.kernels) or self.watched

    def share(self, step: Step) -> tuple[float, bool]:
        """Share of the area of the sheet, or of the members that can yield, and whether anything elastic is in it."""
        results = self.results
        flowed = [(kernel, _flowed(results, kernel, step)) for kernel in self.kernels]
        mesh = results.mesh
        if mesh is None:
            members = np.concatenate([on for _, on in flowed])
            return float(members.mean()), False
        from kirigami.results.sheet_state import matched  # a truss needs none

        over = np.zeros(len(mesh.triangles), dtype=bool)
        for kernel, on in flowed:
            if kernel.surface:
                rows, at = matched(kernel.conn[:, :3], mesh.triangles)
                over[at] |= on[rows]
            elif kernel.name in BARS:
                ends = kernel.conn if kernel.name == "bars" else kernel.conn[:, 1:3]
                rows, edges = matched(np.sort(ends, axis=1), np.sort(mesh.edges, axis=1))
                facets = mesh.edge_facets[edges[on[rows]]].ravel()
                over[facets[facets >= 0]] = True
        elastic = np.zeros_like(over)
        if self.watched and self.limit is not None:
            elastic = self._stress(step) > self.limit
        area = mesh.facet_areas
        return float(area[over | elastic].sum() / area.sum()), bool(elastic.any())

    def _stress(self, step: Step) -> Array:
        """Von Mises' stress (m,) of plate theory at the face where it is larger."""
        results = self.results
        from kirigami.results.recovery import BENDING, MEMBRANE, Recovery

        mesh, constants = results.mesh, results.sheet_constants
        assert mesh is not None and constants is not None
        if self.recovery is None:
            self.recovery = Recovery(results, mesh)
        felt = self.recovery.fields(step, self.recovery.state(step)).mean(axis=1)
        count = len(felt)
        half = 0.5 * constants.thickness_of_facets(count)[:, None]
        number, materials = constants.material_of_facets(count)
        elasticity = np.array([material.elasticity() for material in materials])[number]
        found = np.zeros(count)
        for z in (-half, half):
            stress = np.einsum("nab,nb->na", elasticity, felt[:, MEMBRANE] - z * felt[:, BENDING])
            xx, yy, xy = stress.T
            found = np.maximum(found, np.sqrt(xx**2 - xx * yy + yy**2 + 3 * xy**2))
        return found

    def event(self, step: Step, elastic: bool, before: Step | None) -> Event:
        """What to tell of the first step that is over."""
        lam = step.lam
        bracket = (lam if before is None else before.lam, lam)
        where = f"between load factors {bracket[0]:.6g} and {lam:.6g}" if before else f"at load factor {lam:.6g}"
        what = f"{100 * step.yielded:.3g} % of {'the sheet' if self.results.mesh is not None else 'the members'}"
        if elastic:
            message = f"strained beyond the yield stress {where}, but elastic in this run: {what}"
        else:
            message = f"first yield {where}: {what}"
        number = max(len(self.results.steps) - 1, 0)
        return Event("beyond yield" if elastic else "yield", 0.5 * sum(bracket), number, message, bracket)


def _flowed(results: Results, kernel: Kernel, step: Step) -> Array:
    strain = results.evaluate_at(kernel, step, lambda x: kernel.plastic())
    return np.asarray(strain > 0)


def yield_words(results: Results) -> list[str]:
    """A sentence on how far yield has gone, where there is any."""
    shares = np.nan_to_num(results.yielded)
    if not len(shares) or not shares.max() > 0:
        return []
    worst = int(shares.argmax())
    what = "the sheet" if results.mesh is not None else "the members that can yield"
    share, where = f"{100 * shares[worst]:.3g} % of {what}", f"step {worst}, load factor {results[worst].lam:.6g}"
    if any(event.kind == "beyond yield" for event in results.events):
        return [
            f"up to {share} is strained beyond the yield stress ({where}), but is elastic in this run: forces are too "
            "high there, and it would not spring back all the way"
        ]
    return [f"{share} has yielded ({where})"]


def facet_plastic_strain(results: Results, step: int | None = None) -> Array:
    """Accumulated plastic strain of each facet, where it is largest over the thickness.

    On rungs of bars and hinges it is the largest at the edges of a facet: that of a bar, and that of the faces at the
    plastic curvature of a hinge.

    Parameters
    ----------
    results : Results
        Of a model that was made from a mesh.
    step : int, optional
        Number of one stored step; None takes all of them.

    Returns
    -------
    ndarray, shape (s, facets), or (facets,) for one step
        Zero where nothing has yielded.

    Raises
    ------
    AnalysisError
        The model was not made from a mesh.
    ModelError
        No such step.

    Examples
    --------
    >>> from kirigami.results.yielding import facet_plastic_strain
    >>> import kirigami as kg
    >>> mesh = kg.TriMesh([(0, 0), (1, 0), (1, 1), (0, 1)], [(0, 1, 2), (0, 2, 3)])
    >>> soft = kg.Material(E=1e9, yield_stress=1e6, hardening=1e7)
    >>> m = kg.Model.from_mesh(mesh, thickness=0.01, material=soft, stiffness="shell")
    >>> left, right = m.select(boundary="left"), m.select(boundary="right")
    >>> held = m.add(kg.Fix(m.nodes, "z"), kg.Fix(left, "x"), kg.Fix(left[0], "y"), kg.Prescribe(right, x=0.01))
    >>> facet_plastic_strain(kg.DisplacementControl(m).run())[-1].round(3).tolist()  # strain less yield_stress / E
    [0.009, 0.009]
    """
    from kirigami.results.sheet_state import matched

    step = None if step is None else results.step_number(step, "plastic_strain")
    mesh = results.mesh
    if mesh is None:
        raise AnalysisError("plastic strain of facets needs a model made by Model.from_mesh", results=results)
    chosen = results.steps if step is None else [results.steps[step]]
    found = np.zeros((len(chosen), len(mesh.triangles)))
    kernels = [] if results.linear else [kernel for kernel in results.kernels if kernel.plastic() is not None]
    for row, one in zip(found, chosen):
        for kernel in kernels:
            strain = results.evaluate_at(kernel, one, lambda x: kernel.plastic())  # noqa: B023
            if kernel.surface:
                rows, at = matched(kernel.conn[:, :3], mesh.triangles)
                row[at] = np.maximum(row[at], strain[rows])
            elif kernel.name in BARS:
                ends = kernel.conn if kernel.name == "bars" else kernel.conn[:, 1:3]
                rows, edges = matched(np.sort(ends, axis=1), np.sort(mesh.edges, axis=1))
                own = strain[rows]
                if kernel.name == "hinges":
                    own = own * _face_strain(results)[edges]
                for side in (0, 1):
                    facets = mesh.edge_facets[edges, side]
                    np.maximum.at(row, facets[facets >= 0], own[facets >= 0])
    return found if step is None else found[0]


def _face_strain(results: Results) -> Array:
    """Plastic strain (edges,) of the faces of a sheet that bends by a unit of angle at an edge, in cylindrical
    bending: 2 / sqrt(3) t / 2 k with the curvature k = L / (A1 + A2)."""
    mesh, constants = results.mesh, results.sheet_constants
    assert mesh is not None and constants is not None
    count = len(mesh.triangles)
    both = mesh.edge_facets
    thick = np.append(constants.thickness_of_facets(count), -1.0)[both].max(axis=1)
    area = np.append(mesh.facet_areas, 0.0)[both].sum(axis=1)
    return np.asarray(thick / np.sqrt(3.0) * mesh.edge_lengths / area)
