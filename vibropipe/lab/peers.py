"""Reference packages on the same motions, as a user would apply them: solve_ivp of scipy, and heyoka.

They are general integrators: an impact is an event at which the integration stops or the velocity is reset. A run whose
work exceeds a limit is stopped, and penetration of a support is detected.
"""

from __future__ import annotations

import importlib.util
import math
from functools import cache, partial
from typing import Any

import numpy as np

from vibropipe.lab.timing import repeated
from vibropipe.lab.work_precision_methods import (
    SAMPLES,
    BenchmarkMotion,
    Candidate,
    MethodResult,
    failed,
)
from vibropipe.words.measurements import SCIPY, Outcome

# Largest work per forcing period: evaluations of the equation, or steps of heyoka. It is counted, not timed, so that
# the same runs are stopped on every machine.
MAX_WORK = 10_000
# Work of a restart after an impact, in evaluations of the equation.
RESTART = 100
# Largest penetration of a support, relative to l; beyond it an impact was missed.
MAX_PENETRATION = 1e-3


class WorkError(Exception):
    """The work that a run may do is used up."""


@cache
def is_installed(method: str) -> bool:
    """Return whether the package of a method is installed."""
    return importlib.util.find_spec("scipy" if method in SCIPY else method) is not None


def sample_times(motion: BenchmarkMotion) -> np.ndarray:
    """Return the times of the samples (SAMPLES,) in the last period, followed by the end."""
    period = motion.exciter.period
    return (motion.periods - 1 + np.arange(SAMPLES + 1) / SAMPLES) * period


class Recorder:
    """Record of the impacts of a run and, if `bounded`, of the work it may still do."""

    def __init__(self, motion: BenchmarkMotion, *, bounded: bool = True) -> None:
        self.restitution = {1: motion.exciter.R1, 2: motion.exciter.R2}
        self.bound = {1: motion.exciter.upper, 2: motion.exciter.lower}
        self.l, self.impacts = motion.exciter.l, list[tuple[float, int, float]]()
        self.work_left = MAX_WORK * motion.periods if bounded else math.inf

    def spend(self, work: int = 1) -> bool:
        """Count work; return whether any is left."""
        self.work_left -= work
        return self.work_left > 0

    def record_impact(self, tau: float, support: int, velocity: float) -> float:
        """Record an impact and return the velocity after it."""
        self.impacts.append((tau, support, velocity))
        self.work_left -= RESTART
        return -self.restitution[support] * velocity

    def result(self, samples: Any, end: Any, work: tuple[float, float, float]) -> MethodResult:
        """Return the result of a run; its outcome reports nan and penetration of a support."""
        tau, support, velocity = np.array(self.impacts or np.empty((0, 3))).T
        x = np.append(samples, end[0])
        if not np.isfinite([*x, end[1]]).all():
            return failed(Outcome.DID_NOT_END)
        depth = max(x.max() - self.bound[1], self.bound[2] - x.min())
        outcome = Outcome.FELL_THROUGH if depth > MAX_PENETRATION * self.l else Outcome.OK
        return MethodResult(
            outcome, (float(end[0]), float(end[1])), tau, support, velocity, samples, work
        )


def scipy_peer(motion: BenchmarkMotion, method: str, tolerance: float) -> Candidate:
    """Return solve_ivp with a terminal event at each support, restarted after each impact."""

    def show() -> MethodResult:
        try:
            return solve_by_scipy(motion, method, tolerance)
        except WorkError:
            return failed(Outcome.DID_NOT_END)

    return Candidate(show, repeated(partial(solve_by_scipy, motion, method, tolerance, timed=True)))


def solve_by_scipy(
    motion: BenchmarkMotion, method: str, tolerance: float, *, timed: bool = False
) -> MethodResult:
    """Solve one motion by solve_ivp.

    `timed` leaves out samples and the limit of work, which a user would not have either.
    """
    from scipy.integrate import solve_ivp

    exciter, recorder = motion.exciter, Recorder(motion, bounded=not timed)
    nu, f, h, upper, lower = exciter.nu, exciter.f, exciter.h, exciter.upper, exciter.lower
    f2, phi2 = exciter.f2, exciter.phi2

    def equation(tau: float, state: Any) -> Any:
        if not recorder.spend():
            raise WorkError
        force = f * math.sin(nu * tau)
        if f2:
            force += f2 * math.sin(2 * nu * tau + phi2)
        return state[1], force - h * state[1] - state[0]

    def gap_1(tau: float, state: Any) -> Any:
        return upper - state[0]

    def gap_2(tau: float, state: Any) -> Any:
        return state[0] - lower

    for gap in (gap_1, gap_2):
        gap.terminal, gap.direction = True, -1  # type: ignore[attr-defined]
    tau, state, times = 0.0, np.array([motion.x0, motion.v0]), sample_times(motion)
    samples, steps, evaluations = np.full(0 if timed else SAMPLES, np.nan), 0, 0
    while tau < times[-1]:
        solution = solve_ivp(
            equation, (tau, times[-1]), state, method, events=(gap_1, gap_2),
            dense_output=not timed, rtol=tolerance, atol=tolerance,
        )  # fmt: skip
        evaluations += solution.nfev
        steps += len(solution.t) - 1
        is_in_piece = (times[:-1] >= tau) & (times[:-1] <= solution.t[-1])
        if not timed and len(solution.t) > 1 and is_in_piece.any():
            samples[is_in_piece] = solution.sol(times[:-1][is_in_piece])[0]
        tau, state = solution.t[-1], solution.y[:, -1]
        if solution.status == -1:
            return failed(Outcome.DID_NOT_END)
        if solution.status == 1:
            support = 1 if solution.t_events[0].size else 2
            velocity = recorder.record_impact(tau, support, state[1])
            state = np.array([recorder.bound[support], velocity])
    return recorder.result(samples, state, (float(steps), float(evaluations), math.nan))


@cache
def heyoka_equation(second: bool) -> tuple[Any, Any, Any]:
    """Return x, v and the right side of eq. (5) with parameters nu, f, h and the positions of both supports.

    second : whether f2 and phi2 follow.
    """
    import heyoka

    x, v = heyoka.make_vars("x", "v")
    nu, f, h = (heyoka.par[i] for i in range(3))
    acceleration = f * heyoka.sin(nu * heyoka.time) - h * v - x
    if second:
        f2, phi2 = heyoka.par[5], heyoka.par[6]
        acceleration += f2 * heyoka.sin(2.0 * nu * heyoka.time + phi2)
    return x, v, acceleration


def heyoka_peer(motion: BenchmarkMotion, tolerance: float) -> Candidate:
    """Return heyoka's Taylor integrator with an event at each support that resets the velocity."""
    import heyoka

    exciter, recorder = motion.exciter, Recorder(motion)
    x, v, acceleration = heyoka_equation(exciter.f2 != 0.0)
    second = [exciter.f2, exciter.phi2] if exciter.f2 else []

    def reset_at(support: int) -> Any:
        def callback(integrator: Any, _sign: int) -> bool:
            before = float(integrator.state[1])
            integrator.state[1] = recorder.record_impact(float(integrator.time), support, before)
            integrator.state[0] = recorder.bound[support]
            return recorder.spend(0)

        return callback

    closing = heyoka.event_direction.negative
    gaps = (heyoka.par[3] - x, x - heyoka.par[4])
    integrator = heyoka.taylor_adaptive(
        [(x, v), (v, acceleration)],
        [motion.x0, motion.v0],
        tol=tolerance,
        pars=[exciter.nu, exciter.f, exciter.h, exciter.upper, exciter.lower, *second],
        t_events=[
            heyoka.t_event(gap, callback=reset_at(i + 1), direction=closing)
            for i, gap in enumerate(gaps)
        ],
    )
    times = sample_times(motion)

    def reset(*, bounded: bool = True) -> None:
        nonlocal recorder
        recorder = Recorder(motion, bounded=bounded)
        integrator.time, integrator.state[:] = 0.0, (motion.x0, motion.v0)
        integrator.reset_cooldowns()

    def continue_run(_integrator: Any) -> bool:
        return recorder.spend()

    def show() -> MethodResult:
        reset()
        finished, steps = heyoka.taylor_outcome.time_limit, 0
        if times[0] > 0:
            first_part = integrator.propagate_until(times[0], callback=continue_run)
            if first_part[0] != finished:
                return failed(Outcome.DID_NOT_END)
            steps = first_part[3]
        last_part = integrator.propagate_grid(times, callback=continue_run)
        if last_part[0] != finished:
            return failed(Outcome.DID_NOT_END)
        states, work = last_part[-1], (float(steps + last_part[3]), math.nan, math.nan)
        return recorder.result(states[:-1, 0], states[-1], work)

    def solve_for_timing() -> None:
        reset(bounded=False)
        integrator.propagate_until(times[-1])

    return Candidate(show, repeated(solve_for_timing))
