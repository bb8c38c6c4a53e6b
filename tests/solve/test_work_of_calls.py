"""Every call ends, for all finite parameters, contacts of enormous stiffness or damping among them."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from contextlib import ExitStack, suppress
from typing import Any
from unittest.mock import patch

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mp_contacts import contacts_of_support_1
from orbit_motions import motion_of

import vibropipe as vp
from vibropipe.lab.bench_items import limit_threads
from vibropipe.march.grid import exact_grid
from vibropipe.march.log import COMPUTED, STEPS, new_log, work_of
from vibropipe.orbits.law.marching import Marcher
from vibropipe.physics.effects import ALL_EFFECTS
from vibropipe.physics.limits import MAX_CALL_WORK, MAX_MARCH_STEPS, MAX_TABLE
from vibropipe.solve.basins import attractor_set, section_map
from vibropipe.solve.basins.attractor_set import AttractorSet
from vibropipe.solve.basins.attractors import scattered_starts
from vibropipe.solve.basins.section_map import SectionMap
from vibropipe.solve.boundary import boundary_points
from vibropipe.solve.branch import branch_of_pieces
from vibropipe.solve.motion.run import MotionRequest, run_motion
from vibropipe.solve.rows import many
from vibropipe.words.regimes import Regime
from vibropipe.words.status import Status

SOFT = vp.Exciter(l=0.5, nu=1.0, f=0.8, h=0.15, k1=100.0, h1=0.1, R2=0.7)
wide = st.floats(-8.0, 12.0).map(lambda exponent: 10.0**exponent)
exciters = st.builds(
    lambda nu, f, h, supports: vp.Exciter(l=0.5, nu=nu, f=f, h=h, **supports),
    st.floats(-3.0, 3.0).map(lambda exponent: 10.0**exponent),
    st.floats(-2.0, 2.0).map(lambda exponent: 10.0**exponent),
    wide | st.just(0.0),
    st.fixed_dictionaries({"k1": wide, "h1": wide, "R2": st.sampled_from([0.3, 0.7, 1.0])})
    | st.fixed_dictionaries({"k1": wide, "h1": wide, "k2": wide, "h2": wide})
    | st.fixed_dictionaries({"R1": st.just(0.7), "friction": st.floats(1e-3, 10.0)}),
)
CALLS: dict[str, Callable[[vp.Exciter], Any]] = {
    "attractors": lambda e: vp.attractors(e, starts=64),
    "basins": lambda e: vp.basins(e, [-0.4, 0.3], [-1.0, 0.7], starts=16),
    "branch": lambda e: vp.branch(e, "nu", 1.5 * e.nu, switch=("flip", "pitchfork")),
    "boundary": lambda e: vp.boundary(
        e, "grazing", within=((e.nu, 1.5 * e.nu), (e.f, 1.5 * e.f)), lines=3
    ),
    "tolerance": lambda e: vp.tolerance(e, {"nu": 0.01 * e.nu}, samples=64),
}


def work_of_call(call: Callable[[], Any]) -> int:
    """Return the steps of all marches of a call, which may refuse its exciter."""
    works: list[int] = []
    marching: list[Any] = []

    def counted(function: Callable[..., int]) -> Callable[..., int]:
        def run(*arguments: Any) -> int:
            works.append(function(*arguments))
            return works[-1]

        return run

    def begun(begin: Callable[..., None]) -> Callable[..., None]:
        def run(self: Any, *arguments: Any) -> None:
            begin(self, *arguments)
            marching.append(self)

        return run

    with ExitStack() as stack:
        for place, name, watch in (
            (many, "solve_piece", counted),
            (section_map, "solve_piece", counted),
            (section_map, "_assign_piece", counted),
            (SectionMap, "__init__", begun),
            (Marcher, "__init__", begun),
        ):
            stack.enter_context(patch.object(place, name, watch(getattr(place, name))))
        stack.enter_context(suppress(vp.ParameterError))
        call()
    assert works
    logs = [each.room[0] if isinstance(each, Marcher) else each._log for each in marching]
    return sum(works) + sum(int(work_of(log)) for log in logs)


def check(kind: str, exciter: vp.Exciter) -> None:
    # That of some seconds: what is shared, the search of attractors before, each row that is solved at the end.
    assert work_of_call(lambda: CALLS[kind](exciter)) < 4 * MAX_CALL_WORK


@pytest.mark.parametrize("kind", CALLS)
@settings(max_examples=3, deadline=None)
@given(exciter=exciters)
def test_every_call_ends(kind: str, exciter: vp.Exciter) -> None:
    check(kind, exciter)


@pytest.mark.slow
@pytest.mark.parametrize("kind", CALLS)
@settings(max_examples=60, deadline=None)
@given(exciter=exciters)
def test_every_call_of_many_ends(kind: str, exciter: vp.Exciter) -> None:
    check(kind, exciter)


@pytest.mark.parametrize(("h", "is_computed"), [(0.2, False), (1e5, True)])
def test_a_step_whose_force_is_in_no_table_counts_as_four(h: float, is_computed: bool) -> None:
    """It takes 19 ns in place of 4: overdamped starts of basins took 30 s of a core."""
    exciter = vp.Exciter(l=0.5, nu=5.0, f=0.1, h=h)
    grid = exact_grid(ALL_EFFECTS, exciter.parameters())
    request = MotionRequest(0.0, 2 * exciter.period, 0.1, 0.0, 0, effects=ALL_EFFECTS)
    run = run_motion(exciter, request, grid)
    assert (grid.steps > MAX_TABLE) == is_computed
    assert run.counts[STEPS] > grid.steps
    assert run.counts[COMPUTED] == run.counts[STEPS] * is_computed
    assert work_of(new_log(1, 1)._replace(counts=run.counts)) >= run.counts[STEPS] * 4**is_computed
    span = 0.9 * MAX_MARCH_STEPS / MAX_TABLE * exciter.period
    with pytest.raises(vp.ParameterError, match=r"at most 1\.5e\+08 steps"):
        vp.simulate(exciter, span, method="newmark", steps_per_period=MAX_TABLE + 1)


def test_starts_that_the_work_does_not_suffice_for_do_not_depend_on_threads(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(attractor_set, "MAX_CALL_WORK", 10**6)
    monkeypatch.setattr(attractor_set, "START_WORK", 10**3)
    with limit_threads(1):
        alone = AttractorSet(SOFT).settle(scattered_starts(SOFT, 1200))
    np.testing.assert_array_equal(alone, AttractorSet(SOFT).settle(scattered_starts(SOFT, 1200)))
    assert 0.1 < (alone[0] < 0).mean() < 0.9


def test_points_of_a_branch_that_the_work_does_not_suffice_for_have_a_status(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    whole = vp.branch(SOFT, "nu", 1.5)
    monkeypatch.setattr(branch_of_pieces, "MAX_CALL_WORK", 2 * 10**4)
    part = vp.branch(SOFT, "nu", 1.5)
    is_cut = part.status == Status.MAX_STEPS
    assert 0.1 < is_cut.mean() < 0.9
    assert (part.status[~is_cut] == Status.OK).all()
    np.testing.assert_array_equal(part.nu, whole.nu)
    np.testing.assert_array_equal(
        part.displacement_strobe[~is_cut], whole.displacement_strobe[~is_cut]
    )


def test_boundaries_whose_work_is_spent_say_so(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(boundary_points, "MAX_CALL_WORK", 10**4)
    monkeypatch.setattr(boundary_points, "START_WORK", 0)
    with pytest.warns(vp.UnsolvedWarning, match="in the steps of one call"):
        vp.boundary(SOFT, "grazing", within=((0.8, 1.2), (0.6, 1.0)), lines=2)


# Creep of first order, contacts of a millionth of the period, masses pressed on the support.
CASES: list[dict[str, float]] = [
    {"k1": 1.0, "h1": 1e9},
    {"k1": 1e-6, "h1": 1e7},
    {"k1": 1e4, "h1": 1e12},
    {"k1": 1e8, "h1": 3e3},
    {"k1": 1e12, "h1": 1e5},
    {"k1": 1e8, "h1": 3e3, "delta": -0.6, "f": 0.05},
    {"k1": 1e10, "h1": 1e5, "delta": -0.6, "f": 0.3},
    {"k1": 1e8, "h1": 1e6, "delta": -0.6, "f": 0.3},
]


@pytest.mark.parametrize("case", CASES)
def test_motions_agree_with_their_closed_form(case: dict[str, float]) -> None:
    exciter = vp.Exciter(**{"l": 0.5, "nu": 1.0, "f": 0.8, "h": 0.15, **case})
    start = exciter.upper - 0.2
    motion = vp.simulate(exciter, 4.0, x0=start, samples_per_period=0, energy=True)
    assert motion.status == Status.OK
    contacts, end = contacts_of_support_1(exciter, 4.0, start)
    assert motion.impact_support.values.tolist() == [1] * len(contacts)
    expected = np.array(contacts).T
    ended = np.isfinite(expected[2])
    np.testing.assert_allclose(motion.impact_tau, expected[0], rtol=1e-14)
    np.testing.assert_allclose(motion.impact_velocity, expected[1], rtol=1e-13)
    np.testing.assert_allclose(motion.contact_duration[ended], expected[2][ended], rtol=1e-12)
    np.testing.assert_allclose(float(motion.displacement_end), end[0], atol=1e-14)
    np.testing.assert_allclose(float(motion.velocity_end), end[1], atol=1e-14)
    assert abs(float(motion.energy_residual)) < 1e-13


def test_steady_states_with_slow_contacts() -> None:
    """The support stops the mass like a rigid one with R = 0 that does not let go at once."""
    exciter = vp.Exciter(l=0.5, nu=1.0, f=0.8, h=0.15, k1=1.0, h1=1e9, R2=0.6)
    row = vp.steady_state(exciter)
    assert row.status == Status.OK
    marched = motion_of(exciter, row)
    assert float(marched.displacement_end) == pytest.approx(
        float(row.displacement_strobe), abs=1e-12
    )
    assert np.isfinite(row.displacement_amplitude).all()


@pytest.mark.slow
def test_a_vibration_in_contact_that_never_decays_has_a_status() -> None:
    exciter = vp.Exciter(l=0.5, nu=1.0, f=0.01, h=0.0, k1=1e12, delta=-0.6)
    with pytest.warns(vp.UnsolvedWarning, match="too many steps"):
        motion = vp.simulate(exciter, 200.0, x0=exciter.upper + 1e-13, samples_per_period=0)
    assert motion.status == Status.MAX_STEPS


@settings(max_examples=30, deadline=60_000)
@given(
    k1=wide,
    h1=wide,
    k2=st.none() | wide,
    h=wide | st.sampled_from([0.0, 0.15]),
    energy=st.booleans(),
)
def test_every_motion_ends(k1: float, h1: float, k2: float | None, h: float, energy: bool) -> None:
    """With a status, a refusal or a motion between or shortly beyond the supports."""
    others: dict[str, Any] = {} if k2 is None else {"k2": k2}
    exciter = vp.Exciter(l=0.5, nu=1.0, f=0.8, h=h, k1=k1, h1=h1, **others)
    if h > 1e5:  # free flights have too many steps
        with pytest.raises(vp.ParameterError, match="tau_end: must be reached in at most"):
            vp.simulate(exciter, 1e3, energy=energy, x0=0.5)
        return
    motion = vp.simulate(exciter, 20.0, energy=energy)
    if motion.status == Status.OK:
        assert math.isfinite(float(motion.displacement_end))
        if energy:
            scale = max(1.0, abs(float(motion.energy_input)))
            assert abs(float(motion.energy_residual)) < 1e-10 * scale


@settings(max_examples=15, deadline=None)
@given(k1=wide, h1=wide, h=wide | st.just(0.0), nu=st.floats(-3.0, 3.0).map(lambda n: 10.0**n))
def test_every_row_ends(k1: float, h1: float, h: float, nu: float) -> None:
    """Two rows take at most the work of two, a second of an idle core each."""
    exciter = vp.Exciter(l=0.5, nu=nu, f=0.8, h=h, k1=k1, h1=h1)
    began = time.process_time()
    rows = vp.sweep(exciter, {"nu": [nu, 1.1 * nu]}, outputs=())
    assert time.process_time() - began < 60.0  # compiling included
    unresolved = rows.regime == Regime.UNRESOLVED
    assert np.isin(rows.status.values, [int(each) for each in Status]).all()
    assert not (unresolved & (rows.status == Status.OK)).any()
