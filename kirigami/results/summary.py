"""What an analysis found and what it took, as text; a method of Results."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from kirigami.results.doubts import worth
from kirigami.words import counted

if TYPE_CHECKING:
    from kirigami.results.results import Results


def summary(results: Results) -> str:
    """What was computed, how it went, and where the time went, as text."""
    stats, steps = results.stats, results.steps
    unknowns = int(np.count_nonzero(~results.constrained))
    size = f"{counted(len(results.rest), 'node')} in {results.dim}D, {counted(unknowns, 'unknown')}"
    lines = [f"{results.name or 'model'}: {size}"]
    if results.moves:
        kinetic = results.energy["kinetic"]
        stored = sum(float(values[-1]) for values in results.energy.values()) - kinetic[-1]
        lines.append(
            f"{counted(len(steps), 'stored moment')}, time {results.time[0]:.6g} to {results.time[-1]:.6g}, load "
            f"factor {results.lam[0]:.6g} to {results.lam[-1]:.6g}, kinetic energy at most {kinetic.max():.4g}, "
            f"{kinetic[-1]:.4g} at the end; energy stored at the end {stored:.4g}"
        )
        if "energy_drift" in stats:
            drift = stats["energy_drift"]
            lines.append(f"total energy kept within {drift:.1e} of the largest kinetic energy")
    elif steps:
        stable = int(np.count_nonzero(results.stable))
        lines.append(
            f"{counted(len(steps), 'stored step')}, load factor {steps[0].lam:.6g} to {steps[-1].lam:.6g}, "
            f"{stable} stable, largest relative residual {np.nanmax(results.residual):.1e}"
        )
    lines.append(
        f"{counted(stats['iterations'], 'iteration')}, {counted(stats['factorizations'], 'factorization')} "
        f"({stats['backend'] or 'none'}), {counted(stats['cutbacks'], 'cutback')}, "
        f"{counted(stats['relaxations'], 'relaxation')}"
    )
    lines += [f"event: {event}" for event in results.events] + results.shape_words
    lines += worth(results)
    seconds = stats["seconds"]
    total = seconds.get("total", sum(seconds.values()))
    parts = sorted(((name, value) for name, value in seconds.items() if name != "total"), key=lambda p: -p[1])
    lines.append(f"{total:.2f} s: " + ", ".join(f"{name} {value:.2f}" for name, value in parts))
    return "\n".join(lines)
