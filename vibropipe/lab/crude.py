"""Newmark's method with everything applied at the end of the step, a common simple scheme kept as a reference.

A step that ends beyond a rigid support is set back onto it, and its velocity is reset there. A soft support acts during
a step that begins beyond it (one that only pushes unless it would pull there), and friction acts against the velocity
at the beginning; a velocity that changes its sign in a step with friction is set to zero. No event is located and no
rest on a support is detected, so the error is of first order in the step.
"""

from __future__ import annotations

from vibropipe.compiler import jit
from vibropipe.march.grid import force_at_step
from vibropipe.march.log import STEPS, clear_log, log_impact
from vibropipe.march.piece_state import coefficients
from vibropipe.physics.contact import support_position
from vibropipe.physics.friction import friction_of, hold_of
from vibropipe.physics.load import force_at, force_value
from vibropipe.physics.stiffness import (
    is_soft,
    only_pushes,
    piece_mean_acceleration,
    pull_of_support,
)


@jit
def support_reached(p, x) -> int:
    """Return the support that x lies on or beyond; 0 if none."""
    return 1 if x >= support_position(p, 1) else 2 if x <= support_position(p, 2) else 0


@jit
def is_let_go(e, p, home, x, v) -> bool:
    """Return whether a support that only pushes would pull."""
    if e.no_pull is None:
        return False
    sigma = -1.0 if home == 1 else 1.0
    pull = pull_of_support(p, home, sigma * (x - support_position(p, home)), sigma * v)
    return only_pushes(e, p, home) and pull > 0.0


@jit
def step_of_piece(e, p, grid, step, x, v):
    """Take a step with the soft support and the friction that act at its beginning; return (x, v) at its end."""
    home = support_reached(p, x)
    in_contact = is_soft(e, p, home) and not is_let_go(e, p, home, x, v)
    stiffness, damping = coefficients(e, p, home, in_contact)
    constant = (stiffness - 1.0) * support_position(p, home) if in_contact else 0.0
    first = mean = 0.0
    if e.forcing is not None:
        second = e.second_harmonic
        first = force_value(force_at(p, 1.0, step / grid.steps, second), second)
        last = force_value(force_at(p, 1.0, (step + 1) / grid.steps, second), second)
        mean = 0.5 * (first + last)
    friction, slides = friction_of(e, p), v
    if friction > 0.0:
        if v == 0.0:
            slides = first + constant - stiffness * x
            if abs(slides) <= hold_of(e, p):
                return x, 0.0
        constant -= friction if slides > 0.0 else -friction
    dt = grid.dt
    a = piece_mean_acceleration(x, v, mean + constant, stiffness, damping, dt)
    x1, v1 = x + dt * v + 0.5 * dt * dt * a, v + dt * a
    return x1, 0.0 if friction > 0.0 and slides * v1 < 0.0 else v1


@jit
def crude(e, p, grid, periods, x, v, log, samples):
    """March whole forcing periods from phase 0 with impacts at the ends of steps.

    e : Effects; p : Parameters, without load; grid : StepGrid of `newmark_grid`; periods : int; x, v : state at
    tau = 0; log : receives each impact, and each beginning of a soft contact, at the end of its step; samples : (n,)
    receives the displacement at n equal fractions of the last period. Returns (x, v) at the end.
    """
    for period in range(periods):
        n_sampled = 0 if period == periods - 1 else samples.size
        for step in range(grid.steps):
            if e.soft is not None or e.friction is not None:
                x1, v1 = step_of_piece(e, p, grid, step, x, v)
            else:
                force_x, force_v = force_at_step(grid, step)
                x1 = grid.a11 * x + grid.a12 * v + force_x
                v1 = grid.a21 * x + grid.a22 * v + force_v
            while n_sampled < samples.size and n_sampled * grid.steps < (step + 1) * samples.size:
                theta = n_sampled * grid.steps / samples.size - step
                samples[n_sampled] = x + theta * grid.dt * (v + 0.5 * theta * (v1 - v))
                n_sampled += 1
            support = support_reached(p, x1)
            if is_soft(e, p, support):
                if support_reached(p, x) != support:
                    log_impact(log, period + (step + 1) / grid.steps, support, v1, 0.0)
            elif support > 0:
                x1 = support_position(p, support)
                if (v1 > 0.0) if support == 1 else (v1 < 0.0):
                    restitution = p.R1 if support == 1 else p.R2
                    position = period + (step + 1) / grid.steps
                    log_impact(log, position, support, v1, -(1.0 + restitution) * v1)
                    v1 = -restitution * v1
            x, v = x1, v1
    log.counts[STEPS] += periods * grid.steps
    return x, v


@jit
def crude_repeatedly(e, p, grid, periods, x, v, log, samples, n_calls):
    """March as `crude` does, `n_calls` times, each with an empty log: once for the motion, more often to time it."""
    end = x, v
    for _ in range(n_calls):
        clear_log(log)
        end = crude(e, p, grid, periods, x, v, log, samples)
    return end
