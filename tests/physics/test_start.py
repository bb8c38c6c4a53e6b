"""Starts of motions: by default, on a support within rounding, and rejected outside."""

from __future__ import annotations

import numpy as np
import pytest
import yaml

import vibropipe as vp
from vibropipe.physics.start import largest_start, row_starts, start_at
from vibropipe.scenes.registry import kind_of
from vibropipe.solve.in_si import stated_start, text_in_si
from vibropipe.solve.sweep.blocks import PATIENCE
from vibropipe.study import parse_study
from vibropipe.words.parameters import PARAMETERS
from vibropipe.words.status import Status

BEYOND = {"l": 0.5, "nu": 1.0, "f": 1.0, "h": 0.2, "R1": 0.7, "R2": 0.7}
# 0.8 - 0.5 is 0.30000000000000004.
DECIMAL = vp.Exciter(l=0.5, delta=0.8, nu=1.0, f=1.0, h=0.2, R1=0.7, R2=0.7)


@pytest.mark.parametrize(
    ("delta", "start"), [(0.0, 0.0), (0.2, 0.0), (0.5, 0.0), (0.6, 0.6 - 0.5), (-0.6, 0.5 - 0.6)]
)
def test_the_default_start_is_the_equilibrium_or_the_nearest_support(
    delta: float, start: float
) -> None:
    exciter = vp.Exciter(delta=delta, **BEYOND)
    assert exciter.check_start(None, 0.0) == (start, 0.0)
    left_out, explicit = (vp.simulate(exciter, 20.0, **x) for x in ({}, {"x0": start}))
    np.testing.assert_array_equal(left_out.displacement.values, explicit.displacement.values)
    assert float(left_out.displacement[0]) == start
    default, same = vp.steady_state(exciter), vp.steady_state(exciter, x0=start)
    assert float(default.displacement_strobe) == float(same.displacement_strobe)
    assert int(default.status) == Status.OK


def test_the_default_start_is_that_of_each_row() -> None:
    offsets = np.array([-1.2, -0.6, 0.0, 0.4, 0.6, 1.2])
    sweep = vp.sweep(vp.Exciter(**BEYOND), {"delta": offsets, "nu": [0.8, 1.2]})
    for i, delta in enumerate(offsets):
        for j, nu in enumerate((0.8, 1.2)):
            alone = vp.steady_state(
                vp.Exciter(**BEYOND | {"delta": delta, "nu": nu}), patience=PATIENCE
            )
            assert float(sweep.displacement_strobe[i, j]) == float(alone.displacement_strobe)
            assert int(sweep.periods_to_settle[i, j]) == int(alone.periods_to_settle)
    assert sweep.attrs["start"] == "x0 = 0 or the support nearest to it, v0 = 0"
    near = vp.sweep(vp.Exciter(**BEYOND), {"nu": [0.8]})
    assert near.attrs["start"] == "x0 = 0, v0 = 0"
    loaded = vp.Exciter(l=0.5, nu=1.05, f=0.5, h=0.2, R1=0.7, R2=0.7, load=0.02)
    assert vp.tolerance(loaded, {"f": 1e-3}, samples=64).attrs["start"] == "x0 = 0.02, v0 = 0"


def test_a_chain_begins_at_its_own_start() -> None:
    offsets = np.linspace(0.55, 0.8, 6)
    for direction, first in (("up", 0), ("down", -1)):
        chain = vp.sweep(vp.Exciter(**BEYOND), {"delta": offsets}, follow=("delta", direction))
        alone = vp.steady_state(vp.Exciter(delta=offsets[first], **BEYOND), patience=PATIENCE)
        assert float(chain.displacement_strobe[first]) == float(alone.displacement_strobe)


@pytest.mark.parametrize("x0", [0.3, 0.30000000000000004, 0.30000000000000016])
def test_a_start_within_rounding_of_a_support_lies_on_it(x0: float) -> None:
    assert DECIMAL.check_start(x0, 0.0) == (DECIMAL.lower, 0.0)
    on = vp.simulate(DECIMAL, 20.0, x0=DECIMAL.lower)
    np.testing.assert_array_equal(
        vp.simulate(DECIMAL, 20.0, x0=x0).displacement.values, on.displacement.values
    )
    swept = vp.sweep(DECIMAL, {"nu": [0.9]}, x0=x0)
    rested = vp.sweep(DECIMAL, {"nu": [0.9]}, x0=DECIMAL.lower)
    assert float(swept.displacement_strobe[0]) == float(rested.displacement_strobe[0])


@pytest.mark.parametrize("x0", [0.2999999999, 1.3000000001])
def test_a_start_outside_is_rejected(x0: float) -> None:
    for call in (vp.simulate, vp.steady_state):
        with pytest.raises(vp.ParameterError, match=f"x0: must be .*, got {x0}"):
            call(DECIMAL, x0=x0)
    with pytest.raises(vp.ParameterError, match=f"x0: must be .*, got {x0}"):
        vp.sweep(DECIMAL, {"nu": [0.9]}, x0=x0)


def test_an_explicit_start_must_suit_every_row() -> None:
    with pytest.raises(vp.ParameterError, match=r"x0: must be .*, got 0\.0"):
        vp.sweep(vp.Exciter(**BEYOND), {"delta": [0.0, 0.6]}, x0=0.0)


def test_a_moving_start_close_to_a_support_is_not_moved() -> None:
    exciter = vp.Exciter(l=0.5, delta=0.5, nu=1.0, f=1e-300)
    assert exciter.check_start(1e-302, 1e-302) == (1e-302, 1e-302)
    assert exciter.check_start(1e-302, 0.0) == (0.0, 0.0)
    assert DECIMAL.check_start(0.3, 1.0) == (DECIMAL.lower, 1.0)


def test_starts_of_many_rows_equal_those_of_each() -> None:
    rng = np.random.default_rng(3)
    rows = np.zeros((500, len(PARAMETERS)))
    rows[:, 3], rows[:, 4] = rng.uniform(0.1, 1, 500), rng.uniform(-2, 2, 500)
    starts = row_starts(rows, None, 0.5)
    assert (starts[:, 1] == 0.5).all()
    for (_nu, _f, _h, half, delta, *_), (x, _v) in zip(rows, starts, strict=True):
        assert x == vp.Exciter(l=half, delta=delta).check_start(None, 0.0)[0]
        assert delta - half <= x <= half + delta
    values = {"l": rows[:, 3], "delta": rows[:, 4]}
    assert np.abs(starts[:, 0]).max() <= largest_start(values, None)
    # Supports closer to each other than the rounding of their positions.
    assert start_at(1e-16, 0.0, 1e-16, 0.0) == 1e-16


STUDY = """
title: t
exciter: {l: 0.5, nu: 1, f: 1, h: 0.2, R1: 0.7, R2: 0.7}
scenes:
  m: {kind: motion, exciter: {delta: 0.8}, tau_end: 5, outputs: [motion, stability]}
  s: {kind: sweep, over: {delta: [-0.6, 0, 0.6]}, outputs: [stability]}
  near: {kind: motion, exciter: {delta: 0.8}, start: {x0: 0.3}, tau_end: 5}
"""


def test_a_study_may_omit_the_start(tmp_path: object) -> None:
    study = parse_study(yaml.safe_load(STUDY))
    motion, sweep, near = (
        kind_of(study.scene(name)).solve(study.scene(name)) for name in ("m", "s", "near")
    )
    assert float(motion.displacement[0]) == 0.8 - 0.5
    assert (sweep.status == Status.OK).all()
    np.testing.assert_array_equal(motion.displacement.values, near.displacement.values)
    assert motion.attrs["start"] == "x0 = 0.3, v0 = 0"


def test_the_unit_of_a_start_stands_behind_its_number() -> None:
    si = {"m": 2.0, "C": 800.0}
    attributes = {
        "x0 = 0, v0 = 0": "x0 = 0 m, v0 = 0 m/s",
        "x0 = -0.02, v0 = 0.5": "x0 = -0.02 m, v0 = 10 m/s",
        "x0 = 0.02 or the support nearest to it, v0 = 0": "x0 = 0.02 m or the support nearest to it, v0 = 0 m/s",
        "x0 = load, v0 swept": "x0 = load, v0 swept",
    }
    for plain, expected in attributes.items():
        assert text_in_si("start", plain, si) == expected
    assert stated_start("x0 = -0.02 m, v0 = 10 m/s") == (-0.02, 10.0)
    assert stated_start("x0 = 0.02 or the support nearest to it, v0 = 0") is None
