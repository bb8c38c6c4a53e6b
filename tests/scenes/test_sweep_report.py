"""Part of the report on sweeps: findings in sentences, rows by regime, regimes along each line."""

import re

import numpy as np
import pytest
import xarray as xr
from figures.sample_datasets import sweep

import vibropipe as vp
from vibropipe.scenes.sweep.answers import hardest_answer, mean_answer, sweep_answers
from vibropipe.scenes.sweep.bifurcation import bifurcation_title
from vibropipe.scenes.sweep.captions import starts_text
from vibropipe.scenes.sweep.laws import regions_of, share_text
from vibropipe.scenes.sweep.moves import impacts_answer
from vibropipe.scenes.sweep.neighbours import border_text, doubling_answer, jumps_of
from vibropipe.scenes.sweep.quantities import exponent_ends
from vibropipe.scenes.sweep.report import (
    answers,
    motions_table,
    tables,
    together_table,
    together_text,
)
from vibropipe.scenes.sweep.titles import energy_title, exponent_title
from vibropipe.words.regimes import Regime
from vibropipe.words.vocabulary import describe


def said(dataset: xr.Dataset) -> list[str]:
    """Return the answers of a sweep as sentences."""
    return [f"{answer.lead} {answer.rest}".strip() for answer in sweep_answers(dataset)]


def one_line() -> xr.Dataset:
    """Return a sweep along nu with impacts from 0.9 to 1.6, where it jumps to no impact, a period-2 part within."""
    nu = np.round(np.arange(0.5, 2.05, 0.1), 10)
    struck, doubled = (nu > 0.85) & (nu < 1.65), (nu > 1.15) & (nu < 1.25)
    amplitude = np.where(struck, 0.4 + 0.05 * nu, 0.1)
    amplitude[nu < 0.85] = [0.3, 0.33, 0.37, 0.41]  # a steep resonance is no jump
    velocity = np.where(struck, nu, np.nan)
    data = {
        "regime": ("nu", np.where(struck, Regime.TWO_SIDED, Regime.NO_IMPACT).astype(np.int8)),
        "period_multiple": ("nu", np.where(doubled, 2, 1)),
        "stable": ("nu", np.ones(nu.size, np.int8)),
        "displacement_mean": ("nu", np.where(struck, -0.01 * nu, 0.0)),
        "displacement_amplitude": (("nu", "harmonic"), amplitude[:, None]),
        "impact_velocity_max": (("nu", "support"), np.stack([velocity, 0.5 * velocity], -1)),
    }
    coords = {"nu": nu, "harmonic": [1], "support": [1, 2]}
    return describe(xr.Dataset(data, coords))


def test_answers_of_a_line():
    assert list(answers({"response": one_line()})) == ["response"]
    assert said(one_line()) == [
        "With rising ν the mass strikes no support, then both supports, then no support. "
        "Impacts begin between ν = 0.8 and 0.9.",
        "The hardest impact of an orbit is 1.6, on support 1. It occurs in the row ν = 1.6.",
        "The first harmonic jumps between ν = 1.6 and 1.7.",
    ]
    mean = mean_answer(one_line())
    assert mean.lead == "The mean displacement reaches −0.016."
    assert mean.rest == "That is in the row ν = 1.6."
    one = one_line().isel(nu=[10])
    assert mean_answer(one).rest == ""  # which row it is has no need to be said
    assert hardest_answer(one).rest == ""


def test_the_hardest_impact_of_several_lines_has_a_place():
    lines = xr.concat(
        [one_line(), one_line().assign(impact_velocity_max=2 * one_line()["impact_velocity_max"])],
        xr.DataArray([0.1, 0.2], dims="f", name="f"),
    )
    assert hardest_answer(lines).rest == (
        "It occurs at ν = 1.6 and still rises at the end of the range of f."
    )


def test_a_value_at_an_end_of_the_range_still_rises():
    line = one_line().isel(nu=slice(0, 11))
    assert said(line)[1] == (
        "The hardest impact of an orbit is 1.5, on support 1. "
        "It still rises at the end of the range of ν."
    )


def test_equal_impacts_on_both_supports_are_said_once():
    line = one_line()
    velocity = line["impact_velocity_max"].sel(support=1).drop_vars("support")
    both = xr.concat([velocity, velocity], "support").transpose("nu", "support")
    line = line.assign(impact_velocity_max=both.assign_attrs(velocity.attrs))
    assert said(line)[1].startswith("The hardest impact of an orbit is 1.6, on both supports.")


def test_aperiodic_rows_are_told_apart_from_orbits():
    line = one_line()
    regime = line["regime"].copy()
    regime[10:12] = Regime.APERIODIC
    line = line.assign(regime=regime, window_periods=("nu", np.full(16, 128)))
    assert said(line)[1:3] == [
        "The motion does not repeat itself in 2 of 16 rows. That is so in a window of 128 forcing periods; "
        "whether it settles later is not known.",
        "The hardest impact of an orbit is 1.4, on support 1. Aperiodic motion reaches 1.6 within its window.",
    ]


@pytest.mark.parametrize(
    ("regime", "of_line", "of_map"),
    [
        (Regime.NO_IMPACT, "strikes no support in any row along ν", "strikes no support at any point of the map"),
        (Regime.UNRESOLVED, "has no result in any row along ν", "has no result at any point of the map"),
        (Regime.UNBOUNDED, "moves without bound in all rows along ν", "moves without bound at all points of the map"),
    ],
)  # fmt: skip
def test_what_is_so_of_all_rows_is_not_denied_of_some(regime, of_line, of_map, made):
    line, plane = one_line(), made["map"][1].copy(deep=True)
    for dataset, words in ((line, of_line), (plane, of_map)):
        dataset["regime"][:] = regime
        told = said(dataset)
        assert f"The mass {words}." in told
        assert not any("unbounded" in each for each in told)


def test_aperiodic_rows_alone_are_told_once(made):
    line, plane = one_line(), made["map"][1].copy(deep=True)
    for dataset, where in ((line, "in any row"), (plane, "at any point")):
        dataset["regime"][:] = Regime.APERIODIC
        first, *others = said(dataset)
        assert first.startswith(f"The motion does not repeat itself {where}.")
        assert not any("repeat" in other or "repetition" in other for other in others)


def test_few_rows_without_a_result_leave_their_place_to_answers():
    line = (
        one_line().isel(nu=np.repeat(np.arange(16), 10)).assign_coords(nu=np.linspace(0.5, 2, 160))
    )
    line["regime"][100:120] = Regime.APERIODIC
    for amount, place in ((1, []), (2, [2])):
        line["regime"][:amount] = Regime.UNRESOLVED
        told = said(line)
        assert len(told) == 3
        assert [n for n, text in enumerate(told) if "unresolved" in text] == place
        assert any(text.startswith("The hardest impact") for text in told) != bool(place)
    few = line.drop_vars(["impact_velocity_max", "displacement_mean", "displacement_amplitude"])
    few["regime"][1] = few["regime"][0] = Regime.NO_IMPACT
    few["regime"][:1] = Regime.UNRESOLVED
    assert "unresolved" in said(few)[-1]


def test_the_largest_force_of_a_soft_support_is_found():
    line = one_line()
    force = line["impact_velocity_max"].values * [[10.0, np.nan]]
    line = describe(line.assign(support_force_max=(("nu", "support"), force)))
    assert said(line)[1] == (
        "The largest force on a soft support is 16, on support 1. It occurs in the row ν = 1.6."
    )


def test_exponents_count_beyond_their_error():
    line = one_line()
    exponent = np.where(line["nu"] > 1.35, 0.05, -0.2)
    exponent[3] = 1e-4
    line = line.assign(lyapunov_exponent=("nu", exponent))
    line = describe(line.assign(lyapunov_exponent_error=("nu", np.full(16, 1e-3))))
    assert said(line)[0] == (
        "The largest Lyapunov exponent is positive in 7 of 16 rows. "
        "There perturbations grow exponentially; the exponent reaches 0.05."
    )
    quiet = line.assign(lyapunov_exponent=-abs(line["lyapunov_exponent"]))
    assert said(quiet)[0].startswith("No Lyapunov exponent is positive")
    # the standard error of a motion on a torus is often less than its exponent
    near = line.assign(lyapunov_exponent=0.002 * np.sign(line["lyapunov_exponent"]))
    assert said(near)[0] == "No Lyapunov exponent is positive beyond 3 times its error."


def test_undamped_motions_without_impacts_are_not_chaotic():
    line = vp.sweep(
        vp.Exciter(l=0.5, f=0.05, h=0.0),
        {"nu": np.sqrt(np.linspace(0.3, 3.0, 40)[:8])},
        outputs=("harmonics", "lyapunov"),
    )
    assert (line["regime"] == Regime.APERIODIC).all()
    assert (line["lyapunov_exponent"] > line["lyapunov_exponent_error"]).any()  # rounding
    assert said(line)[0] == (
        "No Lyapunov exponent is positive beyond 3 times its error. "
        "Perturbations grow exponentially in no row."
    )
    assert exponent_title(*exponent_ends(line)) == ""


def test_a_coarse_grid_shows_no_jump():
    """A response without impacts is continuous, and a step over a wide gap is no steeper than its neighbours."""
    nu = np.array([0.5, 0.6, 0.7, 0.72, 1.3, 1.32, 1.4, 1.5])
    amplitude = 0.1 / np.hypot(1 - nu**2, 0.05 * nu)
    regime = np.full(nu.size, Regime.NO_IMPACT, np.int8)
    data = {
        "regime": ("nu", regime),
        "displacement_amplitude": (("nu", "harmonic"), amplitude[:, None]),
    }
    line = xr.Dataset(data, {"nu": nu, "harmonic": [1]})
    assert jumps_of(line, "nu") == []
    assert (
        jumps_of(line.assign(regime=("nu", np.where(nu < 1, Regime.TWO_SIDED, regime))), "nu") == []
    )
    even = line.assign_coords(nu=np.linspace(0.5, 1.2, nu.size))
    assert jumps_of(even, "nu") == []
    assert (
        len(jumps_of(even.assign(regime=("nu", np.where(nu < 1, Regime.TWO_SIDED, regime))), "nu"))
        == 1
    )


def followed_both_ways() -> xr.Dataset:
    """Return the line followed up, and down without impacts until nu = 1.2."""
    up, down = one_line(), one_line()
    late = (down["nu"] > 1.25) & (down["nu"] < 1.65)
    down["regime"] = down["regime"].where(~late, Regime.NO_IMPACT)
    down["displacement_amplitude"] = down["displacement_amplitude"].where(~late, 0.1)
    down["displacement_mean"] = down["displacement_mean"].where(~late, 0.0)
    down["impact_velocity_max"] = down["impact_velocity_max"].where(~late)
    ways = xr.DataArray(["up", "down"], dims="direction", name="direction")
    return describe(xr.concat([up, down], ways).assign_attrs(follow="nu both"))


def test_no_jump_is_taken_from_a_followed_sweep():
    """A step leaves a motion early, and the first row of a line continues none."""
    line = one_line()
    assert any("The first harmonic jumps" in text for text in said(line))
    for follow in ("nu up", "nu down"):
        texts = said(line.assign_attrs(follow=follow))
        assert not any("jumps" in text or "Impacts begin" in text for text in texts)
        assert "no border of it" in starts_text(line.assign_attrs(follow=follow))
    assert starts_text(line) == ""


def test_rows_on_two_motions_are_told_of_a_sweep_followed_both_ways():
    both = followed_both_ways()
    text = " ".join(said(both))
    assert (
        "Among the motions followed here, at least two are stable together. "
        "They are in the rows from ν = 1.3 to 1.6." in text
    )
    assert "jumps" not in text
    assert "Followed upwards and downwards, impacts occur only between ν = 0.8 and 1.7." in text
    same = both.copy(deep=True)
    for name in ("regime", "displacement_amplitude", "displacement_mean", "impact_velocity_max"):
        same[name][1] = same[name][0]
    assert "at least two" not in " ".join(said(same))
    # chaos is on no orbit: which motion it is cannot be compared
    chaotic = both.copy(deep=True)
    chaotic["regime"][0, 8:] = Regime.APERIODIC
    assert "at least two" not in " ".join(said(chaotic))
    unstable = both.copy(deep=True)
    unstable["stable"][1] = 0
    assert "at least two" not in " ".join(said(unstable))


def test_ranges_of_two_motions_stand_below_the_table_of_both_directions():
    both = followed_both_ways()
    assert together_text(both) == ""  # one range, which the answer tells
    for name in ("regime", "displacement_amplitude", "displacement_mean", "impact_velocity_max"):
        both[name][1, 9] = both[name][0, 9]  # of nu = 1.4
    both["nu"].attrs["units"] = "rad/s"
    told = (
        "In two ranges of ν the two directions are on different stable motions, the widest first: "
        "1.5 … 1.6 and 1.3 rad/s."
    )
    assert together_text(both) == told
    assert motions_table("s", both).note.endswith(told)
    assert together_table("s", both) is None
    lines = both.expand_dims(f=[0.1, 0.2])
    assert together_text(lines) == ""
    assert together_table("s", lines).head[0] == "line"


def test_a_step_without_steps_on_both_sides_is_no_jump():
    line = one_line()
    assert len(jumps_of(line, "nu")) == 1
    assert not jumps_of(line.isel(nu=[0, 11]), "nu")
    assert not jumps_of(line.isel(nu=slice(11, 14)), "nu")
    assert len(jumps_of(line.isel(nu=slice(10, 14)), "nu")) == 1
    beside = line.copy(deep=True)  # another jump in the row before
    amplitude = beside["displacement_amplitude"].values
    first = int(np.abs(np.diff(amplitude[:, 0])).argmax())
    amplitude[first] = 0.9
    beside = beside.assign(
        displacement_amplitude=(beside["displacement_amplitude"].dims, amplitude)
    )
    assert len(jumps_of(beside, "nu")) == 2
    lost = line["regime"].copy()
    lost[10] = Regime.UNRESOLVED  # the row before the one in front of the jump
    assert not jumps_of(line.assign(regime=lost), "nu")


def test_answers_are_in_the_units_of_the_data():
    line = one_line()
    line["nu"].attrs["units"], line["impact_velocity_max"].attrs["units"] = "rad/s", "mm/s"
    expected = "is 1.6 mm/s, on support 1. It occurs in the row ν = 1.6 rad/s."
    assert said(line)[1].endswith(expected)
    assert said(line)[0].endswith("Impacts begin between ν = 0.8 and 0.9 rad/s.")
    table = tables({"response": line})[0]
    assert table.head[0] == "ν (rad/s)"
    assert table.head[-1] == "hardest impact (mm/s)"


def test_answers_of_a_map_give_shares():
    dataset = sweep(40, f=np.linspace(0.05, 2, 40), all_regimes=True)
    lead, *others = said(dataset)
    is_struck = (dataset["regime"] == Regime.TWO_SIDED).sum()
    assert share_text(int(is_struck), dataset["regime"].size) in lead
    assert not any("jumps" in text for text in others)
    assert "rows are unresolved" in others[-1] or "unbounded" in others[-1]


@pytest.mark.parametrize("name", ["line", "lines", "columns", "map", "bands"])
def test_every_number_of_an_answer_is_in_the_data(name, made):
    """A value or coordinate, an amount of rows, or its share, to a unit of the last digit that is written."""
    dataset = made[name][1]
    amounts = [
        np.unique(codes, return_counts=True)[1]
        for codes in (dataset["regime"], regions_of(dataset)[0])
    ]
    amounts = np.concatenate([*amounts, [dataset["regime"].size]])
    values = [np.ravel(dataset[each].values).astype(float) for each in dataset.variables]
    known = np.concatenate([*values, amounts, 100.0 * amounts / dataset["regime"].size])
    answers_found = sweep_answers(dataset)
    assert 1 <= len(answers_found) <= 3
    for answer in answers_found:
        text = re.sub(r"supports? \d", "", f"{answer.lead} {answer.rest}")
        numbers = re.findall(r"−?\d+(?:\.\d+)?", text)
        assert len(numbers) <= 2, text
        for number in numbers:
            unit = 10.0 ** -len(number.partition(".")[2])
            value = float(number.replace("−", "-"))
            assert np.nanmin(np.abs(known - value)) <= 1.001 * unit, (number, text)


def test_shares_have_the_digits_of_their_amounts():
    assert share_text(457, 1000) == "45.7 %"
    assert share_text(46, 100) == "46 %"
    assert share_text(5, 12) == "5 of 12"
    assert share_text(1, 40000) == "under 0.1 %"
    assert share_text(39999, 40000) == "over 99.9 %"
    assert share_text(40000, 40000) == "100.0 %"


def test_ranges_along_a_line_and_energies_are_tables():
    line = one_line().assign_coords(f=1.0)
    energy = describe(xr.Dataset({"energy_input": ("nu", np.linspace(0.1, 0.2, line.sizes["nu"]))}))
    for name in ("energy_damping", "energy_impact"):
        energy[name] = energy["energy_input"] / 2
    with_friction = energy.assign(energy_friction=energy["energy_input"] / 4)
    ranges, energies = tables({"response": line.merge(with_friction)})
    assert ranges.rows == [
        ["0.5 … 0.8", "no impact", "1", "–"],
        ["0.9 … 1.1", "both supports struck", "1", "1.1"],
        ["1.2", "both supports struck", "2", "1.2"],
        ["1.3 … 1.6", "both supports struck", "1", "1.6"],
        ["1.7 … 2.0", "no impact", "1", "–"],
    ]
    assert energies.rows[0] == ["work of the force", "0.1 … 0.2"]
    assert energies.rows[3] == ["loss by friction", "0.025 … 0.05"]
    for without in (energy, energy.assign(energy_friction=0 * energy["energy_input"])):
        assert len(tables({"response": line.merge(without)})[1].rows) == 3
    # decimals of a grid are those of its step; of values that are rounded here digits are
    for step, texts in (
        (0.95, ["0.475 … 0.760", "0.855 … 1.045"]),
        (4.0 / 3, ["0.66667 … 1.0667"]),
    ):
        rows = tables({"response": line.assign_coords(nu=step * line["nu"])})[0].rows
        assert [row[0] for row in rows][: len(texts)] == texts
    # without a force it does no work, and its periods are none of the motion
    (ranges,) = tables({"response": line.merge(energy).assign_coords(f=0.0)})
    assert ranges.head == ["ν", "how the mass moves", "hardest impact"]
    assert ranges.rows[0] == ["0.5 … 0.8", "no impact", "–"]


def test_lines_and_coexisting_motions_are_tables():
    both = followed_both_ways()
    (lines,) = tables({"response": both})
    assert lines.rows[0] == ["upwards", "0.9 … 1.6", "8 of 16", "1.6"]
    assert lines.rows[1][:2] == ["downwards", "0.9 … 1.2"]
    twice = both.copy(deep=True)
    twice["displacement_amplitude"][1, 4] = 0.3
    (lines,) = tables({"response": twice})
    assert lines.note.endswith(", the widest first: 1.3 … 1.6 and 0.9.")


def test_a_row_without_a_result_is_not_counted_as_one_without_impacts():
    dataset = sweep(31)
    dataset["regime"][:] = Regime.TWO_SIDED
    dataset["regime"][[0, 7]] = Regime.UNRESOLVED
    assert impacts_answer(dataset).lead == "Impacts occur in all rows with a result along ν."
    dataset["regime"][3] = Regime.NO_IMPACT
    assert impacts_answer(dataset).lead == "Impacts occur in some rows along ν."
    still = dataset.assign_attrs(start="x0 = 0 m, v0 = 0 m/s")
    assert impacts_answer(still).lead == "From rest, impacts occur in some rows along ν."
    thrown = dataset.assign_attrs(start="x0 = 0 m, v0 = 0.3 m/s")
    assert impacts_answer(thrown).lead == "Impacts occur in some rows along ν."
    dataset["regime"][0] = Regime.TWO_SIDED
    lead = "Impacts occur up to both ends of the range of ν, but not in all rows."
    assert impacts_answer(dataset).lead == lead
    dataset["regime"][:] = Regime.NO_IMPACT
    dataset["regime"][7] = Regime.UNRESOLVED
    assert border_text(dataset, "nu") == ""


def test_the_title_of_energies_counts_the_orbits_whose_impacts_take_most():
    dataset = sweep(31)
    struck = (dataset["regime"] < Regime.APERIODIC) & (dataset["regime"] != Regime.NO_IMPACT)
    lost = xr.where(struck, 1.0, np.nan).expand_dims(support=[1, 2])
    dataset = dataset.assign(energy_impact=lost, energy_input=xr.where(struck, 3.0, np.nan))
    text = "Impacts take most of the work of the force in {} with impacts"
    assert energy_title(dataset) == text.format("all orbits")
    dataset["energy_input"][int(np.flatnonzero(struck)[0])] = 5.0
    amount = int(struck.sum())
    assert energy_title(dataset) == text.format(f"{amount - 1} of {amount} orbits")


def test_the_title_of_a_bifurcation_diagram_leaves_out_rows_without_a_result():
    dataset = sweep(31)
    assert bifurcation_title(dataset).startswith("Orbits repeat after up to 2 forcing periods; ")
    dataset["regime"][:4] = Regime.UNRESOLVED
    dataset["period_multiple"][5] = 256
    amount = int((dataset["regime"] == Regime.APERIODIC).sum())
    title = f"Orbits repeat after up to 256 forcing periods; {amount} of {dataset['regime'].size} rows are aperiodic"
    assert bifurcation_title(dataset) == title


def test_the_fastest_progression_is_told_with_its_power():
    line = one_line()
    speed = np.array([0.1, -0.3, 0.2, *([0.0] * 13)])
    creeps = describe(
        line.assign(
            housing_velocity_mean=("nu", speed),
            housing_velocity_max=("nu", np.abs(speed)),
            power_input=("nu", np.arange(16.0)),
        )
    )
    assert said(creeps)[:2] == [
        "In the orbits on which the starts settle, the fastest progression of the housing is 0.3, against x. "
        "It reaches 0.2 along x.",
        "With the fastest progression of an orbit, the mean power of the force is 1.",
    ]
    creeps["regime"][1] = Regime.APERIODIC
    assert said(creeps)[1].endswith(" is 2.")
    still = creeps.assign(housing_velocity_mean=0.0 * creeps["housing_velocity_mean"])
    assert not any("power" in text for text in said(still))


def cascade(*multiples: int) -> xr.Dataset:
    """Return a line with orbits of some numbers of periods, two rows each: 0 if aperiodic, -1 without a result."""
    m = np.repeat(multiples, 2)
    regime = np.select([m == 0, m < 0], [Regime.APERIODIC, Regime.UNRESOLVED], Regime.TWO_SIDED)
    nu = np.round(1.0 + 0.1 * np.arange(m.size), 10)
    data = {"regime": ("nu", regime.astype(np.int8)), "period_multiple": ("nu", np.maximum(m, 0))}
    impacts = np.stack([1.0 * m, 3.0 * m], axis=1)
    return describe(
        xr.Dataset(data | {"impacts_per_orbit": (("nu", "support"), impacts)}, {"nu": nu})
    )


@pytest.mark.parametrize(
    ("multiples", "told"),
    [
        ((0, 8, 4, 2, -1, 1), "With falling ν the period doubles three times before aperiodic motion. "
                              "First between ν = 1.7 and 2.0."),
        ((1, 3, 6, 12, 0, 1, 2, 0), "With rising ν the period doubles twice before aperiodic motion. "
                                    "First between ν = 1.3 and 1.4."),
        ((1, 2, 4, 8), ""), ((1, 2, 0, 4, 8), ""), ((1, 2, 4, 3, 0), ""),
    ],
)  # fmt: skip
def test_a_way_to_chaos_is_told(multiples, told):
    if not told:
        assert "doubles" not in bifurcation_title(cascade(*multiples))
    answer = doubling_answer(cascade(*multiples), "nu")
    assert ("" if answer is None else f"{answer.lead} {answer.rest}") == told


def test_other_laws_of_twice_the_periods_are_no_doublings():
    # (1; 1, 1), (2; 0, 1), (4; 0, 2): a flip of the first would strike twice as often in two periods
    line = cascade(1, 2, 4, 0)
    line["impacts_per_orbit"].values[:] = np.repeat([[1, 1], [0, 1], [0, 2], [0, 0.5]], 2, axis=0)
    assert doubling_answer(line, "nu") is None
    line["impacts_per_orbit"].values[:2] = [0, 0.5]
    answer = doubling_answer(line, "nu")
    assert answer is not None
    assert answer.lead == "With rising ν the period doubles twice before aperiodic motion."


def test_the_rows_of_each_period_of_a_way_to_chaos_are_a_table():
    falling = cascade(0, 8, 4, 2, -1, 1)
    title = "As ν falls, the period doubles until the motion is aperiodic, at ν = 1.1"
    assert bifurcation_title(falling) == title
    (table,) = tables({"s": falling})
    assert table.title == "How the period doubles as ν falls"
    assert table.rows == [
        ["1", "2.1 … 2.0"], ["2", "1.7 … 1.6"], ["4", "1.5 … 1.4"], ["8", "1.3 … 1.2"], ["aperiodic", "1.1"]
    ]  # fmt: skip


def test_that_impacts_occur_in_all_rows_is_said_last():
    line = one_line().isel(nu=slice(0, 6))
    line = line.assign(regime=line["regime"].copy(data=[3, 5, 3, 5, 3, 2]))
    *others, _ = [answer.lead for answer in sweep_answers(line)]
    assert " occur in all rows" not in " ".join(others)
    ends = xr.concat([one_line()] * 2, xr.DataArray([0.1, 0.2], dims="f", name="f"))
    ends["regime"].values[:, [0, -1]] = 3
    leads = [answer.lead for answer in sweep_answers(ends)]
    assert leads[0].startswith("The hardest impact ")
    assert " occur up to both ends " not in " ".join(leads[:-1])
