"""Motions in lockstep: bitwise equal to motions marched alone, with packed vector instructions."""

from __future__ import annotations

import math
import re

import llvmlite.binding as llvm
import newmark_lanes
import numba
import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from lane_rows import march_rows, newmark_item, random_parameters

import vibropipe as vp
from vibropipe.solve.checks import span_in_turns
from vibropipe.words.parameters import PARAMETERS
from vibropipe.words.status import Status

pytestmark = pytest.mark.benchmark

OF_IMPACT = ("impact_tau", "impact_support", "impact_velocity", "impact_velocity_after")
OF_REST = ("rest_start", "rest_end", "rest_support")
ENDS = ("displacement_end", "velocity_end", "status")
FORCED = vp.Exciter(l=0.5, nu=1.1, f=0.8, h=0.1, delta=0.01, R1=0.7, R2=0.6)
CHATTER = vp.Exciter(l=0.5, nu=0.3, f=1.5, h=0.2, R1=0.7, R2=0.7)
PLASTIC = vp.Exciter(l=0.5, nu=0.4, f=1.2, h=0.1, R1=0.0, R2=0.3)
FREE = vp.Exciter(l=1.0, delta=0.2)
OUT_OF_REACH = vp.Exciter(l=1e3, nu=1.0, f=0.5, h=0.1)


def simulate_each(exciters, tau_end, xs, vs, steps):
    return [
        vp.simulate(e, end, x, v, "newmark", steps_per_period=steps, samples_per_period=0)
        for e, end, x, v in zip(exciters, tau_end, xs, vs, strict=True)
    ]


def lockstep(exciters, tau_end, xs, vs, steps, max_impacts=10**6):
    parameters = np.array([e.parameters() for e in exciters])
    turns = [span_in_turns(e, 0.0, end)[1] for e, end in zip(exciters, tau_end, strict=True)]
    starts = np.column_stack([xs, vs]).astype(float)
    return march_rows(parameters, starts, np.array(turns, float), steps, max_impacts)


def check_same(exciters, tau_end, xs, vs, steps):
    """Check that every value of `march_rows` is bitwise that of `simulate`, including nan."""
    rows = lockstep(exciters, tau_end, xs, vs, steps)
    row_ends = {name: np.cumsum([0, *rows[name]]) for name in ("row_size", "row_rests")}
    for row, alone in enumerate(simulate_each(exciters, tau_end, xs, vs, steps)):
        for name in ENDS:
            np.testing.assert_array_equal(rows[name][row], alone[name], err_msg=f"{row} {name}")
        for size, names in (("row_size", OF_IMPACT), ("row_rests", OF_REST)):
            slice_of_row = slice(row_ends[size][row], row_ends[size][row + 1])
            for name in names:
                np.testing.assert_array_equal(
                    rows[name][slice_of_row], alone[name], f"{row} {name}"
                )
    return rows


def exciters():
    """Weak and strong forcing, slow and fast, either support near, plastic to elastic."""
    return st.builds(
        vp.Exciter,
        l=st.floats(0.1, 1.0),
        nu=st.floats(0.1, 5.0),
        f=st.one_of(st.just(0.0), st.floats(-3.0, 3.0)),
        h=st.one_of(st.just(0.0), st.floats(0.0, 3.0)),
        delta=st.floats(-1.5, 1.5),
        R1=st.one_of(st.sampled_from([0.0, 1.0]), st.floats(0.0, 1.0)),
        R2=st.one_of(st.sampled_from([0.0, 1.0]), st.floats(0.0, 1.0)),
    )


rows_of_motions = st.lists(
    st.tuples(exciters(), st.floats(0.0, 40.0), st.floats(0.0, 1.0), st.floats(-2.0, 2.0)),
    min_size=1,
    max_size=8,
)


@settings(max_examples=60)
@example([(CHATTER, 30.0, 0.5, 0.0), (PLASTIC, 31.0, 0.0, 0.0), (FREE, 9.0, 1.0, 2.0)], 2000)
@example([(FORCED, 20.0, 0.5, 0.3), (OUT_OF_REACH, 20.0, 0.5, 0.3)], 9000)
@example([(FORCED, 0.0, 0.5, 0.3)], 10)
@given(rows_of_motions, st.sampled_from([1, 3, 8, 20, 100, 257]))
def test_each_row_is_the_motion_marched_alone(motions, steps):
    row_exciters, ends, fractions, vs = zip(*motions, strict=True)
    # a fraction of 0 or 1 is a start on a support
    xs = [
        min(max(e.lower + fraction * 2 * e.l, e.lower), e.upper)
        for e, fraction in zip(row_exciters, fractions, strict=True)
    ]
    check_same(list(row_exciters), ends, xs, vs, steps)


def test_rows_of_several_blocks_are_independent():
    rng = np.random.default_rng(7)
    row_exciters = [
        vp.Exciter(l=0.5, nu=nu, f=f, h=0.1, R1=R1, R2=R2)
        for nu, f, R1, R2 in rng.uniform((0.3, 0.2, 0.3, 0.3), (2, 2, 1, 1), (150, 4))
    ]
    ends = rng.uniform(5, 60, 150)
    rows = check_same(row_exciters, ends, np.zeros(150), np.zeros(150), 200)
    assert (rows["row_size"] > 0).any()
    assert (rows["row_rests"] > 0).any()
    reversed_rows = lockstep(row_exciters[::-1], ends[::-1], np.zeros(150), np.zeros(150), 200)
    np.testing.assert_array_equal(reversed_rows["displacement_end"][::-1], rows["displacement_end"])


def test_the_log_of_a_row_grows_with_its_contacts():
    many = vp.Exciter(l=0.05, nu=0.1, f=1.0, h=0.1, R1=0.9, R2=0.9)
    rows = check_same([FORCED, many], [900.0, 900.0], [0.0, 0.0], [0.0, 0.0], 100)
    # many times its initial capacity: six for each of 14 periods, and a constant part
    assert rows["row_size"][1] > 2000


def test_too_many_contacts_are_reported_without_an_end():
    rows = lockstep([FORCED, OUT_OF_REACH], [60.0, 60.0], [0.0, 0.0], [0.0, 0.0], 100, 5)
    assert rows["status"].tolist() == [Status.MAX_IMPACTS, Status.OK]
    assert math.isnan(rows["displacement_end"][0])
    assert rows["row_size"][0] == 6
    assert np.isfinite(rows["displacement_end"][1])


def test_rows_that_are_timed_strike_twice_a_period():
    for row in random_parameters()[:3].tolist():
        e = vp.Exciter(**dict(zip(PARAMETERS, row, strict=True)))
        motion = vp.simulate(e, 20 * e.period, samples_per_period=0)
        assert motion.sizes["impact"] == pytest.approx(40, abs=2)
    runs = [newmark_item().find(name).build() for name in ("in lanes", "textbook loop")]
    assert runs[0].units == 128 * runs[1].units


@pytest.mark.skipif(not llvm.get_host_cpu_features().get("avx"), reason="no wide vector registers")
def test_a_stride_is_made_of_packed_instructions():
    """Products and sums of all steps act on whole vector registers of motions."""
    stride = newmark_lanes.advance_block
    # compiled anew, since the assembly of cached code is not available
    fresh = numba.jit(**stride.targetoptions)(stride.py_func)
    block, sin_cos = np.zeros(newmark_lanes.SIZE), np.zeros(2 * newmark_lanes.STRIDE)
    fresh(block, sin_cos, newmark_lanes.STRIDE)
    (code,) = fresh.inspect_asm().values()
    packed = {
        name: len(re.findall(rf"\bv{name}pd\s[^\n]*%[yz]mm", code)) for name in ("mul", "add")
    }
    # a step has eight products and eight sums
    assert packed["mul"] >= 8 * newmark_lanes.STRIDE
    assert packed["add"] >= 8 * newmark_lanes.STRIDE
