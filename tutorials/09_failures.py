# %% [markdown]
# # 9. Failures: from the message to the remedy
#
# An analysis that fails should say what is wrong, where, and what to try. This tutorial breaks things on purpose. Every
# error that is raised on purpose is a `kg.KirigamiError`; the message is the first thing to read, the error object
# carries the rest, and the class says who has to act:
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
# ## The drawing cannot be used: GeometryError
#
# Messages name the cut by its number in the list you gave, and the place by its coordinates.

# %%
for cuts in (
    [LineString([(0.2, 0.5), (0.8, 0.5)]), LineString([(0, 0.7), (1, 0.7)])],  # the second one severs the sheet
    [LineString([(0.2, 0.5), (0.8, 0.5)]), LineString([(1.2, 0.2), (1.4, 0.2)])],  # the second one misses it
):
    try:
        kg.Sheet(box(0, 0, 1, 1), cuts).mesh(max_edge=0.2)
    except kg.GeometryError as error:
        print(f"GeometryError: {error}\n")

# %% [markdown]
# ## The cuts part the sheet: GeometryError as well
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
# ## The model cannot be built: ModelError
#
# Wrong numbers are refused where they are given, and an empty selection says where the nodes are. A common one: a box
# in millimetres for a sheet in metres.

# %%
sheet = kg.Sheet(box(0, 0, 0.1, 0.2), thickness=0.2e-3, material=FILM)
model = kg.Model.from_mesh(sheet.mesh(max_edge=0.025))
try:
    model.select(box=(0, 199, 100, 201))
except kg.ModelError as error:
    print(f"ModelError: {error}")

# %% [markdown]
# ## The same displacement twice: ModelError as well
#
# A support and a drive on the same displacement contradict each other, even where they agree. The message names both
# objects, the axis and the first of the nodes. Usually a corner node belongs to two selections.

# %%
pulled = kg.Model.from_mesh(sheet.mesh(max_edge=0.025))
bottom, top, left = (pulled.select(boundary=name) for name in ("bottom", "top", "left"))
pulled.add(kg.Fix(bottom, "yz"), kg.Fix(top, "z"), kg.Prescribe(top, y=1e-3), kg.Fix(bottom[0], "x"))
mistake = pulled.add(kg.Fix(left, "x"))
try:
    kg.DisplacementControl(pulled).run()
except kg.ModelError as error:
    print(f"ModelError: {error}")
pulled.remove(mistake)

# %% [markdown]
# Give each displacement to one object: leave the nodes out that are held already, or the axes.

# %%
already = {id(node) for item in pulled.constraints for node in item.nodes if "x" in item.values}
pulled.add(kg.Fix([node for node in left if id(node) not in already], "x"))
print(f"left edge on rollers: force {kg.DisplacementControl(pulled).run().reaction(top, 'y')[-1]:.1f} N")

# %% [markdown]
# ## The structure can move: MechanismError
#
# Forgotten supports are the commonest mistake of all, and a solver that meets a singular matrix has nothing to say
# about them. Here the motion is put into words before the first step. The sheet below is held along its lower edge, but
# not its slope there: it can swing like a door.

# %%
bottom, top = model.select(boundary="bottom"), model.select(boundary="top")
hold = model.add(kg.Fix(bottom))
model.add(kg.NodalLoad(top, (0, 0, -1e-4)))
try:
    kg.LinearStatic(model).run()
except kg.MechanismError as error:
    print(f"MechanismError: {error}\n")
    print(f"the motion in short: {error.motion}")
    print(f"{len(error.nodes)} nodes move")

# %% [markdown]
# The message names the motion, so the remedy is at hand: hold the slope.

# %%
model.remove(hold)
model.add(kg.Fix(bottom, clamp=True))
bent = kg.LinearStatic(model).run()
print(f"clamped: the upper edge moves by {1e3 * bent.u[-1, model.index(top), 2].mean():.2f} mm")

# %% [markdown]
# A mechanism inside the structure is found as well. `error.shape` is the motion itself, ready to be drawn: a frame of
# four bars without a diagonal.

# %%
frame = kg.Model(dim=2, name="frame")
corners = frame.add(kg.Node(0, 0), kg.Node(1, 0), kg.Node(1, 1), kg.Node(0, 1))
frame.add(*(kg.Bar(corners[k], corners[(k + 1) % 4], EA=1.0) for k in range(4)))
frame.add(kg.Fix(corners[:2]), kg.NodalLoad(corners[2], (0.1, 0)))
try:
    kg.LinearStatic(frame).run()
except kg.MechanismError as error:
    print(f"MechanismError: {error}")
    x, y, _ = frame.positions().T
    ax = frame.plot(loads=False)
    ax.quiver(x, y, *error.shape[:, :2].T, angles="xy", scale_units="xy", scale=4, color="tab:red")
    ax.set(title="the motion that costs nothing", xlim=(-0.2, 1.4), ylim=(-0.2, 1.2))
    plt.show()

# %% [markdown]
# ## The path ends: ConvergenceError
#
# The truss of tutorial 1 under growing load: past the limit load there is no equilibrium to go to. The error carries
#
# * `results`: every step that converged before, as good as any other result,
# * `history`: the residuals of the last attempt,
# * `worst_nodes`: where the forces do not balance,
# * `hint`: what to try.

# %%
truss = kg.Model(dim=2, name="von Mises truss")
left, apex, right = truss.add(kg.Node(-1, 0), kg.Node(0, 1, name="apex"), kg.Node(1, 0))
truss.add(kg.Bar(left, apex, EA=1.0), kg.Bar(apex, right, EA=1.0))
truss.add(kg.Fix([left, right]), kg.Fix(apex, "x"), kg.NodalLoad(apex, (0, -1)))
try:
    kg.LoadControl(truss, to=0.2).run()
except kg.ConvergenceError as error:
    limit = error
print(f"ConvergenceError: {limit}\n")
print(f"steps that converged: {len(limit.results)}, the last at load factor {limit.results.lam[-1]:.6f}")
print(f"worst node: {truss.nodes[limit.worst_nodes[0]]}")

# %% [markdown]
# Two pictures tell most of the story. On the left the residuals of the last attempt: falling steadily means that more
# patience would help, hovering as here means that there is nothing to find. On the right the path so far: its tangent
# has become level, so this is a limit point, and the hint is right.

# %%
figure, (history_ax, path_ax) = plt.subplots(1, 2, figsize=(7.5, 3), layout="constrained")
history_ax.semilogy(limit.history, "o-")
history_ax.axhline(1e-8, color="0.6", linestyle="--", label="tolerance")
history_ax.set(xlabel="iteration", ylabel="relative residual")
history_ax.legend()
limit.results.plot_curve(x=(apex, "y"), ax=path_ax)
path_ax.set_ylabel("force / EA")
plt.show()

# %% [markdown]
# In a script that runs over many designs, `on_failure="return"` hands back the same partial results with a warning
# and an event instead of an error, and Ctrl-C does so at any time.

# %%
with warnings.catch_warnings(record=True) as caught:
    warnings.simplefilter("always")
    partial = kg.LoadControl(truss, to=0.2).run(on_failure="return")
print(f"{caught[0].category.__name__}; events: {[event.kind for event in partial.events]}")

# %% [markdown]
# ## The path turns back: ConvergenceError as well
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
# ## At a sheet
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
# ## Pulled beyond its lock: no error, but look
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

# %% [markdown]
# ## The numbers
#
# The first failed run was of use: its last step bounds the limit load, 2 / (3 sqrt(3) sqrt(2)^3) of EA in closed form,
# from below and to six digits. The second stopped at the turning point of the closed form, w + P(w) / k with P the load
# of the truss, and everything it stored lies on that curve.

# %%
exact = 2 / (3 * 3**0.5 * 2**1.5)
bound = float(limit.results.lam[-1])
print(f"last load before the failure {bound:.8f}, limit load {exact:.8f}")
assert exact * (1 - 1e-5) < bound <= exact * (1 + 1e-7)
assert np.array_equal(partial.lam, limit.results.lam)
deflection = np.linspace(0, 0.5, 100_001)
z = 0.5 - deflection
travel = deflection + z * (0.25 - z**2) / np.hypot(1, 0.5) ** 3 / 0.02
turning = travel[np.argmax(np.diff(travel) < 0)]
print(f"the grip turns back at {turning:.4f}; the last step kept is at {3 * kept.lam[-1]:.4f}")
assert abs(3 * kept.lam[-1] - turning) < 1e-3
assert any(event.kind == "snap" for event in jumped.events) and traced.u[-1, 3, 1] < -3.0
assert membrane[np.argmin(np.abs(strain - 0.03))] < 0.1 < 0.8 < membrane[-1]
assert force[-1] > 20 * force[np.argmin(np.abs(strain - 0.03))]
