"""A motion by heyoka's Taylor integrator, with an event for each end of a piece, and by the package solve_nivp."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cache, partial
from typing import Any

import numpy as np

from vibropipe.lab.peers.solve_ivp import OFFSET, Recorder, sample_times
from vibropipe.lab.timing import repeated
from vibropipe.lab.work_precision_methods import (
    SAMPLES,
    BenchmarkMotion,
    Candidate,
    MethodResult,
    failed,
)
from vibropipe.words.measurements import Outcome

# Most steps per forcing period that are tried: at some 0.2 ms a step, a run of twenty periods takes seconds.
MAX_STEPS = 512
# An impact changes the velocity by this multiple, at least, of what forces can change it in a step.
IMPACT_CHANGE = 3.0
# d(approach)/d(velocity, displacement) of both supports.
APPROACH = np.array([[-1.0, 0.0], [1.0, 0.0]])


def is_for_nivp(motion: BenchmarkMotion, steps: float) -> bool:
    """Return whether a run is tried: with rigid supports alone, and not too many steps."""
    e = motion.exciter
    return steps <= MAX_STEPS and max(e.k1, e.k2, e.friction) == 0.0


def nivp_peer(motion: BenchmarkMotion, steps: int) -> Candidate:
    """Return solve_nivp with a number of steps per forcing period."""
    return Candidate(partial(show, motion, steps), repeated(partial(solve, motion, steps)))


def solve(motion: BenchmarkMotion, steps: int) -> tuple[np.ndarray, np.ndarray, int]:
    """Return times (n,), states (n, 2) of velocity and displacement, and the iterations for them."""
    from solve_nivp import solve_ivp_ns

    e = motion.exciter

    def equation(tau: float, y: Any) -> np.ndarray:
        force = e.f * math.sin(e.nu * tau) + e.f2 * math.sin(2.0 * e.nu * tau + e.phi2)
        return np.array([force - e.h * y[0] - y[1], y[0]])

    def jacobian(_tau: float, _y: Any, _residual: Any = None) -> np.ndarray:
        return np.array([[-e.h, -1.0], [1.0, 0.0]])

    supports = {
        "gap": lambda _tau, y: np.array([e.upper - y[1], y[1] - e.lower]),
        "u_map": lambda _tau, y: np.array([-y[0], y[0]]),
        "J_u": lambda _tau, _y: APPROACH,
        "G_apply": lambda _tau, _y, impulse, **_: np.array([impulse[1] - impulse[0], 0.0]),
        "e": np.array([e.R1, e.R2]),
    }
    tau, states, _steps, _residuals, solved = solve_ivp_ns(
        equation, (0.0, motion.tau_end), np.array([motion.v0, motion.x0]), method="trapezoidal",
        projection="unilateral", projection_opts=supports, solver="semismooth_newton",
        solver_opts={"rhs_jac": jacobian}, component_slices=[slice(0, 2)], adaptive=False,
        h0=e.period / steps,
    )[:5]  # fmt: skip
    return np.asarray(tau), np.asarray(states), sum(int(step[2]) for step in solved)


def show(motion: BenchmarkMotion, steps: int) -> MethodResult:
    """Solve a motion once and find its impacts in the steps."""
    e = motion.exciter
    tau, states, iterations = solve(motion, steps)
    v, x = states.T
    if not np.isfinite(states).all():
        return failed(Outcome.DID_NOT_END)
    push = abs(e.f) + abs(e.f2) + e.h * np.abs(v).max() + np.abs(x).max()
    is_reversed = np.abs(np.diff(v)) > IMPACT_CHANGE * push * np.diff(tau)
    upper, lower = is_reversed & (v[:-1] > 0.0), is_reversed & (v[:-1] < 0.0)
    struck = np.flatnonzero(upper | lower)
    wanted = (motion.periods - 1 + np.arange(SAMPLES) / SAMPLES) * e.period
    return MethodResult(
        Outcome.OK,
        (float(x[-1]), float(v[-1])),
        tau[struck + 1],
        np.where(upper[struck], 1, 2),
        v[struck],
        np.interp(wanted, tau, x),
        (float(tau.size - 1), math.nan, float(iterations)),
    )


# Parameters of the equation: those of every motion, of a second harmonic, of soft supports and of friction, in that
# order, since heyoka takes no more than it uses. DIRECTION is that of the recorder.
NU, F, DAMPING, UPPER, LOWER, F2, PHI2, STIFFNESS, CONSTANT, DIRECTION, HOLD = range(11)


@cache
def heyoka_equation(second: bool, pieces: bool, friction: bool) -> tuple[Any, Any, Any, Any]:
    """Return x, v, the right side of eq. (5), and the force on the mass at rest, friction included.

    second : whether there are f2 and phi2; pieces : whether there are soft supports or friction.
    """
    import heyoka

    x, v = heyoka.make_vars("x", "v")
    par = heyoka.par
    force = par[F] * heyoka.sin(par[NU] * heyoka.time)
    if second:
        force += par[F2] * heyoka.sin(2.0 * par[NU] * heyoka.time + par[PHI2])
    if not pieces:
        return x, v, force - par[DAMPING] * v - x, None
    at_rest = force - par[STIFFNESS] * x + par[CONSTANT]
    acceleration = at_rest - par[DAMPING] * v
    # A direction of 0 keeps a held mass where it is.
    return x, v, par[DIRECTION] ** 2 * acceleration if friction else acceleration, at_rest


class HeyokaRun:
    """A motion by heyoka, which may be run repeatedly."""

    def __init__(self, motion: BenchmarkMotion, tolerance: float) -> None:
        import heyoka

        self.motion, self.recorder = motion, Recorder(motion)
        self.times = sample_times(motion)
        e = motion.exciter
        self.has_pieces = max(e.k1, e.k2, e.friction) > 0.0
        x, v, acceleration, at_rest = heyoka_equation(
            e.f2 != 0.0, self.has_pieces, e.friction > 0.0
        )
        par, way = heyoka.par, heyoka.event_direction
        events = []
        for support, gap in ((1, par[UPPER] - x), (2, x - par[LOWER])):
            soft = self.recorder.is_soft(support)
            direction = way.any if soft else way.negative
            meet = self.calling(self.meet, support)
            events.append(heyoka.t_event(gap, callback=meet, direction=direction))
        if e.friction > 0.0:
            # Each is 1 where it does not apply, and falls to zero where it does.
            moves = par[DIRECTION] ** 2
            velocity = par[DIRECTION] * v + (1.0 - moves) + OFFSET
            margin = moves + (1.0 - moves) * (par[HOLD] ** 2 - at_rest**2)
            for zero, method in ((velocity, self.turn), (margin, self.release)):
                call = self.calling(method)
                events.append(
                    heyoka.t_event(zero, callback=call, direction=way.negative, cooldown=0.0)
                )
        holds = self.recorder.holds
        pars = [e.nu, e.f, e.h, e.upper, e.lower, e.f2, e.phi2, 1.0, 0.0, 1.0, holds]
        last = HOLD if e.friction > 0.0 else CONSTANT if self.has_pieces else LOWER
        used = 1 + max(last, PHI2 if e.f2 else 0)
        self.integrator = heyoka.taylor_adaptive(
            [(x, v), (v, acceleration)],
            [motion.x0, motion.v0],
            tol=tolerance,
            pars=pars[:used],
            t_events=events,
        )

    def set_piece(self) -> bool:
        """Hand the piece of the recorder to the integrator; return whether work is left."""
        if self.has_pieces:
            pars = self.integrator.pars
            pars[STIFFNESS], pars[DAMPING], pars[CONSTANT] = self.recorder.coefficients()
            if self.motion.exciter.friction > 0.0:
                pars[DIRECTION] = self.recorder.direction
        return self.recorder.spend(0)

    def calling(self, method: Callable[..., None], *arguments: int) -> Callable[[Any, int], bool]:
        """Return what calls a method with the integrator at an event; a function, since heyoka copies objects."""

        def call(integrator: Any, _sign: int) -> bool:
            method(integrator, *arguments)
            return self.set_piece()

        return call

    def meet(self, integrator: Any, support: int) -> None:
        """Strike, enter or leave a support."""
        before = float(integrator.state[1])
        integrator.state[1] = self.recorder.meet(float(integrator.time), support, before)
        integrator.state[0] = self.recorder.bound[support]

    def turn(self, integrator: Any) -> None:
        """Let the mass go on, or be held, where its velocity is zero."""
        integrator.state[1] = 0.0
        self.recorder.turn(float(integrator.time), float(integrator.state[0]))

    def release(self, integrator: Any) -> None:
        """Let the mass go where the force exceeds the friction."""
        self.recorder.release(float(integrator.time), float(integrator.state[0]))

    def reset(self, *, bounded: bool = True) -> None:
        """Go back to the start."""
        self.recorder = Recorder(self.motion, bounded=bounded)
        self.integrator.time = 0.0
        self.integrator.state[:] = (self.motion.x0, self.motion.v0)
        self.integrator.reset_cooldowns()
        self.set_piece()

    def show(self) -> MethodResult:
        """Run with samples and a limit of work."""
        import heyoka

        def continue_run(_integrator: Any) -> bool:
            return self.recorder.spend()

        self.reset()
        times, finished, steps = self.times, heyoka.taylor_outcome.time_limit, 0
        if times[0] > 0:
            first_part = self.integrator.propagate_until(times[0], callback=continue_run)
            if first_part[0] != finished:
                return failed(Outcome.DID_NOT_END)
            steps = first_part[3]
        last_part = self.integrator.propagate_grid(times, callback=continue_run)
        if last_part[0] != finished:
            return failed(Outcome.DID_NOT_END)
        states, work = last_part[-1], (float(steps + last_part[3]), math.nan, math.nan)
        return self.recorder.result(states[:-1, 0], states[-1], work)

    def solve_for_timing(self) -> None:
        """Run as a user would, without samples or limits."""
        self.reset(bounded=False)
        self.integrator.propagate_until(self.times[-1])


def heyoka_peer(motion: BenchmarkMotion, tolerance: float) -> Candidate:
    """Return heyoka's Taylor integrator with an event for each end of a piece."""
    run = HeyokaRun(motion, tolerance)
    return Candidate(run.show, repeated(run.solve_for_timing))
