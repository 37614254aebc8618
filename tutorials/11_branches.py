# %% [markdown]
# # 11. Branches: buckling, imperfections, and which way will it go?
#
# A plate that is squeezed stays flat up to a point and then bows out. Three questions come with that: at what load,
# into which shape, and does the answer depend on how flat the plate was to begin with? This tutorial answers them with
# four tools: `Buckling` for the load in one linear step, the events of a path for the exact point, `branch=` for what
# comes after it, and `study.branches` for all shapes there are. It ends with what to do when the computer is switched
# off in between.

# %%
from __future__ import annotations

import tempfile
from functools import partial
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import shapely

import kirigami as kg

# %% [markdown]
# ## The plate
#
# 1 wide and 2.45 long, on supports that hold it level all round and let it turn, squeezed lengthwise between two stiff
# bars. At this length, the square root of six widths, plate theory says that two and three half waves buckle at the
# same load: a plate that cannot make up its mind.

# %%
WIDTH, LENGTH, THICKNESS, YOUNG, NU = 1.0, 6**0.5, 0.01, 1e6, 1 / 3
SQUEEZE = 1e-3


def plate() -> tuple[kg.Model, list[kg.Node]]:
    """The flat plate, ready to be squeezed, and the edge that is pushed."""
    sheet = kg.Sheet(shapely.box(0, 0, WIDTH, LENGTH), (), THICKNESS, kg.Material(YOUNG, nu=NU))
    model = kg.Model.from_mesh(sheet.mesh(max_edge=0.16))
    bottom, top = model.select(boundary="bottom"), model.select(boundary="top")
    model.add(kg.Fix(model.select(boundary="outer"), "z"), kg.Fix(bottom, "y"))
    model.add(kg.Fix(model.select(box=(0, 0, 0, 0)), "x"))  # one corner, so that sides and ends may widen
    model.add(kg.Prescribe(top, y=-SQUEEZE * LENGTH))
    return model, top


flat, top = plate()
print(flat)

# %% [markdown]
# ## In one step: linear buckling
#
# `Buckling` takes the stresses of a small squeeze, asks how much they soften the plate, and gives the load factors at
# which nothing is left: the classical eigenvalue problem. It is cheap, and right as long as the plate hardly moves
# before it buckles.

# %%
modes = kg.Buckling(flat, n=4).run()
print("buckling load factors:", np.round(modes.values, 4))

x, y, _ = flat.positions().T
figure, axes = plt.subplots(1, 4, figsize=(7.5, 3.6), layout="constrained")
for ax, mode in zip(axes, modes):
    ax.tripcolor(x, y, flat.mesh.triangles, mode.shape[:, 2], shading="gouraud", cmap="RdBu_r", vmin=-1, vmax=1)
    ax.set(title=f"{mode.value:.3f}", aspect="equal", xticks=[], yticks=[])
figure.suptitle("buckling modes and their load factors")
plt.show()

# %% [markdown]
# ## On the path: located bifurcations
#
# The same point met by walking: with `on_instability="follow"` the plate stays flat, and each eigenvalue that turns
# negative is reported. An event knows its load factor, its mode, and the equilibrium itself.

# %%
followed = kg.DisplacementControl(flat, on_instability="follow").run()
for event in followed.events:
    print(event)
first = followed.events[0]

# %% [markdown]
# ## Beyond it: both branches
#
# An analysis can start from such an event. `branch=1` leaves the flat path along the mode, `branch=-1` against it. The
# two are mirror images; the plate is as strong either way.

# %%
up = kg.DisplacementControl(flat, start=first, branch=1).run()
down = kg.DisplacementControl(flat, start=first, branch=-1).run()
edge = flat.index(top)

_, (force_ax, height_ax) = plt.subplots(1, 2, figsize=(7.5, 3.2), layout="constrained")
middle = int(np.argmax(np.abs(first.mode[:, 2])))
for results, label, style in ((followed, "flat", "--"), (up, "branch +1", "-"), (down, "branch -1", "-")):
    force_ax.plot(results.lam, -results.reaction(edge, "y"), style, label=label)
    height_ax.plot(results.lam, results.u[:, middle, 2] / THICKNESS, style, label=label)
force_ax.set(xlabel="load factor", ylabel="force")
height_ax.set(xlabel="load factor", ylabel="deflection / thickness")
force_ax.legend()
plt.show()

# %% [markdown]
# ## All of them: which seed leads where
#
# This plate has another choice: two half waves or three. `study.branches` seeds one shape after the other as an
# imperfection, with both signs, runs to the end and sorts what comes out; shapes that are the same but for a
# reflection count as one. With `folder=` every run is kept, and a study that was stopped goes on where it was. We seed
# the first two buckling modes, a hundredth of the thickness high.

# %%
with tempfile.TemporaryDirectory() as folder:
    study = kg.study.branches(
        flat, modes=list(modes)[:2], amplitude=0.01 * THICKNESS, analysis=partial(kg.DisplacementControl), folder=folder
    )
print(study)
study.plot()
plt.show()

# %% [markdown]
# Both shapes are stable: what a real plate does is decided by how it is bent before anybody pushes. So report the seed
# with the result, try more than one, and compare energies; `study.imperfections` does the same for several amplitudes,
# and `study.table("file.csv")` writes it down.
#
# ## When the computer is switched off
#
# A long run should not be lost. `checkpoint=` keeps a file up to date with every accepted step; the same line, run
# again, goes on from it and finds the same curve to the last bit. Here the run is broken off on purpose.

# %%
bent, _ = plate()
bent.perturb(modes[0], amplitude=0.01 * THICKNESS)


def power_cut(step: kg.Step) -> None:
    if step.lam > 0.5:
        raise RuntimeError("lights out")


with tempfile.TemporaryDirectory() as folder:
    file = Path(folder) / "run.npz"
    try:
        kg.DisplacementControl(bent).run(checkpoint=file, recorders=[power_cut])
    except RuntimeError:
        print(f"kept: {kg.load(file)}")
    resumed = kg.DisplacementControl(bent).run(checkpoint=file)
whole = kg.DisplacementControl(bent).run()
print(f"resumed: {resumed}")
assert np.array_equal(resumed.u, whole.u)

# %% [markdown]
# ## The number
#
# Plate theory (Timoshenko and Gere, Theory of Elastic Stability, on plates compressed in one direction): the critical
# stress is k pi^2 D / (b^2 t) with k = (m b / a + a / (m b))^2, and for a / b = sqrt(6) both m = 2 and m = 3 give
# k = 25 / 6. The sides are free to widen, so the stress is E times the squeeze. Bars and hinges on a coarse mesh come
# within a few per cent; the path and the linear step agree much better with each other.

# %%
theory = (25 / 6) * np.pi**2 / (12 * (1 - NU**2)) * (THICKNESS / WIDTH) ** 2 / SQUEEZE
print(f"load factor: plate theory {theory:.4f}, linear buckling {modes.values[0]:.4f}, path {first.lam:.4f}")
assert abs(modes.values[0] / theory - 1) < 0.03
assert abs(first.lam / modes.values[0] - 1) < 5e-3
