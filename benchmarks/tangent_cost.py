"""What a tangent of shell facets costs beside one of `plate` on the same mesh, per node.

    python benchmarks/tangent_cost.py [nodes]        some seconds; needs the extra "fast"

Both are assembled in turn, on one thread, and the medians of their CPU times are compared: node blocks, the matrix made
of them, and both. A shell has nodes at the middles of edges too: "a node" counts those.
"""

from __future__ import annotations

import sys
import time
from statistics import median

import numpy as np
import shapely

import kirigami as kg

TIMES = 9


def sheet(nodes: int) -> kg.TriMesh:
    """A square with rows of slits."""
    cuts = kg.cuts.parallel_slits(3, 9, 100, 84, 22, margin=8)
    return kg.Sheet(shapely.box(0, 0, 100, 100), cuts, 0.2, kg.Material(E=3.5e3)).mesh(nodes=nodes)


class Timed:
    """Tangents of a sheet on one rung, slightly out of its rest state, and the seconds they took."""

    def __init__(self, mesh: kg.TriMesh, rung: str) -> None:
        self.system = kg.System(kg.Model.from_mesh(mesh, stiffness=rung))
        self.u = np.zeros(self.system.rest.shape)
        self.u[: len(mesh.nodes)] = 1e-3 * np.random.default_rng(1).standard_normal((len(mesh.nodes), 3))
        self.nodes = len(mesh.nodes) + (len(mesh.edges) if rung == "shell" else 0)
        self.blocks: list[float] = []
        self.matrix: list[float] = []

    def once(self) -> None:
        start = time.process_time()
        blocks = self.system.stiffness_blocks(self.u, 1.0)
        between = time.process_time()
        self.system.matrix(blocks)
        self.blocks.append(between - start)
        self.matrix.append(time.process_time() - between)


def main() -> None:
    mesh = sheet(int(sys.argv[1]) if len(sys.argv) > 1 else 11_000)
    plate, shell = Timed(mesh, "plate"), Timed(mesh, "shell")
    print(f"{len(mesh.nodes)} corner nodes, {len(mesh.triangles)} facets, {shell.nodes} nodes with middles")
    for _ in range(TIMES + 1):  # the first compiles and warms up
        plate.once()
        shell.once()
    for name in ("blocks", "matrix"):
        one, other = (median(getattr(timed, name)[1:]) for timed in (plate, shell))
        print(f"{name:<8} plate {1e3 * one:6.1f} ms, shell {1e3 * other:6.1f} ms, {other / one:5.1f} times")
    ratios = [
        (sum(pair) / sum(other))
        for pair, other in zip(zip(shell.blocks[1:], shell.matrix[1:]), zip(plate.blocks[1:], plate.matrix[1:]))
    ]
    both, share = median(ratios), len(mesh.nodes) / shell.nodes
    print(f"both: {both:.1f} times a corner node, {both * share:.2f} times a node (from {min(ratios) * share:.2f} to "
          f"{max(ratios) * share:.2f})")  # fmt: skip


if __name__ == "__main__":
    main()
