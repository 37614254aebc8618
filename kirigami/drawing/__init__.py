"""Drawings in and out: DXF, SVG, GeoJSON, FOLD."""
