"""Studies: many runs of one model, told in one table and one picture."""

from __future__ import annotations

from kirigami.study.accuracy import AccuracyStudy, accuracy
from kirigami.study.bracket import Bracket, bracket
from kirigami.study.branches import branches
from kirigami.study.error_estimate import ErrorEstimate, estimate_error
from kirigami.study.imperfections import Case, ImperfectionStudy, imperfections, seeds
from kirigami.study.mesh_choice import MeshChoice, MeshRun, choose_mesh
from kirigami.study.report import Report, stretch_drawing, write_report
from kirigami.study.shape_links import Branch, Link
from kirigami.study.shape_study import Shape, ShapeStudy
from kirigami.study.shapes import shapes

__all__ = [
    "AccuracyStudy",
    "Bracket",
    "Branch",
    "Case",
    "ErrorEstimate",
    "ImperfectionStudy",
    "Link",
    "MeshChoice",
    "MeshRun",
    "Report",
    "Shape",
    "ShapeStudy",
    "accuracy",
    "bracket",
    "branches",
    "choose_mesh",
    "estimate_error",
    "imperfections",
    "seeds",
    "shapes",
    "stretch_drawing",
    "write_report",
]
