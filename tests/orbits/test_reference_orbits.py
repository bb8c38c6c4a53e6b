"""Agreement with the 20-digit reference orbits: harmonics, phases, energies, multipliers."""

from __future__ import annotations

import itertools
import math
from typing import Any

import numpy as np
import pytest
from comparisons import determinant, parameters_of, reference
from oracles import Oracle
from textbook import Parameters

import vibropipe as vp
from vibropipe.words.regimes import Regime

ORBITS = reference("steady")


@pytest.mark.parametrize("name", ORBITS)
def test_orbit(name: str) -> None:
    entry = ORBITS[name]
    ds = vp.steady_state(vp.Exciter(**parameters_of(entry)._asdict()))
    assert int(ds.period_multiple) == entry["period_multiple"]
    assert int(ds.regime) == Regime.TWO_SIDED
    assert ds.impacts_per_orbit.values.tolist() == [1, 1]

    def near(what: str, want: Any) -> None:
        want = np.array(want, dtype=float)
        np.testing.assert_allclose(ds[what].values, want, rtol=0, atol=1e-9, err_msg=what)

    near("displacement_mean", entry["x_mean"])
    near("velocity_mean", entry["v_mean"])
    near("displacement_amplitude", entry["x_amplitude"])
    near("velocity_amplitude", entry["v_amplitude"])
    near("displacement_strobe", entry["x_strobe"])
    near("velocity_strobe", entry["v_strobe"])
    near("impact_phase", [i["phase"] for i in entry["impacts"]])
    near("impact_support", [i["support"] for i in entry["impacts"]])
    near("impact_velocity", [i["velocity_before"] for i in entry["impacts"]])
    multipliers = sorted(complex(float(a), float(b)).real for a, b in entry["multipliers"])
    multipliers_found = np.sort_complex(ds.floquet_multiplier.values)
    np.testing.assert_allclose(multipliers_found, multipliers, rtol=0, atol=1e-9)
    assert abs(float(ds.residual)) < 1e-12


class Quadrature:
    """Gauss nodes and weights over one forcing period of the oracle's orbit, flight by flight."""

    def __init__(self, entry: dict[str, Any]) -> None:
        p = parameters_of(entry)
        self.period = 2 * math.pi / p.nu
        motion = Oracle(p).run(self.period, entry["x_strobe"], entry["v_strobe"])
        cuts = [0.0, *(float(i.tau) for i in motion.impacts), self.period]
        nodes, weights = np.polynomial.legendre.leggauss(30)
        pairs = list(itertools.pairwise(cuts))
        self.tau = np.concatenate([a + (b - a) * (nodes + 1) / 2 for a, b in pairs])
        self.weight = np.concatenate([(b - a) / 2 * weights for a, b in pairs])
        self.states = np.array([[float(part) for part in motion.state(t)] for t in self.tau]).T
        self.impacts = motion.impacts


@pytest.mark.parametrize("name", ORBITS)
def test_phases_of_harmonics(name: str) -> None:
    p, over = parameters_of(ORBITS[name]), Quadrature(ORBITS[name])
    ds = vp.steady_state(vp.Exciter(**p._asdict()))
    k = np.arange(1, 7)[:, None]
    waves = np.exp(-1j * k * p.nu * over.tau) * over.weight * 2 / over.period
    for quantity, values in zip(("displacement", "velocity"), over.states, strict=True):
        amplitudes = ds[f"{quantity}_amplitude"].values * np.exp(
            1j * ds[f"{quantity}_phase"].values
        )
        np.testing.assert_allclose(amplitudes, waves @ values, rtol=0, atol=1e-9)


@pytest.mark.parametrize("name", ORBITS)
def test_energy_of_an_orbit(name: str) -> None:
    """Work of the force, loss by damping and losses at the supports, each by its own integral or sum."""
    p, over = parameters_of(ORBITS[name]), Quadrature(ORBITS[name])
    ds = vp.steady_state(vp.Exciter(**p._asdict()))
    velocity = over.states[1]
    work = over.weight @ (p.f * np.sin(p.nu * over.tau) * velocity)
    lost = [
        sum(float(i.before**2 - i.after**2) / 2 for i in over.impacts if i.support == k)
        for k in (1, 2)
    ]
    m, damped = int(ds.period_multiple), p.h * over.weight @ velocity**2
    assert float(ds.energy_input) == pytest.approx(work / m, abs=1e-10)
    assert float(ds.energy_damping) == pytest.approx(damped / m, abs=1e-10)
    np.testing.assert_allclose(ds.energy_impact.values, np.divide(lost, m), rtol=0, atol=1e-10)
    assert float(ds.energy_change) == 0.0
    assert abs(float(ds.energy_residual)) < 1e-12


SETTLING = [
    *(parameters_of(entry) for entry in ORBITS.values()),
    Parameters(l=0.5, nu=2.2, f=0.8, h=0.2, delta=0.5, R1=0.7, R2=0.7),
    Parameters(l=0.5, nu=1.3, f=0.9, h=0.2, delta=0.7, R1=0.7, R2=0.7),
    Parameters(l=1.0, nu=1.7, f=0.4, h=0.05, delta=-0.3, R1=0.5, R2=0.9),
    Parameters(l=1.0, nu=0.9, f=0.05, h=0.1),
    Parameters(l=0.5, nu=0.8, f=3.0, h=2.0, R1=0.7, R2=0.7),
    Parameters(l=0.5, nu=0.7, f=1.2, h=0.2, R1=0.0, R2=0.0),
]


@pytest.mark.parametrize("p", SETTLING)
def test_determinant_of_the_return_map(p: Parameters) -> None:
    """exp(-h T) prod R_i^2, or 0 after a rest."""
    ds = vp.steady_state(vp.Exciter(**p._asdict()), x0=max(0.0, p.lower))
    m = int(ds.period_multiple)
    assert m > 0
    struck_1, struck_2 = ds.impacts_per_orbit.values
    want = 0.0 if ds.rests_per_orbit.values.any() else determinant(p, m, (struck_1, struck_2))
    assert abs(np.prod(ds.floquet_multiplier.values) - want) <= 1e-10
