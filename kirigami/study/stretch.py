"""A sheet held and moved as a load case says, in one call: what the command line does, without files."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from kirigami.analysis.path.methods import DisplacementControl, LoadControl
from kirigami.elements.stiffness import Calibration
from kirigami.errors import ConvergenceError, KirigamiError, KirigamiWarning, ModelError
from kirigami.geometry.mesh import TriMesh
from kirigami.geometry.sheet import Sheet
from kirigami.model.model import Model
from kirigami.primitives.checks import (
    require_boolean,
    require_callable,
    require_choice,
    require_finite,
    require_instance,
    require_positive,
    require_whole,
)
from kirigami.primitives.kernel import Array
from kirigami.primitives.material import SheetMaterial, uniaxial_stiffness
from kirigami.primitives.node import Node
from kirigami.results.drives import Drive
from kirigami.results.results import Results
from kirigami.scale import Scale
from kirigami.study.folding import fold
from kirigami.study.grips import find_grips
from kirigami.study.load_case import STRAIN, LoadCase
from kirigami.study.setting import set_up
from kirigami.words import counted


@dataclass(frozen=True)
class Level:
    """What a word for accuracy stands for: a stiffness, a budget of mesh nodes, and a relative residual."""

    stiffness: str
    nodes: int
    tol: float


ACCURACY = {
    "draft": Level("plate", 2500, 1e-6),
    "standard": Level("shell", 1500, 1e-8),
    "fine": Level("shell", 6000, 1e-8),
}
STORED = (0.002, 0.005, 0.01, 0.02, 0.05, *np.linspace(0.1, 1.0, 10).tolist())  # shares of the pull that are stored
TURN = 8.0  # degrees that a twisted grip turns from one stored state to the next
LOCKED = 0.05  # mean strain of the material beyond which cuts no longer give way


def stretch(
    sheet: Sheet,
    strain: float = STRAIN,
    direction: str | float = "y",
    accuracy: str = "standard",
    *,
    thickness: float | Mapping[str | None, float] | None = None,
    material: SheetMaterial | Mapping[str | None, SheetMaterial] | None = None,
    cycle: bool = False,
    grip: float | None = None,
    nodes: int | None = None,
    max_edge: float | None = None,
    stiffness: str | Calibration | None = None,
    amplitude: float | None = None,
    seed: int = 0,
    shapes: bool = False,
    case: LoadCase | None = None,
    progress: bool = False,
    say: Callable[[str], None] | None = None,
) -> Results:
    """Hold a sheet, pull, push, shear, twist or lift it, and follow it through buckling.

    The grips clamp the two ends of the sheet along the direction: its edges there where they are straight, else strips
    of 4 % of its length. They keep their shape, and one of them moves by strain times the free length between them.

    Folds of the sheet are elastic hinges. Where they do not rest flat, the sheet first folds, while the grip that will
    be moved slides and bears no force; what is done counts from there, strains over the free length of the flat sheet.

    Parameters
    ----------
    sheet : Sheet
        The sheet, in any unit.
    strain : float
        Grip displacement over the free length between the grips, to be reached; negative to push.
    direction : "x", "y" or float
        Of the pull; an angle is in degrees from x, counter-clockwise. The end the direction points to is moved.
    accuracy : {"draft", "standard", "fine"}
        How much to pay for: the stiffness, the budget of mesh nodes and the residual, each of which can be given by
        itself as well. What bars and hinges cannot stand for is shell facets in a draft, too.
    thickness : float or mapping of str to float, optional
        Of the sheet [length], or of its regions by name and, under None, of the rest; None takes the sheet's own.
    material : Material or mapping of str to Material, optional
        The same.
    cycle : bool
        Go there and back again.
    grip : float, optional
        Length of the strips that are held [length]; 0 holds the edges alone.
    nodes : int, optional
        Budget of mesh nodes; None takes that of the accuracy.
    max_edge : float, optional
        Longest edge of the mesh [length], in the place of a budget.
    stiffness : str or Calibration, optional
        As for :meth:`kirigami.Model.from_mesh`.
    amplitude : float, optional
        Height of the stress-free imperfection [length], see :meth:`kirigami.Model.imperfect`; 0 leaves the sheet
        flat, None takes what that takes.
    seed : int
        Of the imperfection: another number is another field.
    shapes : bool
        Also look which other shapes the sheet can take at the whole strain, see :func:`kirigami.study.shapes`: the
        study is in ``results.shapes``, and ``results.summary()`` says which of them the pull led to. Some minutes more.
    case : LoadCase, optional
        Everything that is done to the sheet, in the place of strain, direction, cycle and grip.
    progress : bool
        Show a progress bar.
    say : callable, optional
        Called with each note as soon as it is known, so that a slip shows before the path is followed.

    Returns
    -------
    Results
        Load factor 1 is the whole strain, or whatever else the case asks for. ``grips["held"]`` and ``grips["moved"]``
        are the nodes of the grips (their indices, once saved and loaded): ``reaction(grips["moved"], "y")`` is the
        force of a pull along y. Places of a case are there as ``grips["lifted centre"]``, ``grips["held rim"]``. After
        Ctrl-C what was found until then.

    Raises
    ------
    ModelError
        A request that makes no sense, a place that is not on the sheet, or no thickness or material.
    GeometryError
        The sheet cannot be meshed.
    ConvergenceError
        The sheet could not be followed all the way: the message says how far, ``error.results`` is the path up
        to there.

    Warns
    -----
    KirigamiWarning
        Where the material itself is stretched so much that the sheet is locked.

    Examples
    --------
    >>> import shapely
    >>> import kirigami as kg
    >>> strip = kg.Sheet(shapely.box(0, 0, 0.02, 0.1), thickness=1e-4, material=kg.Material(E=2e9, nu=0.0))
    >>> res = kg.stretch(strip, strain=0.001, accuracy="draft", stiffness="facet", max_edge=0.02, amplitude=0)
    >>> round(float(res.reaction(res.grips["moved"], "y")[-1]), 1)
    4.0
    """
    say = _in_silence if say is None else require_callable(say, "say", "stretch")
    require_boolean(shapes, "shapes", "stretch")
    case = _checked_case(case, strain, direction, cycle, grip)
    require_boolean(progress, "progress", "stretch")
    if nodes is not None:
        require_whole(nodes, "nodes", "stretch", least=1)
        if max_edge is not None:
            raise ModelError("stretch: give `max_edge` or a budget of `nodes`, not both")
    level = _level(accuracy)
    regional: dict[str, Any] = {name: given for name, given in (("thickness", thickness), ("material", material))
                                if isinstance(given, Mapping)}  # fmt: skip
    sheet = _checked(sheet, _of_the_rest(thickness), _of_the_rest(material))
    setting = set_up(case, sheet)
    for words in setting.told:
        say(words)
    mesh = default_mesh(sheet, setting.lines, level.nodes if nodes is None else nodes, max_edge)
    size = f"{counted(len(mesh.nodes), 'node')}, {counted(len(mesh.triangles), 'facet')}"
    say(size if mesh.sizing is None else f"mesh: {mesh.sizing}")
    if stiffness is None:
        stiffness = level.stiffness
        materials = [sheet.material, *regional.get("material", {}).values()]
        directed = next((one for one in materials if isinstance(one, SheetMaterial) and not one.isotropic), None)
        if directed is not None and stiffness != "shell":
            stiffness = "shell"
            say(f"shell facets, since bars and hinges cannot stand for {type(directed).__name__}")
    model = Model.from_mesh(mesh, stiffness=stiffness, **regional)
    chosen = setting.hold(model)
    model.imperfect(amplitude, seed=seed)
    start = None
    if any(line.angle for line in mesh.folds):
        start, shift = fold(model, chosen.get("moved", []), level.tol)
        if setting.grips is not None:
            left = 1 + float(shift[:2] @ setting.grips.direction) / setting.grips.free_length
            say(f"folded: the grips are {100 * left:.4g} % of the free length of the flat sheet apart")

    def named(results: Results) -> Results:
        results.grip_nodes = {name: model.index(nodes) for name, nodes in chosen.items()}
        results.drives = setting.drives
        return results

    end = 0.0 if case.cycle else 1.0
    control = DisplacementControl if case.moves else LoadControl
    analysis = control(model, targets=stored(case), to=end, tol=level.tol, start=start)
    try:
        results = named(analysis.run(progress=progress))
    except ConvergenceError as error:
        if error.results is not None:
            named(error.results)
        raise _short_of(error, setting.drives[0], case.cycle, sheet.scale) from error
    _warn_of_lock(results, sheet, setting.drives[0])
    if shapes and not any(event.kind == "interrupted" for event in results.events):
        look_for_shapes(results, seed, progress, say)
    return results


def look_for_shapes(results: Results, seed: int, progress: bool, say: Callable[[str], None]) -> None:
    """Search for the shapes of a sheet at the furthest step of a pull, and note in the results which one that is."""
    from kirigami.study.shape.shapes import shapes

    end = results.steps[int(np.abs(results.lam).argmax())]
    say(f"looking for other shapes at load factor {end.lam:g}")
    try:
        results.shapes = shapes(results.model, at=end.lam, seed=seed, starts=[end], progress=progress)
    except KirigamiError as error:  # the path is there all the same
        warnings.warn(f"the search for other shapes failed: {error}", KirigamiWarning, stacklevel=3)
        return
    results.shape_words = results.shapes.words(end)


def stored(case: LoadCase) -> list[float]:
    """Load factors whose states are stored; close enough that a grip turns by no more than the path can predict."""
    shares = set(STORED)
    legs = int(np.ceil(abs(case.twist) / TURN))
    shares |= {round(share, 12) for share in np.linspace(0.0, 1.0, legs + 1)[1:].tolist()}
    there = sorted(shares)
    return [*there, *there[-2::-1]] if case.cycle else there


def pulled_sheet(
    sheet: Sheet, max_edge: float, direction: str, strain: float, stiffness: str = "plate"
) -> tuple[Model, list[Node]]:
    """Model of a sheet with its imperfection between its grips, to be pulled, and the nodes that are pulled."""
    grips = find_grips(sheet, direction)
    model = Model.from_mesh(default_mesh(sheet, grips.lines(), None, max_edge), stiffness=stiffness)
    _, moved = grips.hold(model, strain * grips.free_length)
    model.imperfect()
    return model, moved


def _level(accuracy: str) -> Level:
    require_choice(accuracy, ACCURACY, "accuracy", "stretch")
    return ACCURACY[accuracy]


def _of_the_rest(given: Any) -> Any:
    """What a property is outside of the regions that have one of their own."""
    return given.get(None) if isinstance(given, Mapping) else given


def _checked(sheet: Sheet, thickness: float | None, material: SheetMaterial | None) -> Sheet:
    """The sheet with its thickness and material."""
    if not isinstance(sheet, Sheet):
        raise ModelError(
            f"stretch takes a Sheet, got {type(sheet).__name__}; Sheet.from_dxf and its kin read drawings"
        )
    thickness = sheet.thickness if thickness is None else thickness
    material = sheet.material if material is None else material
    if isinstance(material, SheetMaterial):
        thickness = material.checked_thickness(thickness, "stretch")
    if thickness is None or material is None:
        missing = "thickness" if thickness is None else "material"
        raise ModelError(f"stretch: the sheet has no {missing}: give one to the Sheet or to stretch")
    thickness = require_positive(thickness, "thickness", "stretch")
    checked = Sheet(sheet.outline, sheet.cuts, thickness, material, sheet.folds, sheet.regions)
    checked.scale = sheet.scale
    return checked


def _checked_case(
    case: LoadCase | None, strain: float, direction: str | float, cycle: bool, grip: float | None
) -> LoadCase:
    """The case, from its own description or from the arguments for a plain pull."""
    require_boolean(cycle, "cycle", "stretch")
    strain = require_finite(strain, "strain", "stretch")
    if case is None:
        return LoadCase(strain, direction, grip, cycle=cycle)
    require_instance(case, LoadCase, "case", "stretch")
    if strain != STRAIN or direction != "y" or cycle or grip is not None:
        raise ModelError("stretch: give strain, direction, cycle and grip to the LoadCase, not beside it")
    return case


def default_mesh(sheet: Sheet, lines: dict[str, Any], nodes: int | None, max_edge: float | None) -> TriMesh:
    """The mesh of a sheet with lines, within a budget of nodes unless a longest edge is given."""
    if max_edge is not None or nodes is None:
        return sheet.mesh(max_edge, lines=lines)
    return sheet.mesh(nodes=round(require_positive(nodes, "nodes", "stretch")), lines=lines)


def _short_of(error: ConvergenceError, drive: Drive, cycle: bool, scale: Scale) -> ConvergenceError:
    """The failure of a path in terms of what was asked for."""
    reached = 0.0 if error.results is None or not len(error.results) else float(error.results.lam[-1])
    way = drive.says(1.0, scale) + (" and back" if cycle else "")
    message = str(error).partition("\nHint: ")[0]
    return ConvergenceError(
        f"the sheet was followed to a {drive.motion} of {drive.says(reached, scale)} on the way to {way}: {message}",
        results=error.results,
        history=error.history,
        worst_nodes=error.worst_nodes,
        hint="the path so far is in error.results; another amplitude or a finer mesh may lead on",
    )


def material_strain(results: Results, sheet: Sheet) -> Array:
    """Mean strain of the material (s,), sqrt(2 U / (E V)) with U the stored energy and V the volume of the sheet; of
    one that is not isotropic in the stiffer direction."""
    mesh = results.mesh
    assert mesh is not None and results.thickness is not None and results.material is not None
    count = len(mesh.triangles)
    heights = np.broadcast_to(results.thickness, (count,)).tolist()
    materials = results.material if isinstance(results.material, tuple) else (results.material,) * count
    each = {kind: uniaxial_stiffness(kind[0].section(kind[1])) for kind in set(zip(materials, heights))}
    shares = mesh.facet_areas / mesh.facet_areas.sum()
    stiffness = float(sum(share * each[kind] for share, kind in zip(shares.tolist(), zip(materials, heights))))
    stored = [values for name, values in results.energy.items() if name not in ("dissipated", "kinetic")]
    energy = np.sum(stored, axis=0)
    strain: Array = np.sqrt(np.maximum(2 * energy / (stiffness * sheet.area), 0.0))
    return strain


def _warn_of_lock(results: Results, sheet: Sheet, drive: Drive) -> None:
    beyond = np.flatnonzero(material_strain(results, sheet) > LOCKED)
    if beyond.size and sheet.material is not None and not sheet.material.hyperelastic:
        reached = drive.says(float(results.lam[beyond[0]]), sheet.scale)
        warnings.warn(
            f"at a {drive.motion} of {reached} the material itself is strained by {100 * LOCKED:g} % on average: the "
            "sheet is locked from about there, and what lies beyond follows a linear law that materials may not",
            KirigamiWarning,
            stacklevel=3,
        )


def _in_silence(note: str) -> None:
    """In the place of print."""
