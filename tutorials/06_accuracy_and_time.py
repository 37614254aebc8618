# %% [markdown]
# # 6. Accuracy and time
#
# How far can a result be trusted, and what would more accuracy cost? This tutorial takes one small sheet from the first
# coarse run to a mesh chosen for a wanted error: what the elements represent, how the rungs of accuracy compare, how
# fine the mesh must be, where it must be fine, and what stress there is in the end.

# %%
from __future__ import annotations

import tempfile
from collections.abc import Sequence
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import shapely

import kirigami as kg

# %% [markdown]
# ## The sheet
#
# A square of polyester film, 100 mm wide and 0.3 mm thick, with a slit of 50 mm across the pull. Everything that
# follows needs one function: it makes the model for a mesh size and a rung, held, driven and slightly bent, and says
# where the force is measured. The imperfection is a formula, a tenth of a millimetre high, so that it is the same on
# every mesh. The pull is 0.05 %, some times what buckles the lips of the slit.

# %%
SLIT = shapely.LineString([(0.025, 0.05), (0.075, 0.05)])
SHEET = kg.Sheet(shapely.box(0, 0, 0.1, 0.1), SLIT, thickness=0.3e-3, material=kg.Material(E=3.5e9, nu=0.34))


def pulled(mesh: kg.TriMesh, stiffness: str) -> tuple[kg.Model, Sequence[kg.Node], str]:
    """The sheet on a mesh: model, driven nodes, axis of the force."""
    model = kg.Model.from_mesh(mesh, stiffness=stiffness)
    bottom, top = model.select(boundary="bottom"), model.select(boundary="top")
    model.add(kg.Fix(bottom, clamp=True), kg.Fix(top, "xz", clamp=True), kg.Prescribe(top, y=0.0005 * 0.1))
    x, y, _ = mesh.nodes.T
    model.perturb(np.sin(np.pi * x / 0.1) * np.exp(-(((y - 0.05) / 0.03) ** 2)), amplitude=1e-4)
    return model, top, "y"


def case(max_edge: float, stiffness: str) -> tuple[kg.Model, Sequence[kg.Node], str]:
    """The sheet on a mesh of one size."""
    return pulled(SHEET.mesh(max_edge), stiffness)


# %% [markdown]
# ## Rungs: what do the elements represent?
#
# `stiffness=` chooses the rung. "paper" has the constants of the publication, "plate" bars and hinges with those of a
# plate, "facet" couples the three bars and the three hinges of a facet, and "shell" converges to shell theory.
# `kg.stiffness.report` measures the elastic constants that a mesh with these elements stands for. What it says holds on
# any mesh of this kind: no refinement helps where a number is not 1.

# %%
mesh = SHEET.mesh(0.02)
for rung in ("plate", "facet", "shell"):
    print(kg.stiffness.report(mesh, stiffness=rung), end="\n\n")

# %% [markdown]
# ## Error against time
#
# `kg.study.accuracy` runs rungs and sizes one after the other and compares them with a reference: a finer run of the
# last rung, unless you give values of your own. One size is enough to see how it works. The table goes to a file, from
# which an interrupted study goes on.

# %%
with tempfile.TemporaryDirectory() as folder:
    study = kg.study.accuracy(
        case, [0.025], path=Path(folder) / "study", stiffness=["plate", "facet", "shell"], at=[0.2, 1.0]
    )
print(study)
print(study.recommend(0.1))

# %% [markdown]
# A reference that is itself a run is no truth; it only says how far the others are from *it*. So ask in another way.
#
# ## A band
#
# Far above buckling, a thin sheet is strongly curved. Flat facets cannot follow it without stretching, so on a coarse
# mesh "facet" is too stiff; shell facets follow it, and may be a little too soft where one turns far.
# `kg.study.bracket` runs both on two meshes. Only where they close in on each other from two sides does the band
# between them hold the truth, and the last line says whether they do.

# %%
band = kg.study.bracket(case, 0.02)
print(band)

# %% [markdown]
# Not here: so gently buckled, both are too stiff, and by nearly the same. A narrow band that is no bracket is worth
# nothing! What is wrong with both is the mesh.
#
# ## Where is the mesh too coarse?
#
# Exact strains and curvatures are continuous, those of facets jump. `kg.study.estimate_error` measures the jumps in
# terms of energy, for every facet. The sizes of meshes that came from `max_edge` are graded along cuts; the picture
# shows that it is the tips that want more, and some places that nobody thought of.

# %%
coarse = band.runs[3]  # the shell facets on the finer mesh
estimate = kg.study.estimate_error(coarse.results)
print(estimate)
estimate.plot()
plt.show()

# %% [markdown]
# The estimate can also give the mesh: `estimate.size(nodes)` is a wanted edge length for every place, such that the
# error is spread evenly over about so many nodes. `sheet.mesh(..., size=...)` follows it.

# %%
refined = SHEET.mesh(0.2, cut_edge=0.2, size=estimate.size(250))
model, top, axis = pulled(refined, "shell")
results = kg.DisplacementControl(model).run()
better = kg.study.estimate_error(results)
force = results.reaction(top, axis)[-1]
print(refined)
print(f"force {force:.4g} N; before, on {coarse.nodes} nodes, it was {coarse.value:.4g} N")
print(better)
kg.plot.plot_mesh(refined)
plt.show()

# %% [markdown]
# ## How fine must a uniform mesh be?
#
# `kg.study.choose_mesh` needs two coarse runs. It extrapolates, picks a size for the wanted error, runs it, and
# compares what it expected with what it got. It refuses runs that end in different shapes, because no law connects
# them. To keep this page quick, the sheet stays flat here (`dim=2`).


# %%
def flat(max_edge: float, stiffness: str) -> tuple[kg.Model, Sequence[kg.Node], str]:
    """The sheet in its plane."""
    model = kg.Model.from_mesh(SHEET.mesh(max_edge), stiffness=stiffness, dim=2)
    top = model.select(boundary="top")
    model.add(kg.Fix(model.select(boundary="bottom")), kg.Prescribe(top, x=0, y=0.0005 * 0.1))
    return model, top, "y"


choice = kg.study.choose_mesh(flat, start=0.03, error=0.05, stiffness="facet")
print(choice)

# %% [markdown]
# ## Stress
#
# `results.stress()` has tensors, principal stresses, membrane forces and moments of every facet, as its elements bear
# them. `plot_stress` draws one of them on the deformed sheet, here the largest principal stress at the upper face [Pa].

# %%
results.plot_stress(view=(35, -60), magnify=10)
plt.show()
stress = results.stress(-1)
print(f"{100 * stress.membrane_share:.0f} % of the energy is in stretching")
print(f"largest von Mises stress at the faces: {1e-6 * max(stress.von_mises('top').max(), 0):.0f} MPa")

# %% [markdown]
# The largest stress belongs to the mesh, not to the sheet: at the tip of a slit it grows without bound as the mesh gets
# finer. The force does not.
#
# ## The number
#
# Pulled in its plane, a sheet on coarse facets is too stiff. The energy norm is a root, so an estimate of 20 % there is
# one of 0.2^2 = 4 % in the force. Take that off the force of the coarse mesh, and it should meet the force of the
# refined one, less what *its* estimate says.

# %%
corrected = [value * (1 - e.relative**2) for value, e in ((coarse.value, estimate), (force, better))]
print(f"coarse {coarse.value:.2f} -> {corrected[0]:.2f} N, refined {force:.2f} -> {corrected[1]:.2f} N")
assert better.relative < 0.75 * estimate.relative
assert not band.closing and force < band.low
assert abs(corrected[0] / corrected[1] - 1) < 0.5 * abs(coarse.value / force - 1)
