"""What it costs to carry thin cut sheets from flat to 20 % stretch, by corrector.

    python benchmarks/correctors.py                              every sheet, imperfection and corrector not yet done
    python benchmarks/correctors.py --sheet ring cells --corrector newton --imperfection 1e-3
    python benchmarks/correctors.py --thin                       second part: other thicknesses, to 40 %
    python benchmarks/correctors.py --table                      print the table of what is done
"""

from __future__ import annotations

import argparse
import csv
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np
import shapely
from shapely import LineString, Point, box

import kirigami as kg

FACTORIZATIONS, SECONDS = 1500, 300.0  # limits of one run
STRAIN = 0.2
GRIP = 0.1  # half-width of the grips of the round sheets


def _slit_disc() -> tuple[Any, Any]:
    return kg.cuts.single_slit_disc(0.5, 0.43, 0.0, 96)


def _ring() -> tuple[Any, Any]:
    return Point(0, 0).buffer(0.5, quad_segs=24).difference(Point(0, 0).buffer(0.3, quad_segs=24)), []


# name: outline and cuts, largest edge, edge along the cuts. Every sheet has the size 1 and at least 2,000 nodes, with
# at least three facets across its narrowest ligament.
SHEETS: dict[str, tuple[Callable[[], tuple[Any, Any]], float, float | None]] = {
    "one slit": (lambda: (box(0, 0, 1, 1), [LineString([(0.25, 0.5), (0.75, 0.5)])]), 0.027, None),
    "staggered": (
        lambda: (box(0, 0, 1, 1), kg.cuts.parallel_slits(2, 7, 1.0, 0.84, 0.36, margin=0.08)),
        0.033,
        0.0265,
    ),
    "disc": (_slit_disc, 0.024, None),
    "random": (
        lambda: (box(0, 0, 1, 1), kg.cuts.random_slits(14, 1, 1, (0.15, 0.35), seed=3, gap=0.05)),
        0.035,
        0.016,
    ),
    "cross": (
        lambda: (box(0, 0, 1, 1), [LineString([(0.3, 0.4), (0.7, 0.6)]), LineString([(0.4, 0.7), (0.6, 0.3)])]),
        0.027,
        None,
    ),
    "parallel": (
        lambda: (box(0, 0, 1, 1), [LineString([(0.2, y), (0.8, y)]) for y in (0.2, 0.4, 0.6, 0.8)]),
        0.03,
        None,
    ),
    "cells": (lambda: (box(0, 0, 1, 1.2), kg.cuts.curved_cells(2, 3, 1.0, 1.0, margin=0.1)), 0.035, 0.02),
    "ring": (_ring, 0.018, None),
}
TUNING = ("one slit", "staggered", "disc", "random")  # correctors were tuned on these; the others are held out
IMPERFECTIONS = (0.0, 1e-6, 1e-3)  # amplitude of the first eigenmode over the thickness
CORRECTORS: dict[str, dict[str, Any]] = {"newton": {}}


def sheet_model(name: str, thickness: float, imperfection: float, strain: float) -> kg.Model:
    """The sheet, held at the bottom and pulled at the top; grip displacement over the distance of the grips is `strain`."""
    geometry, edge, cut_edge = SHEETS[name]
    outline, cuts = geometry()
    mesh = kg.Sheet(outline, cuts).mesh(edge, cut_edge=cut_edge)
    m = kg.Model.from_mesh(mesh, thickness, kg.Material(E=1.0, nu=1 / 3))
    m.name = name
    y = mesh.nodes[:, 1]
    if outline.bounds[0] < 0:
        low, high = (
            m.select(boundary="outer", where=lambda x, y, z, side=side: (np.abs(x) < GRIP + 1e-9) & (side * y > 0))
            for side in (-1, 1)
        )
    else:
        low, high = m.select(boundary="bottom"), m.select(boundary="top")
    m.add(kg.Fix(low), kg.Fix(high, "xz"), kg.Prescribe(high, y=strain * float(np.ptp(y))))
    if imperfection:
        m.perturb(kg.Eigen(m, n=1).run()[0], amplitude=imperfection * thickness)
    return m


class OutOfBudget(Exception):
    """More factorisations or seconds than allowed."""


class Locked(Exception):
    """Stretching stores more energy than bending again."""


class Counted(kg.DisplacementControl):
    """Displacement control that stops at a limit of factorisations or seconds."""

    allowed, seconds, began = FACTORIZATIONS, SECONDS, 0.0

    def _factorize(self, system: Any, results: Any, matrix: Any) -> Any:
        if results.stats["factorizations"] >= self.allowed or time.perf_counter() - self.began > self.seconds:
            raise OutOfBudget
        return super()._factorize(system, results, matrix)


def lock() -> Callable[[kg.Step], None]:
    """A recorder that ends the run once more than half of the energy is in stretching, after bending had more."""
    state = {"bent": False}

    def watch(analysis: Counted) -> Callable[[kg.Step], None]:
        def record(step: kg.Step) -> None:
            energy = analysis.system.energies(step.u)
            share = energy["bars"] / max(sum(energy.values()), 1e-300)
            if share < 0.5:
                state["bent"] = True
            elif state["bent"]:
                raise Locked

        return record

    return watch
