"""A sheet pulled in its plane by scikit-fem, for benchmarks/peers.py: nothing of this package is imported.

    python benchmarks/peers_plane.py sheet.npz P1
"""

from __future__ import annotations

import sys

import numpy as np
import skfem
from skfem.helpers import ddot, sym_grad, trace

ELEMENTS = {"P1": skfem.ElementTriP1, "P2": skfem.ElementTriP2}


def force(path: str, element: str) -> float:
    """Force that moves the upper edge by `pull`, both edges held, small displacements and plane stress."""
    with np.load(path) as file:
        points, triangles, E, nu, t, pull = (file[name] for name in ("points", "triangles", "E", "nu", "t", "pull"))
    mesh = skfem.MeshTri(np.ascontiguousarray(points.T), np.ascontiguousarray(triangles.T))
    basis = skfem.Basis(mesh, skfem.ElementVector(ELEMENTS[element]()))

    @skfem.BilinearForm
    def work(u, v, w):  # type: ignore[no-untyped-def]
        strain, other = sym_grad(u), sym_grad(v)
        return E * t / (1 + nu) * (ddot(strain, other) + nu / (1 - nu) * trace(strain) * trace(other))

    matrix = work.assemble(basis)
    y = basis.doflocs[1]
    low, high = y.min(), y.max()
    held, moved = y < low + 1e-9 * (high - low), y > high - 1e-9 * (high - low)
    upward = np.zeros(basis.N, bool)
    upward[basis.nodal_dofs[1]] = True
    if element == "P2":
        upward[basis.facet_dofs[1]] = True
    u = np.zeros(basis.N)
    u[moved & upward] = pull
    u = skfem.solve(*skfem.condense(matrix, x=u, D=np.flatnonzero(held | moved)))
    return float((matrix @ u)[moved & upward].sum())


if __name__ == "__main__":
    print("FORCE", force(*sys.argv[1:3]))
