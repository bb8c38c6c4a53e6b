"""The conservative exciter, eqs. (7)-(10): h = f = 0, R1 = R2 = 1, in closed form.

Between impacts the motion is an arc of x = A cos(tau); each support cuts the arc off, and the motion runs
to and fro between the two ends. Everything follows from the half period between the ends.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def backbone_velocity(delta_over_l: Array, tau_bar: Array) -> Array:
    """Velocity before impact on support 1 over l, eq. (10), of a motion of period tau_bar that strikes both
    supports; nan where such a motion does not exist."""
    d, half = np.asarray(delta_over_l, float), 0.5 * np.asarray(tau_bar, float)
    with np.errstate(all="ignore"):
        velocity = (1 - d + (1 + d) * np.cos(half)) / np.sin(half)
        # Energy: the square of the velocity at support 2 exceeds that at support 1 by 4 delta/l.
        struck = (half > 0) & (half < np.pi) & (velocity > 0) & (velocity**2 + 4 * d > 0)
        return np.where(struck, velocity, np.nan)


def arc(amplitude: Array, lower: Array, upper: Array) -> tuple[Array, Array]:
    """(start, half period) of the arc x = A cos(start + tau) from its upper to its lower end.

    amplitude: A = sqrt(x^2 + x'^2); lower, upper: positions of the supports. The angle of an end is taken
    by its sine and cosine, since the arc cosine alone is blind near a graze.
    """

    def angle(x: Array) -> Array:
        return np.arctan2(np.sqrt(np.maximum((amplitude - x) * (amplitude + x), 0.0)), x)

    top, bottom = angle(np.minimum(upper, amplitude)), angle(np.maximum(lower, -amplitude))
    return top, bottom - top


def free_harmonics(
    amplitude: Array, lower: float, upper: float, harmonics: int
) -> tuple[Array, Array]:
    """(eigenfrequency, coefficients) of free motions of the given amplitudes, shape (n,) and (n, harmonics + 1).

    x = c_0 + sum c_k cos(k w tau) with tau = 0 at the upper end: the motion is even about it. The integral
    of cos(tau + start) cos(k w tau) over half a period, with sin(z)/z taken as one function.
    """
    start, half = arc(amplitude, lower, upper)
    frequency = np.pi / half
    k = np.arange(harmonics + 1)

    def mean_of_cosine(rate: Array) -> Array:
        phase = 0.5 * rate * half[:, None]
        return np.sinc(phase / np.pi) * np.cos(phase + start[:, None])

    rate = k[None, :] * frequency[:, None]
    coefficients = amplitude[:, None] * (mean_of_cosine(1 + rate) + mean_of_cosine(1 - rate))
    coefficients[:, 0] *= 0.5
    return frequency, coefficients
