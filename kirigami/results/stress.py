"""Stress of a sheet, facet by facet, as the elements bear it.

Everything is counted from the rest state (an imperfection is stress-free) and given in the axes x, y of the drawing,
which turn with the facet: second Piola-Kirchhoff stress and Green strain, the common ones as long as strains are small.
Where a facet is not level in the drawing, as on a tube, its axes lie in its plane: the first is the projection of x,
or of y where the facet stands on x, the second is a quarter turn from it about the normal; `SheetStress.axes` has them.
Its top is the side of the normal, from which its corners run counter-clockwise. Principal values and von Mises' do not
depend on that choice.

* Forces N and moments M per length are those of the elements, and so are the energies
  (:mod:`kirigami.results.sheet_state`): over the sheet they do the work of the loads and hold the stored energy, on
  every rung.
* Stress at distance z from the middle is N / t - 12 z M / t^3, as in Kirchhoff's plate. (Timoshenko and
  Woinowsky-Krieger, 1959.)
* Strain is that of the facet; curvature K, second derivatives of the height, is positive where the sheet is hollow from
  above. Plate theory makes stress of them, E / (1 - nu^2) ((1 - nu) e + nu trace(e) I) with e = strain - z K; that is
  :meth:`SheetStress.by_plate_theory`. Facet elements obey it; bars and hinges do not, since they have a Poisson ratio
  of their own, and none that is right in bending.

On a cylinder of radius R the faces have E t / (2 R (1 - nu^2)) round it and nu times that along it.
"""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from kirigami.elements.stiffness import Calibration, SheetConstants
from kirigami.errors import AnalysisError, ModelError
from kirigami.post.shape import principal_values
from kirigami.primitives.checks import require_choice, require_instance, require_positive, require_whole
from kirigami.primitives.laminate import Laminate
from kirigami.primitives.material import SheetMaterial
from kirigami.results.sheet_state import SheetState, state_reader
from kirigami.units import unit_for

if TYPE_CHECKING:
    from kirigami.results.results import Results

Floats = NDArray[np.float64]

FIBRES = {"bottom": -0.5, "middle": 0.0, "top": 0.5}  # place over the thickness


@dataclass(frozen=True, eq=False)
class SheetStress:
    """Stress and deformation of every facet, in the axes x and y of the drawing, or its own where it is not level.

    Leading axes of all arrays are (s, m), steps and facets, or (m,) for one step.

    Attributes
    ----------
    strain : ndarray, shape (s, m, 2, 2)
        Green strain of the middle surface.
    curvature : ndarray, shape (s, m, 2, 2)
        Curvature [1 / length], positive where the sheet is hollow from above.
    force : ndarray, shape (s, m, 2, 2)
        Membrane force per length [force / length].
    moment : ndarray, shape (s, m, 2, 2)
        Bending moment per length [force], positive where it makes the sheet hollow from above.
    membrane_energy, bending_energy : ndarray, shape (s, m)
        Energy of stretching and of bending that the elements store in each facet [force length].
    area : ndarray, shape (m,)
        Areas of the facets at rest [length^2].
    thickness : float or ndarray, shape (m,)
        Sheet thickness [length], or that of each facet.
    material : Material, Orthotropic, Laminate or tuple of them
        Elastic constants of the sheet, or of each facet.
    axes : ndarray, shape (m, 2, 3)
        Unit vectors in space of the axes of each facet, as drawn; see the text of the module.
    natural : ndarray, shape (s, m, 6)
        Strain and curvature (exx, eyy, gamma_xy, kxx, kyy, 2 kxy) at which facets bear nothing, by
        :class:`kirigami.Actuate`; nan on bars and hinges, where they are known of edges alone.
    heat : ndarray, shape (s, m, 2)
        Heat at the lower and upper faces that is in them.
    layers : ndarray, shape (s, 3, m, 2, 2), or None
        Stress at the lower face, in the middle and at the upper face of a sheet whose facets yield; None elsewhere.

    Examples
    --------
    >>> import numpy as np
    >>> import kirigami as kg
    >>> mesh = kg.Sheet([(0, 0), (2, 0), (2, 1), (0, 1)]).mesh(0.5)
    >>> m = kg.Model.from_mesh(mesh, thickness=0.01, material=kg.Material(E=1e6, nu=0.3), stiffness="shell")
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
    force: Floats
    moment: Floats
    membrane_energy: Floats
    bending_energy: Floats
    area: Floats
    thickness: float | Floats
    material: SheetMaterial | tuple[SheetMaterial, ...]
    axes: Floats
    natural: Floats | None = None
    heat: Floats | None = None
    layers: Floats | None = None

    @property
    def _constants(self) -> SheetConstants:
        return SheetConstants(Calibration(1.0, 1.0), self.thickness, self.material)

    @property
    def sections(self) -> Floats:
        """Section matrices (m, 6, 6) of the facets in the axes of the drawing: (N, M) by (exx, eyy, gamma_xy, kxx, kyy,
        2 kxy)."""
        return self._constants.sections(len(self.area))

    def tensor(self, fibre: str = "middle") -> Floats:
        """Stress tensor (s, m, 2, 2) [force / length^2]; in a laminate that of the layer there.

        Parameters
        ----------
        fibre : {"middle", "top", "bottom"}
            Where in the thickness; the top is the face seen from above, on the side of the facet's normal. Where facets
            have yielded, the stress is that of the layers nearest to it.

        Raises
        ------
        ModelError
            Another name of a fibre.
        """
        require_choice(fibre, FIBRES, "fibre", "stress")
        if self.layers is not None:
            return np.asarray(self.layers[..., list(FIBRES).index(fibre), :, :, :])
        height = FIBRES[fibre]
        t = np.asarray(self.thickness)[..., None, None]
        found = np.asarray(self.force / t - 12 * height / t**2 * self.moment)
        number, materials = self._constants.material_of_facets(len(self.area))
        for position, material in enumerate(materials):
            if isinstance(material, Laminate):  # whose layers do not share forces and moments evenly
                at = number == position
                strain = self.strain[..., at, :, :] - height * material.thickness * self.curvature[..., at, :, :]
                felt = _components(strain) - self._free(material, height, at)
                found[..., at, :, :] = _tensor(felt @ material.elasticity(height))
        return found

    def _free(self, material: Laminate, height: float, at: NDArray[np.bool_]) -> Floats | float:
        """Strain (..., k, 3) of a fibre of facets at which it bears nothing: what heat makes of its layer, and what the
        sheet as a whole is told beside it."""
        if self.natural is None or self.heat is None or not self.natural.any():
            return 0.0
        natural, heat, thickness = self.natural[..., at, :], self.heat[..., at, :], material.thickness
        found = np.zeros((*natural.shape[:-1], 3))
        if heat.any():
            section = material.section(thickness)
            below, above = (np.linalg.solve(section, material.heated(thickness, *face)) for face in np.eye(2).tolist())
            natural = natural - heat[..., :1] * below - heat[..., 1:] * above
            local = heat[..., :1] * (0.5 - height) + heat[..., 1:] * (0.5 + height)
            found += local * material.free_strain(height)
        return np.asarray(found + natural[..., :3] - height * thickness * natural[..., 3:])

    def by_plate_theory(self) -> SheetStress:
        """The stress that plate theory makes of strain and curvature, whatever the elements bear.

        For rungs of bars and hinges, whose own stress has their Poisson ratios and the pattern of their mesh; energies
        are those of a plate with uniform strain and curvature in each facet.

        Raises
        ------
        ModelError
            The sheet is actuated, and made of bars and hinges, which do not tell what facets bear nothing at.
        """
        felt = np.concatenate([_components(self.strain), _components(self.curvature)], axis=-1)
        if self.natural is not None:
            if np.isnan(self.natural).any():
                raise ModelError(
                    "by_plate_theory: the sheet is actuated, and what its facets bear nothing at is known of their "
                    "edges alone on bars and hinges: use stiffness='shell' or 'facet'"
                )
            felt = felt - self.natural
        borne = np.einsum("mab,...mb->...ma", self.sections, felt)
        force, moment = _tensor(borne[..., :3]), _tensor(borne[..., 3:])
        stretching = 0.5 * self.area * (borne[..., :3] * felt[..., :3]).sum(axis=-1)
        bending = 0.5 * self.area * (borne[..., 3:] * felt[..., 3:]).sum(axis=-1)
        elastic = replace(self, layers=None, force=force, moment=moment)
        return replace(elastic, membrane_energy=stretching, bending_energy=bending)

    def principal(self, fibre: str = "middle") -> Floats:
        """Principal stresses (s, m, 2), the algebraically larger first [force / length^2]; fibres as in `tensor`."""
        stress = self.tensor(fibre)
        return principal_values(stress[..., 0, 0], stress[..., 1, 1], stress[..., 0, 1])

    def directions(self, fibre: str = "middle") -> Floats:
        """Unit vectors (s, m, 2, 2) of the principal stresses in the drawing, one a row, as in `principal`; ``@ axes``
        makes them vectors in space, where the facet was drawn."""
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
    def membrane_share(self) -> Floats:
        """Energy of stretching over all energy of the sheet (s,); 0 where nothing is stored."""
        membrane, bending = self.membrane_energy.sum(axis=-1), self.bending_energy.sum(axis=-1)
        total = membrane + bending
        return np.asarray(np.where(total > 0, membrane / np.where(total > 0, total, 1.0), 0.0))


def _components(tensor: Floats) -> Floats:
    """(xx, yy, 2 xy) of symmetric tensors (..., 2, 2)."""
    return np.stack([tensor[..., 0, 0], tensor[..., 1, 1], 2 * tensor[..., 0, 1]], axis=-1)


def _tensor(components: Floats) -> Floats:
    """Symmetric tensors (..., 2, 2) of (xx, yy, xy)."""
    xx, yy, xy = np.moveaxis(components, -1, 0)
    return np.stack([np.stack([xx, xy], axis=-1), np.stack([xy, yy], axis=-1)], axis=-2)


def sheet_stress(
    results: Results, step: int | None = None, thickness: float | None = None, material: SheetMaterial | None = None
) -> SheetStress:
    """Stress of every facet of a sheet.

    Parameters
    ----------
    results : Results
        Results of a model made from a mesh, flat or curved, on any rung of accuracy.
    step : int, optional
        Number of one stored step; None takes all of them.
    thickness : float, optional
        Sheet thickness [length]; by default that of the model or the mesh.
    material : Material, optional
        Elastic constants; by default those of the model or the mesh.

    Returns
    -------
    SheetStress
        What the elements of the rung bear; :meth:`SheetStress.by_plate_theory` makes stress of the deformation instead.

    Raises
    ------
    AnalysisError
        The model was not made from a mesh.
    ModelError
        No such step, no thickness or material.

    Examples
    --------
    A tube under pressure has p r / t round it.

    >>> import kirigami as kg, numpy as np
    >>> angle, along = np.meshgrid(np.arange(24) * np.pi / 12, np.linspace(0, 1, 5), indexing="ij")
    >>> places = np.stack([np.cos(angle), np.sin(angle), along], axis=-1).reshape(-1, 3)
    >>> start = [(5 * i + j, 5 * ((i + 1) % 24) + j) for i in range(24) for j in range(4)]
    >>> mesh = kg.TriMesh(places, [facet for a, b in start for facet in ((a, b, b + 1), (a, b + 1, a + 1))])
    >>> m = kg.Model.from_mesh(mesh, thickness=0.01, material=kg.Material(E=1e6), stiffness="shell")
    >>> held = m.add(kg.Fix(m.nodes, "z"), kg.Fix(m.nodes[0], "y"), kg.Fix(m.nodes[30], "xy"), kg.Pressure(1.0))
    >>> stress = kg.LinearStatic(m).run().stress(-1)
    >>> bool(np.allclose(stress.principal()[:, 0], 100, rtol=0.01))
    True
    """
    from kirigami.results.results import Results

    require_instance(results, Results, "results", "stress")
    thickness = None if thickness is None else require_positive(thickness, "thickness", "stress")
    material = None if material is None else require_instance(material, SheetMaterial, "material", "stress")
    step = None if step is None else require_whole(step, "step", "stress")
    mesh = results.mesh
    if mesh is None:
        raise AnalysisError("stress needs a model made by Model.from_mesh", results=results)
    height = results.thickness if thickness is None else thickness
    made_of = results.material if material is None else material
    if height is None or made_of is None:
        raise ModelError(f"stress: the {'thickness' if height is None else 'material'} is unknown: give it")
    step = None if step is None else results.step_number(step, "stress")
    chosen = results.steps if step is None else [results.steps[step]]
    reader = state_reader(results, mesh)
    states = [reader.at(one) for one in chosen]
    names = [field.name for field in fields(SheetState)]
    parts = {name: np.array([getattr(state, name) for state in states]) for name in names}
    if step is not None:
        parts = {name: values[0] for name, values in parts.items()}
    elif not states:
        shapes = {"natural": (6,), "heat": (2,), "membrane_energy": (), "bending_energy": ()}
        parts = {name: np.zeros((0, len(mesh.triangles), *shapes.get(name, (2, 2)))) for name in names}
    found = SheetStress(**parts, area=reader.area, thickness=height, material=made_of, axes=reader.axes)
    if results.linear or not any(kernel.surface and kernel.plastic() is not None for kernel in results.kernels):
        return found
    elastic = np.stack([found.tensor(fibre) for fibre in FIBRES], axis=-4)
    if step is not None:
        return replace(found, layers=reader.layers(chosen[0], elastic))
    every = [reader.layers(*each) for each in zip(chosen, elastic)]
    return replace(found, layers=np.array(every).reshape(elastic.shape))


def checked_values(stress: SheetStress, kind: Any, fibre: str) -> tuple[Floats, str]:
    """Values of one kind of stress, and what to call them."""
    require_choice(kind, ("largest", "smallest", "von Mises"), "kind", "stress")
    if kind == "largest":
        return stress.principal(fibre)[..., 0], f"largest principal stress, {fibre}"
    if kind == "smallest":
        return stress.principal(fibre)[..., 1], f"smallest principal stress, {fibre}"
    return stress.von_mises(fibre), f"von Mises stress, {fibre}"


def plot_stress(
    results: Results,
    step: int = -1,
    kind: str = "largest",
    fibre: str = "top",
    thickness: float | None = None,
    material: SheetMaterial | None = None,
    **options: Any,
) -> Any:
    """Draw the deformed sheet, coloured by stress: means round each node, with the jumps kept across folds and cuts.

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
        No such step, kind or fibre, no thickness or material.
    """
    from kirigami.results.smooth import sectors

    step = require_whole(step, "step", "plot_stress")
    values, label = checked_values(sheet_stress(results, step, thickness, material), kind, fibre)
    if options.get("smooth", True):
        values = sectors(results).means(values[None])[0]
    if results.units:
        unit, factor = unit_for(float(np.abs(values).max(initial=0.0)), "stress")
        values, label = values / factor, f"{label} [{unit}]"
    return results.plot(step, color=values, **{"label": label, **options})
