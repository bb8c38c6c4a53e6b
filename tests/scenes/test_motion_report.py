"""Part of the report on motions: answers, and steady states in one table."""

import numpy as np
import pytest
import xarray as xr
from figures.sample_datasets import motion, steady

from vibropipe.figures.text import format_number, parameters_text
from vibropipe.report.exciter import side_of
from vibropipe.scenes.motion.captions import steady_text
from vibropipe.scenes.motion.findings import answers, exponent_answers
from vibropipe.scenes.motion.report import (
    MAX_COLUMNS,
    fitting,
    parameter_symbol,
    steady_columns,
    steady_tables,
)
from vibropipe.scenes.motion.steady_text import orbit_text
from vibropipe.words.regimes import Regime
from vibropipe.words.vocabulary import describe


@pytest.fixture(scope="module")
def datasets():
    """Return a motion without a steady state and three with one, by scene."""
    return {
        "free": motion(f=0.0, h=0.0, R1=1.0, R2=1.0, v=-0.51, tau_end=10.0),
        "symmetric": steady(tau_end=13.0),
        "offset": steady(0.035, delta=0.01, tau_end=13.0),
        "very_unequal_scene": steady(-0.02, R1=0.6, R2=0.8, tau_end=13.0),
    }


def test_steady_states_stand_below_each_other(datasets):
    (table,) = (part.as_data() for part in steady_tables(datasets))
    assert table["title"] == "Steady states of the motions"
    assert table["note"].startswith(
        "All motions are two-sided, repeat after 1 forcing period and are stable."
    )
    rows = {row[0]: dict(zip(table["head"][1:], row[1:], strict=True)) for row in table["rows"]}
    assert list(rows) == ["symmetric", "offset", "very_unequal_scene"]
    assert list(rows["offset"].values()) == ["0.01", "0.7", "0.7", "0.855", "−0.925", "−0.035",
                                             format_number(float(datasets["offset"]["displacement_amplitude"][0])),
                                             "0.035", "0.35"]  # fmt: skip
    assert list(rows["offset"])[:3] == ["δ", "R₁", "R₂"]
    assert rows["symmetric"]["mean"] == "0"
    assert "ν" not in table["head"]


def test_the_column_of_periods_is_named_in_a_word(datasets):
    """The symbol of period multiples is that of the mass in studies with units."""
    (table,) = steady_tables({"symmetric": datasets["symmetric"]})
    row = dict(zip(table.as_data()["head"], table.as_data()["rows"][0], strict=True))
    assert row["periods"] == "1"


def test_cells_that_differ_have_columns(datasets):
    chaotic = datasets["offset"].assign(
        period_multiple=np.int32(0), regime=np.int8(Regime.APERIODIC)
    )
    columns = steady_columns({"symmetric": datasets["symmetric"], "chaotic": chaotic})
    assert columns["regime"] == ["two-sided", "aperiodic"]
    assert columns["multiple"] == ["1", "–"]
    (table,) = steady_tables({"symmetric": datasets["symmetric"], "chaotic": chaotic})
    assert {"regime", "stability"} < set(table.head)
    assert table.scene == ""
    (table,) = steady_tables({"free": datasets["free"], "symmetric": datasets["symmetric"]})
    assert table.scene == "symmetric"  # below its own picture, not below that of a motion without
    assert steady_tables({"free": datasets["free"]}) == []


def test_columns_that_matter_least_are_left_out():
    names = ["nu", "f", "h", "delta", "regime", "multiple", "impacts_1", "impacts_2", "rests", "mean (mm)",
             "harmonic 1 (mm)", "harmonic 2 (mm)", "exponent"]  # fmt: skip
    kept = list(fitting({name: ["1"] for name in names}, 4))
    assert len(kept) == MAX_COLUMNS
    left_out = ["h", "delta", "rests", "multiple"]
    assert kept == [name for name in names if name not in left_out]


def test_answers_name_orbits_velocities_and_means(datasets):
    (found,) = answers(datasets).values()
    orbits, hardest, means = found
    assert (
        orbits.lead == "In the steady state both supports are struck once in each forcing period."
    )
    assert orbits.rest == "It was computed for “symmetric”, “offset” and “very_unequal_scene”."
    assert hardest.lead.startswith("The hardest impact recorded is on support ")
    assert (means.lead, means.rest) == (
        "Where computed, the mean displacement is largest in size in the motion “offset”.",
        "It is −0.035.",
    )
    (alone,) = answers({"offset": datasets["offset"]}).values()
    assert alone[0].rest == "The motion is stable and its mean displacement is −0.035."
    several = {name: data for name, data in datasets.items() if name != "free"}
    assert answers(several)[""][0].rest == "All motions are stable."


def test_the_hardest_impact_is_that_of_the_data(datasets):
    data = datasets["offset"]
    top = int(np.abs(data["impact_velocity"].values).argmax())
    answer = answers({"offset": data})["offset"][1]
    assert (
        answer.lead
        == f"The hardest impact recorded is on support {int(data['impact_support'][top])}."
    )
    speed = format_number(abs(float(data["impact_velocity"][top])))
    assert answer.rest == f"Its velocity is {speed}."


def test_effects_of_some_scenes_stand_in_the_table(datasets):
    with_friction = datasets["symmetric"].assign_coords(friction=((), 0.15))
    columns = steady_columns({"one": datasets["symmetric"], "other": with_friction})
    assert columns[parameter_symbol([with_friction], "friction")] == ["0", "0.15"]


def test_a_soft_support_without_a_restitution_has_none(datasets):
    soft = datasets["symmetric"].assign_coords(k1=((), 100.0), R1=((), 1.0))
    columns = steady_columns({"rigid": datasets["symmetric"], "soft": soft})
    assert columns["R₁"] == ["0.7", "–"]
    assert "R₁ =" not in parameters_text(soft)
    assert "R₂ = 0.7" in parameters_text(soft)
    assert "R₁ = 1" in parameters_text(datasets["symmetric"].assign_coords(R1=((), 1.0)))  # rigid


def test_forces_of_soft_supports_stand_in_the_table(datasets):
    soft = steady(tau_end=13.0)
    values = ("support", np.array([12.5, np.nan]))
    soft = describe(
        soft.assign(support_force_max=values, contact_duration_max=("support", [0.25, np.nan]))
    )
    (table,) = steady_tables({"rigid": datasets["symmetric"], "soft": soft})
    columns = dict(zip(table.head, zip(*table.rows, strict=True), strict=True))
    assert columns["force"] == ("–", "12.5")
    assert columns["contact"] == ("–", "0.25")
    assert "the largest of soft supports" in table.note
    (table,) = steady_tables({"rigid": datasets["symmetric"]})
    assert "force" not in table.head
    assert "Force" not in table.note


def test_a_motion_without_a_force_has_no_forcing_period():
    values = {
        "regime": 0,
        "period_multiple": 1,
        "lyapunov_exponent": -0.05,
        "lyapunov_exponent_error": 0.0,
    }
    still = describe(xr.Dataset(values, {"nu": 1.0, "f": 0.0, "h": 0.1, "l": 0.5}))
    forced = describe(xr.Dataset(values, {"nu": 1.0, "f": 0.1, "h": 0.1, "l": 0.5}))
    assert orbit_text(still) == orbit_text(forced) == "The steady state has no impact"
    assert steady_text(still) == "The steady state has no impact"
    resting = forced.assign(regime=4, period_multiple=2, stable=1)
    assert steady_text(resting).startswith(
        "The steady state comes to rest on a support, repeats after 2 forcing periods and is "
    )
    assert [row.symbol for row in side_of({"still": still}).rows] == ["h", "l"]
    (exponent,) = exponent_answers({"s": still})
    assert exponent.lead == "The Lyapunov exponent is −0.05."
    chaotic = forced.assign(lyapunov_exponent=0.12, lyapunov_exponent_error=0.004)
    (exponent,) = exponent_answers({"a": still, "b": chaotic})
    assert exponent.lead == "The Lyapunov exponent is largest in the motion “b”."
    assert exponent.rest == "It is 0.12, with an error of 0.004."
    assert steady_columns({"a": still, "b": chaotic})["exponent"] == ["−0.05", "0.12 ± 0.004"]
    near = chaotic.assign(lyapunov_exponent=0.116, lyapunov_exponent_error=0.001)
    (exponent,) = exponent_answers({"a": still, "b": chaotic, "c": near})
    assert exponent.lead == "The Lyapunov exponent is largest in “b” and “c”."
    assert exponent.rest == "In the motion “b” it is 0.12, with an error of 0.004."
    unasked = still.drop_vars(["lyapunov_exponent", "lyapunov_exponent_error"])
    (exponent,) = exponent_answers({"a": still, "b": chaotic, "c": unasked})
    assert exponent.lead == "Where computed, the Lyapunov exponent is largest in the motion “b”."
    unknown = still.assign(lyapunov_exponent=np.nan)
    assert exponent_answers({"s": unknown})[0].lead == "The Lyapunov exponent is not known."


def test_a_frequency_in_cycles_is_one():
    scene = xr.Dataset({"omega": ((), 18.0, {"units": "Hz"}), "R1": ((), 0.7)})
    assert [parameter_symbol([scene], name) for name in ("omega", "R1", "R2")] == [
        "ω/2π",
        "R₁",
        "R₂",
    ]
