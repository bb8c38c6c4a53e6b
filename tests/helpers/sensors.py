"""Records of sensors made without the package: scipy's solve_ivp with an event for each impact."""

from __future__ import annotations

import numpy as np
from scipy.integrate import solve_ivp


def record_by_solve_ivp(
    exciter, noise, *, seed, periods=24, rate=36, settle=100, start=(0.0, 0.0), offset=0.1
):
    """Times from 0, and noisy displacements, velocities and accelerations from an unknown phase on.

    exciter : with rigid supports, f, h and delta; noise : dict of standard deviations by column; rate : samples of a
    forcing period, about; settle : forcing periods before the record
    """
    generator, period = np.random.default_rng(seed), 2 * np.pi / exciter.nu
    # The rate is no multiple of the frequency, so that samples fill the phases.
    tau = (settle + generator.uniform()) * period + np.arange(periods * rate) * 1.01 * period / rate
    x, v = motion_by_solve_ivp(exciter, tau, start)
    a = exciter.f * np.sin(exciter.nu * tau) - exciter.h * v - x
    exact = {"displacement": x, "velocity": v, "acceleration": a}
    columns = {
        name: exact[name] + offset + sigma * generator.standard_normal(tau.size)
        for name, sigma in noise.items()
    }
    return {"tau": tau - tau[0], **columns}, exciter.f * np.sin(exciter.nu * tau)


def motion_by_solve_ivp(exciter, tau, start):
    """Displacements and velocities (n,) at times (n,) of eqs. (5), (6)."""

    def rates(time, state):
        force = exciter.f * np.sin(exciter.nu * time)
        return [state[1], force - exciter.h * state[1] - state[0]]

    walls = (
        (exciter.l + exciter.delta, 1, exciter.R1),
        (exciter.delta - exciter.l, -1, exciter.R2),
    )
    events = []
    for position, direction, _restitution in walls:
        events.append(lambda _time, state, position=position: state[0] - position)
        events[-1].terminal, events[-1].direction = True, direction
    x, v = np.full(tau.size, np.nan), np.full(tau.size, np.nan)
    time, state = 0.0, np.array(start)
    while True:
        run = solve_ivp(
            rates, (time, tau[-1]), state, method="DOP853", events=events, dense_output=True,
            rtol=1e-10, atol=1e-12, max_step=0.3 / exciter.nu,
        )  # fmt: skip
        within = (tau >= time) & (tau <= run.t[-1])
        if within.any():
            x[within], v[within] = run.sol(tau[within])
        if run.status == 0:
            return x, v
        position, _direction, restitution = walls[0 if run.t_events[0].size else 1]
        time, state = run.t[-1], np.array([position, -restitution * run.y[1, -1]])
