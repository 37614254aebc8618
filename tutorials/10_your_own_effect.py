# %% [markdown]
# # 10. Your own effect, in one file
#
# Everything that makes force is written in the same way: bars, hinges, springs, loads, contact. So is what the package
# does not have yet. As an example: a film glued to a soft bed, such as gold on rubber. Squeezed, it wrinkles, with a
# wavelength that nobody drew.

# %%
from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import matplotlib.pyplot as plt
import numpy as np
from scipy.optimize import brentq

import kirigami as kg

# %% [markdown]
# ## The file
#
# An effect is two small classes. The **object** is what a user adds to a model: it names its nodes, and `lower` turns
# all objects of its class into kernels. The **kernel** is arrays: `conn` says which nodes each member touches, and
# `evaluate` returns energy, gradient and Hessian of all members at once.
#
# The bed pushes back with k w per area, w the displacement along z. A third of each facet's area A belongs to each of
# its corners, so a facet stores k A / 3 (w1^2 + w2^2 + w3^2) / 2. Three more facts help the solver: `pairs` lists the
# local pairs of nodes that have a Hessian block (here a corner with itself only), `anchored` says that moving the sheet
# as a whole costs energy, and `name` is the key under which energy and seconds are reported. With the imports above and
# saved as `bed.py`, the next cell, less than thirty lines, is a complete extension: nothing has to be registered.

# %%
@dataclass(frozen=True, eq=False)
class Bed(kg.ModelObject):
    """An elastic bed under a whole sheet; `stiffness` is force per volume, pressure per displacement along z."""

    kind: ClassVar[str] = "effect"
    group: tuple[kg.Node, ...]
    stiffness: float

    @property
    def nodes(self) -> tuple[kg.Node, ...]:
        return self.group

    @classmethod
    def lower(cls, objects: list[Bed], numbering: kg.Numbering) -> list[kg.Kernel]:
        mesh = numbering.mesh
        share = mesh.facet_areas / 3
        return [BedKernel(numbering.rest, mesh.triangles, bed.stiffness * share) for bed in objects]


class BedKernel(kg.Kernel):
    name = "bed"
    pairs = ((0, 0), (1, 1), (2, 2))
    anchored = True

    def __init__(self, rest: np.ndarray, conn: np.ndarray, stiffness: np.ndarray) -> None:
        self.rest, self.conn, self.stiffness = rest, conn, stiffness[:, None]  # one row for each facet

    def evaluate(self, x: np.ndarray, lam: float = 1.0, need: int = 2) -> kg.Contribution:
        w = kg.displacement_of(x, self.rest)[self.conn, 2]  # (facets, 3 corners)
        gradient = np.zeros((*w.shape, 3))
        gradient[..., 2] = self.stiffness * w
        hessian = np.zeros((*w.shape, 3, 3))
        hessian[..., 2, 2] = self.stiffness
        return kg.Contribution((self.stiffness * w**2 / 2).sum(axis=1), gradient, hessian)


# %% [markdown]
# ## The film
#
# A strip 400 mm long and 60 mm wide, 0.2 mm thick. The mesh is our own: rows of right-angled triangles, handed over as
# arrays. The stiffness of the bed is chosen so that the wrinkles will be 80 mm long: k = D (2 pi / 80 mm)^4, with the
# bending stiffness D = E t^3 / (12 (1 - nu^2)) of the film.
#
# The nodes across the strip are tied to move up and down together. So the film bends like a cylinder, and the classic
# formula below is exact for it.

# %%
LENGTH, WIDTH, COLUMNS, ROWS = 0.4, 0.06, 80, 2
E, THICKNESS, NU = 3.5e9, 0.2e-3, 0.34
BENDING = E * THICKNESS**3 / (12 * (1 - NU**2))
STIFFNESS = BENDING * (2 * math.pi / 0.08) ** 4
SHORTENING = 0.04e-3

x, y = np.meshgrid(np.linspace(0, LENGTH, COLUMNS + 1), np.linspace(0, WIDTH, ROWS + 1))
corner = (np.arange(ROWS)[:, None] * (COLUMNS + 1) + np.arange(COLUMNS)).ravel()
above = corner + COLUMNS + 1
facets = np.concatenate([np.stack([corner, corner + 1, above + 1], 1), np.stack([corner, above + 1, above], 1)])
mesh = kg.TriMesh(np.stack([x.ravel(), y.ravel()], 1), facets)


def film() -> tuple[kg.Model, list[kg.Node]]:
    """The film on its bed, squeezed along x, and its right end."""
    model = kg.Model.from_mesh(mesh, THICKNESS, kg.Material(E, NU))
    model.add(Bed(tuple(model.nodes), STIFFNESS))
    left, right = model.select(boundary="left"), model.select(boundary="right")
    first_row = model.nodes[1:COLUMNS]
    for row in range(1, ROWS + 1):
        begin = row * (COLUMNS + 1)
        model.add(kg.Tie(model.nodes[begin + 1 : begin + COLUMNS], first_row, "z"))
    model.add(kg.Fix(left, "xz"), kg.Fix(right, "z"), kg.Prescribe(right, x=-SHORTENING))
    model.add(kg.Fix(model.nodes[COLUMNS // 2], "y"))
    return model, right


flat, right = film()
print(flat)

# %% [markdown]
# ## Check before use
#
# `check_kernel` compares gradient and Hessian with finite differences of the energy. Do this at a configuration without
# any symmetry, where every sign error shows. The other entries say whether forces and moments of a member balance and
# whether rigid motions are free. They hold for bars and hinges; a bed that is anchored in space need not meet them.

# %%
kernel = next(kernel for kernel in kg.System(flat).kernels if kernel.name == "bed")
anywhere = flat.positions() + np.random.default_rng(0).normal(scale=0.01, size=(len(flat.nodes), 3))
errors = kg.check_kernel(kernel, anywhere)
print({name: f"{error:.1e}" for name, error in errors.items()})
assert max(errors["gradient"], errors["hessian"], errors["symmetry"]) < 1e-8

# %% [markdown]
# ## Wrinkles
#
# The rest is as in tutorial 2: stay on the flat path, find where the lowest eigenvalue crosses zero, use that mode as
# the seed, and go on. Path methods, eigenvalues, energies and the report of seconds know the bed without being told.


# %%
def softest(load_factor: float) -> tuple[kg.Mode, float]:
    """The softest mode of the flat film, and the force that squeezes it."""
    results = kg.DisplacementControl(flat, to=load_factor, on_instability="follow").run()
    mode = kg.Eigen(flat, n=1, about=results[-1]).run()[0]
    return mode, -float(results.reaction(right, "x")[-1])


critical = float(brentq(lambda factor: softest(factor)[0].value, 0.1, 0.9, xtol=1e-5))
mode, force = softest(critical)

wrinkled, right = film()
wrinkled.perturb(mode, amplitude=THICKNESS / 20)
results = kg.DisplacementControl(wrinkled, to=2 * critical, targets=np.linspace(0.1, 2, 20) * critical).run()
print(results.summary())
results.plot(view=(30, -65), magnify=40, colorbar=False)
plt.show()

# %% [markdown]
# Before the wrinkles the film can only be compressed; after them, nearly all further work goes into bending and into
# the bed, in equal parts. That is what settles the wavelength: longer wrinkles bend less but press more.

# %%
figure, ax = plt.subplots(figsize=(5, 3.2), layout="constrained")
for name, energy in results.energy.items():
    ax.plot(results.lam / critical, 1e6 * energy, label=name)
ax.set(xlabel="shortening / critical shortening", ylabel="stored energy [µJ]")
ax.legend()
plt.show()

# %% [markdown]
# ## The number
#
# A beam on an elastic bed buckles at 2 sqrt(k D) per width (Hetényi, *Beams on Elastic Foundation*, 1946), here with a
# whole number of wrinkles between the supports. On rows of right-angled triangles the hinges bend along the rows as a
# plate does, exactly, so only the tiny compression before buckling is in the way.

# %%
formula = 2 * math.sqrt(STIFFNESS * BENDING) * WIDTH
print(f"force at which the film wrinkles: {force:.5f} N, formula {formula:.5f} N")
assert abs(force / formula - 1) < 1e-3

# %% [markdown]
# ## What else an effect may have
#
# Four more things, each a few lines and only where they are wanted:
#
# * **Load factor.** `scaled` says that the potential depends on `lam`. Where it does so other than linearly, `by_load`
#   gives the rates of energy and gradient as well. A model that only this drives needs no load. What results tell by
#   `deformation` and `force`, and what `commit` accepts, may hang on it too: `deformation_at`, `force_at`, `commit_at`.
# * **History.** `history` is what must be stored with a step to go on from it, and `commit` accepts an equilibrium.
#   Between two commits the effect must have a potential, so `evaluate` never changes history.
# * **Mass.** `mass` returns one matrix (k, k) for each member, the same along every axis.
# * **A compiled twin.** `compiled` returns an object that adds forces and blocks in place, by loops for Numba;
#   it is asked for from `compile_from` members on. Write it last, and hold it to the kernel.
#
# A post with a heavy head carries a node. Beyond the force `strength` it crushes for good.

# %%
@dataclass(frozen=True, eq=False)
class Post(kg.ModelObject):
    """A post under a node: stiffness, strength, and mass of its head."""

    kind: ClassVar[str] = "effect"
    node: kg.Node
    stiffness: float
    strength: float
    head: float

    @property
    def nodes(self) -> tuple[kg.Node, ...]:
        return (self.node,)

    @classmethod
    def lower(cls, objects: list[Post], numbering: kg.Numbering) -> list[kg.Kernel]:
        values = np.array([(item.stiffness, item.strength, item.head) for item in objects]).T
        return [PostKernel(numbering.rest, numbering.connectivity(objects), *values)]


class PostKernel(kg.Kernel):
    name = "posts"
    pairs = ((0, 0),)
    anchored = True

    def __init__(self, rest: np.ndarray, conn: np.ndarray, *values: np.ndarray) -> None:
        self.rest, self.conn = rest, conn
        self.stiffness, self.strength, self.head = values
        self.crushed = np.zeros(len(conn))  # how much shorter each post has become

    def raised(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Height (n,) of the heads above the posts as they are, and the part of it that the posts bear."""
        height = kg.displacement_of(x, self.rest)[self.conn[:, 0], 2] + self.crushed
        most = self.strength / self.stiffness
        return height, np.clip(height, -most, most)

    def evaluate(self, x: np.ndarray, lam: float = 1.0, need: int = 2) -> kg.Contribution:
        height, borne = self.raised(x)
        gradient, hessian = np.zeros((len(height), 1, 3)), np.zeros((len(height), 1, 3, 3))
        gradient[:, 0, 2] = self.stiffness * borne
        hessian[:, 0, 2, 2] = np.where(height == borne, self.stiffness, 0.0)
        return kg.Contribution(self.stiffness * borne * (height - borne / 2), gradient, hessian)

    @property
    def history(self) -> np.ndarray:
        return self.crushed

    @history.setter
    def history(self, value: np.ndarray | None) -> None:
        self.crushed = np.zeros(len(self.conn)) if value is None else np.array(value)

    def commit(self, x: np.ndarray) -> None:
        height, borne = self.raised(x)
        self.crushed = self.crushed - (height - borne)

    def mass(self, lumped: bool = False) -> np.ndarray:
        return self.head[:, None, None]

    def compiled(self) -> PostTwin:
        return PostTwin(self)


class PostTwin:
    """The same by loops: put `numba.njit` on functions of plain arrays, one for the forces and one for the blocks."""

    def __init__(self, kernel: PostKernel) -> None:
        self.kernel = kernel

    def add_forces(self, x: np.ndarray, lam: float, total: np.ndarray) -> float:
        squares = 0.0
        for node, force in zip(self.kernel.conn[:, 0], self.kernel.stiffness * self.kernel.raised(x)[1]):
            total[node, 2] += force
            squares += force**2
        return squares

    def add_blocks(
        self, x: np.ndarray, lam: float, tangent: kg.Tangent, slots: np.ndarray, blocks: np.ndarray
    ) -> None:
        for slot, hessian in zip(slots, self.kernel.evaluate(x, lam).hessian[:, 0]):
            blocks[slot] += hessian


class Snow(Post):
    """Snow on a node; `stiffness` stands for its weight at load factor 1."""

    @classmethod
    def lower(cls, objects: list[Snow], numbering: kg.Numbering) -> list[kg.Kernel]:
        return [SnowKernel(numbering.connectivity(objects), np.array([item.stiffness for item in objects]))]


class SnowKernel(kg.Kernel):
    name, pairs, scaled = "snow", (), True

    def __init__(self, conn: np.ndarray, weight: np.ndarray) -> None:
        self.conn, self.weight = conn, weight

    def evaluate(self, x: np.ndarray, lam: float = 1.0, need: int = 2) -> kg.Contribution:
        gradient = np.zeros((len(self.conn), 1, 3))
        gradient[:, 0, 2] = lam * self.weight
        return kg.Contribution(lam * self.weight * x[self.conn[:, 0], 2], gradient)


# %% [markdown]
# Two posts and a beam between them; a stiff spring beside each post takes what a crushed post does not. Snow comes and
# goes. Where the load is on, a post bears its strength and the spring the rest; where it is gone, the crushed length is
# shared by post and spring. The first frequency is that of a head on both.

# %%
WEIGHT, STRENGTH, POST, SPRING, HEAD = 5.0, 2.0, 100.0, 50.0, 0.3
roof = kg.Model()
ends = roof.add(kg.Node(0, 0), kg.Node(1, 0))
roof.add(kg.Bar(*ends, EA=1e4), kg.Fix(ends, "xy"), kg.Spring(ends, (0, 0, SPRING)))
roof.add(*(Post(end, POST, STRENGTH, HEAD) for end in ends), *(Snow(end, WEIGHT, 0.0, 0.0) for end in ends))
winter = kg.LoadControl(roof).run()
spring = kg.LoadControl(roof, start=winter[-1], to=0.0).run()
down, left = winter.u[-1, 0, 2], spring.u[-1, 0, 2]
crushed = (WEIGHT - STRENGTH) / SPRING - STRENGTH / POST
print(f"snow: {down:.4f}, formula {-(WEIGHT - STRENGTH) / SPRING:.4f}; "
      f"after it: {left:.4f}, formula {-crushed * POST / (POST + SPRING):.4f}")  # fmt: skip
frequency = kg.Eigen(roof, n=1, mass="lumped").run().frequencies[0]

kernel = next(kernel for kernel in kg.System(roof).kernels if kernel.name == "posts")
x, forces = roof.positions() + [0.0, 0.0, -0.01], np.zeros((2, 3))
squares = kernel.compiled().add_forces(x, 1.0, forces)
assert np.allclose(forces, kernel.evaluate(x).gradient[:, 0]) and np.isclose(squares, (forces**2).sum())
assert abs(frequency / (math.sqrt((POST + SPRING) / HEAD) / (2 * math.pi)) - 1) < 1e-9
assert abs(down / -((WEIGHT - STRENGTH) / SPRING) - 1) < 1e-9
assert abs(left / (-crushed * POST / (POST + SPRING)) - 1) < 1e-9
