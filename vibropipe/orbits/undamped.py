"""Undamped motions that reach no support: the steady motion and a free vibration of the frequency 1.

They neither settle nor grow. Where both frequencies are commensurable they repeat, within rounding of their ratio.
"""

from __future__ import annotations

import math

from vibropipe.compiler import jit, jit_inline
from vibropipe.orbits.closed_form import (
    linear_amplitudes,
    solve_conservative,
    write_forces_of_flight,
    write_label,
)
from vibropipe.orbits.outputs import NO_IMPACT, write_multipliers, write_orbit_exponent
from vibropipe.physics.friction import friction_of
from vibropipe.physics.linear import (
    linear_amplitude,
    linear_multipliers,
    second_linear_amplitude,
    stays_off_supports,
    steady_at,
    undamped_multiple,
)
from vibropipe.physics.load import has_second, largest_force
from vibropipe.physics.turns import sincos_turns

# Size of a free vibration that is rounding, as a share of the motion.
FREE_ROUNDING = 2.0**-50


@jit
def repeats_after(p, x, v):
    """Return what `linear.undamped_multiple` does for the motion from (x, v): 1 and 0 without a free vibration."""
    steady_x, steady_v = steady_at(p, 0.0)
    size = abs(x) + abs(v) + abs(steady_x) + abs(steady_v)
    if p.h == 0.0 and abs(x - steady_x) + abs(v - steady_v) <= FREE_ROUNDING * size:
        return 1, 0
    return undamped_multiple(p)


@jit
def undamped_state(p, x, v, periods, swings, share):
    """Return (x, x') of an undamped motion without supports at a share of the `periods` after which it repeats.

    x, v : float
        Its section.
    periods, swings : int
        Of `repeats_after`.
    """
    if share == 0.0:
        return x, v
    steady_x, steady_v = steady_at(p, 0.0)
    dx, dv = x - steady_x, v - steady_v
    s, c = sincos_turns(share * swings % 1.0)
    steady_x, steady_v = steady_at(p, share * periods % 1.0)
    return steady_x + (c * dx + s * dv), steady_v + (c * dv - s * dx)


@jit
def sample_undamped(p, x, v, motion, poincare, row) -> None:
    """Write samples and sections of an undamped motion without supports that repeats.

    p, x, v : as for `solve_undamped`; motion, poincare, row : of `RowResults`, or without entries.
    """
    periods, swings = repeats_after(p, x, v)
    if motion.size > 0:
        for i in range(motion.shape[2]):
            share = i / motion.shape[2]
            motion[row, 0, i], motion[row, 1, i] = undamped_state(p, x, v, periods, swings, share)
    if poincare.size > 0:
        for i in range(poincare.shape[2]):
            share = (i % periods) / periods
            poincare[row, 0, i], poincare[row, 1, i] = undamped_state(
                p, x, v, periods, swings, share
            )


@jit
def solve_undamped(p, x, v, out, row) -> None:
    """Solve a row whose undamped motion reaches no support and repeats: the steady motion and a free vibration.

    Every motion beside it repeats as well: both Floquet multipliers are 1. No energy comes in or is lost.

    p : of a forced exciter without damping
    x, v : section of a motion with `repeats_after`
    out : RowResults; outputs without entries are not computed
    """
    periods, swings = repeats_after(p, x, v)
    write_label(out, row, NO_IMPACT, periods)
    out.frequency[row] = p.nu / periods
    steady_x, steady_v = steady_at(p, 0.0)
    # x = 2 Re(X exp(i tau)) of the free vibration.
    free, amplitudes = 0.5 * complex(x - steady_x, steady_v - v), out.amplitudes
    linear_amplitudes(linear_amplitude(p), amplitudes, row)
    if amplitudes.size > 0:
        if has_second(p) and amplitudes.shape[1] > 2:
            amplitudes[row, 2] = second_linear_amplitude(p)
        if periods == 1 and 0 < swings < amplitudes.shape[1]:
            amplitudes[row, swings] += free
    if out.subharmonics.size > 0 and periods > 1:
        for j in range(out.subharmonics.shape[1]):
            if j % periods > 0:
                out.subharmonics[row, j] = free if j == swings else complex(0.0, 0.0)
    if out.multipliers.size > 0:
        first, second = linear_multipliers(p)
        if swings > 0:
            first, second = complex(1.0, 0.0), complex(1.0, 0.0)
        write_multipliers(first, second, out.multipliers, row)
    write_orbit_exponent(0.0, out.exponent, row)
    if out.energy.size > 0:
        out.energy[row] = 0.0
    sample_undamped(p, x, v, out.motion, out.poincare[:0], row)
    if out.impact_velocity_max.size > 0:
        out.impact_velocity_max[row, 0], out.impact_velocity_max[row, 1] = math.nan, math.nan
    if out.impact_count.size > 0:
        out.impact_count[row] = 0


@jit_inline
def is_free(p, x, v) -> bool:
    """Return whether a motion without force or damping, but not at rest, certainly reaches no support."""
    if p.h > 0.0 or largest_force(p) != 0.0 or (x == 0.0 and v == 0.0):
        return False
    return stays_off_supports(p, x, v, 0.0)


@jit
def repeats_without_impact(p, x, v) -> bool:
    """Return whether an undamped motion certainly reaches no support, and repeats or is a free vibration."""
    if p.h > 0.0 or not stays_off_supports(p, x, v, 0.0):
        return False
    return is_free(p, x, v) or repeats_after(p, x, v)[0] > 0


@jit
def is_undamped_row(e, p, x, v, regime, m) -> bool:
    """Return whether a solved row, of that section, is one of `solve_without_contact`."""
    if p.h > 0.0 or friction_of(e, p) > 0.0 or regime != NO_IMPACT:
        return False
    return largest_force(p) == 0.0 or repeats_after(p, x, v)[0] == m


@jit
def goes_on_untouched(p, x, v, repeats_in, untouched) -> bool:
    """Return whether an undamped motion without friction repeats without a contact for ever.

    It certainly does if it has done so once, or reaches no support by its size. A free vibration repeats after 2 pi.

    x, v : its section
    repeats_in : forcing periods in which it repeats without supports; 0 if it does not
    untouched : last periods without a contact
    """
    if largest_force(p) == 0.0:
        return (untouched >= p.nu and (x != 0.0 or v != 0.0)) or is_free(p, x, v)
    return repeats_in > 0 and (untouched >= repeats_in or stays_off_supports(p, x, v, 0.0))


@jit
def solve_without_contact(e, p, x, v, out, row, first, c) -> None:
    """Solve a row whose undamped motion reaches no support, and repeats or is a free vibration.

    Arguments are those of `solve_conservative`; e : Effects.
    """
    if largest_force(p) == 0.0:
        solve_conservative(p, x, v, out, row, first, c)
    else:
        solve_undamped(p, x, v, out, row)
        write_forces_of_flight(e, p, x, v, out, row, c)
