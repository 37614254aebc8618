"""Studies: many runs of one model, told in one table and one picture."""

from __future__ import annotations

from kirigami.study.accuracy import AccuracyStudy, accuracy
from kirigami.study.branches import branches
from kirigami.study.error_estimate import ErrorEstimate, estimate_error
from kirigami.study.imperfections import Case, ImperfectionStudy, imperfections, seeds

__all__ = [
    "AccuracyStudy",
    "Case",
    "ErrorEstimate",
    "ImperfectionStudy",
    "accuracy",
    "branches",
    "estimate_error",
    "imperfections",
    "seeds",
]
