"""Hard cases of motion between impacts: energy, growth, neighbours of resonance, scales, long times,
and energy balances against independent solutions."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from fractions import Fraction
from typing import TYPE_CHECKING

import numpy as np

from vibropipe.lab.hard_cases.analytic import (
    Floats,
    add_force,
    effective_frequency,
    flights,
    linear_end,
    propagators,
    response,
    rests_of,
)
from vibropipe.lab.hard_cases.case import Solver, end_state, expect, largest_error
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


TURN = 2.0 * math.pi
EXACT_TURN = "6.28318530717958647692528676655900576839433879875"
IMPACTS = 1_000_000
PERIODS = 1_000_000
MAX_STEPS = 100_000_000


def keeps_energy(solver: Solver, f: float) -> float:
    """Largest relative error of the energy over a million ideal impacts under force f.

    The exact motion starts at x = 0, x' = -0.51, as that of the paper. A march multiplies by the same rounded matrix at
    every step, so its error grows by 4.2e-16 for each impact of this motion. Newmark's method would take a minute: its
    motions are faster, with flights that are longer than its step.
    """
    half_flight = math.asin(0.5 / 0.51)
    if solver.steps is not None:
        half_flight = max(0.05, 1.25 * TURN / solver.steps)
    speed = 0.5 / math.sin(half_flight)
    motion = solver.motion(
        Exciter(l=0.5, nu=1.0, f=f), 1.01 * IMPACTS * 2.0 * half_flight, v0=-speed
    )
    expect(motion.sizes["impact"] >= IMPACTS * (1.0 if solver.steps is None else 0.9))
    energy = 0.25 + motion["impact_velocity"].values ** 2
    return float(np.max(np.abs(energy / speed**2 - 1.0)))


def end_error(
    solver: Solver, exciter: Exciter, tau_end: float, expected: tuple[float, float]
) -> float:
    """Error of (x, x') at the end of the motion from rest, relative to the magnitude of the expected state."""
    x, v = end_state(solver.motion(exciter, tau_end))
    return math.hypot(x - expected[0], v - expected[1]) / math.hypot(*expected)


def grows_at_resonance(solver: Solver) -> float:
    """Error after 50 periods, relative to the size of x = (sin tau - tau cos tau)/2, or of newmark's own state."""
    tau, exciter = 50.0 * TURN, Exciter(l=1e9, nu=1.0, f=1.0)
    expected = 0.5 * (math.sin(tau) - tau * math.cos(tau)), 0.5 * tau * math.sin(tau)
    if solver.steps is not None:
        expected = linear_end(exciter, 50, solver.steps)
    return end_error(solver, exciter, tau, expected)


def grows_by_impacts(solver: Solver) -> float:
    """Error of the impact velocities 4n/3, n = 1 to 1000: support at the equilibrium, nu = 2, no loss."""
    exciter = Exciter(l=1e9, delta=1e9, nu=2.0, f=1.0)
    count = 1000 if solver.steps is None else 20
    motion = solver.motion(exciter, (count + 0.5) * math.pi)
    expected = -4.0 / 3.0 * np.arange(1, count + 1)
    expect(motion.sizes["impact"] == count)
    return float(np.max(np.abs(motion["impact_velocity"].values / expected - 1.0)))


@largest_error
def linear_check(solver: Solver, exciters: Sequence[Exciter], periods: int) -> Iterator[float]:
    """Error of (x, x') after `periods` forcing periods, relative to their magnitude."""
    for exciter in exciters:
        yield end_error(
            solver, exciter, periods * TURN / exciter.nu, linear_end(exciter, periods, solver.steps)
        )


@largest_error
def scales(solver: Solver) -> Iterator[float]:
    """Deviation of a motion scaled in length by powers of 2 from the scaled motion."""
    base = {"nu": 1.0, "h": 0.2, "R1": 0.7, "R2": 0.7}
    motion = solver.motion(Exciter(**base, l=0.5, f=-1.0, delta=0.01), 40.0)
    for exponent in (-1000, -300, -30, 30, 300, 500):
        scale = 2.0**exponent
        exciter = Exciter(**base, l=0.5 * scale, f=-scale, delta=0.01 * scale)
        scaled = solver.motion(exciter, 40.0)
        for name, size in (
            ("impact_velocity", scale),
            ("impact_tau", 1.0),
            ("displacement_end", scale),
        ):
            expect(motion[name].shape == scaled[name].shape)
            error = np.abs(scaled[name].values / size - motion[name].values)
            yield float(np.max(error, initial=0.0))


@largest_error
def holds_phase(solver: Solver) -> Iterator[float]:
    """Phase error of the steady linear motion after a million periods (newmark: as many as 1e8 steps allow)."""
    periods = PERIODS if solver.steps is None else min(PERIODS, MAX_STEPS // solver.steps)
    for nu in (1.0, 0.7, math.sqrt(3.0)):
        exciter, tau = Exciter(nu=nu, f=0.3, h=0.3, l=2.0), periods * TURN / nu
        x, v = end_state(solver.motion(exciter, tau))
        # tau has 53 bits: its distance to whole periods, in exact arithmetic
        offset = float(Fraction(tau) * Fraction(nu) - periods * Fraction(EXACT_TURN))
        frequency = effective_frequency(exciter, solver.steps)
        amplitude = response(exciter, solver.steps)
        amplitude *= complex(math.cos(offset), math.sin(offset))
        yield math.hypot(x - amplitude.imag, v / frequency - amplitude.real) / abs(amplitude)


NEUTRAL = [
    Exciter(nu=1.0 + off, f=0.2, l=1e3) for off in (0, 1e-6, -1e-6, 1e-9, -1e-9, 1e-12, -1e-12)
]
CRITICAL = [Exciter(nu=0.8, f=3.0, h=2.0 + off, l=1e3) for off in (0.0, 1e-6, -1e-6, 1e-12, -1e-12)]
BASE = {"nu": 1.0, "f": -1.0, "h": 0.2, "l": 0.5, "R1": 0.7, "R2": 0.7}
DAMPED = [
    (Exciter(nu=1.0, f=0.2, l=2.0, h=1e-12, R1=0.9, R2=0.9), 60.0, 0.0, 0.0),
    (Exciter(nu=1.0, f=0.2, l=2.0, h=0.0, R1=0.9, R2=0.9), 60.0, 0.0, 0.0),
    (Exciter(nu=0.8, f=3.0, h=2.0, l=0.5, R1=0.3, R2=0.3), 60.0, 0.0, 0.0),
    (Exciter(nu=0.8, f=3.0, h=2.0 + 1e-12, l=0.5, R1=0.3, R2=0.3), 60.0, 0.0, 0.0),
    (Exciter(nu=1.0, f=100.0, l=0.5, h=50.0, R1=0.4, R2=0.4), 60.0, 0.0, 0.0),
    (Exciter(nu=1.0, f=2e4, l=0.5, h=1e4, R1=0.4, R2=0.4), 12.0, 0.0, 0.0),
]
EXTREME = [
    (Exciter(**BASE | {"nu": 1e4}), 20 * TURN / 1e4, 0.1, 1.0),
    (Exciter(**BASE | {"nu": 1e4, "f": 1e8}), 10 * TURN / 1e4, 0.1, 1.0),
    (Exciter(**BASE | {"f": 0.0}), 20.0, 0.2, 3.0),
    (Exciter(**BASE | {"f": 1e-300}), 20.0, 0.2, 3.0),
    (Exciter(**BASE | {"f": 1e6, "nu": 1e3}), 20 * TURN / 1e3, 0.0, 0.0),
    (Exciter(**BASE | {"l": 1e-9, "f": -2e-9}), 40.0, 0.0, 0.0),
    (Exciter(**BASE | {"l": 1e9, "f": -2e9}), 40.0, 0.0, 0.0),
]
OFFSET = [
    (Exciter(**BASE | {"delta": 0.5}), 40.0, 0.0, 0.0),
    (Exciter(**BASE | {"delta": -0.5}), 40.0, 0.0, 0.0),
    (Exciter(**BASE | {"delta": 0.8, "R1": 0.5, "R2": 0.5}), 40.0, 0.5, 0.0),
    (Exciter(**BASE | {"delta": -0.8, "R1": 0.5, "R2": 0.5}), 40.0, -0.5, 0.0),
    (Exciter(**BASE | {"delta": 50.0, "f": 60.0, "R2": 0.5}), 40.0, 50.0, 0.0),
]
SLOW = [(Exciter(**BASE | {"nu": 1e-4, "R1": 0.4, "R2": 0.4}), 2 * TURN / 1e-4, 0.0, 0.0)]
