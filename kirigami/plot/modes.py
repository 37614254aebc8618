"""Pictures and films of modes, drawn as the results of a motion."""

from __future__ import annotations

import copy
import os
from pathlib import Path
from typing import Any, Protocol

import numpy as np

from kirigami.errors import AnalysisError
from kirigami.plot.deformed import plot_results
from kirigami.plot.movie import animate
from kirigami.primitives.checks import require_positive, require_whole
from kirigami.primitives.kernel import Array
from kirigami.results.results import Results
from kirigami.results.step import Step

SHARE = 0.1  # largest displacement in a picture, as a share of the size of the structure


class Mode(Protocol):
    """What is drawn of a mode: its shape (n, 3), what stands behind the nodes (h, 3), and the state it is about."""

    @property
    def shape(self) -> Array: ...
    @property
    def inner(self) -> Array: ...
    @property
    def origin(self) -> Results | None: ...


def plot_mode(mode: Mode, amplitude: float | None = None, **how: Any) -> Any:
    """Draw a mode as a deformed structure.

    Parameters
    ----------
    mode : Mode
        What to draw.
    amplitude : float, optional
        Largest displacement in the picture [length]; None takes a tenth of the size of the structure.
    **how
        As for :func:`kirigami.plot.plot_results`: ax, color, edges, view, colorbar, cmap, label. Bars are coloured by
        displacement, and sheets as ever.

    Returns
    -------
    matplotlib axes

    Raises
    ------
    AnalysisError
        The mode knows no structure, since it was made by hand.
    ModelError
        An amplitude that is not positive, and anything :func:`kirigami.plot.plot_results` refuses.

    Examples
    --------
    >>> import kirigami as kg
    >>> m = kg.Model(dim=2)
    >>> a, b, c = m.add(kg.Node(0, 0), kg.Node(1, 0), kg.Node(0, 1))
    >>> bars = m.add(kg.Bar(a, b, 1.0), kg.Bar(b, c, 1.0), kg.Bar(c, a, 1.0))
    >>> ax = kg.Eigen(m, n=4).run()[3].plot(colorbar=False)
    """
    motion = _motion(mode, amplitude, np.ones(1))
    return plot_results(motion, **_colored(motion, how))


def animate_mode(
    mode: Mode, path: str | os.PathLike[str], amplitude: float | None = None, frames: int = 24, **how: Any
) -> Path:
    """Write one swing of a mode, to and fro, as an animated GIF or an MP4 video.

    Parameters
    ----------
    mode : Mode
        What to draw.
    path : path
        File to write, ending in ``.gif`` or ``.mp4``.
    amplitude : float, optional
        Largest displacement [length]; None takes a tenth of the size of the structure.
    frames : int
        Number of pictures, at least 2.
    **how
        As for :meth:`kirigami.Results.animate`: fps, color, edges, view, dpi, cmap.

    Returns
    -------
    Path
        The file.

    Raises
    ------
    AnalysisError
        The mode knows no structure, since it was made by hand.
    ModelError
        An amplitude that is not positive, and anything :meth:`kirigami.Results.animate` refuses.
    """
    frames = require_whole(frames, "frames", "animate", least=2)
    motion = _motion(mode, amplitude, np.sin(2 * np.pi * np.arange(frames) / frames))
    return animate(motion, path, frames=frames, pause=0.0, **_colored(motion, how))


def _motion(mode: Mode, amplitude: float | None, swing: Any) -> Results:
    """Results whose steps are the state of a mode, moved along it by shares `swing` of the amplitude."""
    if mode.origin is None:
        raise AnalysisError("this mode knows no structure to draw: take one of the modes that Eigen or Buckling found")
    origin = mode.origin[0]
    if amplitude is None:
        amplitude = SHARE * float(np.linalg.norm(np.ptp(mode.origin.rest, axis=0)))
    amplitude = require_positive(amplitude, "amplitude", "Mode")
    motion = copy.copy(mode.origin)
    motion.steps = []
    for share in (amplitude * swing).tolist():
        u, inner = origin.u + share * mode.shape, origin.inner + share * mode.inner
        motion.append(Step(origin.lam, u, inner=inner, history=origin.history))
    return motion


def _colored(motion: Results, how: dict[str, Any]) -> dict[str, Any]:
    return how if motion.mesh is not None else {"color": "displacement", **how}
