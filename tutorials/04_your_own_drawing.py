# %% [markdown]
# # 4. Your own drawing
#
# You have a drawing from a CAD or vector program and want to know what the sheet does. Here a round sheet with rings of
# slits: lift the middle, and it becomes a lampshade. There is no closed form for it, so this tutorial is also about the
# checks that hold for *any* design.
#
# Reading and writing drawings needs the extra libraries of `pip install "kirigami-mechanics[io]"`.

# %%
from __future__ import annotations

import math
import tempfile
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import shapely
from scipy.integrate import trapezoid

import kirigami as kg
from kirigami.drawing.convert import read_drawing

# %% [markdown]
# ## The drawing
#
# You would save an SVG or DXF file from your program. To keep everything on one page, the script writes the file that
# Inkscape would: millimetres, a layer for the outline, a layer for the cuts, slits as circular arcs. Six rings have two
# slits each, every other ring turned by a right angle.


# %%
def arc(radius: float, start: float, end: float) -> str:
    """An SVG path along a circle about the centre of the page, angles in degrees."""
    points = [(50 + radius * math.cos(math.radians(a)), 50 + radius * math.sin(math.radians(a))) for a in (start, end)]
    (x0, y0), (x1, y1) = points
    return f'<path d="M {x0:.6f},{y0:.6f} A {radius},{radius} 0 0 1 {x1:.6f},{y1:.6f}"/>'


slits = [
    arc(radius, turn + 90 * (ring % 2) + 14, turn + 90 * (ring % 2) + 166)
    for ring, radius in enumerate((14, 19, 24, 29, 34, 39))
    for turn in (0, 180)
]
svg = f"""<svg xmlns="http://www.w3.org/2000/svg" xmlns:inkscape="http://www.inkscape.org/namespaces/inkscape"
  width="100mm" height="100mm" viewBox="0 0 100 100" fill="none" stroke="black">
  <g inkscape:groupmode="layer" inkscape:label="Outline"><circle cx="50" cy="50" r="45"/></g>
  <g inkscape:groupmode="layer" inkscape:label="Cuts">{"".join(slits)}</g>
</svg>"""
folder = tempfile.TemporaryDirectory()
file = Path(folder.name) / "lampshade.svg"
_ = file.write_text(svg)

# %% [markdown]
# ## Reading it
#
# `read_drawing` goes by the ending of the name: .dxf, .svg, .geojson, .fold. Lengths are converted to metres. The
# report says what was read, joined, dropped and assumed; look at it, and look at the picture. Layers are recognised by
# their names; with other names or colours say `cuts="red"` or `outline="Layer 3"`. (Once you know your drawing,
# `kg.Sheet.from_svg` and `from_dxf` make the sheet in one go.) `flatness` is how far the chords of a curve may lie off
# it, as a fraction of the size; short chords would force short edges on the mesh.

# %%
drawing = read_drawing(file, flatness=1e-3)
print(drawing.report)
sheet = drawing.sheet(thickness=0.25e-3, material=kg.Material(E=3.5e9, nu=0.34))
sheet.plot()
plt.show()

# %% [markdown]
# ## The model
#
# The rim is held. The disc inside the first ring is lifted by 30 mm and kept from turning or tilting, as if glued to a
# rod; the circle given by `lines` makes its edge an edge of the mesh. A lifted middle leaves the plane at once, so no
# imperfection is needed.

# %%
LIFT, ROD = 0.03, 0.011
middle = shapely.Point(0.05, 0.05)


def lampshade(max_edge: float) -> tuple[kg.Model, list[kg.Node]]:
    """The model and the nodes that are lifted."""
    model = kg.Model.from_mesh(sheet.mesh(max_edge, lines=[middle.buffer(ROD).exterior]))
    rim = model.select(boundary="outer")
    rod = model.select(where=lambda x, y, z: np.hypot(x - 0.05, y - 0.05) < ROD * (1 + 1e-6))
    model.add(kg.Fix(rim, clamp=True), kg.Fix(rod, "xy"), kg.Prescribe(rod, z=LIFT))
    return model, rod


model, rod = lampshade(max_edge=0.01)
results = kg.DisplacementControl(model, targets=np.linspace(0, 1, 26)[1:]).run()
print(results.summary())
results.plot(view=(25, -60))
plt.show()

# %% [markdown]
# ## Checks that hold for any design
#
# **Forces balance.** What the rod pulls up, the rim holds down. This is an exact law; only the residual of the solver
# is left.

# %%
lift_force = results.reaction(rod, "z")
rim_force = results.reaction(model.select(boundary="outer"), "z")
print(f"force at the rod {lift_force[-1]:.6f} N, at the rim {rim_force[-1]:.6f} N")
assert abs(lift_force[-1] + rim_force[-1]) < 1e-6 * lift_force[-1]

# %% [markdown]
# **Energy balances.** Elastic equilibria only: the work of the rod is stored in the sheet. The work is the area under
# the force curve, here by the trapezoidal rule over the stored steps, so expect agreement to its error, less than one
# part in a thousand. A *missing* part of the energy would tell of a snap between two steps.

# %%
ax = results.plot_curve(rod, "z", x=1e3 * LIFT * results.lam)
ax.set(xlabel="lift [mm]", ylabel="force [N]")
plt.show()
work = float(trapezoid(lift_force, LIFT * results.lam))
stored = {name: float(energy[-1]) for name, energy in results.energy.items()}
print(f"work {1e3 * work:.4f} mJ, stored {1e3 * sum(stored.values()):.4f} mJ:", end=" ")
print(", ".join(f"{name} {1e3 * energy:.4f}" for name, energy in stored.items()))

# %% [markdown]
# Nearly all of it is in the hinges: the sheet bends, it hardly stretches. That is why such sheets are so soft, and why
# the force goes with the cube of the thickness.
#
# **A finer mesh changes little.** How much it changes is the best estimate of the error that you can get without
# another program: here some per cent, for a few facets across each ring. (For a second opinion, `model.to_abaqus`
# and `model.to_openseespy` hand the same sheet to a shell code.)

# %%
refined, lifted = lampshade(max_edge=0.005)
finer = kg.DisplacementControl(refined).run().reaction(lifted, "z")[-1]
print(f"{len(model.nodes)} nodes: {lift_force[-1]:.4f} N; {len(refined.nodes)} nodes: {finer:.4f} N")

# %% [markdown]
# ## Hand it on
#
# A DXF file for the laser cutter, in true millimetres with outline and cuts on layers of their own; and a page for the
# colleague who has only a browser: the sheet turns under the mouse and a slider lifts it.

# %%
dxf = sheet.to_dxf(Path(folder.name) / "lampshade.dxf")
page = results.to_html(Path(folder.name) / "lampshade.html", reactions={"rod": rod}, title="Lampshade")
print(f"{dxf.name}: {dxf.stat().st_size // 1000} kB, {page.name}: {page.stat().st_size // 1000} kB")
again = read_drawing(dxf)
farthest = max(shapely.hausdorff_distance(one, other) for one, other in zip(drawing.cuts, again.cuts))
assert len(again.cuts) == len(drawing.cuts) == 12 and farthest < 1e-9 * 0.1
folder.cleanup()

# %% [markdown]
# From a terminal, the usual pull between two ends is one line, with a folder of pictures, tables and such a page:
#
# ```
# kirigami stretch drawing.dxf --thickness 0.1mm --E 3.5GPa --nu 0.34 --strain 20%
# ```
#
# ## The number
#
# Work over stored energy is one. The trapezoidal rule with 25 intervals leaves less than one part in a thousand.

# %%
balance = work / sum(stored.values())
print(f"work / stored energy = {balance:.4f}")
assert abs(balance - 1) < 0.002
