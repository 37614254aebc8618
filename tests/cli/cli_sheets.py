"""A drawing and the words for it on the command line."""

from __future__ import annotations

from pathlib import Path

DRAWINGS = Path(__file__).parents[1] / "data" / "drawings"
PLATE = str(DRAWINGS / "inkscape_layers_mm.svg")  # 120 x 80 mm, three slits and a hole
SHEET = ["--thickness", "0.1mm", "--E", "3.5GPa", "--strain", "0.2%", "--max-edge", "15mm", "--accuracy", "draft"]
