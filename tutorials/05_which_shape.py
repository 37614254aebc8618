# %% [markdown]
# # 5. Which shape? One sheet, many answers
#
# A thin cut sheet can take many stable shapes at one and the same pull. Which of them a run ends in depends on how the
# sheet was not flat, and on how it was pulled; the force depends on it too. So a force is worth little before three
# questions are answered: which shape is this, what others are there, and how far apart are their forces? This tutorial
# answers them for a small ribbon, and then checks the search on a structure whose shapes are known.

# %%
from __future__ import annotations

import itertools

import matplotlib.pyplot as plt
import numpy as np
import shapely

import kirigami as kg

# %% [markdown]
# ## The ribbon
#
# 60 by 100 mm of polyester film, a tenth of a millimetre thick, with slits from the middle and from the sides in turn,
# clamped at both ends and pulled by 15 mm. The mesh is coarse and the rung the cheapest one, "plate", so that
# everything here takes seconds.

# %%
PULL = 0.015


def ribbon() -> tuple[kg.Model, list[kg.Node]]:
    """The flat ribbon between its clamps, and the nodes that are pulled."""
    slits = kg.cuts.parallel_slits(columns=1, rows=5, width=0.06, height=0.075, length=0.045, margin=0.0125)
    sheet = kg.Sheet(shapely.box(0, 0, 0.06, 0.1), slits, thickness=1e-4, material=kg.Material(E=3.5e9, nu=0.34))
    m = kg.Model.from_mesh(sheet.mesh(max_edge=0.013))
    bottom, top = m.select(boundary="bottom"), m.select(boundary="top")
    m.add(kg.Fix(bottom, clamp=True), kg.Fix(top, "xz", clamp=True), kg.Prescribe(top, y=PULL))
    return m, top


# %% [markdown]
# ## Where a slow pull leads
#
# `m.imperfect(seed=...)` is one of the many ways in which a sheet is not flat. The default of the path methods follows
# the slow pull from there. The run is right: its end is a stable equilibrium, and the one to which this sheet, with
# this imperfection, is led.

# %%
m, top = ribbon()
m.imperfect(seed=0)
pulled = kg.DisplacementControl(m).run()
energy = 1e3 * sum(part[-1] for part in pulled.energy.values())
print(f"{pulled.reaction(top, 'y')[-1]:.2f} N, {energy:.3f} mJ, stable: {pulled[-1].stable}")

# %% [markdown]
# ## What else there is
#
# `kg.study.shapes` searches for the stable shapes at the full pull. It starts from random fields and modes, a little
# beyond the first buckles, and goes on from the lowest shapes by the moves that a cut sheet makes: a lip pops through,
# a row tilts the other way, one part takes the shape it has in another equilibrium. `starts` takes what we know
# already. Mirror images count as one. The search knows nothing of how the sheet was pulled; what a user gets is the
# list, lowest energy first.
#
# A search is no proof: more trials may find more. `path="search.jsonl"` writes every trial down, so that the same call
# goes on after an interruption.

# %%
found = kg.study.shapes(m, at=1.0, trials=12, starts=[pulled[-1]], most=1, followed=1)
print(found)

# %% [markdown]
# Each of them is a stable equilibrium of the same sheet at the same pull. The columns say how often a shape was
# reached, from where first, and which snap leads from it to another one when the pull is let down or goes on. The
# lowest one is also relaxed on "shell", the rung to be trusted: there a shape may hold with another force, or turn out
# to be another one. `found.plot()` draws the lowest shapes, their energy and force against the pull, and the range of
# forces.

# %%
found.plot()
plt.show()

# %% [markdown]
# ## Which one is mine?
#
# `found.which(step)` is the shape that a step is, and `found.words(step)` says it in words. `kg.stretch(sheet,
# shapes=True)` and `kirigami stretch --shapes` do all this at the end of a pull, and their summary, report and page
# tell the same lines.

# %%
for line in found.words(pulled[-1]):
    print(line)
mine = found.which(pulled[-1])
assert mine is not None and mine.energy >= found[0].energy

# %% [markdown]
# The slow pull does not lead to the shape of least energy, and nothing in its result could have told. So say with a
# force which shape it is of, and compare forces, of two meshes, two rungs or two programs, on one shape only:
# `kg.study.accuracy`, `choose_mesh` and `bracket` look at the shapes first and say where they could not compare.
#
# A shape is a step like any other, and an analysis can go on from it: here the lowest one is let down.

# %%
down = kg.DisplacementControl(m, start=found[0].step, to=0.2).run()
for event in down.events:
    print(event)
_, ax = plt.subplots(figsize=(4.6, 3), layout="constrained")
ax.plot(1e3 * PULL * pulled.lam, pulled.reaction(top, "y"), label="a slow pull")
ax.plot(1e3 * PULL * down.lam, down.reaction(top, "y"), label="the lowest shape, let down")
ax.set(xlabel="pull [mm]", ylabel="force [N]")
ax.legend()
plt.show()

# %% [markdown]
# ## Is the search to be trusted?
#
# Two shallow trusses that know nothing of each other, each with a small load on its apex, have 2 x 2 = 4 stable shapes:
# each stands or hangs. With bars of stiffness $EA = 1$ and length $L$ in the strain of Green, half-span 1 and height
# $h$, a truss has the potential $(z^2 - h^2)^2 / (4 L^3) - P (z - h)$ with its apex at $z$. `mirrors=""` counts
# everything by itself.

# %%
LOAD, HEIGHTS = -1e-3, (0.5, 0.4)


def potentials(height: float) -> list[float]:
    """Potentials of the two stable equilibria of one truss."""
    cube = (1 + height**2) ** 1.5
    places = np.roots([1 / cube, 0, -(height**2) / cube, -LOAD]).real
    stable = places[3 * places**2 > height**2]
    return [float((z**2 - height**2) ** 2 / (4 * cube) - LOAD * (z - height)) for z in stable]


trusses = kg.Model(dim=2)
for number, height in enumerate(HEIGHTS):
    left, apex, right = trusses.add(
        kg.Node(3 * number - 1, 0), kg.Node(3 * number, height), kg.Node(3 * number + 1, 0)
    )
    trusses.add(kg.Bar(left, apex, EA=1.0), kg.Bar(apex, right, EA=1.0), kg.Fix([left, right]))
    trusses.add(kg.NodalLoad(apex, (0, LOAD)))
shapes = kg.study.shapes(trusses, trials=32, mirrors="")
expected = sorted(map(sum, itertools.product(*map(potentials, HEIGHTS))))
print("found:   ", [f"{shape.energy:.6f}" for shape in shapes])
print("expected:", [f"{energy:.6f}" for energy in expected])

# %% [markdown]
# ## The number
#
# All four, each once, with the energies of the closed form.

# %%
assert len(shapes) == 4
assert np.allclose([shape.energy for shape in shapes], expected, rtol=1e-8)
