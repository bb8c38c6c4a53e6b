"""How long a race will take on this machine, without running it: `race_seconds`."""

from __future__ import annotations

import math
import time
from collections.abc import Mapping, Sequence

from vibropipe.lab.peers import MAX_WORK, RESTART
from vibropipe.lab.timing import expected_timing
from vibropipe.lab.work_precision import MAX_STEPS, Entry, build_method, entries
from vibropipe.lab.work_precision_methods import BenchmarkMotion
from vibropipe.march.log import STEPS
from vibropipe.solve.accuracy.method_choice import least_cost
from vibropipe.solve.run import MotionResult, run_motion
from vibropipe.words.measurements import OWN_METHODS, Outcome

# Seconds of the twin that judges: for a motion, for each of its impacts.
JUDGED, JUDGED_IMPACT = 5e-3, 7e-4
# Runs of an own method beside its rounds: with and without samples, and to warm. A peer is run with samples only.
RUNS = 3
# What a peer's run is worth in seconds of the one sampled, in work: (seconds, work), or None if it is not there.
Sampled = tuple[float, float] | None


def race_seconds(
    motions: Mapping[str, BenchmarkMotion],
    methods: Sequence[str],
    steps: Sequence[int],
    tolerances: Sequence[float],
    peer_periods: int,
    repeats: int,
) -> float:
    """Estimate the seconds of one core that `solve_accuracy` will take with these arguments.

    Notes
    -----
    Own methods by the prices of their work; peers by one period of one motion, each at each tolerance, in
    which those that are not installed cost nothing. Where the mass comes to rest they are taken to use
    up all the work that they may do.
    """
    listed = entries(methods, steps, tolerances)
    own = [entry for entry in listed if entry.method in OWN_METHODS]
    runs = [run_motion(motion.exciter, motion.task()) for motion in motions.values()]
    rests = [run.contacts["rest_start"].size > 0 for run in runs]
    plain = list(motions.values())[rests.index(min(rests))]
    sampled = [sample(plain, entry) for entry in listed if entry.method not in OWN_METHODS]
    seconds = 0.0
    for motion, run, is_chatter in zip(motions.values(), runs, rests, strict=True):
        periods = min(motion.periods, peer_periods)
        seconds += own_seconds(run, motion.periods, own, repeats) + judge_seconds(run, 1.0)
        if sampled:
            seconds += judge_seconds(run, periods / motion.periods)
        seconds += sum(peer_seconds(each, periods, is_chatter, repeats) for each in sampled)
    return seconds


def judge_seconds(run: MotionResult, share: float) -> float:
    """Seconds of the twin on a share of a motion; a closed form costs it next to nothing for each impact."""
    impacts = share * run.contacts["impact_tau"].size if run.counts[STEPS] > 0 else 0.0
    return JUDGED + JUDGED_IMPACT * impacts


def own_seconds(run: MotionResult, periods: int, listed: Sequence[Entry], repeats: int) -> float:
    """Seconds of own methods on a motion of so many periods."""
    spent = 0.0
    for entry in listed:
        steps = 1 if entry.method == "exact" else int(entry.value)
        if steps * periods <= MAX_STEPS:
            each = least_cost(steps, periods, run) * 1e-9
            spent += RUNS * each + expected_timing(each, repeats)
    return spent


def sample(motion: BenchmarkMotion, entry: Entry) -> Sampled:
    """Seconds and work of a peer on one period of a motion."""
    entered = build_method(entry.method, entry.value, motion._replace(periods=1))
    if isinstance(entered, Outcome):
        return None
    entered.show()  # loads and compiles
    begin = time.thread_time()
    shown = entered.show()
    seconds = time.thread_time() - begin
    if shown.outcome == Outcome.DID_NOT_END:
        return seconds, MAX_WORK
    steps, evaluations, _ = shown.effort
    work = steps if math.isnan(evaluations) else evaluations
    return seconds, work + RESTART * shown.impact_tau.size


def peer_seconds(sampled: Sampled, periods: int, rests: bool, repeats: int) -> float:
    """Seconds of a peer on a motion over so many periods."""
    if sampled is None:
        return 0.0
    seconds, work = sampled
    if rests or work >= MAX_WORK:
        return seconds / work * MAX_WORK * periods  # stopped, and not timed
    return seconds * periods + expected_timing(seconds * periods, repeats)
