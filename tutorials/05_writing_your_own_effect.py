# %% [markdown]
# # 5. Your own effect, in one file
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
# as a whole costs energy, and `name` is the key under which energy and seconds are reported. With
# the imports above and saved as `bed.py`, the next cell is a complete extension: nothing has to be registered.

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
