"""Scripts that move the crosshair and rebuild motions in the browser, against Python."""

import json
from dataclasses import replace

import numpy as np
import pytest
from scripts_in_node import call, needs_node, run

import vibropipe as vp
from vibropipe.solve.rebuild import motion_of
from vibropipe.store import load
from vibropipe.view.page import Page
from vibropipe.view.results import Results
from vibropipe.view.save import save_page, saved_series, stored_events, thinned
from vibropipe.view.saved_plan import plan_text
from vibropipe.view.words import source_of

pytestmark = needs_node
GRID = {
    "x_axis": {"data": {"at": [1.0, 2.0, 3.0, 4.0]}},
    "y_axis": {"data": {"at": [0.1, 0.2, 0.3]}},
    "crosshair": {"data": {"x": [2.0], "y": [0.2]}},
}
POINT = "[crosshair.data.x[0], crosshair.data.y[0]]"


@pytest.mark.parametrize(
    ("moves", "name", "active", "expected"),
    [
        ("both", "tap", None, [3.0, 0.1]),
        ("x", "tap", None, [3.0, 0.2]),
        ("y", "pan", None, [2.0, 0.1]),
        ("both", "pan", "a tool", [2.0, 0.2]),
        ("both", "tap", "a tool", [3.0, 0.1]),
    ],
)
def test_clicks_and_drags_move_the_crosshair_to_the_nearest_row(moves, name, active, expected):
    event = {"event_name": name, "x": 2.6, "y": -7.0}
    plot = {"toolbar": {"gestures": {"pan": {"active": active}}}}
    assert (
        call("drag.js", {**GRID, "moves": moves, "cb_obj": event, "plot": plot}, POINT) == expected
    )


@pytest.mark.parametrize(
    ("key", "shift", "tag", "expected"),
    [
        ("ArrowRight", False, "BODY", [3.0, 0.2]),
        ("ArrowLeft", True, "BODY", [1.0, 0.2]),
        ("ArrowUp", False, "BODY", [2.0, 0.3]),
        ("ArrowDown", False, "INPUT", [2.0, 0.2]),
        ("a", False, "BODY", [2.0, 0.2]),
    ],
)
def test_arrow_keys_move_the_crosshair(key, shift, tag, expected):
    press = f"""(() => {{
        pressed({{key: "{key}", shiftKey: {json.dumps(shift)}, preventDefault() {{}},
                  composedPath: () => [{{tagName: "{tag}"}}]}})
        return {POINT} }})()"""
    arguments = ", ".join(GRID)
    code = f"""
        let pressed = null
        const document = {{addEventListener: (name, f) => {{ pressed = f }}}}
        const {{{arguments}}} = given
        ;(() => {{ {source_of("keys.js")} }})()
        told({press})"""
    assert run(code, GRID) == expected


def rebuilt(cases):
    """Return the motions of the script: parameters, events, length and samples of each."""
    code = source_of("motion.js") + "told(given.map((each) => rebuild(...each)))"
    return run(code, cases)


def exciter_of(exciter):
    return {**exciter.parameters()._asdict(), "upper": exciter.upper, "lower": exciter.lower}


def largest_difference(found, motion):
    """Largest difference of displacement and of velocity at the samples that are at no impact."""
    time, x, v = (np.array(found[name], float) for name in ("time", "x", "v"))
    tau = motion["tau"].values
    events = np.concatenate(
        [motion[name].values for name in ("impact_tau", "rest_start", "rest_end")]
    )
    away = np.abs(tau[:, None] - events[None, :]).min(axis=1, initial=np.inf) > 1e-8
    at = np.clip(np.searchsorted(time, tau - 1e-9), 0, time.size - 1)
    same = away & (np.abs(time[at] - tau) < 1e-9)
    assert same.sum() > 0.9 * away.sum()
    errors = [x[at] - motion["displacement"].values, v[at] - motion["velocity"].values]
    return max(float(np.abs(each[same]).max()) for each in errors)


def test_the_script_rebuilds_the_motion_of_every_regime(results):
    plane = Page(replace(results, first="map")).plane
    rows, events = stored_events(plane)
    cases, motions, regimes = [], [], set()
    for number in range(0, rows["code"].size, 3):
        row = plane.row(number)
        if not rows["known"][number] or int(row["period_multiple"]) == 0:
            continue
        motion = motion_of(row)
        own = slice(rows["first"][number], rows["first"][number] + rows["count"][number])
        period = motion.exciter.period
        listed = [
            [t * period, v * period if side < 0 else v, int(side)]
            for t, v, side in zip(*(events[name][own] for name in events), strict=True)
        ]
        cases.append([exciter_of(motion.exciter), listed, motion.length, 256])
        motions.append(motion.plain)
        regimes.add(int(row["regime"]))
    assert {0, 3, 4} <= regimes
    worst = max(map(largest_difference, rebuilt(cases), motions))
    assert worst < 1e-12  # rounding over an orbit; measured 5e-14


@pytest.mark.parametrize("h", [0.0, 1.5, 2.0, 3.0])
def test_the_script_has_all_dampings_and_the_resonance(h):
    """One motion from an impact on, through others, that need not repeat."""
    exciter = vp.Exciter(l=0.5, nu=1.0, f=1.3, h=h, R1=0.6, R2=0.8)
    motion = vp.simulate(exciter, tau_end=12.0, x0=0.5, v0=-0.7)
    struck = zip(
        motion["impact_tau"].values, motion["impact_velocity"].values,
        motion["impact_support"].values.tolist(), strict=True,
    )  # fmt: skip
    listed = [[0.0, 0.7 / 0.6, 1], *([float(t), float(v), side] for t, v, side in struck)]
    (found,) = rebuilt([[exciter_of(exciter), listed, 0.0, 256]])
    last = float(motion["impact_tau"].values[-1])
    assert largest_difference(found, motion.sel(tau=slice(1e-6, last - 1e-6))) < 1e-12


def fake_page(page):
    """The models that the script of a saved page changes, as plain objects."""
    rows, events = stored_events(page.plane)
    drawn = saved_series(page.plane)
    fields = {f"f{n}": page.plane.field(one).T.ravel() for n, one in enumerate(drawn.values())}
    source = {"data": {}}
    crosshair = {"data": {name: list(values) for name, values in page.crosshair.data.items()}}
    data = {"image": {"data": {"image": [[0.0]]}}}
    names = ("regions", "words", "outlines", "motion", "jumps", "section", "mass", "law", "numbers",
             "bar", "mapper", "x_range", "drawing_range", "legend")  # fmt: skip
    return {
        "plan_text": plan_text(page, drawn, list(fields)),
        "fields": {"data": {name: values.tolist() for name, values in fields.items()}},
        "rows": {"data": {name: values.tolist() for name, values in rows.items()}},
        "events_source": {"data": {name: values.tolist() for name, values in events.items()}},
        "x_axis": {"data": {"at": page.plane.values[0].tolist()}},
        "y_axis": {"data": {"at": page.plane.values[1].tolist()}},
        "quantity": {"value": page.quantity.value}, "menus": [], "walls": [{} for _ in range(6)],
        "slices": [[dict(source), dict(source), {}, {}] for _ in range(2)],
        "spring": {"data": {"x": [0.0], "y": [0.0, 0.3, 0.0]}},
        "crosshair": crosshair, **data, **{name: {} for name in names},
    }  # fmt: skip


@pytest.mark.parametrize("has_units", [False, True])
def test_a_saved_page_shows_what_the_server_shows(results, with_units, has_units):
    """The whole script: motion, jumps, slices and text of a point that was not shown before."""
    page = Page(with_units if has_units else replace(results, first="map"))
    models = fake_page(page)
    nu, f = (float(values[6]) for values in page.plane.values)
    models["crosshair"]["data"] = {"x": [nu], "y": [f]}
    models["cb_obj"] = models["crosshair"]
    names = ", ".join(models)
    code = f"""
        for (const name of ["x_range", "drawing_range", "mapper"])
            given[name].setv = function (values) {{ Object.assign(this, values) }}
        const {{{names}}} = given
        ;(() => {{ {source_of("motion.js")} {source_of("saved.js")} }})()
        told({{motion, jumps, slices, law, numbers, walls, x_range}})"""
    found = run(code, models)
    page.point_at(nu, f)
    for name in ("time", "before", "after", "x"):
        expected = page.point.panel.jumps.data[name]
        np.testing.assert_allclose(found["jumps"]["data"][name], expected, rtol=0, atol=1e-9)
    shown = page.point.panel.sources["motion"].data
    assert len(found["motion"]["data"]["time"]) == pytest.approx(len(shown["time"]), abs=2)
    assert found["x_range"]["start"] == pytest.approx(page.point.panel.x_range.start)
    for (points, _lines, ruler, _range), expected in zip(found["slices"], page.slices, strict=True):
        np.testing.assert_allclose(
            points["data"]["value"], expected.points.data["value"], rtol=1e-6
        )
        assert points["data"]["colour"] == list(expected.points.data["colour"])
        assert ruler["axis_label"] == expected.ruler.axis_label
    assert "Two-sided" in found["law"]["text"]
    assert found["walls"][0]["bottom"] == pytest.approx(510.0 if has_units else 0.51)


def test_a_saved_page_loads_nothing_from_outside(results, tmp_path):
    path = tmp_path / "page.html"
    save_page(replace(results, first="map"), path)
    text = path.read_text(encoding="utf-8")
    assert "<script src" not in text
    assert "<link" not in text
    assert "MathJax.js" not in text
    assert path.stat().st_size < 6_000_000


def test_a_large_map_is_thinned_with_its_impacts(study, monkeypatch):
    monkeypatch.setattr("vibropipe.view.save.MAX_POINTS", 5)
    monkeypatch.setattr("vibropipe.view.save.MIN_POINTS", 2)
    whole = load(study / "map.nc")
    part = thinned(whole)
    assert part["regime"].shape == (5, 5)
    expected = vp.sweep(
        vp.Exciter(l=0.5, h=0.2, delta=0.01, R1=0.7, R2=0.7),
        {"nu": whole["nu"].values[::2], "f": whole["f"].values[::2]},
    )
    for name in ("row_size", "impact_phase", "impact_velocity", "displacement_mean"):
        np.testing.assert_array_equal(part[name], expected[name])


def test_what_the_script_cannot_rebuild_is_said(study):
    data = load(study / "map.nc").drop_dims("impact")
    page = Page(Results("no impacts", {"map": data}, "map"))
    rows, _events = stored_events(page.plane)
    assert not rows["known"].any()
