# %% [markdown]
# # 7. Effects: weight, pressure, strain of its own, a table
#
# So far a sheet was pulled. This tutorial takes one strip of polyester film and lets other things act on it: its own
# weight, a pressure that follows it, a strain and a curvature of its own, and a table that it is pressed against.
# Each is one object that is added to the model, each grows with the load factor unless it is told to be constant, and
# each is held against a number that can be had by hand.

# %%
from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np
import shapely

import kirigami as kg
from kirigami.results.contact import normal_forces, penetration

LENGTH, WIDTH, THICKNESS = 0.1, 0.01, 0.2e-3  # m
FILM = kg.Material(E=3.5e9, nu=0.0, density=1390.0)  # no Poisson ratio, so that a strip is a beam
RIGIDITY = FILM.E * THICKNESS**3 / 12  # per width


def strip(max_edge: float = 0.01) -> kg.Model:
    """A strip along x on the rung that converges to shell theory."""
    sheet = kg.Sheet(shapely.box(0, 0, LENGTH, WIDTH), thickness=THICKNESS, material=FILM)
    return kg.Model.from_mesh(sheet.mesh(max_edge), stiffness="shell")


# %% [markdown]
# ## Its own weight
#
# `kg.Gravity` takes the density of the material. The strip is clamped at its left end and sags like a shelf: of a
# short one the tip goes down by q L^4 / 8 D, and this one is long enough to sag a little less. `kg.EdgeLoad`,
# `kg.AreaLoad` and `kg.EdgeMoment` are added in the same way.

# %%
shelf = strip()
shelf.add(kg.Fix(shelf.select(boundary="left"), clamp=True), kg.Gravity())
sag = kg.LoadControl(shelf).run()
right = sag.node_index(shelf.select(boundary="right"))
tip = -sag.u[:, right, 2].mean(axis=1)
small = FILM.density * THICKNESS * 9.81 * LENGTH**4 / (8 * RIGIDITY)
print(f"tip {1e3 * tip[-1]:.2f} mm, by the formula of small deflections {1e3 * small:.2f} mm")

# %% [markdown]
# ## A pressure that follows
#
# `kg.Pressure` pushes along the normals that the facets have then, so it is no weight: pressed hard enough the strip
# rolls up instead of hanging down. Such a pressure on a free strip has no potential, and the package says where that
# matters: no stability is counted, and `Eigen` and `Buckling` refuse.

# %%
pressed = strip()
pressed.add(kg.Fix(pressed.select(boundary="left"), clamp=True), kg.Pressure(5 * RIGIDITY / LENGTH**3))
rolled = kg.LoadControl(pressed).run()
print(f"stability counted: {rolled[-1].negative is not None}")
rolled.plot()
plt.show()

# %% [markdown]
# ## A strain and a curvature of its own
#
# Heat, swelling, light, a pre-stretched layer: `kg.Actuate` gives facets a strain and a curvature at which they bear
# nothing. With a curvature of pi over the length the strip bends to half a circle; since nothing holds it, next to no
# energy is stored: what there is, is the mesh's, and a small share of what it takes to bend the strip by hand.

# %%
active = strip()
active.add(kg.Fix(active.select(boundary="left"), clamp=True), kg.Actuate(curvature=(np.pi / LENGTH, 0, 0)))
bent = kg.LoadControl(active).run()
middle = bent.position()[-1, bent.node_index(active.select(boundary="right"))].mean(axis=0)
by_hand = 0.5 * RIGIDITY * WIDTH * LENGTH * (np.pi / LENGTH) ** 2
stored = sum(bent.energy.values())[-1]
print(f"energy {100 * stored / by_hand:.4f} % of that of bending by hand")
print(f"ends {1e3 * np.hypot(middle[0], middle[2]):.2f} mm apart, a diameter is {2e3 * LENGTH / np.pi:.2f} mm")
bent.plot()
plt.show()

# %% [markdown]
# ## A table
#
# `kg.Contact` keeps nodes on one side of a plane, outside a cylinder or a sphere, with friction if it is given. Here
# the shelf of above, ten times as heavy, sags onto a table 5 mm below it. What presses there and what the clamp bears
# is the weight.

# %%
lying = strip()
clamped = lying.select(boundary="left")
lying.add(kg.Fix(clamped, clamp=True), kg.Gravity((0, 0, -10 * 9.81)))  # ten times its weight
free = [node for node in lying.nodes if all(node is not held for held in clamped)]
lying.add(kg.Contact(free, kg.Plane((0, 0, -5e-3), normal=(0, 0, 1))))
rest = kg.LoadControl(lying).run()
pressing = normal_forces(rest).sum(axis=1)
borne = rest.reaction(clamped, "z") + pressing
weight = 10 * 9.81 * FILM.density * THICKNESS * LENGTH * WIDTH
print(f"table {pressing[-1]:.4f} N, table and clamp {borne[-1]:.4f} N, weight {weight:.4f} N")
print(f"deepest {1e6 * penetration(rest).max():.2f} um below the table")

figure, ax = plt.subplots(figsize=(5, 2.6), layout="constrained")
for name, results in (("its weight", sag), ("ten times, on a table", rest)):
    x, _, z = results.position()[-1][np.argsort(results.rest[:, 0])].T
    ax.plot(1e3 * x, 1e3 * z, ".", markersize=3, label=name)
ax.axhline(-5, color="0.6", linewidth=1)
ax.set(xlabel="x [mm]", ylabel="z [mm]")
ax.legend()
plt.show()

# %% [markdown]
# More of them stand in the [reference](../docs/reference.md): cables, bars and hinges with targets that are driven,
# springs to the ground, rigid grips and links, a flow that presses, masses and motion. Tutorial 10 writes a new one.
#
# ## The numbers

# %%
assert 0.9 * small < tip[-1] < small
assert rolled[-1].negative is None
assert abs(np.hypot(middle[0], middle[2]) - 2 * LENGTH / np.pi) < 1e-3 * LENGTH
assert stored < 1e-3 * by_hand
assert abs(borne[-1] / weight - 1) < 1e-4 and penetration(rest).max() < 0.5 * THICKNESS
