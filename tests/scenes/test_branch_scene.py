"""Scenes of branches: keys, data, picture, table of bifurcations."""

import re

import numpy as np
import pytest
import xarray as xr

import vibropipe as vp
from vibropipe.figures.claims import percent
from vibropipe.figures.line_names import NAME
from vibropipe.figures.motion_words import amount_text
from vibropipe.figures.text import format_number
from vibropipe.figures.units import display_units
from vibropipe.jobs.report_data import report_data
from vibropipe.scenes.branch.answers import branch_answers, distinct_texts, together_answer
from vibropipe.scenes.branch.curves import draw_branches
from vibropipe.scenes.branch.lines import both_alike, cascade_of, places_of
from vibropipe.scenes.branch.pictures import title_branches
from vibropipe.scenes.branch.report import cascade_table, stable_table, tables, together_table
from vibropipe.scenes.branch.stretches import common_intervals, stretches_of
from vibropipe.scenes.branch.yields import yield_answer
from vibropipe.scenes.registry import kind_of
from vibropipe.study import StudyError, study_of_text
from vibropipe.words.bifurcations import Bifurcation

STUDY = """
title: Branches
exciter: {l: 0.5, h: 0.2, R1: 0.7, R2: 0.7}
scenes:
  response:
    kind: branch
    along: {nu: {from: 1.05, to: [0.8, 3]}}
    over: {f: [0.25, 0.5]}
    at: [1, 2]
"""


@pytest.fixture(scope="module")
def scene():
    return study_of_text(STUDY, "laws").scenes["response"]


@pytest.fixture(scope="module")
def dataset(scene):
    return kind_of(scene).solve(scene)


def test_branches_of_several_forces_stand_one_after_the_other(dataset):
    parts = [
        vp.branch(
            vp.Exciter(l=0.5, h=0.2, R1=0.7, R2=0.7, nu=1.05, f=f), "nu", (0.8, 3), at=(1, 2), harmonics=3
        )
        for f in (0.25, 0.5)
    ]  # fmt: skip
    first = parts[0].sizes["point"]
    for part, points in zip(parts, (slice(None, first), slice(first, None)), strict=True):
        joined = dataset.isel(point=points)
        assert np.array_equal(joined["nu"], part["nu"])
        assert np.array_equal(joined["displacement_amplitude"], part["displacement_amplitude"])
        assert np.array_equal(np.unique(joined["f"]), [float(part["f"])])
    assert dataset.sizes["impact"] == int(dataset["row_size"].sum())
    assert np.unique(dataset["branch_id"]).tolist() == list(
        range(int(dataset["branch_id"].max()) + 1)
    )
    at = dataset["bifurcation_point"].values
    assert np.array_equal(dataset["nu"].values[at], dataset["bifurcation_nu"])
    for value in (1.0, 2.0):
        assert (dataset["nu"] == value).any()


def test_the_picture_marks_what_the_data_hold(scene, dataset):
    (picture,) = kind_of(scene).pictures_of(dataset)
    figure = picture.draw(dataset, scene.figure, {})
    entries = [text.get_text() for legend in figure.legends for text in legend.get_texts()]
    kinds = {vp_kind for vp_kind in ("fold", "pitchfork", "grazing") if vp_kind in entries}
    codes = {"fold": 0, "pitchfork": 2, "grazing": 3}
    assert kinds == {
        name for name, code in codes.items() if (dataset["bifurcation_kind"] == code).any()
    }
    drawn = np.concatenate([line.get_xdata() for line in figure.axes[0].lines])
    assert set(dataset["bifurcation_nu"].values) <= set(drawn)
    # Unstable points are dashed and nothing else is.
    dotted = [line for line in figure.axes[0].lines if line._dash_pattern[1]]
    unstable = dataset["nu"].values[dataset["stable"].values == 0]
    assert set(unstable) <= set(np.concatenate([line.get_xdata() for line in dotted]))
    # each line bears its value, since colours do not differ enough in grey
    for ax in figure.axes[:2]:
        written = {text.get_text() for text in ax.texts if text.get_gid() == NAME}
        assert written == {"$f$ = 0.25", "$f$ = 0.5"}
    caption = picture.describe(dataset, scene.figure, {})
    assert "folds" in caption
    assert "solid: stable, dashed: unstable" in caption


def test_the_table_lists_where_each_motion_is_stable(dataset):
    table = stable_table("response", dataset)
    stretches = stretches_of(dataset)
    assert len(table.rows) == len(
        {(s.over, s.words, *s.values[[0, -1]].round(8)) for s in stretches}
    )
    fold = float(dataset["bifurcation_nu"][folds_of(dataset, 0.5)].max())
    row = ["0.5", "both supports, once a period", "–", "–", f"{fold:.4g}", "fold"]
    assert row in [each[:-1] for each in table.rows]


def test_branches_without_bifurcations_have_no_tables(dataset):
    plain = dataset.isel(bifurcation=slice(0, 0), point=dataset["f"].values == 0.5)
    assert tables({"response": plain}) == []


def test_the_first_page_says_why_the_motion_jumps():
    scene = study_of_text(STUDY + "    switch: [grazing]\n", "laws").scenes["response"]
    dataset = kind_of(scene).solve(scene)
    together, jumps, hardest = branch_answers(dataset)
    # the response with impacts ends at its fold, the linear motion where it grazes a support
    fold = float(dataset["bifurcation_nu"][folds_of(dataset, 0.5)].max())
    first, last = (f"{end:.4g}" for end in (grazing_frequency(0.5), fold))
    assert together.lead == (
        f"The start decides which motion settles from ν = {first} to {last} at f = 0.5, and elsewhere."
    )
    assert together.rest == "Stable there: both supports, once a period; no impact."
    assert jumps.lead == "Followed motions jump at folds and at grazings, in at least four places."
    assert jumps.rest == (
        "The largest jump of the impact velocity leaves “both supports, once a period” as ν grows past "
        f"{fold:.4g} at f = 0.5, a fold; stable beyond: no impact."
    )
    assert hardest.lead.startswith("Stable motions followed here strike hardest near ν = ")
    velocity = dataset["impact_velocity_max"].where(dataset["stable"] == 1).max("support")
    at = float(hardest.lead.partition("ν = ")[2].split()[0].rstrip(".,"))
    point = int(velocity.argmax("point"))
    before, after = sorted(dataset["nu"].values[[point - 1, point + 1]])
    # in the digits in which the points beside it agree
    assert abs(at - before) <= 1.5 * 10.0 ** -(len(f"{at}") - 2)
    assert abs(at - after) <= 1.5 * 10.0 ** -(len(f"{at}") - 2)
    assert "on each support" in hardest.rest
    rows = together_table("response", dataset).rows
    fold = float(dataset["bifurcation_nu"][folds_of(dataset, 0.25)].max())
    expected = [f"{end:.4g}" for end in (grazing_frequency(0.25), fold)]
    assert ["0.25", "both supports, once a period; no impact", *expected] in rows


def test_a_jump_to_a_motion_that_is_not_followed_is_told(dataset):
    (jumps,) = [answer for answer in branch_answers(dataset) if "jump" in answer.lead]
    fold = float(dataset["bifurcation_nu"][folds_of(dataset, 0.5)].max())
    assert f"as ν grows past {fold:.4g} at f = 0.5, a fold; " in jumps.rest
    assert jumps.rest.endswith("no motion followed here is stable beyond.")


def test_a_cascade_is_told_with_the_ratios_of_its_steps():
    """The velocity map of one support: steps shrink towards Feigenbaum's ratio."""
    text = STUDY.replace(
        "{l: 0.5, h: 0.2, R1: 0.7, R2: 0.7}", "{l: 2, delta: -1.95, h: 0.1, f: 1, R1: 0.8, R2: 0.8}"
    )
    text = text.replace("{from: 1.05, to: [0.8, 3]}", "{from: 2.53, to: 2.616}").replace(
        "    at: [1, 2]\n", ""
    )
    text = text.replace("    over: {f: [0.25, 0.5]}\n", "    switch: [flip]\n")
    scene = study_of_text(text, "laws").scenes["response"]
    dataset = kind_of(scene).solve(scene)
    places = cascade_of(dataset)
    flips = dataset["bifurcation_nu"].values[dataset["bifurcation_kind"].values == Bifurcation.FLIP]
    assert places == sorted(flips.tolist())[: len(places)]
    assert len(places) == 3
    ratio = (places[1] - places[0]) / (places[2] - places[1])
    assert cascade_table("response", dataset).rows[2][3] == f"{ratio:.3g}"
    assert [row[0] for row in cascade_table("response", dataset).rows] == [
        "1 to 2",
        "2 to 4",
        "4 to 8",
    ]
    (answer,) = [each for each in branch_answers(dataset) if "flip" in each.lead]
    assert answer.lead == "From flip to flip the steps shrink."
    assert f"the last step is {ratio:.3g} times smaller" in answer.rest
    assert cascade_of(dataset.isel(bifurcation=slice(0, 2))) == []


def test_ends_of_intervals_are_told_apart():
    assert distinct_texts((1.0, 2.0), (1.00001, 1.00002)) == [("1", "2"), ("1.00001", "1.00002")]


def test_lines_of_both_supports_are_alike_in_a_symmetric_exciter(dataset):
    velocity = dataset["impact_velocity_max"]
    assert both_alike(dataset, velocity)
    weaker = velocity * xr.DataArray([1.0, 0.99], dims="support")
    assert not both_alike(dataset, weaker)


@pytest.mark.parametrize(
    ("start", "to", "title"),
    [
        (1.05, (0.8, 3), "Orbits along ν pass one fold, one pitchfork and one grazing"),
        (1.05, 1.1, "All orbits followed along ν are stable"),
    ],
)
def test_a_branch_without_a_title_says_what_it_shows(start, to, title):
    data = vp.branch(vp.Exciter(l=0.5, h=0.2, R1=0.7, R2=0.7, nu=start, f=0.25), "nu", to)
    assert title_branches(data, ()) == title


def grazing_frequency(f: float, length: float = 0.5, h: float = 0.2) -> float:
    """Return the larger frequency at which the linear motion reaches the supports."""
    b = h * h - 2.0
    return float(np.sqrt((-b + np.sqrt(b * b - 4.0 * (1.0 - (f / length) ** 2))) / 2.0))


def folds_of(dataset, f: float) -> np.ndarray:
    """Return the indices of the folds at a value of f."""
    at = dataset["f"].values[dataset["bifurcation_point"].values]
    return np.flatnonzero((dataset["bifurcation_kind"].values == Bifurcation.FOLD) & (at == f))


PHYSICAL = """
title: With units
physical: {m: 2 kg, C: 8 N/mm, H: 25.298221281347036 N s/m, l: 8 mm}
exciter: {R1: 0.7, R2: 0.7}
scenes:
  free: {kind: backbone, amplitude: [1 mm, 20 mm]}
  response:
    kind: branch
    along: {omega: {from: 70 rad/s, to: [50 rad/s, 150 rad/s]}}
    over: {F: [32 N, 64 N]}
    at: [80 rad/s, 100 rad/s]
    figure: {backbone: free}
"""


def test_branches_with_units_are_those_without_in_si():
    study = study_of_text(PHYSICAL, "laws")
    scene = study.scenes["response"]
    data = kind_of(scene).solve(scene)
    p = np.sqrt(8000 / 2)
    part = vp.branch(
        vp.Exciter(**{**scene.resolved_exciter(), "f": 32 / 8000}),
        "nu", tuple(scene.ends.to), at=[80 / p, 100 / p], harmonics=3,
    )  # fmt: skip
    first = data.isel(point=slice(None, part.sizes["point"]))
    assert first["omega"].values == pytest.approx(part["nu"].values * p, rel=1e-12)
    assert {80.0, 100.0} <= {*data["omega"].values.tolist()}
    assert first["impact_velocity_max"].values == pytest.approx(
        part["impact_velocity_max"].values * p, rel=1e-12, nan_ok=True
    )
    at = data["bifurcation_omega"].values[: part.sizes["bifurcation"]]
    assert at == pytest.approx(part["bifurcation_nu"].values * p, rel=1e-12)
    units = {
        name: data[name].attrs["units"]
        for name in ("omega", "F", "bifurcation_omega", "displacement_mean")
    }
    assert units == {
        "omega": "rad s-1",
        "F": "N",
        "bifurcation_omega": "rad s-1",
        "displacement_mean": "m",
    }
    assert data.attrs["follow"] == "omega both"
    free = kind_of(study.scenes["free"]).solve(study.scenes["free"])
    shown = display_units({"free": free, "response": data})
    (picture,) = kind_of(scene).pictures_of(data)
    figure = picture.draw(shown["response"], scene.figure, shown)
    assert figure.axes[0].texts[-1].get_text() == "first harmonic $A_1$ (mm)"
    assert figure.axes[-1].get_xlabel() == "angular frequency of excitation $\\omega$ (rad/s)"
    report = report_data(study, {"free": free, "response": data}, {})
    assert "rad/s at F = 32 N" in " ".join(report["answers"][0].values())
    tables = [
        item for group in report["groups"] for item in group["items"] if item["type"] == "table"
    ]
    assert tables[0]["head"][:6:2] == ["F (N)", "from (rad/s)", "to (rad/s)"]
    beside = {row["symbol"]: row["value"] for row in report["side"]["rows"]}
    assert beside["ω"] == "50 … 150 rad/s"
    assert beside["F"] == "32, 64 N"


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("from: 70 rad/s", "from: 70", "along.omega.from: must be a frequency > 0 with its unit, such as 55 rad/s, "
         "got 70 (it has no unit)"),
        ("50 rad/s,", "5 mm,", "along.omega.to[0]: must be a frequency > 0 with its unit"),
        ("50 rad/s,", "80 rad/s,", "along.omega.to: must have `from` between its two values"),
        ("along: {omega", "along: {nu", "along.nu: is an unknown key; must be one of omega, F, H"),
        ("from: 70 rad/s, ", "", "along.omega.from: is required"),
        ("at: [80 rad/s", "at: [80", "at[0]: must be a frequency > 0 with its unit"),
        ("at: [80 rad/s", "at: [20 rad/s", "at: must have values between the ends of `along`"),
        ("over: {F:", "physical: {omega: 9 Hz}\n    over: {F:",
         "physical.omega: must be left out, since omega is followed, got '9 Hz'"),
    ],
)  # fmt: skip
def test_a_wrong_key_with_units_is_named(old, new, message):
    assert old in PHYSICAL
    with pytest.raises(StudyError, match=re.escape(f"scenes.response.{message}")):
        study_of_text(PHYSICAL.replace(old, new), "laws")


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("from: 1.05", "from: 0", "along.nu.from: must be a finite number > 0, got 0"),
        ("to: [0.8, 3]", "to: 1.05", "along.nu.to: must differ from `from` and from each other"),
        ("to: [0.8, 3]", "to: [0.8, 1, 3]", "along.nu.to: must be a number or a list of two, got a list of 3"),
        ("from: 1.05", "from: high", "along.nu.from: must be a finite number, got 'high'"),
        ("from: 1.05, ", "", "along.nu.from: is required (a finite number > 0)"),
        ("to: [0.8, 3]", "till: 3", "along.nu.till: is an unknown key; must be one of from, to, within"),
        ("f: [0.25, 0.5]", "nu: [0.25, 0.5]", "over.nu: must be left out, since nu is followed"),
        ("f: [0.25, 0.5]", "R1: [0.25, 1.5]", "over.R1: must be a number from 0 to 1"),
        ("at: [1, 2]", "at: [1, 4]", "at: must be values from 0.8 to 3.0, got 1.0 to 4.0"),
        ("to: [0.8, 3]", "to: [2, 3]", "along.nu.to: must have `from` between its two values"),
        ("at: [1, 2]", "switch: [turn]", "switch[0]: must be"),
        ("{l: 0.5, h: 0.2,", "{h: 0.2,", "exciter.l: is required"),
        ("at: [1, 2]", "start: {x0: 0.6}", "start.x0: must be"),
        ("at: [1, 2]", "exciter: {nu: 1}", "exciter.nu: must be left out, since it stands in along"),
        ("at: [1, 2]", "figure: {backbone: free}", "figure.backbone: must be a backbone scene"),
    ],
)  # fmt: skip
def test_a_wrong_key_is_named(old, new, message):
    with pytest.raises(StudyError, match=re.escape(f"scenes.response.{message}")):
        study_of_text(STUDY.replace(old, new), "laws")


def test_free_motion_is_drawn_under_amplitudes_and_velocities(scene, dataset):
    free = vp.amplitude_frequency(vp.Exciter(l=0.5), np.linspace(0.51, 1.5, 40))
    figure = draw_branches(dataset, ["displacement_amplitude", "impact_velocity_max"], free)
    # both supports are alike
    expected = [
        free.displacement_amplitude.sel(harmonic=1),
        free.impact_velocity_max.sel(support=1),
    ]
    for ax, values in zip(figure.axes, expected, strict=False):
        drawn = ax.lines[0]
        assert np.array_equal(drawn.get_xdata(), free.eigenfrequency)
        assert np.array_equal(drawn.get_ydata(), values)


def test_the_caption_counts_each_place_once():
    """Mirror images have the same bifurcation, and all branches that meet at a grazing end there."""
    text = STUDY.replace("[0.25, 0.5]", "[0.25]") + "    switch: [pitchfork, grazing]\n"
    scene = study_of_text(text.replace("[0.8, 3]", "[0.6, 3]"), "laws").scenes["response"]
    dataset = kind_of(scene).solve(scene)
    places = places_of(dataset)
    kinds = dataset["bifurcation_kind"].values
    assert places["grazing"].size < np.count_nonzero(kinds == Bifurcation.GRAZING)
    for name, at in places.items():
        rows = dataset["bifurcation_nu"].values[kinds == Bifurcation[name.upper()]]
        assert abs(rows[:, None] - at).min(axis=1).max() < 1e-9
        assert at.size == 1 or np.diff(at).min() > 1e-9
    (picture,) = kind_of(scene).pictures_of(dataset)
    caption = picture.describe(dataset, scene.figure, {})
    for name, at in places.items():
        assert f"{amount_text(at.size, name)}" in caption


def test_findings_count_the_stable_motions_that_are_followed():
    """A pair of mirrored motions is stable from the flip to the grazing where each begins; no gap at the flip."""
    text = STUDY.replace("[0.25, 0.5]", "[0.25]") + "    switch: [pitchfork, flip, grazing]\n"
    text = text.replace("[0.8, 3]", "[0.78, 1.1]").replace("[1, 2]", "[1]")
    scene = study_of_text(text, "laws").scenes["response"]
    dataset = kind_of(scene).solve(scene)
    intervals = common_intervals(stretches_of(dataset))
    flips = places_of(dataset)["flip"]
    assert any(low < flip < high for low, high in intervals for flip in flips)
    together = together_answer(dataset, stretches_of(dataset))
    assert together.lead.startswith("The start decides which motion settles from ν = ")


@pytest.mark.parametrize(
    ("ends", "where"),
    [
        ((0.6, 1.1), "at ν = 0.7336, a grazing."),
        ((1.5, 2.0), "at ν = 2, where the branch is followed no further."),
    ],
)
def test_the_hardest_impact_says_what_lies_at_the_end_of_a_branch(ends, where):
    exciter = vp.Exciter(l=0.5, nu=sum(ends) / 2, f=-1.0, h=0.2, R1=0.7, R2=0.7)
    assert branch_answers(vp.branch(exciter, "nu", ends))[-1].lead.endswith(where)


def test_an_unstable_pair_is_not_stable_where_it_begins():
    # Its multiplier at the pitchfork is 1 but for rounding: both were listed as stable over 1e-6 of nu.
    exciter = vp.Exciter(l=0.5, nu=1.05, f=0.25, h=0.2, R1=0.7, R2=0.7)
    branch = vp.branch(exciter, "nu", (0.94, 1.06), switch=["pitchfork"])
    first = np.flatnonzero(np.diff(branch.branch_id.values, prepend=-1))
    assert (branch.floquet_multiplier.values[first[1:]].real.max(axis=1) > 1 - 1e-8).all()
    (only,) = stretches_of(branch)
    assert only.ends == ("pitchfork", "")
    assert only.values[0] == pytest.approx(0.951334, abs=1e-6)


def test_begins_and_ends_of_rests_are_no_jumps():
    exciter = vp.Exciter(l=0.5, nu=0.6, f=1.0, h=0.05, R1=0.3, R2=0.2)
    branch = vp.branch(exciter, "nu", (0.5, 0.9))
    assert set(branch.bifurcation_kind.values.tolist()) == {Bifurcation.CHANGE}
    assert (branch.stable == 1).all()
    assert not any("jump" in f"{answer}" for answer in branch_answers(branch))


LAWFUL = """
title: One law
physical: {m: 0.35 kg, C: 6 N/mm, H: 4.583 N s/m, l: 4 mm}
exciter: {R1: 0.6, R2: 0.75}
scenes:
  law: {kind: branch, law: [1, 1, 1], over: {F: [1 N, 12 N]}, along: {omega: {within: [10 Hz, 60 Hz]}}}
"""


def test_a_law_is_told_by_where_it_exists_and_is_stable():
    scene = study_of_text(LAWFUL, "laws").scenes["law"]
    dataset = kind_of(scene).solve(scene)
    laws = np.column_stack([dataset.period_multiple, dataset.impacts_per_orbit])
    assert (laws == (1, 1, 1)).all()
    assert (dataset.F == 12.0).all()  # 1 N reaches no support
    answer = branch_answers(dataset)[0]
    first, last = (format_number(float(end(dataset.omega.values))) for end in (min, max))
    assert answer.lead.startswith(f"Orbits (1; 1, 1) exist at F = 12 N from ω = {first} to ")
    assert answer.lead.endswith(f" to {last} rad/s.")
    stable = dataset.stable.values == 1
    assert "At one value of F none is found." in answer.rest
    first, last = (format_number(float(end(dataset.omega.values[stable]))) for end in (min, max))
    assert f"They are stable from ω = {first} to {last}" in answer.rest
    assert len(np.unique(dataset.branch_id)) >= 2


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("law: [1, 1], along: {nu: {within: [0.3, 3]}}",
         "s.law: must be [m, p1, p2]: a period multiple from 1 to 32, and impacts on each support from 0 to 64, got"),
        ("law: [1, 1, 1], along: {nu: {from: 1, to: 2}}",
         "s.along.nu.from: must be left out beside law: write within"),
        ("along: {nu: {within: [0.3, 3]}}", "s.along.nu.within: must be left out without law: write from and to"),
        ("along: {nu: {from: 1}}", "s.along.nu.to: is required (a finite number > 0)"),
        ("law: [1, 1, 1], along: {nu: {within: [3, 0.3]}}", "s.along.nu.within: must be two increasing numbers"),
        ("law: [1, 1, 1], switch: [flip], along: {nu: {within: [0.3, 3]}}", "s.switch: must be left out beside law"),
        ("law: [1, 1, 1], start: {v0: 1}, along: {nu: {within: [0.3, 3]}}", "s.start: must be left out beside law"),
    ],
)  # fmt: skip
def test_what_does_not_fit_beside_a_law_is_refused(text, message):
    study = f"title: T\nexciter: {{l: 0.5, f: 1, h: 0.2}}\nscenes:\n  s: {{kind: branch, {text}}}\n"
    with pytest.raises(StudyError, match=re.escape(message)):
        study_of_text(study, "laws")


SCATTERED = """
title: Scatter
physical: {m: 0.35 kg, C: 6 N/mm, H: 4.583 N s/m, F: 12 N, l: 4 mm}
exciter: {R1: 0.6, R2: 0.75}
scenes:
  response:
    kind: branch
    along: {omega: {from: 30 Hz, to: [10 Hz, 60 Hz]}}
    start: {v0: 0.5 m/s}
    tolerance: {F: 0.1 N, R1: 0.01}
"""


def test_the_ends_of_stable_motions_scatter_with_the_parts():
    scene = study_of_text(SCATTERED, "laws").scenes["response"]
    dataset = kind_of(scene).solve(scene)
    by = dataset.bifurcation_omega_sensitivity
    assert by.parameter.values.tolist() == ["F", "R1"]
    expected = np.sqrt((by.sel(parameter="F") * 0.1) ** 2 + (by.sel(parameter="R1") * 0.01) ** 2)
    np.testing.assert_allclose(dataset.bifurcation_omega_std, expected, rtol=1e-12)
    np.testing.assert_allclose(dataset.bifurcation_omega_contribution.sum("parameter"), 1.0)
    fold = int(dataset.bifurcation_omega.argmax("bifurcation"))
    near = []
    for force in (11.99, 12.01):
        text = SCATTERED.replace("F: 12 N", f"F: {force} N")
        other = kind_of(scene).solve(study_of_text(text, "laws").scenes["response"])
        near.append(float(other.bifurcation_omega.max()))
    assert float(by.sel(parameter="F")[fold]) == pytest.approx((near[1] - near[0]) / 0.02, rel=1e-4)
    (table,) = [each for each in tables({"response": dataset}) if "scatter" in each.title]
    assert [row[1] for row in table.rows] == ["fold", "fold"]
    assert table.rows[-1][0] == "both supports, once a period"


OF_PARTS = SCATTERED.replace("F: 0.1 N, R1: 0.01", "F: 0.6 N, R1: 0.03").replace(
    "from: 30 Hz, to: [10 Hz, 60 Hz]", "from: 40 Hz, to: 42 Hz"
)


def test_yields_along_branches_are_those_of_the_call_and_told_at_their_points():
    keys = 'subject_to: {impact_velocity_max_1: "< 0.66 m/s"}\n    at: [40.5 Hz, 41.5 Hz]\n'
    scene = study_of_text(OF_PARTS + "    " + keys, "laws").scenes["response"]
    dataset = kind_of(scene).solve(scene)
    exciter = vp.Exciter.from_physical(
        m="0.35 kg", C="6 N/mm", H="4.583 N s/m", F="12 N", l="4 mm", omega="40 Hz", R1=0.6, R2=0.75
    )
    called = vp.branch(
        exciter, "omega", "42 Hz", v0="0.5 m/s", at=["40.5 Hz", "41.5 Hz"], harmonics=3,
        tolerance={"F": "0.6 N", "R1": 0.03}, subject_to={"impact_velocity_max_1": "< 0.66 m/s"},
    )  # fmt: skip
    known = np.flatnonzero(np.isfinite(dataset["yield"].values))
    assert len(known) == 2
    for name in ("yield", "law_yield", "F_sort_threshold"):
        np.testing.assert_allclose(dataset[name], called[name], rtol=1e-9)
    (table,) = (each for each in tables({"response": dataset}) if "scattered parts" in each.title)
    assert [row[2] for row in table.rows] == [percent(float(dataset["yield"][n])) for n in known]
    told = yield_answer(dataset)
    assert told.lead.endswith("95 % of the parts keep their law of motion and the bounds.")
    assert f"{percent(float(dataset['yield'].min()))} of 1,024 parts" in told.rest
    made = int((dataset.yield_low >= 0.95).sum())
    assert told.lead.startswith(f"At {made} of 2" if 0 < made < 2 else "At none of 2")


def test_yields_at_several_values_are_listed_with_them():
    text = OF_PARTS.replace("    start:", "    over: {R2: [0.6, 0.75]}\n    start:")
    text = (
        text.replace("R1: 0.6, R2: 0.75", "R1: 0.6")
        .replace("R1: 0.03", "R1: 0.0003")
        .replace("F: 0.6 N", "F: 0.001 N")
    )
    scene = study_of_text(text + "    at: [41 Hz]\n    subject_to: {}\n", "laws").scenes["response"]
    dataset = kind_of(scene).solve(scene)
    (table,) = (each for each in tables({"response": dataset}) if "scattered parts" in each.title)
    assert [row[0] for row in table.rows] == ["0.6", "0.75"]
    assert yield_answer(dataset).lead == (
        "At all 2 points where parts were scattered, at least 95 % of the parts keep their law of motion."
    )
    assert yield_answer(dataset).rest == "At each, 100 % of 1,024 parts do."


def test_bounds_without_a_tolerance_or_of_what_no_part_has_are_refused():
    for keys, message in (
        ("subject_to: {displacement_mean: '> 1 mm'}", "tolerance: is required beside subject_to"),
        ("tolerance: {F: 1 N}, subject_to: {fold_omega_up: '> 20 Hz'}",
         "subject_to.fold_omega_up: must be a quantity of the motion"),
        ("tolerance: {F: 1 N}, subject_to: {support_force_max_1: '< 20 N'}", "physical.C1: must be above 0"),
        ("tolerance: {F: 1 N}, subject_to: {displacement_mean: '1 mm'}", "must be bounds in quotes"),
    ):  # fmt: skip
        scene = f"  s: {{kind: branch, along: {{omega: {{from: 30 Hz, to: 40 Hz}}}}, {keys}}}\n"
        text = SCATTERED.split("scenes:")[0] + "scenes:\n" + scene
        with pytest.raises(StudyError, match=re.escape(message)):
            study_of_text(text, "laws")


def test_scatter_of_what_moves_no_bifurcation_is_refused():
    for name, message in (
        ("omega: 1 Hz", "omega: must be left out: it is followed"),
        ("friction: 1 N", "there is no friction"),
    ):
        text = SCATTERED.replace("F: 0.1 N, R1", f"{name}, R1")
        with pytest.raises(StudyError, match=re.escape(message)):
            study_of_text(text, "laws")
