"""The damping of a soft support that returns the velocity of a rigid one with a coefficient of restitution.

A contact of stiffness k and damping h, long against neither the force nor the spring of the exciter, is half a swing of
y'' + h y' + k y = 0: it reverses the velocity and leaves the share R = exp(-pi z / sqrt(1 - z^2)), z = h / (2 sqrt(k)).
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

SUPPORTS = (("R1", "k1", "h1"), ("R2", "k2", "h2"))
"""Restitution, stiffness and damping of both supports."""

# Deviation of z up to which a damping is the one that R and k give: rounding, and conversions of units.
TOLERANCE = 1e-9


def damping_ratio(R: float) -> float:
    """Return z = -ln R / sqrt(pi^2 + ln^2 R) of a coefficient of restitution from 0 to 1.

    R = 0 has its limit, z = 1: a critically damped contact, in which the mass creeps back and none of its velocity is
    left.
    """
    if R == 0.0:
        return 1.0
    loss = -math.log(R)
    return loss / math.hypot(math.pi, loss) + 0.0  # no -0.0 of R = 1


def contact_damping(R: Any, k: Any) -> Any:
    """Return h = 2 z sqrt(k) of numbers or arrays; 0 of a rigid support, k = 0."""
    if isinstance(R, float) and isinstance(k, float):
        return 2.0 * damping_ratio(R) * math.sqrt(k)
    # the same bits as for numbers: logarithms of numpy may differ from those of math in the last place
    different, where = np.unique(np.asarray(R, float), return_inverse=True)
    z = np.array([damping_ratio(float(each)) for each in different])[where].reshape(np.shape(R))
    return 2.0 * z * np.sqrt(k)


def is_contact_damping(h: Any, R: Any, k: Any) -> Any:
    """Return whether a damping, or each of an array, is the one that R and k give, but for rounding."""
    return abs(h - contact_damping(R, k)) <= 2.0 * TOLERANCE * k**0.5


def damping_derivatives(R: Any, k: Any) -> tuple[Any, Any]:
    """Return the derivatives of `contact_damping` by R and by k, both above 0.

    With L = -ln R, z = L / sqrt(pi^2 + L^2) and dz/dR = -pi^2 / (R (pi^2 + L^2)^(3/2)).
    """
    by_R = -2.0 * np.sqrt(k) * np.pi**2 / (R * np.hypot(np.pi, np.log(R)) ** 3)
    return by_R, contact_damping(R, k) / (2.0 * k)
