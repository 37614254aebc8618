"""Results: the stored equilibria of an analysis, and what follows from them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kirigami.deferred import deferred
from kirigami.errors import ModelError
from kirigami.primitives.checks import (
    require_array,
    require_axis,
    require_text,
)
from kirigami.primitives.kernel import Array, Configuration, Kernel
from kirigami.primitives.node import AXES
from kirigami.results.linearised import NEAR, linear_contribution, linear_force
from kirigami.results.record import Nodes
from kirigami.results.step import Event, Step
from kirigami.results.stored_steps import StoredSteps
from kirigami.results.supports import carried_by
from kirigami.words import counted

if TYPE_CHECKING:
    from kirigami.results.drives import Drive
    from kirigami.results.error import ErrorBar
    from kirigami.system.system import System


class Results(StoredSteps):
    """Everything an analysis found, step by step.

    Step 0 is the state at load factor 0, in equilibrium with constant loads (or the step the analysis started from).
    In the shapes below s counts steps and n nodes.

    Attributes
    ----------
    steps : list of Step
        The stored equilibria.
    events : list of Event
        What was met on the way.
    supports : tuple of Support
        What was held, driven and tied, by name; see :class:`kirigami.results.supports.Support`.
    stats : dict
        "iterations", "factorizations", "steps", "cutbacks", "relaxations", "backend", and "seconds" per part; and
        "energy_drift" of a motion that should keep energy, its largest change over the largest kinetic energy.
    grip_nodes : dict of str to ndarray of int
        Indices of the nodes of the grips, where there are some.
    shapes : ShapeStudy or None
        The other shapes at the end, where they were looked for; not kept in files.
    shape_words : list of str
        Which of the known shapes the end is, where they were looked for.
    drives : tuple of Drive
        What :func:`kirigami.stretch` moved, and what that takes; see :class:`kirigami.results.drives.Drive`.
    units : str
        "SI" where lengths and forces are known to be metres and newtons, "" where they may be any.

    Examples
    --------
    >>> import kirigami as kg
    >>> m = kg.Model(dim=2)
    >>> a, b = m.add(kg.Node(0, 0), kg.Node(2, 0))
    >>> objects = m.add(kg.Bar(a, b, EA=10.0), kg.Fix(a), kg.Fix(b, "y"), kg.NodalLoad(b, (1, 0)))
    >>> res = kg.LinearStatic(m).run()
    >>> round(float(res.u[-1, 1, 0]), 12), round(float(res.reaction(a, "x")[-1]), 12)
    (0.2, -1.0)
    """

    def __init__(self, system: System, linear: bool = False) -> None:
        self.steps: list[Step] = []
        self.events: list[Event] = []
        self.stats: dict[str, Any] = {
            "iterations": 0, "factorizations": 0, "steps": 0, "cutbacks": 0, "relaxations": 0,
            "backend": "", "seconds": {},
        }  # fmt: skip
        super().__init__(system.model)
        self.inner_rest = system.rest[system.points :]  # what the rows behind the nodes hold at rest, (h, dim)
        self.kernels = system.kernels
        self.constrained = system.constrained
        self.linear = linear
        self.grip_nodes: dict[str, NDArray[np.int64]] = {}
        self.shapes: Any = None
        self.shape_words: list[str] = []
        self.drives: tuple[Drive, ...] = ()
        self.units = ""

    def __getstate__(self) -> dict[str, Any]:
        """Without what a copy makes anew, which may know the results it was made of."""
        return {name: value for name, value in super().__getstate__().items() if name != "_told"}

    def __setstate__(self, state: dict[str, Any]) -> None:
        """A copy has lists of its own."""
        self.__dict__.update(state)
        self.steps, self.events, self.stats = list(self.steps), list(self.events), dict(self.stats)

    # ---- forces and energies

    def member_deformation(self, kernel: Kernel, step: Step) -> Array:
        """Strain or angle (members, ...) of a kernel at a step; to first order for a linear analysis."""
        if self.linear:
            at_rest = self.configuration()
            linearised: Array = kernel.deformation(at_rest) + kernel.deformation_rate(at_rest, self.rows(step))
            return linearised
        found: Array = self.evaluate_at(kernel, step, lambda x: kernel.deformation_at(x, step.lam))
        return found

    def told(self, kernel: Kernel, step: Step, tell: Callable[[Array], Array]) -> Array:
        """What a function of positions, such as a method of a kernel, says at a step; of a linear analysis to first
        order in the displacements, by a central difference."""
        if not self.linear:
            found: Array = self.evaluate_at(kernel, step, tell)
            return found
        at_rest, rows = self.configuration(), self.rows(step)
        rest = np.asarray(at_rest)
        size = float(np.abs(rows).max(initial=0.0))
        if size == 0:
            return tell(at_rest)
        share = NEAR * (float(np.ptp(rest, axis=0).max()) or 1.0) / size
        rate = tell(Configuration(rest, share * rows)) - tell(Configuration(rest, -share * rows))
        return np.asarray(tell(at_rest) + rate / (2 * share))

    def member_force(self, kernel: Kernel, step: Step) -> Array:
        """Force or moment (members, ...) of a kernel at a step; to first order for a linear analysis."""
        if not self.linear:
            found: Array = self.evaluate_at(kernel, step, lambda x: kernel.force_of(x, step.lam))
            return found
        felt = self.member_deformation(kernel, step)
        return linear_force(kernel, kernel.deformation(self.configuration()), felt, step.lam)

    def rows(self, step: Step | None = None) -> Array:
        """Displacements (rows, dim) at a step, or at rest, of the nodes and the rows that elements keep behind them."""
        if step is None:
            return np.zeros((len(self.rest) + len(self.inner_rest), self.dim))
        # A step made of the displacements of nodes alone, as by Step.at, leaves the rows behind them at rest.
        inner = step.inner if len(step.inner) == len(self.inner_rest) else np.zeros((len(self.inner_rest), 3))
        return np.concatenate([step.u, inner])[:, : self.dim]

    def configuration(self, step: Step | None = None) -> Configuration:
        """What kernels are evaluated at: all rows at a step, or at rest."""
        return Configuration(np.concatenate([self.rest[:, : self.dim], self.inner_rest]), self.rows(step))

    def evaluate_at(self, kernel: Kernel, step: Step, evaluate: Any) -> Any:
        """``evaluate(configuration)`` with the history a kernel had at a step; the kernel's own is left untouched."""
        before = kernel.history
        position = next((k for k, other in enumerate(self.kernels) if other is kernel), -1)
        if before is not None and 0 <= position < len(step.history) and step.history[position] is not None:
            kernel.history = step.history[position]
        try:
            return evaluate(self.configuration(step))
        finally:
            if before is not None:
                kernel.history = before

    @property
    def _gradients(self) -> Array:
        """Gradient of the potential (s, n, 3): support reactions at constrained displacements, else about zero."""
        nodal = np.zeros((len(self.steps), len(self.rest), 3))
        nodal[..., : self.dim] = self.row_gradients[:, : len(self.rest)]
        return nodal

    @cached_property
    def row_gradients(self) -> Array:
        """The same (s, rows, dim), with the rows that elements keep behind the nodes."""
        from kirigami.system.assembly import scatter_add

        at_rest = self.configuration()
        total = np.zeros((len(self.steps), *at_rest.shape))
        for target, step in zip(total, self.steps):
            if step.forces is not None:
                target[:] = np.concatenate([step.forces, step.inner_forces])[:, : self.dim]
                continue
            for kernel in self.kernels:
                if self.linear:
                    gradient = linear_contribution(kernel, at_rest, step.lam, self.rows(step)).gradient
                else:
                    gradient = self.evaluate_at(kernel, step, lambda x: kernel.evaluate(x, step.lam, 1)).gradient  # noqa: B023
                assert gradient is not None
                scatter_add(target, kernel.conn, gradient)
        return total

    def reaction(self, nodes: Nodes, axis: str | Sequence[float] | Array | None = None) -> Array:
        """Force of the support on the structure, summed over nodes.

        In a motion it is the mean since the moment stored before, with what moves the mass of the nodes it holds.

        What is tied to a node counts with it: the support holds it by the tie. So the force of a support that drives
        the leader of a rigid grip is that of the whole grip, and its work is the energy stored.

        Parameters
        ----------
        nodes : Node, int, str, or sequence of Node or int
            The supported nodes, as for :meth:`node_index`: also "driven_0", or "top".
        axis : {"x", "y", "z"} or direction of 2 or 3 numbers, optional
            One component: along an axis, or along a direction; None gives all three.

        Returns
        -------
        ndarray, shape (s,) or (s, 3)
            Force [force] at each step.

        Raises
        ------
        ModelError
            Empty selection, nodes that were not in the model of the run, or an unknown axis.
        """
        direction = None if axis is None else _direction(axis)
        carried = carried_by(self.node_index(nodes), self.supports, len(self.rest))
        total: Array = np.where(carried, self._gradients, 0.0).sum(axis=1)
        if direction is None:
            return total
        component: Array = total[:, : len(direction)] @ direction
        return component

    @cached_property
    def energy(self) -> dict[str, Array]:
        """Energy [force length], each (s,): stored, by kind of kernel, "bars", "hinges", "springs", ..., "dissipated"
        where something yields, and "kinetic" of a motion."""
        totals: dict[str, Array] = {}
        for kernel in self.kernels:
            if kernel.stores_energy:
                values = np.array([self.member_energy(kernel, step).sum() for step in self.steps])
                totals[kernel.name] = totals.get(kernel.name, np.zeros(len(self.steps))) + values
        yielding = [kernel for kernel in self.kernels if kernel.plastic() is not None]
        if yielding and not self.linear:
            totals["dissipated"] = np.array(
                [sum(self.member_dissipation(kernel, step).sum() for kernel in yielding) for step in self.steps]
            )
        if self.moves:
            totals["kinetic"] = np.array([step.kinetic for step in self.steps])
        return totals

    def member_energy(self, kernel: Kernel, step: Step) -> Array:
        """Stored energy (members,) of one of the kernels at a step [force length]; of a linear analysis to second
        order."""
        if not self.linear:
            found: Array = self.evaluate_at(kernel, step, lambda x: kernel.evaluate(x, step.lam, 0)).energy
            return found if kernel.plastic() is None else found - self.member_dissipation(kernel, step)
        return linear_contribution(kernel, self.configuration(), step.lam, self.rows(step)).energy

    def member_dissipation(self, kernel: Kernel, step: Step) -> Array:
        """Energy (members,) that members of one of the kernels have dissipated by yield up to a step [force length]."""
        lost: Array = self.evaluate_at(kernel, step, kernel.dissipated)
        return lost

    def _members(self, name: str, quantity: str, of: Any = None) -> Array:
        """A quantity of the members of the kernels of one name, in the order their objects were added."""
        kernels = [kernel for kernel in self.kernels if kernel.name == name]
        place = np.concatenate(
            [np.arange(len(k.conn)) if k.members is None else np.asarray(k.members) for k in kernels]
        )
        order = np.argsort(place, kind="stable")  # an object may have several members, as a contact has
        values = self.once((name, quantity), lambda: self._tell(kernels, quantity, order))
        return values if of is None else values[:, place[order] == self.object_number(of, int(place.max()) + 1)]

    def _tell(self, kernels: list[Kernel], quantity: str, order: NDArray[np.int64]) -> Array:
        rows = []
        for step in self.steps:
            parts = []
            for kernel in kernels:
                tell = self.member_force if quantity == "force" else self.member_deformation
                parts.append(tell(kernel, step))
            rows.append(np.concatenate(parts)[order])
        return np.array(rows) if rows else np.zeros((0, len(order)))

    def deformation(self, name: str, of: Any = None) -> Array:
        """What the members of a kind of kernel feel at each step.

        Parameters
        ----------
        name : str
            Name of the kernels: "bars", "hinges", "springs", "facets", "contact" and so on, or that of your own effect.
        of : object or int, optional
            One object of the model, or its number among those of its kind; None takes all.

        Returns
        -------
        ndarray, shape (s, members, ...)
            Strain, angle or gap, as the kernel defines it, in the order the objects were added; of a linear analysis
            to first order.

        Raises
        ------
        ModelError
            The model had no such kernel or object, or the kernel does not tell.

        Examples
        --------
        >>> import kirigami as kg
        >>> m = kg.Model(dim=2)
        >>> a, b = m.add(kg.Node(0, 0), kg.Node(2, 0))
        >>> objects = m.add(kg.Bar(a, b, EA=10.0), kg.Fix(a), kg.Fix(b, "y"), kg.NodalLoad(b, (1, 0)))
        >>> kg.LinearStatic(m).run().deformation("bars")[-1].round(9).tolist()
        [0.1]
        """
        return self._members(self._known_kernel(name), "deformation", of)

    def force(self, name: str, of: Any = None) -> Array:
        """What the members of a kind of kernel answer at each step, (s, members, ...): force or moment.

        Parameters
        ----------
        name, of
            As for :meth:`deformation`.

        Raises
        ------
        ModelError
            The model had no such kernel or object, or the kernel does not tell.
        """
        return self._members(self._known_kernel(name), "force", of)

    def _known_kernel(self, name: str) -> str:
        kinds = {kernel.name for kernel in self.kernels}
        require_text(name, "name", "Results.deformation")
        if name not in kinds:
            tells = sorted({k.name for k in self.kernels if type(k).deformation is not Kernel.deformation})
            sheet = "; stress() and energy serve every sheet" if self.mesh is not None else ""
            raise ModelError(
                f"the model has no {name!r}, but {', '.join(map(repr, sorted(kinds)))}: deformation() and force() tell "
                f"of {', '.join(map(repr, tells)) or 'none'}{sheet}"
            )
        return name

    # Every rung has its own elements: what the model does not have is not an array of no columns, but an error.
    @property
    def bar_strain(self) -> Array:
        """Strain (s, bars) in the measure of each bar, in the order the bars were added."""
        return self.deformation("bars")

    @property
    def bar_force(self) -> Array:
        """Axial force (s, bars) [force], positive in tension."""
        return self.force("bars")

    @property
    def hinge_angle(self) -> Array:
        """Unwrapped angle (s, hinges) [rad]; 0 is flat."""
        return self.deformation("hinges")

    @property
    def hinge_moment(self) -> Array:
        """Moment (s, hinges) [force length]."""
        return self.force("hinges")

    @property
    def spring_angle(self) -> Array:
        """Unwrapped angle (s, springs) [rad] of the three-node springs."""
        return self.deformation("springs")

    @property
    def spring_moment(self) -> Array:
        """Moment (s, springs) [force length] of the three-node springs."""
        return self.force("springs")

    @property
    def bars(self) -> NDArray[np.int64]:
        """Node indices (bars, 2) in the order the bars were added; none where the model has no bars."""
        kernels = [kernel for kernel in self.kernels if kernel.name == "bars"]
        conn = np.zeros((sum(len(kernel.conn) for kernel in kernels), 2), dtype=np.int64)
        for kernel in kernels:
            conn[slice(None) if kernel.members is None else kernel.members] = kernel.conn
        return conn

    # ---- looking

    @cached_property
    def error(self) -> ErrorBar:
        """Estimated relative errors, each (s,): ``error["force"]``, ``error["open_area"]`` and ``error["height"]``.

        What mesh, rung and tolerance make of them; see :class:`kirigami.results.error.ErrorBar`. It is computed when
        first asked for, at the price of a few factorisations.

        Raises
        ------
        AnalysisError
            Not of a sheet; or of bars, hinges or flat facets on a mesh that was not drawn flat.
        """
        from kirigami.results.error import estimated_error

        return estimated_error(self)

    def __repr__(self) -> str:
        span = f", load factor {self.steps[0].lam:.6g} to {self.steps[-1].lam:.6g}" if self.steps else ""
        return (
            f"<Results of {self.name or 'model'}: {counted(len(self.steps), 'step')}{span}, "
            f"{counted(len(self.events), 'event')}>"
        )

    def _repr_html_(self) -> str:
        return f"<pre>{self.summary().replace('<', '&lt;')}</pre>"

    summary = deferred("kirigami.results.summary:summary")
    plot = deferred("kirigami.plot.deformed:plot_results")
    plot_curve = deferred("kirigami.plot.curves:plot_curve")
    plot_stress = deferred("kirigami.results.stress:plot_stress")
    animate = deferred("kirigami.plot.movie:animate")

    # ---- measures

    height = deferred("kirigami.results.measures:height")
    width = deferred("kirigami.results.measures:width")
    moment = deferred("kirigami.results.moments:moment")
    open_area = deferred("kirigami.results.measures:open_area")
    poisson_ratio = deferred("kirigami.results.measures:poisson_ratio")
    curvature = deferred("kirigami.results.measures:curvature")
    stress = deferred("kirigami.results.stress:sheet_stress")
    plastic_strain = deferred("kirigami.results.yielding:facet_plastic_strain")
    energy_shares = deferred("kirigami.results.measures:energy_shares")
    energy_release = deferred("kirigami.results.fracture:energy_release")
    gradient = deferred("kirigami.results.gradients.gradient:gradient")

    # ---- files

    save = deferred("kirigami.results.archive:save")
    to_csv = deferred("kirigami.io.table:to_csv")
    to_xarray = deferred("kirigami.io.table:to_xarray")
    to_vtk = deferred("kirigami.io.vtk:write_vtk")
    to_html = deferred("kirigami.io.html:to_html")
    to_surface = deferred("kirigami.io.surface:write_surface")


def _direction(axis: str | ArrayLike) -> Array:
    """Unit vector of an axis letter, or of a direction."""
    if isinstance(axis, str):
        return np.asarray(np.eye(3)[AXES.index(require_axis(axis, "reaction"))])
    along = require_array(axis, (2,), (3,), name="axis", owner="reaction")
    if not along.any():
        raise ModelError("reaction: the direction must not be zero")
    return np.asarray(along / np.linalg.norm(along))
