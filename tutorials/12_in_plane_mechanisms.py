# %% [markdown]
# # 12. In-plane mechanisms, from one hinge to a polarised lattice
#
# Rigid panels joined at corners move by turning against each other. Here panels are bars, joints are angle springs, and
# the whole lives in the plane: two unknowns a node, nothing of bending or z.

# %%
from __future__ import annotations

import math

import matplotlib.pyplot as plt
import numpy as np

import kirigami as kg
from kirigami.lattice.picture import plot_tiling

# %% [markdown]
# ## One hinge
#
# Two links with a spring between them, pushed together: the straight column holds up to 2 k / l and then folds,
# P = 2 k phi / (l sin phi). A slight bend of 0.001 rad in the drawing starts it; the rest angle pi says that the
# spring is free of moment when straight.

# %%
column = kg.Model(dim=2, name="two links")
foot, knee, head = column.add(kg.Node(0, 0), kg.Node(0.001, 1), kg.Node(0, 2))
column.add(kg.Bar(foot, knee, EA=1e6), kg.Bar(knee, head, EA=1e6))
column.add(kg.TorsionSpring3(foot, knee, head, stiffness=1.0, rest_angle=math.pi))
column.add(kg.Fix(foot), kg.Fix(head, "x"), kg.Prescribe(head, y=-0.4))
folded = kg.DisplacementControl(column, step=0.01).run()
phi = math.acos(0.8)
print(f"two links: force {-folded.reaction(head, 'y')[-1]:.4f}, closed form {2 * phi / math.sin(phi):.4f}")

# %% [markdown]
# ## A frame that moves, and one that cannot
#
# Which motions stretch no bar, and which bar forces balance by themselves, follows from the geometry alone.

# %%
square = [(0, 0), (1, 0), (1, 1), (0, 1)]
for braces in ((), ((0, 2),), ((0, 2), (1, 3))):
    frame = kg.Model(dim=2)
    corners = frame.add(*(kg.Node(*corner) for corner in square))
    frame.add(*(kg.Bar(corners[i], corners[j], EA=1.0) for i, j in ((0, 1), (1, 2), (2, 3), (3, 0), *braces)))
    print(f"square with {len(braces)} diagonals: {kg.Framework.from_model(frame).rigidity()}")

# %% [markdown]
# ## A mechanism followed at zero energy
#
# Rotating squares have one internal motion. It can be followed far without any stiffness, and it shrinks the lattice
# equally along x and y.

# %%
open_squares = kg.tilings.rotating_squares(angle=1.4).patch(2, 2)
rigidity = kg.Framework.from_tiling(open_squares, bracing="crossed").rigidity()
print(f"rotating squares: {rigidity}")
(mode,) = rigidity.shapes
path = rigidity.framework.follow(mode, distance=2.0, steps=30)
figure, axes = plt.subplots(1, 2, figsize=(7, 3.4), layout="constrained")
plot_tiling(open_squares, ax=axes[0]).set_title("open")
plot_tiling(open_squares, path[-1], ax=axes[1]).set_title("followed")
plt.show()

# %% [markdown]
# ## Springs, and the stiffness of a periodic cell
#
# Angle springs give the motion a price. One cell with ties says what the endless lattice resists: E = 8 k / (l^2 (1 -
# sin theta)) and Poisson's ratio -1.

# %%
cell = kg.tilings.rotating_squares(angle=0.6)
periodic = kg.PeriodicCell(cell.model(EA=1e6, stiffness=1.0), cell.lattice, cell.images)
compliance = np.linalg.inv(periodic.stiffness())
print(
    f"rotating squares: E = {1 / compliance[0, 0]:.3f}, closed form {8 / (1 - math.sin(0.6)):.3f}; "
    f"Poisson's ratio {-compliance[0, 1] / compliance[0, 0]:.4f}"
)

# %% [markdown]
# ## A cell of a sheet that bends
#
# What is no mechanism but an elastic sheet has a cell as well, which may leave the plane. `CellSheet` repeats each slit
# by the lattice and meshes opposite sides alike. The cell tells the stiffness of the endless sheet, and at which strain
# and in which wave it buckles: here in one along the slits, as long as any that was looked at, in which the sheet also
# bends as a whole; the strain goes with the thickness squared.

# %%
slits = [[(-6, 2.5), (6, 2.5)], [(4, 7.5), (16, 7.5)]]
onset = {}
for thickness in (0.1, 0.05):
    sheet = kg.CellSheet([(20, 0), (0, 10)], slits, thickness, kg.Material(E=4000.0, nu=0.3))
    sheet_cell = kg.PeriodicCell(kg.Model.from_mesh(sheet.mesh(10.0, 5.0), stiffness="facet"), sheet.lattice)
    found = sheet_cell.buckling((None, 1.0, 0.0))  # strains along x, along y, of shear: free, driven, none
    onset[thickness] = found.strain[1]
    stretching = np.diag(sheet_cell.section())[:2] / (4000.0 * thickness)
    print(f"thickness {thickness}: {found}; along and across the slits {stretching.round(3)} of E t")
print(f"twice as thick, {onset[0.1] / onset[0.05]:.3f} times the strain: bending resists with the cube")

# %% [markdown]
# ## A lattice at the brink of rigidity
#
# Equilateral and scalene triangles: six bars and six coordinates a cell. The cell has one uniform motion, its twist.
# Twisting the lattice past the angles where sides come into line changes an integer, the polarisation: it says towards
# which edge the soft motions of a finite piece are pushed.

# %%
figure, axes = plt.subplots(1, 2, figsize=(7, 2.8), layout="constrained")
for angle, ax in zip((1.08, 1.92), axes):
    kagome = kg.Framework.from_tiling(kg.tilings.kagome(angle))
    (twist,) = kg.bloch.guest_modes(kagome)
    soft = kg.bloch.polarization(kagome) + 0.0
    print(f"angle {angle}: polarisation {soft}, Poisson's ratio of the twist {twist.poisson:.3f}")
    plot_tiling(kg.tilings.kagome(angle).patch(5, 4), ax=ax).set_title(f"angle {angle}")
plt.show()

# %% [markdown]
# ## The soft edge
#
# Push one hinge of the bottom edge, then one of the top edge, the opposite edge pinned. The polarisation points up: the
# top is the soft one, and the more so the larger the lattice. Both edges end on rows with one hinge per cell.


# %%
def edge_stiffness(angle: float, columns: int, rows: int, pushed: str) -> float:
    """Force over displacement of the middle hinge of an edge, in its softest direction."""
    cell = kg.tilings.kagome(angle)
    piece = cell.patch(columns, rows + 1, keep=lambda a, b, panel: b > 0 if panel == 0 else b < rows)
    model = piece.model(EA=1.0, stiffness=1e-6)
    height = piece.vertices[:, 1].max()
    edges = {
        "bottom": model.select(where=lambda x, y, z: y < 1e-6),
        "top": model.select(where=lambda x, y, z: y > height - 1e-6),
    }
    middle = sorted(edges[pushed], key=lambda node: node.x)[columns // 2]
    model.add(kg.Fix(edges["top" if pushed == "bottom" else "bottom"]))
    compliance = np.zeros((2, 2))
    for axis, force in enumerate(np.eye(2)):
        load = model.add(kg.NodalLoad(middle, force))
        compliance[:, axis] = kg.LinearStatic(model).run().u[-1, model.index(middle)[0], :2]
        model.remove(load)
    return float(1 / np.linalg.eigvalsh(compliance)[-1])


contrast = 0.0
for angle in (1.08, 1.92):
    for columns, rows in ((15, 10), (30, 16)):
        hard, soft = (edge_stiffness(angle, columns, rows, edge) for edge in ("bottom", "top"))
        contrast = hard / soft
        print(f"angle {angle}, {columns} x {rows} cells: bottom over top {contrast:.2f}")

# %% [markdown]
# The last number, at 1.92 rad with 30 x 16 cells, is about 22; a sweep and pictures are in
# `examples/polarised_lattice.py`.

# %%
assert abs(contrast / 21.7 - 1) < 0.02
print(f"contrast of the polarised lattice: {contrast:.1f}")
