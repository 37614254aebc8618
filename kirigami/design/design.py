"""A sheet given by a few numbers: one mesh that moves with them, and how everything changes with each."""

from __future__ import annotations

import inspect
import warnings
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from kirigami.analysis.path.methods import DisplacementControl, LoadControl
from kirigami.deferred import deferred
from kirigami.design.chain import STEP, Chain
from kirigami.design.potentials import Changed, potentials
from kirigami.elements.stiffness import rung_named
from kirigami.errors import GeometryError, KirigamiWarning, ModelError
from kirigami.geometry.fold_line import FoldEdges
from kirigami.geometry.mesh import TriMesh
from kirigami.geometry.moving import POOR, Follower, check_topology, with_nodes
from kirigami.geometry.sheet import Sheet
from kirigami.model.model import Model
from kirigami.primitives.checks import (
    require_array,
    require_callable,
    require_choice,
    require_finite,
    require_instance,
    require_mapping,
    require_positive,
    require_whole,
    shown,
)
from kirigami.primitives.kernel import Array
from kirigami.primitives.material import SheetMaterial
from kirigami.results.gradients.equilibrium import Adjoint
from kirigami.results.results import Results
from kirigami.study.load_case import LoadCase
from kirigami.study.setting import set_up
from kirigami.words import counted


class Design:
    """A sheet whose cuts, thickness and material are functions of named parameters.

    One mesh moves with the parameters, as :meth:`TriMesh.moved` does, so that everything is a smooth function of them;
    the imperfection is a fixed field of the design. So a sweep over a parameter gives a smooth curve, and
    ``results.gradient(functional, design)`` the derivative by each.

    Parameters
    ----------
    cuts : callable or sequence of geometries
        ``cuts(**parameters)`` returns the cuts: as many, with as many corners each, whatever the parameters. It is
        given those parameters that it names.
    outline : shapely.Polygon, sequence of (x, y), or callable
        The sheet, or a function of parameters.
    supports : callable or LoadCase
        ``supports(model)`` adds supports and loads to a model of the sheet; a :class:`LoadCase` does what it does for
        :func:`kirigami.stretch`, and :meth:`export` writes it with the drawing.
    thickness : float, tuple or callable
        Thickness [length], a function of parameters, or ``(start, low, high)``, which makes it a parameter.
    material : Material, Orthotropic, Laminate, NeoHookean or callable
        The material, or a function of parameters.
    folds : Fold, sequence of Folds, or callable
        Creases, as of a :class:`Sheet`, or a function of parameters that returns them: as many, with as many corners.
    mesh : mapping, optional
        Arguments of :meth:`Sheet.mesh`; by default ``{"nodes": 1000}``.
    stiffness : str
        Rung of accuracy, as in :meth:`Model.from_mesh`.
    imperfection : float, optional
        Its amplitude [length], as in :meth:`Model.imperfect`; 0 is a flat sheet.
    seed : int
        Another number is another imperfection.
    **parameters : float or (start, low, high)
        The parameters: a value, or a value with the range it may have. Only those with a range are searched for by
        :class:`Inverse`.

    Attributes
    ----------
    values : dict of str to float
        The parameters.
    bounds : dict of str to (float, float)
        Their ranges; infinite where none is given.

    Raises
    ------
    ModelError
        No parameter, a parameter that no function takes, a value that is no number or out of its range.
    GeometryError
        Cuts that meet, reach or leave the outline where they did not before, change in number or corners, or turn a
        facet of the mesh over.

    Warns
    -----
    KirigamiWarning
        Where the moved mesh gets poor; :meth:`remeshed` makes a new one.

    Examples
    --------
    >>> import shapely, kirigami as kg
    >>> def cuts(length):
    ...     return [shapely.LineString([(0.5 - length / 2, 0.5), (0.5 + length / 2, 0.5)])]
    >>> def pulled(m):
    ...     top = m.select(boundary="top")
    ...     m.add(kg.Fix(m.select(boundary="bottom")), kg.Fix(top, "xz"), kg.Prescribe(top, y=0.02))
    >>> design = kg.Design(cuts, outline=shapely.box(0, 0, 1, 1), supports=pulled, thickness=0.01,
    ...                    material=kg.Material(E=1e6), mesh={"max_edge": 0.4}, length=(0.5, 0.2, 0.8))
    >>> longer = design.at(length=0.6)
    >>> len(longer.mesh.nodes) == len(design.mesh.nodes), longer.values
    (True, {'length': 0.6})
    """

    def __init__(
        self,
        cuts: Any,
        *,
        outline: Any,
        supports: Callable[[Model], Any] | LoadCase,
        thickness: Any = None,
        material: Any = None,
        folds: Any = (),
        mesh: Mapping[str, Any] | None = None,
        stiffness: str = "shell",
        imperfection: float | None = None,
        seed: int = 0,
        **parameters: Any,
    ) -> None:
        if isinstance(thickness, tuple):
            parameters["thickness"] = thickness
            thickness = _take_thickness
        if not parameters:
            raise ModelError("Design: give a parameter at least, as length=0.5 or length=(0.5, 0.2, 0.8)")
        self.values: dict[str, float] = {}
        self.bounds: dict[str, tuple[float, float]] = {}
        for name, given in parameters.items():
            self.values[name], self.bounds[name] = _parameter(name, given)
        self.stiffness = rung_named(stiffness, "Design")
        self.case = supports if isinstance(supports, LoadCase) else None
        self._hold = None if self.case is not None else require_callable(supports, "supports", "Design")
        settings = {"nodes": 1000} if mesh is None else dict(require_mapping(mesh, "mesh", "Design"))
        self.mesh_settings: dict[str, Any] = settings
        self._made = {"cuts": cuts, "outline": outline, "thickness": thickness, "material": material, "folds": folds}
        if thickness is not None and not callable(thickness):
            require_positive(thickness, "thickness", "Design")
        self._amplitude = None if imperfection is None else require_finite(imperfection, "imperfection", "Design")
        self._seed = require_whole(seed, "seed", "Design", 0)
        takers = [value for value in self._made.values() if callable(value)]
        known = {name for taker in takers for name in _names(taker, self.values)}
        idle = [name for name in self.values if name not in known]
        if idle:
            raise ModelError(
                f"Design: no function takes {', '.join(map(repr, idle))}: cuts, outline, thickness or material must "
                "name it"
            )
        self._take_reference()

    def _take_reference(self) -> None:
        """Mesh the sheet as it is now; everything else moves from here."""
        sheet = self.sheet()
        lines = {} if self.case is None else {"lines": set_up(self.case, sheet).lines}
        self._reference_mesh: TriMesh = sheet.mesh(**{**lines, **self.mesh_settings})
        self._drawn = (sheet.outline, sheet.cuts, lines_of(sheet))
        self._drawn_at = dict(self.values)
        check_topology(*self._drawn[:2], self._drawn[:2], "Design")
        self._follower = Follower(self._reference_mesh, *self._drawn)
        self._offsets: list[Array] = []  # the imperfection, once it was needed: one for all that share the mesh
        self._mesh: TriMesh | None = None

    # ---- values

    def at(self, values: Mapping[str, float] | Sequence[float] | Array | None = None, /, **more: float) -> Design:
        """The same design with other values of some of its parameters.

        Parameters
        ----------
        values : mapping or sequence of float, optional
            By name, or those of all that have a range, in their order.
        **more : float
            By name.

        Raises
        ------
        ModelError
            A name that the design does not have, or a value out of its range.
        GeometryError
            Cuts that meet, or a mesh that cannot follow.
        """
        given: dict[str, Any] = {}
        if isinstance(values, Mapping):
            given.update(values)
        elif values is not None:
            listed = require_array(values, (len(self.free),), name="values", owner="Design.at")
            given.update(zip(self.free, listed.tolist()))
        given.update(more)
        for name, value in given.items():
            if name not in self.values:
                raise ModelError(f"Design.at: there is no {shown(name)}, but {', '.join(self.values)}")
            low, high = self.bounds[name]
            number = require_finite(value, name, "Design.at")
            if not low <= number <= high:
                raise ModelError(f"Design.at: {name} must lie between {low:g} and {high:g}, got {number:g}")
        moved = self._with(given)
        if moved.mesh.min_angle < POOR:
            warnings.warn(
                "Design.at: the smallest angle of the moved mesh is "
                f"{counted(moved.mesh.min_angle, 'degree', spec='.3g')}; remeshed() "
                "makes a new one",
                KirigamiWarning,
                stacklevel=2,
            )
        return moved

    def _with(self, values: Mapping[str, float]) -> Design:
        """The same without a look at ranges."""
        twin: Design = object.__new__(type(self))
        twin.__dict__.update(self.__dict__)
        twin.values = {**self.values, **{name: float(value) for name, value in values.items()}}
        twin._mesh = None
        return twin

    @property
    def vector(self) -> Array:
        """The values of the parameters that have a range, in their order."""
        return np.array([self.values[name] for name in self.free])

    @property
    def free(self) -> list[str]:
        """The parameters that have a range."""
        return [name for name, (low, high) in self.bounds.items() if np.isfinite(high - low)]

    def span(self, name: str) -> float:
        """By what a parameter is scaled: its range, or its size where it has none."""
        require_choice(name, tuple(self.values), "name", "Design.span")
        low, high = self.bounds[name]
        return high - low if np.isfinite(high - low) else abs(self.values[name]) or 1.0

    def _call(self, what: str) -> Any:
        made = self._made[what]
        if not callable(made):
            return made
        return made(**{name: self.values[name] for name in _names(made, self.values)})

    # ---- the sheet

    def sheet(self) -> Sheet:
        """The sheet as it is drawn at the present values, to be meshed anew or exported."""
        material = self._call("material")
        if material is not None and not isinstance(material, SheetMaterial):
            raise ModelError(f"Design: material() must return a material, got {shown(material)}")
        return Sheet(
            self._call("outline"), self._call("cuts"), self._call("thickness"), material, self._call("folds")
        )  # fmt: skip

    def _takes(self, name: str, *which: str) -> bool:
        """Whether one of "cuts", "outline", "thickness", "material" is a function of a parameter."""
        made = (self._made[what] for what in which)
        return any(callable(what) and name in _names(what, self.values) for what in made)

    @property
    def mesh(self) -> TriMesh:
        """The moved mesh."""
        if self._mesh is None:
            sheet = self.sheet()
            where = f"Design at {', '.join(f'{name}={value:.6g}' for name, value in self.values.items())}"
            check_topology(sheet.outline, sheet.cuts, self._drawn[:2], where)
            creases = lines_of(sheet)
            if [len(line.coords) for line in creases] != [len(line.coords) for line in self._drawn[2]]:
                raise GeometryError(f"{where}: folds change in number or corners, which must stay")
            points = self._follower.points(sheet.outline, sheet.cuts, creases)
            moved = with_nodes(self._reference_mesh, points, tell=False)
            if callable(self._made["folds"]):  # their angles and stiffnesses may be functions as well
                edges = [fold.edges for fold in moved.folds]
                moved = moved.with_folds(
                    [FoldEdges(ends, fold.angle, fold.stiffness) for ends, fold in zip(edges, sheet.folds)]
                )
            self._mesh = moved
        return self._mesh

    def _on_lines(self) -> Array:
        """Displacements (k, 2) of the nodes that lie on lines, which those of all follow from."""
        sheet = self.sheet()
        return self._follower.on_lines(sheet.outline, sheet.cuts, lines_of(sheet))

    def ligament(self) -> float:
        """Least distance [length] of two cuts, or of a cut and the outline that it does not reach."""
        sheet = self.sheet()
        rim = sheet.outline.boundary
        found = [rim.distance(cut) for cut in sheet.cuts if sheet.outline.contains_properly(cut)]
        for number, cut in enumerate(sheet.cuts):
            found += [cut.distance(other) for other in sheet.cuts[:number]]
        return float(min(found, default=np.inf))

    def remeshed(self, **settings: Any) -> Design:
        """The same design with a mesh made anew at the present values, from which it moves on.

        Parameters
        ----------
        **settings
            Arguments of :meth:`Sheet.mesh` in the place of those it had.
        """
        twin = self._with({})
        if settings:
            twin.mesh_settings = dict(settings)
        twin._take_reference()
        return twin

    def finer(self, factor: float = 2.0) -> Design:
        """The same design on a mesh made anew at the present values, with edges so many times shorter."""
        factor = require_positive(factor, "factor", "Design.finer")
        settings = dict(self.mesh_settings)
        for name in ("max_edge", "cut_edge"):
            if settings.get(name) is not None:
                settings[name] = settings[name] / factor
        if settings.get("nodes") is not None:
            settings["nodes"] = int(settings["nodes"] * factor**2)
        elif "max_edge" not in settings:
            settings["nodes"] = int(4000 * factor**2)
        return self.remeshed(**settings)

    # ---- models

    def model(self) -> Model:
        """A model of the sheet at the present values, with its supports and its imperfection."""
        model = self._flat()
        if self._amplitude != 0:
            model.perturb(self._offset())
        return model

    def _offset(self) -> Any:
        """The imperfection (n, 3), or zero."""
        if self._amplitude == 0:
            return 0.0
        if not self._offsets:
            self._offsets.append(self._with(self._drawn_at)._imperfection())
        return self._offsets[0]

    def _flat(self) -> Model:
        model = self._sheet_model()
        self.supports(model)
        return model

    def supports(self, model: Model) -> None:
        """Add supports and loads to a model of the sheet.

        Parameters
        ----------
        model : Model
            Made from a mesh of the sheet.
        """
        require_instance(model, Model, "model", "Design.supports")
        if self.case is not None:
            set_up(self.case, self.sheet()).hold(model)
        else:
            assert self._hold is not None
            self._hold(model)

    def _sheet_model(self) -> Model:
        sheet = self.sheet()
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", KirigamiWarning)
            return Model.from_mesh(self.mesh, sheet.thickness, sheet.material, self.stiffness)

    def _imperfection(self) -> Array:
        model = self._flat()
        before = model.positions()
        model.imperfect(self._amplitude, self._seed)
        return model.positions() - before

    def walk(self, targets: Any = (1.0,), **settings: Any) -> Results:
        """Walk from the flat sheet to load factors, which are stored.

        Parameters
        ----------
        targets : sequence of float
            Load factors.
        **settings
            Further arguments of :class:`DisplacementControl`, or of :class:`LoadControl` where loads drive.
        """
        model = self.model()
        wanted = np.unique(require_array(targets, (None,), name="targets", owner="Design.walk"))
        driven = any(item.drives for item in model.constraints)
        method: Any = DisplacementControl if driven else LoadControl
        found: Results = method(model, to=float(wanted[-1]), targets=wanted.tolist(), **settings).run()
        return found

    # ---- derivatives

    def derivatives(self, adjoints: Sequence[Adjoint], names: Sequence[str] | None = None) -> list[dict[str, float]]:
        """Derivatives of functionals at equilibria of this design by its parameters: for ``results.gradient``."""
        found: list[dict[str, float]] = [{} for _ in adjoints]
        chain = Chain(self, adjoints)
        for name in self.values if names is None else names:
            step = STEP * self.span(name)
            sides = [self._with({name: self.values[name] + way}) for way in (step, -step)]
            column = chain.rates(name, sides, step)
            if column is None:
                ahead, behind = (potentials(adjoints, Changed(side.model())) for side in sides)
                column = [(one - other) / (2 * step) for one, other in zip(ahead, behind)]
            for rates, adjoint, rate in zip(found, adjoints, column):
                measured = adjoint.told.by_drawing
                if measured is not None:  # what is measured against the drawing
                    rate += (measured(sides[0].mesh) - measured(sides[1].mesh)) / (2 * step)
                rates[name] = rate
        return found

    export = deferred("kirigami.design.export:export")

    def __getstate__(self) -> dict[str, Any]:
        """Without what is made anew in another process."""
        return {name: value for name, value in self.__dict__.items() if name != "_follower"}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        self._follower = Follower(self._reference_mesh, *self._drawn)

    def __repr__(self) -> str:
        told = ", ".join(f"{name}={value:.6g}" for name, value in self.values.items())
        kept = {name: self._made[name] for name in ("thickness", "material") if not callable(self._made[name])}
        kept |= {"stiffness": self.stiffness, "imperfection": self._amplitude, "seed": self._seed}
        same = ", ".join(f"{name}={shown(value)}" for name, value in kept.items() if value is not None)
        return f"Design({told}; {counted(len(self._reference_mesh.nodes), 'node')}, {same})"


def lines_of(sheet: Sheet) -> tuple[Any, ...]:
    """The lines of the folds of a sheet."""
    return tuple(fold.line for fold in sheet.folds)


def _take_thickness(thickness: float) -> float:
    return thickness


def _names(function: Callable[..., Any], values: Mapping[str, float]) -> list[str]:
    """The parameters that a function takes."""
    taken = inspect.signature(function).parameters
    if any(parameter.kind is inspect.Parameter.VAR_KEYWORD for parameter in taken.values()):
        return list(values)
    return [name for name in values if name in taken]


def _parameter(name: str, given: Any) -> tuple[float, tuple[float, float]]:
    if not isinstance(given, (tuple, list)):
        return require_finite(given, name, "Design"), (-np.inf, np.inf)
    if len(given) != 3:
        raise ModelError(f"Design: {name} must be a number or (start, low, high), got {shown(given)}")
    start, low, high = (require_finite(value, name, "Design") for value in given)
    if not low <= start <= high or low == high:
        raise ModelError(f"Design: {name} starts at {start:g}, which must lie within its range {low:g} to {high:g}")
    return start, (low, high)


