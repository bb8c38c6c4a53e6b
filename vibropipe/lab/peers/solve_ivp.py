"""A motion by solve_ivp of scipy, with a terminal event for each end of a piece and a restart after it;
what each run of another package records, and the limit of its work.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
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
from vibropipe.words.measurements import Outcome

# Largest work per forcing period: evaluations of the equation, or steps of heyoka. It is counted, not timed, so that
# the same runs are stopped on every machine.
MAX_WORK = 10_000
# Work of a restart after an event, in evaluations of the equation.
RESTART = 100
# Largest penetration of a rigid support, relative to l; beyond it an impact was missed.
MAX_PENETRATION = 1e-3
# What is added to a velocity, or to the gap of a soft support, that is zero where a piece begins and again where it
# ends: the event function then begins on its own side of zero, and both packages find its zero in a first step, too.
# The time of the event moves by as much over its rate, below what is compared.
OFFSET = 1e-14


class WorkError(Exception):
    """The work that a run may do is used up."""


def sample_times(motion: BenchmarkMotion) -> np.ndarray:
    """Return the times of the samples (SAMPLES,) in the last period, followed by the end."""
    period = motion.exciter.period
    return (motion.periods - 1 + np.arange(SAMPLES + 1) / SAMPLES) * period


class Recorder:
    """Record of a run: its impacts, the linear piece it is on and, if `bounded`, the work it may still do.

    pressed : the soft support that acts on the mass; 0 if none
    direction : sign of the velocity, or of the velocity that the mass is about to have; 0 if friction holds it
    """

    def __init__(self, motion: BenchmarkMotion, *, bounded: bool = True) -> None:
        e = motion.exciter
        self.exciter, self.impacts = e, list[tuple[float, int, float]]()
        self.restitution = {1: e.R1, 2: e.R2}
        self.bound = {1: e.upper, 2: e.lower}
        self.stiffness, self.damping = {1: e.k1, 2: e.k2}, {1: e.h1, 2: e.h2}
        self.work_left = MAX_WORK * motion.periods if bounded else math.inf
        x, v = motion.x0, motion.v0
        support = 1 if x >= e.upper else 2 if x <= e.lower else 0
        self.pressed = support if self.is_soft(support) and x != self.bound[support] else 0
        self.direction = 1.0
        self.go_on(0.0, x, v)
        if self.is_soft(support) and not self.pressed and (self.direction > 0) == (support == 1):
            self.pressed = support

    def is_soft(self, support: int) -> bool:
        """Return whether a support is soft; 0 is none."""
        return self.stiffness.get(support, 0.0) > 0.0

    def spend(self, work: int = 1) -> bool:
        """Count work; return whether any is left."""
        self.work_left -= work
        return self.work_left > 0

    def coefficients(self) -> tuple[float, float, float]:
        """Return stiffness, damping and constant force of the piece."""
        k, h = self.stiffness.get(self.pressed, 0.0), self.damping.get(self.pressed, 0.0)
        constant = k * self.bound.get(self.pressed, 0.0) - self.exciter.friction * self.direction
        return 1.0 + k, self.exciter.h + h, constant

    def force_at(self, tau: float) -> float:
        """Return the periodic force."""
        e = self.exciter
        force = e.f * math.sin(e.nu * tau)
        return force + e.f2 * math.sin(2 * e.nu * tau + e.phi2) if e.f2 else force

    def force_at_rest(self, tau: float, x: float) -> float:
        """Return the force on the mass without velocity, friction apart."""
        k = self.stiffness.get(self.pressed, 0.0)
        return self.force_at(tau) - x - k * (x - self.bound.get(self.pressed, 0.0))

    def go_on(self, tau: float, x: float, v: float) -> None:
        """Set the direction in which the mass goes on from a state; without velocity it may be held."""
        if v == 0.0:
            v = self.force_at_rest(tau, x)
            if self.exciter.friction > 0.0 and abs(v) <= self.holds:
                v = 0.0
        self.direction = math.copysign(1.0, v) if v else 0.0

    @property
    def holds(self) -> float:
        """The largest force that holds a mass without velocity."""
        return self.exciter.friction_ratio * self.exciter.friction

    def is_held(self) -> bool:
        """Return whether friction holds the mass."""
        return self.direction == 0.0 and self.exciter.friction > 0.0

    def release(self, tau: float, x: float) -> None:
        """Let a held mass go as the force pulls it."""
        self.direction = math.copysign(1.0, self.force_at_rest(tau, x))
        self.work_left -= RESTART

    def turn(self, tau: float, x: float) -> None:
        """Let a mass go on that has lost its velocity."""
        self.go_on(tau, x, 0.0)
        self.work_left -= RESTART

    def meet(self, tau: float, support: int, velocity: float) -> float:
        """Strike a rigid support, enter a soft one or leave it; return the velocity after it."""
        self.work_left -= RESTART
        if self.pressed == support:
            self.pressed = 0
            return velocity
        self.impacts.append((tau, support, velocity))
        if self.is_soft(support):
            self.pressed = support
            return velocity
        after = -self.restitution[support] * velocity
        self.direction = math.copysign(1.0, after)
        return after

    def result(self, samples: Any, end: Any, work: tuple[float, float, float]) -> MethodResult:
        """Return the result of a run; its outcome reports nan and penetration of a rigid support."""
        tau, support, velocity = np.array(self.impacts or np.empty((0, 3))).T
        x = np.append(samples, end[0])
        if not np.isfinite([*x, end[1]]).all():
            return failed(Outcome.DID_NOT_END)
        depths = {1: x.max() - self.bound[1], 2: self.bound[2] - x.min()}
        depth = max((depths[i] for i in depths if not self.is_soft(i)), default=0.0)
        fell = depth > MAX_PENETRATION * self.exciter.l
        return MethodResult(
            Outcome.FELL_THROUGH if fell else Outcome.OK,
            (float(end[0]), float(end[1])),
            tau,
            support,
            velocity,
            samples,
            work,
        )


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
        return recorder.holds - abs(recorder.force_at_rest(tau, state[0]))

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
