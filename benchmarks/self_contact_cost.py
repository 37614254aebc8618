"""What self-contact costs: the share of a run's processor time that goes into it, and how many facets touch meanwhile.

Counted are the pairs, forces, tangents and ways of the contact, the places of its entries in the matrix, every order of
elimination beyond the first, and what is told of contacts and crossings at the end. What it changes in the path, more
and shorter steps, is physics and not counted.

    python benchmarks/self_contact_cost.py [loop | slits | stack]
"""

from __future__ import annotations

import sys
import time
import warnings
from collections.abc import Callable
from typing import Any

import numpy as np
import shapely

import kirigami as kg
from kirigami.analysis import resumable
from kirigami.effects.self_contact import SelfContactKernel
from kirigami.linalg import multifrontal
from kirigami.system.coupling_plan import CouplingPlan

PET = kg.Material(3.5e9, 0.3)


def loop() -> kg.Results:
    """A strip with clamped ends pushed together until its legs touch, and on."""
    length, width, t = 0.1, 0.01, 1e-4
    sheet = kg.Sheet(shapely.box(0, 0, length, width), [], thickness=t, material=PET)
    m = kg.Model.from_mesh(sheet.mesh(nodes=250), stiffness="shell")
    left, right = m.select(boundary="left"), m.select(boundary="right")
    m.add(kg.Fix(left, clamp=True), kg.Fix(right, "yz", clamp=True), kg.Prescribe(right, x=-length))
    m.add(kg.SelfContact())
    m.perturb(2 * t * np.sin(np.pi * m.positions()[:, 0] / length) ** 2)
    return kg.DisplacementControl(m, to=0.9, targets=[0.8, 0.9]).run()


def slits() -> kg.Results:
    """A slit sheet pushed together and sideways."""
    cuts = list(kg.cuts.parallel_slits(columns=1, rows=2, width=1.0, height=1.0, length=0.7, margin=0.1))
    sheet = kg.Sheet(shapely.box(0, 0, 1, 1), cuts, thickness=0.01, material=PET)
    m = kg.Model.from_mesh(sheet.mesh(nodes=200), stiffness="shell")
    bottom, top = m.select(boundary="bottom"), m.select(boundary="top")
    m.add(kg.Fix(bottom, clamp=True), kg.Prescribe(top, x=0.15, y=-0.5, z=0.1), kg.SelfContact())
    m.perturb(0.01 * np.sin(np.pi * m.positions()[:, 1]) * np.cos(3 * m.positions()[:, 0]))
    return kg.DisplacementControl(m).run(on_failure="return")


def stack() -> kg.Results:
    """A flap of a sheet, cut free on three sides, bent over until it lies on the sheet."""
    flap = shapely.LineString([(0.3, 0.1), (0.7, 0.1), (0.7, 0.5), (0.3, 0.5)])
    sheet = kg.Sheet(shapely.box(0, 0, 1, 1), [flap], thickness=0.004, material=PET)
    m = kg.Model.from_mesh(sheet.mesh(nodes=250), stiffness="shell")
    x = m.positions()
    tip = [node for node in m.nodes if abs(node.x - 0.7) < 1e-9 and 0.1 < node.y < 0.5]
    rim = m.select(boundary="left")
    m.add(kg.Fix(rim, clamp=True), kg.SelfContact(), kg.NodalLoad(tip, (-4.0, 0, 6.0)))
    m.perturb(0.002 * np.sin(np.pi * x[:, 0]))
    return kg.LoadControl(m).run(on_failure="return")


CASES: dict[str, Callable[[], kg.Results]] = {"loop": loop, "slits": slits, "stack": stack}


class Meter:
    """Adds up the processor time within some functions, each counted once where they call each other."""

    def __init__(self) -> None:
        self.seconds: dict[str, float] = {}
        self._busy = False

    def watch(self, owner: Any, name: str, skip: int = 0) -> None:
        """Count a function; its first `skip` calls would have been made without contact."""
        plain = getattr(owner, name)
        calls = 0

        def counted(*given: Any, **more: Any) -> Any:
            nonlocal calls
            calls += 1
            if self._busy or calls <= skip:
                return plain(*given, **more)
            self._busy, started = True, time.process_time()
            try:
                return plain(*given, **more)
            finally:
                self._busy = False
                self.seconds[name] = self.seconds.get(name, 0.0) + time.process_time() - started

        setattr(owner, name, counted)


def touching(res: kg.Results) -> np.ndarray:
    """Share of the facets (s,) of which two corners bear a force."""
    assert res.mesh is not None
    pressed = np.linalg.norm(res.force("self-contact"), axis=2) > 0
    return np.asarray((pressed[:, res.mesh.triangles].sum(axis=2) > 1).mean(axis=1))


def main() -> None:
    warnings.simplefilter("ignore")
    meter = Meter()
    for name in ("evaluate", "coupling", "admissible", "commit", "check_start"):
        meter.watch(SelfContactKernel, name)
    meter.watch(CouplingPlan, "matrix")
    meter.watch(resumable, "note_contacts")
    meter.watch(resumable, "note_crossings")
    meter.watch(multifrontal, "dissect", skip=1)
    for name in sys.argv[1:] or CASES:
        meter.seconds.clear()
        started = time.process_time()
        res = CASES[name]()
        whole = time.process_time() - started
        share = touching(res)
        counts = res.stats
        parts = ", ".join(f"{key} {value:.2f}" for key, value in sorted(meter.seconds.items(), key=lambda p: -p[1]))
        print(
            f"{name}: {len(res.rest)} nodes, {len(res)} steps, {counts['factorizations']} factorisations; facets that "
            f"touch {100 * share[share > 0].mean():.1f} % on average where any do, {100 * share.max():.1f} % at most; "
            f"contact {100 * sum(meter.seconds.values()) / whole:.1f} % of {whole:.1f} s ({parts})"
        )


if __name__ == "__main__":
    main()
