"""Every call ends: its marches take a bounded number of steps, for all finite parameters."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import ExitStack, suppress
from typing import Any
from unittest.mock import patch

import numba
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import vibropipe as vp
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


@pytest.mark.filterwarnings("ignore::vibropipe.UnsolvedWarning")
@pytest.mark.parametrize("kind", CALLS)
@settings(max_examples=3, deadline=None)
@given(exciter=exciters)
def test_every_call_ends(kind: str, exciter: vp.Exciter) -> None:
    check(kind, exciter)


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::vibropipe.UnsolvedWarning")
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
    found, n_threads = [], numba.get_num_threads()
    try:
        for n in (1, n_threads):
            numba.set_num_threads(n)
            found.append(AttractorSet(SOFT).settle(scattered_starts(SOFT, 1200)))
    finally:
        numba.set_num_threads(n_threads)
    np.testing.assert_array_equal(*found)
    assert 0.1 < (found[0][0] < 0).mean() < 0.9


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
    monkeypatch.setattr(boundary_points, "MAX_CALL_WORK", 10**6)
    monkeypatch.setattr(boundary_points, "START_WORK", 0)
    with pytest.warns(vp.UnsolvedWarning, match="in the steps of one call"):
        vp.boundary(SOFT, "grazing", within=((0.8, 1.2), (0.6, 1.0)), lines=2)
