"""Error estimates of motions with soft supports, friction and two harmonics of the force, against 40 digits."""

from __future__ import annotations

import math
from decimal import Decimal
from typing import Any

import numpy as np
import pytest

import vibropipe as vp
from vibropipe.lab.reference_solver import ReferenceSolver

# Speed below which impacts belong to a chatter, of which the exact method completes the last ones in one piece.
SLOWEST = 1e-4


def random_motion(seed: int) -> tuple[vp.Exciter, float, float, float]:
    """Draw an exciter, a start and an end."""
    draw = np.random.default_rng([7, seed])
    values: dict[str, float] = {}
    for i in "12":
        k = draw.choice([0.0, 10 ** draw.uniform(0, 5)], p=[0.35, 0.65])
        values |= {f"k{i}": k, f"h{i}": 2.0 * math.sqrt(k) * draw.uniform(0, 1.2)}
    for name, low, high in (("friction", 0.01, 0.5), ("f2", -0.8, 0.8), ("load", -0.2, 0.2)):
        values[name] = draw.choice([0.0, draw.uniform(low, high)])
    if values["k1"] + values["k2"] == 0.0:
        values["friction"] = 0.2
    ranges = {"nu": (0.3, 3), "f": (-1.5, 1.5), "h": (0, 0.4), "delta": (-0.4, 0.4)}
    ranges |= {"R1": (0.2, 0.95), "R2": (0.2, 0.95), "phi2": (-3, 3)}
    values |= {name: draw.uniform(*ends) for name, ends in ranges.items()}
    values |= {
        f"R{i}": 1.0 for i in "12" if values[f"k{i}"] > 0.0
    }  # a soft support has its own damping
    exciter = vp.Exciter(l=0.5, **values)
    x0 = draw.uniform(exciter.lower, exciter.upper)
    return exciter, float(draw.uniform(3, 8)), float(x0), float(draw.uniform(-1, 1))


def largest_ratio(seed: int) -> float:
    """Return the largest ratio of a true error to its estimate; inf if events differ."""
    exciter, tau_end, x0, v0 = random_motion(seed)
    ds = vp.simulate(exciter, tau_end, x0, v0, accuracy=1e-8, samples_per_period=0, energy=True)
    exact = ReferenceSolver(exciter).run(x0, v0, [Decimal(tau_end)])
    ratios = [abs(float(ds.energy_residual)) / float(ds.energy_residual_error)]

    def compare(name: str, wanted: list[Any], at: np.ndarray) -> None:
        found, errors = (np.atleast_1d(ds[each].values)[at] for each in (name, f"{name}_error"))
        if found.size != len(wanted):
            ratios.append(math.inf)
            return
        for one, other, error in zip(found, wanted, errors, strict=True):
            ratios.append(abs(float(Decimal(float(one)) - other)) / error)

    once = np.ones(1, bool)
    compare("displacement_end", [exact.states[0][0]], once)
    compare("velocity_end", [exact.states[0][1]], once)
    impacts = [e for e in exact.events if e[1] in ("in", "impact") and abs(e[3]) > SLOWEST]
    is_fast = np.abs(ds.impact_velocity.values) > SLOWEST
    compare("impact_tau", [event[0] for event in impacts], is_fast)
    compare("impact_velocity", [event[3] for event in impacts], is_fast)
    for kind, name in (("stick", "stick_start"), ("slip", "stick_end")):
        if name in ds:
            times = [event[0] for event in exact.events if event[1] == kind]
            compare(name, times, np.isfinite(ds[name].values))
    return max(ratios)


@pytest.mark.parametrize("seed", [0, 3, 5, 8])
def test_errors_hold(seed: int) -> None:
    assert largest_ratio(seed) < 1.0


@pytest.mark.slow
def test_errors_hold_for_500_motions() -> None:
    ratios = np.array([largest_ratio(seed) for seed in range(500)])
    assert np.count_nonzero(ratios > 1.0) <= 2
    assert (ratios[np.isfinite(ratios)] < 30.0).all()


def test_every_contact_has_its_errors() -> None:
    exciter = vp.Exciter(l=0.5, nu=1.0, f=-1.0, h=0.2, R1=0.7, k2=300.0, h2=3.0, friction=0.15)
    ds = vp.simulate(exciter, 20.0, accuracy=1e-8)
    assert ds.attrs["method"] == "exact"
    assert ds.attrs["accuracy_reached"] < 1e-12
    for name in ("contact_duration", "contact_force_max", "contact_depth_max"):
        ended = np.isfinite(ds[name].values)
        errors = ds[f"{name}_error"].values
        assert (np.isfinite(errors) == ended).all()
        assert (errors[ended] < 1e-11).all()
        assert (errors[ended] > 0.0).all()
    for name in ("turn_tau", "stick_start", "velocity"):
        assert float(ds[f"{name}_error"].max()) < 1e-11
