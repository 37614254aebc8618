"""A box that pops up out of a flat sheet by itself: hinges of two layers, of which one swells.

The net of a box is cut out of a sheet, six square faces in a cross, joined by narrow strips. In the strips a second
layer is bonded on top, which shrinks with the drive (a heat that is taken away, a swelling that dries up). Alone, a
strip of two layers would curve like a cap, both ways, by (Timoshenko, J. Opt. Soc. Am. 11 (1925), 233)

    k = 6 e (1 + m)^2 / (t (3 (1 + m)^2 + (1 + m n) (m^2 + 1 / (m n))))

with e the difference of free strains, t the thickness of both layers, m and n the ratios of their thicknesses and
moduli. The faces keep it straight along the fold, so that it becomes part of a cylinder with the curvature (1 + nu) k,
as both layers have the same nu, and folds by (1 + nu) k times its width. It is driven until that is 87 degrees.

    python examples/folding_box.py           some forty seconds: a picture, and what it prints
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import shapely
from numpy.typing import NDArray

import kirigami as kg

SIDE, HINGE = 0.04, 0.008
EDGE = HINGE / 2  # of the mesh in the strips
FACE = 1e-3  # thick and stiff beside the hinges
NU, THIN, THICK, SOFT, STIFF = 0.3, 5e-5, 1e-4, 1.5e9, 3e9
SHRINKING = kg.Material(E=SOFT, nu=NU, expansion=1.0)  # by 1 per unit of drive: the drive is its free strain
STILL = kg.Material(E=STIFF, nu=NU, expansion=0.0)
FACES = {"base": (0, 0), "left": (-1, 0), "right": (1, 0), "front": (0, -1), "back": (0, 1), "lid": (0, 2)}
FOLDS = (("base", "left"), ("base", "right"), ("base", "front"), ("base", "back"), ("back", "lid"))


def curvature(strain: float) -> float:
    """Timoshenko's, for a difference of free strains."""
    m, n, t = THIN / THICK, SOFT / STIFF, THIN + THICK
    return 6 * strain * (1 + m) ** 2 / (t * (3 * (1 + m) ** 2 + (1 + m * n) * (m**2 + 1 / (m * n))))


CLOSED = np.radians(87)  # nearly a right angle, so that faces do not touch
STRAIN = CLOSED / ((1 + NU) * curvature(1.0) * HINGE)  # the free strain that folds by so much


def square(face: str) -> shapely.Polygon:
    """A face in the net."""
    x, y = np.multiply(SIDE + HINGE, FACES[face])
    return shapely.box(x - SIDE / 2, y - SIDE / 2, x + SIDE / 2, y + SIDE / 2)


def strip(first: str, second: str) -> shapely.Polygon:
    """The hinge between two faces."""
    between = shapely.union_all([square(first), square(second)]).convex_hull
    return between.difference(square(first)).difference(square(second))


def edge_lengths(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Edges (n,) of the mesh at points (n, 2): short in the strips and beside them."""
    beyond = np.abs(points[:, :, None] - np.array([-1, 0, 1, 2]) * (SIDE + HINGE) - (SIDE + HINGE) / 2).min(axis=(1, 2))
    return EDGE + (beyond - HINGE / 2).clip(0)


def popped(
    targets: Sequence[float] = (0.25, 0.5, 0.75, 1.0), folds: Sequence[tuple[str, str]] = FOLDS
) -> tuple[kg.Results, NDArray[np.float64]]:
    """The net on its base at shares of the whole drive, and the angles [rad] of its folds there (s, folds)."""
    faces = {name: square(name) for name in FACES if name in np.unique(folds)}
    hinges = {" ".join(pair): strip(*pair) for pair in folds}
    outline = shapely.union_all([*faces.values(), *hinges.values()], grid_size=1e-9)
    mesh = kg.Sheet(outline, regions=faces | hinges).mesh(SIDE / 2, SIDE / 2, size=edge_lengths)
    pair = kg.Laminate([(STILL, THICK), (SHRINKING, THIN)])
    thickness = {**dict.fromkeys(faces, FACE), **dict.fromkeys(hinges, THICK + THIN)}
    material = {**dict.fromkeys(faces, STILL), **dict.fromkeys(hinges, pair)}
    model = kg.Model.from_mesh(mesh, thickness, material, "shell")
    model.add(kg.Fix(model.select(index=np.unique(mesh.triangles[mesh.regions["base"]]))))
    model.add(*[kg.Actuate(name, heat=-STRAIN) for name in hinges])
    results = kg.LoadControl(model, to=targets[-1], targets=targets).run()
    corners = results.position()[:, mesh.triangles]
    areas = np.cross(corners[:, :, 1] - corners[:, :, 0], corners[:, :, 2] - corners[:, :, 0])
    normals = {name: areas[:, mesh.regions[name]].sum(axis=1) for name in faces}
    unit = {name: normal / np.linalg.norm(normal, axis=1, keepdims=True) for name, normal in normals.items()}
    cosines = np.array([(unit[first] * unit[second]).sum(axis=1) for first, second in folds])
    return results, np.arccos(cosines.clip(-1, 1)).T


def main() -> None:
    results, angles = popped()
    print(results.summary())
    for share in (0.25, 0.5, 0.75, 1.0):
        found, known = np.degrees(angles[np.argmin(np.abs(results.lam - share))]), np.degrees(CLOSED) * share
        print(f"folds at {share:.0%}: {found.min():.1f} to {found.max():.1f} degrees, theory {known:.1f}")
    draw(results)


def draw(results: kg.Results) -> None:
    """Flat, on the way, and closed."""
    from matplotlib import pyplot as plt
    from matplotlib.colors import ListedColormap

    hinges = np.concatenate([results.mesh.regions[name] for name in results.mesh.regions if " " in name])
    color = np.isin(np.arange(len(results.mesh.triangles)), hinges).astype(float)
    colors = ListedColormap(["#d9c9a8", "#c8502f"])
    figure = plt.figure(figsize=(12, 3.6), layout="constrained")
    for place, share in enumerate((0.0, 0.5, 0.75, 1.0)):
        ax = figure.add_subplot(1, 4, place + 1, projection="3d")
        step = int(np.argmin(np.abs(results.lam - share)))
        results.plot(step, ax=ax, view=(28, -125), color=color, cmap=colors, colorbar=False)
        ax.set_axis_off()
        ax.set_title(f"{share:.0%}")
    figure.savefig("folding_box.png", dpi=120)


if __name__ == "__main__":
    main()
