"""Hidden designs found again from their force curves, against a search without derivatives.

A ribbon with three rows of slits; a design drawn at random is hidden, its curve of four forces is what is wanted, and
the search starts with every length about 20 % off, to either side. It may try forty designs. ``python
benchmarks/hidden_designs.py [trials] [first seed]`` prints a row for each trial, also those that fail;
``compare`` in the place of the trials tells evaluations and seconds beside the simplex of Nelder and Mead.
"""

from __future__ import annotations

import sys
import time

import numpy as np
import shapely

import kirigami as kg
from kirigami.design.branch import Branch
from kirigami.results.gradients.functionals import tell_of

LAMS = [0.25, 0.5, 0.75, 1.0]
FORCE = ("force", "driven_0", "y")
MET = 0.01  # of the largest force


def cuts(low, middle, high):
    """Slits in the middle, at the sides and in the middle again."""
    lines = [[(0.05 - 0.03 * low, 0.02), (0.05 + 0.03 * low, 0.02)]]
    lines += [[(0, 0.05), (0.035 * middle, 0.05)], [(0.1 - 0.035 * middle, 0.05), (0.1, 0.05)]]
    lines += [[(0.05 - 0.03 * high, 0.08), (0.05 + 0.03 * high, 0.08)]]
    return [shapely.LineString(line) for line in lines]


def pulled(m):
    top = m.select(boundary="top")
    m.add(kg.Fix(m.select(boundary="bottom"), clamp=True), kg.Fix(top, "xz", clamp=True), kg.Prescribe(top, y=0.006))


def ribbon():
    return kg.Design(
        cuts, outline=shapely.box(0, 0, 0.1, 0.1), supports=pulled, thickness=8e-4, material=kg.Material(2e9, 0.3),
        mesh={"max_edge": 0.025, "cut_edge": 0.02}, low=(1.0, 0.6, 1.4), middle=(1.0, 0.6, 1.25), high=(1.0, 0.6, 1.4),
    )  # fmt: skip


def forces(design):
    res = design.walk(LAMS, tol=1e-10)
    return np.array([res.reaction("driven_0", "y")[int(np.argmin(np.abs(res.lam - lam)))] for lam in LAMS])


def hidden_and_start(seed):
    random = np.random.default_rng(seed)
    hidden = random.uniform(0.85, 1.1, 3)
    start = np.clip(hidden * (1 + 0.2 * random.choice([-1, 1], 3)), 0.62, [1.38, 1.23, 1.38])
    return hidden, start


def trial(seed):
    hidden, start = hidden_and_start(seed)
    here = ribbon()
    wanted = forces(here.at(hidden))
    began = time.process_time()
    found = kg.Inverse(here.at(start), (FORCE, LAMS, wanted), corrections=None, evaluations=40).run()
    seconds = time.process_time() - began
    away = np.abs(np.array(list(found.values.values())) / hidden - 1).max()
    flat = float(np.abs(forces(found.design) / wanted - 1).max())
    good = found.coarse_error < MET and flat < MET
    print(
        f"seed {seed}: {'met' if good else 'FAILED'}, error {found.coarse_error:.1e}, walked from flat {flat:.1e}, "
        f"parameters off by {away:.1e}, {found.evaluations} designs, {found.walks} walks, {found.factorizations} "
        f"factorisations, {seconds:.1f} CPU s",
        flush=True,
    )
    return good


def compare(seed):
    from scipy.optimize import minimize

    hidden, start = hidden_and_start(seed)
    here = ribbon()
    wanted = forces(here.at(hidden))
    began, branch, tried = time.process_time(), Branch(here.at(start), LAMS), []

    def worth(x):
        try:
            branch.go_to(here.at(np.clip(x, 0.6, [1.4, 1.25, 1.4])))
            tell = tell_of(FORCE, branch.results)
            error = np.array([at.told(tell).value for at in branch.at]) / wanted.max() - wanted / wanted.max()
        except kg.KirigamiError:
            error = np.ones(4)
        tried.append(np.abs(error).max())
        return float((error**2).sum())

    minimize(worth, start, method="Nelder-Mead", options={"maxfev": 120, "xatol": 1e-5, "fatol": 1e-12})
    first = next((k + 1 for k, error in enumerate(tried) if error < 1e-3), None)
    print(
        f"Nelder-Mead, seed {seed}: best error {min(tried):.1e} in {len(tried)} designs, below 1e-3 after {first}, "
        f"{branch.factorizations} factorisations, {time.process_time() - began:.1f} CPU s",
        flush=True,
    )
    found = kg.Inverse(here.at(start), (FORCE, LAMS, wanted), corrections=None).run()
    errors = [entry["error"] for entry in found.history]
    first = next((k + 1 for k, error in enumerate(errors) if error < 1e-3), None)
    print(
        f"adjoint, seed {seed}: best error {np.nanmin(errors):.1e} in {len(errors)} designs, below 1e-3 after {first}, "
        f"{found.factorizations} factorisations",
        flush=True,
    )


if __name__ == "__main__":
    if sys.argv[1:2] == ["compare"]:
        compare(int(sys.argv[2]) if len(sys.argv) > 2 else 1)
    else:
        count, first = (int(sys.argv[k]) if len(sys.argv) > k else default for k, default in ((1, 20), (2, 1)))
        print(sum(trial(first + k) for k in range(count)), "of", count, "met")
