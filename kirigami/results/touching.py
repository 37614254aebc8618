"""Stored steps in which a sheet touches itself or an obstacle, told as events."""

from __future__ import annotations

import numpy as np

from kirigami.results.results import Results
from kirigami.results.step import Event

TOLD = "contacts_told"  # in the stats: stored steps that were looked at
KIND = "contact"
SELF_CONTACT = "self-contact"


def note_contacts(results: Results) -> None:
    """Bring the events "contact" up to date: one for each run of stored steps in which parts of a sheet touch.

    Nothing happens without a :class:`kirigami.SelfContact`, which alone knows what touches.
    """
    # By its name, since a model without contact does not load what contact needs.
    held = next((kernel for kernel in results.kernels if kernel.name == SELF_CONTACT), None)
    if held is None or results.stats.get(TOLD) == len(results.steps):
        return
    found: list[Event] = []
    apart: float | None = None  # when they last were
    met = False
    for number, step in enumerate(results.steps):
        when = step.time if results.moves else step.lam
        force = np.linalg.norm(results.evaluate_at(held, step, held.deformation), axis=1)
        if not force.any():
            apart, met = when, False
            continue
        what = "time" if results.moves else "load factor"
        if met:
            last = found[-1]
            begun = last.message.split("; until")[0]
            found[-1] = Event(KIND, last.lam, last.step, f"{begun}; until {what} {when:.6g}", last.bracket)
            continue
        met = True
        place = (results.rest + step.u)[held.conn[int(force.argmax()), 0]]
        where = ", ".join(f"{value:.4g}" for value in place)
        between = f"at {what} {when:.6g}" if apart is None else f"between {what}s {apart:.6g} and {when:.6g}"
        last_apart = max(number - 1, 0)
        before = results.steps[last_apart].lam
        message = f"parts of the sheet touch {between}, first near ({where})"
        found.append(Event(KIND, 0.5 * (before + step.lam), last_apart, message, (before, step.lam)))
    results.events[:] = [event for event in results.events if event.kind != KIND] + found
    results.stats[TOLD] = len(results.steps)
