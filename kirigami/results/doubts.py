"""What no number of a run says of itself, told once in words: where a sheet is beyond what the model knows of it.

All such judgements stand here; :meth:`kirigami.Results.summary` and the report tell them. What a mesh is too coarse for
is warned of where it is made (:mod:`kirigami.geometry.sizing`).
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from kirigami.elements.mesh_bias import MeshBias
from kirigami.errors import AnalysisError
from kirigami.post.shape import principal_values
from kirigami.primitives.kernel import Array
from kirigami.results.crossing import words_on_crossings
from kirigami.results.fracture import tips
from kirigami.results.recovery import BENDING, MEMBRANE, Recovery
from kirigami.results.results import Results
from kirigami.results.scale import scale_of
from kirigami.results.yielding import yield_words
from kirigami.words import percent

if TYPE_CHECKING:
    from kirigami.geometry.mesh import TriMesh
    from kirigami.primitives.material import SheetMaterial

THICK = 0.2  # thickness over the width of a ligament beyond which shear bends it as well: 1 to 2 % at 0.2
ELASTIC = 0.05  # strain beyond which hardly any sheet is linear
SHARE = 0.01  # of the area of the sheet that must be strained so much
FREE = 0.1  # stiffness lost at free edges that is worth a word
BARS = ("paper", "plate", "calibration")  # rungs that lose stiffness there


def doubts(results: Results) -> list[str]:
    """Sentences on what is to be doubted in results, none where nothing is; of a model without a mesh only on yield.

    Examples
    --------
    >>> from kirigami.results.doubts import doubts
    >>> import kirigami as kg, shapely
    >>> slit = shapely.LineString([(0.1, 0.5), (0.9, 0.5)])
    >>> sheet = kg.Sheet(shapely.box(0, 0, 1, 1), slit, thickness=0.05, material=kg.Material(1e6))
    >>> m = kg.Model.from_mesh(sheet.mesh(nodes=300), stiffness="shell")
    >>> top = m.select(boundary="top")
    >>> held = m.add(kg.Fix(m.nodes, "z"), kg.Fix(m.select(boundary="bottom"), "xy"), kg.Prescribe(top, x=0, y=0.01))
    >>> print(*doubts(kg.LinearStatic(m).run()), sep="\\n")
    the narrowest ligament is 0.1 wide, 2 times the thickness: thin-sheet theory leaves out its shear
    the largest strain, at a tip of a slit, is the mesh's and grows with every finer one; energy_release(cut) converges
    """
    mesh = results.mesh
    if mesh is None:
        return yield_words(results)
    told = words_on_crossings(results) + _ligaments(results, mesh) + _free_edges(results, mesh) + yield_words(results)
    constants = results.sheet_constants
    if len(results) and constants is not None and all(_only_linear(m) for m in constants.materials):
        told += _strain(results, mesh)
    if any(tips(mesh, cut) for cut in range(len(mesh.cuts))):
        told.append(
            "the largest strain, at a tip of a slit, is the mesh's and grows with every finer one; energy_release(cut) "
            "converges"
        )
    return told


def worth(results: Results) -> list[str]:
    """The error bar of a sheet in words, where it has one, and what is to be doubted."""
    if not len(results):
        return []
    told: list[str] = []
    if results.mesh is None:
        return doubts(results)
    try:
        told.append(str(results.error))
    except AnalysisError as error:  # no estimate of what is no sheet, or moves
        if results.sheet_constants is not None and not results.moves:
            told.append(str(error).partition("\n")[0])
    return told + doubts(results)


def _only_linear(material: SheetMaterial) -> bool:
    """Whether nothing else than this law knows where the material ends to be linear."""
    return not material.hyperelastic and material.yield_stress is None


def _ligaments(results: Results, mesh: TriMesh) -> list[str]:
    sizing, thickness = mesh.sizing, results.thickness
    if sizing is None or not sizing.ligaments:
        return []
    told, scale = [], scale_of(results)
    if sizing.coarse:
        told.append(
            f"the worst ligament, {scale.show(sizing.width, 'length', 3)} wide at {scale.place(sizing.place)}, has "
            f"{sizing.across} across"
        )
    thickest = 0.0 if thickness is None else float(np.max(thickness))
    if thickest > THICK * sizing.narrowest:
        told.append(
            f"the narrowest ligament is {scale.show(sizing.narrowest, 'length', 3)} wide, "
            f"{sizing.narrowest / thickest:.2g} times the thickness: thin-sheet theory leaves out its shear"
        )
    return told


def _free_edges(results: Results, mesh: TriMesh) -> list[str]:
    constants = results.sheet_constants
    if constants is None or constants.rung not in BARS:
        return []
    free = MeshBias(mesh).free_stretching
    if free is None or free[0] >= 1 - FREE:
        return []
    return [
        f"bars lose stiffness at the free edges of this mesh: pulled with its edges free, it represents {free[0]:.2f} "
        f"to {free[1]:.2f} times the sheet's, by direction; stiffness='facet' and stiffness='shell' lose none"
    ]


def _strain(results: Results, mesh: TriMesh) -> list[str]:
    """Whether more than a small share of the sheet is strained beyond what is elastic, at the last step."""
    recovery = Recovery(results, mesh)
    step = results[-1]
    fields = recovery.fields(step, recovery.state(step)).mean(axis=1)
    assert results.sheet_constants is not None
    half = 0.5 * results.sheet_constants.thickness_of_facets(len(mesh.triangles))[:, None]
    largest = np.max([_principal(fields[:, MEMBRANE] + z * fields[:, BENDING]) for z in (-half, half)], axis=0)
    order = np.argsort(largest)
    below = np.cumsum(recovery.area[order])
    reached = float(largest[order][np.searchsorted(below, (1 - SHARE) * below[-1])])
    if reached <= ELASTIC:
        return []
    return [
        f"{100 * SHARE:g} % of the sheet is strained by more than {percent(reached)} at the last step: hardly any "
        "material is linear there, as this law is"
    ]


def _principal(strain: Array) -> Array:
    """Largest size of the principal strains (m,) of strains (m, 3)."""
    return np.asarray(np.abs(principal_values(strain[:, 0], strain[:, 1], 0.5 * strain[:, 2])).max(axis=1))
