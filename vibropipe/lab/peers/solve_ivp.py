"""A motion by solve_ivp of scipy, with a terminal event for each end of a piece and a restart after it."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from vibropipe.lab.peers.recorder import OFFSET, Recorder, WorkError, sample_times
from vibropipe.lab.timing import repeated
from vibropipe.lab.work_precision_methods import (
    SAMPLES,
    BenchmarkMotion,
    Candidate,
    MethodResult,
    failed,
)
from vibropipe.words.measurements import Outcome

# Least number of steps in a forcing period of a motion with friction. An event is noticed if its function has another
# sign at the end of a step: longer steps pass over a velocity that turns twice, and over the release of a held mass.
STEPS_WITH_FRICTION = 32
Event = Callable[[float, Any], float]


def scipy_peer(motion: BenchmarkMotion, method: str, tolerance: float) -> Candidate:
    """Return solve_ivp with a terminal event at each support, restarted after each impact."""

    def show() -> MethodResult:
        try:
            return solve_by_scipy(motion, method, tolerance)
        except WorkError:
            return failed(Outcome.DID_NOT_END)

    return Candidate(show, repeated(partial(solve_by_scipy, motion, method, tolerance, timed=True)))


def terminal(event: Event, direction: float) -> Event:
    """Let an event end an integration where it passes zero in a direction."""
    event.terminal, event.direction = True, direction  # type: ignore[attr-defined]
    return event


def events_of_piece(recorder: Recorder) -> dict[str, Event]:
    """Return the events that end the present piece: gap_1, gap_2, velocity or release."""
    exciter, bound = recorder.exciter, recorder.bound

    def gap_event(support: int) -> Event:
        side, way = 1 if support == 1 else -1, 1 if recorder.pressed == support else -1
        start = (
            bound[support] - side * way * OFFSET if recorder.is_soft(support) else bound[support]
        )
        return terminal(lambda _tau, state: side * (start - state[0]), way)

    def velocity(_tau: float, state: Any) -> float:
        return state[1] + recorder.direction * OFFSET

    def release(tau: float, state: Any) -> float:
        return exciter.friction - abs(recorder.force_at_rest(tau, state[0]))

    if recorder.is_held():
        return {"release": terminal(release, -1)}
    events = {"gap_1": gap_event(1), "gap_2": gap_event(2)}
    if exciter.friction > 0.0:
        events["velocity"] = terminal(velocity, -recorder.direction)
    return events


def pass_event(recorder: Recorder, event: str, tau: float, state: np.ndarray) -> np.ndarray:
    """Let a recorder take an event; return the state after it."""
    if event == "release":
        recorder.release(tau, state[0])
        return state
    if event == "velocity":
        recorder.turn(tau, state[0])
        return np.array([state[0], 0.0])
    support = int(event[-1])
    velocity = recorder.meet(tau, support, state[1])
    return np.array([recorder.bound[support], velocity])


def solve_by_scipy(
    motion: BenchmarkMotion,
    method: str,
    tolerance: float,
    *,
    timed: bool = False,
    recorder: Recorder | None = None,
    longest: float = math.inf,
) -> MethodResult:
    """Solve one motion by solve_ivp.

    `timed` leaves out samples and the limit of work, which a user would not have either; `recorder` takes the impacts;
    `longest` is the longest step.
    """
    from scipy.integrate import solve_ivp

    exciter = motion.exciter
    if recorder is None:
        recorder = Recorder(motion, bounded=not timed)
    nu, f, f2, phi2 = exciter.nu, exciter.f, exciter.f2, exciter.phi2
    stiffness, damping, constant = recorder.coefficients()
    if exciter.friction > 0.0:
        longest = min(longest, exciter.period / STEPS_WITH_FRICTION)

    def equation(tau: float, state: Any) -> Any:
        if not recorder.spend():
            raise WorkError
        force = constant + f * math.sin(nu * tau)
        if f2:
            force += f2 * math.sin(2 * nu * tau + phi2)
        return state[1], force - damping * state[1] - stiffness * state[0]

    def hold(_tau: float, _state: Any) -> Any:
        if not recorder.spend():
            raise WorkError
        return 0.0, 0.0

    tau, state, times = 0.0, np.array([motion.x0, motion.v0]), sample_times(motion)
    samples, steps, evaluations = np.full(0 if timed else SAMPLES, np.nan), 0, 0
    while tau < times[-1]:
        events = events_of_piece(recorder)
        solution = solve_ivp(
            hold if recorder.is_held() else equation, (tau, times[-1]), state, method,
            events=list(events.values()), dense_output=not timed, rtol=tolerance, atol=tolerance,
            max_step=longest,
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
            found = (name for name, t in zip(events, solution.t_events, strict=True) if t.size)
            state = pass_event(recorder, next(found), tau, state)
            stiffness, damping, constant = recorder.coefficients()
    return recorder.result(samples, state, (float(steps), float(evaluations), math.nan))
