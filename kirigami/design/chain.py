"""Derivatives by the parameters of a design in one pass: one contraction a functional, then the chain rule.

What a functional makes of the places of the nodes at rest is found once, see
:mod:`kirigami.results.gradients.by_rest`; a parameter then costs a moved mesh, its supports, and the stiffnesses that
come from the mesh. Where something of the structure does not tell how it follows its nodes, or the supports change with
a parameter in more than what the nodes do, nothing is said here, and the structure is lowered once more.
"""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from kirigami.elements.shell_facet import turned_sections
from kirigami.elements.stiffness import Calibration, SheetConstants, bar_stiffness, hinge_stiffness
from kirigami.errors import KirigamiWarning
from kirigami.model.moved import moved, nodes_of
from kirigami.model.properties import facet_properties
from kirigami.primitives.kernel import Array
from kirigami.primitives.material import SheetMaterial
from kirigami.primitives.parts import ModelObject
from kirigami.results.gradients.by_rest import by_rest_state
from kirigami.results.gradients.equilibrium import Adjoint

if TYPE_CHECKING:
    from kirigami.design.design import Design

STEP = 1e-5  # of the range of a parameter, in central differences of meshes and stiffnesses


class Chain:
    """Derivatives of functionals at equilibria of a design, parameter by parameter."""

    def __init__(self, design: Design, adjoints: Sequence[Adjoint]) -> None:
        self.design = design
        self._adjoints = adjoints
        self._by_array: list[dict[tuple[int, str], Array]] | None = None  # once it is needed
        self._by_line: Array | None = None  # (functionals, k, 2), by the places of nodes on lines
        by_place = self._contracted(adjoints)
        if by_place is None:
            return
        self._system = adjoints[0].at.system
        self._still = self._supports_stay({name: self._ahead(name) for name in design.values})
        self._by_line = np.array([design._follower.back(rates[:, :2]) for rates in by_place])

    @staticmethod
    def _contracted(adjoints: Sequence[Adjoint]) -> Array | None:
        found: list[Array | None] = [None] * len(adjoints)
        for at in {id(adjoint.at): adjoint.at for adjoint in adjoints}.values():
            rows = [row for row, adjoint in enumerate(adjoints) if adjoint.at is at]
            model = at.system.model
            mesh = model.mesh
            if mesh is None or mesh.folds or len(model.sheet_elements) != len(model.elements):
                return None
            if len(mesh.nodes) != at.system.points:
                return None
            told = by_rest_state([adjoints[row] for row in rows], sections_are_known=True)
            if told is None:
                return None
            for row, part in zip(rows, told):
                found[row] = part
        return np.array(found)

    def _ahead(self, name: str) -> float:
        return self.design.values[name] + STEP * self.design.span(name)

    def _supports_stay(self, values: dict[str, float]) -> bool:
        """Whether supports() adds the same as it does here to the sheet at other values of parameters."""
        mesh, here = self.design._with(values).mesh, self._system.model
        model = moved(here, mesh.nodes, mesh)
        before = model.objects[len(model.elements) :]
        model.remove(*before)
        with nodes_of(model), warnings.catch_warnings():
            warnings.simplefilter("ignore", KirigamiWarning)
            self.design.supports(model)
        return len(model.nodes) == len(here.nodes) and _alike(model.objects[self._sheet :], before)

    @property
    def _sheet(self) -> int:
        return len(self._system.model.sheet_elements)

    def rates(self, name: str, sides: Sequence[Design], step: float) -> list[float] | None:
        """Derivatives of the functionals by a parameter, with the designs a `step` ahead and behind; None where they
        must be found otherwise."""
        if self._by_line is None or not (self._still or self._supports_stay({name: self._ahead(name)})):
            return None
        found = np.zeros(len(self._adjoints))
        if self.design._takes(name, "cuts", "outline", "folds"):
            more, less = (side._on_lines() for side in sides)
            found = np.einsum("kna,na->k", self._by_line, more - less) / (2 * step)
        if self._needs_arrays(name):
            if self._by_array is None:
                self._by_array = [self._of_arrays(adjoint) for adjoint in self._adjoints]
            ahead, behind = (self._arrays(side) for side in sides)
            for row, by_array in enumerate(self._by_array):
                for key, rate in by_array.items():
                    found[row] += float((rate * (ahead[key] - behind[key])).sum()) / (2 * step)
        rates: list[float] = found.tolist()
        return rates

    # ---- stiffnesses, which the mesh and the parameters make

    def _needs_arrays(self, name: str) -> bool:
        """Whether a parameter changes stiffnesses: those of isotropic shells feel no mesh."""
        constants = self._system.model.sheet_constants
        assert constants is not None
        plain = constants.rung == "shell" and all(item.isotropic for item in constants.materials)
        return not plain or self.design._takes(name, "thickness", "material")

    def _of_arrays(self, adjoint: Adjoint) -> dict[tuple[int, str], Array]:
        """Derivatives by the arrays that :meth:`_arrays` makes, kernel by kernel."""
        names = {"shell": ("section",), "bars": ("EA",), "hinges": ("stiffness",), "clamps": ("stiffness",),
                 "facets": ("thickness", "E", "nu")}  # fmt: skip
        found = {}
        for number, kernel in enumerate(adjoint.at.system.kernels):
            if kernel.name in names:
                told = adjoint.of_member_arrays(kernel)
                found.update({(number, name): told[name] for name in names[kernel.name]})
        return found

    def _arrays(self, design: Design) -> dict[tuple[int, str], Array]:
        """The arrays of the kernels of a sheet, as lowering the model of a design makes them."""
        sheet, mesh = design.sheet(), design.mesh
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", KirigamiWarning)
            height, material = facet_properties(mesh, sheet.thickness, sheet.material, "Design")
        one = material if isinstance(material, SheetMaterial) else material[0]
        made = SheetConstants(Calibration.named(design.stiffness, one), height, material, design.stiffness)
        count = len(mesh.triangles)
        found: dict[tuple[int, str], Array] = {}
        by_edge = None
        for number, kernel in enumerate(self._system.kernels):
            members = slice(None) if kernel.members is None else kernel.members
            if kernel.name == "shell":
                sections = made.sections(count)
                if not all(item.isotropic for item in made.materials):
                    corners = (mesh.nodes + design._offset())[mesh.triangles]
                    sections = turned_sections(sections, np.broadcast_to([1.0, 0.0, 0.0], (count, 3)), corners)
                found[number, "section"] = sections
            elif kernel.name == "facets":
                found[number, "thickness"] = made.thickness_of_facets(count)[members]
                for name in ("E", "nu"):
                    found[number, name] = np.broadcast_to(np.asarray(made.of_facets(name)), (count,))[members]
            elif kernel.name == "bars":
                found[number, "EA"] = bar_stiffness(mesh, height, made.of_facets("E"), made.calibration.F_s)[members]
            elif kernel.name in ("hinges", "clamps"):
                if by_edge is None:
                    by_edge = hinge_stiffness(mesh, height, made.of_facets("E"), made.of_facets("c"))
                inner = np.flatnonzero(mesh.edge_facets[:, 1] >= 0)
                edges = inner if kernel.mesh_edges is None else kernel.mesh_edges
                found[number, "stiffness"] = by_edge[edges][members]
        return found


def _alike(one: Any, other: Any) -> bool:
    """Whether two things, such as supports on the same nodes, say the same to the last digit."""
    if one is other:
        return True
    if type(one) is not type(other):
        return False
    if isinstance(one, np.ndarray):
        return bool(np.array_equal(one, other))
    if isinstance(one, (tuple, list)):
        return len(one) == len(other) and all(map(_alike, one, other))
    if isinstance(one, dict):
        return one.keys() == other.keys() and all(_alike(value, other[key]) for key, value in one.items())
    if isinstance(one, ModelObject):
        names = {name for cls in type(one).__mro__ for name in getattr(cls, "__slots__", ())}
        names |= set(getattr(one, "__dict__", ()))
        return all(_alike(getattr(one, name, None), getattr(other, name, None)) for name in names)
    return isinstance(one, (bool, int, float, str)) and bool(one == other)
