"""General integrators on the same motions, as a user would write them: solve_ivp of scipy, and heyoka.

They know nothing of this problem: impacts are events at which the integration stops or is changed. A
peer that goes on for ever is stopped, one that falls through a support is found out.
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

# Work in a forcing period after which a peer is stopped: evaluations of the equation, or steps of heyoka. Counted
# and not timed, so that the same peers are stopped on every machine.
MAX_WORK = 10_000
# A new start after an impact costs a peer about as much as so many evaluations.
RESTART = 100
# A mass so far beyond a support, in half distances of the supports, has fallen through it.
DEPTH = 1e-3


class WorkError(Exception):
    """All the work that a peer may do is done."""


@cache
def is_installed(method: str) -> bool:
    """Whether the package of a peer is there."""
    return importlib.util.find_spec("scipy" if method in SCIPY else method) is not None


def last_period(motion: BenchmarkMotion) -> np.ndarray:
    """Times of the samples (SAMPLES,) and the end."""
    period = motion.exciter.period
    return (motion.periods - 1 + np.arange(SAMPLES + 1) / SAMPLES) * period


class Recorder:
    """Collects impacts, and tells when a peer has done all the work it may (unless not `bounded`)."""

    def __init__(self, motion: BenchmarkMotion, *, bounded: bool = True) -> None:
        self.restitution = {1: motion.exciter.R1, 2: motion.exciter.R2}
        self.bound = {1: motion.exciter.upper, 2: motion.exciter.lower}
        self.l, self.impacts = motion.exciter.l, list[tuple[float, int, float]]()
        self.left = MAX_WORK * motion.periods if bounded else math.inf

    def may_go_on(self, work: int = 1) -> bool:
        """Whether there is work left after so much of it."""
        self.left -= work
        return self.left > 0

    def strike(self, tau: float, support: int, velocity: float) -> float:
        """Note an impact; its velocity after."""
        self.impacts.append((tau, support, velocity))
        self.left -= RESTART
        return -self.restitution[support] * velocity

    def shown(self, samples: Any, end: Any, work: tuple[float, float, float]) -> MethodResult:
        """What was found, with a fall through a support told."""
        tau, support, velocity = np.array(self.impacts or np.empty((0, 3))).T
        x = np.append(samples, end[0])
        if not np.isfinite([*x, end[1]]).all():
            return failed(Outcome.DID_NOT_END)
        depth = max(x.max() - self.bound[1], self.bound[2] - x.min())
        outcome = Outcome.FELL_THROUGH if depth > DEPTH * self.l else Outcome.OK
        return MethodResult(
            outcome, (float(end[0]), float(end[1])), tau, support, velocity, samples, work
        )


def scipy_peer(motion: BenchmarkMotion, method: str, tolerance: float) -> Candidate:
    """solve_ivp with terminal events at both supports, started again after each impact."""

    def show() -> MethodResult:
        try:
            return solve_by_scipy(motion, method, tolerance)
        except WorkError:
            return failed(Outcome.DID_NOT_END)

    return Candidate(show, repeated(partial(solve_by_scipy, motion, method, tolerance, timed=True)))


def solve_by_scipy(
    motion: BenchmarkMotion, method: str, tolerance: float, *, timed: bool = False
) -> MethodResult:
    """One motion; `timed` leaves out what is looked at only, and the bound on work."""
    from scipy.integrate import solve_ivp

    e, recorder = motion.exciter, Recorder(motion, bounded=not timed)
    nu, f, h, upper, lower = e.nu, e.f, e.h, e.upper, e.lower

    def equation(tau: float, state: Any) -> Any:
        if not recorder.may_go_on():
            raise WorkError
        return state[1], f * math.sin(nu * tau) - h * state[1] - state[0]

    def gap_1(tau: float, state: Any) -> Any:
        return upper - state[0]

    def gap_2(tau: float, state: Any) -> Any:
        return state[0] - lower

    for gap in (gap_1, gap_2):
        gap.terminal, gap.direction = True, -1  # type: ignore[attr-defined]
    tau, state, times = 0.0, np.array([motion.x0, motion.v0]), last_period(motion)
    samples, steps, evaluations = np.full(0 if timed else SAMPLES, np.nan), 0, 0
    while tau < times[-1]:
        found = solve_ivp(
            equation, (tau, times[-1]), state, method, events=(gap_1, gap_2),
            dense_output=not timed, rtol=tolerance, atol=tolerance,
        )  # fmt: skip
        evaluations += found.nfev
        steps += len(found.t) - 1
        among = (times[:-1] >= tau) & (times[:-1] <= found.t[-1])
        if not timed and len(found.t) > 1 and among.any():
            samples[among] = found.sol(times[:-1][among])[0]
        tau, state = found.t[-1], found.y[:, -1]
        if found.status == -1:
            return failed(Outcome.DID_NOT_END)
        if found.status == 1:
            support = 1 if found.t_events[0].size else 2
            velocity = recorder.strike(tau, support, state[1])
            state = np.array([recorder.bound[support], velocity])
    return recorder.shown(samples, state, (float(steps), float(evaluations), math.nan))


@cache
def heyoka_equation() -> tuple[Any, Any, Any]:
    """The variables and eq. (5) in symbols, parameters nu, f, h, support 1, support 2."""
    import heyoka

    x, v = heyoka.make_vars("x", "v")
    nu, f, h = (heyoka.par[i] for i in range(3))
    return x, v, f * heyoka.sin(nu * heyoka.time) - h * v - x


def heyoka_peer(motion: BenchmarkMotion, tolerance: float) -> Candidate:
    """heyoka's Taylor integrator with an event at each support that resets the velocity."""
    import heyoka

    e, recorder = motion.exciter, Recorder(motion)
    x, v, acceleration = heyoka_equation()

    def strike(support: int) -> Any:
        def callback(integrator: Any, _sign: int) -> bool:
            before = float(integrator.state[1])
            integrator.state[1] = recorder.strike(float(integrator.time), support, before)
            integrator.state[0] = recorder.bound[support]
            return recorder.may_go_on(0)

        return callback

    falling = heyoka.event_direction.negative
    gaps = (heyoka.par[3] - x, x - heyoka.par[4])
    integrator = heyoka.taylor_adaptive(
        [(x, v), (v, acceleration)],
        [motion.x0, motion.v0],
        tol=tolerance,
        pars=[e.nu, e.f, e.h, e.upper, e.lower],
        t_events=[
            heyoka.t_event(gap, callback=strike(i + 1), direction=falling)
            for i, gap in enumerate(gaps)
        ],
    )
    times = last_period(motion)

    def begin(*, bounded: bool = True) -> None:
        nonlocal recorder
        recorder = Recorder(motion, bounded=bounded)
        integrator.time, integrator.state[:] = 0.0, (motion.x0, motion.v0)
        integrator.reset_cooldowns()

    def ahead(_integrator: Any) -> bool:
        return recorder.may_go_on()

    def show() -> MethodResult:
        begin()
        ended, steps = heyoka.taylor_outcome.time_limit, 0
        if times[0] > 0:
            before = integrator.propagate_until(times[0], callback=ahead)
            if before[0] != ended:
                return failed(Outcome.DID_NOT_END)
            steps = before[3]
        after = integrator.propagate_grid(times, callback=ahead)
        if after[0] != ended:
            return failed(Outcome.DID_NOT_END)
        states, work = after[-1], (float(steps + after[3]), math.nan, math.nan)
        return recorder.shown(states[:-1, 0], states[-1], work)

    def once() -> None:
        begin(bounded=False)
        integrator.propagate_until(times[-1])

    return Candidate(show, repeated(once))
