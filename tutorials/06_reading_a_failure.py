# %% [markdown]
# # 6. Reading a failure
#
# An analysis that fails should say what is wrong, where, and what to try. This tutorial breaks things on purpose: a
# drawing, a mesh, supports, and a path that ends. Every error the package raises on purpose is a `kg.KirigamiError`;
# the message is the first thing to read, and the error object carries the rest.

# %%
from __future__ import annotations

import warnings

import matplotlib.pyplot as plt
import numpy as np
from shapely import LineString, box

import kirigami as kg

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
# ## The model cannot be built: ModelError
#
# Wrong numbers are refused where they are given, and an empty selection says where the nodes are. A common one: a box
# in millimetres for a sheet in metres.

# %%
sheet = kg.Sheet(box(0, 0, 0.1, 0.2), thickness=0.2e-3, material=kg.Material(E=3.5e9, nu=0.34))
model = kg.Model.from_mesh(sheet.mesh(max_edge=0.025))
try:
    model.select(box=(0, 199, 100, 201))
except kg.ModelError as error:
    print(f"ModelError: {error}")

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
    failure = error
print(f"ConvergenceError: {failure}\n")
print(f"steps that converged: {len(failure.results)}, the last at load factor {failure.results.lam[-1]:.6f}")
print(f"worst node: {truss.nodes[failure.worst_nodes[0]]}")

# %% [markdown]
# Two pictures tell most of the story. On the left the residuals of the last attempt: falling steadily means that more
# patience would help, hovering as here means that there is nothing to find. On the right the path so far: its tangent
# has become level, so this is a limit point, and the hint is right.

# %%
figure, (history_ax, path_ax) = plt.subplots(1, 2, figsize=(7.5, 3), layout="constrained")
history_ax.semilogy(failure.history, "o-")
history_ax.axhline(1e-8, color="0.6", linestyle="--", label="tolerance")
history_ax.set(xlabel="iteration", ylabel="relative residual")
history_ax.legend()
failure.results.plot_curve(x=(apex, "y"), ax=path_ax)
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
# ## Followed, and checked
#
# The hint says `DisplacementControl`; with it the path goes on. And the failed run was of use: its last step bounds the
# limit load, 2 / (3 sqrt(3) sqrt(2)^3) of EA in closed form, from below and to six digits.

# %%
followed = kg.DisplacementControl(truss, to=-2.0, control=(apex, "y")).run()
print(followed.events[0])
exact = 2 / (3 * 3**0.5 * 2**1.5)
bound = float(failure.results.lam[-1])
print(f"last load before the failure {bound:.8f}, limit load {exact:.8f}")
assert exact * (1 - 1e-5) < bound <= exact * (1 + 1e-7)
assert np.array_equal(partial.lam, failure.results.lam)
