"""Where common methods fail: the exact method has no failure there, and each error is that of its closed form."""

import math

import mpmath
import numpy as np
import pytest

from vibropipe.lab.hard_cases import failures
from vibropipe.lab.hard_cases.failures import (
    COUNTS,
    DEPTHS,
    METHODS,
    RESTITUTIONS,
    grazing_velocity,
    relative_error,
    scipy_impacts,
)
from vibropipe.lab.work_precision_methods import BenchmarkMotion
from vibropipe.physics.exciter import Exciter
from vibropipe.words.measurements import Outcome

EPS = np.finfo(float).eps


def test_every_grazing_impact_is_found_as_well_as_its_start_is_known(monkeypatch):
    monkeypatch.setattr(failures, "DEPTHS", DEPTHS[::4])
    found = failures.grazing()
    # v = sqrt(v0^2 - 1/4): half an ulp of v0 moves it by this share
    allowed = 30 * EPS / (2 * DEPTHS[::4])
    for method in ("exact", "newmark", "DOP853_short"):
        assert (found[method].outcome == Outcome.OK).all()
        assert (found[method].error < allowed).all()
    # an integrator whose steps are longer than the contact steps over it
    assert found["DOP853"].outcome.tolist() == [Outcome.OK, *[Outcome.MISSED_IMPACT] * 5]
    assert found["crude"].error[0] > 1e-3
    assert found["crude"].outcome[-1] == Outcome.MISSED_IMPACT


def test_errors_are_relative_to_more_digits_than_a_double_has():
    with mpmath.workdps(40):
        truth = mpmath.sqrt(mpmath.mpf(0.5 + 1e-9) ** 2 - mpmath.mpf("0.25"))
        assert abs(mpmath.mpf(str(grazing_velocity(0.5 + 1e-9))) / truth - 1) < mpmath.mpf("1e-38")
    assert relative_error(
        float(truth) * (1 + 1e-10), grazing_velocity(0.5 + 1e-9)
    ) == pytest.approx(1e-10, rel=1e-4)
    assert math.isnan(relative_error(math.nan, grazing_velocity(0.6)))


def test_the_end_of_a_chatter_is_found_and_an_integrator_is_stuck_before_it(monkeypatch):
    monkeypatch.setattr(failures, "RESTITUTIONS", RESTITUTIONS[[0, 2, 5]])
    found = failures.chatter()
    assert (found["exact"].error < 1e-13).all()
    assert (found["newmark"].error < 1e-5).all()
    assert found["crude"].outcome.tolist() == [Outcome.OK, *[Outcome.DID_NOT_END] * 2]
    assert (found["DOP853"].outcome == Outcome.DID_NOT_END).all()
    assert ((found["DOP853"].error > 1e-3) & (found["DOP853"].error < 0.1)).all()


def test_the_energy_of_all_impacts_is_kept_but_by_the_crude_method(monkeypatch):
    monkeypatch.setattr(failures, "IMPACTS", 1000)
    monkeypatch.setattr(failures, "COUNTS", COUNTS[COUNTS <= 1000])
    monkeypatch.setattr(failures, "MAX_IMPACTS", 100)
    found = failures.energy()
    assert found["closed"].error.max() <= EPS
    assert found["exact"].error.max() < 1e-11
    assert found["newmark"].error.max() < 1e-11
    for method, least in (("DOP853", 1e-11), ("DOP853_loose", 1e-6), ("crude", 1e-4)):
        known = np.isfinite(found[method].error)
        assert found[method].error[known].max() > least
        assert (found[method].outcome[~known] == Outcome.DID_NOT_END).all()
        assert not known.all()


def test_errors_over_the_step_fall_with_the_order_of_each_method(monkeypatch):
    monkeypatch.setattr(failures, "STEPS_TRIED", np.array([64, 512, 4096]))
    monkeypatch.setattr(failures, "TOLERANCES", (1e-4, 1e-8))
    values = failures.step()
    count, error = (values[name] for name in ("step_count", "step_error"))
    newmark = METHODS.index("newmark")
    assert count[newmark].tolist() == [64, 512, 4096]
    order = np.log(error[newmark, 0] / error[newmark, 2]) / np.log(64)
    assert order == pytest.approx(2, abs=0.1)
    assert error[METHODS.index("exact"), 0] < 1e-14
    assert np.isnan(error[METHODS.index("closed")]).all()


def test_an_integrator_is_stopped_by_its_impacts_or_where_it_is_stuck():
    free = BenchmarkMotion(Exciter(l=0.5), 0.0, -0.51, 20)
    assert len(scipy_impacts(free, 1e-8, 5)) == 5
    pressed = Exciter(l=0.5, delta=-1.5, R1=0.5)
    impacts = scipy_impacts(BenchmarkMotion(pressed, -1.5, 0.0, 2), 1e-10, 1000)
    assert impacts[-1][0] - impacts[-2][0] <= math.ulp(impacts[-1][0])
