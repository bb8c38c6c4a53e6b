"""The derivative of the free motion by the damping."""

from __future__ import annotations

import math

from vibropipe.compiler import jit


@jit
def free_flow_by_h(h, t):
    """Return the derivative of the matrix of `free_flow` by h, as (e11, e12, e21, e22).

    Notes
    -----
    With z = (1 - h^2/4) t^2, e12 = exp(-h t/2) t s(z) and e22 = exp(-h t/2) (cos(sqrt z) - h t s(z)/2),
    s(z) = sin(sqrt z)/sqrt z; near z = 0 s and its derivative are summed from their series.
    """
    b = 0.5 * h
    z = (1.0 - b) * (1.0 + b) * t * t
    if z < -1.0:
        root = math.sqrt((b - 1.0) * (b + 1.0))
        slow, fast = -1.0 / (b + root), -(b + root)
        slow_h, fast_h = -slow / (2.0 * root), fast / (2.0 * root)
        e_slow, e_fast = math.exp(slow * t), math.exp(fast * t)
        e12 = 0.5 * (e_slow - e_fast) / root
        e12_h = 0.5 * (t * (slow_h * e_slow - fast_h * e_fast) - b * e12 / root) / root
        e22 = 0.5 * (slow * e_slow - fast * e_fast) / root
        e22_h = (
            0.5
            * (
                slow_h * (1.0 + slow * t) * e_slow
                - fast_h * (1.0 + fast * t) * e_fast
                - b * e22 / root
            )
            / root
        )
    else:
        if z > 1.0:
            angle = math.sqrt(z)
            even, odd = math.cos(angle), math.sin(angle) / angle
            odd_z = 0.5 * (even - odd) / z
        else:
            even, odd, odd_z, term = 1.0, 1.0, 0.0, 1.0
            for n in range(1, 12):
                odd_z -= term * n / ((2 * n - 1) * (2 * n) * (2 * n + 1))
                term *= -z / ((2 * n - 1) * (2 * n))
                even += term
                odd += term / (2 * n + 1)
        decay, z_h = math.exp(-b * t), -b * t * t
        e12_h = decay * t * (odd_z * z_h - 0.5 * t * odd)
        e22_h = decay * (
            -0.5 * odd * z_h - 0.5 * t * odd - b * t * odd_z * z_h - 0.5 * t * (even - b * t * odd)
        )
        e12 = decay * t * odd
    return e22_h + e12 + h * e12_h, e12_h, -e12_h, e22_h
