"""Part of the report on motions: steady states in one table, and the effect of each asymmetry."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr
from figures.sample_datasets import motion, steady

from vibropipe.report.exciter import side_of
from vibropipe.report.table import ZERO_WIDTH_SPACE
from vibropipe.scenes.motion.captions import steady_text
from vibropipe.scenes.motion.findings import exponent_text, findings, orbit_text
from vibropipe.scenes.motion.report import (
    comparison,
    sections,
    signed_percent,
    steady_scenes,
    steady_tables,
)
from vibropipe.words.regimes import Regime
from vibropipe.words.status import Status
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


def test_steady_states_stand_side_by_side(datasets):
    assert list(steady_scenes(datasets)) == ["symmetric", "offset", "very_unequal_scene"]
    (section,) = sections(datasets)
    (table,) = (part.as_data() for part in section.tables)
    assert table["head"][-1].replace(ZERO_WIDTH_SPACE, "") == "very_unequal_scene"
    rows = {row[0]: row[1:] for row in table["rows"]}
    assert rows["δ"] == ["0", "0.01", "0"]
    assert rows["R₁"] == ["0.7", "0.7", "0.6"]
    assert "nu" not in rows
    assert rows["regime"] == ["two-sided"] * 3
    assert rows["m"] == ["1"] * 3
    assert rows["struck, support 1"] == ["0.89", "0.855", "0.91"]
    assert rows["struck, support 2"] == ["−0.89", "−0.925", "−0.87"]
    assert rows["mean"] == ["0", "−0.035", "0.02"]
    assert rows["A₂"] == ["0", "0.035", "0.02"]
    assert rows["multipliers"] == ["0.35 ± 0.01 i"] * 3
    assert rows["stability"] == ["stable"] * 3


def test_many_steady_states_are_cut_into_tables_that_fit(datasets):
    many = {f"scene_{n}": datasets["offset"] for n in range(12)}
    tables = steady_tables(many)
    assert [len(table.head) for table in tables] == [7, 7]


def test_what_each_asymmetry_does_is_computed(datasets):
    text = comparison(steady_scenes(datasets))
    assert text["opening"] == "Compared with the symmetric scene, symmetric:"
    names = [item["name"].replace(ZERO_WIDTH_SPACE, "") for item in text["items"]]
    assert names == ["offset", "very_unequal_scene"]
    offset, unequal = (item["text"] for item in text["items"])
    assert offset.startswith("δ = 0.01 instead of 0: ")
    assert "the constant part of displacement changes from 0 to −0.035" in offset
    assert "the impact velocity on support 1 from 0.89 to 0.855 (−3.9 %)" in offset
    assert "the second harmonic from 0 to 0.035" in offset
    assert unequal.startswith("R₁ = 0.6 instead of 0.7 and R₂ = 0.8 instead of 0.7: ")
    assert "differ most in offset, by 7.6 % of the larger one" in text["closing"]
    # another result, another sentence
    other = steady(0.07, delta=0.01, tau_end=5.0)
    text = comparison({"symmetric": datasets["symmetric"], "offset": other})
    assert "changes from 0 to −0.07" in text["items"][0]["text"]


def test_one_steady_state_is_compared_with_nothing(datasets):
    assert comparison({"symmetric": datasets["symmetric"]}) == {
        "title": "Steady states of the motions"
    }


def test_no_sentence_on_asymmetry_where_other_parameters_differ(datasets):
    others = {"slow": steady(nu=0.8, tau_end=5.0), "fast": steady(0.02, nu=1.2, tau_end=5.0)}
    (section,) = sections(others)
    assert section.title == "Steady states of the motions"
    assert section.opening == "Compared with the first scene, slow:"
    (section,) = sections({"symmetric": datasets["symmetric"], "offset": datasets["offset"]})
    assert section.title == "Effect of each asymmetry"


def test_a_motion_without_an_orbit_is_compared_with_nothing(datasets):
    chaotic = datasets["offset"].assign(
        period_multiple=np.int32(0), regime=np.int8(Regime.APERIODIC)
    )
    (section,) = sections({"symmetric": datasets["symmetric"], "chaotic": chaotic})
    assert len(section.tables[0].head) == 3
    assert (section.opening, section.items, section.closing) == ("", [], "")


def test_findings_name_orbits_velocities_and_motions_that_did_not_end(datasets):
    full = datasets["free"].assign(status=np.int8(Status.LOG_FULL))
    (finding,) = findings(datasets | {"free": full})
    assert finding.scene == ""
    steady_text, velocity, mean, status = (t.replace(ZERO_WIDTH_SPACE, "") for t in finding.texts)
    assert steady_text == (
        "The steady states of the motions are two-sided, of 1 forcing period, stable (symmetric, offset and "
        "very_unequal_scene)."
    )
    assert velocity.startswith("The largest impact velocity is ")
    assert mean == "The largest constant part of displacement is −0.035, in offset."
    assert status == "free (log_full) has a status other than ok (see below)."


def test_percentages_have_no_power_of_ten():
    texts = [signed_percent(share) for share in (0.0567, -0.35, -1.0, 0.9949, 0.996, 12.5)]
    assert texts == ["+5.7 %", "−35 %", "−100 %", "+99 %", "+100 %", "+1250 %"]


def test_effects_of_some_scenes_stand_in_the_table(datasets):
    with_friction = datasets["symmetric"].assign_coords(friction=((), 0.15))
    one, other = datasets["symmetric"], with_friction
    rows = {row[0]: row[1:] for row in steady_tables({"one": one, "other": other})[0].rows}
    assert rows["friction"] == ["0", "0.15"]
    assert comparison({"one": one, "other": other})["title"] == "Steady states of the motions"


def test_forces_of_soft_supports_stand_in_the_table(datasets):
    soft = steady(tau_end=13.0)
    values = ("support", np.array([12.5, np.nan]))
    soft = describe(
        soft.assign(support_force_max=values, contact_duration_max=("support", [0.25, np.nan]))
    )
    (table,) = steady_tables({"rigid": datasets["symmetric"], "soft": soft})
    rows = {row[0]: row[1:] for row in table.rows}
    assert rows["force, support 1"] == ["–", "12.5"]
    assert rows["contact, support 1"] == ["–", "0.25"]
    assert "force_2" not in rows
    assert "largest force of each soft support" in table.note
    (table,) = steady_tables({"rigid": datasets["symmetric"]})
    assert "force" not in table.note


def test_a_motion_without_a_force_has_no_forcing_period():
    values = {
        "regime": 0,
        "period_multiple": 1,
        "lyapunov_exponent": -0.05,
        "lyapunov_exponent_error": 0.0,
    }
    still = describe(xr.Dataset(values, {"nu": 1.0, "f": 0.0, "h": 0.1, "l": 0.5}))
    forced = describe(xr.Dataset(values, {"nu": 1.0, "f": 0.1, "h": 0.1, "l": 0.5}))
    assert orbit_text(still) == "no impact"
    assert orbit_text(forced) == "no impact, of 1 forcing period"
    assert steady_text(still) == "The steady state is no impact"
    assert [row.symbol for row in side_of({"still": still}).rows] == ["h", "l"]
    assert exponent_text({"s": still}) == "The Lyapunov exponent is −0.05"
    assert (
        exponent_text({"a": still, "b": forced})
        == "The Lyapunov exponents are −0.05 (a) and −0.05 (b)"
    )
