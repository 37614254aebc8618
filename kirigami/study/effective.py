"""Effective properties of a mesh: the elastic constants that this very mesh and these elements represent.

The sheet is laid flat and every boundary node is given a uniform strain, or a quadratic deflection; the nodes inside
relax. Energy per area is then that of an elastic plate, and its matrix is compared with the material's (Hill, 1963, on
homogenisation under affine boundary displacements; it bounds the stiffness from above, and tightly where the mesh has
many nodes inside). Cuts and holes are boundary, so they do not count as softness of the mesh.
"""

from __future__ import annotations

import math
import warnings
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from kirigami.elements.mesh_bias import free_compliance, stress_along
from kirigami.elements.shell_geometry import GAUSS
from kirigami.elements.stiffness import Calibration
from kirigami.errors import KirigamiWarning, ModelError
from kirigami.geometry.topology import pair_numbers
from kirigami.model.model import Model
from kirigami.primitives.checks import require_instance
from kirigami.primitives.kernel import Array, Configuration, Kernel, full_hessian
from kirigami.primitives.material import Material
from kirigami.system.system import System

if TYPE_CHECKING:
    from kirigami.geometry.mesh import TriMesh

PLATES = ("facet", "shell")  # rungs whose uniform strain is exact, at free edges as well
FLAT = 1e-9  # largest height of a flat mesh over its size
DIRECTIONS = 36


@dataclass(frozen=True)
class EffectiveProperties:
    """What a mesh with given elements represents, beside its material.

    Attributes
    ----------
    membrane : ndarray, shape (3, 3)
        Matrix of (exx, eyy, gamma_xy) to membrane forces per length [force / length].
    bending : ndarray, shape (3, 3)
        Matrix of (kxx, kyy, 2 kxy) to moments per length [force length / length].
    thickness : float
        Of the sheet [length].
    material : Material
        What the mesh should represent.
    stiffness : str
        The rung, or the calibration.
    free : ndarray, shape (3, 3), or None
        Of bars: matrix of forces per length to mean strain where all edges are free [length / force]; facets lose
        nothing there.
    """

    membrane: Array
    bending: Array
    thickness: float
    material: Material
    stiffness: str
    free: Array | None = None

    @property
    def ratios(self) -> dict[str, tuple[float, float, float]]:
        """Mean, smallest and largest over directions of each property, over the material's value.

        "E" and "G" are moduli in the plane, "bending" is the rigidity against a cylinder, D, and "twisting" the one
        against pure twist, D (1 - nu).
        """
        E, nu, t = self.material.E, self.material.nu, self.thickness
        rigidity = E * t**3 / (12 * (1 - nu**2))
        angles = np.arange(DIRECTIONS) * math.pi / DIRECTIONS
        turned = [(_turned(self.membrane, angle), _turned(self.bending, angle)) for angle in angles]
        values = {
            "E": [1 / np.linalg.inv(membrane)[0, 0] / (E * t) for membrane, _ in turned],
            "G": [1 / np.linalg.inv(membrane)[2, 2] / (E * t / (2 * (1 + nu))) for membrane, _ in turned],
            "bending": [bending[0, 0] / rigidity for _, bending in turned],
            "twisting": [2 * bending[2, 2] / (rigidity * (1 - nu)) for _, bending in turned],
        }
        return {name: (float(np.mean(list_)), min(list_), max(list_)) for name, list_ in values.items()}

    @property
    def free_stretching(self) -> tuple[float, float, float] | None:
        """Mean, smallest and largest modulus of bars over E in a sheet whose edges are all free, where they lose
        stiffness; None for elements that lose nothing there."""
        if self.free is None:
            return None
        pull = stress_along(np.arange(DIRECTIONS) * math.pi / DIRECTIONS)
        found = 1 / np.einsum("di,ij,dj->d", pull, self.free, pull) / (self.material.E * self.thickness)
        return float(found.mean()), float(found.min()), float(found.max())

    @property
    def nu(self) -> float:
        """Poisson's ratio in the plane, the mean over directions."""
        angles = np.arange(DIRECTIONS) * math.pi / DIRECTIONS
        compliances = [np.linalg.inv(_turned(self.membrane, angle)) for angle in angles]
        return float(np.mean([-c[0, 1] / c[0, 0] for c in compliances]))

    def off(self, tolerance: float = 0.2) -> list[str]:
        """Names of the properties that differ from the material's by more than `tolerance` in some direction."""
        return [name for name, (_, low, high) in self.ratios.items() if max(abs(low - 1), abs(high - 1)) > tolerance]

    def __str__(self) -> str:
        lines = [f"mesh with stiffness {self.stiffness!r}, over the material's value (mean, smallest to largest)"]
        lines += [
            f"  {name:9s} {mean:7.3f}   {low:.3f} to {high:.3f}" for name, (mean, low, high) in self.ratios.items()
        ]
        if self.free_stretching is not None:
            mean, low, high = self.free_stretching
            lines.append(f"  E where edges are free {mean:.3f}   {low:.3f} to {high:.3f}")
        lines.append(f"  nu {self.nu:.3f} (material {self.material.nu:.3f})")
        return "\n".join(lines)


def report(
    mesh: TriMesh,
    thickness: float | None = None,
    material: Material | None = None,
    stiffness: str | Calibration = "plate",
) -> EffectiveProperties:
    """Elastic constants that a flat mesh represents, against those of its material.

    Parameters
    ----------
    mesh : TriMesh
        Flat; cuts and holes are taken as boundary.
    thickness : float, optional
        Sheet thickness [length]; None takes the mesh's.
    material : Material, optional
        None takes the mesh's.
    stiffness : str or Calibration
        As for :meth:`Model.from_mesh`.

    Returns
    -------
    EffectiveProperties
        ``print`` it; ``ratios`` and ``off()`` hold the numbers.

    Raises
    ------
    ModelError
        The mesh is not flat, or has no facet without a free edge where bending needs one, or thickness or material
        are missing.

    Examples
    --------
    >>> import shapely
    >>> import kirigami as kg
    >>> sheet = kg.Sheet(shapely.box(0, 0, 2, 1), thickness=0.01, material=kg.Material(E=1e9, nu=0.3))
    >>> properties = kg.stiffness.report(sheet.mesh(0.2), stiffness="shell")
    >>> [round(properties.ratios[name][0], 3) for name in ("E", "G", "twisting")]
    [1.0, 1.0, 1.0]
    """
    from kirigami.geometry.mesh import TriMesh

    require_instance(mesh, TriMesh, "mesh", "stiffness.report")
    if np.ptp(mesh.nodes[:, 2]) > FLAT * mesh.size:
        raise ModelError("stiffness.report: the mesh is not flat; give it the mesh before folding or perturbing it")
    flat = TriMesh(
        mesh.nodes, mesh.triangles, thickness=mesh.thickness, material=mesh.material, regions=mesh.regions
    )
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", KirigamiWarning)  # whoever asks for the numbers is warned
        model = Model.from_mesh(flat, thickness, material, stiffness)
    constants = model.sheet_constants
    assert constants is not None
    if not isinstance(constants.material, Material) or not isinstance(constants.thickness, float):
        raise ModelError("stiffness.report compares with one isotropic material of one thickness: give it these")
    system = System(model)
    matrix = system.stiffness(constrained=False)
    membrane, bending = _fields(system, flat)
    on_edge = np.unique(flat.edges[flat.boundary_edges])
    inside = np.setdiff1d(np.arange(len(flat.nodes)), on_edge)
    _relax(matrix, membrane, _plane_motions(system, inside))
    if system.edges is None:  # where edges have no angles, a slope is held at the boundary by two rows of nodes
        beside = flat.triangles[np.isin(flat.triangles, on_edge).any(axis=1)]
        inside = np.setdiff1d(inside, beside)
    _relax(matrix, bending, _bending_motions(system, inside))
    name = stiffness if isinstance(stiffness, str) else repr(stiffness)
    scale = constants.calibration.F_s * constants.material.E * constants.thickness
    return EffectiveProperties(
        _per_area(system, flat, membrane, whole=True),
        _per_area(system, flat, bending, whole=False),
        constants.thickness,
        constants.material,
        name,
        None if constants.rung in PLATES else free_compliance(flat) / scale,
    )


def _fields(system: System, mesh: TriMesh) -> tuple[Array, Array]:
    """Displacements (rows * 3, 3) of three uniform strains and of three uniform curvatures."""
    n = len(system.rest)
    centre = mesh.nodes[:, :2].mean(axis=0)
    x, y = (mesh.nodes[:, :2] - centre).T
    zero = np.zeros_like(x)
    membrane, bending = np.zeros((n, 3, 3)), np.zeros((n, 3, 3))
    membrane[: len(x), 0] = np.column_stack([x, zero, y / 2])
    membrane[: len(x), 1] = np.column_stack([zero, y, x / 2])
    bending[: len(x), 2] = np.column_stack([x**2 / 2, y**2 / 2, x * y / 2])
    edges = system.edges
    if edges is not None:  # middles lie below the mean of their ends, and the sheet turns about its edges
        start = system.rest[edges.ends[:, 0], :2] - centre
        along = system.rest[edges.ends[:, 1], :2] - centre - start
        bending[edges.middle, 2] = -np.column_stack([along[:, 0] ** 2, along[:, 1] ** 2, along[:, 0] * along[:, 1]]) / 8
        edge, row = edges.pairs
        for point, share in enumerate(GAUSS):
            px, py = (start + share * along).T
            left = np.column_stack([-along[:, 1], along[:, 0]])  # across the edge, times its length
            slope = np.column_stack([px * left[:, 0], py * left[:, 1], (px * left[:, 1] + py * left[:, 0]) / 2])
            bending[row, point] = -slope[edge]
    return membrane.reshape(3 * n, 3), bending.reshape(3 * n, 3)


def _inner_edges(system: System) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Rows of the middles and of the angles of edges between two facets, where elements have such rows."""
    edges = system.edges
    if edges is None:
        return np.empty(0, np.int64), np.empty(0, np.int64)
    inner = np.bincount(edges.edge.ravel()) > 1
    edge, row = edges.pairs
    return edges.middle[inner], row[inner[edge]]


def _plane_motions(system: System, inside: NDArray[np.int64]) -> list[NDArray[np.int64]]:
    """Groups of displacements that move as one when nodes inside move in the plane."""
    middles, _ = _inner_edges(system)
    return [np.array([3 * row + axis]) for row in [*inside.tolist(), *middles.tolist()] for axis in (0, 1)]


def _bending_motions(system: System, inside: NDArray[np.int64]) -> list[NDArray[np.int64]]:
    """The same when the sheet bends: nodes and middles move across, and edges turn."""
    middles, turns = _inner_edges(system)
    groups = [np.array([3 * row + 2]) for row in [*inside.tolist(), *middles.tolist()]]
    return groups + [np.array([3 * row + point]) for row in turns.tolist() for point in (0, 1)]


def _relax(matrix: object, fields: Array, groups: list[NDArray[np.int64]]) -> None:
    """Let the groups of displacements move to the least energy, for each field."""
    from scipy.sparse import csc_matrix
    from scipy.sparse.linalg import splu

    if not groups:
        return
    columns = np.repeat(np.arange(len(groups)), [len(group) for group in groups])
    rows = np.concatenate(groups)
    pick = csc_matrix((np.ones(len(rows)), (rows, columns)), shape=(len(fields), len(groups)))
    inner = (pick.T @ matrix @ pick).tocsc()
    scale = abs(inner).max()
    # A node without stiffness in some direction, as in a flat row of bars, stays where it is.
    inner = inner + scale * 1e-12 * csc_matrix((np.ones(len(groups)), (range(len(groups)), range(len(groups)))))
    fields += pick @ splu(inner).solve(-(pick.T @ (matrix @ fields)))  # type: ignore[operator]


def _per_area(system: System, mesh: TriMesh, fields: Array, whole: bool) -> Array:
    """Second derivative of the energy per area by the amplitudes of the fields."""
    rest = Configuration(system.rest, np.zeros_like(system.rest))
    total, area = np.zeros((3, 3)), 0.0
    own = fields.reshape(-1, 3, 3)
    for kernel in system.kernels:
        if kernel.name not in (("bars", "facets", "shell") if whole else ("hinges", "facets", "shell")):
            continue
        share = _area_share(kernel, mesh)
        if not whole and kernel.name == "facets":
            share = np.where(kernel.conn.shape[1] == 6, share, 0.0)  # facets with a free edge are not representative
        local = own[kernel.conn]
        blocks = full_hessian(kernel, kernel.evaluate(rest, 0.0, 2))
        energy = np.einsum("mkap,mklab,mlbq->mpq", local, blocks, local)
        total += energy[share > 0].sum(axis=0)
        area += float(share.sum())
    if area == 0:
        raise ModelError("stiffness.report: the mesh has no facet without a free edge, so its bending says nothing")
    return total / area


def _area_share(kernel: Kernel, mesh: TriMesh) -> Array:
    """Area of the sheet that each member stands for."""
    if kernel.name in ("facets", "shell"):
        corners = mesh.nodes[kernel.conn[:, :3]]
        cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        return np.asarray(0.5 * np.linalg.norm(cross, axis=1))
    ends = kernel.conn if kernel.name == "bars" else kernel.conn[:, 1:3]
    areas = np.append(mesh.facet_areas, 0.0)[mesh.edge_facets].sum(axis=1) / 3
    return np.asarray(areas[pair_numbers(ends, mesh.edges, len(mesh.nodes))])


def _turned(matrix: Array, angle: float) -> Array:
    """A plane matrix for (exx, eyy, gamma_xy) in axes turned by an angle."""
    c, s = math.cos(angle), math.sin(angle)
    to_old = np.array([[c * c, s * s, -c * s], [s * s, c * c, c * s], [2 * c * s, -2 * c * s, c * c - s * s]])
    return np.asarray(to_old.T @ matrix @ to_old)
