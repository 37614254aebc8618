"""Studies: many runs of one model, told in one table and one picture."""

from __future__ import annotations

from kirigami.study.accuracy import AccuracyStudy, accuracy
from kirigami.study.bracket import Bracket, bracket
from kirigami.study.branches import branches
from kirigami.study.error_estimate import ErrorEstimate, estimate_error
from kirigami.study.imperfections import Case, ImperfectionStudy, imperfections, seeds
from kirigami.study.job import Job
from kirigami.study.measured import Comparison, Measured, compare, read_measured
from kirigami.study.mesh_choice import MeshChoice, MeshRun, choose_mesh
from kirigami.study.places import Place, place
from kirigami.study.report import Report, write_report
from kirigami.study.run_job import stretch_drawing
from kirigami.study.shape.links import Branch, Link
from kirigami.study.shape.shapes import shapes
from kirigami.study.shape.study import Shape, ShapeStudy

__all__ = [
    "AccuracyStudy",
    "Bracket",
    "Branch",
    "Case",
    "Comparison",
    "ErrorEstimate",
    "ImperfectionStudy",
    "Job",
    "Link",
    "Measured",
    "MeshChoice",
    "MeshRun",
    "Place",
    "Report",
    "Shape",
    "ShapeStudy",
    "accuracy",
    "bracket",
    "branches",
    "choose_mesh",
    "compare",
    "estimate_error",
    "imperfections",
    "place",
    "read_measured",
    "seeds",
    "shapes",
    "stretch_drawing",
    "write_report",
]
