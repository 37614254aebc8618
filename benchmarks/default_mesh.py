"""The mesh that a sheet chooses for itself, judged by the stiffness of two slit sheets on every rung.

    python benchmarks/default_mesh.py             # the table: stiffness over its limit, seconds
    python benchmarks/default_mesh.py --limit     # the limits anew; needs scikit-fem, a development tool only

The limits are those of quadratic plane-stress triangles of scikit-fem on ever finer meshes graded to the tips of the
slits, extrapolated in one over the nodes by the last two. Stored: scikit-fem 12.0.2 with 22,813 and 48,107 nodes for
the sheet with 52 slits, 12,078 and 23,693 for the cracked plate.
"""

from __future__ import annotations

import argparse
import time
import warnings
from typing import Any

import numpy as np
import shapely

import kirigami as kg

MM = 1e-3
MATERIAL = kg.Material(E=4e9, nu=0.38)
SLITS = kg.cuts.parallel_slits(columns=6, rows=8, width=100 * MM, height=24 * MM, length=12 * MM, margin=18 * MM)
CRACK = [[(25 * MM, 100 * MM), (75 * MM, 100 * MM)]]
SLIT_SHEET = kg.Sheet(shapely.box(0, 0, 100 * MM, 60 * MM), SLITS, 0.125 * MM, MATERIAL)
CRACKED = kg.Sheet(shapely.box(0, 0, 100 * MM, 200 * MM), CRACK, 0.125 * MM, MATERIAL)
# With the limit of their stiffness [kN/m], and the budgets of the two last meshes it is taken from.
SHEETS = {"52 slits": (SLIT_SHEET, 52.28, (24000, 48000)), "centre crack": (CRACKED, 205.38, (12000, 24000))}
RUNGS = ("plate", "facet", "shell")


def stiffness(mesh: kg.TriMesh, rung: str) -> float:
    """Force over displacement [kN/m] of the upper edge, which is pulled while neither edge contracts."""
    model = kg.Model.from_mesh(mesh, stiffness=rung)
    bottom, top = model.select(boundary="bottom"), model.select(boundary="top")
    model.add(kg.Fix(bottom), kg.Fix(top, "xz"), kg.Prescribe(top, y=1e-6))
    return float(kg.LinearStatic(model).run().reaction(top, "y")[-1]) / 1e-6 / 1e3


def quadratic(mesh: kg.TriMesh) -> float:
    """The same [kN/m] with quadratic elements of scikit-fem."""
    from scipy.sparse.linalg import splu
    from skfem import Basis, ElementTriP2, ElementVector, MeshTri
    from skfem.models.elasticity import linear_elasticity

    basis = Basis(
        MeshTri(np.ascontiguousarray(mesh.nodes.T[:2]), np.ascontiguousarray(mesh.triangles.T)),
        ElementVector(ElementTriP2()),
    )
    E, nu, thickness = MATERIAL.E, MATERIAL.nu, mesh.thickness
    matrix = (thickness * linear_elasticity(E * nu / (1 - nu**2), E / (2 * (1 + nu))).assemble(basis)).tocsr()
    height = basis.doflocs[1]
    low, high = (np.abs(height - end) < 1e-9 for end in (height.min(), height.max()))
    along = np.zeros(len(height), bool)
    along[np.concatenate([basis.nodal_dofs[1], basis.facet_dofs[1]])] = True
    u = np.where(high & along, 1.0, 0.0)
    free = np.flatnonzero(~(low | high))
    solver: Any = splu(matrix[free][:, free].tocsc(), permc_spec="MMD_AT_PLUS_A", options={"SymmetricMode": True})
    u[free] = solver.solve(-(matrix @ u)[free])
    return float(u @ (matrix @ u)) / 1e3


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--limit", action="store_true", help="compute the limits by scikit-fem")
    parser.add_argument("--nodes", type=int, nargs="+", default=[1500, 4000], help="budgets (default: %(default)s)")
    options = parser.parse_args()
    warnings.simplefilter("ignore", kg.KirigamiWarning)
    for name, (sheet, limit, budgets) in SHEETS.items():
        if options.limit:
            meshes = [sheet.mesh(nodes=nodes) for nodes in budgets]
            first, second = (quadratic(mesh) for mesh in meshes)
            one, other = (1 / len(mesh.nodes) for mesh in meshes)
            limit = second - (first - second) * other / (one - other)
            print(f"{name}: {first:.3f}, {second:.3f}, limit {limit:.2f} kN/m", flush=True)
            continue
        for nodes in options.nodes:
            begin = time.process_time()
            mesh = sheet.mesh(nodes=nodes)
            print(f"{name}, {time.process_time() - begin:.1f} CPU s for the mesh: {mesh.sizing}")
            for rung in RUNGS:
                found = stiffness(mesh, rung)
                print(f"  {rung:<6} {found:8.2f} kN/m  {100 * (found / limit - 1):+5.1f} %", flush=True)


if __name__ == "__main__":
    main()
