"""A motion by solve_nivp: nonsmooth time stepping, with both supports as unilateral constraints on the velocity.

Impacts are not located: within a step whose end lies on or beyond a support, the velocity is projected so that Newton's
law of impact holds. Steps are of the trapezoidal rule, solved by a semismooth Newton method.
"""

from __future__ import annotations

import math
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
