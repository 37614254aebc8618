# %% [markdown]
# # When it fails: from the message to the remedy
#
# Tutorial 6 shows how to read an error. This page is the other way round: six things that go wrong with cut sheets,
# each with what you see, why it is so, and what to do. Every error raised on purpose is a `kg.KirigamiError`, and its
# class says who has to act:
#
# | error | what is wrong | who acts |
# | --- | --- | --- |
# | `GeometryError` | the drawing or the mesh | change the drawing |
# | `ModelError` | an object of the model, or what is asked of it | change the script |
# | `MechanismError` | something can move without resistance | add a support or a member |
# | `ConvergenceError` | no equilibrium next to the last one | choose another way along the path |
#
# And one thing that is no error at all, although it looks like one: a sheet that is pulled beyond its lock.

# %%
from __future__ import annotations

import warnings

import matplotlib.pyplot as plt
import numpy as np
from shapely import LineString, Polygon, box

import kirigami as kg

FILM = kg.Material(E=3.5e9, nu=0.34)

# %% [markdown]
# ## 1. Nothing holds the sheet: MechanismError
#
# The grips below hold the sheet up and down, but nothing keeps it from sliding sideways. The message names every
# motion that is left; the remedy is a support for each.

# %%
sheet = kg.Sheet(box(0, 0, 0.1, 0.1), LineString([(0.03, 0.05), (0.07, 0.05)]), thickness=0.2e-3, material=FILM)
model = kg.Model.from_mesh(sheet.mesh(max_edge=0.02))
bottom, top = model.select(boundary="bottom"), model.select(boundary="top")
model.add(kg.Fix(bottom, "yz"), kg.Fix(top, "z"), kg.Prescribe(top, y=1e-3))
try:
    kg.DisplacementControl(model).run()
except kg.MechanismError as error:
    print(f"MechanismError: {error}\n")
    print(f"in short: {error.motion}")

# %% [markdown]
# One node is enough, since the sheet cannot turn in its plane any more. (Holding x all along both grips would be
# right as well, but it is another experiment: the sheet could not contract there.)

# %%
model.add(kg.Fix(bottom[0], "x"))
pulled = kg.DisplacementControl(model).run()
print(f"held: {len(pulled)} steps, force {pulled.reaction(top, 'y')[-1]:.1f} N")

# %% [markdown]
# ## 2. The same displacement twice: ModelError
#
# A support and a drive on the same displacement contradict each other, even where they agree. The message names both
# objects, the axis and the first of the nodes. Usually a corner node belongs to two selections.

# %%
left = model.select(boundary="left")
mistake = model.add(kg.Fix(left, "x"))
try:
    kg.DisplacementControl(model).run()
except kg.ModelError as error:
    print(f"ModelError: {error}")
model.remove(mistake)

# %% [markdown]
# Give each displacement to one object: leave the nodes out that are held already, or the axes.

# %%
already = {id(node) for item in model.constraints for node in item.nodes if "x" in item.values}
model.add(kg.Fix([node for node in left if id(node) not in already], "x"))
print(f"left edge on rollers: force {kg.DisplacementControl(model).run().reaction(top, 'y')[-1]:.1f} N")

# %% [markdown]
# ## 3. The cuts part the sheet: GeometryError
#
# Three slits that meet enclose a triangle. Nothing would hold it, so the drawing is refused, and the message lists
# the parts with their places and the cuts that bound them.

# %%
slits = [LineString(ends) for ends in (
    [(0.02, 0.03), (0.08, 0.03)], [(0.07, 0.02), (0.045, 0.08)], [(0.03, 0.02), (0.055, 0.08)],
)]  # fmt: skip
drawing = kg.Sheet(box(0, 0, 0.1, 0.1), slits, thickness=0.2e-3, material=FILM)
try:
    drawing.mesh(max_edge=0.01)
except kg.GeometryError as error:
    print(f"GeometryError: {error}")

# %% [markdown]
# `allow_parts=True` meshes it all the same, so that the parts can be looked at.

# %%
parted = drawing.mesh(max_edge=0.01, allow_parts=True)
_, ax = plt.subplots(figsize=(3.4, 3.2), layout="constrained")
shade = np.where(parted.facet_parts == np.bincount(parted.facet_parts).argmax(), 0.15, 0.75)
ax.tripcolor(*parted.nodes[:, :2].T, parted.triangles, shade, cmap="Blues", vmin=0, vmax=1, edgecolors="white", lw=0.4)
for slit in slits:
    ax.plot(*slit.xy, color="tab:red", lw=1.5)
ax.set(aspect="equal", xticks=[], yticks=[], title="the part that nothing holds")
plt.show()

# %% [markdown]
# What to do depends on what is meant. If the piece is to fall out, draw it as a polygon, which is an opening. If it
# is to stay, shorten one slit. In a model with both parts, the loose one is found before the first step. What can be
# repaired without a doubt is repaired, with a `kg.KirigamiWarning`.

# %%
loose = kg.Model.from_mesh(parted)
loose_top = loose.select(boundary="top")
loose.add(kg.Fix(loose.select(boundary="bottom")), kg.Fix(loose_top, "xz"), kg.Prescribe(loose_top, y=1e-3))
try:
    kg.DisplacementControl(loose).run()
except kg.MechanismError as error:
    print(f"MechanismError: {error}"[:300], "...")

lines = [slit.coords for slit in slits]
corners = [LineString(lines[a]).intersection(LineString(lines[b])) for a, b in ((0, 1), (1, 2), (2, 0))]
opening = Polygon([(corner.x, corner.y) for corner in corners])
with warnings.catch_warnings(record=True) as repairs:  # the slits run on along the opening, which is told, not refused
    warnings.simplefilter("always")
    mended = kg.Sheet(box(0, 0, 0.1, 0.1), [*slits, opening], thickness=0.2e-3, material=FILM).mesh(max_edge=0.01)
print(f"\nwith an opening: {mended}")
print(f"{repairs[0].category.__name__}: {repairs[0].message}")

# %% [markdown]
# ## 4. No equilibrium next to the last one: ConvergenceError
#
# A shallow truss is pushed through by a soft spring. The truss gives way faster than the spring relaxes, so somewhere
# the grip's path turns back, and a little further down there is no equilibrium close by. With
# `on_instability="follow"` the analysis may not jump, and says so. What it found until then is not lost.

# %%
truss = kg.Model(dim=2, name="truss below a spring")
foot, apex, other, grip = truss.add(kg.Node(-1, 0), kg.Node(0, 0.5, name="apex"), kg.Node(1, 0), kg.Node(0, 10.5))
truss.add(kg.Bar(foot, apex, EA=1.0), kg.Bar(apex, other, EA=1.0), kg.Bar(apex, grip, EA=0.2, strain="engineering"))
truss.add(kg.Fix([foot, other]), kg.Fix([apex, grip], "x"))
drive = truss.add(kg.Prescribe(grip, y=-3.0))
try:
    kg.DisplacementControl(truss, on_instability="follow").run()
except kg.ConvergenceError as error:
    failure = error
print(f"ConvergenceError: {failure}\n")
print(f"steps kept: {len(failure.results)}, the last at {3 * failure.results.lam[-1]:.3f} of 3 pushed")
print(f"worst node: {truss.nodes[failure.worst_nodes[0]]}")

# %% [markdown]
# The hint offers ways out, and they answer different questions.
#
# * What does the structure do? It jumps: `on_instability="switch"`, the default for driven displacements. An event
#   tells of the snap and of the energy set free.
# * What does the path look like? `ArcLength` follows it back and forth; it needs a load instead of a driven
#   displacement.

# %%
jumped = kg.DisplacementControl(truss).run()
for event in jumped.events:
    print(f"{event.kind}: {event}")
truss.remove(drive)
truss.add(kg.NodalLoad(grip, (0, -1e-2)))
traced = kg.ArcLength(truss, step=0.1, stop=lambda step: step.u[3, 1] < -3.0).run()

_, ax = plt.subplots(figsize=(5, 3.2), layout="constrained")
ax.plot(-traced.u[:, 3, 1], 1e-2 * traced.lam, color="0.7", label="ArcLength")
ax.plot(-jumped.u[:, 3, 1], -jumped.reaction(grip, "y"), "o", color="tab:blue", markersize=4, label='"switch"')
kept = failure.results
ax.plot(-kept.u[:, 3, 1], -kept.reaction(grip, "y"), "x", color="tab:red", label='"follow", until it failed')
ax.set(xlabel="travel of the grip", ylabel="force")
ax.legend()
plt.show()

# %% [markdown]
# ## 5. A sheet that needs another start: ConvergenceError at a sheet
#
# On a sheet the same error mostly means that the increments ended at an instability. Try, in this order: the default
# `on_instability="switch"` if it was changed; an imperfection (`model.perturb` with a mode of `kg.Eigen`, a hundredth
# of the thickness and up); a finer mesh where the worst nodes lie, since a ligament that is one facet wide and
# narrower than the sheet is thick is no plate any more. In a sweep over many designs, `on_failure="return"` keeps the
# results so far and goes on:
#
# ```python
# results = kg.DisplacementControl(model).run(on_failure="return")
# reached = results.lam[-1]
# ```
#
# ## 6. Pulled beyond its lock: no error, but look
#
# A disc with one slit, pulled at two points across it, opens by bending, which costs next to nothing, until the
# shortest way on the sheet from one point to the other is straight: past a strain of sqrt(1 + (a / R)^2) - 1 = 8.9 %
# it can only stretch as a membrane (Chaudhary et al., "Geometric mechanics of ordered and disordered kirigami"). An
# elastic model does not stop there. Ask it for 12 % and it will give an equilibrium, with the strains of a torn film.

# %%
radius, slit_length, asked = 3.0, 2.58, 0.12
outline, slit = kg.cuts.single_slit_disc(radius, slit_length, points=32)
disc = kg.Model.from_mesh(kg.Sheet(outline, slit, thickness=0.01, material=FILM).mesh(max_edge=0.9, cut_edge=0.45))
x, y, _ = disc.positions().T
disc.perturb(1e-3 * np.exp(-(x**2) - (y - 0.5) ** 2))
north, south = disc.nodes[int(np.argmax(y))], disc.nodes[int(np.argmin(y))]
sides = [disc.nodes[int(np.argmax(x))], disc.nodes[int(np.argmin(x))]]
disc.add(kg.Fix(south), kg.Fix(north, "xz"), kg.Fix(sides, "z"), kg.Prescribe(north, y=2 * radius * asked))
opened = kg.DisplacementControl(disc, targets=np.linspace(0, 1, 13)[1:]).run()

strain = asked * opened.lam
force = opened.reaction(north, "y")
membrane = opened.energy["bars"] / np.maximum(sum(opened.energy.values()), 1e-300)
lock = (1 + (slit_length / 2 / radius) ** 2) ** 0.5 - 1
print(" strain   force [kN]   membrane's share of the energy   largest bar strain")
for wanted in (0.02, 0.04, 0.06, 0.08, 0.10, 0.12):
    at = int(np.argmin(np.abs(strain - wanted)))
    largest = np.abs(opened.bar_strain[at]).max()
    print(f"{strain[at]:7.3f} {1e-3 * force[at]:10.1f} {100 * membrane[at]:22.0f} % {100 * largest:22.1f} %")

_, ax = plt.subplots(figsize=(5, 3.2), layout="constrained")
ax.semilogy(strain[1:], 1e-3 * force[1:], "o-", markersize=3)
ax.axvline(lock, color="tab:red", linestyle="--", linewidth=1, label="lock: no further by bending")
ax.set(xlabel="strain between the points", ylabel="force [kN]")
ax.legend()
plt.show()

# %% [markdown]
# Two numbers tell the lock before the force does: the membrane's share of the energy, which is a few per cent while
# the sheet bends and nearly all of it at the end, and the largest bar strain. A film that yields at 2 % has left the
# elastic model well before.
#
# ## Checked
#
# The failed run stopped at the turning point of the closed form, w + P(w) / k with P the load of the von Mises truss,
# and everything it stored lies on that curve.

# %%
deflection = np.linspace(0, 0.5, 100_001)
z = 0.5 - deflection
travel = deflection + z * (0.25 - z**2) / np.hypot(1, 0.5) ** 3 / 0.02
turning = travel[np.argmax(np.diff(travel) < 0)]
print(f"the grip turns back at {turning:.4f}; the last step kept is at {3 * kept.lam[-1]:.4f}")
assert abs(3 * kept.lam[-1] - turning) < 1e-3
assert any(event.kind == "snap" for event in jumped.events) and traced.u[-1, 3, 1] < -3.0
assert membrane[np.argmin(np.abs(strain - 0.03))] < 0.1 < 0.8 < membrane[-1]
assert force[-1] > 20 * force[np.argmin(np.abs(strain - 0.03))]
