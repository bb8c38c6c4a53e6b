"""Part of the report on sweeps: findings in sentences, rows by regime, regimes along each line."""

from __future__ import annotations

import numpy as np
import xarray as xr
from figures.sample_datasets import sweep

from vibropipe.figures.text import format_number
from vibropipe.scenes.sweep.captions import follow_text, maxima_text, peak_text
from vibropipe.scenes.sweep.findings import findings, mean_text, sweep_texts
from vibropipe.scenes.sweep.jumps import jumps_of
from vibropipe.scenes.sweep.report import sections
from vibropipe.words.regimes import Regime
from vibropipe.words.vocabulary import describe


def test_regimes_of_sweeps_are_counted():
    dataset = sweep(f=[0.1, 0.2, 0.5], all_regimes=True)
    regime = dataset["regime"].values
    (section,) = sections({"response": dataset})
    table = section.tables[0].as_data()
    rows = {row[0]: row[1] for row in table["rows"]}
    assert rows["rows"] == str(regime.size)
    for code, name in ((3, "two-sided"), (4, "with rest"), (6, "unbounded"), (7, "unresolved")):
        amount = int((regime == code).sum())
        assert rows[name] == f"{amount} ({format_number(100 * amount / regime.size, 3)} %)"
    assert rows["stable, m > 1"].startswith("24 ")
    assert rows["unstable"] == "15 (4.13 %)"


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


def test_findings_of_a_line():
    (finding,) = findings({"response": one_line()})
    assert finding.scene == "response"
    assert finding.texts == [
        "Along ν the regime is in turn no impact, two-sided, two-sided, m = 2, two-sided and no impact; impacts begin "
        "between ν = 0.8 and 0.9.",
        "Orbits strike support 1 hardest: 1.6 in the row ν = 1.6.",
        "The first harmonic jumps between ν = 1.6 and 1.7.",
    ]
    assert mean_text(one_line()) == (
        "The constant part of displacement is not zero: it reaches −0.016 in the row ν = 1.6"
    )


def test_a_value_at_an_end_of_the_range_still_rises():
    line = one_line().isel(nu=slice(0, 11))
    assert sweep_texts(line)[1] == (
        "Orbits strike support 1 hardest: 1.5 in the row ν = 1.5, "
        "where it still rises at the end of the range of ν"
    )
    assert peak_text(line).endswith("at ν = 1.5, where it still rises at the end of the range of ν")


def test_aperiodic_rows_are_told_apart_from_orbits():
    line = one_line()
    regime = line["regime"].copy()
    regime[10:12] = Regime.APERIODIC
    line = line.assign(regime=regime, window_periods=("nu", np.full(16, 128)))
    assert sweep_texts(line)[1:3] == (
        "Orbits strike support 1 hardest: 1.4 in the row ν = 1.4",
        "Aperiodic motion strikes harder than any orbit: 1.6, in a window of 128 periods",
    )
    assert "on support 1 of the orbits is 1.4, at ν = 1.4 and aperiodic rows is 1.6" in maxima_text(
        line
    )


def test_the_largest_force_of_a_soft_support_is_found():
    line = one_line()
    force = line["impact_velocity_max"].values * [[10.0, np.nan]]
    line = describe(line.assign(support_force_max=(("nu", "support"), force)))
    assert sweep_texts(line)[2] == "Soft support 1 has the largest force: 16 in the row ν = 1.6"


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
    assert any("The first harmonic jumps" in text for text in sweep_texts(line))
    for follow in ("nu up", "nu down"):
        texts = sweep_texts(line.assign_attrs(follow=follow))
        assert not any("jumps" in text or "impacts begin" in text for text in texts)
        assert "no border of a motion" in follow_text(line.assign_attrs(follow=follow))
    assert follow_text(line) == ""


def test_rows_on_two_motions_are_told_of_a_sweep_followed_both_ways():
    both = followed_both_ways()
    text = " ".join(sweep_texts(both))
    assert (
        "among the motions followed here, at least two are stable in the rows from ν = 1.3 to 1.6"
        in text.lower()
    )
    assert "jumps" not in text
    assert "in the row ν = 1.6, upwards" in text
    assert "Impacts occur only between ν = 0.8 and 1.7 along ν, on each line" in text
    same = both.copy(deep=True)
    for name in ("regime", "displacement_amplitude", "displacement_mean", "impact_velocity_max"):
        same[name][1] = same[name][0]
    assert "at least two" not in " ".join(sweep_texts(same))
    # chaos is on no orbit: which motion it is cannot be compared
    chaotic = both.copy(deep=True)
    chaotic["regime"][0, 8:] = Regime.APERIODIC
    assert "at least two" not in " ".join(sweep_texts(chaotic))
    unstable = both.copy(deep=True)
    unstable["stable"][1] = 0
    assert "at least two" not in " ".join(sweep_texts(unstable))


def test_a_step_without_steps_on_both_sides_is_no_jump():
    line = one_line()
    assert len(jumps_of(line, "nu")) == 1
    assert not jumps_of(line.isel(nu=[0, 11]), "nu")
    assert not jumps_of(line.isel(nu=slice(11, 14)), "nu")
    assert len(jumps_of(line.isel(nu=slice(10, 14)), "nu")) == 1
    lost = line["regime"].copy()
    lost[10] = Regime.UNRESOLVED  # the row before the one in front of the jump
    assert not jumps_of(line.assign(regime=lost), "nu")


def test_findings_are_in_the_units_of_the_data():
    line = one_line()
    line["nu"].attrs["units"], line["impact_velocity_max"].attrs["units"] = "rad/s", "mm/s"
    assert sweep_texts(line)[1].endswith("hardest: 1.6 mm/s in the row ν = 1.6 rad/s")
    assert sweep_texts(line)[0].endswith("impacts begin between ν = 0.8 and 0.9 rad/s")


def test_findings_of_a_map_give_shares_and_ranges():
    dataset = sweep(40, f=np.linspace(0.05, 2, 40), all_regimes=True)
    text = " ".join(sweep_texts(dataset))
    share = format_number(100 * float((dataset["regime"] == Regime.TWO_SIDED).mean()), 3)
    assert f"{share} %" in text.split("Orbits")[0]
    assert "jumps" not in text
    (section,) = sections({"map": dataset})
    assert len(section.tables) == 1


def test_regimes_along_each_line_and_energies_are_tables():
    line = one_line()
    energy = describe(xr.Dataset({"energy_input": ("nu", np.linspace(0.1, 0.2, line.sizes["nu"]))}))
    for name in ("energy_damping", "energy_impact"):
        energy[name] = energy["energy_input"] / 2
    with_friction = energy.assign(energy_friction=energy["energy_input"] / 4)
    tables = sections({"response": line.merge(with_friction), "plain": line.merge(energy)})[
        0
    ].tables
    assert tables[2].head[1:] == [
        "work of the force", "loss by damping", "loss at impacts", "loss by friction",
    ]  # fmt: skip
    assert [row[4] for row in tables[2].rows] == ["0.025 … 0.05", "–"]
    for without in (energy, energy.assign(energy_friction=0 * energy["energy_input"])):
        assert len(sections({"response": line.merge(without)})[0].tables[2].head) == 4
    tables = sections({"response": line.merge(energy)})[0].tables
    assert tables[1].rows[0][:3] == ["response", "–", "ν"]
    assert tables[1].rows[0][3].startswith("no impact (0.5 … 0.8); two-sided (0.9 … 1.1); ")
    assert tables[2].rows == [["response", "0.1 … 0.2", "0.05 … 0.1", "0.05 … 0.1"]]
