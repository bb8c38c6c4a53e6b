"""The effects that parameters need, and the bounds that prove a support out of reach."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from strategies import log

import vibropipe as vp
from vibropipe.physics.bounds import linear_bound, state_norm_bound, ultimate_bound
from vibropipe.physics.effects import (
    ALL_EFFECTS,
    all_effect_names,
    effect_names,
    effects_from_names,
    effects_of,
    missing_effect,
    resolve_effects,
)
from vibropipe.words.parameters import COMMON_EFFECTS

FORCED = {"nu": 1.0, "f": -1.0, "h": 0.2, "l": 0.5, "delta": 0.0, "R1": 0.7, "R2": 0.7}
FAR_2 = {"l": 100.0, "delta": -99.5}  # support 1 at 0.5, support 2 at -199.5
FAR_1 = {"l": 100.0, "delta": 99.5}


@pytest.mark.parametrize(
    ("changed", "start", "called_for"),
    [
        ({}, (0.0, 0.0), set(COMMON_EFFECTS)),
        ({"h": 0.0}, (0.0, 0.0), set(COMMON_EFFECTS) - {"damping"}),
        ({"f": 0.0}, (0.0, 0.6), {"damping", "support_1", "support_2", "restitution"}),
        ({"f": 0.0}, (0.0, 0.4), {"damping"}),
        ({"f": 0.0, "delta": 0.5}, (0.2, 0.6), {"damping", "support_2", "restitution", "rest"}),
        ({"f": 0.4}, (0.0, 0.6), set(COMMON_EFFECTS) - {"rest"}),
        ({"R1": 1.0, "R2": 1.0}, (0.0, 0.0), set(COMMON_EFFECTS) - {"restitution"}),
        ({"f": 0.01}, (0.0, 0.0), {"damping", "forcing"}),
        ({**FAR_2, "f": 0.3}, (0.0, 0.0), {"damping", "forcing", "support_1", "restitution"}),
        ({**FAR_1, "f": 0.3}, (0.0, 0.0), {"damping", "forcing", "support_2", "restitution"}),
        # the restitution of a support out of reach does not count
        (
            {**FAR_2, "f": 0.3, "R1": 1.0, "R2": 0.5},
            (0.0, 0.0),
            {"damping", "forcing", "support_1"},
        ),
        ({**FAR_2, "h": 0.0}, (0.0, 0.0), set(COMMON_EFFECTS) - {"damping"}),
    ],
)
def test_effects_follow_from_parameters_and_start(
    changed: dict[str, float], start: tuple[float, float], called_for: set[str]
) -> None:
    assert set(effect_names(effects_of({**FORCED, **changed}, *start))) == called_for


@pytest.mark.parametrize(
    ("further", "named"),
    [
        ({"k1": 50.0}, ["soft"]),
        ({"k2": np.array([0.0, 50.0])}, ["soft"]),
        ({"friction": 0.1}, ["friction"]),
        ({"k1": 50.0, "friction": 0.1}, ["soft", "friction"]),
        ({"friction": 0.1, "mass_ratio": 0.5}, ["friction", "housing"]),
    ],
)
def test_a_kernel_that_holds_more_names_what_the_parameters_have(
    further: dict[str, Any], named: list[str]
) -> None:
    names = all_effect_names({**FORCED, **further}, pieces=True, housing=True)
    assert names == (*COMMON_EFFECTS, *named)


def test_a_short_motion_cannot_reach_the_supports() -> None:
    undamped = {**FORCED, "h": 0.0, "f": 0.1}
    assert effect_names(effects_of(undamped, 0.0, 0.0, 4.9)) == ("forcing",)
    assert "support_1" in effect_names(effects_of(undamped, 0.0, 0.0, 5.1))
    # the bound is not proven for Newmark's method
    assert "support_1" in effect_names(effects_of(undamped, 0.0, 0.0, 4.9, exact=False))


def test_a_grid_has_the_effects_of_all_its_rows() -> None:
    grid = {**FORCED, "f": [0.0, 0.1], "h": [0.0, 0.3], "R2": [0.5, 1.0]}
    assert set(effect_names(effects_of(grid, 0.0, 0.4))) == set(COMMON_EFFECTS) - {"rest"}
    # resonance lies inside the range, not at its ends
    nu = np.linspace(0.5, 1.5, 101)
    off = {**FORCED, "f": 0.06, "nu": [0.5, 1.5]}
    assert "support_1" not in effect_names(effects_of(off, 0.0, 0.0))
    assert "support_1" in effect_names(effects_of({**off, "nu": nu, "h": 0.05}, 0.0, 0.0))


def test_rows_that_follow_each_other_have_no_bound() -> None:
    weak = {**FORCED, "f": 0.01}
    assert "support_1" not in effect_names(effects_of(weak, 0.0, 0.0))
    assert "support_1" in effect_names(effects_of(weak, 0.0, 0.0, followed=True))


def test_all_effects_where_nothing_is_stated() -> None:
    assert resolve_effects(None, FORCED, 0.0, 0.0) == ALL_EFFECTS
    assert effect_names(ALL_EFFECTS) == COMMON_EFFECTS
    assert effects_from_names(COMMON_EFFECTS) == ALL_EFFECTS


@pytest.mark.parametrize("name", ["damping", "forcing", "restitution", "rest"])
def test_an_effect_that_the_parameters_need_cannot_be_left_out(name: str) -> None:
    names = [other for other in COMMON_EFFECTS if other != name]
    must, found = missing_effect(names, FORCED, 0.0, 0.0) or ("", "")
    assert must.startswith(f"must include {name} unless ")
    assert found.startswith(f"{', '.join(names)} with ")
    with pytest.raises(vp.ParameterError) as error:
        resolve_effects(names, FORCED, 0.0, 0.0)
    assert str(error.value) == f"effects: {must}, got {found}"


def test_a_support_left_out_is_watched_unless_it_is_out_of_reach() -> None:
    names = [name for name in COMMON_EFFECTS if name != "support_2"]
    watched = resolve_effects(names, FORCED, 0.0, 0.0)
    assert watched == ALL_EFFECTS._replace(watched=2)
    assert "support_2" not in effect_names(watched)
    proven = resolve_effects(names, {**FORCED, **FAR_2}, 0.0, 0.0)
    assert proven == ALL_EFFECTS._replace(support_2=None)


def test_effects_that_are_not_needed_may_be_stated() -> None:
    assert resolve_effects(COMMON_EFFECTS, {**FORCED, "f": 0.0, "h": 0.0}, 0.0, 0.0) == ALL_EFFECTS


def test_an_unknown_effect_is_named() -> None:
    with pytest.raises(
        vp.ParameterError, match=r"effects: must be among damping, forcing.*, got 'magnetism'"
    ):
        effects_from_names(["magnetism"])


# -- the bounds --------------------------------------------------------------------------------


@settings(max_examples=100)
@given(
    nu=log(-1, 1),
    h=log(-1.5, 1.5),
    f=log(-1, 1),
    l=log(-1, 1),
    offset=st.floats(-1, 1),
    R=st.floats(0, 1),
    v=st.floats(-2, 2),
)
@example(nu=1.0, h=2.0, f=1.0, l=0.5, offset=0.0, R=1.0, v=0.0)
@example(nu=1.0, h=0.05, f=1.0, l=5.0, offset=-0.9, R=1.0, v=0.5)
def test_no_motion_leaves_its_bounds(**drawn: Any) -> None:
    f, half = drawn["f"], drawn["l"]
    shape = {"nu": drawn["nu"], "f": f, "h": drawn["h"], "l": half}
    shape["delta"] = drawn["offset"] * half
    exciter = vp.Exciter(**shape, R1=drawn["R"], R2=drawn["R"])
    x0 = exciter.delta
    motion = vp.simulate(exciter, tau_end=20.0, x0=x0, v0=drawn["v"], samples_per_period=64)
    norm = np.hypot(motion.displacement, motion.velocity)
    start = math.hypot(x0, drawn["v"])
    assert (norm <= (start + f * motion.tau) * (1 + 1e-12)).all()
    assert norm.max() <= ultimate_bound(drawn["h"], f, start)
    if motion.impact_tau.size == 0 and motion.rest_start.size == 0:
        assert norm.max() <= linear_bound(drawn["nu"], drawn["h"], f, start)
    grid = {name: np.atleast_1d(value) for name, value in exciter.parameters()._asdict().items()}
    assert norm.max() <= state_norm_bound(grid, x0, drawn["v"], 20.0, False)


def test_the_linear_bound_is_infinite_at_resonance() -> None:
    assert linear_bound([0.5, 1.0], 0.0, 0.1, 0.0).tolist() == [pytest.approx(4 / 15), math.inf]


def test_a_load_is_an_effect_without_a_kernel_of_its_own() -> None:
    loaded = {**FORCED, "load": 0.2}
    assert effects_of(loaded, -0.2, 0.0) == ALL_EFFECTS
    assert effect_names(ALL_EFFECTS, loaded) == (*COMMON_EFFECTS, "load")
    with pytest.raises(vp.ParameterError, match=r"must include load unless load = 0, .* 0\.2$"):
        resolve_effects(COMMON_EFFECTS, loaded, -0.2, 0.0)
    assert resolve_effects((*COMMON_EFFECTS, "load"), loaded, -0.2, 0.0) == ALL_EFFECTS


def test_a_load_moves_a_support_within_and_out_of_reach() -> None:
    weak = {**FORCED, "nu": 3.0, "f": 0.4, "load": 0.0}
    off = {"support_1", "support_2"} & {*effect_names(effects_of(weak, 0.0, 0.0))}
    assert not off
    assert "support_1" in effect_names(effects_of({**weak, "load": 0.45}, 0.0, 0.0))
    # The load of all rows counts, those that press on a support included.
    assert "rest" in effect_names(effects_of({**weak, "load": [0.0, 0.45]}, 0.0, 0.0))
