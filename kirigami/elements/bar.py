"""The bar: an axial spring between two nodes.

With rest vector d0, displacement difference v, current vector d = d0 + v, rest length L and length l = |d|:

* Green strain        e = (d0.v + v.v / 2) / L^2  (+ a constant where the rest length is not |d0|)
* engineering strain  e = (l - L) / L
* energy              EA L w(e),  stress S = w'(e),  tangent S' = w''(e)
* laws                linear: w = e^2 / 2;  ogden: the two-term law of the MERLIN family, alpha = (5, 1), with
  stretch s = sqrt(1 + 2 e): w = ((s^5 - 1) / 5 - (s - 1)) / 4, S = (s^3 - 1 / s) / 4;  cable: linear for e >= 0,
  nothing below. The corner at e = 0 is exact: a cable that is just straight counts as taut.

The rest length may be driven, L = L_0 + lam (L_1 - L_0). With s = 1 + 2 e (Green) or 1 + e, energy W and gradient g,

    dW/dL = EA (w - S s),    dg/dL = -g / L - EA S' s d / L^2 (Green),   -EA S' s d / (L l) (engineering).

A bar of a sheet that is actuated bears nothing at a strain of its own (:mod:`kirigami.elements.natural`).

(Felippa, Nonlinear Finite Element Methods, ch. on the total Lagrangian bar; Liu and Paulino, Proc. R. Soc. A 473,
20170348 (2017), for the Ogden law.)
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kirigami.elements.driven_rest import driven, held_at, targets_of, untouched
from kirigami.elements.natural import NaturalKernel
from kirigami.errors import ModelError
from kirigami.primitives.checks import require_choice, require_not_negative, require_positive
from kirigami.primitives.hardening import Hardening, YieldCurve, member_curve
from kirigami.primitives.kernel import EXACT, Array, CompiledKernel, Contribution, Kernel, Tangent, displacement_of
from kirigami.primitives.node import Node, require_nodes
from kirigami.primitives.parts import ModelObject, Numbering
from kirigami.words import counted

STRAINS = ("green", "engineering")
LAWS = ("linear", "ogden", "cable")


@dataclass(frozen=True, slots=True, eq=False)
class Bar(ModelObject):
    """Axial spring between two nodes.

    Parameters
    ----------
    i, j : Node
        End nodes.
    EA : float
        Axial stiffness, Young's modulus times area [force]. Small-strain spring constant is ``EA / rest_length``.
    rest_length : float, optional
        Length without stress; None takes the distance of the nodes in the rest state (imperfection included).
    strain : {"green", "engineering"}
        Strain measure; the two agree to first order.
    law : {"linear", "ogden", "cable"}
        Stress over strain; "ogden" goes with Green strain only. A "cable" bears tension alone; where it is slack it has
        no stiffness, so something else must hold its ends. LinearStatic, Eigen and Buckling about the rest state take
        one that is just straight as a bar.
    target_length : float, optional
        Length without stress at load factor 1: it is driven there from the rest length with the load factor.
    mass_per_length : float
        Mass over the length without stress at load factor 0 [mass / length]; only where mass matters. The bars of a
        sheet have none: its mass belongs to its facets.
    yield_force : float, optional
        Axial force at which the bar yields first, in the measure of its strain [force]; None: it never does. Only with
        the linear law.
    hardening : float or array_like, shape (k, 2)
        How that force grows with the accumulated plastic strain: a modulus [force], or a table of plastic strain and
        force that does not fall, constant beyond its end.
    kinematic : float or array_like, shape (k, 2)
        Kinematic hardening, how the force about which the bar yields follows the plastic strain: a modulus [force], or
        a table of plastic strain and that force, from zero, that does not fall, constant beyond its end.

    Raises
    ------
    ModelError
        EA or rest length not positive and finite, a negative mass, the same node twice, an unknown strain or law, a
        table that falls, hardening without a yield force, or a bar that both yields and is driven.

    Examples
    --------
    >>> import kirigami as kg
    >>> bar = kg.Bar(kg.Node(0, 0), kg.Node(3, 4), EA=100.0)
    >>> bar.EA, bar.strain
    (100.0, 'green')
    """

    kind: ClassVar[str] = "element"
    i: Node
    j: Node
    EA: float
    rest_length: float | None
    strain: str
    law: str
    target_length: float | None
    reached: float | None
    mass_per_length: float
    yield_curve: YieldCurve | None

    def __init__(
        self,
        i: Node,
        j: Node,
        EA: float,
        *,
        rest_length: float | None = None,
        strain: str = "green",
        law: str = "linear",
        target_length: float | None = None,
        mass_per_length: float = 0.0,
        yield_force: float | None = None,
        hardening: float | ArrayLike = 0.0,
        kinematic: float | ArrayLike = 0.0,
    ) -> None:
        require_nodes("Bar", i=i, j=j)
        put = object.__setattr__
        put(self, "i", i)
        put(self, "j", j)
        put(self, "EA", require_positive(EA, "EA", "Bar"))
        put(self, "rest_length", None if rest_length is None else require_positive(rest_length, "rest_length", "Bar"))
        put(self, "strain", require_choice(strain, STRAINS, "strain", "Bar"))
        put(self, "law", require_choice(law, LAWS, "law", "Bar"))
        target = None if target_length is None else require_positive(target_length, "target_length", "Bar")
        put(self, "target_length", target)
        put(self, "reached", None)
        put(self, "mass_per_length", require_not_negative(mass_per_length, "mass_per_length", "Bar"))
        put(self, "yield_curve", member_curve(yield_force, hardening, kinematic, "Bar", "yield_force"))
        if yield_force is not None and (law != "linear" or target_length is not None):
            beside = f"has law={law!r}" if law != "linear" else "is driven to a target_length"
            raise ModelError(f"a Bar that {beside} cannot yield: leave out yield_force, or give it law='linear' alone")
        if i is j:
            raise ModelError(f"Bar from {i!r} to itself: a bar needs two different nodes")
        if law == "ogden" and strain != "green":
            raise ModelError("the ogden law of a Bar is written in Green strain: use strain='green' with it")

    @property
    def nodes(self) -> tuple[Node, ...]:
        return (self.i, self.j)

    def held(self, lam: float) -> Bar:
        """The same, its rest length where load factor `lam` has brought it."""
        held: Bar = held_at(self, "target_length", lam)
        return held

    @classmethod
    def lower(cls, objects: Sequence[Bar], numbering: Numbering) -> list[Kernel]:
        """One kernel for each combination of strain and law that occurs, and of those that are driven."""
        conn = numbering.connectivity(objects)
        distance = np.linalg.norm(numbering.rest[conn[:, 1]] - numbering.rest[conn[:, 0]], axis=1)
        short = np.flatnonzero(distance <= 1e-12 * numbering.size)
        if short.size:
            bar = objects[int(short[0])]
            raise ModelError(
                f"{counted(short.size, 'bar')} of zero length, the first between {numbering.describe(bar.i)} and "
                f"{numbering.describe(bar.j)}: merge the nodes or remove the bar"
            )
        EA = np.array([bar.EA for bar in objects])
        length = np.array([math.nan if bar.rest_length is None else bar.rest_length for bar in objects])
        follows = np.isnan(length)
        length = np.where(follows, distance, length)
        line = np.array([bar.mass_per_length for bar in objects])
        kernels: list[Kernel] = []
        groups: dict[tuple[str, str, bool, bool], list[int]] = {}
        for position, bar in enumerate(objects):
            key = (bar.strain, bar.law, bar.target_length is not None, bar.yield_curve is not None)
            groups.setdefault(key, []).append(position)
        for (strain, law, _, yields), positions in sorted(groups.items()):
            members, some = np.array(positions), [objects[position] for position in positions]
            targets = targets_of(some, "target_length")
            mass = line[members] if line[members].any() else None
            arrays = numbering.rest, conn[members], EA[members], length[members], strain, law, members, targets, mass
            if yields:
                from kirigami.elements.member_yield import YieldingBarKernel

                curves = [bar.yield_curve for bar in some]
                kernels.append(YieldingBarKernel(*arrays, yields=Hardening.of(curves).packed))
            else:
                kernel = BarKernel(*arrays)
                kernel.follows = follows[members]
                kernels.append(kernel)
        return kernels


class BarKernel(NaturalKernel):
    """All bars of one strain measure and law; see the module's text for the formulas."""

    name = "bars"
    pairs = ((0, 1),)
    translation_invariant = True
    measures_displacement = True
    approximates = True
    follows: NDArray[np.bool_] | None = None  # whose rest length (n,) is that of the rest state; None if not known

    def __init__(
        self,
        rest: Array,
        conn: NDArray[np.int64],
        EA: Array,
        rest_length: Array,
        strain: str = "green",
        law: str = "linear",
        members: NDArray[np.int64] | None = None,
        targets: Array | None = None,
        mass_per_length: Array | None = None,
        natural: Array | None = None,
    ) -> None:
        self.rest, self.conn, self.EA = rest, conn, EA
        self.rest_length, self.drive = driven(rest_length, targets)
        self._natural = natural
        self._scale()
        self.strain, self.law, self.members = strain, law, members
        self.mass_per_length = mass_per_length  # (n,), None where no bar has mass
        self._rest_vector = self._between(rest)
        self._distance = np.sqrt((self._rest_vector**2).sum(axis=0))
        self._rest_strain = self._strain_at_rest(self.rest_length)

    @property
    def sheet_part(self) -> str:  # type: ignore[override]
        """A bar of a sheet is measured and answers as from_mesh makes it."""
        return "bars" if self.drive is None and (self.strain, self.law) == ("green", "linear") else ""

    def arrays(self) -> dict[str, Any]:
        own = {name: getattr(self, name) for name in ("conn", "EA", "rest_length", "strain", "law", "members")}
        if self.mass_per_length is not None:
            own["mass_per_length"] = self.mass_per_length
        own = own if self.drive is None else {**own, "targets": untouched(self.rest_length, self.drive)}
        return self.with_natural(own)

    def part(self, members: NDArray[np.int64]) -> Kernel:
        if type(self) is not BarKernel:
            return self
        one = dict.fromkeys(("conn", "EA", "rest_length", "drive", "members", "mass_per_length", "follows"), 0)
        two = dict.fromkeys(("_natural", "_rest_vector"), 1)
        part: BarKernel = self._cut_out(members, {**one, "_distance": 0, "_rest_strain": 0, **two})
        return part

    def _scale(self) -> None:
        super()._scale()
        self.scaled |= self.drive is not None

    def mass(self, lumped: bool = False) -> Array | None:
        """Mass matrices (n, 2, 2) of bars whose displacement is linear between the ends; lumped, a half at each."""
        if self.mass_per_length is None:
            return None
        shares = np.eye(2) / 2 if lumped else np.array([[2.0, 1.0], [1.0, 2.0]]) / 6
        return np.asarray((self.mass_per_length * self.rest_length)[:, None, None] * shares)

    def _strain_at_rest(self, length: Array) -> Array:
        """Green strain (n,) in the rest state for given rest lengths."""
        return np.asarray((self._distance - length) * (self._distance + length) / (2 * length**2))

    def rest_length_at(self, lam: float) -> Array:
        """Length without stress (n,) at a load factor."""
        return self.rest_length if self.drive is None else self.rest_length + lam * self.drive

    def _vectors(self, x: Array, lam: float = 0.0) -> tuple[Array, Array, Array]:
        """Current vector (dim, n), Green strain (n,) and length (n,)."""
        L = self.rest_length_at(lam)
        change = self._between(displacement_of(x, self.rest))
        vector = self._rest_vector + change
        change *= self._rest_vector + 0.5 * change
        start = self._rest_strain if self.drive is None else self._strain_at_rest(L)
        green = start + change.sum(axis=0) / L**2
        return vector, green, np.sqrt((vector**2).sum(axis=0))

    def start_strain(self, lam: float) -> Array:
        """Green strain (n,) that bars feel in the rest state."""
        return self.beyond(self._rest_strain, lam)

    def _between(self, field: Array) -> Array:
        """Difference (dim, n) of a field (n_nodes, dim) between the ends."""
        # Members last in memory, so that every operation runs through it.
        difference: Array = np.ascontiguousarray((field[self.conn[:, 1]] - field[self.conn[:, 0]]).T)
        return difference

    def _law(self, strain: Array) -> tuple[Array, Array, Array]:
        """Energy density over EA, stress over EA and its derivative, each (n,)."""
        if self.law == "linear":
            return 0.5 * strain**2, strain, np.ones_like(strain)
        if self.law == "cable":
            taut = np.maximum(strain, 0.0)
            return 0.5 * taut**2, taut, np.where(strain >= 0, 1.0, 0.0)
        stretch = np.sqrt(1 + 2 * strain)
        d = 2 * strain / (stretch + 1)  # stretch - 1 without cancellation
        energy = d**2 * (2 + 2 * d + d**2 + d**3 / 5) / 4
        stress = d * (4 + 6 * d + 4 * d**2 + d**3) / (4 * stretch)
        return energy, stress, (3 * stretch + stretch**-3) / 4

    def _strain(self, green: Array, length: Array, lam: float | None = None) -> Array:
        """What bars feel; at no load factor, against the rest length at zero."""
        if self.strain == "green":
            return green if lam is None else self.beyond(green, lam)
        lam = lam or 0.0
        L = self.rest_length_at(lam)
        return np.asarray(2 * L * green / (length + L))  # (l - L) / L without cancellation

    def deformation(self, x: Array) -> Array:
        """Strain of each bar (n,) against its rest length at load factor 0."""
        _, green, length = self._vectors(x)
        return self._strain(green, length)

    def deformation_rate(self, x: Array, change: Array) -> Array:
        """First-order change of the strain (n,) for a displacement change (n_nodes, dim)."""
        vector, _, length = self._vectors(x)
        return self._rate(vector, length, change)

    def _rate(self, vector: Array, length: Array, change: Array, lam: float = 0.0) -> Array:
        stretching: Array = (vector * self._between(change)).sum(axis=0)
        L = self.rest_length_at(lam)
        return stretching / (L * (L if self.strain == "green" else length))

    def force(self, strain: Array) -> Array:
        """True axial force (n,), positive in tension, for given strain."""
        stress = self.EA * self._law(strain)[1]
        if self.strain == "green":
            return stress * np.sqrt(np.maximum(1 + 2 * strain, 0.0))
        return stress

    def force_at(self, deformation: Array, lam: float) -> Array:
        if self._natural is not None:
            stress = self.EA * self._law(self.beyond(deformation, lam))[1]
            return np.asarray(stress * np.sqrt(np.maximum(1 + 2 * deformation, 0.0)))
        if self.drive is None:
            return self.force(deformation)
        part = self.rest_length / self.rest_length_at(lam)  # the strain against the rest length as it is then
        if self.strain == "green":
            return self.force((part - 1) * (part + 1) / 2 + part**2 * deformation)
        return self.force(part - 1 + part * deformation)

    def by_load(self, x: Array, lam: float, need: int = 1) -> Contribution:
        if self.drive is None:
            return super().by_load(x, lam, need)
        L = self.rest_length_at(lam)
        vector, green, length = self._vectors(x, lam)
        strain = self._strain(green, length, lam)
        energy, stress, slope = self._law(strain)
        stretch = 1 + (2 if self.strain == "green" else 1) * strain
        change = self.EA * self.drive
        rate = change * (energy - stress * stretch)
        if self.strain == "green":
            pull = -change * (stress + slope * stretch) / L**2 * vector
        else:
            pull = -change * slope * stretch / (L * length) * vector
        return Contribution(rate, np.stack([-pull, pull]).transpose(2, 0, 1))

    def _law_ahead(self, x: Array, change: Array, lam: float) -> tuple[Array, Array]:
        """Stress and its slope (n,) where a linear step leads to: without the false strain of turns, which would pull
        at what is stiff, and make a bar yield that does not."""
        vector, green, length = self._vectors(x, lam)
        strain = self._strain(green, length, lam) + self._rate(vector, length, change, lam)
        return self._law(strain)[1:]

    def by_rest(self, x: Array, lam: float, fields: Array, energies: Array) -> Array | None:
        """In closed form: strain and its rate are functions of the vector at rest and of the rest length."""
        if self.follows is None or self.drive is not None or self._natural is not None:
            return None
        vector, green, length = self._vectors(x)
        L, engineering = self.rest_length, self.strain == "engineering"
        strain = self._strain(green, length, lam)
        energy, stress, slope = self._law(strain)
        base = L * (length if engineering else L)
        by_length = -(1 + strain if engineering else 1 + 2 * strain) / L
        found = np.zeros((len(fields), *self.rest.shape))
        for total, field, share in zip(found, fields, energies.tolist()):
            change = self._between(field)
            rate = (vector * change).sum(axis=0) / base
            by_strain = slope * rate + share * stress
            turned = change / base
            if engineering:
                turned -= rate / length**2 * vector
            by_vector = self.EA * L * (by_strain / base * vector + stress * turned)
            by_rest = self.EA * (stress * rate + share * energy)
            by_rest += self.EA * L * (by_strain * by_length - stress * rate * (1 if engineering else 2) / L)
            pull = (by_vector + np.where(self.follows, by_rest / self._distance, 0.0) * self._rest_vector).T
            np.add.at(total, self.conn[:, 1], pull)
            np.add.at(total, self.conn[:, 0], -pull)
        return found

    def compiled(self) -> CompiledKernel | None:
        if self.strain != "green" or self.law != "linear" or self.rest.shape[1] != 3 or self.drive is not None:
            return None
        from kirigami.elements.compiled import CompiledBars

        return CompiledBars(self)

    def evaluate(self, x: Array, lam: float = 1.0, need: int = 2, tangent: Tangent = EXACT) -> Contribution:
        vector, green, length = self._vectors(x, lam)
        energy, stress, slope = self._law(self._strain(green, length, lam))
        L = self.rest_length_at(lam)
        energy = self.EA * L * energy
        if need == 0:
            return Contribution(energy)
        # The derivative of the strain along the bar is l/L^2 (Green) or 1/L: both are vector / (L * base).
        base = L if self.strain == "green" else length
        pull = (self.EA * stress / base) * vector
        dim, n = vector.shape
        gradient = np.empty((dim, 2, n))
        gradient[:, 0], gradient[:, 1] = -pull, pull
        if need == 1:
            return Contribution(energy, gradient.transpose(2, 1, 0))
        if tangent.ahead is not None:
            stress, slope = self._law_ahead(*tangent.ahead, lam)
        if tangent.convexity:  # compression is what makes a bar's Hessian indefinite
            stress = stress - tangent.convexity * np.minimum(stress, 0.0)
            if self.law == "linear":  # what yields is as stiff as it can become
                slope = slope + tangent.convexity * (1.0 - slope)
        geometric = self.EA * stress / base
        along = self.EA * slope / (L * base**2)
        if self.strain == "engineering":  # the direction of the pull turns with the bar
            along = along - geometric / length**2
        hessian = np.empty((dim, dim, 1, n))
        np.multiply((-along * vector)[:, None], vector[None], out=hessian[:, :, 0])
        for axis in range(dim):
            hessian[axis, axis] -= geometric
        return Contribution(energy, gradient.transpose(2, 1, 0), hessian.transpose(3, 2, 0, 1))
