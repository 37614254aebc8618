"""Where a mesh is too coarse: an estimate of the error of each facet, and the mesh sizes that follow from it.

The difference between the deformation and a smoother one (:mod:`kirigami.results.recovery`) in the norm of the elastic
energy, eta_f^2 = integral over the facet of t de : C : de / 2 + dk : D : dk / 2, is taken for the error.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from kirigami.errors import AnalysisError, ModelError
from kirigami.post.shape import check_flat
from kirigami.primitives.checks import require_instance, require_positive, require_whole
from kirigami.results.recovery import Recovery
from kirigami.results.results import Results
from kirigami.words import percent

if TYPE_CHECKING:
    from kirigami.geometry.mesh import TriMesh

Floats = NDArray[np.float64]

LARGEST_CHANGE = 4.0  # of a facet's edge length in one refinement
GRADING = 0.3  # increase of the wanted length per distance, as along cuts
EQUILATERAL = np.sqrt(3.0) / 4.0


@dataclass(frozen=True, eq=False)
class ErrorEstimate:
    """Estimated error of each facet at one step.

    Attributes
    ----------
    results : Results
        What the estimate is about.
    step : int
        Number of the step.
    facets : ndarray, shape (m,)
        Error of each facet in the norm of the energy, squared: an energy [force length].
    membrane, bending : ndarray, shape (m,)
        The two parts of `facets`.
    energy : float
        Elastic energy of the sheet [force length].

    Examples
    --------
    >>> import kirigami as kg, shapely
    >>> sheet = kg.Sheet(shapely.box(0, 0, 1, 1), shapely.LineString([(0.3, 0.5), (0.7, 0.5)]), 0.01, kg.Material(1e6))
    >>> m = kg.Model.from_mesh(sheet.mesh(0.1), dim=2)
    >>> top = m.select(boundary="top")
    >>> held = m.add(kg.Fix(m.select(boundary="bottom")), kg.Prescribe(top, x=0, y=1e-3))
    >>> estimate = kg.study.estimate_error(kg.LinearStatic(m).run())
    >>> 0.0 < estimate.relative < 0.3
    True
    >>> x, y = estimate.worst(1)[0]  # at a tip of the slit
    >>> bool(min(abs(x - 0.3), abs(x - 0.7)) < 0.05 and abs(y - 0.5) < 0.05)
    True
    """

    results: Results
    step: int
    facets: Floats
    membrane: Floats
    bending: Floats
    energy: float

    @property
    def relative(self) -> float:
        """Estimated error in the norm of the energy over that norm: the root of the energies' ratio."""
        total = float(self.facets.sum())
        return float(np.sqrt(total / (self.energy + total))) if total > 0 else 0.0

    @property
    def density(self) -> Floats:
        """Share of each facet (m,) in the squared error per share in the area; 1 everywhere is an ideal mesh's."""
        area = self._mesh.facet_areas
        total = float(self.facets.sum())
        density: Floats = self.facets / area * (area.sum() / total if total > 0 else 0.0)
        return density

    def worst(self, count: int = 5) -> Floats:
        """Places (count, 2) in the drawing of the facets with the largest errors, the largest first [length]."""
        count = require_whole(count, "count", "ErrorEstimate.worst", least=1)
        chosen = np.argsort(-self.facets)[:count]
        return np.asarray(self._mesh.nodes[self._mesh.triangles[chosen], :2].mean(axis=1))

    def size(
        self, nodes: int, order: float = 1.0, smallest: float | None = None
    ) -> Callable[[NDArray[np.float64]], NDArray[np.float64]]:
        """A wanted edge length for :meth:`kirigami.Sheet.mesh` that spreads the error evenly over the facets.

        The squared error of a facet goes with h^(2 order + 2), so that with as many facets as asked for each has the
        same error where h_new = c h eta^(-1 / (order + 1)). Lengths change by at most a factor of 4, and grow by at
        most 0.3 per distance.

        Parameters
        ----------
        nodes : int
            About how many nodes the new mesh is to have.
        order : float
            Order in h of the error in the norm of the energy; 1 for all facets.
        smallest : float, optional
            No wanted length is below this [length].

        Returns
        -------
        callable
            ``size(points)``, wanted lengths (n,) at points (n, 2). Mesh with a large ``max_edge`` and ``cut_edge``, as
            in ``sheet.mesh(0.2, cut_edge=0.2, size=estimate.size(2000))``.

        Raises
        ------
        ModelError
            A number of nodes or an order that is not positive, or no error to spread.
        """
        from scipy.spatial import KDTree

        nodes_wanted = require_positive(nodes, "nodes", "ErrorEstimate.size")
        order = require_positive(order, "order", "ErrorEstimate.size")
        mesh = self._mesh
        if not self.facets.sum() > 0:
            raise ModelError("ErrorEstimate.size: the estimated error is zero everywhere, any mesh will do")
        area = mesh.facet_areas
        now = np.sqrt(area / EQUILATERAL)
        # errors of single facets are noisy: take the mean over the facets around each node, and then of its nodes
        smooth = _interpolated(mesh.nodal_mean(self.facets[:, None]), mesh)[:, :, 0].mean(axis=1)
        smooth = np.maximum(smooth, 1e-12 * smooth.max())
        shape = now * smooth ** (-0.5 / (order + 1))
        centres = mesh.nodes[mesh.triangles, :2].mean(axis=1)
        tree = KDTree(centres)
        facets_wanted = 2.0 * nodes_wanted
        floor = 0.0 if smallest is None else require_positive(smallest, "smallest", "ErrorEstimate.size")
        near = tree.query(centres, k=min(60, len(centres)))

        def graded(factor: float) -> Floats:
            wanted: Floats = np.maximum(np.clip(factor * shape, now / LARGEST_CHANGE, now * LARGEST_CHANGE), floor)
            for _ in range(20):
                bounded = np.minimum(wanted, (wanted[near[1]] + GRADING * near[0]).min(axis=1))
                if np.allclose(bounded, wanted, rtol=1e-3):
                    break
                wanted = bounded
            return wanted

        low, high = 1e-3 * np.min(now / shape), 1e3 * np.max(now / shape)
        for _ in range(40):  # bisection for the number of facets
            middle = float(np.sqrt(low * high))
            if (area / (EQUILATERAL * graded(middle) ** 2)).sum() > facets_wanted:
                low = middle
            else:
                high = middle
        lengths = graded(float(np.sqrt(low * high)))

        def size(points: NDArray[np.float64]) -> NDArray[np.float64]:
            distance, nearest = tree.query(points, k=min(3, len(lengths)))
            weight = 1.0 / (distance + 1e-3 * now[nearest])
            return np.asarray((weight * lengths[nearest]).sum(axis=1) / weight.sum(axis=1))

        return size

    def plot(self, **options: Any) -> Any:
        """Draw the error per area on the sheet as drawn, over its mean, in powers of ten; options of `plot_results`."""
        values = np.log10(np.maximum(self.density, 1e-4))
        given = {"magnify": 0.0, "view": "top", "label": "log10 of error per area over its mean", **options}
        return self.results.plot(self.step, color=values, **given)

    def __str__(self) -> str:
        (x, y), *_ = self.worst(1)
        share = float(self.membrane.sum() / self.facets.sum()) if self.facets.sum() > 0 else 0.0
        return (
            f"estimated error in the energy norm {percent(self.relative)} ({100 * share:.0f} % of its square in "
            f"stretching), largest at ({x:.4g}, {y:.4g})"
        )

    @property
    def _mesh(self) -> TriMesh:
        assert self.results.mesh is not None
        return self.results.mesh


def estimate_error(results: Results, step: int = -1) -> ErrorEstimate:
    """Estimate where, and how much, a mesh is too coarse.

    Parameters
    ----------
    results : Results
        Results of a model made from a flat mesh, on any rung of accuracy.
    step : int
        Number of the stored step.

    Returns
    -------
    ErrorEstimate
        What discretisation adds to the energy; what a rung gets wrong on any mesh (such as the constants of "paper")
        is not seen. On "plate" and "facet" the curvature comes from angles between facets, which is smooth already, and
        its error comes out too small.

    Raises
    ------
    AnalysisError
        The model was not made from a mesh.
    ModelError
        No such step, or a mesh that is not flat.
    """
    require_instance(results, Results, "results", "estimate_error")
    step = require_whole(step, "step", "estimate_error")
    if results.mesh is None:
        raise AnalysisError("estimate_error needs a model made by Model.from_mesh", results=results)
    check_flat(results.mesh, "estimate_error")
    if results.thickness is None or results.material is None:
        raise ModelError("estimate_error: the thickness or the material of the sheet is unknown")
    step = results.step_number(step, "estimate_error")
    recovery = Recovery(results, results.mesh)
    state = recovery.state(results[step])
    fields = recovery.fields(results[step], state)
    membrane, bending = recovery.lost(results[step], fields)
    if state is not None:
        energy = float((state.membrane_energy + state.bending_energy).sum())
    else:
        energy = 0.5 * float(sum(part.sum() for part in recovery.work(fields, fields)))
    return ErrorEstimate(results, step, membrane + bending, membrane, bending, energy)


def _interpolated(nodal: Floats, mesh: TriMesh) -> Floats:
    """Values (m, 3, k) at the corners of the facets."""
    return np.asarray(nodal[mesh.triangles])
