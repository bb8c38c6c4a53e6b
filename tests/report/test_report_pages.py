"""Pages of reports: the first has question, answers and hero; pages are filled; type is one family and legible."""

from pathlib import Path

import numpy as np
import pytest
from figures.sample_datasets import Scene
from pdf_pages import filled, letters, page_texts
from report_text import flat, items, study_of

from vibropipe.figures.canvas import MIN_TYPE, axes, new_canvas
from vibropipe.figures.style import house_style, save
from vibropipe.jobs.report_data import hero_of, report_data
from vibropipe.report import typeset
from vibropipe.report.parts import Table
from vibropipe.words.regimes import Regime
from vibropipe.words.status import Status


def test_the_first_page_has_question_answers_and_hero(report, data):
    assert data["hero"]["name"] == "response"
    assert data["kind"].startswith("Steady states · ")
    question = "How does the motion change with the frequency of excitation and the amplitude of excitation?"
    assert data["question"] == question
    first, *others = map(flat, page_texts(report))
    assert flat(question) in first
    assert len(data["answers"]) == 3
    for answer in data["answers"]:
        assert flat(f"{answer['lead']}{answer['rest']}") in first
    assert first.index("Figure1") < first.index(flat(data["hero"]["caption"])[:40])
    assert others
    assert data["footer"].partition(" · 2")[0].replace(" ", "") in first


def test_answers_of_other_scenes_stand_beside_their_figures(data):
    by_scene = {group["items"][0].get("scene"): group["answers"] for group in data["groups"]}
    assert by_scene["hard"][0]["lead"] == "4 cases: 1 bound exceeded."
    assert all(len(answers) <= 3 for answers in by_scene.values())


def test_a_study_chooses_question_and_hero(solved):
    study, _, datasets = solved
    hero = study_of({}, hero=None).__class__(scene="law", picture=None)
    chosen = study_of(study.scenes, question="Why?", hero=hero)
    entries = report_data(chosen, datasets, {})
    assert entries["question"] == "Why?"
    assert entries["hero"]["name"] == "law"
    assert entries["kind"].startswith("Free motion · ")
    assert "Free motions strike both supports" in " ".join(entries["answers"][0].values())
    assert "law" not in [entry["name"] for entry in items(entries, "figure")]
    assert hero_of(study) == ("response", "response")


def test_motions_and_rows_that_did_not_end_as_asked_are_named_last(solved, data):
    study, _, datasets = solved
    assert "Rows and motions to look at" not in [table["title"] for table in items(data, "table")]
    regime = datasets["response"]["regime"]
    status = regime.copy(data=np.where(regime == Regime.UNRESOLVED, Status.MAX_IMPACTS, Status.OK))
    bad = datasets | {
        "free": datasets["free"].assign(status=np.int8(Status.LOG_FULL)),
        "response": datasets["response"].assign(status=status),
    }
    entries = report_data(study, bad, {})
    group = entries["groups"][-1]
    assert group["heading"] == "Which rows and motions did not end as asked?"
    assert entries["fixed"] == 1
    rows = {row[0]: row[1:] for row in group["items"][0]["rows"]}
    number = int((status == Status.MAX_IMPACTS).sum())
    assert rows["free"] == ["log full", "–", "–", Status.LOG_FULL.remedy]
    assert rows["response"][1] == f"{number} of 363"
    assert rows["response"][2] == "ν = 2.415 … 2.595, f = 0.1 … 0.5"
    # a motion that is known to be aperiodic in its window is a result
    status = regime.copy(data=np.where(regime == Regime.APERIODIC, Status.MAX_PERIODS, Status.OK))
    assert (status == Status.MAX_PERIODS).any()
    chaos = datasets | {"response": datasets["response"].assign(status=status)}
    assert report_data(study, chaos, {})["fixed"] == 0
    # one that grows without bound has no orbit, and is not unresolved
    grows = chaos["response"].assign(
        regime=regime.copy(data=np.where(status, Regime.UNBOUNDED, regime))
    )
    entries = report_data(study, datasets | {"response": grows}, {})
    (line,) = [line for line in entries["methods"] if line["name"] == "To look at"]
    assert line["text"].endswith(", unbounded")
    # one line tells what is one row of the table
    few = datasets | {"response": bad["response"]}
    entries = report_data(study, few, {})
    assert entries["fixed"] == 0
    (line,) = [line for line in entries["methods"] if line["name"] == "To look at"]
    where = "ν = 2.415 … 2.595, f = 0.1 … 0.5"
    remedy = Status.MAX_IMPACTS.remedy.replace("`", "")  # a report has no marks of code
    assert (
        line["text"] == f"“response”: {number} of 363 rows, at {where}, too many impacts. {remedy}"
    )


FILLED = 0.65


@pytest.fixture(scope="module")
def pages_of(tmp_path_factory):
    """Return a function from heights of figures and tables, in groups, to the pages of a report of them.

    `following` are the numbers of the groups that are of the scene of the one before.
    """
    folder = tmp_path_factory.mktemp("flow")

    def picture(height: float, width: float) -> str:
        name = f"f{height:g}_{width:g}"
        if not (folder / f"{name}.pdf").exists():
            with house_style():
                figure = new_canvas(height, width)
                axes(figure, 1.2, 1.2, width - 1.5, height - 1.5).plot([0, 1], [0, 1])
                save(figure, folder, name)
        return name

    def item(size, number) -> dict:
        if isinstance(size, int):
            rows = [[f"row {n}", "1"] for n in range(size)]
            return Table(["a", "b"], rows, "Note.", title=f"T{number}").as_data()
        name = picture(*size) if isinstance(size, tuple) else picture(size, 16.0)
        path = f"figures/{name}.pdf"
        return {
            "type": "figure",
            "name": name,
            "path": path,
            "title": f"T{number}",
            "caption": "Drawn.",
            "alt": "a",
        }

    def pages(hero: float, groups, following=()) -> tuple[Path, list[str]]:
        numbers = iter(range(2, 100))
        given = {
            "title": "Flow", "kind": "Kind", "question": "Why?", "footer": "Foot", "fixed": 0, "symbols": "",
            "answers": [{"lead": "So.", "rest": ""}], "side": {"rows": [], "drawing": None},
            "hero": item(hero, 1),
            "groups": [
                {
                    "heading": f"Q{n}?", "follows": n in following, "answers": [],
                    "items": [item(size, next(numbers)) for size in group],
                }
                for n, group in enumerate(groups)
            ],
            "methods": [{"name": "Again", "text": "`run`", "plain": False}],
        }  # fmt: skip
        path = folder / "flow.pdf"
        path.write_bytes(typeset(given, {each.stem: each for each in folder.glob("f*.pdf")}))
        return path, page_texts(path)

    return pages


def test_a_gap_is_filled_by_what_comes_later(pages_of):
    # neither figure fits below the hero, nor the second below the first; both tables do
    path, texts = pages_of(11.0, [[14.0, 8, 14.0, 9]])
    assert [[f"T{n}" in text for n in (2, 3, 4, 5)] for text in texts] == [
        [False, True, False, False],
        [True, False, False, True],
        [False, False, True, False],
    ]
    assert "Q0?" in texts[0]
    assert min(filled(path)[:-1]) >= FILLED


def test_a_group_that_fits_is_set_before_one_that_does_not(pages_of):
    _, texts = pages_of(9.0, [[14.0], [13.0], [6.0]])
    assert [[f"Q{n}?" in text for n in range(3)] for text in texts] == [
        [False, False, True],
        [True, False, False],
        [False, True, False],
    ]


def test_groups_of_one_scene_stay_together(pages_of):
    # as above, but the last group, or the first, is of the scene of what stands before it
    for following in ({2}, {0, 1}):
        _, texts = pages_of(9.0, [[14.0], [13.0], [6.0]], following)
        assert [[f"Q{n}?" in text for n in range(3)] for text in texts] == [
            [False, False, False],
            [True, False, False],
            [False, True, True],
        ]


def test_headings_stay_with_their_figures_and_nothing_breaks(pages_of):
    for height in (5.0, 7.5, 9.0, 11.0):
        _, texts = pages_of(8.0, [[height], [height, 5], [height], [9, height]])
        for heading, first in (("Q0?", "T2"), ("Q1?", "T3"), ("Q2?", "T5"), ("Q3?", "T6")):
            (page,) = [text for text in texts if heading in text]
            assert first in page
        assert sum(text.count("Note.") for text in texts) == 2
        assert sum(text.count("Drawn.") for text in texts) == 5


def test_narrow_figures_stand_side_by_side(pages_of):
    path, texts = pages_of(9.0, [[(6.0, 7.75), (6.0, 7.75)]])
    assert len(texts) == 1
    assert "T2" in texts[0]
    assert "T3" in texts[0]
    assert filled(path)[0] < 1.01


def test_figures_keep_their_size_unless_too_tall_for_a_page(pages_of):
    path, texts = pages_of(9.0, [[23.0], [30.0]])
    assert [[f"T{n}" in text for n in (1, 2, 3)] for text in texts[:3]] == np.eye(
        3, dtype=bool
    ).tolist()
    sizes = {letter.size for letter in letters(path) if letter.page == 2}
    assert 7.0 in {round(size, 2) for size in sizes}
    reduced = {round(letter.size, 2) for letter in letters(path) if letter.page == 3}
    assert 7.0 not in reduced
    assert max(filled(path)) <= 1.0


def test_figures_are_a_little_smaller_where_that_saves_a_page(pages_of):
    path, texts = pages_of(9.0, [[23.5]])
    assert len(texts) == 2  # with the methods, which would stand alone on a third page
    sizes = {letter.size for letter in letters(path) if letter.page == 2 and letter.size < 7.0}
    assert min(sizes) >= MIN_TYPE


def test_figures_are_a_little_smaller_where_that_closes_a_gap(pages_of):
    path, texts = pages_of(11.0, [[9.6], [9.6], [9.6], [9.6]])
    assert len(texts) == 3
    assert "T2" in texts[0]
    assert min(filled(path)[:-1]) > 0.75


def test_a_heading_alone_is_measured_with_the_space_below_it(pages_of):
    path, texts = pages_of(15.0, [[10.9], [11.4], [10.9]])
    assert len(texts) == 3
    assert filled(path)[1] > 0.95


def test_rows_beside_the_answers_and_units_do_not_break(tmp_path):
    rows = [
        {"symbol": "C₁", "value": "100, 200, 800 N·s/mm", "words": "stiffness of support 1"},
        {"symbol": "κ", "value": "0.5", "words": "mass ratio"},
    ]
    note = ", ".join(["20 N·s/m"] * 80)  # at the end of every line stands one
    data = {
        "title": "Rows over x(0) and x'(0)", "kind": "Kind",
        "question": "Why?", "footer": "", "fixed": 0, "symbols": "", "answers": [],
        "side": {"rows": rows, "drawing": None}, "groups": [], "methods": [],
        "hero": Table(["a"], [["1"]], note, title="T").as_data(),
    }  # fmt: skip
    path = tmp_path / "rows.pdf"
    path.write_bytes(typeset(data, {}))
    lines = [line.replace("\u00a0", " ") for line in page_texts(path)[0].splitlines()]
    assert "Rows over x(0) and ẋ(0)" in lines  # as in figures
    assert "C₁ 100, 200, 800 N·s/mm stiffness of support 1" in lines
    units = [line for line in lines if "N·s/m" in line][1:]
    assert len(units) > 3
    assert all(line.startswith("20 ") and line.rstrip(", ").endswith("N·s/m") for line in units)


def test_a_scene_with_a_caption_of_its_own_keeps_the_title_of_its_picture(solved):
    scene = Scene("motion", "a_b", title="")
    assert scene.title == ""
    _, _, datasets = solved
    entries = report_data(study_of({"a_b": scene}), {"a_b": datasets["free"]}, {})
    assert entries["hero"]["title"].startswith(
        ("Both supports are struck, hardest at ", "Supports 1 and 2 are struck, hardest at ")
    )
    bare = datasets["free"].drop_dims(["impact", "grazing", "rest"], errors="ignore")
    entries = report_data(study_of({"a_b": scene}), {"a_b": bare}, {})
    assert entries["hero"]["title"] == "A b"
