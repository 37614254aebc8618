"""Strain and curvature that a sheet takes by itself: heat, swelling, prestretch, layers that do not fit.

A facet with strain e and curvature k bears forces and moments by what they are beyond the natural e_0 and k_0:

    energy  A ((e - e_0, k - k_0) . section . (e - e_0, k - k_0)) / 2

Heat T(z) makes of the expansion of each layer what classical lamination theory says: (e_0, k_0) = S^-1 (N_T, M_T), see
:mod:`kirigami.primitives.material`. In one isotropic layer that is e_0 = a T (1, 1, 0) and, where the heat rises by dT
from the lower to the upper face, k_0 = -a dT / t (1, 1, 0). Two equal layers of thickness t / 2 whose free strains
differ by d bend to k_0 = 3 d / (2 t) (Timoshenko, J. Opt. Soc. Am. 11 (1925), 233). What layers bear against each
other in a sheet that is free is part of their stress, but not of the energy. How bars, hinges and flat facets take e_0
and k_0 is in :mod:`kirigami.model.natural_state`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kirigami.errors import ModelError
from kirigami.model.natural_state import NaturalState
from kirigami.model.spread_loads import Surface, _facets
from kirigami.primitives.checks import require_array, require_boolean, require_finite
from kirigami.primitives.kernel import Array, Kernel
from kirigami.primitives.node import Node
from kirigami.primitives.parts import ModelObject, Numbering
from kirigami.words import counted

Index = NDArray[np.int64]


@dataclass(frozen=True, slots=True, eq=False, repr=False, init=False)
class Actuate(ModelObject):
    """Gives facets of a sheet a strain and a curvature of their own, at which they bear nothing.

    Several on one facet add up. A model that only this drives needs no load. On every rung the sheet takes what it can
    take freely; what it bears when it is held is what the elements of the rung make of it. A strain is that of all
    layers alike: a tube that swells becomes a wider tube.

    Parameters
    ----------
    facets : str or array_like of int, optional
        Name of a region of the mesh, or numbers of facets; None is the whole sheet.
    strain : array_like, shape (3,)
        (exx, eyy, gamma_xy) at load factor 1, in the axes of the drawing.
    curvature : array_like, shape (3,)
        (kxx, kyy, 2 kxy) at load factor 1 [1 / length]; kxx > 0 curves a flat sheet towards its normal.
    constant : bool
        They are there in full whatever the load factor.
    heat : float or array_like, shape (2,)
        Rise of temperature at load factor 1, evenly or at the lower and upper faces with a straight line between, in
        the unit to which the ``expansion`` of the material belongs; the upper face is that of the normals.

    Raises
    ------
    ModelError
        Values that are no three numbers, or all zero; in a run facets that are not there, a model without a mesh, a
        curvature in a model with dim=2, or a material without expansion that is heated.

    Examples
    --------
    >>> import kirigami as kg
    >>> mesh = kg.Sheet([(0, 0), (4, 0), (4, 1), (0, 1)]).mesh(0.8)
    >>> m = kg.Model.from_mesh(mesh, thickness=0.05, material=kg.Material(E=1e6), stiffness="shell")
    >>> held = m.add(kg.Fix(m.nodes[0]), kg.Fix(m.nodes[1], "yz"), kg.Fix(m.nodes[2], "z"))
    >>> heat = m.add(kg.Actuate(strain=(0.01, 0.01, 0)))
    >>> res = kg.LoadControl(m).run()
    >>> round(float(res.width("y")[-1]), 3), bool(max(sum(res.energy.values())) < 1e-12)
    (4.04, True)

    A strip of two metals that is warmed by 100 degrees curves towards the one that expands less:

    >>> lower = kg.Material(E=2e11, nu=0.3, expansion=17e-6)
    >>> upper = kg.Material(E=2e11, nu=0.3, expansion=12e-6)
    >>> pair = kg.Laminate([(lower, 5e-4), (upper, 5e-4)])
    >>> m = kg.Model.from_mesh(mesh.scaled(0.01), material=pair, stiffness="shell")
    >>> objects = m.add(kg.Fix(m.nodes[0]), kg.Fix(m.nodes[1], "yz"), kg.Fix(m.nodes[2], "z"), kg.Actuate(heat=100.0))
    >>> res = kg.LoadControl(m).run()
    >>> round(float(res.stress(-1).curvature[0, 0, 0]), 3)       # 3 d / (2 t), d = 5e-4, t = 1e-3
    0.75
    """

    kind: ClassVar[str] = "effect"
    facets: Index | str | None
    strain: tuple[float, float, float]
    curvature: tuple[float, float, float]
    constant: bool
    heat: tuple[float, float]

    def __init__(
        self,
        facets: str | ArrayLike | None = None,
        strain: ArrayLike = (0.0, 0.0, 0.0),
        curvature: ArrayLike = (0.0, 0.0, 0.0),
        constant: bool = False,
        heat: ArrayLike = 0.0,
    ) -> None:
        object.__setattr__(self, "facets", _facets(facets, "Actuate"))
        for name, value in (("strain", strain), ("curvature", curvature)):
            object.__setattr__(self, name, tuple(require_array(value, (3,), name=name, owner="Actuate").tolist()))
        warmed = require_array(heat, (), (2,), name="heat", owner="Actuate")
        object.__setattr__(self, "heat", tuple(np.broadcast_to(warmed, (2,)).tolist()))
        if not any(self.strain + self.curvature + self.heat):
            raise ModelError("Actuate: give a strain, a curvature or a heat other than zero")
        object.__setattr__(self, "constant", require_boolean(constant, "constant", "Actuate"))

    @property
    def nodes(self) -> tuple[Node, ...]:
        return ()

    def held(self, lam: float) -> Actuate:
        """The same, constant at load factor `lam`."""
        lam = require_finite(lam, "lam", "Actuate.held")
        if self.constant or lam == 0:
            return self
        strain, curvature, heat = (np.multiply(lam, values) for values in (self.strain, self.curvature, self.heat))
        return Actuate(self.facets, strain, curvature, constant=True, heat=heat)

    @classmethod
    def lower(cls, objects: Sequence[Any], numbering: Numbering) -> list[Kernel]:
        """Nothing is made: the elements of the sheet themselves are told."""
        if numbering.mesh is None or numbering.sheet is None:
            raise ModelError(
                f"{objects[0]!r} needs the sheet of a mesh: make the model by Model.from_mesh; bars and hinges added "
                "by hand are driven by target_length and target_angle"
            )
        surface = Surface(numbering, "Actuate")
        for item in objects:
            facets = surface.chosen(item.facets, repr(item))
            state = NaturalState(numbering, repr(item))
            state.tell(facets, item._state(facets, numbering), item.constant)
            if any(item.heat):
                state.warm(facets, np.array(item.heat), item.constant)
        return []

    def _state(self, facets: Index, numbering: Numbering) -> Array:
        """Strain and curvature (k, 6) of facets at load factor 1, in the axes of the drawing."""
        found = np.tile(self.strain + self.curvature, (len(facets), 1))
        if not any(self.heat):
            return found
        count = len(numbering.mesh.triangles)
        number, materials = numbering.sheet.material_of_facets(count)
        kinds = np.stack([number, numbering.sheet.thickness_of_facets(count)], axis=1)[facets]
        pairs, which = np.unique(kinds, axis=0, return_inverse=True)
        free = []
        for position, thickness in pairs.tolist():
            material = materials[int(position)]
            free.append(np.linalg.solve(material.section(thickness), material.heated(thickness, *self.heat)))
        return np.asarray(found + np.array(free)[which.ravel()])

    def __repr__(self) -> str:
        where = "the whole sheet" if self.facets is None else (
            repr(self.facets) if isinstance(self.facets, str) else counted(len(self.facets), "facet")
        )
        parts = {"strain": self.strain, "curvature": self.curvature, "heat": self.heat}
        said = ", ".join(f"{name}={values}" for name, values in parts.items() if any(values))
        return f"Actuate({where}, {said})"
