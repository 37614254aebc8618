"""kirigami: the mechanics of cut sheets, on shell facets, on flat ones, or on bars and hinges.

``kg.stretch(kg.Sheet(outline, cuts, thickness=..., material=kg.Material(E=...)), strain=0.1)`` holds a sheet, pulls it
and follows it through buckling; ``kg.Sheet.from_dxf`` and its kin read a drawing, ``kg.LoadCase`` says what else may be
done. By hand the same is a :class:`Model`, an analysis such as :class:`DisplacementControl`, and its :class:`Results`.
Each name has its own ``help``, with an example.

Public names load on first use, so that a scene imports only what it contains.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

from kirigami.moved import install as _install_old_modules
from kirigami.version import __version__ as __version__

_install_old_modules()

_HOME = {
    "Material": "primitives.material",
    "Orthotropic": "primitives.material",
    "NeoHookean": "primitives.rubber",
    "Laminate": "primitives.laminate",
    "Node": "primitives.node",
    "Model": "model.model",
    "Bar": "elements.bar",
    "BendHinge": "elements.bend_hinge",
    "TorsionSpring3": "elements.torsion_spring",
    "Facet": "elements.facet",
    "CurvedFacet": "elements.curved_facet",
    "Normal": "elements.curved_facet",
    "ShellFacet": "elements.shell_facet",
    "Crease": "elements.crease",
    "Fix": "model.constraints",
    "Prescribe": "model.constraints",
    "Grip": "model.grip",
    "RigidLink": "model.grip",
    "Symmetry": "model.constraints",
    "Tie": "model.constraints",
    "Turn": "model.turn",
    "NodalLoad": "model.loads",
    "EdgeLoad": "model.spread_loads",
    "AreaLoad": "model.spread_loads",
    "EdgeMoment": "model.edge_moment",
    "Gravity": "model.spread_loads",
    "Pressure": "model.pressure",
    "FlowPressure": "model.flow_pressure",
    "Actuate": "model.actuate",
    "Mass": "elements.mass",
    "Calibration": "elements.stiffness",
    "System": "system.system",
    "Kernel": "primitives.kernel",
    "Contribution": "primitives.kernel",
    "Tangent": "primitives.kernel",
    "displacement_of": "primitives.kernel",
    "ModelObject": "primitives.parts",
    "Numbering": "primitives.parts",
    "Contact": "effects.contact",
    "SelfContact": "effects.self_contact",
    "Moving": "effects.surfaces",
    "Plane": "effects.surfaces",
    "Cylinder": "effects.surfaces",
    "Sphere": "effects.surfaces",
    "Spring": "effects.spring",
    "check_kernel": "primitives.check_kernel",
    "Sheet": "geometry.sheet",
    "CellSheet": "geometry.cell_sheet",
    "Fold": "geometry.fold_line",
    "FoldEdges": "geometry.fold_line",
    "TriMesh": "geometry.mesh",
    "LinearStatic": "analysis.linear",
    "Eigen": "analysis.eigen",
    "Mode": "analysis.modes",
    "Buckling": "analysis.buckling",
    "Dynamics": "analysis.dynamics.dynamics",
    "LoadControl": "analysis.path.methods",
    "DisplacementControl": "analysis.path.methods",
    "ArcLength": "analysis.path.methods",
    "Results": "results.results",
    "Step": "results.step",
    "Event": "results.step",
    "load": "results.archive",
    "Framework": "lattice.framework",
    "Rigidity": "lattice.framework",
    "PeriodicCell": "lattice.periodic",
    "AngleLimit": "effects.angle_limit",
    "Sweep": "sweep.sweep",
    "SweepTable": "sweep.table",
    "latin_hypercube": "sweep.sampling",
    "LoadCase": "study.load_case",
    "stretch": "study.stretch",
    "Design": "design.design",
    "Inverse": "design.inverse",
    "InverseResult": "design.answer",
    "KirigamiError": "errors",
    "GeometryError": "errors",
    "ModelError": "errors",
    "MechanismError": "errors",
    "AnalysisError": "errors",
    "ConvergenceError": "errors",
    "KirigamiWarning": "errors",
}
_MODULES = {
    "bloch": "lattice.bloch",
    "cuts": "geometry.cuts",
    "stiffness": "elements.stiffness",
    "study": "study",
    "plot": "plot",
    "tilings": "lattice.tilings",
}

__all__ = ["__version__", *_HOME, *_MODULES]

if TYPE_CHECKING:
    from kirigami import plot as plot
    from kirigami import study as study
    from kirigami.analysis.buckling import Buckling as Buckling
    from kirigami.analysis.dynamics.dynamics import Dynamics as Dynamics
    from kirigami.analysis.eigen import Eigen as Eigen
    from kirigami.analysis.linear import LinearStatic as LinearStatic
    from kirigami.analysis.modes import Mode as Mode
    from kirigami.analysis.path.methods import ArcLength as ArcLength
    from kirigami.analysis.path.methods import DisplacementControl as DisplacementControl
    from kirigami.analysis.path.methods import LoadControl as LoadControl
    from kirigami.design.answer import InverseResult as InverseResult
    from kirigami.design.design import Design as Design
    from kirigami.design.inverse import Inverse as Inverse
    from kirigami.effects.angle_limit import AngleLimit as AngleLimit
    from kirigami.effects.contact import Contact as Contact
    from kirigami.effects.self_contact import SelfContact as SelfContact
    from kirigami.effects.spring import Spring as Spring
    from kirigami.effects.surfaces import Cylinder as Cylinder
    from kirigami.effects.surfaces import Moving as Moving
    from kirigami.effects.surfaces import Plane as Plane
    from kirigami.effects.surfaces import Sphere as Sphere
    from kirigami.elements import stiffness as stiffness
    from kirigami.elements.bar import Bar as Bar
    from kirigami.elements.bend_hinge import BendHinge as BendHinge
    from kirigami.elements.crease import Crease as Crease
    from kirigami.elements.curved_facet import CurvedFacet as CurvedFacet
    from kirigami.elements.curved_facet import Normal as Normal
    from kirigami.elements.facet import Facet as Facet
    from kirigami.elements.mass import Mass as Mass
    from kirigami.elements.shell_facet import ShellFacet as ShellFacet
    from kirigami.elements.stiffness import Calibration as Calibration
    from kirigami.elements.torsion_spring import TorsionSpring3 as TorsionSpring3
    from kirigami.errors import AnalysisError as AnalysisError
    from kirigami.errors import ConvergenceError as ConvergenceError
    from kirigami.errors import GeometryError as GeometryError
    from kirigami.errors import KirigamiError as KirigamiError
    from kirigami.errors import KirigamiWarning as KirigamiWarning
    from kirigami.errors import MechanismError as MechanismError
    from kirigami.errors import ModelError as ModelError
    from kirigami.geometry import cuts as cuts
    from kirigami.geometry.cell_sheet import CellSheet as CellSheet
    from kirigami.geometry.fold_line import Fold as Fold
    from kirigami.geometry.fold_line import FoldEdges as FoldEdges
    from kirigami.geometry.mesh import TriMesh as TriMesh
    from kirigami.geometry.sheet import Sheet as Sheet
    from kirigami.lattice import bloch as bloch
    from kirigami.lattice import tilings as tilings
    from kirigami.lattice.framework import Framework as Framework
    from kirigami.lattice.framework import Rigidity as Rigidity
    from kirigami.lattice.periodic import PeriodicCell as PeriodicCell
    from kirigami.model.actuate import Actuate as Actuate
    from kirigami.model.constraints import Fix as Fix
    from kirigami.model.constraints import Prescribe as Prescribe
    from kirigami.model.constraints import Symmetry as Symmetry
    from kirigami.model.constraints import Tie as Tie
    from kirigami.model.edge_moment import EdgeMoment as EdgeMoment
    from kirigami.model.flow_pressure import FlowPressure as FlowPressure
    from kirigami.model.grip import Grip as Grip
    from kirigami.model.grip import RigidLink as RigidLink
    from kirigami.model.loads import NodalLoad as NodalLoad
    from kirigami.model.model import Model as Model
    from kirigami.model.pressure import Pressure as Pressure
    from kirigami.model.spread_loads import AreaLoad as AreaLoad
    from kirigami.model.spread_loads import EdgeLoad as EdgeLoad
    from kirigami.model.spread_loads import Gravity as Gravity
    from kirigami.model.turn import Turn as Turn
    from kirigami.primitives.check_kernel import check_kernel as check_kernel
    from kirigami.primitives.kernel import Contribution as Contribution
    from kirigami.primitives.kernel import Kernel as Kernel
    from kirigami.primitives.kernel import Tangent as Tangent
    from kirigami.primitives.kernel import displacement_of as displacement_of
    from kirigami.primitives.laminate import Laminate as Laminate
    from kirigami.primitives.material import Material as Material
    from kirigami.primitives.material import Orthotropic as Orthotropic
    from kirigami.primitives.node import Node as Node
    from kirigami.primitives.parts import ModelObject as ModelObject
    from kirigami.primitives.parts import Numbering as Numbering
    from kirigami.primitives.rubber import NeoHookean as NeoHookean
    from kirigami.results.archive import load as load
    from kirigami.results.results import Results as Results
    from kirigami.results.step import Event as Event
    from kirigami.results.step import Step as Step
    from kirigami.study.load_case import LoadCase as LoadCase
    from kirigami.study.stretch import stretch as stretch
    from kirigami.sweep.sampling import latin_hypercube as latin_hypercube
    from kirigami.sweep.sweep import Sweep as Sweep
    from kirigami.sweep.table import SweepTable as SweepTable
    from kirigami.system.system import System as System


def __getattr__(name: str) -> Any:
    if name in _HOME:
        value = getattr(importlib.import_module(f"kirigami.{_HOME[name]}"), name)
    elif name in _MODULES:
        value = importlib.import_module(f"kirigami.{_MODULES[name]}")
    else:
        from kirigami.errors import nearest_name

        near = nearest_name(name, __all__)
        hint = f": did you mean {near!r}?" if near else ""
        # Without an object to look at, Python has no hint of its own to add.
        raise AttributeError(f"module 'kirigami' has no attribute {name!r}{hint}", name=name, obj=None)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted(__all__)
