"""Running a path analysis."""

from __future__ import annotations

from collections.abc import Iterable

from kirigami.analysis.path.settings import PathSettings
from kirigami.analysis.path.walk import Walk
from kirigami.analysis.resumable import Recorder


class PathAnalysis(PathSettings):
    """Common part of the path methods; see :class:`LoadControl`, :class:`DisplacementControl`, :class:`ArcLength`."""

    def _make_walk(self, recorders: Iterable[Recorder]) -> Walk:
        return Walk(self, recorders)
