"""Stress of a sheet, facet by facet: membrane strain, curvature, and what plane stress makes of them.

Everything is counted from the rest state (an imperfection is stress-free) and given in the axes x, y of the drawing,
which turn with the facet: second Piola-Kirchhoff stress and Green strain, the common ones as long as strains are small.

* Membrane strain: the Green strains of the three edges of a facet determine its strain; uniform strain is exact. For
  curved facets the edges are the curved ones, so that bending does not count as stretch.
* Curvature K, second derivatives of the height, positive where the sheet is hollow from above: of curved facets the
  mean over the facet of its own slope field, of all others the least-squares fit of
  :func:`kirigami.post.curvature.curvature`.
* Kirchhoff's plate: strain at distance z from the middle is strain - z K, and stress = E / (1 - nu^2) times
  ((1 - nu) strain + nu trace(strain) I). Force per length N = t stress of the middle, moment per length
  M = D ((1 - nu) K + nu trace(K) I), D = E t^3 / (12 (1 - nu^2)). (Timoshenko and Woinowsky-Krieger, 1959.)

On a cylinder of radius R the faces have E t / (2 R (1 - nu^2)) round it and nu times that along it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from kirigami.elements.curved_facet import CORNER_OF_SLOPE, EDGE_OF_SLOPE, CurvedFacetKernel
from kirigami.elements.triangle import ENDS, STARTS, edge_vectors, flat_edges, strain_from_edges
from kirigami.errors import AnalysisError, ModelError
from kirigami.post.curvature import FLAT, curvature
from kirigami.primitives.checks import require_positive
from kirigami.primitives.kernel import Configuration
from kirigami.primitives.material import Material

if TYPE_CHECKING:
    from kirigami.geometry.mesh import TriMesh
    from kirigami.results.results import Results

Floats = NDArray[np.float64]

FIBRES = {"bottom": -0.5, "middle": 0.0, "top": 0.5}  # place over the thickness
SMALL = 1e-4  # displacement over size from which the rate of strain of a linear analysis is taken


@dataclass(frozen=True, eq=False)
class SheetStress:
    """Stress and deformation of every facet, in the axes x and y of the drawing.

    Leading axes of all arrays are (s, m), steps and facets, or (m,) for one step.

    Attributes
    ----------
    strain : ndarray, shape (s, m, 2, 2)
        Green strain of the middle surface.
    curvature : ndarray, shape (s, m, 2, 2)
        Curvature [1 / length], positive where the sheet is hollow from above.
    area : ndarray, shape (m,)
        Areas of the facets at rest [length^2].
    thickness : float
        Sheet thickness [length].
    material : Material
        Elastic constants.

    Examples
    --------
    >>> import kirigami as kg
    >>> mesh = kg.Sheet([(0, 0), (2, 0), (2, 1), (0, 1)]).mesh(0.5)
    >>> m = kg.Model.from_mesh(mesh, thickness=0.01, material=kg.Material(E=1e6, nu=0.3), stiffness="split")
    >>> left, right = m.select(boundary="left"), m.select(boundary="right")
    >>> held = m.add(kg.Fix(left, "xz"), kg.Fix(left[0], "y"), kg.Fix(right, "z"), kg.Prescribe(right, x=2e-3))
    >>> stress = kg.LinearStatic(m).run().stress(-1)
    >>> bool(np.allclose(stress.principal(), (1e3, 0), atol=1e-3))
    True
    >>> stress.force.shape == (len(mesh.triangles), 2, 2)
    True
    """

    strain: Floats
    curvature: Floats
    area: Floats
    thickness: float
    material: Material

    def tensor(self, fibre: str = "middle") -> Floats:
        """Stress tensor (s, m, 2, 2) [force / length^2].

        Parameters
        ----------
        fibre : {"middle", "top", "bottom"}
            Where in the thickness; the top is the face seen from above.

        Raises
        ------
        ModelError
            Another name of a fibre.
        """
        if fibre not in FIBRES:
            raise ModelError(f"stress: fibre must be one of {', '.join(FIBRES)}, got {fibre!r}")
        strain = self.strain - FIBRES[fibre] * self.thickness * self.curvature
        return self.material.E / (1 - self.material.nu**2) * self._law(strain)

    def principal(self, fibre: str = "middle") -> Floats:
        """Principal stresses (s, m, 2), the algebraically larger first [force / length^2]; fibres as in `tensor`."""
        stress = self.tensor(fibre)
        mean = 0.5 * (stress[..., 0, 0] + stress[..., 1, 1])
        radius = np.hypot(0.5 * (stress[..., 0, 0] - stress[..., 1, 1]), stress[..., 0, 1])
        return np.stack([mean + radius, mean - radius], axis=-1)

    def directions(self, fibre: str = "middle") -> Floats:
        """Unit vectors (s, m, 2, 2) of the principal stresses in the drawing, one a row, as in `principal`."""
        stress = self.tensor(fibre)
        angle = 0.5 * np.arctan2(2 * stress[..., 0, 1], stress[..., 0, 0] - stress[..., 1, 1])
        first = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
        second = np.stack([-first[..., 1], first[..., 0]], axis=-1)
        return np.stack([first, second], axis=-2)

    def von_mises(self, fibre: str = "middle") -> Floats:
        """Von Mises' equivalent stress (s, m) of plane stress [force / length^2]; fibres as in `tensor`."""
        first, second = np.moveaxis(self.principal(fibre), -1, 0)
        return np.asarray(np.sqrt(first**2 - first * second + second**2))

    @property
    def force(self) -> Floats:
        """Membrane force per length (s, m, 2, 2) [force / length]."""
        return self.thickness * self.tensor()

    @property
    def moment(self) -> Floats:
        """Bending moment per length (s, m, 2, 2) [force], positive where it makes the sheet hollow from above."""
        return self._rigidity * self._law(self.curvature)

    @property
    def membrane_energy(self) -> Floats:
        """Energy of stretching of each facet (s, m) [force length]."""
        return np.asarray(0.5 * self.area * (self.force * self.strain).sum(axis=(-2, -1)))

    @property
    def bending_energy(self) -> Floats:
        """Energy of bending of each facet (s, m) [force length], with the curvature taken as uniform over it."""
        return np.asarray(0.5 * self.area * (self.moment * self.curvature).sum(axis=(-2, -1)))

    @property
    def membrane_share(self) -> Floats:
        """Energy of stretching over all energy of the sheet (s,); 0 where nothing is stored."""
        membrane, bending = self.membrane_energy.sum(axis=-1), self.bending_energy.sum(axis=-1)
        total = membrane + bending
        return np.asarray(np.where(total > 0, membrane / np.where(total > 0, total, 1.0), 0.0))

    @property
    def _rigidity(self) -> float:
        return self.material.E * self.thickness**3 / (12 * (1 - self.material.nu**2))

    def _law(self, tensor: Floats) -> Floats:
        nu = self.material.nu
        trace = tensor[..., 0, 0] + tensor[..., 1, 1]
        return np.asarray((1 - nu) * tensor + nu * trace[..., None, None] * np.eye(2))


def sheet_stress(
    results: Results, step: int | None = None, thickness: float | None = None, material: Material | None = None
) -> SheetStress:
    """Stress of every facet of a sheet.

    Parameters
    ----------
    results : Results
        Results of a model made from a flat mesh, on any rung of accuracy.
    step : int, optional
        Number of one stored step; None takes all of them.
    thickness : float, optional
        Sheet thickness [length]; by default that of the model or the mesh.
    material : Material, optional
        Elastic constants; by default those of the model or the mesh.

    Returns
    -------
    SheetStress
        Stresses follow from the deformation and the material, also where the rung (such as "paper") takes other
        stiffnesses.

    Raises
    ------
    AnalysisError
        The model was not made from a mesh.
    ModelError
        No such step, no thickness or material, or a mesh that is not flat.
    """
    mesh = results.mesh
    if mesh is None:
        raise AnalysisError("stress needs a model made by Model.from_mesh", results=results)
    if np.ptp(mesh.nodes[:, 2]) > FLAT * mesh.size:
        raise ModelError("stress: the drawing must be flat and level, but the nodes of the mesh differ in z")
    thickness = results.thickness if thickness is None else require_positive(thickness, "thickness", "stress")
    material = results.material if material is None else material
    if thickness is None or material is None:
        raise ModelError(f"stress: the {'thickness' if thickness is None else 'material'} is unknown: give it")
    if not isinstance(material, Material):
        raise ModelError(f"stress: material must be a Material, got {material!r}")
    step = None if step is None else results.step_number(step, "stress")
    chosen = results.steps if step is None else [results.steps[step]]
    sheet = _Sheet(results, mesh)
    strain, bent = np.empty((2, len(chosen), len(mesh.triangles), 2, 2))
    for row, one in enumerate(chosen):
        strain[row], bent[row] = sheet.linear_rate(one.u) if results.linear else sheet.deformation(one.u)
    if step is not None:
        strain, bent = strain[0], bent[0]
    return SheetStress(strain, bent, sheet.area, float(thickness), material)


class _Sheet:
    """Strain and curvature of the facets of one sheet under displacements."""

    def __init__(self, results: Results, mesh: TriMesh) -> None:
        self.mesh, self.dim = mesh, results.dim
        self.rest = results.rest
        triangles = mesh.triangles
        self.rest_edges = edge_vectors(self.rest, triangles)
        self.flat, self.area = flat_edges(self.rest_edges)
        self.square = (self.flat**2).sum(axis=2)
        self.to_strain = strain_from_edges(self.flat)
        # the facet laid out flat, against its drawing: the rotation of the gradient, without the stretch
        drawn = edge_vectors(mesh.nodes[:, :2], triangles)
        gradient = np.linalg.solve(drawn[:, :2], self.flat[:, :2]).transpose(0, 2, 1)
        angle = np.arctan2(gradient[:, 1, 0] - gradient[:, 0, 1], gradient[:, 0, 0] + gradient[:, 1, 1])
        cosine, sine = np.cos(angle), np.sin(angle)
        self.turn = np.stack([np.stack([cosine, -sine], axis=-1), np.stack([sine, cosine], axis=-1)], axis=-2)
        self.kernel = self._curved(results)
        if self.kernel is None and self.dim == 3:
            self.rest_curvature = curvature(self.rest[: len(mesh.nodes)], mesh, "tensor")

    def _curved(self, results: Results) -> CurvedFacetKernel | None:
        """The kernel of the sheet's curved facets, where it has them."""
        for kernel in results.kernels:
            if isinstance(kernel, CurvedFacetKernel):
                count = len(self.mesh.triangles)
                if np.array_equal(kernel.conn[:count, :3], self.mesh.triangles):
                    return kernel
        return None

    def deformation(self, u: Floats) -> tuple[Floats, Floats]:
        """Strain and curvature (m, 2, 2) in drawing axes."""
        count = len(self.mesh.triangles)
        bent = np.zeros((count, 2, 2))
        if self.kernel is None:
            change = edge_vectors(u, self.mesh.triangles)
            edge_strain = ((self.rest_edges + 0.5 * change) * change).sum(axis=2) / self.square
            if self.dim == 3:
                nodes = len(self.mesh.nodes)
                bent = curvature(self.rest[:nodes] + u[:nodes], self.mesh, "tensor") - self.rest_curvature
        else:
            state = self.kernel._state(Configuration(self.rest, u))
            edge_strain = state[3][:count]
            slopes = (state[4] - self.kernel._rest_slopes)[:count]
            bent = self._drawn(mean_curvature(self.flat, self.area, slopes))
        exx, eyy, shear = np.einsum("nac,nc->an", self.to_strain, edge_strain)
        strain = np.stack([np.stack([exx, shear / 2], axis=-1), np.stack([shear / 2, eyy], axis=-1)], axis=-2)
        return self._drawn(strain), bent

    def linear_rate(self, u: Floats) -> tuple[Floats, Floats]:
        """Strain and curvature to first order in the displacements, by a central difference."""
        largest = float(np.abs(u).max())
        share = min(1.0, SMALL * self.mesh.size / largest) if largest > 0 else 1.0
        ahead, back = self.deformation(share * u), self.deformation(-share * u)
        return 0.5 / share * (ahead[0] - back[0]), 0.5 / share * (ahead[1] - back[1])

    def _drawn(self, tensor: Floats) -> Floats:
        """From the axes of facets laid out flat to those of the drawing."""
        return np.asarray(self.turn.transpose(0, 2, 1) @ tensor @ self.turn)


def mean_curvature(flat: Floats, area: Floats, slopes: Floats) -> Floats:
    """Mean curvature tensor (n, 2, 2) of a discrete Kirchhoff triangle with end slopes (n, 6) against its chords.

    By Gauss's theorem it is the sum over the edges of the slope vector times the outward normal; along an edge the
    slope vector is quadratic, so Simpson's rule is exact.
    """
    corner = np.empty((len(area), 3, 2))
    for k in range(3):
        at = np.flatnonzero(CORNER_OF_SLOPE == k)
        along = -flat[:, EDGE_OF_SLOPE[at]]
        corner[:, k] = np.linalg.solve(along, slopes[:, at, None])[..., 0]
    total = np.zeros((len(area), 2, 2))
    for edge, (a, b) in enumerate(zip(STARTS, ENDS)):
        vector = flat[:, edge]
        both = corner[:, a] + corner[:, b]
        unit = vector / np.linalg.norm(vector, axis=1)[:, None]
        middle = 0.5 * both - 0.75 * (unit * both).sum(axis=1)[:, None] * unit
        outward = np.stack([vector[:, 1], -vector[:, 0]], axis=1)
        total += ((both + 4 * middle) / 6)[:, :, None] * outward[:, None]
    total /= area[:, None, None]
    return np.asarray(0.5 * (total + total.transpose(0, 2, 1)))


def checked_values(stress: SheetStress, kind: Any, fibre: str) -> tuple[Floats, str]:
    """Values of one kind of stress, and what to call them."""
    if kind == "largest":
        return stress.principal(fibre)[..., 0], f"largest principal stress, {fibre}"
    if kind == "smallest":
        return stress.principal(fibre)[..., 1], f"smallest principal stress, {fibre}"
    if kind == "von Mises":
        return stress.von_mises(fibre), f"von Mises stress, {fibre}"
    raise ModelError(f"stress: kind must be 'largest', 'smallest' or 'von Mises', got {kind!r}")


def plot_stress(
    results: Results,
    step: int = -1,
    kind: str = "largest",
    fibre: str = "top",
    thickness: float | None = None,
    material: Material | None = None,
    **options: Any,
) -> Any:
    """Draw the deformed sheet, coloured by stress.

    Parameters
    ----------
    step : int
        Number of the stored step; -1 is the last.
    kind : {"largest", "smallest", "von Mises"}
        Which: one of the principal stresses, or von Mises' [force / length^2].
    fibre : {"top", "middle", "bottom"}
        Where in the thickness.
    thickness, material : optional
        As for :func:`sheet_stress`.
    options
        As for :func:`kirigami.plot.plot_results`.

    Returns
    -------
    matplotlib axes

    Raises
    ------
    AnalysisError
        The model was not made from a mesh.
    ModelError
        No such step, kind or fibre, no thickness or material, or a mesh that is not flat.
    """
    values, label = checked_values(sheet_stress(results, step, thickness, material), kind, fibre)
    return results.plot(step, color=values, **{"label": label, **options})
