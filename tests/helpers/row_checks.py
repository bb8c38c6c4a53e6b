"""Invariants of every row of a steady-state dataset over `row`, whatever its parameters."""

from __future__ import annotations

import numpy as np
import xarray as xr

from vibropipe.orbits.window import LISTED_PERIODS
from vibropipe.words.regimes import Regime
from vibropipe.words.status import Status

EPS = np.finfo(float).eps
# Bound of the residual of an orbit's return map, relative to its size.
MAX_RESIDUAL = 1e-9


def broken_rows(rows: xr.Dataset) -> dict[str, np.ndarray]:
    """Return the indices of the rows that violate an invariant, by its name; empty if all hold.

    rows: all outputs over `row`, with the parameters as coordinates (`random_rows.solve_drawn`).
    """
    broken = label_faults(rows) | impact_faults(rows) | number_faults(rows) | motion_faults(rows)
    broken |= section_faults(rows) | subharmonic_faults(rows)
    return {name: np.flatnonzero(at) for name, at in broken.items() if at.any()}


def label_faults(rows: xr.Dataset) -> dict[str, np.ndarray]:
    """Regime, status, multiple and residual are consistent."""
    regime, status, m, residual = (
        rows[name].values for name in ("regime", "status", "period_multiple", "residual")
    )
    orbit = m > 0
    named = regime <= Regime.WITH_REST
    impacts, rests = rows["impacts_per_orbit"].values, rows["rests_per_orbit"].values
    struck, rested = impacts > 0, rests.sum(axis=1) > 0
    expected = {
        Regime.NO_IMPACT: ~struck.any(axis=1) & ~rested,
        Regime.ONE_SIDED_1: struck[:, 0] & ~struck[:, 1] & ~rested,
        Regime.ONE_SIDED_2: struck[:, 1] & ~struck[:, 0] & ~rested,
        Regime.TWO_SIDED: struck.all(axis=1) & ~rested,
        Regime.WITH_REST: rested,
    }
    contradicted = np.zeros(m.size, bool)
    for code, is_so in expected.items():
        contradicted |= (regime == code) & ~is_so
    solved = orbit | (status == Status.MAX_PERIODS)
    window = rows["window_periods"].values
    per_period = rows["impacts_per_period"].values
    expected_per_period = np.where(solved[:, None], impacts / np.maximum(m, 1)[:, None], np.nan)
    return {
        "an orbit is named so, and only an orbit": orbit != named,
        "an orbit is ok, and nothing else is": orbit != (status == Status.OK),
        "m is 0 or a number of periods": m < 0,
        "an orbit has a small residual": orbit & ~(residual < MAX_RESIDUAL),
        "the regime names the supports struck": contradicted,
        "contacts of an orbit are whole numbers": orbit
        & ((impacts != np.floor(impacts)) | (rests != np.floor(rests))).any(axis=1),
        "an unsolved row is unresolved": ~solved & (regime != Regime.UNRESOLVED),
        "an unsolved row has no contacts": ~solved & ((impacts != 0) | (rests != 0)).any(axis=1),
        "impacts per period are those of the orbit or the window": (
            ~np.isclose(per_period, expected_per_period, rtol=1e-15, atol=0, equal_nan=True)
        ).any(axis=1),
        "a motion without an orbit has a window": (window > 0) != (status == Status.MAX_PERIODS),
        "frequency is positive": ~(rows["base_frequency"].values > 0),
        "the section of a solved row is finite": solved
        != (
            np.isfinite(rows["displacement_strobe"].values)
            & np.isfinite(rows["velocity_strobe"].values)
        ),
    }


def impact_faults(rows: xr.Dataset) -> dict[str, np.ndarray]:
    """The listed impacts are those of the orbit, or of the last periods without one, in order and within its length."""
    m, size = rows["period_multiple"].values, rows["row_size"].values
    of = np.repeat(np.arange(m.size), size)
    period, phase = rows["impact_period"].values, rows["impact_phase"].values
    support, velocity = rows["impact_support"].values, rows["impact_velocity"].values

    def any_of(bad: np.ndarray) -> np.ndarray:
        return np.bincount(of[bad], minlength=m.size) > 0

    counted = np.stack([np.bincount(of[support == s], minlength=m.size) for s in (1, 2)], axis=1)
    at = period + phase
    hardest = np.zeros((m.size, 2))
    np.maximum.at(hardest, (of, support - 1), np.abs(velocity))
    largest = rows["impact_velocity_max"].values
    orbit = m > 0
    solved = orbit | (rows["status"].values == Status.MAX_PERIODS)
    length = np.where(orbit, m, np.minimum(rows["window_periods"].values, LISTED_PERIODS))
    return {
        "all impacts of an orbit are listed": orbit
        & (counted != rows["impacts_per_orbit"].values).any(axis=1),
        "an unsolved row has no impacts listed": ~solved & (size > 0),
        "impacts lie within the orbit": any_of(
            ~((period >= 0) & (period < length[of]) & (phase >= 0) & (phase < 1))
        ),
        "a listed impact is no harder than the largest": solved
        & (hardest > np.nan_to_num(largest)).any(axis=1),
        "impacts are in order": np.bincount(
            of[1:][(np.diff(at) < 0) & (np.diff(of) == 0)], minlength=m.size
        )
        > 0,
        "an impact moves into its support": any_of(~(velocity * (3 - 2 * support) > 0)),
        "impact velocities are finite": any_of(~np.isfinite(velocity)),
        "the largest impact velocity is that of an impact": orbit
        & ((counted > 0) & (hardest != largest)).any(axis=1),
        "a support that is not struck has no velocity": orbit
        & ((counted == 0) & ~np.isnan(largest)).any(axis=1),
    }


def number_faults(rows: xr.Dataset) -> dict[str, np.ndarray]:
    """Harmonics, multipliers and energies are finite and within their bounds; those of an unsolved row are NaN."""
    orbit = rows["period_multiple"].values > 0
    solved = orbit | (rows["status"].values == Status.MAX_PERIODS)
    upper, lower, near = supports_of(rows)
    harmonics = np.concatenate(
        [
            np.reshape(rows[f"{of}_{what}"].values, (orbit.size, -1))
            for of in ("displacement", "velocity")
            for what in ("mean", "amplitude", "phase")
        ],
        axis=1,
    )
    mean, amplitude = (rows[f"displacement_{of}"].values for of in ("mean", "amplitude"))
    radius = np.abs(rows["floquet_multiplier"].values)
    unsure = np.full(orbit.size, 1e-9)
    if "floquet_multiplier_error" in rows:
        largest = np.nan_to_num(radius).argmax(axis=1)
        errors = rows["floquet_multiplier_error"].values[np.arange(orbit.size), largest]
        unsure = np.nan_to_num(errors.astype(float), nan=1e-9)
    energy = np.column_stack(
        [rows["energy_input"], rows["energy_damping"], rows["energy_impact"].values]
    )
    gap = np.abs(rows["energy_residual"].values)
    with np.errstate(invalid="ignore"):
        share = np.abs(energy).sum(axis=1)
        scale = (
            share
            + near**2
            + np.nanmax(
                np.column_stack([np.zeros(orbit.size), rows["impact_velocity_max"].values]), axis=1
            )
            ** 2
        )
        return {
            "harmonics are finite": solved & ~np.isfinite(harmonics).all(axis=1),
            "harmonics of an unsolved row are none": ~solved & ~np.isnan(harmonics).all(axis=1),
            "the mean lies between the supports": solved
            & ~((mean >= lower - 1e-9 * near) & (mean <= upper + 1e-9 * near)),
            "an amplitude is within the supports": orbit
            & (amplitude > (2 / np.pi) * (upper - lower)[:, None] + 1e-9 * near[:, None]).any(
                axis=1
            ),
            "multipliers are finite": orbit & ~np.isfinite(radius).all(axis=1),
            "multipliers are in order": orbit & (radius[:, 0] < radius[:, 1] * (1 - 1e-12)),
            "no volume grows": orbit & (radius.prod(axis=1) > 1 + 1e-6),
            "stable agrees with the multipliers": (rows["stable"].values == 1)
            != (np.nan_to_num(radius.max(axis=1), nan=np.inf) < 1 - unsure),
            "energies are finite": solved & ~np.isfinite(energy).all(axis=1),
            "energies of an unsolved row are none": ~solved & ~np.isnan(energy).all(axis=1),
            "losses are losses": solved & (energy[:, 1:] < -1e-12 * scale[:, None]).any(axis=1),
            "energy is balanced": solved & ~(gap <= 1e-7 * scale),
            "an orbit stores no energy": orbit & (rows["energy_change"].values != 0.0),
        }


def motion_faults(rows: xr.Dataset) -> dict[str, np.ndarray]:
    """The samples of an orbit start at its section and stay between the supports."""
    orbit = rows["period_multiple"].values > 0
    upper, lower, near = supports_of(rows)
    x, v = rows["displacement"].values, rows["velocity"].values
    # Depth up to which a contact is a grazing (`march.roots.MAX_GRAZING_DEPTH`, of the lengths in the gap).
    rounding = 2.0**-46 * near
    sampled = np.isfinite(x).all(axis=1) & np.isfinite(v).all(axis=1)
    with np.errstate(invalid="ignore"):
        return {
            "samples are finite": orbit & ~sampled,
            "samples of a row without an orbit are none": ~orbit
            & ~(np.isnan(x).all(axis=1) & np.isnan(v).all(axis=1)),
            "samples lie between the supports": orbit
            & ~((x.min(axis=1) >= lower - rounding) & (x.max(axis=1) <= upper + rounding)),
            "samples begin at the section": orbit
            & (np.abs(x[:, 0] - rows["displacement_strobe"].values) > 1e-12 * near),
            "the section lies between the supports": (
                (rows["displacement_strobe"].values < lower - rounding)
                | (rows["displacement_strobe"].values > upper + rounding)
            ),
        }


def section_faults(rows: xr.Dataset) -> dict[str, np.ndarray]:
    """Sections repeat with the period multiple; the first of an orbit, or the last, is that of the row."""
    m = rows["period_multiple"].values
    solved = (m > 0) | (rows["status"].values == Status.MAX_PERIODS)
    faults = {}
    for of in ("displacement", "velocity"):
        values, strobe = rows[f"poincare_{of}"].values, rows[f"{of}_strobe"].values
        repeated = values[np.arange(m.size)[:, None], np.arange(64) % np.maximum(m, 1)[:, None]]
        at = np.where(m > 0, values[:, 0], values[:, -1])
        faults |= {
            f"{of}s at the section are finite if solved": solved != np.isfinite(values).all(axis=1),
            f"{of}s at the section of an unsolved row are none": ~solved
            & ~np.isnan(values).all(axis=1),
            f"{of}s at the section repeat": (m > 0) & (repeated != values).any(axis=1),
            f"the {of} of the row is at the section": solved & (at != strobe),
        }
    return faults


def subharmonic_faults(rows: xr.Dataset) -> dict[str, np.ndarray]:
    """Subharmonics of an orbit of several periods are finite between harmonics; all others are NaN."""
    m, j = rows["period_multiple"].values, rows["subharmonic"].values
    between = (m[:, None] > 1) & (j % np.maximum(m, 1)[:, None] != 0)
    faults = {}
    for part in ("amplitude", "phase"):
        values = rows[f"subharmonic_displacement_{part}"].values
        faults[f"subharmonic {part}s are those between harmonics"] = (
            np.isfinite(values) != between
        ).any(axis=1)
    return faults


def supports_of(rows: xr.Dataset) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Positions of supports 1 and 2, and the larger one of l and |delta|."""
    half, delta = rows["l"].values, rows["delta"].values
    return half + delta, delta - half, np.maximum(half, np.abs(delta))
