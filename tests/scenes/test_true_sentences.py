"""Sentences on datasets at which an earlier form of them was false: ties, unknown rows, and few of them."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr
from figures.sample_datasets import sweep

import vibropipe as vp
from vibropipe.scenes.accuracy.summary import multiple_text
from vibropipe.scenes.basins.report import starts_text
from vibropipe.scenes.basins.text import percent
from vibropipe.scenes.motion.captions import seen_text
from vibropipe.scenes.sweep.answers import hardest_answer, sweep_answers, unresolved_answer
from vibropipe.scenes.sweep.moves import fills_answer, impacts_answer, moves_answer
from vibropipe.scenes.sweep.neighbours import border_text, jump_steps, jumps_of
from vibropipe.scenes.sweep.quantities import Series
from vibropipe.scenes.sweep.report import lines_table, motions_table
from vibropipe.scenes.sweep.sweep_rows import strikes
from vibropipe.scenes.sweep.titles import largest_title
from vibropipe.words.regimes import Regime
from vibropipe.words.vocabulary import describe


def line(regimes: list[int], first: list[float], second: list[float]) -> xr.Dataset:
    """Return rows along x0 with the velocities on both supports."""
    dataset = sweep(31).isel(nu=slice(0, len(regimes)), drop=True).copy(deep=True)
    dataset["regime"].values[:] = regimes
    velocities = np.stack([first, second], axis=-1)
    dims = dataset["impact_velocity_max"].transpose("nu", "support").dims
    attrs = dataset["impact_velocity_max"].attrs
    return dataset.assign(impact_velocity_max=(dims, velocities, attrs))


ONE, TWO, BOTH, NONE = Regime.ONE_SIDED_1, Regime.ONE_SIDED_2, Regime.TWO_SIDED, Regime.NO_IMPACT
OPEN = Regime.UNRESOLVED
NAN = float("nan")


def test_rows_without_a_result_may_strike() -> None:
    unknown = line([NONE, NONE, OPEN], [NAN] * 3, [NAN] * 3)
    told = hardest_answer(unknown)
    assert told is not None
    assert told.lead == "No row with a result strikes a support."
    assert hardest_answer(line([OPEN] * 3, [NAN] * 3, [NAN] * 3)) is None
    known = line([NONE] * 3, [NAN] * 3, [NAN] * 3)
    assert hardest_answer(known) is None
    leads = [answer.lead for answer in sweep_answers(known)]
    assert [lead for lead in leads if "support" in lead] == [  # once
        "The mass strikes no support in any row along ν."
    ]


@pytest.fixture(scope="module")
def pressed() -> xr.Dataset:
    """Return rows of a mass that strikes a support, and from 0.6 on lies on it for good."""
    exciter = vp.Exciter(l=0.5, nu=0.9, f=0.1, h=0.1, R1=0.7, R2=0.7)
    return vp.sweep(exciter, {"delta": np.linspace(0.3, 0.9, 13)})


def test_a_mass_that_lies_on_a_support_strikes_none(pressed: xr.Dataset) -> None:
    lies = pressed["impacts_per_orbit"].sum("support").values == 0
    at_rest = (pressed["regime"].values == Regime.WITH_REST) & lies
    assert at_rest.tolist() == [False] * 6 + [True] * 7
    assert strikes(pressed).values.tolist() == [True] * 6 + [False] * 7
    assert " up to both ends" not in impacts_answer(pressed).lead
    assert lines_table("a", pressed).as_data()["rows"][0][1:3] == ["0.30 … 0.55", "6 of 13"]
    assert border_text(pressed, "delta").startswith("Impacts end")


def test_a_motion_that_dies_out_does_not_jump(pressed: xr.Dataset) -> None:
    assert jumps_of(pressed, "delta") == []
    x, struck = np.arange(8.0), np.full(8, int(Regime.TWO_SIDED))
    up_and_down = np.array([1.0, 1.0, 1.0, 3.0, 1.0, 1.0, 1.0, 1.0])
    assert jump_steps(x, up_and_down, struck).tolist() == [2, 3]
    assert jump_steps(x, np.array([1.0, 1.0, 1.0, 2.0, 3.0, 3.0, 3.0, 3.0]), struck).size == 0


def test_the_same_velocity_in_several_rows_has_no_row() -> None:
    apart = hardest_answer(line([ONE, NONE, TWO], [0.5, NAN, NAN], [NAN, NAN, 0.5]))
    assert apart is not None
    assert ", on one support or the other." in apart.lead
    assert "in the row" not in apart.rest
    both = hardest_answer(line([BOTH, NONE, TWO], [0.5, NAN, NAN], [0.5, NAN, 0.4]))
    assert both is not None
    assert ", on both supports." in both.lead
    assert "in the row" in both.rest


def test_equal_sizes_of_either_sign_have_no_place() -> None:
    dataset = line([BOTH] * 3, [0.5] * 3, [0.5] * 3)
    dataset["displacement_mean"] = "nu", [0.1, 0.0, -0.1]
    assert "at" not in largest_title(dataset, Series("displacement_mean", None, None, "")).split()


def test_a_harmonic_that_is_largest_in_no_row_has_no_place() -> None:
    dataset = sweep(6, f=[1.0, 2.0]).copy(deep=True)
    first = Series("displacement_amplitude", "harmonic", 0)
    amplitude = dataset["displacement_amplitude"].transpose("nu", "f", "harmonic")

    def title(values: np.ndarray) -> str:
        own = np.broadcast_to(values[..., None], amplitude.shape)
        found = amplitude.dims, own.copy(), amplitude.attrs
        regime = xr.full_like(dataset["regime"], BOTH)
        return largest_title(dataset.assign(displacement_amplitude=found, regime=regime), first)

    assert title(np.full((6, 2), 0.3)) == "The first harmonic is the same in all rows"
    rising = np.linspace(0.1, 0.2, 6)[:, None] * np.ones(2)
    nu = dataset["nu"].values[-1]
    assert title(rising) == (
        f"On the grid, the first harmonic is largest at ν = {nu:.4g}, the end of its range"
    )
    noise = np.zeros((6, 2))
    noise[2, 1] = 1e-14  # of a mass that rests on a support
    assert title(noise) == "First harmonic amplitude of displacement"


def test_regions_of_one_size_are_equally_frequent() -> None:
    dataset = sweep(4, f=[1.0, 2.0]).copy(deep=True)
    dataset["regime"].values[:] = [[NONE, ONE]] * 4
    assert fills_answer(dataset).lead == "No way to move is the most frequent."
    dataset["regime"].values[0] = NONE
    assert fills_answer(dataset).lead == "In most of the map the mass strikes no support."


@pytest.mark.parametrize(
    ("forces", "lead"),
    [
        ([0.1, 0.2], "The mass does not move in any row along f."),
        ([0.31, 0.35], "The mass strikes no support in any row along f."),
    ],
)
def test_a_mass_that_friction_holds_does_not_move(forces: list[float], lead: str) -> None:
    exciter = vp.Exciter(0.5, nu=1.5, h=0.1, R1=0.7, R2=0.7, friction=0.3)
    assert moves_answer(vp.sweep(exciter, {"f": forces})).lead == lead


def test_a_line_with_unknown_rows_may_have_impacts() -> None:
    dataset = sweep(4, f=[1.0, 2.0]).copy(deep=True)
    dataset["regime"].values[:] = np.transpose([[NONE, ONE, ONE, NONE], [NONE, OPEN, OPEN, NONE]])
    assert "Some lines have none" not in impacts_answer(dataset).rest
    dataset["regime"].values[:, 1] = NONE
    assert "Some lines have none" in impacts_answer(dataset).rest


def test_one_row_is_one() -> None:
    one = unresolved_answer(line([OPEN, NONE, NONE], [NAN] * 3, [NAN] * 3))
    assert one is not None
    assert one.lead == "1 of 3 rows is unresolved."
    both = unresolved_answer(line([OPEN, Regime.UNBOUNDED, Regime.UNBOUNDED], [NAN] * 3, [NAN] * 3))
    assert both is not None
    assert both.lead == "1 row is unresolved and 2 rows are unbounded."


@pytest.mark.parametrize(("share", "text"), [(0.9999, "99.9\u00a0%"), (1.0, "100\u00a0%")])
def test_a_part_is_not_all(share: float, text: str) -> None:
    assert percent(share) == text


def test_at_least_is_rounded_down() -> None:
    assert [multiple_text(ratio, np.floor) for ratio in (53.6, 9960.0, 54.0)] == [
        "53",
        "9,900",
        "54",
    ]
    assert [multiple_text(ratio) for ratio in (53.6, 9960.0, 1.12)] == ["54", "10,000", "1.1"]


def test_rows_that_are_followed_are_told_as_such(pressed: xr.Dataset) -> None:
    followed = pressed.assign_attrs(follow="delta down")
    assert impacts_answer(followed).lead.startswith("Followed downwards, impacts occur ")
    table = motions_table("a", followed)
    assert table is not None
    assert "border" not in table.note
    assert "border" in motions_table("a", pressed).note


def test_none_of_the_starts_are_told_as_none() -> None:
    starts = xr.Dataset(coords={"x0": [0.0, 0.1], "v0": [0.0, 0.1]})
    told = [starts_text(starts, amount) for amount in (0.0, 0.25, 0.5)]
    assert told == [
        "none of 4 starts settles on", "one of 4 starts settles on", "two of 4 starts settle on",
    ]  # fmt: skip


def test_a_rest_from_the_beginning_is_no_rest_at_times() -> None:
    pressed = vp.Exciter(l=0.5, nu=0.9, f=0.1, h=0.1, R1=0.7, R2=0.7, load=0.8)
    lies = vp.simulate(pressed, 20.0)
    assert seen_text(lies) == "No support is struck; the mass lies on support 1 all the time"
    bounces = vp.simulate(pressed, 20.0, x0=0.3)
    assert seen_text(bounces).endswith("; the mass rests at times")


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("contact_duration_max", "the contact of orbits at support 1 is longest"),
        ("support_force_max", "the force of orbits at support 1 is largest"),
    ],
)
def test_the_title_of_an_extreme_contact_is_a_sentence(name: str, words: str) -> None:
    values = np.array([[0.2, 0.1], [0.3, 0.1], [np.nan, np.nan]])
    dataset = line([BOTH, BOTH, Regime.APERIODIC], *values.T)
    dataset = describe(dataset.assign({name: (("nu", "support"), values)}))
    nu = dataset["nu"].values[1]
    title = largest_title(dataset, Series(name, "support", 0, ""))
    assert title == f"On the grid, {words} at ν = {nu:g}"


def test_one_way_to_move_has_no_table_of_ranges() -> None:
    dataset = line([BOTH] * 3, [0.5, 0.6, 0.7], [0.5, 0.6, 0.7])
    assert motions_table("a", dataset) is None
    dataset["regime"][0] = NONE
    assert len(motions_table("a", dataset).rows) == 2


def test_rows_that_slide_away_are_not_counted_as_rows_without_impacts() -> None:
    """A housing that slides away is struck in each row, none of which has an orbit."""
    exciter = vp.Exciter(
        l=0.5, f=0.5, h=0.1, R1=0.6, R2=0.6, mass_ratio=0.5, housing_load=0.4,
        housing_friction_1=0.05, housing_friction_2=0.05,
    )  # fmt: skip
    away = vp.sweep(exciter, {"nu": np.linspace(0.8, 2, 4)}, follow=("nu", "both"))
    assert (away.regime == Regime.UNBOUNDED).all()
    assert (away.impacts_per_period > 0).any()
    assert lines_table("a", away) is None
    assert lines_table(
        "a", line([BOTH, NONE, OPEN], [1.0, NAN, NAN], [1.0, NAN, NAN])
    ).note.endswith("Rows without a result may have impacts, too.")
