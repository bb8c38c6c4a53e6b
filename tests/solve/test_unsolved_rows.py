"""A row that fails has a status and no results, and the sweep continues."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
import xarray as xr
from random_rows import solve_drawn
from row_checks import broken_rows

import vibropipe as vp
from vibropipe.physics.exciter import Parameters
from vibropipe.physics.linear import linear_multipliers
from vibropipe.solve.rows import many as rows
from vibropipe.solve.rows.unsolved import mask_unsolved
from vibropipe.words.outputs import OUTPUTS
from vibropipe.words.regimes import Regime
from vibropipe.words.status import Status

ALL = OUTPUTS
# An impact every 1e-5 of a forcing period: far more than the log holds, or than are marched.
CROWDED = {"l": 1e-3, "nu": 0.01, "h": 0.1}
NUMBERS = (
    "displacement_mean", "displacement_amplitude", "velocity_phase", "displacement", "velocity",
    "energy_input", "energy_damping", "energy_impact", "displacement_strobe", "impact_velocity_max",
)  # fmt: skip


def check(*parameters: tuple[float, ...]) -> xr.Dataset:
    solved = solve_drawn(np.array(parameters))
    assert broken_rows(solved) == {}
    return solved


# Rows whose orbit, of m > 1, was closed as far as rounding allows and lost when closed again.
LOST = [
    (0.7, 1.9726726726726727, 0.2, 0.5, 0.0, 0.7, 0.7),
    (1.0, 0.002076265817342339, 0.0, 0.5, 0.0, 1.0, 0.3022562994345702),
    (1.0, 0.14987745459391338, 0.0, 81.94608436527449, 0.0, 1.0, 0.0),
    (1.0, 0.0005575589668394057, 2.083176949087056e-06, 0.008234059813130657, 0.0, 0.0, 1.0),
    (1.8225596842521448, 256.65871547620435, 0.19159014267751728, 0.5, 0.0, 0.9546987000126025, 1.0),
    (0.02304259964610495, -2.359001172129468, 0.0, 0.5, -0.3171825391582074, 1.0, 0.9959795876089536),
]  # fmt: skip


@pytest.mark.parametrize("row", LOST)
def test_an_orbit_that_is_lost_when_closed_anew_stands_as_it_was_found(row: tuple) -> None:
    check(row)


def test_the_row_that_ended_a_study_has_its_orbit() -> None:
    exciter, over = vp.Exciter(l=0.5, h=0.2, R1=0.7, R2=0.7), {"nu": [0.7], "f": [LOST[0][1]]}
    for outputs in ((), ALL):
        solved = vp.sweep(exciter, over, x0=-0.3324, v0=0.2544, outputs=outputs).squeeze()
        assert int(solved.regime) == Regime.TWO_SIDED
        assert int(solved.status) == Status.OK
        assert int(solved.period_multiple) == 26
        assert float(solved.residual) < 1e-11


def test_an_impact_at_the_end_of_an_orbit_is_the_one_at_its_beginning() -> None:
    solved = check((2.0, 0.2001310478579399, 0.0, 0.5, 0.5, 0.0, 0.3201144705261024))
    assert solved.impact_period.values.tolist() == [0]
    assert solved.impact_phase.values.tolist() == [0.0]


def test_multipliers_that_are_none_but_for_rounding_are_in_order() -> None:
    check((2.0, 0.6432535411541057, 0.0, 0.5, 0.35515370975039917, 0.553718597339522, 0.0))


@pytest.mark.parametrize(
    "row",
    [
        (0.039012208094153664, 1.6683669299790311, 0.37, 0.5, -0.186174752391719, 1.0, 0.36683),
        # Without an orbit: means over a window with most contacts dropped lay beyond the supports.
        (0.03792454254133698, 3.2408399921640076, 0.0, 0.001322252208618864, 0.0006879, 1.0, 1.0),
        (0.030545633460192737, -212.1299062029406, 0.12632021494766554, 0.5, -0.5, 1.0, 1.0),
    ],
)
def test_a_row_of_more_contacts_than_are_kept_has_no_results(row: tuple) -> None:
    solved = check(row)
    assert int(solved.status.squeeze()) in (Status.LOG_FULL, Status.MAX_STEPS)
    assert np.isnan(solved.floquet_multiplier.values).all()


def test_results_are_masked_whole() -> None:
    solved = vp.sweep(vp.Exciter(**CROWDED), {"f": [10.0, 1e-5]}, outputs=ALL)
    assert solved.regime.values.tolist()[0] == Regime.UNRESOLVED
    bad = solved.isel(f=0)
    assert int(bad.status) == Status.MAX_IMPACTS
    assert int(bad.period_multiple) == int(bad.row_size) == int(bad.window_periods) == 0
    assert float(bad.impacts_per_orbit.sum()) == float(bad.rests_per_orbit.sum()) == 0
    for name in NUMBERS:
        assert np.isnan(bad[name].values).all(), name
    assert int(solved.status[1]) == Status.OK


def test_a_row_that_takes_too_many_steps_is_not_marched() -> None:
    """Such a row was solved with 8 steps per period: a rest, status `ok`, with energies of NaN."""
    solved = vp.sweep(
        vp.Exciter(l=0.5, nu=1.0, f=1.0, h=0.2, R1=0.5, R2=0.5), {"nu": [1e-300, 1e-30, 1e-9, 1.0]}
    )
    assert solved.status.values.tolist() == [Status.MAX_STEPS] * 3 + [Status.OK]
    assert np.isnan(solved.displacement_mean.values[:3]).all()


def test_a_number_out_of_range_is_not_a_result() -> None:
    """The harmonics of a motion in closed form overflow."""
    solved = vp.steady_state(vp.Exciter(l=0.5), x0=0.5, v0=1e200)
    assert int(solved.status) == Status.NOT_FINITE
    assert int(solved.regime) == Regime.UNRESOLVED
    assert int(solved.period_multiple) == 0


def test_multipliers_of_a_slow_motion_are_no_larger_than_its_decay() -> None:
    p = Parameters(1e-200, 0.2, 1e-300, 0.5, 0.0, 1.0, 1.0)
    assert all(abs(multiplier) <= 1.0 + 1e-15 for multiplier in linear_multipliers(p))
    for turns in (2.0**40 + 0.25, 1e12 / 7):
        slow = linear_multipliers(Parameters(1.0 / turns, 0.0, 0.0, 0.5, 0.0, 1.0, 1.0))[0]
        phase = 2 * math.pi * math.fmod(1.0 / (1.0 / turns), 1.0)
        assert slow == pytest.approx(complex(math.cos(phase), math.sin(phase)), abs=1e-12)


def test_a_chain_goes_on_from_the_start_of_a_row_that_is_not_solved() -> None:
    """The last state of an unsolved row need not be finite."""
    exciter = vp.Exciter(l=0.5, nu=1.0, h=0.1, R1=0.5, R2=0.5)
    solved = vp.sweep(exciter, {"f": [0.5, 1.0, 1e300, 2e300]}, follow=("f", "down"), outputs=ALL)
    assert solved.status.values.tolist()[2:] == [Status.MAX_IMPACTS] * 2
    assert solved.status.values.tolist()[:2] == [Status.OK] * 2
    plain = vp.sweep(exciter, {"f": [1.0]}, outputs=ALL)
    assert float(solved.displacement_strobe[1]) == float(plain.displacement_strobe[0])


def test_a_sampling_march_that_fails_leaves_no_samples(monkeypatch: Any) -> None:
    out = rows.new_rows(2, 3, ALL, rows.new_impact_buffer(2))
    out.period_multiple[:], out.frequency[:], out.residual[:] = 1, 1.0, 0.0
    out.motion[1] = math.nan
    masked = mask_unsolved(rows.compact_impacts(out))
    assert masked.status.tolist() == [Status.OK, Status.NOT_FINITE]
    assert masked.regime.tolist() == [Regime.NO_IMPACT, Regime.UNRESOLVED]
    assert masked.period_multiple.tolist() == [1, 0]
    assert np.isnan(masked.amplitudes[1]).all()
    assert np.isfinite(masked.amplitudes[0]).all()


def test_an_unsolved_row_has_no_error_that_could_be_trusted() -> None:
    solved = vp.sweep(vp.Exciter(**CROWDED), {"f": [10.0, 1e-5]}, accuracy=1e-6)
    assert solved.error.values[0] == math.inf
    assert solved.error.values[1] < 1e-6
