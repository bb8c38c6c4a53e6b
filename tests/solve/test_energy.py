"""The energy balance of a motion: its terms against independent solutions, its residual against wrong contacts."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from orbit_motions import motion_of

import vibropipe as vp
from vibropipe.lab.hard_cases import smooth as independent
from vibropipe.lab.hard_cases.analytic import flights
from vibropipe.physics.effects import ALL_EFFECTS
from vibropipe.solve.motion.contacts import log_of
from vibropipe.solve.motion.energy import work_of_flights
from vibropipe.words.regimes import Regime
from vibropipe.words.vocabulary import ENERGIES, quantity

TERMS = [name for name in ENERGIES if not quantity(name).effect]
MOTIONS = independent.MOTIONS


def terms(ds: Any) -> np.ndarray:
    return np.concatenate([np.atleast_1d(ds[name].values) for name in TERMS])


def test_nothing_is_drawn_up_unasked() -> None:
    assert not set(TERMS) & set(vp.simulate(vp.Exciter(l=1.0), tau_end=1.0).variables)


def test_damping_alone_in_closed_form() -> None:
    h, tau = 0.3, 7.0
    ds = vp.simulate(vp.Exciter(l=5.0, h=h), tau_end=tau, x0=1.0, energy=True)
    w = math.sqrt(1 - h * h / 4)
    x = math.exp(-h * tau / 2) * (math.cos(w * tau) + h / (2 * w) * math.sin(w * tau))
    v = -math.exp(-h * tau / 2) * math.sin(w * tau) / w
    stored = 0.5 * (x * x + v * v - 1.0)
    assert float(ds.energy_change) == pytest.approx(stored, rel=1e-13)
    assert float(ds.energy_damping) == pytest.approx(-stored, rel=1e-13)
    assert float(ds.energy_input) == 0.0
    assert ds.energy_impact.values.tolist() == [0.0, 0.0]


@pytest.mark.parametrize("motion", MOTIONS)
def test_exact_terms_agree_with_matrix_exponentials(motion: Any) -> None:
    p, tau_end, x0, v0 = motion
    ds = vp.simulate(p, tau_end, x0, v0, samples_per_period=0, energy=True)
    work, damped = independent.flight_energy(p, *flights(p, ds, tau_end, x0, v0))
    size = abs(work) + damped + 1.0
    assert float(ds.energy_input) == pytest.approx(work, abs=1e-12 * size)
    assert float(ds.energy_damping) == pytest.approx(damped, abs=1e-12 * size)
    assert abs(float(ds.energy_residual)) < 1e-13 * size


@pytest.mark.parametrize("motion", [MOTIONS[0], MOTIONS[2], MOTIONS[4]])
def test_newmark_closes_its_balance_and_nears_the_exact_one_by_the_square(motion: Any) -> None:
    exact = terms(vp.simulate(*motion, samples_per_period=0, energy=True))
    errors = []
    for steps in (250, 1000):
        coarse = {"method": "newmark", "steps_per_period": steps}
        ds = vp.simulate(*motion, samples_per_period=0, energy=True, **coarse)
        assert abs(float(ds.energy_residual)) < 1e-12 * (abs(float(ds.energy_input)) + 1)
        errors.append(np.abs(terms(ds) - exact)[:-1].max())
    assert 10 < errors[0] / errors[1] < 25


def test_a_contact_out_of_place_opens_the_balance() -> None:
    p, tau_end, x0, v0 = MOTIONS[2]
    ds = vp.simulate(p, tau_end, x0, v0, samples_per_period=0)
    contacts = {name: ds[name].values for name in ds.data_vars if ds[name].ndim}
    turns = (0.0, tau_end / p.period)
    # An impact with a rebound: an impact without one has no velocity after to perturb.
    fastest = np.abs(contacts["impact_velocity_after"]).argmax()
    correct = work_of_flights(p, ALL_EFFECTS, (x0, v0), turns, contacts)
    for name in ("impact_tau", "impact_velocity", "impact_velocity_after"):
        wrong = {key: value.copy() for key, value in contacts.items()}
        wrong[name][fastest] *= 1 + 1e-6
        moved = work_of_flights(p, ALL_EFFECTS, (x0, v0), turns, wrong)
        residual = (moved - correct) @ [1, -1, -1, -1]
        assert abs(residual) > 1e-9, name


def test_a_motion_that_breaks_off_has_no_balance() -> None:
    ds = vp.simulate(*MOTIONS[0], max_impacts=3, energy=True)
    assert np.isnan(terms(ds)).all()


def test_an_accuracy_stands_beside_every_term() -> None:
    ds = vp.simulate(*MOTIONS[0], accuracy=1e-6, energy=True)
    for name in TERMS:
        assert (ds[f"{name}_error"].values > 0).all()
    exact = terms(vp.simulate(*MOTIONS[0], energy=True))
    bound = np.concatenate([np.atleast_1d(ds[f"{name}_error"].values) for name in TERMS])
    assert (np.abs(terms(ds) - exact) <= bound).all()


def test_a_scene_stores_the_balance_of_its_motion_beside_that_of_its_orbit(tmp_path: Any) -> None:
    from vibropipe.jobs.solving import solve_scene
    from vibropipe.study import load_study

    file = tmp_path / "balance.yaml"
    file.write_text(
        "title: t\nexciter: {l: 0.5, nu: 1, f: -1, h: 0.2, R1: 0.7, R2: 0.7}\n"
        "scenes: {run: {kind: motion, tau_end: 40, outputs: [impacts, energy]}}\n"
    )
    ds = solve_scene(load_study(file), "run")
    assert abs(float(ds.energy_residual)) < 1e-12
    assert abs(float(ds.orbit_energy_residual)) < 1e-12
    assert float(ds.energy_input) > float(ds.orbit_energy_input) > 0
    assert float(ds.orbit_energy_change) == 0.0
    assert ds.energy_input.attrs["long_name"] == "work of the force"
    per_period = "work of the force per forcing period of the steady state"
    assert quantity("orbit_energy_input").long_name == per_period


@pytest.mark.parametrize("side", [1, 2])
def test_the_tail_of_a_chatter_acts_away_from_its_support(side: int) -> None:
    sign = 1.0 if side == 1 else -1.0
    exciter = vp.Exciter(l=1.0, delta=-1.5 * sign, f=0.1 * sign, nu=0.8, R1=0.5, R2=0.5)
    ds = vp.simulate(exciter, 2.5, -0.7 * sign)
    log = log_of(exciter, {str(name): ds[name].values for name in ds.data_vars}, 1.0)
    assert (log.support == -side).any()
    assert (log.impulse * sign < 0.0).all()


def steady_energies(exciter: vp.Exciter, **options: Any) -> Any:
    return vp.steady_state(exciter, outputs=("energy", "harmonics", "impacts"), **options)


DOUBLED = vp.Exciter(l=0.5, nu=1.5, f=0.8, h=0.1, delta=0.3, R1=0.8, R2=0.8)
CHAOTIC = {
    "rigid": replace(DOUBLED, nu=2.3),
    "soft": replace(DOUBLED, nu=2.3, R1=1.0, k1=2000.0, h1=5.0, friction=0.01),
}


@pytest.mark.parametrize("name", CHAOTIC)
def test_energies_without_an_orbit_are_means_over_the_window(name: str) -> None:
    """The work is that of the first harmonic, which is by impulses; the losses balance it with what is stored."""
    exciter = CHAOTIC[name]
    ds = steady_energies(exciter)
    assert int(ds.regime) == Regime.APERIODIC
    first = ds.isel(harmonic=0)
    work = -math.pi * exciter.f * first.displacement_amplitude * np.cos(first.displacement_phase)
    assert float(ds.energy_input) == pytest.approx(float(work), rel=1e-10)
    assert abs(float(ds.energy_residual)) < 1e-11
    losses = float(ds.energy_damping + ds.energy_impact.sum() + ds.get("energy_friction", 0.0))
    assert losses + float(ds.energy_change) == pytest.approx(float(ds.energy_input), abs=1e-11)
    # At most the energy of the fastest impact, over 128 periods.
    assert 0 < abs(float(ds.energy_change)) < 0.02 * float(ds.energy_input)
    assert (ds.energy_impact > 0).all()


def test_a_motion_that_grows_stores_what_it_is_given() -> None:
    """Without losses, at resonance: the energies of the window are those of the same motion by `simulate`."""
    exciter = vp.Exciter(l=1e9, delta=1e9, nu=2.0, f=1.0)
    ds = steady_energies(exciter)
    end, window = int(ds.periods_to_settle), int(ds.window_periods)
    assert window > 0
    start = vp.simulate(exciter, (end - window) * exciter.period, samples_per_period=0)
    motion = vp.simulate(
        exciter,
        window * exciter.period,
        float(start.displacement_end),
        float(start.velocity_end),
        samples_per_period=0,
        energy=True,
    )
    for term in ("energy_input", "energy_change"):
        mine, expected = float(ds[term]), float(motion[term]) / window
        assert mine == pytest.approx(expected, rel=1e-6)
    assert ds.energy_impact.values.tolist() == [0.0, 0.0]


def test_energies_are_per_forcing_period_of_orbits_of_several() -> None:
    ds = steady_energies(DOUBLED)
    m = int(ds.period_multiple)
    assert m > 1
    motion = motion_of(DOUBLED, ds, energy=True)
    for term in ("energy_input", "energy_damping", "energy_impact"):
        np.testing.assert_allclose(m * ds[term].values, motion[term].values, rtol=1e-9)
    assert ds.energy_input.attrs["long_name"] == "work of the force per forcing period"
    with_units = vp.to_physical(motion, 2.0, 8.0)
    assert with_units.energy_input.attrs["long_name"] == "work of the force"
