"""Hard cases of the energy balance: work of the force = damping + losses at the supports + stored energy."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from vibropipe.lab.hard_cases.analytic import Floats, add_force, flights, propagators, rests_of
from vibropipe.lab.hard_cases.case import Solver, end_state, largest_error
from vibropipe.physics.exciter import Exciter

if TYPE_CHECKING:
    import xarray as xr

NODES, WEIGHTS = np.polynomial.legendre.leggauss(12)
MOTIONS = (
    (Exciter(nu=1.0, f=-1.0, h=0.2, l=0.5, R1=0.7, R2=0.7), 40.0, 0.1, 1.0),
    (Exciter(nu=1.3, f=2.0, h=0.0, l=0.5, delta=0.1, R1=0.5, R2=0.9), 40.0, 0.0, 0.0),
    (Exciter(nu=0.4, f=1.5, h=0.1, l=0.5, R1=0.3, R2=0.0), 40.0, 0.0, 0.0),
    (Exciter(nu=2.5, f=6.0, h=0.05, l=0.5, delta=0.6, R1=0.8, R2=0.8), 40.0, 0.2, 0.0),
    (Exciter(nu=1.0, f=0.4, h=2.0, l=9.0), 40.0, 1.0, 0.0),
)


def flight_energy(exciter: Exciter, starts: Floats, ends: Floats) -> tuple[float, float]:
    """Return work of the force and damping loss over flights of the exact motion, by Gauss quadrature."""
    spans = ends[:, 0] - starts[:, 0]
    pieces = max(1, math.ceil(float(spans.max(initial=0.0)) * max(1.0, exciter.nu, exciter.h)))
    propagator = propagators(exciter, spans / pieces)
    to_nodes = [propagators(exciter, spans / pieces * (0.5 + 0.5 * node)) for node in NODES]
    states = add_force(exciter, starts)
    work = loss = 0.0
    for _ in range(pieces):
        for weight, to_node in zip(WEIGHTS, to_nodes, strict=True):
            _, v, force, _ = np.einsum("nij,nj->in", to_node, states)
            weights = 0.5 * weight * spans / pieces
            work += float(np.sum(weights * force * v))
            loss += float(np.sum(weights * exciter.h * v * v))
        states = np.einsum("nij,nj->ni", propagator, states)
    return work, loss


def step_energy(exciter: Exciter, motion: xr.Dataset) -> tuple[float, float]:
    """Return work of the force and damping loss of Newmark's steps, from samples at their ends and contacts.

    A step of constant average acceleration satisfies its own balance with its mean force times its displacement.
    """
    support_x = {1: exciter.upper, 2: exciter.lower}
    columns = ("impact_tau", "impact_support", "impact_velocity", "impact_velocity_after")
    samples = (motion[name].values for name in ("tau", "displacement", "velocity"))
    nodes = list(zip(*samples, strict=True))
    for tau, support, before, after in zip(*(motion[n].values for n in columns), strict=True):
        nodes += [(tau, support_x[int(support)], v) for v in (before, after)]
    for start, end, support in rests_of(motion):
        nodes += [
            (at, support_x[support], 0.0) for at in (start, end) if at < float(motion["tau"][-1])
        ]
    tau, x, v = np.array(sorted(nodes, key=lambda node: node[0])).T
    force, path = exciter.f * np.sin(exciter.nu * tau), np.diff(x)
    work = 0.5 * (force[1:] + force[:-1]) * path
    return float(np.sum(work)), float(np.sum(0.5 * exciter.h * (v[1:] + v[:-1]) * path))


@largest_error
def balance(solver: Solver) -> Iterator[float]:
    """Largest residual of the balance of a motion, relative to all energy supplied and stored."""
    for exciter, tau_end, x0, v0 in MOTIONS:
        motion = solver.motion(exciter, tau_end, x0, v0, samples_per_period=solver.steps or 0)
        if solver.steps is None:
            work, damped = flight_energy(exciter, *flights(exciter, motion, tau_end, x0, v0))
        else:
            work, damped = step_energy(exciter, motion)
        lost = motion["impact_velocity"].values ** 2 - motion["impact_velocity_after"].values ** 2
        at_supports = 0.5 * float(np.sum(lost))
        x, v = end_state(motion)
        stored = 0.5 * (x * x + v * v - x0 * x0 - v0 * v0)
        residual = work - damped - at_supports - stored
        yield abs(residual) / (abs(work) + damped + at_supports + abs(stored))


@largest_error
def balance_of_orbits(solver: Solver) -> Iterator[float]:
    """Largest residual of the balance of an orbit, relative to the work of the force."""
    for exciter, _, _, _ in MOTIONS[:3]:
        orbit = solver.solve_steady(exciter)
        yield abs(float(orbit["energy_residual"]) / float(orbit["energy_input"]))
