"""A scene of designs, from its keys to its pictures and tables, with and without units."""

import re
from itertools import combinations

import numpy as np
import pytest
import xarray as xr
from command_line import run
from drawing import draw, picture_of
from figures.figure_text import words

import vibropipe as vp
from vibropipe.figures.claims import percent
from vibropipe.jobs.verify import verify
from vibropipe.physics.exciter import Parameters
from vibropipe.report.parts import Answer, beside_pictures
from vibropipe.scenes.design import ranking
from vibropipe.scenes.design.data import spread_parts, wanted_text
from vibropipe.scenes.design.front import beating, swept
from vibropipe.scenes.design.nominal import nominal_numbers, nominal_text, shown_tolerance
from vibropipe.scenes.design.pictures import describe_sketch
from vibropipe.scenes.design.ranking import describe_designs, verdicts
from vibropipe.scenes.design.report import REPORT, answers, answers_at_ends, best_design, tables
from vibropipe.scenes.design.sorting_words import foretold_by, sorting_text
from vibropipe.scenes.design.workshop import sorting_cells, workshop_texts
from vibropipe.scenes.registry import kind_of
from vibropipe.solve.design.scattered_parts import MAX_CORNERS, box
from vibropipe.solve.design.sorting import NO_RULE
from vibropipe.solve.physical import in_units
from vibropipe.solve.rows.points import clipped, solve_points
from vibropipe.study import StudyError, study_of_text
from vibropipe.words.designs import DesignResult
from vibropipe.words.vocabulary import describe

STUDY = """
title: Wanted
exciter: {l: 0.5, nu: 1, f: -1, h: 0.2, R2: 0.7}
scenes:
  shifted:
    kind: design
    vary: {delta: [-0.3, 0.3], R1: [0.4, 0.9]}
    target: {displacement_mean: -0.1}
    subject_to: {impact_velocity_max_1: "< 0.8"}
    tolerance: {delta: 0.0002, R1: 0.002}
    allow: {displacement_mean: 0.005}
    samples: 32
    designs: 2
"""
FAILING = """
title: Scattered too far
exciter: {l: 0.5, nu: 1, f: -1, h: 0.2, R1: 0.7, R2: 0.7}
scenes:
  loose:
    kind: design
    vary: {delta: [-0.3, 0.3]}
    subject_to: {impact_velocity_max_1: "< 0.95", displacement_mean: "> -0.1"}
    tolerance: {delta: 0.02, R1: 0.03}
    samples: 32
    designs: 1
"""
PHYSICAL = """
title: Wanted
physical: {m: 2 kg, C: 8 N/mm, H: 25 N s/m, F: -8 kN, omega: 10 Hz, l: 500 mm}
exciter: {R2: 0.7}
scenes:
  shifted:
    kind: design
    vary: {delta: [-300 mm, 300 mm], R1: [0.4, 0.9]}
    target: {displacement_mean: -100 mm}
    subject_to: {impact_velocity_max_1: "< 50 m/s"}
    tolerance: {F: 8 N, delta: 0.2 mm}
    allow: {displacement_mean: 5 mm}
    samples: 32
    designs: 2
"""
# The weaker forces do not strike a support from rest.
TWO_MOTIONS = """
title: Struck from a start
physical: {m: 2 kg, C: 8 N/mm, H: 25.3 N s/m, omega: 120.2 rad/s, l: 5 mm}
exciter: {R2: 0.7}
scenes:
  struck:
    kind: design
    vary: {F: [36 N, 76 N], R1: [0.5, 0.9]}
    target: {impact_velocity_max_1: 0.474 m/s}
    start: {x0: 1 mm, v0: 0.95 m/s}
    samples: 64
"""


@pytest.fixture(scope="module")
def dataset():
    scene = study_of_text(STUDY, "wanted").scenes["shifted"]
    return kind_of(scene).solve(scene)


def test_from_yaml_to_report(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    path = tmp_path / "wanted.yaml"
    path.write_text(STUDY)
    assert run("plan", path) == 0
    assert "32 samples over delta, R1" in capsys.readouterr().out
    assert run("solve", path, "--scene", "shifted", "--output", "results/wanted/shifted.nc") == 0
    assert run("figure", path) == 0
    assert run("report", path, "--output", "results/wanted/report.pdf") == 0
    assert all(verdict.good and verdict.checked for verdict in verify("results/wanted"))
    table = vp.table("results/wanted/shifted.nc")
    assert (table.design_result == "met").all()
    assert {"displacement_mean_std_first_order", "impact_velocity_max_contribution_1_R1"} <= {
        *table
    }


@pytest.mark.slow
def test_a_scene_is_the_call(dataset):
    scene = study_of_text(STUDY, "wanted").scenes["shifted"]
    called = vp.design(vp.Exciter(**scene.resolved_exciter()), **scene.arguments())
    assert dataset.identical(called)


def test_needed_tolerances_hold_at_random_corners(dataset):
    best, generator = dataset.isel(design=0), np.random.default_rng(3)
    names = ["nu", "f", "h", "l", "delta", "R1", "R2"]
    for _ in range(20):
        signs = dict(zip(names, generator.choice((-1, 1), len(names)), strict=True))
        off = {name: float(best[name] + signs[name] * best[f"{name}_tolerance"]) for name in names}
        orbit = vp.steady_state(vp.Exciter(**off))
        assert np.array_equal(orbit.impacts_per_orbit, best.impacts_per_orbit)
        assert abs(float(orbit.displacement_mean) + 0.1) <= 0.005
        assert float(orbit.impact_velocity_max.sel(support=1)) <= 0.8


def test_all_tolerances_at_once_are_told_only_where_they_were_tried(dataset):
    assert workshop_texts(dataset)[0].startswith("All parameters may be off at once")
    names = [f"p{number}" for number in range(MAX_CORNERS)]
    many = dataset.assign_coords(dict.fromkeys(names, 1.0))
    many = many.assign({f"{name}_tolerance": dataset.R1_tolerance for name in names})
    assert workshop_texts(many)[0].startswith("At each end of each tolerance alone")
    assert "at once" not in describe_sketch(many)
    assert len(box(MAX_CORNERS, 1.0)) == 2 * MAX_CORNERS + 2**MAX_CORNERS
    assert len(box(MAX_CORNERS + 1, 1.0)) == 2 * (MAX_CORNERS + 1)


@pytest.mark.slow
def test_the_sorting_rule_in_the_report_sorts_random_parts():
    scene = study_of_text(FAILING, "wanted").scenes["loose"]
    dataset = kind_of(scene).solve(scene)
    (best,) = dataset["foretold_by"].values
    assert best == "impact_velocity_max_1"
    text = answers({"loose": dataset})["loose"][1].rest
    rule = re.search(
        r"Of finished exciters, those whose largest impact velocity at support 1 is below ([\d.]+) count as good; "
        r"([\d.]+) to ([\d.]+) % of all are then sorted wrongly\.",
        text,
    )
    cut, low, high = map(float, rule.groups())
    generator, n = np.random.default_rng(8), 1500
    exciter = vp.Exciter(**scene.resolved_exciter())
    rows = np.tile(np.array(exciter.numbers()), (n, 1))
    for name, sigma in (("delta", 0.02), ("R1", 0.03)):
        column = Parameters._fields.index(name)
        rows[:, column] = float(dataset[name].values.ravel()[0])
        rows[1:, column] += sigma * generator.standard_normal(n - 1)
    parts = solve_points(clipped(rows), (None, 0.0), ("impacts", "stability", "harmonics"), 1)
    speed = parts.variables["impact_velocity_max"][1][:, 0]
    mean = parts.variables["displacement_mean"][1]
    good = (speed <= 0.95) & (mean >= -0.1) & parts.has_law(parts.laws[0])
    told = [(speed, cut, low, high)]
    # Another quantity: not the one of the bound that most parts break.
    fields = ("threshold", "area", "wrong_low", "wrong_high")
    limit, area, *ends = (float(dataset[f"displacement_mean_sort_{f}"].squeeze()) for f in fields)
    assert area > 0.5
    told.append((-mean, -limit, 100 * ends[0], 100 * ends[1]))
    for values, cut, low, high in told:
        wrong = 100 * ((values < cut) != good).mean()
        room = 4 * np.sqrt(wrong * (100 - wrong) / n)
        assert low - room < wrong < high + room
        assert high < 100 * (1 - good.mean())  # to take all parts is worse
    nothing = dataset.assign(foretold_by=("design", ["no single quantity"]))
    rest = answers({"loose": nothing})["loose"][1].rest
    assert "No single measured quantity foretells which exciters do." in rest


def test_the_sorting_rule_of_a_study_with_units_is_told_in_them():
    rule = {"threshold": -1.01, "area": 0.9, "wrong_low": 0.012, "wrong_high": 0.0231}
    plain = xr.Dataset({f"f_sort_{name}": ("design", [each, 0.5]) for name, each in rule.items()})
    plain = describe(plain.assign_coords(f=("design", [-1.0, -1.1])))
    found = vp.to_physical(plain.assign_attrs(foretold_by="f; nu"), "2 kg", "8 N/mm")
    assert sorting_text(in_units(found, "kN")) == (
        "Of finished exciters of design 1, those whose amplitude of excitation is above −8.08 kN count as good; "
        "1.2 to 2.4 % of all are then sorted wrongly."
    )


@pytest.mark.slow
def test_the_table_has_the_rule_and_the_nearest_limit_of_each_design():
    scene = study_of_text(FAILING.replace("designs: 1", "designs: 3"), "wanted").scenes["loose"]
    found = kind_of(scene).solve(scene)
    assert found.sizes["design"] > 1
    told = {each.title: each for each in tables({"loose": found})}
    (table,) = (each for title, each in told.items() if "what they are told by" in title)
    designs = told["The designs in numbers"]
    for row, cells in enumerate(table.rows):
        design = found.isel(design=row)
        assert cells[1] == percent(float(design["yield"]))
        best = str(design.foretold_by.values)
        if best == "no single quantity":
            assert cells[2:5] == [best, "–", "–"]
            continue
        stem, _, index = best.rpartition("_")
        rule = {
            name: float(design[f"{stem}_sort_{name}"][int(index) - 1])
            for name in ("threshold", "area", "wrong_low", "wrong_high")
        }
        side, cut = cells[3].replace("−", "-").split()[:2]
        assert side == ("above" if rule["area"] > 0.5 else "below")
        assert float(cut) == pytest.approx(rule["threshold"], rel=1e-4)
        low, high = (float(each) / 100 for each in cells[4].removesuffix(" %").split(" to "))
        assert low <= rule["wrong_low"] <= rule["wrong_high"] <= high
        std = design.sel(estimate="first_order")
        away = {
            "largest impact velocity at support 1": (0.95 - std.impact_velocity_max[0])
            / std.impact_velocity_max_std[0],
            "mean displacement": (std.displacement_mean + 0.1) / std.displacement_mean_std,
        }  # fmt: skip
        nearest = min(away, key=lambda name: float(away[name]))
        own = dict(zip(designs.head, designs.rows[row], strict=True))
        if "nearest limit" in own:
            assert own["nearest limit"] == nearest
        else:
            assert f"nearest limit: {nearest}" in designs.note
        assert float(own["away"]) == pytest.approx(float(away[nearest]), rel=0.1)


def test_files_of_earlier_versions_name_what_foretells_in_an_attribute():
    earlier = xr.Dataset({"yield": ("design", [0.9, 1.0])}, attrs={"foretold_by": "f; nu"})
    assert foretold_by(earlier) == ["f", "nu"]
    assert foretold_by(earlier.drop_attrs()) == [NO_RULE] * 2


def test_without_failing_parts_the_report_has_no_rule(dataset):
    assert dataset["foretold_by"].values.tolist() == [NO_RULE] * 2
    assert not [name for name in dataset if "_sort_" in name]
    assert "finished" not in answers({"shifted": dataset})["shifted"][1].rest


def test_a_caption_names_only_what_is_drawn(dataset):
    picture = picture_of("design", dataset, "designs")
    told = picture.describe(dataset, None, {})
    assert "grey: outside the goal" in told  # beyond the bound of the velocity
    assert "red" not in told
    assert "yield" not in words(picture.draw(dataset, None, {}))  # that of both is in the title
    title = "All 4,096 sampled exciters of each design keep all that is wanted"
    assert picture.title(dataset, None, {}) == title
    of_law = dataset.drop_vars(
        [name for name in dataset if str(name).endswith(("_target", "_upper"))]
    )
    assert "grey" not in picture.describe(of_law, None, {})


@pytest.mark.parametrize("name", ["sketch", "designs", "tornado", "sensitivities"])
def test_every_picture_is_drawn(dataset, name):
    picture = picture_of("design", dataset, name)
    shown = words(picture.draw(dataset, None, {}))
    assert ("may be off by" if name == "sketch" else "support 1") in shown.replace("\n", " ")
    texts = picture.describe(dataset, None, {}) + picture.title(dataset, None, {})
    assert "_" not in texts
    assert 0 < len(picture.title(dataset, None, {})) <= 85


def test_the_sketch_is_to_scale(dataset):
    axes = picture_of("design", dataset, "sketch").draw(dataset, None, {}).axes[0]
    upright = {line.get_xdata()[0] for line in axes.lines if np.ptp(line.get_xdata()) == 0}
    half, offset = float(dataset.l), float(dataset.delta[0])
    scale = 3.2 / half
    title = picture_of("design", dataset, "sketch").title(dataset, None, {})
    # its numbers stand in the answer and beside the drawing
    assert title == "Design 1, drawn to scale"
    for place in (-half, half, -offset):
        assert any(abs(x - (6.4 + scale * place)) < 1e-9 for x in upright)


def test_many_parameters_below_a_sketch_leave_room_for_the_table(dataset):
    further = {"load": 0.1234, "friction": 0.1234, "f2": 0.2345, "phi2": 1.234, "mass_ratio": 2.345}
    many = dataset.assign_coords(further).assign_coords(housing_friction_1=0.123)
    axes = picture_of("design", describe(many), "sketch").draw(many, None, {}).axes[0]
    *others, line = sorted(axes.texts, key=lambda text: text.get_text().count("="))
    box = line.get_window_extent()
    assert line.get_text().count("=") >= 8
    assert not any(box.overlaps(text.get_window_extent()) for text in others)


def test_a_quantity_that_design_1_lacks_is_told_and_not_drawn(dataset):
    """The velocity at a support that is not struck."""
    assert [each.variable for each in spread_parts(dataset)].count("impact_velocity_max") == 1
    lacking = dataset.copy(deep=True)
    lacking["impact_velocity_max"].loc[{"design": lacking.design[0], "support": 1}] = np.nan
    assert "impact_velocity_max" not in [each.variable for each in spread_parts(lacking)]
    assert "largest impact velocity at support 1 = no value (" in describe_sketch(lacking)


def test_a_verdict_names_only_as_many_parameters_as_have_room(dataset, monkeypatch):
    names = ["f", "l", "delta", "R1", "R2"]
    monkeypatch.setattr(ranking, "held_too_wide", lambda *_: names)
    assert ranking.verdict(dataset, 0) == "5 are tight"
    assert "Tight: a tolerance below" in describe_designs(dataset)
    names.pop()
    assert ranking.verdict(dataset, 0).startswith("tight: $f$, ")


def test_the_force_of_a_sketch_without_a_table_points_away_from_the_mass(dataset):
    bare = dataset.drop_vars([n for n in dataset if str(n).endswith(("_tolerance", "_std"))])
    axes = picture_of("design", bare, "sketch").draw(bare, None, {}).axes[0]
    (mass,) = [
        patch for patch in axes.patches if patch.get_zorder() == 1 and patch.get_width() == 1.1
    ]
    arrows = [
        text for text in axes.texts if getattr(text, "arrow_patch", None) and text.xy[1] == 1.27
    ]
    (force,) = arrows
    assert force.xyann[0] == pytest.approx(mass.get_x() + 1.1)
    assert force.xy[0] > force.xyann[0] + 0.3


def test_what_all_designs_meet_is_not_drawn_by_its_rounding(dataset):
    met = dataset.isel(design=[0, 0]).drop_vars([n for n in dataset if "_quantile" in str(n)])
    met.attrs.pop("allow")
    for size in (-0.1, 0.0):
        close = met.assign(displacement_mean=("design", [size - 1e-12, size + 1e-12]))
        close["displacement_mean"].attrs = met["displacement_mean"].attrs
        close["displacement_mean_target"] = size
        figure = picture_of("design", close, "designs").draw(close, None, {})
        (ax,) = [ax for ax in figure.axes if any("mean" in t.get_text() for t in ax.texts)]
        assert np.ptp(ax.get_xlim()) > 0.01


def test_what_symmetry_lets_vanish_is_no_number():
    """The mean displacement of an exciter with equal supports is 0, whatever its force and its length."""
    exciter = "exciter: {l: 0.5, nu: 1, f: -1, h: 0.2, R1: 0.7}"
    text = (
        f"title: Even\n{exciter}\nscenes:\n  even: {{kind: design, vary: {{R2: [0.4, 0.9]}}, samples: 16, designs: 1, "
        "target: {displacement_mean: 0}, allow: {displacement_mean: 0.01}, tolerance: {f: 0.002, l: 0.0002}}\n"
    )
    scene = study_of_text(text, "even").scenes["even"]
    even = kind_of(scene).solve(scene)
    assert 0.0 < float(abs(even["displacement_mean_deviation"]).max()) < 1e-12
    told = " ".join(f"{each.lead} {each.rest}" for each in answers({"even": even})["even"])
    assert "mean displacement = 0." in told
    assert "standard deviations away" not in told
    assert "comes from" not in told
    tornado = picture_of("design", even, "tornado")
    assert tornado.title(even, None, {}) == "No parameter alone moves the mean displacement"
    (ax,) = tornado.draw(even, None, {}).axes
    assert ax.get_xlim()[1] == pytest.approx(0.025)


def test_the_side_has_goals_and_ranges(dataset):
    rows = {row.symbol: row.value for row in REPORT.side({"shifted": dataset}).rows}
    assert rows["mean displacement"] == "−0.1 ± 0.005"
    assert rows["largest impact velocity at support 1"] == "< 0.8"
    assert (rows["δ"], rows["R₁"]) == ("−0.3 … 0.3", "0.4 … 0.9")


def test_pictures_of_the_spread_say_what_to_add(dataset):
    bare = dataset.drop_vars([name for name in dataset if "law_change" in name])
    for name in ("tornado", "sensitivities"):
        picture = picture_of("design", bare, name)
        assert "add tolerance" in words(picture.draw(bare, None, {}))
        assert "add tolerance" in picture.describe(bare, None, {})


def test_goals_without_a_spread_show_the_usual_quantities(dataset):
    of_law = dataset.drop_vars(
        [name for name in dataset if str(name).endswith(("_target", "_upper"))]
    )
    of_law["impacts_per_period_target"] = ("support", [3.0, np.nan])
    for name in ("sketch", "designs", "tornado", "sensitivities"):
        picture = picture_of("design", of_law, name)
        assert picture.draw(of_law, None, {}).axes
        assert picture.describe(of_law, None, {})


def test_the_front_is_drawn():
    text = (
        STUDY[: STUDY.index("    target")]
        + "    minimise: [impact_velocity_max_1, -displacement_amplitude_1]\n    samples: 16\n"
    )
    scene = study_of_text(text, "wanted").scenes["shifted"]
    front = kind_of(scene).solve(scene)
    assert len(draw("design", front).axes) == 1
    near = front.copy(deep=True)  # designs that are almost one
    near["displacement_amplitude"][1], near["impact_velocity_max"][1] = (
        front["displacement_amplitude"][0] * 1.001,
        front["impact_velocity_max"][0] * 1.001,
    )
    (ax,) = draw("design", near).axes
    boxes = [text.get_window_extent() for text in ax.texts if text.get_text() in ("1", "2")]
    assert not boxes[0].overlaps(boxes[1])
    crowd = xr.DataArray(np.linspace(1.0, 1.01, front.sizes["design"]), dims="design")
    crowded = {
        name: (front[name][0] * crowd).transpose(*front[name].dims)
        for name in ("displacement_amplitude", "impact_velocity_max")
    }
    near = front.assign(crowded)
    near["impact_velocity_max"][-1] *= 2
    (ax,) = draw("design", near).axes
    written = {text.get_text(): text.get_window_extent() for text in ax.texts}
    assert {"1", str(crowd.size)} <= set(written)
    assert len(written) < crowd.size
    assert not any(a.overlaps(b) for a, b in combinations(written.values(), 2))
    cloud, picture = swept(front), picture_of("design", front)
    bounded = front.assign_attrs(subject_to="displacement_mean > -0.5")
    for data, has_bounds in ((front, False), (bounded, True)):
        told = picture.describe(data, None, {})
        assert (" that keep to the bounds" in told) == has_bounds
    assert 1000 < len(cloud) <= 4096
    assert beating(front) == 0
    title = picture.title(front, None, {})
    assert title == f"None of {len(cloud):,} swept motions with impacts beats a design of the front"
    worse = front.copy()
    worse["impact_velocity_max"] = front.impact_velocity_max + 0.05
    assert beating(worse) > 1
    assert "swept motions with impacts beat a design" in picture.title(worse, None, {})
    first, at_end = answers({"front": front})["front"]
    assert re.fullmatch(
        r"Along the front the largest impact velocity at support 1 goes from ([\d.]{5}|[\d.]{4}) to "
        r"([\d.]{5}|[\d.]{4}) and the amplitude of harmonic 1 goes from [\d.]{5} to [\d.]{5}\.",
        first.lead,
    )
    assert at_end.lead == "Most designs of the front lie at an end of a range."
    assert (
        at_end.rest
        == f"{np.isclose(front['R1'], 0.4, rtol=0, atol=1e-7).sum()} of them at R₁ = 0.4."
    )
    point = {"delta": 0.3, "R1": 0.4}  # a corner of the grid
    corner = vp.steady_state(vp.Exciter(l=0.5, nu=1, f=-1, h=0.2, R2=0.7, **point))
    pair = [float(corner.impact_velocity_max[0]), float(corner.displacement_amplitude[0])]
    assert np.abs(cloud - pair).max(axis=1).min() < 1e-9


def test_what_is_reached_from_rest_is_said(dataset):
    # Both settle, so the note of the table says it, not a column.
    designs = tables({"shifted": dataset})[0]
    assert "from rest" not in designs.head
    assert designs.note.startswith("Of all designs, mean displacement: −0.100; ")
    assert "; from rest: yes. " in designs.note
    first = answers({"shifted": dataset})["shifted"][0]
    assert first.rest.endswith(" The mass settles on this motion from rest.")
    scene = study_of_text(TWO_MOTIONS, "wanted").scenes["struck"]
    found = kind_of(scene).solve(scene)
    given = {name: float(found[name]) for name in ("m", "C", "H", "l", "omega", "R2")}
    made = [
        vp.Exciter.from_physical(**given, F=float(found.F[n]), R1=float(found.R1[n]))
        for n in range(found.sizes["design"])
    ]
    # Once a period on each support, or on none.
    struck = [bool(vp.steady_state(each).impacts_per_orbit.any()) for each in made]
    texts = ["yes" if each else "no" for each in struck]
    shown = in_units(found, "mm")
    (table, *_) = (table.as_data() for table in tables({"struck": shown}))
    assert [row[-1] for row in table["rows"]] == texts
    assert (
        "From rest: whether the mass settles on this motion if it starts at rest." in table["note"]
    )
    assert texts[0] == "no"
    second = answers({"struck": shown})["struck"][1]
    assert second.lead == "From rest, design 1 settles on another motion."
    assert second.rest == (
        "Start it at the displacement 1 mm and the velocity 0.95 m/s, at the zero phase of the force."
    )
    older, unknown = found.drop_vars("from_rest"), found.assign(from_rest=-1 * found.from_rest**0)
    assert tables({"struck": older})[0].as_data()["head"] == table["head"][:-1]
    for each in (older, unknown):
        told = answers({"struck": each})["struck"]
        assert not any("From rest" in f"{answer.lead}{answer.rest}" for answer in told)
    assert "from rest: unknown" in tables({"struck": unknown})[0].note


@pytest.mark.parametrize(
    "minimise", ["power_input", "-power_input", "power_input; impact_velocity_max_1"]
)
def test_the_design_that_was_found_and_its_best_value_are_told(minimise):
    variables = {
        "nu": [0.7, 0.81],
        "power_input": [0.2, 0.3],
        "law_margin": [0.001, 0.3],
        "design_result": [DesignResult.CONFLICTING, DesignResult.MET],
    }
    columns = {name: ("design", values) for name, values in variables.items()}
    dataset = describe(xr.Dataset(columns, attrs={"vary": "nu", "minimise": minimise}))
    assert best_design(dataset) == Answer(
        "Design 2 has ν = 0.8100.", "It reaches power of the force = 0.300."
    )


def test_a_design_reaches_a_yield(dataset):
    sought = dataset.assign_attrs(minimise="-yield")
    assert best_design(sought).rest.startswith("It reaches yield = ")


@pytest.mark.parametrize(
    ("R1", "lead"),
    [
        ([0.4, 0.4, 0.9], "Each design of the front lies at an end of a range."),
        ([0.4, 0.4, 0.5], "Most designs of the front lie at an end of a range."),
        ([0.4, 0.5, 0.5], ""),
    ],
)
def test_designs_at_the_ends_of_their_ranges_are_said_to_be(R1, lead):
    columns = {"R1": ("design", R1), "delta": ("design", [0.0, 0.1, 0.2])}
    ends = {"R1_lower": 0.4, "R1_upper": 0.9, "delta_lower": -0.3, "delta_upper": 0.3}
    front = describe(xr.Dataset(ends, columns, {"vary": "R1 delta"}))
    found = answers_at_ends(front)
    assert [answer.lead for answer in found] == ([lead] if lead else [])
    assert [answer.rest for answer in found] == (["2 of them at R₁ = 0.4."] if lead else [])


def test_the_table_of_designs_does_without_the_columns_of_their_picture(dataset):
    table = tables({"shifted": dataset})[0]
    alone, beside = (beside_pictures(table, drawn) for drawn in ((), ("sketch", "designs")))
    shown = ["δ", "R₁", "impacts in a period, at 1 + 2"]
    assert [head for head in alone.head if head in shown] == shown
    assert beside.head == [head for head in alone.head if head not in shown]
    assert {len(row) for row in beside.as_data()["rows"]} == {len(beside.head)}


def test_the_table_tells_the_workshop_how_tight(dataset):
    designs, tight, *_ = (table.as_data() for table in tables({"shifted": dataset}))
    assert len(designs["rows"]) == dataset.sizes["design"]
    # The first line has the deviations; tolerances of the other design are those of the first times one number.
    assert tight["head"][1:] == ["± ν", "± f", "± h", "± l", "± δ", "± R₁", "± R₂"]
    assert [row[0] for row in tight["rows"]] == ["given deviation", "design 1"]
    assert all(float(cell.rstrip("*")) > 0 for cell in tight["rows"][1][1:])
    times = re.search(r"those of design 1 times ([\d.]+) \(design 2\)\.", tight["note"])
    tolerances = ["nu", "f", "h", "l", "delta", "R1", "R2"]
    for name, cell in zip(tolerances, tight["rows"][1][1:], strict=True):
        exact = float(dataset[f"{name}_tolerance"][1])
        assert 0.8 * exact < float(times[1]) * float(cell.rstrip("*")) <= exact
    best, made, limit = answers({"shifted": dataset})["shifted"]
    offset, restitution = (nominal_text(dataset, name) for name in ("delta", "R1"))
    assert best.lead == f"Design 1 has δ = {offset} and R₁ = {restitution}."
    assert best.rest.startswith(
        "It reaches mean displacement = −0.100 and largest impact velocity at support 1 = 0."
    )
    assert made == Answer(
        "All 2 designs can be made.",
        "Of each, all 4,096 exciters sampled with the given deviations keep the law of motion, the bounds and the "
        "targets.",
    )
    away = float(dataset["reliability_index"][0])
    best_std = dataset.isel(design=0).sel(estimate="first_order", support=1)
    std = [float(best_std[f"{name}_std"]) for name in ("displacement_mean", "impact_velocity_max")]
    speed = float(dataset["impact_velocity_max"].isel(design=0).sel(support=1))
    rooms = 0.005 / std[0], (0.8 - speed) / std[1]
    assert away == pytest.approx(min(rooms), rel=1e-6)
    goal = "mean displacement" if rooms[0] < rooms[1] else "largest impact velocity at support 1"
    told = re.fullmatch(
        rf"The nearest limit of design 1, of the {goal}, is (\S+) standard deviations away, to first order\.",
        limit.lead,
    )
    assert 0.9 * away < float(told[1]) <= away
    assert verdicts(dataset)[0] == "can be made"


def test_a_parameter_has_as_many_digits_wherever_it_is_told():
    values = {"R1_tolerance": ("design", [0.015, 0.0056])}
    designs = xr.Dataset(values, {"R1": ("design", [0.676054, 0.587321])})
    assert nominal_numbers(designs, "R1") == ["0.67605", "0.58732"]
    assert [nominal_text(designs, "R1", row) for row in (0, 1)] == nominal_numbers(designs, "R1")


def test_a_value_near_zero_has_no_more_decimals_than_the_others_need(dataset):
    near = dataset.copy(deep=True)
    for name, values in (("delta", [0.20412, -0.0024078]), ("delta_tolerance", [0.0094, 0.0094])):
        near[name].values[:] = values
    assert nominal_numbers(near, "delta") == ["0.20412", "−0.00241"]
    near["delta_tolerance"].values[:] = np.nan
    assert nominal_numbers(near, "delta") == ["0.2041", "−0.002408"]


def test_yields_alone_are_no_table_beside_the_picture_that_has_them(dataset):
    some = dataset.assign(**{"yield": dataset["yield"] * [0.999, 0.998]})
    table = next(t for t in tables({"s": some}) if t.title.startswith("How many sampled"))
    assert table.head == ["design", "yield"]
    assert beside_pictures(table, ("sketch",)) is table
    assert beside_pictures(table, ("designs",)) is None


def test_margins_are_told_as_in_captions(dataset):
    close = dataset.assign(law_margin=("design", [0.0257, 3.9e-7]))
    table = next(t for t in tables({"s": close}) if "margin (%)" in t.head)
    assert [row[table.head.index("margin (%)")] for row in table.rows] == ["2.5", "< 0.01"]


def test_design_1_is_shown_in_units(dataset):
    table = tables({"shifted": dataset})[2].as_data()
    assert table["title"] == "Design 1 in units, for an exciter of l = 8 mm at 9 Hz"
    best = dataset.isel(design=0)  # l = 0.5, nu = 1
    p = 2 * np.pi * 9
    scaled = [16 * float(best.delta), 0.016 * p * float(best.impact_velocity_max[0])]
    found = [float(table["rows"][0][k].replace("−", "-")) for k in (2, 3)]
    assert found == pytest.approx(scaled, rel=1e-3)


def test_a_tolerance_below_the_given_deviation_is_marked(dataset):
    tight = dataset.copy()
    tight["R1_std"] = ((), 10 * float(dataset.R1_tolerance.max()))
    tight["delta_std"] = ((), 0.1 * float(dataset.delta_tolerance.min()))
    table = tables({"shifted": tight})[1].as_data()
    (marked,) = ([cell.endswith("*") for cell in row] for row in table["rows"][1:])
    assert marked[table["head"].index("± R₁")]
    assert sum(marked) == 1
    assert "which cannot be held: R₁ of designs 1 and 2." in table["note"]
    assert verdicts(tight) == ["tight: $R_1$"] * 2


def test_a_tolerance_as_wide_as_its_deviation_reads_the_same(dataset):
    # Where the nominal value is shown it is rounded, by some 1e-5 of this tolerance.
    same = dataset.assign(R1=("design", [0.7 + 1e-7] * 2), R1_tolerance=("design", [0.01, 0.0099]))
    assert [shown_tolerance(same, "R1", row) for row in (0, 1)] == ["0.01", "0.0099"]
    rounded = same.assign(R1=("design", [0.700004, 0.7]))
    assert shown_tolerance(rounded.assign(R1_tolerance=same.R1_tolerance / 1e4), "R1", 0) == "0"


def test_a_design_on_its_bound_has_no_tolerance(dataset):
    bound = dataset.copy()
    names = [name for name in dataset if str(name).endswith("_tolerance")]
    for name in names:
        bound[name] = dataset[name].where(dataset.design != 1)
    bound["tolerance_result"] = ("design", [0, 1])
    yields = tables({"shifted": bound})[1].as_data()
    reason = (
        "Design 2 has no tolerance: on the bound of the largest impact velocity at support 1 < 0.8."
    )
    assert reason in yields["note"]
    assert yields["rows"][2][1:] == ["–"] * len(names)
    assert verdicts(bound) == ["can be made", "no tolerance"]
    missed = bound.assign(tolerance_result=("design", [3, 3]))
    reason = "Designs 1 and 2 have no tolerance: not all that is wanted holds."
    assert reason in tables({"shifted": missed})[1].as_data()["note"]
    bound["yield"], bound["yield_low"], bound["yield_high"] = (
        ("design", [1.0, share]) for share in (0.614, 0.6, 0.63)
    )
    bound["yield_low"] = ("design", [0.999, 0.6])
    _, first, lost = answers({"shifted": bound})["shifted"]
    assert first.lead == "1 of 2 designs can be made."
    assert lost.lead == "Design 2 loses 38.6 % of its sampled exciters."
    bound["yield"] = bound["yield_low"] = bound["yield_high"] = ("design", [0.6, 0.5])
    _, first, lost = answers({"shifted": bound})["shifted"]
    assert first.lead == "None of 2 designs can be made."
    assert first.rest.startswith("Of each, fewer than 95 % of the exciters sampled with the given")
    assert lost.lead == "2 designs lose up to 50 % of their sampled exciters."
    picture = picture_of("design", bound, "designs")
    title = "Designs 1 and 2 lose 40 to 50 % of their sampled exciters"
    assert picture.title(bound, None, {}) == title
    assert "red: below 95 %" in picture.describe(bound, None, {})
    assert verdicts(bound) == ["too many fail"] * 2


def test_what_was_not_found_may_be_there(dataset):
    missed = dataset.assign(design_result=("design", [1, 1]), design_miss=("design", [0.3, 0.24]))
    (answer,) = answers({"shifted": missed})["shifted"]
    assert answer.lead == "No design was found that keeps all that is wanted."
    assert answer.rest.startswith(
        "Of those found, design 2 misses least, by 0.24 times what is wanted, or l"
    )


def test_yields_are_never_rounded_to_all():
    assert [percent(4095 / 4096), percent(1.0), percent(0.6149)] == ["99.9 %", "100 %", "61.4 %"]
    assert percent(1 / 4096, up=True) == "0.1 %"


def test_a_design_without_a_sorting_rule_says_why():
    shares = {1.0: "none fails", 0.9998: "too few fail", 0.0002: "too few are good"}
    assert {share: sorting_cells(None, share)[0] for share in shares} == shares


def test_goals_are_written_in_the_units_shown():
    displacement = xr.DataArray([-50.0], dims="design", attrs={"units": "mm"})
    shown = xr.Dataset({"displacement_mean": displacement})
    shown.attrs |= {
        "shown_units": "length: mm",
        "target": "displacement_mean = -0.05 m; displacement at 12 phases",
    }
    shown.attrs |= {"subject_to": "impact_velocity_max_1 > 0.5 m s-1, < 1e-07 m s-1"}
    assert wanted_text(shown) == (
        "mean displacement = −50 mm; displacement at 12 phases; "
        "impact velocity max 1 > 0.5 m/s, < 1 × 10⁻⁷ m/s"
    )
    plain = xr.Dataset(attrs={"target": "displacement_mean = -0.1"})
    assert wanted_text(plain) == "displacement mean = −0.1"


@pytest.mark.slow
def test_a_study_with_units_has_goals_and_designs_in_si():
    study = study_of_text(PHYSICAL, "wanted")
    scene = study.scenes["shifted"]
    p = np.sqrt(8000 / 2)
    assert float(scene.subject_to["impact_velocity_max_1"].removeprefix("< ")) == pytest.approx(
        50 / p
    )
    assert scene.tolerance == {"f": pytest.approx(1e-3), "delta": pytest.approx(2e-4)}
    found = kind_of(scene).solve(scene)
    assert found.attrs["subject_to"] == "impact_velocity_max_1 < 50 m s-1"
    assert (abs(found.displacement_mean + 0.1) < 1e-9).all()
    assert (found.impact_velocity_max.sel(support=1) < 50).all()
    assert found.impact_velocity_max_std.attrs["units"] == "m s-1"
    assert found.F_tolerance.attrs["units"] == "N"
    assert {*found.parameter.values} == {"F", "delta"}


SOFT = """
title: Soft
physical: {m: 2 kg, C: 8 N/mm, H: 12 N s/m, F: 3.6 kN, omega: 50 rad/s, l: 500 mm, C1: 1600 N/mm, C2: 1600 N/mm}
scenes:
  pressed:
    kind: design
    vary: {F: [2.8 kN, 4.4 kN]}
    target: {support_force_max_1: 40 kN}
    subject_to: {contact_duration_max_1: "< 20 ms"}
    samples: 16
    designs: 1
"""


def test_the_force_of_a_soft_support_is_wanted_in_newtons():
    scene = study_of_text(SOFT, "wanted").scenes["pressed"]
    assert scene.target == {"support_force_max_1": pytest.approx(40e3 / 8e3)}
    found = kind_of(scene).solve(scene)
    assert found.support_force_max.attrs["units"] == "N"
    assert float(found.support_force_max.sel(support=1)[0]) == pytest.approx(40e3, rel=1e-8)
    assert float(found.contact_duration_max.sel(support=1)[0]) < 0.02
    with pytest.raises(StudyError, match="C1: must be above 0, since support_force_max_1"):
        study_of_text(SOFT.replace(" C1: 1600 N/mm,", ""), "wanted")


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("displacement_mean: -0.1", "displacment_mean: -0.1", "target: must be a quantity"),
        ("displacement_mean: -0.1", "displacement_mean: -1 mm", "no unit belongs here"),
        ('"< 0.8"', '"0.8"', "subject_to.impact_velocity_max_1: must be bounds in quotes"),
        ('"< 0.8"', "{max: 0.8}", "subject_to.impact_velocity_max_1: must be bounds in quotes"),
        ('"< 0.8"', '"< 0.8, < 0.9"', "subject_to.impact_velocity_max_1: must be a bound such as"),
        ("R1: [0.4, 0.9]", "R1: [0.4, 1.9]", "vary.R1: must be a number from 0 to 1"),
        ("R1: [0.4, 0.9]", "R2: [0.9, 0.4]", "vary.R2: must be two increasing numbers"),
        ("allow: {displacement_mean: 0.005}", "allow: {f: 0.005}", "allow: must have the targets as keys"),
        ("tolerance: {delta: 0.0002,", "tolerance: {delta: -1,", "tolerance.delta: must be a finite number > 0"),
        ("samples: 32", "exciter: {R1: 0.5}", "exciter.R1: must be left out, since R1 stands in vary"),
        ("samples: 32", "start: {x0: 0.3}", "start.x0: must be"),
        ("samples: 32", "minimise: [f, h, nu]", "minimise: must be a quantity or a list of two"),
        ("delta: [-0.3, 0.3]", "k1: [0, 9]", "vary.k1: must be above 0 where k1 or h1 vary"),
    ],
)  # fmt: skip
def test_a_wrong_key_is_named(old, new, message):
    assert old in STUDY
    with pytest.raises(StudyError, match=re.escape(message)):
        study_of_text(STUDY.replace(old, new), "wanted")


def test_a_curve_is_a_target_with_and_without_units():
    curve = "displacement: [[0, -0.2], [0.5, 0.1]]"
    scene = study_of_text(
        STUDY.replace("displacement_mean: -0.1", curve).replace(
            "    allow: {displacement_mean: 0.005}\n", ""
        ),
        "wanted",
    ).scenes["shifted"]
    assert scene.target == {"displacement": [[0.0, -0.2], [0.5, 0.1]]}
    text = PHYSICAL.replace(
        "displacement_mean: -100 mm", "displacement: [[0, -200 mm], [0.5, 0.1 m]]"
    )
    scene = study_of_text(
        text.replace("    allow: {displacement_mean: 5 mm}\n", ""), "wanted"
    ).scenes["shifted"]
    assert scene.target == {"displacement": [[0.0, -0.2], [0.5, 0.1]]}
    with pytest.raises(StudyError, match=r"target\.displacement: must be a finite number or, of"):
        study_of_text(
            STUDY.replace("displacement_mean: -0.1", "displacement: [[0, 1, 2]]"), "wanted"
        )


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("-100 mm}", "-0.1}", "target.displacement_mean: must be a length with its unit"),
        ('"< 50 m/s"', '"< 50 mm"', "subject_to.impact_velocity_max_1: must be a velocity"),
        (
            '"< 50 m/s"',
            '"< 50 m/s", displacement_mean: "> 0 mm"',
            "displacement_mean, got '> 0 mm'",
        ),
        ('"< 50 m/s"', '"< 50 m/s, < 60 m/s"', "got '< 50 m/s, < 60 m/s'"),
        ('"< 50 m/s"', "50 m/s", "impact_velocity_max_1: must be bounds in quotes"),
        ('"< 50 m/s"', "{max: 50 m/s}", "impact_velocity_max_1: must be bounds in quotes"),
        ("[-300 mm, 300 mm]", "[-300, 300]", "vary.delta"),
        ("F: 8 N, delta", "f: 8, delta", "tolerance.f: is an unknown key"),
        (
            "displacement_mean: -100 mm",
            "displacement_men: 1 mm",
            "did you mean 'displacement_mean'",
        ),
        ('"< 50 m/s"', '"> 2 m/s, < 1 m/s"', "got '> 2 m/s, < 1 m/s'"),
    ],
)
def test_a_wrong_unit_is_named(old, new, message):
    assert old in PHYSICAL
    with pytest.raises(StudyError, match=re.escape(message)):
        study_of_text(PHYSICAL.replace(old, new), "wanted")


def test_a_change_of_law_that_was_not_found_is_nowhere() -> None:
    exciter = vp.Exciter(l=0.5, nu=1.3, f=0.5, h=0.1, R1=0.7, R2=0.7)
    design = vp.design(exciter, {"delta": (0, 0.1)}, {"impact_velocity_max_1": 0.5}, samples=16)
    assert design.sizes["design"] == 1
    none = design.assign(law_margin=("design", [1.0]))
    assert "change of the law" not in describe_designs(none)
    some = design.assign(law_margin=("design", [0.5]))
    assert "that was found is 50 % of the ranges away" in describe_designs(some)
    assert "Another law" not in best_design(some).rest
    near = design.assign(law_margin=("design", [0.0002]))
    assert best_design(near).rest.endswith(
        "Another law of motion begins 0.02 % of the ranges away."
    )
    two = xr.concat(
        [none, some], "design", data_vars="minimal", coords="minimal", compat="override"
    )
    (table, *_) = tables({"s": two})
    assert [row[table.head.index("margin (%)")] for row in table.rows] == ["–", "50"]
    assert "is 50 % of the ranges away from design 2" in describe_designs(two)
    assert "A dash: none was found within the widths of the ranges." in table.note


def test_designs_that_are_no_front_are_drawn_once(dataset):
    missed = dataset.assign_attrs(minimise="impact_velocity_max_1; -displacement_amplitude_1")
    missed["design_result"] = missed["design_result"] * 0 + DesignResult.AT_RANGE
    front, designs = (picture_of("design", missed, name) for name in ("front", "designs"))
    assert front.describe(missed, None, {}) == describe_sketch(missed)
    titles = [picture.title(missed, None, {}) for picture in (front, designs)]
    assert titles[0] == "The design found that misses least, drawn to scale"
    assert titles[1].startswith("No design was found that keeps all that is wanted")
