"""Friction of a sheet whose cut edges stand out: an empirical law over the height they stand out by.

    mu = mu0 + K_f h rho S_f

with the pop-out height h [length], the number of cuts per area rho [1 / length^2] and the share S_f of the footprint
that engages the ground (no unit). K_f then has the unit of length, the inverse of that of h rho S_f. It is a constant
of the ground that only an experiment gives: without one, ratios between patterns mean something, mu itself does not.
(Khan et al., Appl. Sci. 15, 7897 (2025).)
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kirigami.errors import ModelError
from kirigami.primitives.checks import require_array


def friction_coefficient(
    height: ArrayLike, density: ArrayLike, surface_factor: ArrayLike, *, base: float, engagement: float
) -> NDArray[np.float64]:
    """Coefficient of friction mu0 + K_f h rho S_f.

    Parameters
    ----------
    height : array_like
        Pop-out height h of the cuts [length].
    density : array_like
        Number of cuts per area, rho [1 / length^2].
    surface_factor : array_like
        Share of the footprint that engages the ground, S_f (no unit). The three broadcast together.
    base : float
        Coefficient mu0 of the flat sheet.
    engagement : float
        Constant K_f of the ground [length].

    Returns
    -------
    ndarray
        Coefficient of friction, in the shape of the arguments together.

    Raises
    ------
    ModelError
        A value that is negative or not finite, or shapes that do not fit together.

    Examples
    --------
    80 cuts on 51 x 140 mm that stand out by 1 mm, with a tenth of the area engaged:

    >>> from kirigami.post.friction import friction_coefficient
    >>> float(round(friction_coefficient(1e-3, 80 / (0.051 * 0.140), 0.1, base=0.2, engagement=0.5)[()], 4))
    0.7602
    """
    named = {"height": height, "density": density, "surface_factor": surface_factor}
    values = {}
    for name, value in {**named, "base": base, "engagement": engagement}.items():
        single = ((),) if name in ("base", "engagement") else ()
        values[name] = require_array(value, *single, name=name, owner="friction_coefficient")
        if (values[name] < 0).any():
            raise ModelError(f"friction_coefficient: {name} must not be negative")
    try:
        h, rho, share = np.broadcast_arrays(values["height"], values["density"], values["surface_factor"])
    except ValueError as error:
        raise ModelError(f"friction_coefficient: height, density and surface factor do not fit: {error}") from None
    mu: NDArray[np.float64] = values["base"] + values["engagement"] * h * rho * share
    return mu
