"""Tilings: flat panels joined at corners, ready to become planar models of bars and angle springs.

>>> import kirigami as kg
>>> lattice = kg.tilings.rotating_squares(angle=0.6).patch(2, 3)
>>> print(lattice)
Tiling of 24 panels with 38 joints
"""

from __future__ import annotations

from kirigami.lattice.tilings.families import (
    critical_angles,
    kagome,
    rotating_squares,
    rotating_triangles,
    square_rhombus,
)
from kirigami.lattice.tilings.ligaments import Neck, ligament_sheet, panels_of_sheet
from kirigami.lattice.tilings.panel import Ligament
from kirigami.lattice.tilings.polygons import from_polygons
from kirigami.lattice.tilings.tiling import Gap, Tiling

__all__ = [
    "Gap",
    "Ligament",
    "Neck",
    "Tiling",
    "critical_angles",
    "from_polygons",
    "kagome",
    "ligament_sheet",
    "panels_of_sheet",
    "rotating_squares",
    "rotating_triangles",
    "square_rhombus",
]
