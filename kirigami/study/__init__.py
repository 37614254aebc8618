"""Studies: many runs of one model, told in one table and one picture."""

from __future__ import annotations

from kirigami.study.accuracy import AccuracyStudy, accuracy
from kirigami.study.bracket import Bracket, bracket
from kirigami.study.branches import branches
from kirigami.study.error_estimate import ErrorEstimate, estimate_error
from kirigami.study.imperfections import Case, ImperfectionStudy, imperfections, seeds
from kirigami.study.mesh_choice import MeshChoice, MeshRun, choose_mesh

__all__ = [
    "AccuracyStudy",
    "Bracket",
    "Case",
    "ErrorEstimate",
    "ImperfectionStudy",
    "MeshChoice",
    "MeshRun",
    "accuracy",
    "bracket",
    "branches",
    "choose_mesh",
    "estimate_error",
    "imperfections",
    "seeds",
]
