"""What every report keeps, for small studies of every kind of scene: pages, type, words and numbers of sentences."""

import re
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr
from command_line import run
from pdf_pages import filled, letters, page_texts
from sentence_numbers import missing, values_of
from small_studies import STUDIES

from vibropipe.figures.canvas import MIN_TYPE
from vibropipe.jobs.drawing import draw_study
from vibropipe.jobs.report_data import report_data
from vibropipe.jobs.reporting import build_report
from vibropipe.jobs.solving import solve_to_file
from vibropipe.store import read_scenes, read_sidecar
from vibropipe.study import load_study

MIN_FILLED = 0.65
MAX_TITLE = 85
SHIPPED = ("paper", "regimes", "laws", "coexistence", "design", "hard_cases", "accuracy", "effects")
# A number, with its power of ten; names of supports, figures, harmonics, designs, methods (RK45) and laws of motion
# (m; p1, p2) have none.
NAMES = re.compile(
    r"([Ss]upports?|[Ff]igures?|[Hh]armonics?|[Dd]esigns?) \d+(( and |, )\d+)*|[A-Z]+\d+|\(\d+; \d+, \d+\)|95 %"
)
NUMBER = re.compile(r"\d[\d,]*(\.\d+)?( × 10[⁻⁰¹²³⁴-⁹]+)?")
DECIMAL = re.compile(r"−?\d[\d,]*\.\d+( × 10[⁻⁰¹²³⁴-⁹]+)?")


@pytest.fixture(scope="module")
def reports(tmp_path_factory):
    """Return a function from the name of a study to its report: file and data."""
    made: dict[str, SimpleNamespace] = {}

    def report_of(name: str) -> SimpleNamespace:
        if name not in made:
            folder = tmp_path_factory.mktemp(name)
            file = folder / f"{name}.yaml"
            if name in STUDIES:
                file.write_text(STUDIES[name], encoding="utf-8")
            else:
                file = Path(__file__).parents[2] / "config" / f"{name}.yaml"
            study = load_study(file)
            for scene in study.scenes:
                solve_to_file(study, scene, folder / name / f"{scene}.nc", None, 1)
            draw_study(study, folder)
            pdf = build_report(study, folder, folder / "report.pdf")
            datasets = read_scenes(folder / name, study.scenes, study.fingerprints)
            sidecars = {each: read_sidecar(folder / name / f"{each}.nc") for each in study.scenes}
            data = report_data(study, datasets, sidecars)
            made[name] = SimpleNamespace(pdf=pdf, data=data, datasets=study.shown(datasets))
        return made[name]

    return report_of


@pytest.fixture(params=[*STUDIES, *(pytest.param(n, marks=pytest.mark.slow) for n in SHIPPED)])
def report(reports, request) -> SimpleNamespace:
    return reports(request.param)


def figures_of(data) -> list[dict]:
    return [data["hero"], *(i for g in data["groups"] for i in g["items"] if i["type"] == "figure")]


def answers_of(data) -> Iterator[list[dict]]:
    yield data["answers"]
    for group in data["groups"]:
        yield group["answers"]


def numbers_in(text: str) -> list[str]:
    """Return the numbers that a sentence states."""
    return [found[0] for found in NUMBER.finditer(NAMES.sub("", text))]


def derived_from(dataset: xr.Dataset) -> Iterator[float]:
    """Yield what sentences state that follows from a dataset: shares of codes, steps of grids, ratios of a cascade."""
    for name, array in dataset.variables.items():
        if array.dtype.kind in "iub" and array.size:
            yield from np.unique(array.values, return_counts=True)[1] / array.size
        steps = np.abs(np.diff(array.values)) if name in ("x0", "v0") else ()
        yield from steps
        if str(name).startswith("bifurcation_") and array.dtype.kind == "f":
            steps = np.abs(np.diff(np.unique(array.values)))
            yield from (before / after for before, after in pairwise(steps))


@pytest.mark.parametrize(
    ("text", "amount"),
    [
        ("Support 1 is struck with 1.5, supports 1 and 2 of figure 6 are not.", 1),
        ("It fills 46 % of the map, between 2.515 and 2.520.", 3),
        ("Harmonic 1 goes from 0.357 to 0.469.", 2),
        ("DOP853 misses 21 of them, and scipy's RK45 takes 3,800 times as long.", 2),
        ("The error of (1; 1, 1) is 3 × 10⁻¹⁵, R₁ = 16,000.", 2),
    ],
)
def test_numbers_of_a_sentence_are_counted(text, amount):
    assert len(numbers_in(text)) == amount


def test_pages_are_filled(report):
    assert min([1.0, *filled(report.pdf)[:-1]]) >= MIN_FILLED


def test_type_is_of_one_family(report):
    fonts = {letter.font.partition("-")[0] for letter in letters(report.pdf)}
    assert fonts <= {"LibertinusSerif", "DejaVuSansMono"}


def test_type_is_large_enough(report):
    small = [letter for letter in letters(report.pdf) if letter.size < MIN_TYPE]
    assert not small, {(letter.page, letter.text, round(letter.size, 2)) for letter in small}


def test_no_identifier_stands_outside_methods_and_commands(report):
    names = [
        letter for letter in letters(report.pdf) if letter.text == "_" and "Mono" not in letter.font
    ]
    assert not names, re.findall(r"\S*_\S*", "".join(page_texts(report.pdf)))


def test_scenes_have_at_most_three_answers_of_two_numbers(report):
    for answers in answers_of(report.data):
        assert len(answers) <= 3
        for answer in answers:
            # A design is its parameters, however many are free.
            lead = (
                ""
                if re.match(r"(Design \d+|The design found) has ", answer["lead"])
                else answer["lead"]
            )
            text = f"{lead} {answer['rest']}"
            assert len(numbers_in(text)) <= 2, text


def test_numbers_of_answers_and_titles_are_those_of_the_data(report):
    texts = [each["title"] for each in figures_of(report.data)]
    texts += [
        f"{each['lead']} {each['rest']}" for group in answers_of(report.data) for each in group
    ]
    decimals = [number[0] for text in texts for number in DECIMAL.finditer(text)]
    derived = [value for data in report.datasets.values() for value in derived_from(data)]
    first, *others = report.datasets.values()
    derived += [value for data in others for value in values_of(data)]
    assert not missing(decimals, first, derived)


def test_every_answer_begins_with_a_half_sentence_that_is_bold(report):
    assert all(answer["lead"] for answers in answers_of(report.data) for answer in answers)


def test_titles_are_one_line(report):
    titles = [figure["title"] for figure in figures_of(report.data)]
    assert all(0 < len(title) <= MAX_TITLE for title in titles)
    assert len(set(titles)) == len(titles)
    assert report.data["answers"]
    assert report.data["question"].endswith("?")


def test_an_exponent_that_was_asked_for_stands_in_the_report(reports):
    text = " ".join("".join(page_texts(reports("motions_and_response").pdf)).split())
    assert "TheLyapunovexponentofthemotion“withoutaperiod”is" in text.replace(" ", "")


def test_an_hour_is_no_symbol(tmp_path):
    text = """title: The hour of a velocity
physical: {m: 2 kg, C: 8 N/mm, H: 40 N s/m, F: 120 N, omega: 9 Hz, l: 8 mm}
exciter: {R1: 0.7, R2: 0.6}
units: {velocity: km/h, length: in}
scenes: {one: {kind: motion}}
"""
    (tmp_path / "hour.yaml").write_text(text)
    where = (tmp_path / "hour.yaml", "--results", tmp_path / "results")
    assert run("solve", *where) == 0
    assert run("report", *where, "--output", tmp_path / "report.pdf") == 0
    printed = letters(tmp_path / "report.pdf")
    shown = "".join(letter.text for letter in printed)
    hours = [at for at in range(len(shown)) if shown.startswith("km/h", at)]
    assert hours
    assert not any("Italic" in printed[at + 3].font for at in hours)


def test_a_force_with_units_is_slanted_also_without_a_value(reports):
    printed = letters(reports("units").pdf)
    text = "".join(letter.text for letter in printed)
    place = text.index("borderinFthemass") + len("borderin")
    assert "Italic" in printed[place].font
    assert "Italic" not in printed[place + 1].font
