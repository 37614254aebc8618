# %% [markdown]
# # 8. Design: a number asked for, a drawing that gives it
#
# So far a drawing was given and a force came out. Here a force is asked for, and the drawing is found: first how
# the force changes with the sheet, facet by facet, then how long a slit must be, and at the end the drawing is
# exported, read back and pulled once more, as whoever cuts it would.

# %%
from __future__ import annotations

import tempfile
from pathlib import Path

import matplotlib.pyplot as plt
import shapely

import kirigami as kg

WIDTH, HEIGHT, PULL = 0.1, 0.08, 0.002  # m
FILM = kg.Material(E=2e9, nu=0.3)
OUTLINE = shapely.box(0, 0, WIDTH, HEIGHT)


def cuts(length: float) -> list[shapely.LineString]:
    """One slit of that length, and one from either side above it."""
    return [
        shapely.LineString([(0.5 * (WIDTH - length), 0.025), (0.5 * (WIDTH + length), 0.025)]),
        shapely.LineString([(0, 0.055), (0.03, 0.055)]),
        shapely.LineString([(WIDTH - 0.03, 0.055), (WIDTH, 0.055)]),
    ]


def grips(m: kg.Model) -> None:
    """Both ends are clamped, and the upper one is pulled."""
    bottom, top = m.select(boundary="bottom"), m.select(boundary="top")
    m.add(kg.Fix(bottom, clamp=True), kg.Fix(top, "xz", clamp=True), kg.Prescribe(top, y=PULL))


# %% [markdown]
# ## A sheet given by a number
#
# A `kg.Design` is a sheet whose cuts are a function of named numbers: here the length of a slit, with the range in
# which it may be looked for. One mesh follows, so that everything is a smooth function of it.

# %%
design = kg.Design(
    cuts, outline=OUTLINE, supports=grips, thickness=1e-3, material=FILM, mesh={"max_edge": 0.03},
    length=(0.07, 0.035, 0.085),
)  # fmt: skip
res = design.walk([1.0])
force = float(res.reaction("driven_0", "y")[-1])
print(design, f"bears {force:.0f} N")

# %% [markdown]
# ## Gradients
#
# `results.gradient` tells how the force changes with the length, and with the thickness of every facet, for the
# price of one factorisation. Drawn on the sheet it says where more material would help most. Forces held by
# displacements are in proportion to E, whatever the sheet does, which is a check on the last digits.

# %%
pull = ("force", "driven_0", "y")
print(f"{1e-3 * res.gradient(pull, design)['length']:.0f} N for a millimetre more of slit")
kg.plot.plot_gradient(res.mesh, res.gradient(pull, "thickness"), label="N per m of thickness and m$^2$")
plt.show()
by_modulus = res.gradient(pull, ("E", None)) * FILM.E

# %% [markdown]
# ## The length for a force
#
# Wanted is a tenth more. `kg.Inverse` follows the gradient from design to design; each goes on from the equilibrium
# of the last one, and is walked from flat where its branch ends. With `corrections=None` nothing is walked on a
# finer mesh; left out, the answer is corrected by one and says whether it is `verified` there.

# %%
found = kg.Inverse(design, (pull, 1.0, 1.1 * force), corrections=None).run()
print(found.summary())

# %% [markdown]
# ## Out to the cutter, and back
#
# The drawing is all that leaves the house. Read back, meshed anew and pulled from flat it bears what was asked for,
# but for what the mesh weighs: a few percent here, with so few facets. That is what corrections are for.

# %%
with tempfile.TemporaryDirectory() as folder:
    found.design.sheet().to_geojson(Path(folder) / "sheet.geojson")
    drawn = kg.Sheet.from_geojson(Path(folder) / "sheet.geojson")
again = kg.Design(
    list(drawn.cuts), outline=drawn.outline, supports=grips, thickness=lambda t: t, material=FILM,
    mesh={"max_edge": 0.03}, t=1e-3,
)  # fmt: skip
redone = float(again.walk([1.0]).reaction("driven_0", "y")[-1])
print(f"asked {1.1 * force:.0f} N, drawn, read back and pulled {redone:.0f} N")

# %%
assert abs(by_modulus / force - 1) < 1e-6
assert found.status == "met" and found.coarse_error < 1e-3
assert found.values["length"] < 0.07
assert abs(redone / (1.1 * force) - 1) < 0.1
