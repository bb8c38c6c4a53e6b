"""Steady states with soft supports and friction: derivative, harmonics and energies from the pieces of an orbit."""

from __future__ import annotations

import numpy as np
import pytest

import vibropipe as vp
from vibropipe.march.grid import Instant, exact_grid, grid_time
from vibropipe.march.log import new_log
from vibropipe.march.loop import march
from vibropipe.march.piece_log import CAUSE, PIECES, piece_log_of
from vibropipe.march.piece_state import start_state
from vibropipe.orbits.forces import Integrals
from vibropipe.orbits.pieces import add_harmonics_of_pieces, integrate_piece, jacobian_of_pieces
from vibropipe.orbits.return_map import state_xv
from vibropipe.physics.effects import all_effects
from vibropipe.physics.flow import DEGREE
from vibropipe.words.status import Status

BASE = {"l": 0.5, "nu": 1.0, "f": -1.0, "h": 0.2, "R1": 0.7, "R2": 0.7}
# by what their orbits are made of: contacts; a rigid and a soft support; turns; sticks; all
CASES = {
    "soft": {"k1": 400.0, "h1": 4.0, "k2": 400.0, "h2": 4.0, "delta": 0.01, "R1": 1.0, "R2": 1.0},
    "one_soft": {"R2": 1.0, "k2": 30.0, "h2": 1.0, "delta": 0.05},
    "turns": {"friction": 0.05, "f": 0.2, "nu": 2.0},
    "sticks": {"friction": 0.35, "nu": 0.6, "f": 0.7, "h": 0.05},
    "slips with a jump": {"friction": 0.25, "friction_ratio": 1.5, "nu": 0.6, "f": 0.7, "h": 0.05},
    "no_pull": {
        "R1": 1.0,
        "k1": 90.0,
        "h1": 6.0,
        "R2": 1.0,
        "k2": 300.0,
        "h2": 4.0,
        "contact_1": 1,
        "contact_2": 1,
    },
    "reload": {"R2": 1.0, "k2": 25.0, "h2": 5.0, "contact_2": 1, "load": -2.6, "nu": 4.0, "f": 2.9},
    "both": {"R1": 1.0, "k1": 200.0, "h1": 2.0, "friction": 0.08, "delta": -0.05},
}
OUTPUTS = ("harmonics", "impacts", "stability", "energy", "motion", "subharmonics")


def exciter(case: str) -> vp.Exciter:
    """Return the exciter of a case."""
    return vp.Exciter(**{**BASE, **CASES[case]})


def two_periods(case: str, x: float, v: float) -> tuple:
    """Return effects, parameters, the log and the end (x, v) of a march over two forcing periods."""
    p = exciter(case).parameters()
    e = all_effects(p._asdict(), pieces=True)
    grid, (pieces, plain) = exact_grid(e, p), piece_log_of(e, 500)
    log = new_log(100, 100, pieces, plain)
    state = start_state(pieces, e, p, grid, 0.0, x, v, 0.0)
    end = Instant(2, 0, 0.0)
    after, status = march(e, p, grid, state, end, log, None, np.empty(DEGREE + 1), 1000)
    assert status == Status.OK
    return e, p, log, state_xv(p, after)


@pytest.mark.parametrize("case", CASES)
def test_the_jacobian_is_the_derivative_of_the_motion(case: str) -> None:
    x, v, step = 0.05, -0.3, 1e-7
    e, p, log, _end = two_periods(case, x, v)
    columns = []
    for dx, dv in ((step, 0.0), (0.0, step)):
        ends = [np.array(two_periods(case, x + s * dx, v + s * dv)[3]) for s in (1.0, -1.0)]
        columns.append((ends[0] - ends[1]) / (2.0 * step))
    jacobian = np.reshape(jacobian_of_pieces(e, p, log.pieces), (2, 2))
    assert np.allclose(jacobian, np.array(columns).T, rtol=1e-6, atol=1e-7)


@pytest.mark.parametrize("case", CASES)
def test_harmonics_in_closed_form_are_those_by_quadrature(case: str) -> None:
    e, p, log, _end = two_periods(case, 0.05, -0.3)
    closed, work, quadrature = (np.zeros(5, complex) for _ in range(3))
    add_harmonics_of_pieces(e, p, log.pieces, np.int64(2), closed, work)
    sums = Integrals(np.zeros(5), np.zeros(0), quadrature, np.int64(2))
    for i in range(int(log.pieces.counts[PIECES])):
        integrate_piece(e, p, log.pieces, i, sums)
    assert abs(closed - quadrature).max() < 1e-14


@pytest.mark.parametrize("case", CASES)
def test_an_orbit_repeats_balances_and_has_its_harmonics(case: str) -> None:
    orbit = vp.steady_state(exciter(case), outputs=OUTPUTS, harmonics=3)
    m = int(orbit["period_multiple"])
    assert m > 0
    assert float(orbit["residual"]) < 1e-13
    assert abs(float(orbit["energy_residual"])) < 1e-13
    assert bool(orbit["stable"])
    spectrum = np.fft.fft(orbit["displacement"].values) / orbit.sizes["phase"]
    amplitudes = 2.0 * np.abs(spectrum[m * np.arange(1, 4)])
    assert np.allclose(orbit["displacement_amplitude"], amplitudes, rtol=0.0, atol=1e-4)
    loss = float(orbit["energy_friction"])
    assert (loss > 0.0) == (exciter(case).friction > 0.0)
    # a long motion arrives at the orbit
    turns = 60 * m
    motion = vp.simulate(exciter(case), turns * exciter(case).period, samples_per_period=0)
    assert abs(float(motion["displacement_end"] - orbit["displacement_strobe"])) < 1e-8


def test_a_mass_that_friction_holds_for_ever_is_an_orbit_without_impacts() -> None:
    orbit = vp.steady_state(vp.Exciter(l=0.5, nu=1.0, f=0.2, friction=0.3), x0=0.05)
    assert (int(orbit["period_multiple"]), float(orbit["displacement_strobe"])) == (1, 0.05)


def test_a_sweep_over_friction_and_stiffness_has_the_rows_of_single_states() -> None:
    over = {"friction": [0.0, 0.1], "k1": [0.0, 300.0]}
    base = vp.Exciter(**BASE)
    sweep = vp.sweep(base, over, outputs=("harmonics", "impacts"))
    plain = vp.steady_state(base, outputs=("harmonics", "impacts"), harmonics=3)
    # without both the row is that of the plain kernel, to rounding
    first = sweep.isel(friction=0, k1=0)
    assert (
        float(abs(first["displacement_amplitude"] - plain["displacement_amplitude"]).max()) < 1e-12
    )
    single = vp.steady_state(
        vp.Exciter(**BASE, k1=300.0, friction=0.1), outputs=("harmonics",), harmonics=3
    )
    last = sweep.isel(friction=1, k1=1)
    assert (last["displacement_amplitude"].values == single["displacement_amplitude"].values).all()


def test_events_of_a_march_cut_in_two_are_those_of_the_whole() -> None:
    case, x, v = "both", 0.05, -0.3
    _e, _p, whole, end = two_periods(case, x, v)
    p = exciter(case).parameters()
    e = all_effects(p._asdict(), pieces=True)
    grid, (pieces, plain) = exact_grid(e, p), piece_log_of(e, 500)
    log, c = new_log(100, 100, pieces, plain), np.empty(DEGREE + 1)
    state = start_state(pieces, e, p, grid, 0.0, x, v, 0.0)
    for turns in np.linspace(0.0, 2.0, 30)[1:]:
        state, status = march(e, p, grid, state, grid_time(turns, grid.steps), log, None, c, 1000)
        assert status == Status.OK
    assert np.allclose(state_xv(p, state), end, rtol=0.0, atol=1e-13)
    causes = [q.codes[: int(q.counts[PIECES]), CAUSE] for q in (log.pieces, whole.pieces)]
    assert causes[0][causes[0] > 0].tolist() == causes[1][causes[1] > 0].tolist()
    assert np.allclose(
        pieces.leaves[: pieces.counts[1]], whole.pieces.leaves[: pieces.counts[1]], rtol=1e-12
    )
