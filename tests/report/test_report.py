"""The report shows the datasets, its PDF contains all of the report, and a title is never markup."""

import json
import math
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr
from pdf_pages import page_texts
from report_text import HOSTILE, flat, items, study_of

import vibropipe as vp
from vibropipe.figures.text import parameters_text
from vibropipe.jobs.report_data import _groups, report_data, scene_labels
from vibropipe.jobs.reporting import build_report
from vibropipe.report import typeset
from vibropipe.report.exciter import drawing_of, said_beside, side_of, values_text
from vibropipe.report.methods import method_words, model_line, solved_line
from vibropipe.report.parts import (
    MAX_ROWS,
    Answer,
    Table,
    not_repeated,
    own_answers,
    symbol,
    told_once,
)
from vibropipe.store import StoreError, save
from vibropipe.study import study_of_text
from vibropipe.words.wording import paragraphs


def test_two_runs_give_the_same_bytes(solved, tmp_path):
    study, results, _ = solved
    first = build_report(study, results, tmp_path / "a.pdf")
    second = build_report(study, results, tmp_path / "b.pdf")
    assert first.read_bytes() == second.read_bytes()
    assert first.read_bytes().startswith(b"%PDF-")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.pdf", "b.pdf"]


def test_the_restitution_of_a_soft_support_that_states_none_is_left_out():
    soft = vp.Exciter(l=0.5, nu=1.0, f=0.8, h=0.15, k1=100.0, h1=0.1, R2=0.7)
    for exciter, symbols in (
        (soft, ["R₂"]),
        (replace(soft, k2=90.0, h2=0.2, R2=1.0), []),
        (replace(soft, k1=0.0, h1=0.0), ["R₁", "R₂"]),
    ):
        rows = side_of({"one": vp.simulate(exciter, 5.0)}).rows
        assert [row.symbol for row in rows if row.symbol.startswith("R")] == symbols


def test_text_of_a_user_is_only_text(report):
    # the PDF's own title stands in its metadata as XML
    assert b"#panic(&quot;no&quot;)" in report.read_bytes().replace(b'"', b"&quot;")
    text = flat("".join(page_texts(report)))
    hostile = flat(HOSTILE)
    assert text.count(hostile) >= 4  # title, title and caption of a scene, description
    assert f"Lookat{hostile}." in text
    assert f"First{hostile}" in text


def test_every_figure_and_table_is_there(report, data):
    text = flat("".join(page_texts(report)))
    figures = [data["hero"], *items(data, "figure")]
    assert [entry["name"] for entry in figures].count("response") == 1
    assert len(figures) == 7
    for entry in figures:
        assert flat(entry["title"]) in text
        assert flat(entry["caption"])[:80] in text
        assert entry["alt"]
    for table in items(data, "table"):
        assert flat(table["title"]) in text


def test_captions_of_the_author_stand_in_place_of_those_from_data(data):
    by_scene = {entry["name"]: entry for entry in [data["hero"], *items(data, "figure")]}
    assert by_scene["offset"]["caption"] == f"Look at {HOSTILE}."
    assert by_scene["offset"]["title"].startswith("Supports 1 and 2 are struck, hardest at ")
    assert HOSTILE in [group["heading"] for group in data["groups"]]
    assert "impacts on support" in by_scene["free"]["caption"]
    assert by_scene["offset"]["alt"] != by_scene["offset"]["caption"]


def test_scenes_are_called_by_a_short_title_else_by_words(solved):
    study, _, _ = solved
    labels = scene_labels(study)
    assert labels["very_unequal_scene"] == "very unequal scene"
    assert labels["offset"] == "offset"  # its title is long
    twice = {name: SimpleNamespace(title="Both", figure=None) for name in ("one_a", "two")}
    assert scene_labels(study_of(twice)) == {"one_a": "one a", "two": "two"}
    twice["two"].figure = SimpleNamespace(heads=["figure 6", "figure 9"])
    assert scene_labels(study_of(twice))["two"] == "figure 6"
    figure = SimpleNamespace(heads=["rigid", "soft"], drawn_together=lambda: ("soft",))
    both = {"rigid": SimpleNamespace(title="Rigid beside soft", figure=figure)}
    assert scene_labels(study_of(both))["rigid"] == "rigid"  # the title is that of the picture
    assert scene_labels(study_of(both), math.inf)["rigid"] == "Rigid beside soft"
    figure.together = ["buffer"]
    both["buffer"] = SimpleNamespace(title="", figure=SimpleNamespace(drawn_together=tuple))
    assert scene_labels(study_of(both))["buffer"] == "soft"  # as above its column


def test_numbers_beside_the_exciter(data):
    beside = {row["symbol"]: row["value"] for row in data["side"]["rows"]}
    assert beside["ν"] == "0.3 … 3"
    assert beside["δ"] == "0"  # of the hero alone, whose answers stand beside it
    assert beside["f"] == "0.1, 0.2, 0.5"
    assert beside["l"] == "0.5"
    assert list(beside)[:2] == ["ν", "f"]


def test_equal_supports_share_a_row_and_absent_effects_have_none(solved):
    _, _, datasets = solved
    one = {"symmetric": datasets["symmetric"].assign_coords(k1=0.0, k2=0.0, friction=0.0)}
    rows = {row.symbol: row for row in side_of(one).rows}
    assert rows["R₁, R₂"].value == "0.7"
    assert rows["R₁, R₂"].words == "restitution"
    assert not {"k₁", "k₁, k₂", "d"} & set(rows)
    assert not any([*drawing_of(one)["soft"], drawing_of(one)["friction"]])
    soft = {"a": datasets["symmetric"].assign_coords(k1=100.0, k2=0.0, friction=0.1)}
    rows = {row.symbol: row for row in side_of(soft).rows}
    assert rows["k₁"].value == "100"
    assert rows["d"].words == "dry friction"
    several = soft["a"].drop_vars(["k1", "R1"])
    several = several.assign_coords(k1=("motion", [0.0, 100.0]), R1=("motion", [0.6, 1.0]))
    rows = {row.symbol: row for row in side_of({"a": several}).rows}
    assert rows["R₁"].value == "0.6"  # 1 of the soft one states no restitution
    assert rows["k₁"].value == "0, 100"
    derived = several.assign_coords(h1=("motion", [3.191, 3.191004]))
    rows = {row.symbol: row for row in side_of({"a": derived}).rows}
    assert rows["h₁"].value == "3.191"  # two that are written alike
    assert drawing_of(soft)["soft"] == [True, False]
    assert drawing_of(soft)["symbols"]["supports"] == ["k₁", "R₂"]
    assert not drawing_of(soft)["housing"]
    both = soft["a"].assign_coords(k2=100.0, contact_1=1, contact_2=1, mass_ratio=0.5)
    both = both.assign_coords(housing_friction_1=0.1, housing_friction_2=0.1)
    rows = {row.symbol: row for row in side_of({"a": both}).rows}
    assert rows["k₁, k₂"].words == "stiffness of the supports"
    assert (rows["c₁, c₂"].value, rows["c₁, c₂"].words) == (
        "no pull",
        "end of a contact with the supports",
    )
    assert rows["d₁, d₂"].words == "housing friction, both ways"
    assert "c₁ = no pull, c₂ = no pull" in parameters_text(both)
    assert model_line(soft).text.startswith("ẍ + hẋ + x = f sin ντ")


@pytest.mark.parametrize(
    ("cells", "even"),
    [
        (["52.1 %", "51.83 %", "52.33 %"], ["52.10 %", "51.83 %", "52.33 %"]),
        (["0.61", "0.585"], ["0.610", "0.585"]),
        (["24", "8.9", "7", "± 4"], ["24", "8.9", "7.0", "± 4.0"]),
        (["1,250", "7", "0"], ["1,250", "7", "0"]),
        (["0.1", "0.25", "0.5"], ["0.1", "0.25", "0.5"]),
        (["0", "–", "2 × 10⁻⁹", "0.03"], ["0", "–", "2 × 10⁻⁹", "0.03"]),
    ],
)
def test_the_numbers_of_a_column_keep_their_last_zeros(cells, even):
    table = Table(["", "value"], [["a", cell] for cell in cells]).as_data()
    assert [row[1] for row in table["rows"]] == even
    first = Table(["value", ""], [[cell, "a"] for cell in cells]).as_data()
    assert [row[0] for row in first["rows"]] == cells


@pytest.mark.parametrize(
    ("offset", "sign"), [([-0.2], -1), ([-0.2, 0.0], -1), ([0.2], 1), ([0.0], 1), ([-0.2, 0.1], 1)]
)
def test_the_drawing_has_the_equilibrium_on_the_side_of_the_offset(solved, offset, sign):
    _, _, datasets = solved
    data = datasets["symmetric"].drop_vars("delta").assign_coords(delta=("offset", offset))
    assert drawing_of({"a": data})["offset"] == sign


def test_a_caption_leaves_out_parameters_that_stand_beside_the_exciter(solved):
    _, _, datasets = solved
    one = datasets["symmetric"]
    caption = f"Steady states. {parameters_text(one)}. Arrows: jumps."
    assert said_beside(caption, one, {"a": one}) == "Steady states. Arrows: jumps."
    other = one.assign_coords(h=0.9)
    assert said_beside(caption, one, {"a": one, "b": other}) == caption
    tied = one.assign_attrs(ties="R2 = R1")
    assert "tied" in parameters_text(tied)
    caption = f"Steady states. {parameters_text(tied)}."
    assert said_beside(caption, tied, {"a": tied}) == caption


def test_supports_of_a_housing_that_slides_are_no_ground(solved):
    _, _, datasets = solved
    sliding = {"a": datasets["symmetric"].assign_coords(mass_ratio=0.4, housing_friction_1=0.1)}
    assert drawing_of(sliding)["housing"]
    assert model_line(sliding).text.startswith("(ẍ + Ẍ) + hẋ + x = f sin ντ")
    rows = {row.symbol: row.words for row in side_of(sliding).rows}
    assert rows["d₁"] == "housing friction along x"
    assert rows["κ"] == "mass ratio m/M"


def test_parameters_in_si_have_their_units(solved):
    _, _, datasets = solved
    dataset = datasets["response"].rename(nu="omega", f="F", h="H").assign_coords(C=8000.0)
    dataset["omega"].attrs["units"], dataset["l"].attrs["units"] = "rad/s", "mm"
    rows = {row.symbol: row.value for row in side_of({"response": dataset}).rows}
    assert rows["ω"] == "0.3 … 3 rad/s"
    assert rows["l"] == "0.5 mm"
    assert drawing_of({"response": dataset})["symbols"]["force"] == "F sin ωt"
    no_force = xr.zeros_like(dataset["F"])
    assert drawing_of({"response": dataset.assign_coords(F=no_force)})["symbols"]["force"] == ""
    two = dataset.assign_coords(F2=no_force + 1.0)
    assert drawing_of({"response": two})["symbols"]["force"] == "F(t)"
    shaken = dataset.assign_coords(shaker=no_force + 1e-3)
    assert drawing_of({"response": shaken})["symbols"]["force"] == "F(t)"


def test_methods_and_provenance(data):
    lines = {line["name"]: line["text"] for line in data["methods"]}
    assert list(lines) == ["About", "", "Compared with", "Known by", "Solved by", "Model", "Again"]
    assert "computed in steps differ by at most 0.001" in lines["Compared with"]
    assert "accuracy asked: 1 × 10⁻⁸; orbits close to 1 × 10⁻¹⁴" in lines["Solved by"]
    assert "vibropipe 0.1.0 (commit 0123456789ab)" in lines["Again"]
    assert lines["Again"].startswith("`vibropipe run small.yaml`; data: 7 files in `results/small`")
    assert lines["Again"].endswith("computed in 1.2 s, compilation included")
    assert data["footer"] == "vibropipe 0.1.0 · study small · 24 November 2026"


def test_the_command_has_the_folder_of_results(solved):
    study, _, datasets = solved
    elsewhere = report_data(study, datasets, {}, Path("other results"))["methods"][-1]["text"]
    assert elsewhere.startswith("`vibropipe run small.yaml --results 'other results'`; ")
    assert "data: 7 files in `other results/small`" in elsewhere


def test_datasets_of_different_origin_are_told_apart(solved):
    study, _, datasets = solved
    mixed = datasets | {"free": datasets["free"].assign_attrs(git_commit="another")}
    again = report_data(study, mixed, {})["methods"][-1]["text"]
    assert "(commit 0123456789ab) and vibropipe 0.1.0 (commit another)" in again


def test_a_study_of_one_scene_without_steady_states(solved):
    study, results, datasets = solved
    alone = study_of({"free": study.scenes["free"]})
    bare = {"free": datasets["free"].drop_attrs()}
    pictures = {"free": results / "small" / "figures" / "free.pdf"}
    assert typeset(report_data(alone, bare, {}), pictures).startswith(b"%PDF-")


def test_a_missing_figure_or_dataset_is_named(solved, tmp_path):
    study, _, datasets = solved
    save(datasets["free"], tmp_path / "small" / "free.nc")
    alone = study_of({"free": study.scenes["free"]})
    with pytest.raises(StoreError, match=r"free\.pdf.*draw the figures"):
        build_report(alone, tmp_path, tmp_path / "report.pdf")
    with pytest.raises(StoreError, match=r"no dataset of law, symmetric, offset"):
        build_report(study, tmp_path, tmp_path / "report.pdf")
    assert not (tmp_path / "report.pdf").exists()


def test_paragraphs_and_tables():
    assert paragraphs("one\ntwo\n\n \n\nthree") == ["one two", "three"]
    assert paragraphs("") == []
    with pytest.raises(ValueError, match="2 columns has a row of 1"):
        Table(["a", "b"], [["only"]]).as_data()
    long = Table(["a"], [[str(n)] for n in range(MAX_ROWS + 1)], "Note.").as_data()
    assert len(long["rows"]) == 10
    assert long["note"] == "Note. 3 more rows are in the dataset."


def test_names_of_quantities_become_symbols():
    names = ["delta", "omega (rad/s)", "harmonic 12 (mm)", "R1", "anything else"]
    assert [symbol(name) for name in names] == ["δ", "ω (rad/s)", "A₁₂ (mm)", "R₁", "anything else"]


def test_an_answer_with_its_numbers_is_told_once_of_an_exciter():
    jumps, several = Answer("It jumps at ν = 1.723.", "To no impact."), Answer("Several coexist.")
    along = xr.DataArray([1.0, 2.0], dims="nu", name="nu")
    same, other = (xr.Dataset(coords={"nu": along, "f": f}) for f in (1.0, 2.0))
    answers = {"first": [jumps, several], "other": [jumps], "again": [several, jumps], "": [jumps]}
    shown = {"first": same, "again": same, "other": other}
    assert not_repeated(answers, shown) == {**answers, "again": [several]}


def test_own_answers_are_bold_up_to_their_first_full_stop():
    assert own_answers(["Three coexist. Half, a third.", "All are met."]) == [
        Answer("Three coexist.", "Half, a third."),
        Answer("All are met."),
    ]


def test_data_is_json_without_loss(data):
    assert json.loads(json.dumps(data, allow_nan=False)) == data
    assert not np.isnan([len(group["items"]) for group in data["groups"]]).any()


@pytest.mark.parametrize(
    ("stored", "words"),
    [
        ("exact", "exact"),
        ("newmark, 64 steps per forcing period", "Newmark's method with 64 steps per forcing period"),
        ("exact, newmark 8, newmark 60 steps per forcing period",
         "exact, Newmark's method with 8, with 60 steps per forcing period"),
        (
            "crude, newmark, exact",
            "Newmark's method with impacts at the ends of steps, Newmark's method, exact",
        ),
    ],
)  # fmt: skip
def test_methods_are_written_in_words(stored, words):
    assert method_words(stored) == words


def test_a_method_is_named_once():
    def told(*methods):
        return solved_line({m: xr.Dataset(attrs={"method": m}) for m in methods}).text

    both = "Newmark's method with impacts at the ends of steps, exact"
    assert told("exact", "crude, exact") == both
    absent = "; not installed: heyoka"
    assert told(f"exact{absent}", f"crude, exact{absent}", "exact") == both + absent


def test_the_model_has_the_force_that_there_is():
    still = vp.Exciter(l=0.5, h=0.1)
    free, forced = (vp.simulate(e, 5.0, x0=0.1) for e in (still, replace(still, nu=1.0, f=0.1)))
    assert model_line({"a": free}).text.startswith("ẍ + hẋ + x = 0 between the supports; ")
    many = model_line({"a": xr.Dataset(attrs={"effects": "damping, forcing, load"})}).text
    assert many.startswith("ẍ + hẋ + x = f(τ) between the supports; ")
    assert "an exciter may have further terms" in many
    for one in (free, forced, vp.backbone([0.0, 0.1], [3.0, 4.0])):
        assert "further terms" not in model_line({"a": one}).text
    assert model_line({"a": free, "b": forced}).text.startswith("ẍ + hẋ + x = f sin ντ between")
    soft = vp.simulate(replace(still, k1=100.0, k2=50.0), 5.0, x0=0.1)
    turns = "an impact turns the velocity"
    assert turns not in model_line({"b": soft}).text
    assert turns in model_line({"a": free, "b": soft}).text  # rigid in one scene
    with_units = {"a": vp.to_physical(free, 1.0, 1e4)}
    assert model_line(with_units).text.startswith("mẍ + Hẋ + Cx = 0 between the supports; ")
    two = vp.simulate(replace(still, nu=1.0, f=0.1, f2=0.2, load=0.01), 5.0, x0=0.1)
    told = model_line({"b": forced, "a": two}).text
    assert told.startswith("ẍ + hẋ + x = f sin ντ + f₂ sin(2ντ + φ₂) between the supports; ")
    assert "multiplies it by R; a constant load acts; " in told  # no second verb of the impact
    si = model_line({"a": vp.to_physical(two, 1.0, 1e4)}).text
    assert si.startswith("mẍ + Hẋ + Cx = F sin ωt + F₂ sin(2ωt + φ₂) between the supports; ")


def test_values_that_a_design_found_are_not_the_exciter(solved):
    _, _, datasets = solved
    found = xr.Dataset({"delta": ("design", [0.01, 0.02])}, attrs={}).set_coords("delta")
    found["delta"].attrs |= datasets["response"]["delta"].attrs
    given = values_text("delta", datasets)
    assert values_text("delta", {**datasets, "design": found}) == given
    assert values_text("delta", {"design": found}) == "0.01, 0.02"


def test_no_heading_stands_twice_or_over_figures_of_another_scene():
    scenes = "".join(f"  {n}: {{kind: motion, title: {n.upper()}, tau_end: 9}}\n" for n in "abc")
    study = study_of_text(f"title: T\nexciter: {{l: 1, nu: 1, f: 1}}\nscenes:\n{scenes}", "study")
    figures = [
        {"scene": scene, "title": title, "heading": heading, "picture": "p"}
        for scene, title, heading in (
            ("a", "hero", ""), ("a", "a2", "Why?"), ("b", "B", ""), ("c", "c1", "Why?"), ("c", "c2", "Why?"),
        )
    ]  # fmt: skip
    labels = {name: name.upper() for name in study.scenes}
    groups = _groups(study, labels, figures, {}, {}, figures[0])
    assert [(g.heading, [item["title"] for item in g.items]) for g in groups] == [
        ("Why?", ["a2"]),
        ("Motions", ["B"]),
        ("C", ["c1", "c2"]),
    ]


def test_columns_that_all_lines_share_stand_in_the_note():
    table = Table(
        ["line", "rows", "hardest"], [["a", "100 %", "1.2"], ["b", "100 %", "1.3"]], "Note."
    )
    told = told_once(table, "all lines")
    assert told.head == ["line", "hardest"]
    assert told.note == "Of all lines, rows: 100 %. Note."
    same = replace(table, rows=[["a", "100 %", "1.2"], ["b", "100 %", "1.2"]])
    assert told_once(same, "all lines") is same  # its lines would have no cells


def test_a_table_of_several_scenes_does_not_stand_under_the_heading_of_one():
    scenes = "".join(f"  {n}: {{kind: motion, title: {n.upper()}, tau_end: 9}}\n" for n in "ab")
    study = study_of_text(f"title: T\nexciter: {{l: 1, nu: 1, f: 1}}\nscenes:\n{scenes}", "study")
    figures = [{"scene": n, "title": f"{n} seen", "heading": "", "picture": "p"} for n in "ab"]
    of_both, of_one = (
        Table(["a"], [["b"]], title=title, scene=scene)
        for title, scene in (("both", ""), ("one", "B"))
    )

    class Both:
        report = SimpleNamespace(tables=lambda own: [of_one, of_both], noun="Motions")

    labels = {"a": "A", "b": "B"}
    groups = _groups(study, labels, figures, {}, {Both: {"A": None, "B": None}}, figures[0])
    assert [(g.heading, [item["title"] for item in g.items]) for g in groups] == [
        ("B", ["b seen", "one"]),
        ("Motions", ["both"]),
    ]
