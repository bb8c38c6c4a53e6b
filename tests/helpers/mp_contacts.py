"""Motions with one soft support in forty digits: the closed form of each piece, with events by bisection."""

from __future__ import annotations

from typing import Any

import mpmath as mp

import vibropipe as vp


def contacts_of_support_1(
    exciter: vp.Exciter, tau_end: float, x0: float = 0.0
) -> tuple[list[tuple[float, float, float]], tuple[float, float]]:
    """Return (time, velocity before, duration) of each contact with support 1 from rest at x0, and the end (x, x').

    The duration of a contact that has not ended is infinite.
    """
    with mp.workdps(60):
        return _march(exciter, mp.mpf(tau_end), mp.mpf(x0))


def _solution(exciter: vp.Exciter, start: tuple[Any, ...], contact: bool) -> Any:
    """Return x(t) and x'(t) of the piece from (t0, x0, v0)."""
    t0, x0, v0 = start
    nu, f, h, wall = mp.mpf(exciter.nu), mp.mpf(exciter.f), mp.mpf(exciter.h), mp.mpf(exciter.upper)
    k, c = (mp.mpf(exciter.k1), mp.mpf(exciter.h1)) if contact else (mp.mpf(0), mp.mpf(0))
    stiffness, damping = 1 + k, h + c
    forced = f / mp.mpc(stiffness - nu**2, damping * nu)
    mean = k * wall / stiffness
    root = mp.sqrt(mp.mpc(damping**2 - 4 * stiffness))
    rates = (-damping + root) / 2, (-damping - root) / 2

    def steady(t: Any) -> tuple[Any, Any]:
        wave = forced * mp.expj(nu * t)
        return mean + wave.imag, nu * wave.real

    dx, dv = (value - at for value, at in zip((x0, v0), steady(t0), strict=True))
    first = (dv - rates[1] * dx) / (rates[0] - rates[1])
    second = dx - first

    def state(t: Any) -> tuple[Any, Any]:
        x, v = steady(t)
        parts = [a * mp.exp(r * (t - t0)) for a, r in zip((first, second), rates, strict=True)]
        return x + (parts[0] + parts[1]).real, v + (rates[0] * parts[0] + rates[1] * parts[1]).real

    return state


def _march(exciter: vp.Exciter, end: Any, x0: Any) -> tuple[list[Any], tuple[float, float]]:
    """Return what `contacts_of_support_1` does; the support is passed at most once in a stride.

    Strides in contact begin with a part of its time scale and grow.
    """
    wall, fast = mp.mpf(exciter.upper), mp.mpf(exciter.h1) + mp.sqrt(1 + mp.mpf(exciter.k1))
    start, contact, contacts = (mp.mpf(0), x0, mp.mpf(0)), False, []
    while True:
        state = _solution(exciter, start, contact)
        sign = -1 if contact else 1
        low = start[0]
        stride = 1 / (8 * fast) if contact else mp.mpf(1) / 1024
        while True:
            high = min(low + stride, end)
            if sign * (state(high)[0] - wall) > 0 or high >= end:
                break
            low, stride = high, min(stride * mp.mpf("1.05"), mp.mpf(1) / 256)
        if not sign * (state(high)[0] - wall) > 0:
            x, v = state(end)
            if contact:
                contacts[-1] = (*contacts[-1][:2], float("inf"))
            return contacts, (float(x), float(v))
        for _ in range(150):
            middle = (low + high) / 2
            if sign * (state(middle)[0] - wall) > 0:
                high = middle
            else:
                low = middle
        x, v = state(high)
        if contact:
            contacts[-1] = (*contacts[-1][:2], float(high - start[0]))
        else:
            contacts.append((float(high), float(v), 0.0))
        start, contact = (high, wall, v), not contact
