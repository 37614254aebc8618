# %% [markdown]
# # 1. A truss, and how to follow it through a snap
#
# Two bars lean against each other and are pushed down at the apex. Up to a certain load the truss holds; then it snaps
# through to the other side. It is the smallest structure that does what cut sheets do, and it has a closed form, so it
# shows what the three ways of following a path are for.

# %%
from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np

import kirigami as kg

# %% [markdown]
# ## The model
#
# Nodes are points, a bar joins two of them, and everything is added to a model. `dim=2` keeps the truss in the plane.
# `EA` is Young's modulus times cross-section, a force; with `EA = 1` all forces below are shares of it. `Fix` holds
# displacements, `NodalLoad` pushes. The load is what acts at *load factor* 1; an analysis scales it up from zero.

# %%
truss = kg.Model(dim=2, name="von Mises truss")
left, apex, right = truss.add(kg.Node(-1, 0), kg.Node(0, 1, name="apex"), kg.Node(1, 0))
truss.add(kg.Bar(left, apex, EA=1.0), kg.Bar(apex, right, EA=1.0))
truss.add(kg.Fix([left, right]), kg.Fix(apex, "x"), kg.NodalLoad(apex, (0, -1)))
print(truss)
truss.plot()
plt.show()

# %% [markdown]
# ## A weight on the apex: load control
#
# `LoadControl` raises the load step by step, as somebody who puts on one weight after another. At the limit load there
# is no equilibrium nearby any more. `on_instability="switch"` lets the truss run downhill to where it comes to rest,
# and the result says what happened: where it snapped and how much energy was set free. (With `"follow"`, the default
# for trusses, the analysis stops there with an error that carries the steps so far; see tutorial 9.)

# %%
loaded = kg.LoadControl(truss, to=0.2, on_instability="switch").run()
print(loaded.summary())
for event in loaded.events:
    print(event)

# %% [markdown]
# ## A hand that guides the apex: displacement control
#
# Now the displacement of the apex is walked, and the load factor is whatever keeps it there: at first a push, later a
# pull. Nothing snaps, and both limit points are found on the way. Increments adapt by themselves; `targets` asks for
# displacements that are to be hit exactly, here for a smooth curve.

# %%
driven = kg.DisplacementControl(truss, to=-2.2, control=(apex, "y"), targets=np.linspace(0, -2.2, 34)[1:]).run()
for event in driven.events:
    print(event)

# %% [markdown]
# ## Wherever the path goes: arc length
#
# Other structures turn back in displacement as well as in load. `ArcLength` walks along the path itself and asks for
# neither. You say how long the first step is and when to stop.

# %%
walked = kg.ArcLength(truss, step=0.02, stop=lambda step: step.u[1, 1] < -2.2).run()
print(f"arc length: {len(walked)} steps to a displacement of {walked[-1].u[1, 1]:.3f}")

# %% [markdown]
# ## The same curve three times
#
# The closed form: at height z of the apex, with the Green strain that bars have by default,
# P / EA = 2 z (1 - z^2) / (2 sqrt(2)^3). A dashed line is an equilibrium that a free weight would not keep:
# `results.stable` tells which steps are stable under a fixed load.

# %%
height = np.linspace(1, -1.25, 200)
closed_form = height * (1 - height**2) / 2**1.5
ax = driven.plot_curve(x=(apex, "y"))
ax.plot(height - 1, closed_form, color="0.75", linewidth=5, zorder=0, label="closed form")
ax.plot(loaded.u[:, 1, 1], loaded.lam, "s", markersize=4, markerfacecolor="none", color="0.2", label="load control")
ax.set_ylabel("force / EA")
ax.legend()
plt.show()

# %% [markdown]
# The squares leave the curve at the top and come back to it far to the left: that is the snap. Where did it land? On
# the same curve, in the last picture, with both bars hanging in tension.

# %%
loaded.plot()
plt.show()

# %% [markdown]
# ## The number
#
# The limit load in closed form is 2 / (3 sqrt(3) sqrt(2)^3), 0.1360828 of EA. Limit points are located to a relative
# 1e-7 in load, whatever the steps were.

# %%
exact = 2 / (3 * 3**0.5 * 2**1.5)
for name, results in (("displacement control", driven), ("arc length", walked)):
    limit = max(event.lam for event in results.events if event.kind == "limit point")
    print(f"{name}: limit load {limit:.8f} EA, closed form {exact:.8f} EA")
    assert abs(limit / exact - 1) < 1e-6
between = next(event.bracket for event in loaded.events if event.kind == "snap")
assert between[0] < exact < between[1]  # a weight cannot find the limit itself, only the two steps around it
