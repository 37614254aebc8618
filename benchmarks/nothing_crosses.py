"""Random slit sheets with self-contact, pushed together and twisted at random, or folded over: does anything cross?

    python benchmarks/nothing_crosses.py [--sheets 1000] [--folded 200] [--first 0] [--minutes 15] [--nodes 70]

Each sheet is a square with random slits, clamped at the bottom. A pushed one has its top moved by up to 0.6 of its
height in a random direction; a folded one has its top brought to within a tenth of its bottom, so that its halves lie
on each other. Every stored step is looked at: the surface that is held must not pass through itself. Sheets whose
run ends early, without an equilibrium, are counted as well; their steps up to there are looked at too. A sheet that
crosses is named by its seed. Ends after the minutes with what was done by then.
"""

from __future__ import annotations

import argparse
import time
import warnings

import numpy as np
import shapely

import kirigami as kg
from kirigami.effects.self_contact import SelfContactKernel
from kirigami.post.crossing import crossings

MATERIAL = kg.Material(E=3.5e9, nu=0.0)


def random_sheet(seed: int, folded: bool, nodes: int = 70) -> kg.Results:
    """One sheet, by its seed."""
    rng = np.random.default_rng([seed, folded])
    slits = kg.cuts.random_slits(int(rng.integers(2, 6)), 1.0, 1.0, (0.2, 0.6), seed=seed, margin=0.1, gap=0.1)
    sheet = kg.Sheet(shapely.box(0, 0, 1, 1), list(slits), thickness=0.01, material=MATERIAL)
    m = kg.Model.from_mesh(sheet.mesh(nodes=nodes), stiffness="plate")
    bottom, top = m.select(boundary="bottom"), m.select(boundary="top")
    x, y, z = 0.6 * rng.uniform(-1, 1, 3)
    if folded:
        x, y, z = 0.1 * x, -rng.uniform(0.9, 0.95), 0.03 + 0.05 * abs(z)
    else:
        y = -0.3 - abs(y) / 2
    m.add(kg.Fix(bottom, clamp=True), kg.Prescribe(top, x=x, y=y, z=z), kg.SelfContact())
    height = m.positions()[:, 1]
    bump = 0.2 * np.sin(np.pi * height) if folded else 0.0
    m.perturb(bump + 0.02 * rng.normal(size=len(height)) * (0.5 - np.abs(height - 0.5)))
    return kg.DisplacementControl(m, corrector="newton").run(on_failure="return")


def places_crossed(res: kg.Results) -> int:
    """Crossings of the surface that is held, over all stored steps."""
    kernel = next(kernel for kernel in res.kernels if isinstance(kernel, SelfContactKernel))
    return sum(len(crossings(kernel.held_at(res.rest + s.u), kernel.edges, kernel.triangles)) for s in res.steps)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--sheets", type=int, default=1000)
    parser.add_argument("--folded", type=int, default=200)
    parser.add_argument("--first", type=int, default=0, help="seed of the first")
    parser.add_argument("--minutes", type=float, default=15.0)
    parser.add_argument("--nodes", type=int, default=70)
    given = parser.parse_args()
    warnings.simplefilter("ignore")
    ends = time.monotonic() + 60 * given.minutes
    jobs = {False: given.sheets, True: given.folded}
    tally = {kind: dict.fromkeys(("sheets", "touched", "to the end", "no mesh", "steps"), 0) for kind in jobs}
    crossed: list[str] = []
    order = sorted((k / max(count, 1), kind, k) for kind, count in jobs.items() for k in range(count))
    for _, kind, k in order:
        if time.monotonic() > ends:
            break
        seed, own = given.first + k, tally[kind]
        try:
            res = random_sheet(seed, kind, given.nodes)
        except (kg.GeometryError, kg.ModelError) as error:  # slits that a mesh of this size cannot hold
            own["no mesh"] += 1
            print(f"{'folded' if kind else 'pushed'} {seed}: {error}", flush=True)
            continue
        own["sheets"] += 1
        own["steps"] += len(res)
        own["touched"] += any(event.kind == "contact" for event in res.events)
        own["to the end"] += bool(res.lam[-1] > 1 - 1e-9)
        if places_crossed(res):
            crossed.append(f"{'folded' if kind else 'pushed'} {seed}")
    for kind, own in tally.items():
        print("folded:" if kind else "pushed:", ", ".join(f"{name} {value}" for name, value in own.items()))
    print(f"crossed: {len(crossed)}", *crossed)


if __name__ == "__main__":
    main()
