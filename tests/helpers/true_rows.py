"""Rows of random exciters and their true quantities in long arithmetic, for the errors that rows state."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import mpmath as mp
import numpy as np
import xarray as xr
from long_orbits import DIGITS, quantities, solve_orbit
from oracles import Oracle, side_of
from random_rows import HARMONICS, solve_drawn
from textbook import Parameters

Exact = dict[str, Any]
# Largest number of impacts of an orbit that is compared: long arithmetic takes a time of its square.
MAX_IMPACTS = 40
DIGITS_OF_RESTS = 40


def draw_exciters(seed: int, n: int) -> np.ndarray:
    """Return parameters (n, 7) of random exciters, a third of them without damping."""
    rng = np.random.default_rng(seed)
    half = rng.uniform(0.5, 1.5, n)
    return np.stack(
        [
            rng.uniform(0.2, 3.0, n), rng.uniform(0.2, 2.0, n),
            np.where(rng.random(n) < 0.3, 0.0, rng.uniform(0.0, 0.5, n)), half,
            rng.uniform(-0.8, 0.8, n) * half, rng.uniform(0.2, 0.95, n), rng.uniform(0.2, 0.95, n),
        ],
        axis=1,
    )  # fmt: skip


def true_linear(p: Exact) -> dict[str, list[Any]]:
    """Return the quantities of the motion without impacts."""
    nu, h = p["nu"], p["h"]
    x = mp.mpc(0, -p["f"] / 2) / mp.mpc(1 - nu**2, h * nu)
    root = mp.sqrt(mp.mpc(h * h / 4 - 1))
    rest = [0] * (HARMONICS - 1)
    return {
        "displacement_strobe": [2 * x.real],
        "velocity_strobe": [-2 * nu * x.imag],
        "displacement_mean": [0],
        "displacement_amplitude": [2 * abs(x), *rest],
        "displacement_phase": [mp.arg(x)],
        "floquet_multiplier": [mp.exp((sign * root - h / 2) * 2 * mp.pi / nu) for sign in (1, -1)],
    }


def true_with_rests(p: Exact, row: xr.Dataset) -> dict[str, list[Any]]:
    """Return the quantities of an orbit with rests, and its impacts that are nearest to those listed.

    A release forgets what was before it, so that the second turn of the orbit is exact.
    """
    m, period = int(row.period_multiple), 2 * mp.pi / p["nu"]
    context = mp.MPContext()
    context.dps = DIGITS_OF_RESTS
    oracle = Oracle(Parameters(*(float(p[name]) for name in Parameters._fields)), context)
    oracle.bound = {1: p["delta"] + p["l"], 2: p["delta"] - p["l"]}
    x0 = min(max(mp.mpf(float(row.displacement_strobe)), oracle.bound[2]), oracle.bound[1])
    begin, end = m * period, 2 * m * period
    motion = oracle.run(end, x0, float(row.velocity_strobe))
    impacts = [hit for hit in motion.impacts if hit.tau > begin]
    found = []
    for phase, velocity in zip(row.listed_position, row.impact_velocity, strict=True):
        at = begin + mp.mpf(float(phase)) * period
        found.append(
            min(impacts, key=lambda hit: abs(hit.tau - at) + abs(1 - hit.before / float(velocity)))
        )
    speeds = [[abs(hit.before) for hit in impacts if hit.support == s] for s in (1, 2)]
    amplitudes = [
        _amplitude(p, oracle, motion, impacts, begin, end, k) for k in range(HARMONICS + 1)
    ]
    return {
        "displacement_strobe": [motion.displacement_end],
        "velocity_strobe": [motion.velocity_end],
        "impact_phase": [hit.tau / period for hit in found],
        "impact_velocity": [hit.before for hit in found],
        "impact_velocity_max": [max(each, default=mp.nan) for each in speeds],
        "displacement_mean": [amplitudes[0].real],
        "displacement_amplitude": [2 * abs(x) for x in amplitudes[1:]],
        "displacement_phase": [mp.arg(x) for x in amplitudes[1:]],
    }


def _amplitude(
    p: Exact, oracle: Any, motion: Any, impacts: Any, begin: Any, end: Any, k: int
) -> Any:
    """Return X(k nu) from the support forces between `begin` and `end`: impacts, ends of chatters, and rests."""
    rate = 1j * k * p["nu"]

    def wave(factor: Any, start: Any, stop: Any) -> Any:
        """Integrate exp(factor t)."""
        return (mp.exp(factor * stop) - mp.exp(factor * start)) / factor if factor else stop - start

    total = mp.mpc(0, -p["f"] / 2) * (end - begin) if k == 1 else mp.mpc(0)
    for hit in impacts:
        total += (hit.after - hit.before) * mp.exp(-rate * hit.tau)
    for rest in motion.rests:
        start, stop = max(rest.start, begin), min(rest.end, end)
        if stop <= start:
            continue
        if rest.start > begin:
            last = [hit for hit in impacts if hit.tau < rest.start][-1]
            r = oracle.restitution[rest.support]
            left = -side_of(rest.support) * abs(last.after) * (1 + r) / (1 - r)
            total += left * mp.exp(-rate * (last.tau + rest.start) / 2)
        total += oracle.bound[rest.support] * wave(-rate, start, stop)
        for sign in (1, -1):
            total -= sign * p["f"] / 2j * wave(sign * 1j * p["nu"] - rate, start, stop)
    return total / (end - begin) / (1 - (k * p["nu"]) ** 2 + rate * p["h"])


def orbits(parameters: np.ndarray) -> Iterator[tuple[str, Exact, xr.Dataset]]:
    """Yield the sort (linear, struck, resting), the parameters and the results of each row that is an orbit."""
    dataset = solve_drawn(parameters)
    last = np.cumsum(dataset.row_size.values)
    for n, values in enumerate(parameters):
        row = dataset.isel(row=n, impact=slice(last[n] - int(dataset.row_size[n]), last[n]))
        if int(row.period_multiple) == 0 or row.sizes["impact"] > MAX_IMPACTS:
            continue
        row["listed_position"] = row.impact_phase + row.impact_period
        held = float(row.rests_per_orbit.sum()) > 0
        sort = "linear" if row.sizes["impact"] == 0 else "resting" if held else "struck"
        if not (held and sort == "linear"):
            exact = {
                name: mp.mpf(float(v)) for name, v in zip(Parameters._fields, values, strict=True)
            }
            yield sort, exact, row


def true_quantities(sort: str, p: Exact, row: xr.Dataset) -> dict[str, list[Any]]:
    """Return the true quantities of a row under their names in datasets."""
    if sort == "linear":
        return true_linear(p)
    if sort == "resting":
        return true_with_rests(p, row)
    supports = row.impact_support.values.tolist()
    start = [*row.listed_position.values.tolist(), *row.impact_velocity.values.tolist()]
    p = {**p, "load": mp.mpf(0)}
    u, _inverse = solve_orbit(p, int(row.period_multiple), supports, start)
    return quantities(p, int(row.period_multiple), supports, u, HARMONICS)


def error_ratios(sort: str, p: Exact, row: xr.Dataset) -> dict[str, float]:
    """Return the largest true error over the stated one of each quantity of a row that states one."""
    ratios = {}
    with mp.workdps(DIGITS):
        for name, true in true_quantities(sort, p, row).items():
            # The error of an exponent is that of its average without an orbit.
            if f"{name}_error" not in row or name == "lyapunov_exponent":
                continue
            stated = row[f"{name}_error"].values.ravel()
            own = row[name].values.ravel()
            if name == "floquet_multiplier" and abs(own[0] - complex(true[0])) > abs(
                own[0] - complex(true[1])
            ):
                true = true[::-1]
            turn = {"impact_phase": 1, "displacement_phase": 2 * mp.pi}.get(name)
            worst = 0.0
            for value, exact, error in zip(own, true, stated, strict=False):
                if mp.isnan(mp.mpc(complex(value))) and mp.isnan(exact):
                    continue
                off = abs(
                    mp.mpmathify(complex(value) if np.iscomplexobj(own) else float(value)) - exact
                )
                off = abs(off - turn * mp.nint(off / turn)) if turn else off
                # A stated zero holds for what 50 digits call zero.
                with np.errstate(divide="ignore"):
                    ratio = np.float64(off) / error if off > 1e-40 else 0.0
                worst = max(worst, ratio) if ratio == ratio else np.inf
            ratios[name] = worst
    return ratios
