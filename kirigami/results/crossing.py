"""Stored steps in which a sheet passes through itself, told as events."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from kirigami.primitives.kernel import Array
from kirigami.results.results import Results
from kirigami.results.scale import scale_of
from kirigami.results.step import Event, Step
from kirigami.words import counted

CHECKED = "crossings_checked"  # in the stats: stored steps that were looked at


def note_crossings(results: Results) -> None:
    """Bring the events "crossing" up to date: one for each run of stored steps in which the sheet crosses itself.

    The surface is that of the corners of the facets. Nothing happens without a mesh, in the plane, after a linear
    analysis, or where `ipctk` is not installed.
    """
    if results.stats.get(CHECKED) == len(results.steps) or not _can_cross(results):
        return
    from kirigami.post.crossing import can_search  # in the plane nothing of this is read

    if not can_search():
        return
    results.events[:] = [event for event in results.events if event.kind != "crossing"]
    results.events.extend(_found(results))
    results.stats[CHECKED] = len(results.steps)


def words_on_crossings(results: Results) -> list[str]:
    """What must be said of crossings beside the events: that nobody looked, or what is found now that somebody does."""
    if results.stats.get(CHECKED) == len(results.steps) or not _can_cross(results):
        return []
    from kirigami.post.crossing import INSTALL, can_search

    if not can_search():
        return [f"not checked whether the sheet passes through itself: {INSTALL}"]
    return [event.message for event in _found(results)]


def _can_cross(results: Results) -> bool:
    mesh = results.mesh
    if mesh is None or results.dim < 3 or results.linear or not results.steps:
        return False
    return bool(np.ptp(results.rest[:, 2]) or any(step.u[:, 2].any() for step in results.steps))


def _surface(results: Results) -> Callable[[Step], Array]:
    """What finds the crossings (k, 3) of a step: of the facets, or of the surface that contact holds apart."""
    from kirigami.post.crossing import crossings

    mesh = results.mesh
    assert mesh is not None

    def found(step: Step) -> Array:
        places = results.rest + step.u
        held = (kernel.held_surface(places) for kernel in results.kernels)
        return crossings(*next((one for one in held if one is not None), (places, mesh.edges, mesh.triangles)))

    return found


def _found(results: Results) -> list[Event]:
    surface = _surface(results)
    found: list[Event] = []
    open_since: int | None = None
    for number, step in enumerate(results.steps):
        places = surface(step)
        if not len(places):
            open_since = None
            continue
        lam, when = step.lam, f"load factor {step.lam:.6g}"
        if results.moves:
            when = f"time {step.time:.6g}"
        if open_since is None:
            open_since = number
            first = (
                f"the sheet passes through itself at {when}, at {counted(len(places), 'place')}, one of them "
                f"{scale_of(results).place(places[0])}: the shape is wrong there; kg.SelfContact holds it apart"
            )
            found.append(Event("crossing", lam, number, first, (lam, lam)))
        else:
            last = found[-1]
            begun = last.message.split("; until")[0]
            found[-1] = Event("crossing", last.lam, last.step, f"{begun}; until {when}", (last.bracket[0], lam))
    return found
