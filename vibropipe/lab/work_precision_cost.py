"""Estimated run time of a work-precision comparison on this machine: `work_precision_seconds`."""

from __future__ import annotations

import math
import time
from collections.abc import Mapping, Sequence

from vibropipe.lab.peers.recorder import MAX_WORK, RESTART
from vibropipe.lab.timing import expected_timing
from vibropipe.lab.work_precision import MAX_STEPS, Entry, build_method, entries
from vibropipe.lab.work_precision_methods import BenchmarkMotion
from vibropipe.march.log import STEPS
from vibropipe.solve.accuracy.method_choice import least_cost
from vibropipe.solve.motion.run import MotionResult, run_motion
from vibropipe.words.measurements import OWN_METHODS, Outcome

# Seconds of the 40-digit reference for a motion and for each of its impacts.
REFERENCE_SECONDS, REFERENCE_IMPACT_SECONDS = 5e-3, 7e-4
# Seconds of a call of `simulate` beside the march, and marches of one that estimates its error.
CALL_SECONDS, ASKED_RUNS = 2e-3, 6
# Runs of a method of this package in addition to its timings: with samples, without, and to warm up.
EXTRA_RUNS = 3
# Seconds and work of a sampled run of a reference package; None if it is not installed.
SampledRun = tuple[float, float] | None


def work_precision_seconds(
    motions: Mapping[str, BenchmarkMotion],
    methods: Sequence[str],
    steps: Sequence[int],
    tolerances: Sequence[float],
    accuracies: Sequence[float],
    repeats: int,
) -> float:
    """Estimate the CPU seconds of `solve_accuracy` with these arguments.

    Parameters
    ----------
    motions, methods, steps, tolerances, accuracies, repeats
        As of `solve_accuracy`.

    Returns
    -------
    float
        Seconds of one core.

    Notes
    -----
    Methods of this package are estimated from the cost of their work, reference packages from one period of one motion
    at each tolerance; packages that are not installed cost nothing. On motions with sticking, reference packages are
    assumed to use up the work that they may do.
    """
    listed = entries(methods, steps, tolerances)
    own = [entry for entry in listed if entry.method in OWN_METHODS]
    runs = [run_motion(motion.exciter, motion.request()) for motion in motions.values()]
    has_rests = [run.contacts["rest_start"].size > 0 for run in runs]
    plain = list(motions.values())[has_rests.index(min(has_rests))]
    samples = [sample_run(plain, entry) for entry in listed if entry.method not in OWN_METHODS]
    seconds = 0.0
    for motion, run, has_rest in zip(motions.values(), runs, has_rests, strict=True):
        seconds += own_seconds(run, motion.periods, own, repeats) + reference_seconds(run)
        seconds += sum(
            peer_seconds(sample, motion.periods, has_rest, repeats) for sample in samples
        )
        call = CALL_SECONDS + ASKED_RUNS * least_cost(1, motion.periods, run) * 1e-9
        seconds += len(accuracies) * (call + expected_timing(call, repeats))
    return seconds


def reference_seconds(run: MotionResult) -> float:
    """Return the seconds of the reference of a motion; closed forms need no time for impacts."""
    impacts = run.contacts["impact_tau"].size if run.counts[STEPS] > 0 else 0.0
    return REFERENCE_SECONDS + REFERENCE_IMPACT_SECONDS * impacts


def own_seconds(run: MotionResult, periods: int, listed: Sequence[Entry], repeats: int) -> float:
    """Return the seconds of this package's methods on a motion of `periods` forcing periods."""
    seconds = 0.0
    for entry in listed:
        steps = 1 if entry.method == "exact" else int(entry.value)
        if steps * periods <= MAX_STEPS:
            run_seconds = least_cost(steps, periods, run) * 1e-9
            seconds += EXTRA_RUNS * run_seconds + expected_timing(run_seconds, repeats)
    return seconds


def sample_run(motion: BenchmarkMotion, entry: Entry) -> SampledRun:
    """Return seconds and work of a reference package on one period of a motion."""
    candidate = build_method(entry.method, entry.value, motion._replace(periods=1))
    if isinstance(candidate, Outcome):
        return None
    candidate.show()  # loads and compiles
    start = time.thread_time()
    result = candidate.show()
    seconds = time.thread_time() - start
    if result.outcome == Outcome.DID_NOT_END:
        return seconds, MAX_WORK
    steps, evaluations, _ = result.effort
    work = steps if math.isnan(evaluations) else evaluations
    return seconds, work + RESTART * result.impact_tau.size


def peer_seconds(sampled: SampledRun, periods: int, has_rest: bool, repeats: int) -> float:
    """Return the seconds of a reference package on a motion of `periods` forcing periods."""
    if sampled is None:
        return 0.0
    seconds, work = sampled
    if has_rest or work >= MAX_WORK:
        return seconds / work * MAX_WORK * periods  # stopped, and not timed
    return seconds * periods + expected_timing(seconds * periods, repeats)
