"""When a motion without an orbit is left: chaos, transients that look like it, long orbits."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
import xarray as xr

import vibropipe as vp
from vibropipe.march.grid import exact_grid
from vibropipe.march.log import IMPACTS, clear_log, new_log
from vibropipe.march.state import initial_state
from vibropipe.orbits.growth import contraction, count_on_support_1, period_jacobian
from vibropipe.orbits.recurrence import HISTORY_OFFSET, lies_on_orbit
from vibropipe.orbits.return_map import at_period_zero, march_periods, state_xv
from vibropipe.orbits.verdict import APERIODIC, DRIFTING, next_limit
from vibropipe.physics.effects import ALL_EFFECTS
from vibropipe.physics.exciter import Parameters
from vibropipe.physics.flow import DEGREE
from vibropipe.solve.sweep.blocks import MAX_PERIODS, PATIENCE
from vibropipe.words.regimes import Chaos, Regime

ONE, MANY = np.int64(1), np.int64(10**6)
CHAOTIC = Parameters(1.2, 1.4, 0.2, 0.5, 0.01, 0.7, 0.7)
# Of these the period multiple.
LONG_ORBITS = [
    (Parameters(3.808330787, -1.799585357, 0.1907996438, 0.5, 0.3983598063, 0.5470469625, 0.4267024246), 46),
    (Parameters(4.059923166, -1.568079306, 0.1224276611, 0.5, 0.3118956208, 0.7398313789, 0.3013997506), 48),
    # After each rest the motion is the same to rounding, chaotic as it is in between.
    (Parameters(0.5299458755, -1.570481184, 0.002634082672, 0.5, 0.3191967047, 0.9567551355, 0.950876618), 214),
]  # fmt: skip
# Chaotic for some hundreds of periods, then without impacts.
LONG_TRANSIENTS = [
    Parameters(3.494452581, -1.172965603, 0.01111450194, 0.5, -0.1976924936, 0.6510081123, 0.6201630808),
    Parameters(3.378875805, 1.449456494, 0.01033760018, 0.5, 0.0, 0.3447421803, 0.3447421803),
]  # fmt: skip


def row(p: Parameters) -> xr.Dataset:
    """Return the steady state at p as a row of a sweep."""
    swept = vp.sweep(vp.Exciter(**p._asdict()), {"nu": [p.nu]}, outputs=("stability",))
    return swept.isel(nu=0)


def period_by_period(p: Parameters, periods: int) -> Any:
    """Yield (log, start, end) of each forcing period from rest at 0."""
    grid, log, c = exact_grid(ALL_EFFECTS, p), new_log(2000, 100), np.empty(DEGREE + 1)
    end = initial_state(ALL_EFFECTS, p, grid, 0.0, 0.0, 0.0, None)
    for _ in range(periods):
        clear_log(log)
        start = at_period_zero(end)
        end, _status = march_periods(ALL_EFFECTS, p, grid, start, ONE, log, c, MANY)
        yield log, start, end


@pytest.mark.parametrize(("p", "m"), LONG_ORBITS)
def test_a_long_orbit_is_closed(p: Parameters, m: int) -> None:
    """Perturbations grow along a part of it; a march of 1,000 periods repeats after m of them, and not sooner."""
    found = row(p)
    assert int(found.period_multiple) == m
    assert int(found.chaos) != Chaos.IN_WINDOW
    assert int(found.stable) == 1
    assert int(found.periods_to_settle) > PATIENCE
    sections = np.array([state_xv(p, end) for _log, _start, end in period_by_period(p, 1000)])
    changes = np.abs(sections[-1] - sections[-1 - m : -1]).sum(axis=1)[::-1]
    assert changes[m - 1] < 1e-7
    assert (changes[: m - 1] > 1e-5).all()


@pytest.mark.parametrize("p", LONG_TRANSIENTS)
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_chaos_beside_a_motion_without_impacts_is_followed(p: Parameters, sign: float) -> None:
    if sign < 0.0:  # the mirror image
        p = p._replace(f=-p.f, delta=-p.delta, R1=p.R2, R2=p.R1)
    swept = row(p)
    assert int(swept.regime) == Regime.NO_IMPACT
    assert int(swept.chaos) == Chaos.TRANSIENT
    assert int(swept.periods_to_settle) > PATIENCE


def test_what_is_chaotic_to_the_end_is_told_from_what_never_was() -> None:
    over = {"nu": [0.5, 1.2], "f": [0.9, 1.4]}
    rows = vp.sweep(vp.Exciter(l=0.5, h=0.2, delta=0.01, R1=0.7, R2=0.7), over)
    assert rows.chaos.attrs["flag_meanings"].split() == ["none", "transient", "in_window"]
    chaotic = rows.regime.values == Regime.APERIODIC
    assert chaotic.tolist() == [[False, False], [False, True]]
    assert (rows.chaos.values == np.where(chaotic, Chaos.IN_WINDOW, Chaos.NONE)).all()
    assert int(rows.periods_to_settle[1, 1]) == PATIENCE


@pytest.mark.parametrize("p", [CHAOTIC, CHAOTIC._replace(R1=0.6, R2=0.8, h=0.1)])
def test_contraction_is_the_determinant_of_the_return_map(p: Parameters) -> None:
    impacts = on_1 = 0
    determinants, periods = [], 40
    for log, start, end in period_by_period(p, periods):
        impacts, on_1 = impacts + int(log.counts[IMPACTS]), on_1 + count_on_support_1(log)
        j11, j12, j21, j22 = period_jacobian(ALL_EFFECTS, p, log, True, start, end)
        determinants.append(j11 * j22 - j12 * j21)
    assert 0 < on_1 < impacts
    expected = -np.log(np.abs(determinants)).mean()
    assert contraction(p, periods, on_1, impacts - on_1) == pytest.approx(expected, rel=1e-6)
    assert contraction(p._replace(R1=0.0), periods, on_1, 1) == math.inf
    assert contraction(p._replace(R1=0.0), periods, 0, 0) == pytest.approx(2 * math.pi * p.h / p.nu)


def test_how_long_a_motion_is_followed() -> None:
    def limit(
        k: int, is_chaotic: bool, shrinking: float = 3.0, kind: int = APERIODIC, **p: Any
    ) -> int:
        exciter = CHAOTIC._replace(**p)
        return next_limit(exciter, kind, is_chaotic, shrinking, k, 200, MAX_PERIODS)

    assert limit(200, True) == 200
    assert limit(200, True, shrinking=0.23 * 2) == 1000
    assert limit(200, True, shrinking=1.15) == 400
    assert limit(200, True, shrinking=2.2) == 328  # no window is shorter than 128 periods
    assert limit(950, True, shrinking=0.1) == 1000
    assert limit(1000, True, shrinking=0.1) == 1000
    assert limit(200, True, f=0.01) == 400  # beside a motion without impacts
    assert limit(4000, True, f=0.01) == limit(4000, False) + 872 == 5000
    assert limit(5000, True, f=0.01) == limit(5000, False) == 5000
    assert limit(200, False) == 328
    assert limit(1000, False) == 1128
    for kind, h in ((DRIFTING, 0.2), (APERIODIC, 0.0)):
        assert limit(200, True, kind=kind, h=h) == limit(200, False, kind=kind, h=h) == 1000
        assert limit(1000, False, kind=kind, h=h) == 1000


def test_a_chance_return_is_not_an_orbit() -> None:
    rng = np.random.default_rng(3)
    k, none = 240, np.empty(0)
    xs, vs = rng.uniform(-1, 1, (2, HISTORY_OFFSET + k + 1))
    assert not lies_on_orbit((xs, vs, none), k, 1.0, 1e-4)
    xs[-1], vs[-1] = xs[-57], vs[-57]
    assert not lies_on_orbit((xs, vs, none), k, 1.0, 1e-4)
    xs[-4:], vs[-4:] = xs[-60:-56] + 5e-5, vs[-60:-56]
    assert lies_on_orbit((xs, vs, none), k, 1.0, 1e-4)
    assert not lies_on_orbit((xs, vs, none), k, 0.1, 1e-4)
    assert not lies_on_orbit((xs, vs, none), k, 1.0, 1e-9)
    drifts = np.arange(xs.size) * 5e-4
    assert not lies_on_orbit((xs, vs, drifts), k, 1.0, 1e-4)
