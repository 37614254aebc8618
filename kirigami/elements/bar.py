"""The bar: an axial spring between two nodes.

With rest vector d0, displacement difference v, current vector d = d0 + v, rest length L and length l = |d|:

* Green strain        e = (d0.v + v.v / 2) / L^2  (+ a constant where the rest length is not |d0|)
* engineering strain  e = (l - L) / L
* energy              EA L w(e),  stress S = w'(e),  tangent S' = w''(e)
* laws                linear: w = e^2 / 2;  ogden: the two-term law of the MERLIN family, alpha = (5, 1), with
  stretch s = sqrt(1 + 2 e): w = ((s^5 - 1) / 5 - (s - 1)) / 4, S = (s^3 - 1 / s) / 4

(Felippa, Nonlinear Finite Element Methods, ch. on the total Lagrangian bar; Liu and Paulino, Proc. R. Soc. A 473,
20170348 (2017), for the Ogden law.)
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from kirigami.errors import ModelError
from kirigami.primitives.checks import require_choice, require_positive
from kirigami.primitives.kernel import EXACT, Array, CompiledKernel, Contribution, Kernel, Tangent, displacement_of
from kirigami.primitives.node import Node, require_nodes
from kirigami.primitives.parts import ModelObject, Numbering

STRAINS = ("green", "engineering")
LAWS = ("linear", "ogden")


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
    law : {"linear", "ogden"}
        Stress over strain; "ogden" goes with Green strain only.

    Raises
    ------
    ModelError
        EA or rest length not positive and finite, the same node twice, an unknown strain or law.

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

    def __init__(
        self,
        i: Node,
        j: Node,
        EA: float,
        *,
        rest_length: float | None = None,
        strain: str = "green",
        law: str = "linear",
    ) -> None:
        require_nodes("Bar", i=i, j=j)
        put = object.__setattr__
        put(self, "i", i)
        put(self, "j", j)
        put(self, "EA", require_positive(EA, "EA", "Bar"))
        put(self, "rest_length", None if rest_length is None else require_positive(rest_length, "rest_length", "Bar"))
        put(self, "strain", require_choice(strain, STRAINS, "strain", "Bar"))
        put(self, "law", require_choice(law, LAWS, "law", "Bar"))
        if i is j:
            raise ModelError(f"Bar from {i!r} to itself: a bar needs two different nodes")
        if law == "ogden" and strain != "green":
            raise ModelError("the ogden law of a Bar is written in Green strain: use strain='green' with it")

    @property
    def nodes(self) -> tuple[Node, ...]:
        return (self.i, self.j)

    @classmethod
    def lower(cls, objects: Sequence[Bar], numbering: Numbering) -> list[Kernel]:
        """One kernel for each combination of strain and law that occurs."""
        conn = numbering.connectivity(objects)
        distance = np.linalg.norm(numbering.rest[conn[:, 1]] - numbering.rest[conn[:, 0]], axis=1)
        short = np.flatnonzero(distance <= 1e-12 * numbering.size)
        if short.size:
            bar = objects[int(short[0])]
            raise ModelError(
                f"{short.size} bar(s) of zero length, the first between {numbering.describe(bar.i)} and "
                f"{numbering.describe(bar.j)}: merge the nodes or remove the bar"
            )
        EA = np.array([bar.EA for bar in objects])
        length = np.array([math.nan if bar.rest_length is None else bar.rest_length for bar in objects])
        length = np.where(np.isnan(length), distance, length)
        kernels: list[Kernel] = []
        groups: dict[tuple[str, str], list[int]] = {}
        for position, bar in enumerate(objects):
            groups.setdefault((bar.strain, bar.law), []).append(position)
        for (strain, law), positions in sorted(groups.items()):
            members = np.array(positions)
            kernels.append(BarKernel(numbering.rest, conn[members], EA[members], length[members], strain, law, members))
        return kernels


class BarKernel(Kernel):
    """All bars of one strain measure and law; see the module's text for the formulas."""

    name = "bars"
    pairs = ((0, 1),)
    translation_invariant = True
    measures_displacement = True
    approximates = True

    def __init__(
        self,
        rest: Array,
        conn: NDArray[np.int64],
        EA: Array,
        rest_length: Array,
        strain: str = "green",
        law: str = "linear",
        members: NDArray[np.int64] | None = None,
    ) -> None:
        self.rest, self.conn, self.EA, self.rest_length = rest, conn, EA, rest_length
        self.strain, self.law, self.members = strain, law, members
        self._rest_vector = self._between(rest)
        distance = np.sqrt((self._rest_vector**2).sum(axis=0))
        self._rest_strain = (distance - rest_length) * (distance + rest_length) / (2 * rest_length**2)

    def arrays(self) -> dict[str, Any]:
        return {name: getattr(self, name) for name in ("conn", "EA", "rest_length", "strain", "law", "members")}

    def _vectors(self, x: Array) -> tuple[Array, Array, Array]:
        """Current vector (dim, n), Green strain (n,) and length (n,)."""
        change = self._between(displacement_of(x, self.rest))
        vector = self._rest_vector + change
        change *= self._rest_vector + 0.5 * change
        green = self._rest_strain + change.sum(axis=0) / self.rest_length**2
        return vector, green, np.sqrt((vector**2).sum(axis=0))

    def _between(self, field: Array) -> Array:
        """Difference (dim, n) of a field (n_nodes, dim) between the ends."""
        # Members last in memory, so that every operation runs through it.
        difference: Array = np.ascontiguousarray((field[self.conn[:, 1]] - field[self.conn[:, 0]]).T)
        return difference

    def _law(self, strain: Array) -> tuple[Array, Array, Array]:
        """Energy density over EA, stress over EA and its derivative, each (n,)."""
        if self.law == "linear":
            return 0.5 * strain**2, strain, np.ones_like(strain)
        stretch = np.sqrt(1 + 2 * strain)
        d = 2 * strain / (stretch + 1)  # stretch - 1 without cancellation
        energy = d**2 * (2 + 2 * d + d**2 + d**3 / 5) / 4
        stress = d * (4 + 6 * d + 4 * d**2 + d**3) / (4 * stretch)
        return energy, stress, (3 * stretch + stretch**-3) / 4

    def _strain(self, green: Array, length: Array) -> Array:
        if self.strain == "green":
            return green
        return 2 * self.rest_length * green / (length + self.rest_length)  # (l - L) / L without cancellation

    def deformation(self, x: Array) -> Array:
        """Strain of each bar (n,)."""
        _, green, length = self._vectors(x)
        return self._strain(green, length)

    def deformation_rate(self, x: Array, change: Array) -> Array:
        """First-order change of the strain (n,) for a displacement change (n_nodes, dim)."""
        vector, _, length = self._vectors(x)
        return self._rate(vector, length, change)

    def _rate(self, vector: Array, length: Array, change: Array) -> Array:
        stretching: Array = (vector * self._between(change)).sum(axis=0)
        return stretching / (self.rest_length * (self.rest_length if self.strain == "green" else length))

    def force(self, strain: Array) -> Array:
        """True axial force (n,), positive in tension, for given strain."""
        stress = self.EA * self._law(strain)[1]
        if self.strain == "green":
            return stress * np.sqrt(np.maximum(1 + 2 * strain, 0.0))
        return stress

    def _stress_ahead(self, x: Array, change: Array) -> Array:
        """Stress over EA (n,) after a linear step `change` off `x`."""
        vector, green, length = self._vectors(x)
        _, stress, slope = self._law(self._strain(green, length))
        return stress + slope * self._rate(vector, length, change)

    def compiled(self) -> CompiledKernel | None:
        if self.strain != "green" or self.law != "linear" or self.rest.shape[1] != 3:
            return None
        from kirigami.elements.compiled import CompiledBars

        return CompiledBars(self)

    def evaluate(self, x: Array, lam: float = 1.0, need: int = 2, tangent: Tangent = EXACT) -> Contribution:
        vector, green, length = self._vectors(x)
        energy, stress, slope = self._law(self._strain(green, length))
        L = self.rest_length
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
            stress = self._stress_ahead(*tangent.ahead)
        if tangent.convexity:  # compression is what makes a bar's Hessian indefinite
            stress = stress - tangent.convexity * np.minimum(stress, 0.0)
        geometric = self.EA * stress / base
        along = self.EA * slope / (L * base**2)
        if self.strain == "engineering":  # the direction of the pull turns with the bar
            along = along - geometric / length**2
        hessian = np.empty((dim, dim, 1, n))
        np.multiply((-along * vector)[:, None], vector[None], out=hessian[:, :, 0])
        for axis in range(dim):
            hessian[axis, axis] -= geometric
        return Contribution(energy, gradient.transpose(2, 1, 0), hessian.transpose(3, 2, 0, 1))
