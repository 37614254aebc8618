"""What the test of arguments leaves out, and the values that a parameter takes on purpose, each with its reason."""

from __future__ import annotations

import importlib
from collections.abc import Callable
from typing import Any

ANSWER = "an answer of the package, not made by users"
CONTRACT = "the contract between kernels and the assembly: called with arrays of the package, in the innermost loop"
ERRORS = "an error that the package raises"
STEPS = "a piece of a running analysis, called by it alone"
# Patterns of names.
NOT_CALLED: dict[str, str] = {
    **dict.fromkeys(
        """Mode Results Step Event Rigidity Framework bloch.GuestMode tilings.Gap tilings.Neck stiffness.SheetConstants
        study.AccuracyStudy study.Bracket study.Branch study.Case study.ErrorEstimate study.ImperfectionStudy study.Link
        study.MeshChoice study.MeshRun study.Report study.Report.text study.Shape study.ShapeStudy
        study.write_report InverseResult InverseResult.*
        study.Comparison study.Measured study.Place study.Place.*""".split(),
        ANSWER,
    ),
    **dict.fromkeys(
        """Kernel Kernel.* *.lower *.reserve Bar.held Facet.held BendHinge.held TorsionSpring3.held Crease.held
        Grip.known Contribution Tangent displacement_of ModelObject Numbering* stiffness.SheetConstants.* *.elasticity
        *.weights *.section *.checked_thickness *.mass_per_area *.free_strain *.heated""".split(),
        CONTRACT,
    ),
    **dict.fromkeys(("*Error", "*Warning"), ERRORS),
    **dict.fromkeys(
        """*Control.make_control ArcLength.make_control *.memorable *.goes_downhill *.chosen_for *.plan *.steer *.stops
        Results.append Results.evaluate_at Results.forget_model Results.member_* Results.told Results.once
        Results.object_number
        Results.step_number Results.configuration Results.rows System.joined System.settled System.parted System.c*
        System.displacement System.forces System.imbalance System.l* System.begin System.go_on_from
        System.admissible System.multiply System.matrix System.motion System.small_displacement
        System.plan_with System.potential_rate System.re*
        System.start_stage System.stiffness_blocks System.unknowns System.drive_* System.part System.known*
        System.factored System.straighten Design.derivatives""".split(),
        STEPS,
    ),
    "Normal": "made by the rung that needs it",
    "CurvedFacet": "made by the rung that needs it",
    "Results.to_xarray": "needs xarray, which is an extra; takes no argument",
    "post.shape.check*": "a check itself",
    "post.opening.areas": "of loops that open_area has checked",
    "stiffness.rung_named": "a check itself",
    "post.curvature.angle_rows": "a piece of curvature, called by it alone",
    "post.curvature.CurvatureFit*": "a piece of curvature and of the state of a sheet, which give it checked meshes",
    "post.shape.principal_values": "a piece of other measures, called by them alone",
    "study.compare": "the job behind `kirigami stretch --compare`, whose arguments are tested there",
    "study.Job.run": "the job behind `kirigami stretch`, whose arguments are tested there",
    "study.stretch_drawing": "the job behind `kirigami stretch`, whose arguments are tested there",
}


def _function(path: str) -> Callable[[], Any]:
    module, name = path.split(":")
    return lambda: getattr(importlib.import_module(f"kirigami.{module}"), name)


# Functions that take the options which a method hands on.
OPTIONS: dict[str, Callable[[], Any]] = {
    "Sheet.from_dxf": _function("drawing.dxf:read_dxf"),
    "Sheet.from_svg": _function("drawing.svg:read_svg"),
    "Sheet.from_geojson": _function("drawing.geojson:read_geojson"),
    "Sheet.from_fold": _function("drawing.fold:read_fold"),
}
LABEL, GREY = "any words do", "a level of grey is written as text, and None is matplotlib's next colour"
# Parameters that take any text.
FREE_TEXT: dict[tuple[str, str], str] = dict.fromkeys(
    (
        ("Model", "name"), ("Node", "name"), ("Results.plot", "label"), ("Results.plot_curve", "label"),
        ("Results.to_html", "title"), ("Results.to_vtk", "name"), ("plot.plot_curve", "label"),
        ("plot.plot_gradient", "label"),
        ("plot.plot_measure", "name"), ("plot.plot_measure", "label"), ("plot.plot_open_area", "label"),
        ("plot.plot_results", "label"), ("tilings.Tiling.model", "name"),
    ),
    LABEL,
)  # fmt: skip
# The name of a region, of which only a mesh knows whether it is there.
FREE_TEXT |= {
    (name, "facets"): "a region, looked up in a run"
    for name in ("AreaLoad", "Gravity", "Pressure", "FlowPressure", "Actuate")
}
# Parameters that take one of the bad values on purpose: the reason, and which.
ACCEPTED: dict[tuple[str, str], tuple[str, tuple[str, ...]]] = {
    ("DisplacementControl", "targets"): ("no targets", ("empty list",)),
    ("LoadControl", "targets"): ("no targets", ("empty list",)),
    ("SelfContact", "obstacles"): ("no obstacles", ("empty list", "empty array", "dict")),
    ("Sheet", "cuts"): ("no cuts", ("empty list",)),
    ("CellSheet", "cuts"): ("no cuts", ("empty list",)),
    ("Design", "cuts"): ("no cuts", ("empty list",)),
    ("Design", "folds"): ("no folds", ("empty list",)),
    ("Sheet", "folds"): ("no folds", ("empty list",)),
    ("TriMesh", "folds"): ("no folds", ("empty list",)),
    ("TriMesh.with_folds", "folds"): ("no folds", ("empty list",)),
    ("LoadCase", "hold"): ("nothing held", ("dict", "empty list", "empty array")),
    ("LoadCase", "lift"): ("nothing lifted", ("dict", "empty list", "empty array")),
    ("LoadCase.from_plain", "kept"): ("a pull as usual", ("dict",)),
    ("study.Job", "reading"): ("no options", ("dict",)),
    ("study.Job", "regions"): ("none", ("dict",)),
    **dict.fromkeys(
        (("study.Job", "thickness"), ("study.Job", "E"), ("study.Job", "max_edge"), ("study.Job", "imperfection"),
         ("study.Job", "density"), ("study.Job", "fold_stiffness")),
        ("a number without a unit is in SI units", ("number as text",)),
    ),
    ("TriMesh.with_cuts", "cuts"): ("as in TriMesh: every inner boundary is a cut", ("None",)),
    ("TriMesh.with_sets", "mine"): ("a set without nodes", ("empty list", "empty array")),
    ("units.parse", "text"): ("a number without a unit is in SI units", ("number as text",)),
    **dict.fromkeys(
        (
            ("Results.plot_curve", "color"), ("plot.plot_curve", "color"), ("plot.plot_measure", "color"),
            ("plot.plot_open_area", "color"), ("Sheet.plot", "fill"), ("Sheet.plot", "cut_color"),
            ("plot.plot_sheet", "fill"), ("plot.plot_sheet", "cut_color"),
        ),
        (GREY, ("number as text", "None")),
    ),
}  # fmt: skip
# Calls that are right but take longer than a test may.
TOO_LONG: dict[tuple[str, str, str], str] = {
    ("study.choose_mesh", "error", "tiny"): "meshes as fine as the error asks for, four of them",
    ("stretch", "max_edge", "None"): "the mesh of a whole budget of nodes",
    ("stretch", "shapes", "bool"): "a search for other shapes, which tests/test_stretch.py makes",
}
# Answers that may be nan on purpose.
NAN_MEANS: dict[str, str] = {
    "study.AccuracyStudy.values": "a run that did not get there, as documented",
    "Results.poisson_ratio": "not defined where there is no strain, as documented",
    "post.shape.poisson_ratio": "not defined where there is no strain, as documented",
}
ANY_KEYWORD: dict[str, str] = {"TriMesh.with_sets": "keywords are the names of the sets"}
