"""Studies: many runs of one model, told in one table and one picture."""

from __future__ import annotations

from kirigami.study.accuracy import AccuracyStudy, accuracy
from kirigami.study.bracket import Bracket, bracket
from kirigami.study.branches import branches
from kirigami.study.error_estimate import ErrorEstimate, estimate_error
from kirigami.study.imperfections import Case, ImperfectionStudy, imperfections, seeds
from kirigami.study.mesh_choice import MeshChoice, MeshRun, choose_mesh
from kirigami.study.report import Report, stretch_drawing, write_report

__all__ = [
    "AccuracyStudy",
    "Bracket",
    "Case",
    "ErrorEstimate",
    "ImperfectionStudy",
    "MeshChoice",
    "MeshRun",
    "Report",
    "accuracy",
    "bracket",
    "branches",
    "choose_mesh",
    "estimate_error",
    "imperfections",
    "seeds",
    "stretch_drawing",
    "write_report",
]
