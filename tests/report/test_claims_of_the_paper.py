"""What the study of the paper says in words of its own, against its data."""

import re
from pathlib import Path

import numpy as np
import pytest

from vibropipe.jobs.report_data import _groups, scene_labels
from vibropipe.scenes.registry import kind_of
from vibropipe.study import load_study

STUDY = load_study(Path(__file__).parents[2] / "config" / "paper.yaml")
SEEN = {row[0]: row[4] for row in STUDY.table.rows}
FORCED = {
    "6": "forced_symmetric", "9": "forced_offset", "10": "forced_unequal", "11": "forced_both",
    "12": "forced_both_swapped",
}  # fmt: skip


def test_no_figure_stands_under_the_heading_of_another_scene():
    names = ("free_response_0", "backbone", "free_response_offset", "forced_symmetric")
    figures = [
        {"scene": name, "picture": "", "heading": "", "title": STUDY.scenes[name].title or name}
        for name in names
    ]
    figures[1]["title"] = "Shorter periods have harder impacts"
    groups = _groups(STUDY, scene_labels(STUDY), figures, {}, {}, figures[0])
    headings = [group.heading for group in groups]
    assert headings == ["Period and frequency of the free motion", "Free motion", "Motions"]


def numbers(text: str) -> list[float]:
    return [float(n.replace("−", "-")) for n in re.findall(r"[−+]?\d+\.\d+", text)]


@pytest.fixture(scope="module")
def motions():
    names = ("conservative_0", "conservative_offset", *FORCED.values())
    return {name: kind_of(STUDY.scenes[name]).solve(STUDY.scenes[name]) for name in names}


def speeds(dataset, support):
    return np.abs(dataset["impact_velocity"].values[dataset["impact_support"].values == support])


@pytest.mark.parametrize("figure", FORCED)
def test_forced_motions_strike_as_told(motions, figure):
    data = motions[FORCED[figure]]
    told = numbers(SEEN[figure])
    assert SEEN[figure].startswith("both")
    wanted = told if len(told) == 2 else told * 2
    assert [speeds(data, s).mean() for s in (1, 2)] == pytest.approx(wanted, abs=5e-4)


def test_the_means_are_those_told(motions):
    mean = {figure: float(motions[name]["displacement_mean"]) for figure, name in FORCED.items()}
    assert numbers(STUDY.answers[1]) == pytest.approx([mean["9"], mean["10"]], abs=5e-4)
    assert mean["6"] == pytest.approx(0.0, abs=1e-12)
    # offset and restitution against each other in figure 11, together in figure 12
    assert abs(mean["9"]) < mean["11"] < mean["10"] < -mean["12"]


def test_figure_11_is_less_and_figure_12_most_unequal(motions):
    unequal = {
        figure: abs(np.diff([speeds(motions[name], s).mean() for s in (1, 2)])[0])
        for figure, name in FORCED.items()
    }
    assert unequal["11"] < unequal["10"]
    assert max(unequal, key=lambda figure: unequal[figure]) == "12"
    assert "less unequal" in SEEN["11"]
    assert "most unequal" in SEEN["12"]


def test_free_motions_strike_and_graze_as_told(motions):
    # x(0) = 0, x'(0) = -0.51: x'^2 + x^2 = 0.51^2 up to an impact, which keeps it for R = 1
    data = motions["conservative_0"]
    (told,) = numbers(SEEN["4"])
    for support in (1, 2):
        assert speeds(data, support) == pytest.approx(np.sqrt(0.51**2 - 0.5**2), rel=1e-12)
    assert told == pytest.approx(np.sqrt(0.51**2 - 0.5**2), abs=5e-5)
    # with the offset 0.01 support 1 is at 0.51, which the mass reaches with no velocity left
    data = motions["conservative_offset"]
    (told,) = numbers(SEEN["7"])
    assert speeds(data, 1).size == 0
    assert speeds(data, 2) == pytest.approx(np.sqrt(0.51**2 - 0.49**2), rel=1e-12)
    assert told == pytest.approx(np.sqrt(0.51**2 - 0.49**2), abs=5e-5)
    assert "support 1 is grazed" in SEEN["7"]
    assert set(data["grazing_support"].values.tolist()) == {1}
    assert data.sizes["grazing"] == 4
    assert float(data["displacement"].max()) == pytest.approx(0.51, abs=1e-3)


@pytest.mark.parametrize(("figure", "delta"), [("5", 0.0), ("8", 0.01)])
def test_amplitudes_from_which_free_motions_strike(figure, delta):
    scene = STUDY.scenes["free_response_offset" if delta else "free_response_0"]
    data = kind_of(scene).solve(scene)
    told = numbers(SEEN[figure])
    amplitude, regime = data["amplitude"].values, data["regime"].values
    changes = amplitude[1:][np.diff(regime) != 0]
    # an amplitude is a row of the grid, 0.001 apart; each limit lies in the step before
    assert told == pytest.approx([0.5 - delta, 0.5 + delta] if delta else [0.5], abs=1e-12)
    assert changes == pytest.approx(np.array(told) + 0.0005, abs=1e-9)


def test_the_drop_of_the_first_harmonic_is_that_told():
    scene = STUDY.scenes["response_0"]
    whole = kind_of(scene).solve(scene).sel(direction="up")
    struck = whole["impacts_per_period"].sum("support") > 0
    falls = -whole["displacement_amplitude"].sel(harmonic=1).diff("nu").where(whole["nu"] > 1)
    assert (falls.max("nu") > 0.2).values.tolist() == [False, True, True, False]
    assert struck.any("nu").values.tolist() == [True] * 4
    assert STUDY.answers[2].startswith("At the two middle forces, ")
    data = whole.sel(f=0.5)
    first = data["displacement_amplitude"].sel(harmonic=1).values
    at = int(np.abs(np.diff(first)).argmax())
    assert float(data["nu"][at]) > 1.0
    assert numbers(STUDY.answers[2]) == pytest.approx([0.5, *first[at : at + 2]], abs=5e-3)
    # along the free motion of the same frequency, up to the drop
    free = STUDY.scenes["free_response_0"]
    backbone = kind_of(free).solve(free)
    frequency = backbone["eigenfrequency"].values
    curve = backbone["displacement_amplitude"].sel(harmonic=1).values
    rising = frequency > 1.0 + 1e-9
    there = (data["nu"].values > 1.8) & (data["nu"].values <= float(data["nu"][at]))
    along = np.interp(data["nu"].values[there], frequency[rising], curve[rising])
    assert np.abs(first[there] - along).max() < 0.03
