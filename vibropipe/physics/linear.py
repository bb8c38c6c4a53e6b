"""The exciter without impacts: the steady state of eq. (5) in closed form, and certificates that no impact occurs."""

from __future__ import annotations

import math

from vibropipe.compiler import jit
from vibropipe.physics.contact import support_position
from vibropipe.physics.load import forcing_period, has_second
from vibropipe.physics.load_harmonics import force_amplitude, second_amplitude
from vibropipe.physics.quotient import divide
from vibropipe.physics.turns import sincos_turns

# Squares in this range neither overflow nor lose digits to underflow; their root takes a third of the time of `hypot`.
MIN_SQUARE, MAX_SQUARE = 1e-280, 1e280
# Largest argument of `sincos_turns`, in turns.
MAX_TURNS = 2.0**30
# Largest number of forcing periods, or of free vibrations, in which an undamped motion is sought to repeat, and of the
# other, that where one of the first suffices, and largest rounding of their ratio with which it is known to be whole.
MAX_COMMENSURABLE, MAX_MULTIPLE, MAX_WHOLE, MAX_DOUBT = 10_000, 2.0**20, 2.0**30, 1e-4
# Relative rounding of a frequency with 15 digits, as spreadsheets write it: 1/7 is 0.142857142857143.
FREQUENCY_ROUNDING = 2.0**-47


@jit
def _length(x, y):
    """Return sqrt(x^2 + y^2)."""
    square = x * x + y * y
    if MIN_SQUARE < square < MAX_SQUARE:
        return math.sqrt(square)
    return math.hypot(x, y)


@jit
def linear_amplitude(p) -> complex:
    """Return the complex amplitude of the steady motion of eq. (5) without supports.

    Returns X = -i f/2 / (1 - nu^2 + i h nu) of x = 2 Re(X exp(i nu tau)); infinite at resonance without damping.
    """
    if p.f == 0.0:
        return complex(0.0, 0.0)
    d = complex((1.0 - p.nu) * (1.0 + p.nu), p.h * p.nu)
    square = d.real * d.real + d.imag * d.imag
    if MIN_SQUARE < square < MAX_SQUARE:
        share = force_amplitude(p).imag / square
        return complex(share * d.imag, share * d.real)
    if d == 0.0:
        return complex(math.inf, 0.0)
    return divide(force_amplitude(p), d)


@jit
def second_linear_amplitude(p) -> complex:
    """Return the complex amplitude X of the part 2 Re(X exp(2 i nu tau)) of the steady motion."""
    if not has_second(p):
        return complex(0.0, 0.0)
    d = complex((1.0 - 2.0 * p.nu) * (1.0 + 2.0 * p.nu), p.h * 2.0 * p.nu)
    if d == 0.0:
        return complex(math.inf, 0.0)
    return divide(second_amplitude(p), d)


@jit
def steady_at(p, turn):
    """Return (x, x') of the steady motion at the phase `turn`, in turns."""
    x, v = state_at_phase(p, linear_amplitude(p), turn)
    if has_second(p):
        x2, v2 = state_at_phase(p, second_linear_amplitude(p), 2.0 * turn)
        x, v = x + x2, v + 2.0 * v2
    return x, v


@jit
def state_at_phase(p, amplitude, turn):
    """Return (x, x') of the steady motion with a complex amplitude, at the phase `turn` in turns."""
    s, c = sincos_turns(turn)
    at = 2.0 * amplitude * complex(c, s)
    return at.real, -p.nu * at.imag


@jit
def stays_off_supports(p, x, v, turn) -> bool:
    """Return whether a motion certainly never reaches a support.

    The motion is the steady one, of amplitude 2 |X|, plus a free one z with (z^2 + z'^2)' = -2 h z'^2 <= 0: |x| never
    exceeds 2 |X| + sqrt(z0^2 + z0'^2). A factor 1 + 1e-12 covers rounding.

    x, v : start
    turn : phase of the start, in turns
    """
    amplitude = linear_amplitude(p)
    steady_x, steady_v = state_at_phase(p, amplitude, turn)
    size = 2.0 * _length(amplitude.real, amplitude.imag)
    if has_second(p):
        second = second_linear_amplitude(p)
        x2, v2 = state_at_phase(p, second, 2.0 * turn)
        steady_x, steady_v = steady_x + x2, steady_v + 2.0 * v2
        size += 2.0 * _length(second.real, second.imag)
    bound = (size + _length(x - steady_x, v - steady_v)) * (1.0 + 1e-12)
    return bound < support_position(p, 1) and bound < -support_position(p, 2)


@jit
def linear_multipliers(p):
    """Return the Floquet multipliers of the steady motion without impacts.

    Returns exp(s T) for the roots of s^2 + h s + 1 = 0, T the forcing period; the larger modulus first.
    """
    b, period = 0.5 * p.h, forcing_period(p)
    square = (1.0 - b) * (1.0 + b)
    if square > 0.0:
        turns = math.sqrt(square) / p.nu
        if not turns < MAX_TURNS:
            turns = turns % 1.0
        s, c = sincos_turns(turns)
        decay = math.exp(-b * period)
        return complex(decay * c, decay * s), complex(decay * c, -decay * s)
    root = math.sqrt(-square)
    # The slow rate b - root cancels for strong damping; the product of both rates is 1, so it is 1/(b + root).
    slow, fast = math.exp(-period / (b + root)), math.exp(-(b + root) * period)
    return complex(slow, 0.0), complex(fast, 0.0)


@jit
def linear_exponent(p):
    """Return the largest Lyapunov exponent of the motion without impacts, the largest real part of the roots."""
    b = 0.5 * p.h
    # As in `linear_multipliers`; 0 - b is not -0 without damping.
    return 0.0 - b if b <= 1.0 else -1.0 / (b + math.sqrt((b - 1.0) * (b + 1.0)))


@jit
def settles_without_impact(p, x, v) -> bool:
    """Return whether the motion from (x, v) at tau = 0 certainly settles and never reaches a support.

    False wherever h = 0, since the transient does not decay.
    """
    return p.h > 0.0 and stays_off_supports(p, x, v, 0.0)


@jit
def is_resonant(p) -> bool:
    """Return whether the motion without supports grows without bound: a force at the frequency 1, without damping."""
    if p.h > 0.0:
        return False
    return (p.f != 0.0 and p.nu == 1.0) or (p.f2 != 0.0 and 2.0 * p.nu == 1.0)


@jit
def undamped_multiple(p):
    """Return after how many forcing periods an undamped motion without supports repeats, and how often it swings in it.

    Its free part exp(i tau) swings 1/nu times in a forcing period: the motion repeats after m of them if m/nu is whole.
    It counts as whole if it is so within the rounding of a frequency that is written with 15 digits.

    Returns the least; 0 if there are none, or the motion grows without bound.
    """
    if p.h > 0.0 or is_resonant(p):
        return 0, 0
    # Of periods and swings the fewer are counted.
    rate = p.nu if p.nu >= 1.0 else 1.0 / p.nu
    for fewer in range(1, MAX_COMMENSURABLE + 1):
        product = fewer * rate
        rounding = FREQUENCY_ROUNDING * product
        if not (rounding < MAX_DOUBT and product < (MAX_WHOLE if fewer == 1 else MAX_MULTIPLE)):
            break
        more = math.floor(product + 0.5)
        if abs(product - more) <= rounding:
            return (int(more), fewer) if p.nu >= 1.0 else (fewer, int(more))
    return 0, 0
