"""The units in which pictures, pages and reports tell results."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from kirigami.scale import Scale

if TYPE_CHECKING:
    from kirigami.results.results import Results


def scale_of(results: Results) -> Scale:
    """One for all that is told of a sheet, by its size at rest; without units where these are not known.

    Examples
    --------
    >>> from kirigami.results.scale import scale_of
    >>> import kirigami as kg
    >>> m = kg.Model(dim=2)
    >>> a, b = m.add(kg.Node(0, 0), kg.Node(0.2, 0))
    >>> objects = m.add(kg.Bar(a, b, EA=10.0), kg.Fix(a), kg.Fix(b, "y"), kg.NodalLoad(b, (1, 0)))
    >>> res = kg.LinearStatic(m).run()
    >>> scale_of(res).show(0.01, "length")
    '0.01'
    >>> res.units = "SI"
    >>> scale_of(res).show(0.01, "length")
    '10 mm'
    """
    return Scale.of(float(np.ptp(results.rest, axis=0).max())) if results.units else Scale()
