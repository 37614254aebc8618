"""Gradients of results: what an end state tells, by thickness, modulus, strain, places, members or a design."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from kirigami.errors import AnalysisError, ModelError
from kirigami.primitives.checks import require_instance, shown
from kirigami.primitives.kernel import Array
from kirigami.results.gradients import critical
from kirigami.results.gradients.equilibrium import Adjoint, Equilibrium, prepared, weighted
from kirigami.results.gradients.fields import FIELDS, of_positions, of_sheet
from kirigami.results.gradients.functionals import Tell, _parts, tell_of
from kirigami.results.results import Results
from kirigami.results.step import Step
from kirigami.system.system import System

STEP = 1e-4  # of the load factor, to both sides, in the difference that makes a stiffness


def gradient(results: Results, functional: Any, wrt: Any, step: int = -1) -> Any:
    """How a number that an equilibrium tells changes with the structure, by the adjoint method.

    It costs one factorisation and one solution for each functional, whatever the number of parameters. The equilibrium
    is first found to the last digits; what is driven stays driven.

    Parameters
    ----------
    functional : tuple, callable or list of these
        What is asked for; of a list all share the factorisation.

        * ``("force", nodes, axis)``: force of a support on the structure, as :meth:`Results.reaction`.
        * ``("position", nodes, axis)``: mean place of nodes [length]; ``("point", (x, y), axis)``: place of the
          point of the sheet that is drawn there. ``("height",)``, ``("width", axis)``, ``("poisson_ratio", axis)``,
          ``("open_area",)``: as the methods of these names; the area is that of all cuts, or of those numbered in
          ``("open_area", cuts)``.
        * ``("strain", power)``: mean of a power of the size sqrt(exx^2 + eyy^2 + 2 exy^2) of the strain in the plane of
          the facets, and the root of it; with the power 3 it may be left out. Between 1 and 4: from 4 on the tips of
          cuts, and with them the mesh, decide alone.
        * ``("shape", target)``: mean squared distance [length^2] of all nodes from a target shape (n, 3), laid over
          them as well as a rigid motion can.
        * ``("energy",)``: the energy stored.
        * ``("stiffness", nodes, axis)``: change of that force over that of the place of the nodes, along the path.
        * ``("critical", event)``: load factor of a limit point or bifurcation of ``results.events``, by its number.
        * ``function(positions, forces)`` of arrays (n, 3) that returns a number, or also its derivatives by both;
          forces are those of the supports on the nodes, and about zero at nodes that are free.
    wrt : str, tuple or Design
        With respect to what.

        * "thickness", "E": of each facet (facets,). ``("thickness", region)``: of a region of the mesh, or
          ``("thickness", None)`` of the whole sheet, as one number.
        * "strain", "curvature": at which the facets bear nothing, (facets, 3), in the axes and signs of
          :class:`Actuate` and there in full; only on the shell rung.
        * "positions": places of the nodes at rest (n, 3), without stress, as :meth:`Model.perturb` moves them.
        * "bars.EA", "hinges.stiffness", "springs.rest_angle", ...: an array of a kernel, by the name of the kernel and
          of the array, in the order of the objects; also of your own effects. Those of a sheet are its bars and hinges.
        * a :class:`Design`: a dict of numbers, by the names of its parameters; at its present values.
    step : int
        Number of the step; the last by default.

    Returns
    -------
    ndarray, float or dict
        Units of the functional over those of the parameter; a list of them for a list of functionals.

    Raises
    ------
    ModelError
        Unknown functionals or parameters, members whose state depends on the way (friction), forces without a
        potential, a model that was edited since.
    AnalysisError
        Results without a model, of a linear analysis or of a motion; a singular tangent; what is not finite.

    Notes
    -----
    dJ/dp = d/dp (J - mu . r) at fixed unknowns, with K mu = dJ/dq. Near a limit point mu grows without bound, and so
    does the gradient at a fixed load factor. For critical load factors lam_c with the null vector phi,
    d lam_c/dp = -phi.(dr/dp) / phi.(dr/dlam) at limit points, and at bifurcations
    -phi.(dK/dp + dK/dq q_p) phi / phi.(dK/dlam + dK/dq q_lam) phi.

    Examples
    --------
    A bar: the force of a support that drives it grows with EA as it does itself.

    >>> import kirigami as kg
    >>> m = kg.Model(dim=2)
    >>> a, b = m.add(kg.Node(0, 0), kg.Node(2, 0))
    >>> objects = m.add(kg.Bar(a, b, EA=10.0), kg.Fix(a), kg.Fix(b, "y"), kg.Prescribe(b, x=0.2))
    >>> res = kg.DisplacementControl(m).run()
    >>> round(float(res.gradient(("force", b, "x"), "bars.EA")[0] * 10.0 / res.reaction(b, "x")[-1]), 9)
    1.0
    """
    number = results.step_number(step, "gradient")
    listed = functional if isinstance(functional, list) else [functional]
    if not listed:
        raise ModelError("gradient: give a functional at least")
    _check(results, results[number])
    answers: list[Any] = [None] * len(listed)
    plain: list[tuple[int, Tell]] = []
    for position, item in enumerate(listed):
        kind = None if callable(item) else _parts(item, "gradient")[0]
        if kind == "stiffness":
            answers[position] = _of_stiffness(results, results[number], item, wrt)
        elif kind == "critical":
            answers[position] = critical.gradient(results, item, lambda adjoints: _derivatives(adjoints, wrt))
        else:
            plain.append((position, tell_of(item, results)))
    if plain:
        at = equilibrium(results, results[number])
        adjoints = at.adjoints([at.told(tell) for _, tell in plain])
        for (position, _), answer in zip(plain, _derivatives(adjoints, wrt)):
            answers[position] = answer
    return answers if isinstance(functional, list) else answers[0]


def _check(results: Results, step: Step) -> None:
    if results.linear:
        raise AnalysisError(
            "gradient: these are results of a linear analysis; run LoadControl or DisplacementControl", results=results
        )
    if step.velocity is not None:
        raise AnalysisError("gradient: a moment of a motion is no equilibrium, so it has no gradient", results=results)
    model = results.model
    unchanged = np.array_equal(model.positions(), results.rest) and model.objects == results.objects
    if not unchanged or (step.stage_key and step.stage_key != model.stage_key):
        raise ModelError(
            "gradient: the model was edited since these results were found, or holds another stage: run it once more"
        )


def equilibrium(results: Results, step: Step, lam: float | None = None, system: System | None = None) -> Equilibrium:
    """The equilibrium of a stored step, or next to it at another load factor."""
    system = prepared(results.model, step.history) if system is None else system
    u = system.joined(step.u, step.inner)
    found = Equilibrium(system, u, step.lam if lam is None else lam)
    if lam is None and system.largest_rotation(found.u - u) > 0.05:
        raise AnalysisError("gradient: the step is no equilibrium of the model as it is now: run it once more")
    return found


def stiffness_pair(at: Equilibrium, tells: tuple[Tell, Tell]) -> tuple[list[Equilibrium], float, float]:
    """Equilibria a little below and above, and the rates of a force and of a place between them."""
    span = STEP * (abs(at.lam) or 1.0)
    sides = [Equilibrium(at.system, at.u, at.lam + sign * span) for sign in (1.0, -1.0)]
    force, place = (sides[0].told(tell).value - sides[1].told(tell).value for tell in tells)
    return sides, force / (2 * span), place / (2 * span)


def stiffness(
    at: Equilibrium, functional: Any, results: Results, owner: str = "gradient", slopes: bool = True
) -> tuple[float, list[tuple[float, Adjoint]]]:
    """A stiffness, and with `slopes` its derivative as a sum of weights times those of adjoints, two for each side."""
    if len(functional) != 3:
        raise ModelError(f"{owner}: give ('stiffness', nodes, axis)")
    tells = tell_of(("force", *functional[1:]), results, owner), tell_of(("position", *functional[1:]), results, owner)
    sides, force, place = stiffness_pair(at, tells)
    if not place:
        raise ModelError(f"{owner}: these nodes do not move with the load factor, so they have no stiffness")
    share = 1.0 / (2 * STEP * (abs(at.lam) or 1.0) * place)
    parts = [
        (sign * weight, adjoint)
        for side, sign in zip(sides, (1.0, -1.0))
        for weight, adjoint in zip((share, -share * force / place), side.adjoints([side.told(tell) for tell in tells]))
    ] if slopes else []  # fmt: skip
    return force / place, parts


def _of_stiffness(results: Results, step: Step, functional: Any, wrt: Any) -> Any:
    _, parts = stiffness(equilibrium(results, step), functional, results)
    weights, adjoints = zip(*parts)
    return weighted(weights, [rate for side in (adjoints[:2], adjoints[2:]) for rate in _derivatives(side, wrt)])


def _derivatives(adjoints: Sequence[Adjoint], wrt: Any) -> list[Any]:
    """Derivatives of the functionals of one equilibrium."""
    system = adjoints[0].at.system
    if hasattr(wrt, "derivatives"):
        found: list[Any] = wrt.derivatives(adjoints)
        return found
    if isinstance(wrt, tuple) and len(wrt) == 2 and wrt[0] in ("thickness", "E", "strain", "curvature"):
        rows = slice(None) if wrt[1] is None else _region(system, wrt[1])
        values = [field[rows].sum(axis=0) for field in of_sheet(adjoints, wrt[0], "gradient")]
        return [float(value) if np.ndim(value) == 0 else value for value in values]
    require_instance(wrt, str, "wrt", "gradient", "the name of a field or of an array of a kernel, or a Design")
    if wrt == "positions":
        return list(of_positions(adjoints, "gradient"))
    if wrt in FIELDS:
        return list(of_sheet(adjoints, wrt, "gradient"))
    return [_of_members(adjoint, wrt) for adjoint in adjoints]


def _region(system: System, name: Any) -> Array:
    mesh = system.model.mesh
    if mesh is None or name not in mesh.regions:
        known = "none" if mesh is None else ", ".join(map(repr, mesh.regions)) or "none"
        raise ModelError(f"gradient: the mesh has no region {shown(name)} (there are: {known})")
    return np.asarray(mesh.regions[name])


def _of_members(adjoint: Adjoint, wrt: str) -> Array:
    """By an array of the kernels of one name, in the order of their objects."""
    system = adjoint.at.system
    kind, _, array = wrt.rpartition(".")
    kernels = [kernel for kernel in system.kernels if kernel.name == kind]
    parts = [adjoint.of_member_arrays(kernel) for kernel in kernels]
    if not kernels or any(array not in part for part in parts):
        known = sorted(
            f"{kernel.name}.{name}" for kernel in system.kernels if kernel.name != "shell"
            for name in adjoint.of_member_arrays(kernel)
        )
        raise ModelError(
            f"gradient: nothing is called {wrt!r}: take one of {', '.join(FIELDS)}, {', '.join(known)}, or a Design"
        )
    place = [np.arange(len(k.conn)) if k.members is None else np.asarray(k.members) for k in kernels]
    total = np.zeros((int(max(rows.max() for rows in place)) + 1, *parts[0][array].shape[1:]))
    for rows, part in zip(place, parts):
        np.add.at(total, rows, part[array])
    return total

