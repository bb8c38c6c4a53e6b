"""Lyapunov exponents, and how perturbations grow from period to period."""

from __future__ import annotations

import math

import numpy as np
import pytest
import xarray as xr
from scipy.linalg import expm

import vibropipe as vp
from vibropipe.lab.bench_items import limit_threads
from vibropipe.march.grid import exact_grid
from vibropipe.march.log import RESTS, clear_log, new_log
from vibropipe.march.state import initial_state
from vibropipe.orbits.growth import (
    BLOCK_PERIODS,
    EXPONENT_PERIODS,
    period_jacobian,
    perturbation_growth,
)
from vibropipe.orbits.housing_jacobian import no_coupling
from vibropipe.orbits.return_map import at_period_zero, march_periods, return_map_jacobian
from vibropipe.physics.effects import ALL_EFFECTS
from vibropipe.physics.exciter import Parameters
from vibropipe.physics.flow import DEGREE
from vibropipe.solve.sweep.blocks import assemble, solve_shard
from vibropipe.solve.sweep.sweep import grid_of

OUTPUTS = ("stability", "poincare", "lyapunov")
LOSSY = {"l": 0.5, "h": 0.2, "R1": 0.7, "R2": 0.7}
CHAOTIC = [
    vp.Exciter(nu=1.2, f=1.4, delta=0.01, **LOSSY),
    vp.Exciter(nu=0.7, f=1.9, **LOSSY),
    vp.Exciter(nu=1.2, f=1.0, l=0.5, h=0.05, R1=0.6, R2=0.6),
]


def sections(exciter: vp.Exciter, patience: int) -> tuple[np.ndarray, xr.Dataset]:
    """Return the states (x, x') before and after the last EXPONENT_PERIODS, and the motion."""
    earlier, motion = (
        vp.steady_state(exciter, outputs=OUTPUTS, patience=given)
        for given in (patience - EXPONENT_PERIODS + 63, patience)
    )
    first, last = (
        np.stack([each.poincare_displacement.values, each.poincare_velocity.values], axis=1)
        for each in (earlier, motion)
    )
    assert int(motion.period_multiple) == 0
    assert int(motion.periods_to_settle) == patience
    shift = EXPONENT_PERIODS - 63
    assert (first[shift:] == last[:-shift]).all()
    return np.concatenate([first, last[-shift:]]), motion


def carried(exciter: vp.Exciter, state: np.ndarray) -> np.ndarray:
    """Return the state a forcing period later."""
    end = vp.simulate(
        exciter, tau_end=exciter.period, samples_per_period=0, x0=state[0], v0=state[1]
    )
    return np.array([float(end.displacement_end), float(end.velocity_end)])


def jacobian(exciter: vp.Exciter, state: np.ndarray) -> np.ndarray:
    """Return the derivative of the return map by matrix exponentials and the jumps at its impacts."""
    motion = vp.simulate(
        exciter, tau_end=exciter.period, samples_per_period=0, x0=state[0], v0=state[1]
    )
    flow = np.array([[0.0, 1.0], [-1.0, -exciter.h]])
    whole, before = np.eye(2), 0.0
    for tau, support, v in zip(
        motion.impact_tau.values, motion.impact_support.values, motion.impact_velocity.values,
        strict=True,
    ):  # fmt: skip
        x, R = (exciter.upper, exciter.R1) if support == 1 else (exciter.lower, exciter.R2)
        pull = exciter.f * math.sin(exciter.nu * tau) - x
        shear = ((pull + R * exciter.h * v) + R * (pull - exciter.h * v)) / v
        whole = np.array([[-R, 0.0], [shear, -R]]) @ expm(flow * (tau - before)) @ whole
        before = tau
    return expm(flow * (exciter.period - before)) @ whole


@pytest.mark.parametrize("exciter", CHAOTIC)
@pytest.mark.parametrize("patience", [300, 313])
def test_exponent_and_its_error_are_those_of_a_qr_product(
    exciter: vp.Exciter, patience: int
) -> None:
    states, motion = sections(exciter, patience)
    q, growths, sums = np.eye(2), [], []
    for state in states[:-1]:
        whole = jacobian(exciter, state)
        q, r = np.linalg.qr(whole @ q)
        growths.append(math.log(abs(r[0, 0])))
        sums.append(np.log(np.abs(np.diag(r))).sum() - math.log(abs(np.linalg.det(whole))))
    np.testing.assert_allclose(sums, 0.0, atol=1e-8)
    blocks = np.reshape(growths[BLOCK_PERIODS:], (-1, BLOCK_PERIODS)).mean(axis=1) / exciter.period
    assert len(growths) == EXPONENT_PERIODS
    assert float(motion.lyapunov_exponent) == pytest.approx(blocks.mean(), abs=1e-7)
    error = blocks.std(ddof=1) / math.sqrt(blocks.size)
    assert float(motion.lyapunov_exponent_error) == pytest.approx(error, abs=1e-7)
    assert 0.0 < float(motion.lyapunov_exponent_error) < float(motion.lyapunov_exponent)


@pytest.mark.parametrize("exciter", CHAOTIC)
def test_near_motions_part_at_the_rate_of_the_exponent(exciter: vp.Exciter) -> None:
    """Two motions at a small distance, brought near each other again after each period."""
    states, motion = sections(exciter, 300)
    direction, growths, near = np.array([1.0, 0.0]), [], 1e-7
    for state in states[:-1]:
        apart = carried(exciter, state + near * direction) - carried(
            exciter, state - near * direction
        )
        growths.append(math.log(np.hypot(*apart) / (2 * near)))
        direction = apart / np.hypot(*apart)
    mean = np.mean(growths[BLOCK_PERIODS:]) / exciter.period
    assert float(motion.lyapunov_exponent) == pytest.approx(mean, abs=1e-4)


@pytest.mark.parametrize("exciter", CHAOTIC)
def test_other_parts_of_a_chaotic_motion_have_the_same_exponent(exciter: vp.Exciter) -> None:
    motions = [
        vp.steady_state(exciter, outputs=OUTPUTS, patience=patience)
        for patience in range(300, 1000, 80)
    ]
    values = np.array([float(motion.lyapunov_exponent) for motion in motions])
    errors = np.array([float(motion.lyapunov_exponent_error) for motion in motions])
    # errors are of few blocks each, and scatter as well
    assert (np.abs(values - values.mean()) < 4 * errors.mean()).all()
    assert 0.4 < errors.mean() / values.std(ddof=1) < 2.5


def test_exponents_of_orbits_follow_from_their_multipliers() -> None:
    over = {"nu": np.linspace(0.1, 3.0, 60), "f": [0.1, 0.6, 1.2]}
    rows = vp.sweep(vp.Exciter(delta=0.1, **LOSSY), over, outputs=OUTPUTS)
    multiplier = np.abs(rows.floquet_multiplier.isel(multiplier=0))
    with np.errstate(divide="ignore"):
        expected = np.log(multiplier) / (rows.period_multiple * 2 * np.pi / rows.nu)
    orbit = rows.period_multiple.values > 0
    np.testing.assert_allclose(
        rows.lyapunov_exponent.values[orbit], expected.values[orbit], rtol=1e-12, atol=1e-14
    )
    assert (rows.lyapunov_exponent_error.values[orbit] == 0.0).all()
    names = rows.regime.attrs["flag_meanings"].split()
    found = {names[code] for code in np.unique(rows.regime)}
    assert {"no_impact", "two_sided", "with_rest"} <= found
    with_rest = rows.regime.values == names.index("with_rest")
    assert (rows.lyapunov_exponent.values[with_rest] == -np.inf).all()


@pytest.mark.parametrize(
    ("given", "expected"),
    [
        ({"h": 0.3, "f": 0.1, "nu": 2.0}, -0.15),
        ({"h": 2.5, "f": 0.1, "nu": 2.0}, -0.5),
        ({"h": 1.5, "f": 0.1, "nu": 1e-3}, -0.75),  # the multipliers underflow
        ({"h": 0.0, "f": 0.0}, 0.0),
    ],
)
@pytest.mark.parametrize("v0", [0.1, 40.0])
def test_exponents_of_closed_forms(given: dict[str, float], expected: float, v0: float) -> None:
    """With and without impacts of the transient, which make the row one that is marched."""
    motion = vp.steady_state(vp.Exciter(l=0.5, **given), v0=v0, outputs=OUTPUTS)
    assert float(motion.lyapunov_exponent) == pytest.approx(expected, rel=1e-12, abs=1e-12)
    assert float(motion.lyapunov_exponent_error) == 0.0


def test_mirrored_exciters_have_the_same_exponents() -> None:
    over = {"nu": np.linspace(0.6, 3.0, 80)}
    given = {"l": 0.5, "h": 0.05}
    one = vp.sweep(
        vp.Exciter(f=1.2, delta=0.1, R1=0.8, R2=0.6, **given), over, 0.1, 0.3, outputs=OUTPUTS
    )
    two = vp.sweep(
        vp.Exciter(f=-1.2, delta=-0.1, R1=0.6, R2=0.8, **given), over, -0.1, -0.3, outputs=OUTPUTS
    )
    assert (one.period_multiple == 0).sum() >= 3
    for name in ("lyapunov_exponent", "lyapunov_exponent_error", "period_multiple"):
        np.testing.assert_array_equal(one[name], two[name])


def test_cuts_and_cores_do_not_change_a_bit_and_other_outputs_neither() -> None:
    exciter, over = (
        vp.Exciter(nu=1.0, f=1.0, l=0.5, h=0.05, R1=0.8, R2=0.8),
        {"nu": np.linspace(0.8, 1.3, 90)},
    )
    outputs = ("harmonics", "impacts", *OUTPUTS)
    whole, grid = vp.sweep(exciter, over, outputs=outputs), grid_of(exciter, over)
    shards = [
        solve_shard(grid, start, stop, outputs=outputs)
        for start, stop in ((0, 7), (60, 90), (7, 60))
    ]
    xr.testing.assert_identical(assemble(shards, grid), whole)
    with limit_threads(1):
        xr.testing.assert_identical(vp.sweep(exciter, over, outputs=outputs), whole)
    without = vp.sweep(exciter, over, outputs=outputs[:-1])
    names = ["lyapunov_exponent", "lyapunov_exponent_error"]
    xr.testing.assert_identical(whole.drop_vars(names), without)
    assert 0 < int((whole.period_multiple == 0).sum()) < 90


def test_unsolved_rows_have_no_exponent() -> None:
    exciter = vp.Exciter(nu=1e-9, f=1.0, **LOSSY)  # too many steps in a forcing period
    with pytest.warns(vp.UnsolvedWarning, match="max_steps"):
        motion = vp.steady_state(exciter, outputs=OUTPUTS)
    assert math.isnan(motion.lyapunov_exponent)
    assert math.isnan(motion.lyapunov_exponent_error)


def test_exponents_in_si_are_per_second() -> None:
    motion = vp.steady_state(CHAOTIC[0], outputs=OUTPUTS)
    physical = vp.to_physical(motion, 2.0, 800.0)
    for name in ("lyapunov_exponent", "lyapunov_exponent_error"):
        assert float(physical[name]) == pytest.approx(20.0 * float(motion[name]))
        assert physical[name].attrs["units"] == "s-1"
        assert motion[name].attrs["units"] == "1"


def test_an_accuracy_does_not_ask_chaos_for_digits() -> None:
    """An orbit's exponent is compared with that of perturbed parameters, one without an orbit is an average."""
    over = {"nu": np.linspace(0.7, 3.0, 40)}
    exciter = vp.Exciter(f=1.0, **LOSSY)
    with_exponent, without = (
        vp.sweep(exciter, over, outputs=outputs, accuracy=1e-6)
        for outputs in (OUTPUTS, OUTPUTS[:-1])
    )
    np.testing.assert_allclose(with_exponent.error, without.error, rtol=1.0)


FORCED = Parameters(1.0, -1.0, 0.2, 0.5, 0.01, 0.6, 0.8)
CHATTER = Parameters(0.3, 1.5, 0.2, 0.5, 0.0, 0.7, 0.7)
MAX_EVENTS = np.int64(10**6)
ALONE = no_coupling()


def test_growth_adds_up_to_that_of_the_return_map() -> None:
    grid, c = exact_grid(ALL_EFFECTS, FORCED), np.empty(DEGREE + 1)
    start = state = initial_state(ALL_EFFECTS, FORCED, grid, 0.0, 0.1, -0.2, None)
    log, total, (a, b) = new_log(2000, 100), 0.0, (1.0, 0.0)
    for _ in range(5):
        clear_log(log)
        before = at_period_zero(state)
        state, _status = march_periods(
            ALL_EFFECTS, FORCED, grid, before, np.int64(1), log, c, MAX_EVENTS
        )
        jacobian = period_jacobian(ALL_EFFECTS, FORCED, log, True, before, state)
        a, b, rest, growth = perturbation_growth(jacobian, ALONE, a, b, 0.0)
        assert rest == 0.0
        assert math.hypot(a, b) == pytest.approx(1)
        total += growth
    whole = new_log(2000, 100)
    end, _status = march_periods(
        ALL_EFFECTS, FORCED, grid, start, np.int64(5), whole, c, MAX_EVENTS
    )
    carried = np.reshape(return_map_jacobian(ALL_EFFECTS, FORCED, whole, start, end, 5), (2, 2))[
        :, 0
    ]
    assert total == pytest.approx(math.log(np.hypot(*carried)), abs=1e-9)
    np.testing.assert_allclose((a, b), carried / np.hypot(*carried), atol=1e-9)


def test_what_a_rest_forgets_has_not_grown() -> None:
    grid, log = exact_grid(ALL_EFFECTS, CHATTER), new_log(2000, 100)
    start = initial_state(ALL_EFFECTS, CHATTER, grid, 0.0, 0.0, 0.0, None)
    end, _status = march_periods(
        ALL_EFFECTS, CHATTER, grid, start, np.int64(1), log, np.empty(DEGREE + 1), MAX_EVENTS
    )
    assert log.counts[RESTS] >= 1
    jacobian = period_jacobian(ALL_EFFECTS, CHATTER, log, True, start, end)
    assert perturbation_growth(jacobian, ALONE, 0.6, 0.8, 0.0) == (1.0, 0.0, 0.0, -math.inf)


def test_a_log_that_is_not_whole_tells_nothing() -> None:
    grid, log = exact_grid(ALL_EFFECTS, FORCED), new_log(2000, 100)
    start = initial_state(ALL_EFFECTS, FORCED, grid, 0.0, 0.1, -0.2, None)
    jacobian = period_jacobian(ALL_EFFECTS, FORCED, log, False, start, start)
    assert np.isnan(jacobian).all()
    assert math.isnan(perturbation_growth(jacobian, ALONE, 0.6, 0.8, 0.0)[3])
