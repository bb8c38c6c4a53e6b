"""The page of one exciter: its text, its starts, its sliders, and the motions that coexist."""

import re
from collections import deque
from dataclasses import replace

import numpy as np
import pytest
import typer
from scripts_in_node import needs_node, run

import vibropipe as vp
from vibropipe.cli.commands import app
from vibropipe.solve.rebuild import motion_of
from vibropipe.study import StudyError
from vibropipe.view.latest import Latest
from vibropipe.view.one_exciter import EXAMPLE, exciter_results, tree_of_file, tree_of_text
from vibropipe.view.page import Page
from vibropipe.view.results import Results
from vibropipe.view.words import source_of

THREE = vp.Exciter(l=0.5, nu=3.48, f=0.7, h=0.1, delta=0.1, R1=0.8, R2=0.8)
IN_SI = "m=2 kg, C=8 N/mm, l=500 mm, δ=100 mm, H=12.649110640673518 N s/m, F=5600 N, "
IN_SI += "omega=220.09452514419555 rad/s R1=0.8 R2=0.8"  # the same, with p = sqrt(4000) rad/s


def page_of(results):
    page = Page(results, background=lambda work: work())
    page.point.seek.active = True
    return page


@pytest.fixture(scope="module")
def three():
    return exciter_results(tree_of_text(EXAMPLE), "--exciter")


def test_the_text_of_an_exciter_is_a_tree_of_a_study():
    assert tree_of_text("l=0.5, ν=−2 R1 = 0.7") == {
        "title": "l=0.5, ν=−2 R1 = 0.7",
        "exciter": {"l": 0.5, "nu": -2.0, "R1": 0.7},
    }
    tree = tree_of_text("m=2 kg C=8 N/mm H=4 N s/m R1=0.7")
    assert tree["physical"] == {"m": "2 kg", "C": "8 N/mm", "H": "4 N s/m"}
    assert tree["exciter"] == {"R1": 0.7}


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("", "--exciter: must be names and values as in 'l=0.5 nu=3.48"),
        ("0.5", "--exciter: must be names and values as in"),
        ("l= nu=2", "--exciter: must be names and values as in"),
        ("l=1 l=2", "l: must be given once"),
        ("l=0.5 R1=3", "exciter.R1: must be a number from 0 to 1, got 3"),
        ("l=0.5 nu=two", "exciter.nu: must be a finite number > 0, got 'two'"),
        ("m=2 kg C=8 l=8 mm", "physical.C: must be a stiffness > 0 with its unit"),
    ],
)
def test_faults_of_the_text_are_messages(text, expected):
    with pytest.raises(StudyError, match=re.escape(expected)):
        exciter_results(tree_of_text(text), "--exciter")


def test_each_start_of_the_map_shows_the_motion_that_settles_from_it(three):
    page = page_of(three)
    xs, vs = page.plane.values
    assert (xs[0], xs[-1]) == pytest.approx((-0.4, 0.6))
    for i, j in [(3, 40), (20, 24), (44, 24), (30, 6)]:
        page.point_at(xs[i], vs[j])
        steady = vp.steady_state(THREE, x0=xs[i], v0=vs[j])
        shown = np.sort(page.point.panel.jumps.data["before"])
        np.testing.assert_allclose(shown, np.sort(steady["impact_velocity"].values), atol=1e-9)
        assert "3 motions coexist here: see the menu." in page.point.law.text
        assert len(page.point.coexisting.options) == 1 + 3


def test_distances_are_in_the_units_of_the_exciter():
    page = page_of(exciter_results(tree_of_text(IN_SI), "--exciter"))
    knocks = vp.attractors(THREE)["knock"].values
    menu = page.point.coexisting
    for number, name in enumerate(menu.options[1:]):
        menu.value = name
        assert float(page.point.shown.row["knock"]) == pytest.approx(
            1000 * knocks[number], rel=0.02
        )
        written = re.search(r"<i>rₖ.*?</tr>|least distance.*?</tr>", page.point.numbers.text)[0]
        assert "mm</td>" in written
    assert page.point.panel.curves.yaxis.axis_label == "displacement x (mm)"


def test_a_point_of_a_map_tells_what_coexists_there():
    """Found by a search of its own: the study has no basins."""
    data = vp.sweep(THREE, {"f": np.linspace(0.1, 0.7, 9), "nu": np.linspace(3.0, 3.48, 9)})
    page = page_of(Results("t", {"map": data}, "map"))
    page.point_at(*(3.48 if name == "nu" else 0.7 for name in page.plane.axes))
    assert "Coexists with 2 other motions: see the menu." in page.point.law.text
    found = vp.attractors(THREE)
    menu, sizes = page.point.coexisting, found["row_size"].values
    assert len(menu.options) == 1 + 3
    shown = page.point.panel.jumps.data["before"].copy()
    for number, name in enumerate(menu.options[1:]):
        menu.value = name
        first = int(sizes[:number].sum())
        own = found["impact_velocity"].values[first : first + sizes[number]]
        jumps = np.sort(page.point.panel.jumps.data["before"])
        np.testing.assert_allclose(jumps, np.sort(own), atol=1e-9)
    menu.value = menu.options[0]
    np.testing.assert_array_equal(page.point.panel.jumps.data["before"], shown)
    page.point_at(*(3.0 if name == "nu" else 0.1 for name in page.plane.axes))
    assert vp.attractors(replace(THREE, nu=3.0, f=0.1)).sizes["attractor_id"] == 1
    assert "No other attractor was found from scattered starts." in page.point.law.text
    assert not page.point.coexisting.visible
    page.point.seek.active = False
    page.point_at(*(3.48 if name == "nu" else 0.7 for name in page.plane.axes))
    assert "oexist" not in page.point.law.text


def test_a_slider_asks_anew_what_coexists_and_a_fault_is_told(three):
    page = page_of(three)
    page.point.what_if.spinners["R1"].value = 0.5
    n = vp.attractors(replace(THREE, R1=0.5)).sizes["attractor_id"]
    assert n == 2
    assert len(page.point.coexisting.options) == 1 + n
    assert f"Coexists with {n - 1} other motion: see the menu." in page.point.law.text
    page.point.what_if.spinners["l"].value = -1.0
    assert "l: must be a finite number &gt; 0, got -1.0" in page.point.law.text
    page.solve_map()
    assert "l: must be a finite number &gt; 0, got -1.0" in page.point.law.text
    page.point.what_if.spinners["l"].value = 0.3
    assert "What if l = 0.3, R₁ = 0.5" in page.point.law.text


def test_the_map_anew_has_its_starts_between_the_supports_that_are_there_then(three):
    page = page_of(three)
    page.point.what_if.spinners["l"].value = 0.3
    page.solve_map()
    assert page.scene.value == "starts, l = 0.3"
    xs, vs = page.plane.values
    assert (xs[0], xs[-1], xs.size) == pytest.approx((-0.2, 0.4, 48))
    page.point_at(xs[10], vs[30])
    steady = vp.steady_state(replace(THREE, l=0.3), x0=xs[10], v0=vs[30])
    assert int(page.point.stored["regime"]) == int(steady["regime"])


def test_a_start_without_an_attractor_shows_its_own_motion():
    page = page_of(exciter_results(tree_of_text("l=0.5"), "--exciter"))
    x, v = (values[30] for values in page.plane.values)
    page.point_at(x, v)
    assert "No attractor was found from this start." in page.point.law.text
    drawn = page.point.panel.sources["motion"].data
    energy = drawn["x"] ** 2 + drawn["v"] ** 2
    np.testing.assert_allclose(energy[np.isfinite(energy)], x**2 + v**2, rtol=1e-9)


def test_ties_hold_while_sliders_move():
    tree = {"title": "t", "exciter": {"l": 0.5, "nu": 2.0, "f": 0.5, "h": 0.1, "R1": 0.6}}
    page = page_of(exciter_results({**tree, "ties": {"R2": "R1"}}, "--exciter"))
    assert "R2" not in page.point.what_if.spinners
    page.point.what_if.spinners["R1"].value = 0.9
    assert float(page.point.shown.row["R2"]) == 0.9


def test_of_requests_that_come_while_one_is_worked_on_the_newest_is_answered():
    waiting, done, answers = deque(), [], []

    def request(value):
        def work():
            done.append(value)
            if value == 9:
                raise ValueError("nine")
            return value

        latest.request(work, answers.append)

    latest = Latest(waiting.append, lambda work: work())
    for value in range(5):
        request(value)
    while waiting:
        waiting.popleft()()
    assert done == [4]  # what is outdated before it begins is not begun
    assert answers == [4]
    request(9)
    waiting.popleft()()
    assert str(answers[-1]) == "nine"
    request(6)
    latest.drop()
    waiting.popleft()()
    assert len(answers) == 2


@needs_node
def test_a_slider_that_moves_sends_its_newest_value_ten_times_a_second():
    code = f"""
    let due = null
    globalThis.setTimeout = (work) => {{ due = work; return 1 }}
    const slide = (cb_obj, slider, field) => {{ {source_of("slide.js")} }}
    const slider = {{value: 0, start: 0, end: 1, setv(values) {{ Object.assign(this, values) }}}}, sent = []
    const field = {{set value(next) {{ sent.push(next); this.own = next; slide(field, slider, field) }},
                    get value() {{ return this.own }}}}
    for (const value of [0.1, 0.2, 0.30000000000000004]) {{ slider.value = value; slide(slider, slider, field) }}
    due(); due = null
    const once = [...sent]
    field.value = 1.5
    told([once, slider.value, slider.start, slider.end])
    """
    assert run(code, {}) == [[0.3], 1.5, 0, 1.5]


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        (["results", "--exciter", "l=0.5"], "must be left out beside RESULTS"),
        (["--exciter", "l=0.5", "--save", "x.html"], "needs the results of a study"),
        (["--scene", "map"], "needs the results of a study"),
    ],
)
def test_options_of_a_study_are_refused(arguments, expected):
    with pytest.raises(typer.BadParameter, match=expected):
        app(args=["view", *arguments], standalone_mode=False)


def test_a_file_with_an_exciter_alone_is_served(tmp_path, monkeypatch):
    served = []
    monkeypatch.setattr("vibropipe.view.server.serve", lambda *given: served.append(given[0]))
    file = tmp_path / "mine.yaml"
    text = "physical: {m: 2 kg, C: 8 N/mm, l: 8 mm, F: 120 N, omega: 55 rad/s, H: 40 N s/m}\n"
    file.write_text(text + "units: {velocity: mm/s}\nexciter: {R1: 0.7, R2: 0.7}\n", "utf-8")
    app(args=["view", str(file)], standalone_mode=False)
    app(args=["view"], standalone_mode=False)
    mine, example = served
    assert mine.title == "mine"
    assert mine.datasets["starts"]["v0"].attrs["units"] == "mm/s"
    assert float(mine.datasets["starts"]["l"]) == 8.0
    assert example.title == EXAMPLE
    file.write_text("title: A study\nexciter: {l: 0.5}\nscenes: {}\n", "utf-8")
    assert tree_of_file(file) is None
    file.write_text("exciter: {l: -1}\n", "utf-8")
    with pytest.raises(StudyError, match=r"mine\.yaml: exciter\.l: must be a finite number > 0"):
        app(args=["view", str(file)], standalone_mode=False)
    assert motion_of(page_of(mine).point.stored).is_orbit
