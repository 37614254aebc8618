# %% [markdown]
# # 2. One slit: buckling, and what an imperfection does
#
# Pull a thin sheet with one slit across the pull. The lips of the slit are squeezed along their length, although the
# sheet is pulled, and at a tiny stretch they buckle out of the plane. A perfectly flat model never would: flat stays an
# equilibrium for ever, only not a stable one. This tutorial finds the stretch at which the sheet buckles, and shows how
# small an imperfection may be, and how large.

# %%
from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np
from scipy.optimize import brentq

import kirigami as kg

# %% [markdown]
# ## The sheet
#
# 200 mm by 200 mm of polyester film, 0.3 mm thick, with a slit of 100 mm. A slit is a line without width; the mesh
# opens along it. `clamp=True` holds the slope at the grips as well. All is in metres and newtons: the package knows no
# units, so any consistent set will do. The upper grip moves by 0.1 mm at load factor 1.

# %%
THICKNESS, PULL = 0.3e-3, 0.1e-3


def held_sheet() -> tuple[kg.Model, list[kg.Node]]:
    """The flat model, ready to be pulled, and its upper grip."""
    outline, slit = kg.cuts.single_slit_rectangle(0.2, 0.2, length=0.1)
    sheet = kg.Sheet(outline, slit, THICKNESS, kg.Material(E=3.5e9, nu=0.34))
    model = kg.Model.from_mesh(sheet.mesh(max_edge=0.015))
    bottom, top = model.select(boundary="bottom"), model.select(boundary="top")
    model.add(kg.Fix(bottom, clamp=True), kg.Fix(top, "xz", clamp=True), kg.Prescribe(top, y=PULL))
    return model, top


flat, top = held_sheet()
print(flat)
flat.plot()
plt.show()

# %% [markdown]
# ## The flat path, and where it loses its stability
#
# `on_instability="follow"` stays on the flat path whether it is stable or not. `Eigen(model, about=step)` gives the
# lowest eigenvalue of the tangent stiffness at an equilibrium: how much the sheet still resists the shape it resists
# least. At first the pull makes the sheet stiffer, as it does a drum; then the squeezed lips win. Buckling is where the
# eigenvalue crosses zero.

# %%
still_flat = kg.DisplacementControl(flat, targets=np.linspace(0.02, 0.4, 20), on_instability="follow").run()
early = [step for step in still_flat.steps if step.lam <= 0.4]
softness = np.array([kg.Eigen(flat, n=1, about=step).run().values[0] for step in early])
load_factors = np.array([step.lam for step in early])

crossing = int(np.argmax(softness < 0))
near = slice(crossing - 2, crossing + 3)  # five steps around the crossing, and the root of a cubic through them
cubic = np.polynomial.Polynomial.fit(load_factors[near], softness[near], 3)
critical = float(brentq(cubic, *load_factors[[crossing - 1, crossing]]))
print(f"the flat sheet buckles at a pull of {1e3 * PULL * critical:.4f} mm, a stretch of {PULL * critical / 0.2:.1e}")

_, ax = plt.subplots(figsize=(4.6, 3), layout="constrained")
ax.plot(1e3 * PULL * load_factors, softness, "o-", markersize=3)
ax.axhline(0, color="0.8", linewidth=0.8)
ax.plot(1e3 * PULL * critical, 0, "o", markersize=8, markerfacecolor="none", color="tab:red")
ax.set(xlabel="pull [mm]", ylabel="lowest eigenvalue [N/m]")
plt.show()

# %% [markdown]
# One more run, to that very pull, gives the modes there. The lowest eigenvalue is as good as zero.

# %%
at_buckling = kg.DisplacementControl(flat, to=critical, on_instability="follow").run()[-1]
first, second = kg.Eigen(flat, n=2, about=at_buckling).run()
print(f"eigenvalues: {first.value:.1e} and {second.value:.1e} N/m")

# %% [markdown]
# In the softest mode both lips go to the same side, in the next one they part. Colours are heights, the largest is 1.

# %%
figure, axes = plt.subplots(1, 2, figsize=(7, 3.4), layout="constrained")
x, y, _ = flat.positions().T
for ax, mode, title in zip(axes, (first, second), ("first mode", "second mode")):
    height = mode.shape[:, 2]
    shades = ax.tripcolor(x, y, flat.mesh.triangles, height, shading="gouraud", cmap="RdBu_r", vmin=-1, vmax=1)
    ax.plot([0.05, 0.15], [0.1, 0.1], color="black", linewidth=1)
    ax.set(title=title, aspect="equal", xticks=[], yticks=[])
figure.colorbar(shades, ax=axes, label="height / largest height", shrink=0.8)
plt.show()

# %% [markdown]
# ## A seed
#
# A real sheet is never flat. `Model.perturb` moves the nodes by a shape of your choice; the moved state is the new rest
# state, free of stress. The softest mode is the natural choice, because it is what grows first. Here it is a hundredth
# and a third of the thickness high.

# %%
crest = int(np.argmax(np.abs(first.shape[:, 2])))  # the node in the middle of a lip


def pulled(imperfection: float, to: float, steps: int = 1) -> kg.Results:
    """The path of a sheet whose seed is `imperfection` thicknesses high."""
    model, _ = held_sheet()
    model.perturb(first, amplitude=imperfection * THICKNESS)
    # At the critical load the sheet hardly resists: a tiny seed shows only where the residual is smaller still.
    return kg.DisplacementControl(model, to=to, targets=np.linspace(0, to, steps + 1)[1:], tol=1e-10).run()


figure, (force_ax, height_ax) = plt.subplots(1, 2, figsize=(7.5, 3.2), layout="constrained")
grip = flat.index(top)
pull = 1e3 * PULL
force_ax.plot(pull * still_flat.lam, still_flat.reaction(grip, "y"), color="0.6", linestyle="--", label="kept flat")
for share, color in ((0.01, "C0"), (0.33, "C1")):
    path = pulled(share, to=1.0, steps=16)
    label = f"seed {share:g} t"
    force_ax.plot(pull * path.lam, path.reaction(grip, "y"), color=color, label=label)
    height_ax.plot(pull * path.lam, path.u[:, crest, 2] / THICKNESS, color=color, label=label)
for ax, label in ((force_ax, "force [N]"), (height_ax, "deflection of the lip / thickness")):
    ax.axvline(pull * critical, color="0.8", linewidth=0.8)
    ax.set(xlabel="pull [mm]", ylabel=label)
force_ax.legend()
plt.show()

# %% [markdown]
# The grey line marks where the flat sheet buckles. The force bends off there, and the seeds agree about it. The lip
# knows its seed much longer: near buckling a third of the thickness blurs everything, a hundredth shows a clear kink.
# So take a seed that is small against the deflections you are interested in. A hundredth to a tenth of the thickness is
# a good start, and the choice belongs in every report.
#
# The sheet at the end, with displacements ten times as large as they are:

# %%
path.plot(magnify=10)
plt.show()

# %% [markdown]
# ## The number
#
# Why does a small seed matter so much just there? Koiter's theory (1945) of a symmetric buckling point: the height h at
# load factor lambda follows (1 - lambda / lambda_c) h - b h^3 + seed = 0 in suitable units. *At* the critical load the
# linear term vanishes and h grows as the **cube root** of the seed: one a thousand times smaller still gives a tenth
# of the height. The measured exponent tends to 1/3 as the seeds get small; the next term of the theory is of relative
# order (h / t)^2, some per cent here.

# %%
seeds = np.array([1e-5, 1e-4, 1e-3])
heights = np.array([pulled(seed, critical).u[-1, crest, 2] for seed in seeds])
exponents = np.diff(np.log(np.abs(heights))) / np.diff(np.log(seeds))
print("seed / t:", seeds, " height / t:", np.round(np.abs(heights) / THICKNESS, 4))
print(f"exponents {np.round(exponents, 4)}, Koiter: 0.3333")
assert np.all(np.abs(exponents - 1 / 3) < 0.02)
