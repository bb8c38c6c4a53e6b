"""The lines of a record's spectrum, the noise that it repeats without, and where its motion has settled.

Frequencies are refined by least squares of a sine and its harmonics, so that samples may be uneven and may be left out.
"""

from __future__ import annotations

from itertools import pairwise
from typing import NamedTuple

import numpy as np

# Zeros are added up to so many times the samples, so that a line is found to a fraction of its width.
PADDING = 4
# A line stands out if noise alone is as large in fewer than one of a thousand records.
CHANCE = 1e-3
# Largest number of harmonics in the least squares, and samples in a period of the highest one.
HARMONICS, SAMPLES_OF_HARMONIC = 8, 3.0
REFINEMENTS, WIDTH = 60, 1.0
# Forcing periods after which a motion may repeat, and the deviation of a normal one over its median.
MULTIPLES, NORMAL = (1, 2, 3, 4), 0.67449
# Forcing periods of a window and harmonics in it; windows are steady within so many times the usual scatter of the
# second half, so many times its largest, or this share of the record's deviation; least number of windows.
WINDOW, WINDOW_HARMONICS, SCATTERS, OF_LARGEST, LEAST_SCATTER, MIN_WINDOWS = 2, 3, 4.0, 1.5, 1e-3, 8


class Line(NamedTuple):
    """A line of a spectrum.

    nu, std : its frequency and the standard deviation of that, 0 if it is stated
    rise : time at which a trigger rises
    """

    nu: float
    std: float
    rise: float | None = None


def largest_line(tau: np.ndarray, values: np.ndarray, is_clipped: np.ndarray | None) -> Line | None:
    """Return the largest line of the first column (n, q), refined in all columns; None where none stands out."""
    kept = np.ones(values.shape, bool) if is_clipped is None else ~is_clipped
    span, n = tau[-1] - tau[0], tau.size
    even = np.linspace(tau[0], tau[-1], n)
    first = np.interp(even, tau[kept[:, 0]], values[kept[:, 0], 0])
    power = np.abs(np.fft.rfft((first - first.mean()) * np.hanning(n), PADDING * n)) ** 2
    frequency = 2 * np.pi * np.arange(power.size) / (PADDING * n) * (n - 1) / span
    # Below two periods in the record a window does not separate a line from the mean.
    power[frequency * span < 2 * 2 * np.pi * 0.75] = 0.0
    return line_at(tau, values, ~kept, float(frequency[int(power.argmax())]))


def line_at(tau: np.ndarray, values: np.ndarray, is_clipped: np.ndarray, nu: float) -> Line | None:
    """Return the line next to a frequency, within a width of the record's resolution; None where none stands out."""
    from scipy.optimize import minimize_scalar

    width = WIDTH * 2 * np.pi / (tau[-1] - tau[0])
    found = minimize_scalar(
        lambda each: _left(tau, values, is_clipped, each, _harmonics(tau, nu)),
        bounds=(max(nu - width, 0.25 * nu), nu + width), method="bounded",
        options={"xatol": 1e-12 * nu, "maxiter": REFINEMENTS},
    )  # fmt: skip
    at = float(found.x)
    if not any(
        _stands_out(tau[~clipped], column[~clipped], at)
        for column, clipped in zip(values.T, is_clipped.T, strict=True)
    ):
        return None
    return Line(at, _deviation(tau, values, is_clipped, at))


def _harmonics(tau: np.ndarray, nu: float) -> int:
    """Return the number of harmonics that the samples resolve."""
    step = float(np.median(np.diff(tau)))
    return int(np.clip(2 * np.pi / nu / step / SAMPLES_OF_HARMONIC, 1, HARMONICS))


def basis(tau: np.ndarray, nu: float, harmonics: int) -> np.ndarray:
    """Return a constant and sines and cosines (n, 1 + 2 harmonics)."""
    angle = nu * (tau - tau.mean())[:, None] * np.arange(1, harmonics + 1)
    return np.column_stack([np.ones_like(tau), np.sin(angle), np.cos(angle)])


def _left(
    tau: np.ndarray, values: np.ndarray, is_clipped: np.ndarray, nu: float, harmonics: int
) -> float:
    """Return the share of the squares of all columns that a sine and its harmonics leave."""
    total = 0.0
    for column, clipped in zip(values.T, is_clipped.T, strict=True):
        y, b = column[~clipped], basis(tau[~clipped], nu, harmonics)
        left = y - b @ np.linalg.lstsq(b, y, rcond=None)[0]
        total += float(left @ left) / max(float(((y - y.mean()) ** 2).sum()), np.finfo(float).tiny)
    return total


def _stands_out(tau: np.ndarray, y: np.ndarray, nu: float) -> bool:
    """Return whether a sine at a frequency is larger than the largest of noise [1]_.

    References
    ----------
    .. [1] J. D. Scargle, Studies in astronomical time series analysis II, Astrophysical Journal 263 (1982) 835.
    """
    left = _left(tau, y[:, None], np.zeros((y.size, 1), bool), nu, 1)
    with np.errstate(divide="ignore"):
        return bool(np.log(y.size / 2) + 0.5 * (y.size - 3) * np.log(left) < np.log(CHANCE))


def _deviation(tau: np.ndarray, values: np.ndarray, is_clipped: np.ndarray, nu: float) -> float:
    """Return the standard deviation of a frequency in the linear model of the sine and its harmonics."""
    harmonics, information = _harmonics(tau, nu), 0.0
    for column, clipped in zip(values.T, is_clipped.T, strict=True):
        t, y = tau[~clipped], column[~clipped]
        b = basis(t, nu, harmonics)
        amplitudes = np.linalg.lstsq(b, y, rcond=None)[0]
        left = y - b @ amplitudes
        order = np.arange(1, harmonics + 1)
        slope = (b[:, harmonics + 1 :] * order) @ amplitudes[1 : harmonics + 1]
        slope -= (b[:, 1 : harmonics + 1] * order) @ amplitudes[harmonics + 1 :]
        slope *= t - t.mean()
        slope -= b @ np.linalg.lstsq(b, slope, rcond=None)[0]
        variance = float(left @ left) / max(y.size - b.shape[1] - 1, 1)
        information += float(slope @ slope) / max(variance, 1e-24 * float(y @ y) / y.size)
    return float(1.0 / np.sqrt(information)) if information > 0.0 else np.inf


def line_of_trigger(tau: np.ndarray, pulse: np.ndarray) -> Line | None:
    """Return the frequency at which a trigger rises, once in each forcing period; None where it rises unevenly."""
    level = 0.5 * (pulse.min() + pulse.max())
    rises = np.flatnonzero((pulse[:-1] < level) & (pulse[1:] >= level))
    if rises.size < 3:
        return None
    share = (level - pulse[rises]) / (pulse[rises + 1] - pulse[rises])
    times = tau[rises] + share * (tau[rises + 1] - tau[rises])
    number = np.rint((times - times[0]) / np.median(np.diff(times)))
    period, start = np.polyfit(number, times, 1)
    left = times - start - period * number
    if np.abs(left).max() > 0.1 * period:
        return None
    spread = np.sqrt(
        (left**2).sum() / max(times.size - 2, 1) / ((number - number.mean()) ** 2).sum()
    )
    nu = 2 * np.pi / period
    # A stated frequency has the deviation 0, one that was found has not.
    return Line(float(nu), float(nu * max(spread / period, 1e-12)), float(start))


def folded_noise(tau: np.ndarray, y: np.ndarray, nu: float) -> float:
    """Return the standard deviation of what does not repeat, from neighbours after few forcing periods."""
    estimates = []
    for m in MULTIPLES:
        place = (tau - tau[0]) * nu / (2 * np.pi) % m
        order = np.argsort(place, kind="stable")
        u, v = place[order], y[order]
        width = np.maximum(u[2:] - u[:-2], np.finfo(float).tiny)
        share = (u[1:-1] - u[:-2]) / width
        bend = v[1:-1] - (1 - share) * v[:-2] - share * v[2:]
        size = np.sqrt(1 + share**2 + (1 - share) ** 2)
        estimates.append(float(np.median(np.abs(bend) / size)) / NORMAL)
    return max(min(estimates), 1e-9 * float(np.ptp(y)))


def steady_index(tau: np.ndarray, values: np.ndarray, is_clipped: np.ndarray, line: Line) -> int:
    """Return the sample from which the motion repeats, in the first half of a record; 0 if all of it does.

    Mean and harmonics of windows of two forcing periods are compared with those of the second half.
    """
    width = WINDOW * 2 * np.pi / line.nu
    n_windows = int((tau[-1] - tau[0]) / width)
    if n_windows < MIN_WINDOWS:
        return 0
    # Windows end with the record.
    starts = tau[-1] - width * np.arange(n_windows, 0, -1)
    edges = np.append(np.searchsorted(tau, starts), tau.size)
    columns = WINDOW_HARMONICS * 2 + 1
    parts = np.zeros((n_windows, values.shape[1] * columns))
    for n, (low, high) in enumerate(pairwise(edges.tolist())):
        for q in range(values.shape[1]):
            kept = ~is_clipped[low:high, q]
            if kept.sum() > 2 * columns:
                angle = line.nu * tau[low:high][kept, None] * np.arange(1, WINDOW_HARMONICS + 1)
                b = np.column_stack([np.ones(kept.sum()), np.sin(angle), np.cos(angle)])
                fit = np.linalg.lstsq(b, values[low:high, q][kept], rcond=None)[0]
                parts[n, q * columns : (q + 1) * columns] = fit / values[:, q].std()
    late = parts[n_windows // 2 :]
    distance = np.linalg.norm(parts - np.median(late, axis=0), axis=1)
    late = distance[n_windows // 2 :]
    limit = max(SCATTERS * float(np.median(late)), OF_LARGEST * float(late.max()), LEAST_SCATTER)
    unsteady = np.flatnonzero(distance[: n_windows // 2] > limit)
    return int(edges[unsteady[-1] + 1]) if unsteady.size else 0
