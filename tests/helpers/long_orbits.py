"""Orbits of an impact sequence in long arithmetic: flights in closed form, chord iterations, quantities, differences.

It shares no formula with the package: the free motion is a sum of two exponentials, and multipliers come from
differences of the return map.
"""

from __future__ import annotations

from collections.abc import Mapping

import mpmath as mp
import numpy as np

DIGITS = 50
STEP = mp.mpf("1e-18")
DIFFERENTIATED = ("nu", "f", "h", "l", "delta", "R1", "R2", "load")
Values = dict[str, np.ndarray]


def _fly(p: Mapping[str, mp.mpf], start, end, x, v):
    """Return (x, x') at the phase `end` of a flight from (x, v) at the phase `start`, in turns."""
    nu, h = p["nu"], p["h"]
    amplitude = p["f"] / (1 - nu**2 + 1j * h * nu)
    second = p.get("f2", 0) * mp.expj(p.get("phi2", 0)) / (1 - 4 * nu**2 + 2j * h * nu)
    root = mp.sqrt(mp.mpc(h * h / 4 - 1))
    roots = (-h / 2 + root, -h / 2 - root)

    def steady(turn):
        at, twice = amplitude * mp.expjpi(2 * turn), second * mp.expjpi(4 * turn)
        return (at + twice).imag + p["load"], (1j * nu * (at + 2 * twice)).imag

    x0, v0 = steady(start)
    y, w = x - x0, v - v0
    first = (w - roots[1] * y) / (roots[0] - roots[1])
    parts = first, y - first
    t = (end - start) * 2 * mp.pi / nu
    moved = [part * mp.exp(rate * t) for part, rate in zip(parts, roots, strict=True)]
    x1, v1 = steady(end)
    return x1 + mp.re(sum(moved)), v1 + mp.re(sum(r * m for r, m in zip(roots, moved, strict=True)))


def _bound(p, support):
    return p["delta"] + (p["l"] if support == 1 else -p["l"])


def _residual(p, m, supports, u):
    """Return the residual of the sequence's equations at the times and velocities u."""
    n, rows = len(supports), []
    for i in range(n):
        j = (i + 1) % n
        end = u[j] + (m if j == 0 else 0)
        restitution = p["R1" if supports[i] == 1 else "R2"]
        x, v = _fly(p, u[i], end, _bound(p, supports[i]), -restitution * u[n + i])
        rows += [x - _bound(p, supports[j]), v - u[n + j]]
    return rows


def solve_orbit(p, m, supports, u, inverse=None):
    """Return the orbit near u in long arithmetic, and the inverse Jacobian (float) that the chord iteration uses."""
    u = [mp.mpf(value) for value in u]
    if inverse is None:
        base, columns = _residual(p, m, supports, u), []
        for k in range(len(u)):
            moved = list(u)
            moved[k] += mp.mpf("1e-15")
            change = _residual(p, m, supports, moved)
            columns.append(
                [float((b - a) * mp.mpf("1e15")) for a, b in zip(base, change, strict=True)]
            )
        inverse = np.linalg.inv(np.array(columns).T)
    for _ in range(12):
        residual = _residual(p, m, supports, u)
        size = max(abs(r) for r in residual)
        if size < mp.mpf(10) ** (6 - DIGITS):
            break
        scaled = np.array([float(r / size) for r in residual]) if size else np.zeros(len(u))
        u = [value - size * mp.mpf(step) for value, step in zip(u, inverse @ scaled, strict=True)]
    assert size < mp.mpf("1e-40"), f"no orbit in long arithmetic: residual {mp.nstr(size, 3)}"
    return u, inverse


def quantities(p, m, supports, u, harmonics):
    """Return the quantities of an orbit, under their names in datasets, as lists of numbers."""
    n, nu, period = len(supports), p["nu"], 2 * mp.pi / p["nu"]
    times, velocities = u[:n], u[n:]
    signs = [1 if support == 1 else -1 for support in supports]
    found = {"impact_phase": times, "impact_velocity": velocities}
    last = max(range(n), key=lambda i: times[i])
    restitutions = [p["R1" if support == 1 else "R2"] for support in supports]
    section = _fly(
        p, times[last], mp.mpf(m), _bound(p, supports[last]), -restitutions[last] * velocities[last]
    )
    found["displacement_strobe"], found["velocity_strobe"] = [section[0]], [section[1]]
    found["impact_velocity_max"] = [
        max((s * v for s, v in zip(signs, velocities, strict=True) if s == side), default=mp.nan)
        for side in (1, -1)
    ]
    amplitudes = []
    for k in range(harmonics + 1):
        second = mp.mpc(0, -p.get("f2", 0) / 2) * mp.expj(p.get("phi2", 0))
        force = (p["load"], mp.mpc(0, -p["f"] / 2), second, 0)[min(k, 3)]
        for t, v, r in zip(times, velocities, restitutions, strict=True):
            force -= (1 + r) * v * mp.expjpi(-2 * k * t) / (m * period)
        amplitudes.append(force / (1 - (k * nu) ** 2 + 1j * k * nu * p["h"]))
    found["displacement_mean"] = [mp.re(amplitudes[0])]
    found["displacement_amplitude"] = [2 * abs(x) for x in amplitudes[1:]]
    found["displacement_phase"] = [mp.arg(x) for x in amplitudes[1:]]
    found["velocity_amplitude"] = [2 * k * nu * abs(x) for k, x in enumerate(amplitudes[1:], 1)]
    # The mean of f sin(nu tau) and of f2 sin(2 nu tau + phi2), each times its part of x'.
    work = mp.re(amplitudes[1]) * p["f"]
    if harmonics > 1:
        work += 2 * mp.re(amplitudes[2] * mp.expj(-p.get("phi2", 0))) * p.get("f2", 0)
    found["energy_input"] = [-2 * mp.pi * work]
    found["energy_impact"] = [
        sum(
            (1 - r**2) * v**2 / 2
            for s, v, r in zip(signs, velocities, restitutions, strict=True)
            if s == side
        )
        / m
        + mp.mpf(0)
        for side in (1, -1)
    ]
    found["energy_damping"] = [found["energy_input"][0] - sum(found["energy_impact"])]
    multipliers = _multipliers(p, m, supports, u)
    found["floquet_multiplier"] = multipliers
    found["lyapunov_exponent"] = [mp.log(abs(multipliers[0])) / (m * period)]
    return found


def _multipliers(p, m, supports, u):
    """Return the multipliers of the map of (time, velocity) of the first impact, by differences of flights."""
    n, matrix, tiny = len(supports), mp.eye(2), mp.mpf("1e-20")
    for i in range(n):
        j = (i + 1) % n
        end, target = u[j] + (m if j == 0 else 0), _bound(p, supports[j])
        restitution = p["R1" if supports[i] == 1 else "R2"]

        x0 = _bound(p, supports[i])

        def image(t, v, end=end, target=target, r=restitution, x0=x0):
            at = end
            for _ in range(3):
                x, w = _fly(p, t, at, x0, -r * v)
                at -= (x - target) / w * p["nu"] / (2 * mp.pi)
            return at, _fly(p, t, at, x0, -r * v)[1]

        t, v = u[i], u[n + i]
        columns = []
        for dt, dv in ((tiny, 0), (0, tiny)):
            ahead, back = image(t + dt, v + dv), image(t - dt, v - dv)
            columns.append([(a - b) / (2 * tiny) for a, b in zip(ahead, back, strict=True)])
        matrix = mp.matrix(columns).T * matrix
    half = (matrix[0, 0] + matrix[1, 1]) / 2
    # That of the differences loses the digits of a small second multiplier.
    determinant = mp.exp(-2 * mp.pi * m * p["h"] / p["nu"])
    for support in supports:
        determinant *= p["R1" if support == 1 else "R2"] ** 2
    root = mp.sqrt(mp.mpc(half**2 - determinant))
    if root.imag == 0 and half < 0:
        root = -root
    return [half + root, determinant / (half + root)]


def _orbit_of(dataset):
    """Return parameters, m, supports and unknowns of the orbit of a steady state, and the inverse Jacobian."""
    known = (*DIFFERENTIATED, "f2", "phi2")
    exact = {n: mp.mpf(float(dataset[n]) if n in dataset.coords else 0.0) for n in known}
    m, supports = int(dataset.period_multiple), dataset.impact_support.values.tolist()
    times = dataset.impact_phase.values + dataset.impact_period.values
    start = [*times.tolist(), *dataset.impact_velocity.values.tolist()]
    return exact, m, supports, *solve_orbit(exact, m, supports, start)


def true_values(dataset, harmonics) -> Values:
    """Return the quantities of a steady state with impacts and without rests."""
    with mp.workdps(DIGITS):
        exact, m, supports, u, _inverse = _orbit_of(dataset)
        return _plain(quantities(exact, m, supports, u, harmonics))


def _plain(values) -> Values:
    return {key: np.array([complex(v) for v in numbers]) for key, numbers in values.items()}


def sensitivities(dataset, harmonics) -> tuple[Values, Values]:
    """Return the quantities of a steady state with impacts and without rests, and their derivatives by each parameter.

    Central differences in long arithmetic; the derivatives have the parameters of `dataset` along the last axis.
    """
    with mp.workdps(DIGITS):
        exact, m, supports, u, inverse = _orbit_of(dataset)
        values = quantities(exact, m, supports, u, harmonics)
        slopes: dict[str, list] = {name: [] for name in values}
        for name in (str(name) for name in dataset.parameter.values):
            ends = []
            for sign in (1, -1):
                moved = {**exact, name: exact[name] + sign * STEP}
                v, _inverse = solve_orbit(moved, m, supports, u, inverse)
                ends.append(quantities(moved, m, supports, v, harmonics))
            for key in values:
                pairs = zip(ends[0][key], ends[1][key], strict=True)
                slopes[key].append([complex((a - b) / (2 * STEP)) for a, b in pairs])
        return _plain(values), {key: np.array(columns).T for key, columns in slopes.items()}
