"""Materials in plain lists and numbers, for files."""

from __future__ import annotations

from typing import Any

from kirigami.primitives.laminate import Laminate
from kirigami.primitives.material import Material, Orthotropic, SheetMaterial
from kirigami.primitives.rubber import NeoHookean


def to_words(material: SheetMaterial) -> Any:
    """A material as files keep it."""
    if isinstance(material, Material):
        elastic = [material.E, material.nu, material.density]  # as files of earlier versions have it
        if material.yield_stress is None and material.expansion is None:
            return elastic
        plastic = [material.yield_stress, material.hardening, material.kinematic]
        return {"class": "Material", "values": [*elastic, *plastic], "expansion": material.expansion}
    if isinstance(material, Orthotropic):
        values = [material.E1, material.E2, material.nu12, material.G12, material.angle, material.density]
        return {"class": "Orthotropic", "values": values, "expansion": material.expansion}
    if isinstance(material, Laminate):
        return {"class": "Laminate", "layers": [[to_words(layer), thickness] for layer, thickness in material.layers]}
    if isinstance(material, NeoHookean):
        return {"class": "NeoHookean", "values": [material.E, material.density], "expansion": material.expansion}
    raise NotImplementedError(f"a {type(material).__name__} does not say how to save itself")


def from_words(words: Any) -> SheetMaterial:
    """The material of :func:`to_words`."""
    if not isinstance(words, dict):
        return Material(*words)
    if words["class"] == "Material":
        return Material(*words["values"], expansion=words.get("expansion"))
    if words["class"] == "Orthotropic":
        return Orthotropic(*words["values"], expansion=words.get("expansion"))
    if words["class"] == "Laminate":
        return Laminate(tuple((from_words(layer), thickness) for layer, thickness in words["layers"]))
    if words["class"] == "NeoHookean":
        return NeoHookean(*words["values"], expansion=words["expansion"])
    raise ValueError(f"no material of this package: {words['class']}")
