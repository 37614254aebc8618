"""Step and Event: what an analysis stores of one equilibrium, and of what it met between two."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import ArrayLike

from kirigami.model.model import Model
from kirigami.primitives.checks import require_array, require_finite, require_instance
from kirigami.primitives.kernel import Array
from kirigami.primitives.parts import ModelObject
from kirigami.words import counted


@dataclass(frozen=True, eq=False, repr=False)
class Step:
    """One converged equilibrium, or one moment of a motion.

    Attributes
    ----------
    lam : float
        Load factor.
    u : ndarray, shape (n, 3)
        Displacements from the rest state [length].
    negative : int or None
        Number of negative eigenvalues of the tangent stiffness at fixed load factor; None where not counted.
    residual : float
        Norm of the residual over the root sum of squares of all unassembled forces.
    residual_over_reaction : float
        Norm of the residual over the norm of the support reactions (nan without reactions).
    iterations : int
        Corrections it took.
    inner : ndarray, shape (h, 3)
        Displacements of the rows that elements keep behind the nodes; an analysis that starts here needs them.
    history : tuple
        What history-dependent kernels need to go on from here.
    stage : int
        How often :meth:`Model.hold` had been called.
    stage_key : str
        Which model and stage it was, as :attr:`Model.stage_key` says; empty for steps that were read from a file.
    time : float
        Time [time]; nan for equilibria.
    velocity : ndarray, shape (n, 3), or None
        Velocities of the nodes [length / time] in a motion.
    inner_velocity : ndarray, shape (h, 3)
        The same of the rows that elements keep behind the nodes.
    kinetic : float
        Kinetic energy [force length].
    forces : ndarray, shape (n, 3), or None
        In a motion the forces of supports on the nodes, about zero elsewhere [force]: the mean since the moment stored
        before, inertia and damping included. None at its first moment.
    inner_forces : ndarray, shape (h, 3)
        The same of the rows that elements keep behind the nodes.
    yielded : float
        Share of the sheet, or of the members that can yield, that has yielded or, where it stays elastic, is strained
        beyond its yield stress; nan without a yield stress.

    Examples
    --------
    >>> import kirigami as kg
    >>> m = kg.Model(dim=2)
    >>> a, b = m.add(kg.Node(0, 0), kg.Node(1, 0))
    >>> objects = m.add(kg.Bar(a, b, EA=10.0), kg.Fix(a), kg.Fix(b, "y"), kg.NodalLoad(b, (1, 0)))
    >>> step = kg.LoadControl(m).run()[-1]
    >>> step.lam, step.stable, step.residual < 1e-8
    (1.0, True, True)
    """

    lam: float
    u: Array
    negative: int | None = None
    residual: float = float("nan")
    residual_over_reaction: float = float("nan")
    iterations: int = 0
    history: tuple[Array | None, ...] = ()
    stage: int = 0
    inner: Array = field(default_factory=lambda: np.zeros((0, 3)))
    stage_key: str = ""
    time: float = float("nan")
    velocity: Array | None = None
    inner_velocity: Array = field(default_factory=lambda: np.zeros((0, 3)))
    kinetic: float = 0.0
    forces: Array | None = None
    inner_forces: Array = field(default_factory=lambda: np.zeros((0, 3)))
    yielded: float = float("nan")

    @property
    def stable(self) -> bool:
        """True where no eigenvalue of the tangent stiffness is negative."""
        return self.negative == 0

    @classmethod
    def at(cls, model: Model, lam: float, u: ArrayLike) -> Step:
        """A step from known displacements, to start an analysis from.

        Parameters
        ----------
        model : Model
            The model the displacements belong to.
        lam : float
            Load factor.
        u : array_like, shape (n, 3) or (n, dim)
            Displacements from the rest state [length]. How shell facets bend between the nodes is guessed from them.

        Raises
        ------
        ModelError
            Wrong shape, or values that are not finite.
        """
        n = len(require_instance(model, Model, "model", "Step.at").nodes)
        lam = require_finite(lam, "lam", "Step.at")
        given = require_array(u, (n, 3), (n, model.dim), name="u", owner="Step.at")
        full = np.zeros((n, 3))
        full[:, : given.shape[1]] = given
        step = cls(lam=lam, u=full, stage=model.stage, stage_key=model.stage_key)
        if all(type(item).reserve is ModelObject.reserve for item in model.elements):
            return step
        from kirigami.system.system import System

        system = System(model)  # elements with rows behind the nodes guess what is in them
        inner = system.parted(system.settled(full))[1]
        return replace(step, inner=inner, history=system.history)

    def __repr__(self) -> str:
        if self.velocity is not None:
            return f"Step(time={self.time:.6g}, lam={self.lam:.6g}, kinetic energy={self.kinetic:.3g})"
        if self.negative is None:
            state = "stability not counted"
        else:
            state = counted(self.negative, "negative eigenvalue") if self.negative else "stable"
        return (
            f"Step(lam={self.lam:.6g}, {state}, residual={self.residual:.1e}, {counted(self.iterations, 'iteration')})"
        )


@dataclass(frozen=True, eq=False)
class Event:
    """Something met on the way: a limit point, a bifurcation, a snap, an interruption.

    Attributes
    ----------
    kind : str
        "limit point" (the load factor has an extremum), "bifurcation" (another path crosses), "stability change" (one
        of the two that could not be located), "switch" (an unstable path was left for another one), "switch failed"
        (no stable equilibrium was found), "snap" (energy was set free; where grips drive, more than a hundredth of
        force times displacement, or of what is stored if that is more), "small snaps" (one or many that set less free
        each, such as wrinkles that move on), "jump" (a long increment of a corrector that leaps lost the path, in a
        sharp bend or a small snap), "yield" (something yields for the first time), "beyond yield" (something that
        stays elastic is strained beyond its yield stress for the first time), "contact" (parts of a sheet with
        self-contact meet, between the stored steps of ``bracket``), "crossing" (the sheet passes through itself in
        the stored steps of ``bracket``), "step limit", "interrupted" or "failed".
    lam : float
        Load factor: located for limit points and bifurcations, else the middle of ``bracket``.
    step : int
        Index of the stored step just before it.
    message : str
        The event in words.
    bracket : tuple of float
        Load factors of the steps on both sides.
    located : Step or None
        The equilibrium at a located point; an analysis can start from it.
    mode : ndarray, shape (n, 3), or None
        The critical mode there, to which the tangent stiffness has just lost its resistance: largest component 1, the
        first of the largest entries positive.
    energy : float or None
        Of a snap, or of small snaps together: the energy that was set free [force times length].

    Examples
    --------
    >>> import kirigami as kg
    >>> event = kg.Event("interrupted", lam=0.4, step=7, message="interrupted after load factor 0.4")
    >>> print(event)
    interrupted after load factor 0.4
    """

    kind: str
    lam: float
    step: int
    message: str
    bracket: tuple[float, float] = (float("nan"), float("nan"))
    located: Step | None = field(default=None, repr=False)
    mode: Array | None = field(default=None, repr=False)
    energy: float | None = None

    @property
    def u(self) -> Array | None:
        """Displacements (n, 3) at a located point, else None."""
        return None if self.located is None else self.located.u

    def __str__(self) -> str:
        return self.message
