"""Pictures: sheets, meshes, models, deformed structures, curves and animations, drawn with matplotlib.

Every function returns the matplotlib axes it drew on (:func:`animate` the path it wrote), and draws on axes of your
own when they are given as ``ax``. matplotlib is imported when something is drawn, not before.
"""

from __future__ import annotations

from kirigami.plot.curves import plot_curve, plot_open_area
from kirigami.plot.deformed import plot_results
from kirigami.plot.gradients import plot_gradient
from kirigami.plot.measures import plot_energy_shares, plot_measure
from kirigami.plot.movie import animate
from kirigami.plot.undeformed import plot_mesh, plot_model, plot_sheet

__all__ = [
    "animate",
    "plot_curve",
    "plot_energy_shares",
    "plot_gradient",
    "plot_measure",
    "plot_mesh",
    "plot_model",
    "plot_open_area",
    "plot_results",
    "plot_sheet",
]
