# %% [markdown]
# # 13. Yield and contact: what stays bent, and what touches itself
#
# Real sheets are creased: film yields at a strain of some hundredths, and lips that open wide fold onto each other. An
# elastic sheet that passes through itself gives numbers all the same, so the package tells of both, asked or not; and
# where it matters it computes them. Here a strip is bent beyond yield and let go, a loop is pushed together until its
# legs touch, and a pad is dragged over a floor. Contact needs the extra `contact`
# (`pip install 'kirigami-mechanics[contact]'`).

# %%
from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np

import kirigami as kg


def strip(length: float, width: float, columns: int) -> kg.TriMesh:
    """A strip along x, one cell wide, its diagonals in turn."""
    x = np.linspace(0, length, columns + 1)
    nodes = [(a, b) for a in x for b in (0.0, width)]
    facets = []
    for k in range(columns):
        a = 2 * k
        facets += [(a, a + 2, a + 3), (a, a + 3, a + 1)] if k % 2 else [(a, a + 2, a + 1), (a + 2, a + 3, a + 1)]
    return kg.TriMesh(nodes, facets)


# %% [markdown]
# ## It is told
#
# A yield stress is part of a material. With `hardening=None` the sheet stays elastic, and results say where that is
# wrong: the strip below bears the moment at which a real one has yielded through and through.

# %%
E, NU, LIMIT, THICK, LENGTH = 70e9, 0.3, 150e6, 1e-3, 0.02  # soft aluminium
MOMENT = 2 / np.sqrt(3) * LIMIT * THICK**2 / 4  # a width that has yielded through and through bears no more than this


def wide(material: kg.Material) -> tuple[kg.Model, list[kg.Node]]:
    """A piece of a wide strip between planes of symmetry, with a moment on its end."""
    m = kg.Model.from_mesh(strip(LENGTH, 0.005, 4), thickness=THICK, material=material, stiffness="shell")
    right = m.select(boundary="right")
    for side, normal in (("left", "x"), ("top", "y"), ("bottom", "y")):
        m.add(kg.Symmetry(m.select(boundary=side), normal))
    m.add(kg.Fix(m.select(boundary="left")[0], "z"), kg.EdgeMoment(right, MOMENT))
    return m, right


elastic, _ = wide(kg.Material(E, NU, yield_stress=LIMIT, hardening=None))
told = kg.LoadControl(elastic).run()
print(next(event.message for event in told.events if event.kind == "beyond yield"))

# %% [markdown]
# ## It is computed
#
# Without that, or with a modulus or a table of hardening, shell facets yield layer by layer. Bent to a curvature of
# 60 per metre, the moment has passed the fully plastic one, by what has hardened. Let go, the strip opens
# elastically: what is left is the curvature less M / D.

# %%
soft, right = wide(kg.Material(E, NU, yield_stress=LIMIT, hardening=7e8))
curvature = np.linspace(0, 60, 13)[1:]
heights = (1 - np.cos(curvature * LENGTH)) / curvature
bent = kg.DisplacementControl(soft, to=heights[-1], control=(right[0], "z"), targets=heights).run()
free = kg.LoadControl(soft, to=0.0, start=bent[-1]).run()


def mean_curvature(res: kg.Results) -> float:
    return float(res.stress(-1).curvature[:, 0, 0].mean())


rigidity = E * THICK**3 / (12 * (1 - NU**2))
by_hand = mean_curvature(bent) - bent.lam[-1] * MOMENT / rigidity
print(f"moment {bent.lam[-1]:.3f} of the plastic one, left {mean_curvature(free):.2f} / m, by hand {by_hand:.2f} / m")
print(f"{100 * bent.yielded[-1]:.0f} % has yielded")

# %% [markdown]
# A next stage goes on from any stored step, by `start=`, or after `model.hold(step)`. Cycles, spring-back and creases
# are made that way; [yield.md](../docs/yield.md) has what yields on which rung.
#
# ## Legs that meet
#
# A clamped strip is pushed together. Without contact its legs pass through each other, which is an event; with
# `kg.SelfContact` they are held a thickness apart. They meet at 0.849 of the length, as the closed form of the thin
# elastica has it.

# %%
SPAN, FILM = 0.1, kg.Material(3.5e9, 0.0)


def loop(*effects: kg.ModelObject) -> kg.Results:
    m = kg.Model.from_mesh(strip(SPAN, 0.01, 40), thickness=1e-4, material=FILM, stiffness="plate")
    left, right = m.select(boundary="left"), m.select(boundary="right")
    m.add(kg.Fix(left, clamp=True), kg.Fix(right, "yz", clamp=True), kg.Prescribe(right, x=-SPAN), *effects)
    m.perturb(2e-4 * np.sin(np.pi * m.positions()[:, 0] / SPAN) ** 2)
    return kg.DisplacementControl(m, to=0.88, targets=[0.8, 0.84, 0.86]).run()


through, held = loop(), loop(kg.SelfContact())
for res in (through, held):
    print(*(event.message for event in res.events if event.kind in ("contact", "crossing")), sep="\n")
met = next(event for event in held.events if event.kind == "contact")

figure, ax = plt.subplots(figsize=(5, 4), layout="constrained")
for name, res in (("through itself", through), ("with contact", held)):
    x, _, z = res.position()[-1, ::2].T
    ax.plot(1e3 * x, 1e3 * z, ".-", markersize=3, label=name)
ax.set(xlabel="x [mm]", ylabel="z [mm]", aspect="equal")
figure.legend(loc="outside right center")
plt.show()

# %% [markdown]
# ## Friction, and an obstacle
#
# Fixed surfaces are meshes as well. A pad is pressed on a floor of one facet by its weight, and dragged: it sticks,
# slips by up to the layer, and then slides at mu N. Friction is one increment behind the pressure, so it is pressed
# first.

# %%
MU, PRESS, FAR = 0.3, 60.0, 4e-3
floor = kg.TriMesh(np.array([(-0.1, -0.1, -1.9e-3), (0.4, -0.1, -1.9e-3), (-0.1, 0.4, -1.9e-3)]), np.array([(0, 1, 2)]))
pad = kg.Model.from_mesh(strip(0.05, 0.02, 4), thickness=2e-3, material=FILM, stiffness="facet")
guide = pad.add(kg.Fix(pad.nodes, "xy"))
pad.add(kg.Spring(pad.nodes, 1e-2), kg.NodalLoad(pad.nodes, (0, 0, -PRESS / len(pad.nodes))))
pad.add(kg.SelfContact(thickness=1.8e-3, layer=5e-4, friction=MU, obstacles=[floor]))
lying = kg.LoadControl(pad).run()[-1]
pad.hold(lying)
pad.remove(guide)
pad.add(kg.Prescribe(pad.nodes, x=FAR, y=0))
dragged = kg.DisplacementControl(pad, targets=np.linspace(0.05, 1, 12), start=lying).run()
pull = dragged.reaction(pad.nodes, "x")
used = np.linalg.norm(dragged.deformation("self-friction"), axis=2).max(axis=1)  # of the limit, 1 where it slides

figure, ax = plt.subplots(figsize=(5, 2.6), layout="constrained")
ax.plot(1e3 * FAR * dragged.lam, pull, ".-")
ax.axhline(MU * PRESS, color="0.6", linewidth=1)
ax.set(xlabel="dragged by [mm]", ylabel="pull [N]")
plt.show()
print(f"pull {pull[-1]:.3f} N, mu N {MU * PRESS:.3f} N")

# %% [markdown]
# Layers, stiffness, limits: [self_contact.md](../docs/self_contact.md).
#
# ## The numbers

# %%
assert told.yielded[-1] == 1.0 and 1.0 < bent.lam[-1] < 1.1
assert abs(mean_curvature(free) / by_hand - 1) < 0.01
assert any(event.kind == "crossing" for event in through.events)
assert not any(event.kind == "crossing" for event in held.events)
assert met.bracket[0] - 0.01 < 0.849 < met.bracket[1] + 0.01
assert abs(pull[-1] / (MU * PRESS) - 1) < 0.01 and used[-1] > 0.999
