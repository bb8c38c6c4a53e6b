"""The 40-digit reference of a motion, and the errors of other results against it.

Impacts of a method are paired with those of the reference in the order in which they come. A motion that lags behind
has an error of time, however large, but it has missed no impact; one that has passed over a contact has.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from decimal import Decimal
from typing import NamedTuple

import numpy as np

from vibropipe.lab.power_series import period_of
from vibropipe.lab.reference_solver import ReferenceSolver
from vibropipe.lab.work_precision_methods import SAMPLES, BenchmarkMotion, MethodResult
from vibropipe.words.measurements import Outcome
from vibropipe.words.vocabulary import drawn_by

HARMONICS = 4
# Impacts slower than this fraction of the fastest count as chatter, in which methods need not agree.
SLOW_IMPACT_RATIO = 0.05
# Change of a lag from one impact to the next, over the longer of the intervals before and after it (of the motion that
# has the shorter ones), from which one was passed over or added: that makes it a whole interval, while within a chatter
# lags change by up to half of one.
MAX_LAG_CHANGE = 0.9
ERRORS = drawn_by("accuracy")


class Pairs(NamedTuple):
    """Impacts on one support, paired in order.

    partner : (n,) index of the counterpart of each impact of the reference, -1 if it comes after the end; lag : the
    largest difference of times; is_same : whether both have the same sequence of impacts, but for late ones.
    """

    partner: np.ndarray
    lag: float
    is_same: bool


def pair_impacts(tau: np.ndarray, other_tau: np.ndarray, is_slow: np.ndarray, end: float) -> Pairs:
    """Pair the impacts of a reference on one support with those of another motion, both in order of time.

    tau : (n,) times of the reference
    other_tau, is_slow : (k,) times of the other motion, and whether it may have an impact that the reference does not
        count, as too slow
    end : end of both motions: what lags may come after it
    """
    partner = np.full(tau.size, -1)
    intervals, other_intervals = longer_intervals(tau), longer_intervals(other_tau)
    lag = largest = 0.0
    k, is_same = 0, True
    for n, time in enumerate(tau):
        expected = time + lag
        while (
            k + 1 < other_tau.size
            and is_slow[k]
            and abs(other_tau[k + 1] - expected) < abs(other_tau[k] - expected)
        ):
            k += 1
        if k == other_tau.size:
            is_same &= time + 2.0 * lag >= end
            largest = max(largest, end - time)
            continue
        interval = min(intervals[n], other_intervals[k])
        is_same &= bool(abs(other_tau[k] - expected) <= MAX_LAG_CHANGE * interval)
        partner[n], lag = k, float(other_tau[k] - time)
        largest = max(largest, abs(lag))
        k += 1
    left = other_tau[k:][~is_slow[k:]]
    is_same &= bool((left - 2.0 * lag >= end).all())
    return Pairs(partner, largest, bool(is_same))


def longer_intervals(tau: np.ndarray) -> np.ndarray:
    """Return the longer of the intervals before and after each of some times from 0 on."""
    before = np.diff(tau, prepend=0.0)
    return np.maximum(before, np.append(before[1:], 0.0))


class MotionReference:
    """The 40-digit reference of one motion, and the errors of results against it."""

    def __init__(self, motion: BenchmarkMotion) -> None:
        motion = motion.about_equilibrium()
        self.motion, period = motion, period_of(motion.exciter.nu)
        start = period * (motion.periods - 1)
        times = [start + period * k / SAMPLES for k in range(SAMPLES + 1)]
        states, impacts = reference_motion(motion, times)
        self.samples, self.end = states[:-1, 0], states[-1]
        self.speed = max(np.abs(states[:, 1]).max(), np.abs(impacts[:, 2]).max(initial=0.0))
        self.size = np.abs(states[:, 0]).max()
        self.slow = SLOW_IMPACT_RATIO * np.abs(impacts[:, 2]).max(initial=0.0)
        is_fast = np.abs(impacts[:, 2]) > self.slow
        self.tau, self.support, self.velocity = impacts[is_fast].T

    def impact_errors(
        self, tau: np.ndarray, support: np.ndarray, velocity: np.ndarray
    ) -> tuple[bool, float, float]:
        """Return whether no impact is missed or added, and the largest errors of time and of velocity."""
        is_same, lag, velocity_error = True, 0.0, 0.0
        speed = np.abs(velocity)
        is_counted = speed > 0.5 * self.slow
        for number in (1, 2):
            mine = self.support == number
            theirs = (support == number) & is_counted
            is_slow = speed[theirs] < 2.0 * self.slow
            pairs = pair_impacts(self.tau[mine], tau[theirs], is_slow, self.motion.tau_end)
            found = pairs.partner >= 0
            differences = velocity[theirs][pairs.partner[found]] - self.velocity[mine][found]
            is_same, lag = is_same and pairs.is_same, max(lag, pairs.lag)
            velocity_error = max(velocity_error, np.abs(differences).max(initial=0.0))
        return is_same, lag, float(velocity_error)

    def errors(self, result: MethodResult) -> tuple[Outcome, list[float]]:
        """Return the outcome of a result, MISSED_IMPACT if its impacts are not those of the reference, and its errors.

        They are the ERRORS of displacement and velocity, relative to their largest magnitudes in the last period and at
        impacts; of impact times, relative to the forcing period; of harmonics. nan where not comparable.
        """
        if result.outcome == Outcome.DID_NOT_END:
            return result.outcome, [math.nan] * len(ERRORS)
        end_error = np.abs(np.array(result.end) - self.end) / (self.size, self.speed)
        harmonics = np.abs(np.fft.rfft(result.samples - self.samples)[:HARMONICS]) * 2 / SAMPLES
        outcome, tau_error, speed_error = result.outcome, math.nan, math.nan
        if self.tau.size:
            is_same, lag, velocity = self.impact_errors(
                result.impact_tau, result.impact_support, result.impact_velocity
            )
            if is_same:
                tau_error, speed_error = lag / self.motion.exciter.period, velocity / self.speed
            else:
                outcome = max(outcome, Outcome.MISSED_IMPACT)
        errors = end_error.max(), tau_error, speed_error, harmonics.max() / self.size
        return outcome, [float(error) for error in errors]


def reference_motion(
    motion: BenchmarkMotion, times: Sequence[Decimal]
) -> tuple[np.ndarray, np.ndarray]:
    """Return (x, x') at the times, and (tau, support, velocity) of impacts and beginnings of soft contacts."""
    exact = ReferenceSolver(motion.exciter).run(motion.x0, motion.v0, times)
    return np.array(exact.states, dtype=float), np.array(exact.impacts, dtype=float).reshape(-1, 3)
