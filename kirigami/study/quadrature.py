"""Seven points of a triangle that integrate polynomials of degree five (Radon, 1948)."""

import numpy as np

NEAR, FAR = (6 + np.sqrt(15.0)) / 21, (6 - np.sqrt(15.0)) / 21
# Shares of the corners in each point (7, 3), and weights (7,), which sum to one.
POINTS = np.array([[1 / 3] * 3, *(np.roll([a, a, 1 - 2 * a], k) for a in (NEAR, FAR) for k in range(3))])
WEIGHTS = np.array([9 / 40, *[(155 + np.sqrt(15.0)) / 1200] * 3, *[(155 - np.sqrt(15.0)) / 1200] * 3])
