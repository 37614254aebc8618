"""What gradients are worth: two designs searched for with them, by a simplex and by a genetic search of SciPy.

The problems are a hidden ribbon of benchmarks/hidden_designs.py, three lengths by a curve of four forces, and the
silhouette of examples/silhouette.py, three lengths by three places. All searches follow equilibria from design to
design alike, start from the same design (the genetic one from the ranges), and end where every target is met within
1 %, or after as many designs as are allowed.

``python benchmarks/derivative_free.py`` adds the rows that are missing to ``results/derivative_free.csv``, and prints
the table.
"""

from __future__ import annotations

import sys
import time
import warnings
from pathlib import Path

import numpy as np

import kirigami as kg
from kirigami.design.branch import Branch

sys.path.insert(0, str(Path(__file__).parent))
sys.path.insert(0, str(Path(__file__).parent.parent / "examples"))
import hidden_designs
import silhouette
import tables

TABLE = Path(__file__).parent / "results" / "derivative_free.csv"
MET = 0.01
ALLOWED = {"adjoint": 40, "Nelder-Mead": 150, "differential evolution": 300}


class Found(Exception):
    """The targets are met."""


def ribbon():
    """A start, and targets: (functional, load factors, values, size)."""
    searched, hidden, start = ["low", "left", "high"], *hidden_designs.hidden_and_start(1)[1:]
    start = np.where(np.isin(hidden_designs.NAMES, searched), 0.8 * hidden, hidden)
    design = hidden_designs.ribbon(searched, start)
    values = dict(zip(hidden_designs.NAMES, hidden))
    wanted = hidden_designs.forces(design.at({name: values[name] for name in searched}))
    return design, [(hidden_designs.FORCE, hidden_designs.LAMS, wanted, float(wanted.max()))]


def strip():
    """The same of the silhouette."""
    size = max(silhouette.INWARD)
    return silhouette.strip(), [
        (("point", (0.0, y), "x"), [1.0], [inward], size) for y, inward in zip(silhouette.AT, silhouette.INWARD)
    ]


def errors_of(branch, targets):
    """Errors over the sizes of all targets."""
    found = []
    for functional, lams, values, size in targets:
        for lam, value in zip(lams, values):
            found.append((branch.asked(functional, lam, slopes=False).value - value) / size)
    return np.array(found)


def without_derivatives(design, targets, method):
    """Errors of all designs tried, and factorisations."""
    from scipy.optimize import differential_evolution, minimize

    lams = sorted({lam for _, lams, _, _ in targets for lam in lams})
    branch, tried = Branch(design, lams), []
    ends = np.array([design.bounds[name] for name in design.free])

    def worth(x):
        if len(tried) >= ALLOWED[method]:
            raise Found
        try:
            branch.go_to(design.at(np.clip(x, ends[:, 0], ends[:, 1])))
            errors = errors_of(branch, targets)
        except kg.KirigamiError:
            errors = np.ones(1)
        tried.append(float(np.abs(errors).max()))
        if tried[-1] < MET:
            raise Found
        return float((errors**2).sum())

    try:
        if method == "Nelder-Mead":
            minimize(worth, design.vector, method=method, bounds=ends, options={"maxfev": 10 * ALLOWED[method]})
        else:
            differential_evolution(worth, ends, popsize=6, seed=1, polish=False, maxiter=1000)
    except Found:
        pass
    return tried, branch.factorizations


def run(problem, method):
    design, targets = {"ribbon": ribbon, "silhouette": strip}[problem]()
    began = time.process_time()
    if method == "adjoint":
        search = kg.Inverse(design, targets, corrections=None, evaluations=ALLOWED[method] - 1, enough=MET)
        found = search.run()
        tried, tangents = [entry["error"] for entry in found.history], found.factorizations
    else:
        tried, tangents = without_derivatives(design, targets, method)
    seconds = time.process_time() - began
    met = next((number + 1 for number, error in enumerate(tried) if error < MET), "")
    return {
        "problem": problem, "search": method, "met_after_designs": met, "designs": len(tried),
        "best_error": f"{np.nanmin(tried):.1e}", "factorisations": tangents, "cpu_s": f"{seconds:.0f}",
    }  # fmt: skip


def main():
    warnings.simplefilter("ignore", kg.KirigamiWarning)
    rows = tables.read(TABLE)
    done = {(row["problem"], row["search"]) for row in rows}
    for problem in ("ribbon", "silhouette"):
        for method in ALLOWED:
            if (problem, method) in done:
                continue
            row = run(problem, method)
            tables.add(TABLE, row)
            rows.append(row)
    for row in rows:
        print(*row.values(), sep=", ")


if __name__ == "__main__":
    main()
