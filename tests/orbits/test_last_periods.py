"""Sections and impacts of the last forcing periods, and stationary points of their flights."""

from __future__ import annotations

import math

import mpmath
import numpy as np
import pytest
import xarray as xr
from hypothesis import given
from hypothesis import strategies as st
from textbook import Flight

import vibropipe as vp
from vibropipe.march.log import IMPACTS, Log, log_impact, new_log
from vibropipe.orbits.results import RowResults
from vibropipe.orbits.room import new_sums, new_work
from vibropipe.orbits.window import LISTED_PERIODS, Window, list_impacts, window_of
from vibropipe.physics.exciter import Parameters
from vibropipe.solve.boundary.closed_flights import flight_extremes
from vibropipe.solve.rows.row_results import ImpactBuffer, new_rows
from vibropipe.words.status import Status

LOSSY = {"l": 0.5, "h": 0.2, "R1": 0.7, "R2": 0.7}
CHAOTIC = [
    vp.Exciter(nu=1.2, f=1.4, delta=0.01, **LOSSY),
    vp.Exciter(nu=0.7, f=1.97267, **LOSSY),
    vp.Exciter(nu=0.4628140703517588, f=1.6962311557788945, delta=0.01, **LOSSY),
]
OUTPUTS = ("impacts", "poincare", "stability")


def next_section(exciter: vp.Exciter, motion: xr.Dataset, n: int) -> xr.Dataset:
    """Return the motion over the forcing period after section n."""
    start = {"x0": motion.poincare_displacement[n], "v0": motion.poincare_velocity[n]}
    return vp.simulate(
        exciter,
        tau_end=exciter.period,
        samples_per_period=0,
        **{name: float(value) for name, value in start.items()},
    )


@pytest.mark.parametrize("exciter", CHAOTIC)
@pytest.mark.parametrize("patience", [256, 300, 1000])
def test_each_listed_period_is_the_motion_from_the_section_before(
    exciter: vp.Exciter, patience: int
) -> None:
    """Impacts and next section, by a march of that period alone."""
    motion = vp.steady_state(exciter, outputs=OUTPUTS, patience=patience)
    assert int(motion.period_multiple) == 0
    assert motion.sizes["visit"] == LISTED_PERIODS == 64
    assert float(motion.poincare_displacement[-1]) == float(motion.displacement_strobe)
    assert float(motion.poincare_velocity[-1]) == float(motion.velocity_strobe)
    period = motion.impact_period.values
    assert set(period) == set(range(64))
    assert (np.diff(period + motion.impact_phase.values) > 0).all()
    for n in range(1, 64):
        after, listed = next_section(exciter, motion, n - 1), period == n
        assert motion.impact_support.values[listed].tolist() == after.impact_support.values.tolist()
        np.testing.assert_allclose(
            motion.impact_phase.values[listed], after.impact_tau / exciter.period, atol=1e-9
        )
        np.testing.assert_allclose(
            motion.impact_velocity.values[listed], after.impact_velocity, atol=1e-8
        )
        np.testing.assert_allclose(
            motion.poincare_displacement[n], after.displacement_end, atol=1e-8
        )
        np.testing.assert_allclose(motion.poincare_velocity[n], after.velocity_end, atol=1e-8)


def test_a_window_of_few_periods_lists_these() -> None:
    """With a patience just below the longest march, the last window has the periods between them."""
    exciter = vp.Exciter(l=0.5, nu=1.0, f=0.7, h=0.0, R1=1.0, R2=1.0)
    motion = vp.steady_state(exciter, outputs=OUTPUTS, patience=990)
    assert int(motion.window_periods) == 10
    assert set(motion.impact_period.values) == set(range(10))
    assert motion.sizes["visit"] == 64


@pytest.mark.parametrize(
    ("nu", "f", "m"), [(0.5, 0.9, 1), (1.6, 1.58, 2), (1.45, 1.35, 3), (1.72, 1.8, 8)]
)
def test_sections_of_an_orbit_repeat(nu: float, f: float, m: int) -> None:
    exciter = vp.Exciter(nu=nu, f=f, delta=0.01, **LOSSY)
    orbit = vp.steady_state(exciter, outputs=OUTPUTS)
    assert int(orbit.period_multiple) == m
    x, v = orbit.poincare_displacement.values, orbit.poincare_velocity.values
    assert (x[0], v[0]) == (float(orbit.displacement_strobe), float(orbit.velocity_strobe))
    assert len(set(zip(x, v, strict=True))) == m
    np.testing.assert_array_equal(x[m:], x[:-m])
    for n in range(m):
        after = next_section(exciter, orbit, n)
        np.testing.assert_allclose(x[n + 1], after.displacement_end, atol=1e-11)
        np.testing.assert_allclose(v[n + 1], after.velocity_end, atol=1e-11)
    struck = np.bincount(orbit.impact_support, minlength=3)[1:]
    np.testing.assert_array_equal(orbit.impacts_per_period, struck / m)


def test_every_row_has_impacts_per_period_whatever_outputs_are_asked() -> None:
    exciter = vp.Exciter(nu=1.2, delta=0.01, **LOSSY)
    over = {"nu": [1.2, 1.6, 1e-30], "f": [0.04, 1.4, 1.58]}
    rows = vp.sweep(exciter, over, outputs=())
    m, mean = rows.period_multiple, rows.impacts_per_period
    solved = rows.status <= Status.MAX_PERIODS
    assert solved.values.tolist() == [[True] * 3, [True] * 3, [True, False, False]]
    assert (mean.isnull() == ~solved).all()
    np.testing.assert_array_equal(
        mean.where(solved, 0.0), rows.impacts_per_orbit / np.maximum(m, 1)
    )
    assert mean.sel(nu=1.6, f=1.58).values.tolist() == [1.0, 1.5]
    assert (mean.sel(nu=1.2, f=1.4) > 1.0).all()
    assert (mean.sel(f=0.04) == 0.0).all()


def test_unsolved_rows_list_nothing() -> None:
    crowded = vp.Exciter(l=1e-3, nu=0.01, h=0.1, f=10.0)
    row = vp.steady_state(crowded, outputs=(*OUTPUTS, "subharmonics"))
    assert int(row.status) == Status.MAX_IMPACTS
    assert row.sizes["impact"] == 0
    for name in ("poincare_displacement", "poincare_velocity", "impacts_per_period"):
        assert np.isnan(row[name].values).all(), name


def listing(first: int, capacity: int = 10) -> tuple[RowResults, Window, Log]:
    """Results of a row whose impacts begin at `first`, its window, and a log of this capacity."""
    n = first + capacity
    buffer = ImpactBuffer(np.full(n, -1.0), np.full(n, -1.0), np.full(n, -1, np.int8))
    out = new_rows(1, 1, ("impacts",), buffer)
    p = Parameters(1.0, 1.0, 0.1, 0.5, 0.0, 0.7, 0.7)
    # In Python: compiled, it counts no references of what it returns.
    make = getattr(window_of, "py_func", window_of)
    window = make(p, out, np.int64(0), np.int64(first), new_sums(), new_work(out))
    return out, window, new_log(capacity, 2)


@pytest.mark.parametrize("first", [0, 5])
def test_a_list_that_is_full_begins_anew_with_whole_periods(first: int) -> None:
    """The last periods stay, and the index tells which."""
    out, window, log = listing(first)
    for period in range(LISTED_PERIODS):
        log.counts[IMPACTS] = 0
        for i in range(3):
            log_impact(log, 0.25 * i, 1 + i % 2, 1.0, -1.7)
        log_impact(log, 0.9, -1, 0.0, -0.1)  # the tail of a chatter is no impact
        list_impacts(window, log, np.int64(period))
    # Three periods fit: a fourth would need 9 + 4 entries. The list began anew with the periods 3, 6, ..., 63.
    assert int(out.impact_count[0]) == 3
    assert out.impact_position[first : first + 3].tolist() == [63.0, 63.25, 63.5]
    assert out.impact_support[first : first + 3].tolist() == [1, 2, 1]
    assert (out.impact_position[:first] == -1.0).all()


def test_an_impact_at_the_end_of_the_last_period_is_not_listed() -> None:
    out, window, log = listing(0)
    log_impact(log, 1.0, 1, 1.0, -1.7)
    for period in (0, LISTED_PERIODS - 1):
        list_impacts(window, log, np.int64(period))
    assert out.impact_position[: int(out.impact_count[0])].tolist() == [1.0]


def test_a_free_motion_turns_at_its_amplitude() -> None:
    p = Parameters(1.0, 0.0, 0.0, 0.5, 0.0, 1.0, 1.0)
    least, most = flight_extremes(p, 0.0, 0.3, -0.4, 2)
    assert (least, most) == pytest.approx((-0.5, 0.5), rel=1e-14)
    # a quarter of the period downwards: it turns nowhere
    assert flight_extremes(p._replace(nu=2.0), 0.0, 0.5, -1e-9, 1) == (math.inf, -math.inf)


def test_with_damping_the_first_minimum_is_the_least() -> None:
    h, x = 0.2, 0.7
    omega = math.sqrt(1 - h * h / 4)
    least, most = flight_extremes(Parameters(0.1, 0.0, h, 0.5, 0.0, 1.0, 1.0), 0.25, x, 0.0, 2)
    assert least == pytest.approx(-x * math.exp(-0.5 * h * math.pi / omega), rel=1e-13)
    assert most == pytest.approx(x * math.exp(-h * math.pi / omega), rel=1e-13)


@given(
    nu=st.floats(0.2, 8),
    h=st.sampled_from([0.0, 0.1, 2.0, 7.0]),
    turn=st.floats(0, 0.999),
    x=st.floats(-1, 1),
    v=st.floats(-2, 2),
    n=st.integers(1, 5),
)
def test_they_are_those_of_dense_samples(
    nu: float, h: float, turn: float, x: float, v: float, n: int
) -> None:
    p = Parameters(nu, 1.0, h, 0.5, 0.0, 1.0, 1.0)
    start = 2 * math.pi * turn / nu
    flight = Flight(mpmath.fp, nu, 1.0, h, (start, x, v)) if nu != 1 or h > 0 else None
    if flight is None or abs(nu - 1) < 1e-6:
        return
    tau = start + np.linspace(0, n * math.pi / nu, 3001)
    xs = np.array([flight(t)[0] for t in tau])
    minima = xs[1:-1][(xs[1:-1] < xs[:-2]) & (xs[1:-1] < xs[2:])]
    maxima = xs[1:-1][(xs[1:-1] > xs[:-2]) & (xs[1:-1] > xs[2:])]
    least, most = flight_extremes(p, turn, x, v, n)
    # samples miss a stationary point between the first or last two of them, and one of a height below rounding
    if minima.size:
        assert least <= minima.min() + 1e-12
    if maxima.size:
        assert most >= maxima.max() - 1e-12
    bound = 1e-4 * max(1.0, abs(xs).max(), (n * math.pi / nu) ** 2)
    assert not math.isfinite(least) or least >= xs.min() - bound
    assert not math.isfinite(most) or most <= xs.max() + bound
