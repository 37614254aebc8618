"""The in-plane stiffness of the dozen by another program: quadratic triangles of scikit-fem, refined and extrapolated.

Each sheet of benchmarks/dozen_drawings.py (the design itself, not the file that is read) is clamped in the plane at its
grips and pulled by a millimetre at small displacements, plane stress. Two triangles of six nodes share the sides of
every cut's lips only where the sheet is whole, as in the mesh of facets; that mesh is refined twice by halving all
edges, and the three stiffnesses are extrapolated by their own ratio of differences. Written: force per displacement
over E t, which has no unit, and what the last extrapolation changed. scikit-fem (BSD licence) is needed for this script
only, in an environment of its own:

    python -m venv /tmp/reference && /tmp/reference/bin/pip install scikit-fem shapely triangle
    PYTHONPATH=. /tmp/reference/bin/python benchmarks/dozen_reference.py
"""

from __future__ import annotations

import json
import sys
import warnings

import numpy as np
import skfem
from dozen_drawings import FOLDER, Design, dozen
from skfem.helpers import ddot, sym_grad, trace

from kirigami.geometry.mesh import TriMesh
from kirigami.geometry.sheet import Sheet
from kirigami.study.grips import find_grips

NU = 0.34
FIRST = 5000  # triangles of the coarsest mesh, about


def stiffness(mesh: skfem.MeshTri, strip: float) -> float:
    """Force per displacement over E t of a sheet held at its lower end and pulled at its upper one."""
    basis = skfem.Basis(mesh, skfem.ElementVector(skfem.ElementTriP2()))

    @skfem.BilinearForm
    def work(u, v, w):  # type: ignore[no-untyped-def]
        strain, other = sym_grad(u), sym_grad(v)
        return (ddot(strain, other) + NU / (1 - NU) * trace(strain) * trace(other)) / (1 + NU)

    matrix = work.assemble(basis)
    y = basis.doflocs[1]
    low, high, slack = y.min(), y.max(), 1e-9 * np.ptp(y)
    held, moved = y <= low + strip + slack, y >= high - strip - slack
    component = np.zeros(basis.N, dtype=int)
    component[basis.nodal_dofs[1]] = 1
    component[basis.facet_dofs[1]] = 1
    u = np.zeros(basis.N)
    u[moved & (component == 1)] = 1.0
    u = skfem.solve(*skfem.condense(matrix, x=u, D=np.flatnonzero(held | moved)))
    return float(u @ matrix @ u)


def refined_three_times(design: Design) -> tuple[list[float], list[int]]:
    """Stiffness and triangles of the coarse mesh, its halving, and the halving of that."""
    sheet = Sheet(design.polygon(), design.shapes())
    grips = find_grips(sheet, "y")
    mesh: TriMesh = sheet.mesh((4 * sheet.area / FIRST) ** 0.5, lines=grips.lines())
    found, counts = [], []
    halved = skfem.MeshTri(np.ascontiguousarray(mesh.nodes[:, :2].T), np.ascontiguousarray(mesh.triangles.T))
    for level in range(3):
        halved = halved.refined() if level else halved
        found.append(stiffness(halved, grips.strip))
        counts.append(halved.nelements)
    return found, counts


def main() -> None:
    """Write the table: all rows, or those named."""
    warnings.simplefilter("ignore")
    table = FOLDER / "reference.json"
    rows = {row["name"]: row for row in json.loads(table.read_text())["rows"]} if table.exists() else {}
    for design in dozen():
        if sys.argv[1:] and design.name not in sys.argv[1:]:
            continue
        found, counts = refined_three_times(design)
        first, second = found[0] - found[1], found[1] - found[2]
        ratio = first / second
        limit = found[2] - second / (ratio - 1)
        rows[design.name] = {
            "name": design.name, "stiffness": float(f"{limit:.6g}"), "levels": [float(f"{k:.7g}") for k in found],
            "triangles": counts, "ratio": float(f"{ratio:.4g}"),
            "extrapolated_by": float(f"{found[2] / limit - 1:.2g}"),
        }  # fmt: skip
        print(rows[design.name], flush=True)
        content = {
            "what": "in-plane stiffness over E t, plane stress, nu = 0.34, grips of kirigami.stretch along y",
            "by": f"scikit-fem {skfem.__version__}, ElementTriP2; benchmarks/dozen_reference.py",
            "rows": [rows[other.name] for other in dozen() if other.name in rows],
        }
        table.write_text(json.dumps(content, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
