"""Power series of 40 digits: values, derivatives, first zeros; sine and cosine, and the forcing period.

Arithmetic: `decimal` of the standard library. A zero is approached by steps that cannot pass it, since the second
derivative of a series is bounded by its terms.
"""

from __future__ import annotations

from collections.abc import Sequence
from decimal import Context, Decimal, localcontext

DIGITS = 40
PI = Decimal("3.14159265358979323846264338327950288419716939937510582097494")
ZERO, ONE, TWO = Decimal(0), Decimal(1), Decimal(2)
# Time tolerance of a zero, relative to the shortest time scale: a few digits above rounding.
TIME_TOLERANCE = Decimal("1e-36")

Series = list[Decimal]
# Value and slope now, and frequency, of a sine.
Wave = tuple[Decimal, Decimal, Decimal]


def period_of(nu: float) -> Decimal:
    """Return the forcing period 2 pi / nu, with nu exactly the given double."""
    with localcontext(Context(prec=DIGITS)):
        return TWO * PI / Decimal(nu)


def value_at(series: Sequence[Decimal], t: Decimal) -> Decimal:
    """Return the value of a power series at t."""
    total = ZERO
    for coefficient in reversed(series):
        total = total * t + coefficient
    return total


def derivative(series: Series) -> Series:
    """Return the derivative of a power series."""
    return [n * coefficient for n, coefficient in enumerate(series)][1:]


def sine_series(phase: Decimal) -> tuple[Decimal, Decimal]:
    """Return sine and cosine of a phase, from their series."""
    phase = phase.remainder_near(TWO * PI)
    sine, cosine, term, n = ZERO, ZERO, ONE, 0
    while abs(term) > Decimal(10) ** (-DIGITS - 5) or n < 4:
        sign = -ONE if n % 4 > 1 else ONE
        sine, cosine = (sine + sign * term, cosine) if n % 2 else (sine, cosine + sign * term)
        n += 1
        term = term * phase / n
    return sine, cosine


def first_zero(gap: Series, span: Decimal, reach: Decimal) -> Decimal | None:
    """Return the first time in (0, span] at which a series, positive at first, falls through zero.

    reach : the shortest time scale
    """
    rate, second = derivative(gap), ZERO
    for n in range(len(gap) - 1, 1, -1):
        second = second * span + n * (n - 1) * abs(gap[n])
    t = ZERO
    while t <= span:
        height, fall = value_at(gap, t), -value_at(rate, t)
        if height <= 0 and t > 0:
            return t
        # the series lies above a parabola of the largest curvature, which has no zero before `step`
        root = (fall * fall + TWO * second * height).sqrt() if height > 0 else abs(fall)
        if fall > 0:
            step = TWO * height / (fall + root)
        elif second:
            step = (root - fall) / second
        else:
            step = span
        if step <= TIME_TOLERANCE * reach + t * TIME_TOLERANCE:
            curvature = value_at(derivative(rate), t)
            if fall > 0 and fall * fall >= TWO * curvature * height:
                return t + step
            # grazing: continue beyond the minimum
            step = (
                max(TWO * fall / curvature if curvature > 0 else step, TIME_TOLERANCE * reach) * TWO
            )
        t += step
    return None


def series_of_waves(waves: Sequence[Wave], reach: Decimal) -> Series:
    """Return the series of a sum of sines about the current time, accurate up to `reach`."""
    total: Series = []
    for value, slope, nu in waves:
        series, n, power = [value, slope], 0, ONE
        while n < 12 or (abs(series[-1]) + abs(series[-2])) * power > Decimal(10) ** -DIGITS:
            series.append(-nu * nu * series[n] / ((n + 1) * (n + 2)))
            n, power = n + 1, power * reach
        total += [ZERO] * (len(series) - len(total))
        for n, c in enumerate(series):
            total[n] += c
    return total


def waves_after(waves: Sequence[Wave], span: Decimal) -> list[Wave]:
    """Return sines a time later."""
    later = []
    for value, slope, nu in waves:
        sine, cosine = sine_series(nu * span)
        later.append((value * cosine + slope / nu * sine, slope * cosine - nu * value * sine, nu))
    return later
