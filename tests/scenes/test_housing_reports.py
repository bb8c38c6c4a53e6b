"""What reports say of a housing that slides: how fast it progresses and which way, and scales of one sign."""

from dataclasses import replace

import numpy as np
import pytest
import xarray as xr
from figures.figure_text import texts

import vibropipe as vp
from vibropipe.figures.motion_words import progression_of, slides_away
from vibropipe.figures.style import house_style
from vibropipe.figures.text import axis_label, digits, format_number
from vibropipe.jobs.solving import solve_scene
from vibropipe.report.exciter import bare_symbols, values_text
from vibropipe.scenes.basins.answers import basin_answers, progression_answers, safety_table
from vibropipe.scenes.motion.captions import describe_motion
from vibropipe.scenes.motion.findings import answers as motion_answers
from vibropipe.scenes.motion.panels import draw_motion, panel_names
from vibropipe.scenes.motion.report import steady_tables
from vibropipe.scenes.motion.steady_text import orbit_text
from vibropipe.scenes.sweep.answers import progress_answer, sweep_answers
from vibropipe.scenes.sweep.captions import describe_quantities, describe_sweep
from vibropipe.scenes.sweep.laws import regions_of
from vibropipe.scenes.sweep.layout import MAX_SIDE
from vibropipe.scenes.sweep.maps import has_negative, map_series, value_norm
from vibropipe.scenes.sweep.quantities import panels_of
from vibropipe.scenes.sweep.report import energy_table
from vibropipe.scenes.sweep.titles import largest_title, sweep_title
from vibropipe.study import study_of_text
from vibropipe.words.regimes import Regime

ROBOT = vp.Exciter.from_physical(
    m="0.2 kg", M="0.5 kg", C="8 N/mm", H="4 N s/m", l="3 mm", F="20 N", omega="60 Hz",
    D1="1.5 N", D2="4 N", R1=0.6, R2=0.6,
)  # fmt: skip


TWO_MOTIONS = """title: A housing that slides, and one that is held
exciter: {l: 0.5, nu: 1.2, f: 0.8, h: 0.1, R1: 0.6, R2: 0.6}
scenes:
  moving: {kind: motion, exciter: {mass_ratio: 0.5, housing_friction_1: 0.1, housing_friction_2: 0.25},
           settle_periods: 100, tau_end: 21, outputs: [motion, impacts, harmonics, stability]}
  held: {kind: motion, settle_periods: 100, tau_end: 21, outputs: [motion, impacts, harmonics, stability]}
"""


def test_a_housing_keeps_its_velocity_where_the_record_begins() -> None:
    record = solve_scene(study_of_text(TWO_MOTIONS, "two"), "moving")
    e = vp.Exciter(
        l=0.5, nu=1.2, f=0.8, h=0.1, R1=0.6, R2=0.6,
        mass_ratio=0.5, housing_friction_1=0.1, housing_friction_2=0.25,
    )  # fmt: skip
    settled = vp.simulate(e, 100 * e.period, samples_per_period=0)
    assert float(settled.housing_velocity_end) != 0.0
    assert float(record.housing_velocity[0]) == float(settled.housing_velocity_end)


@pytest.fixture(scope="module")
def sweep():
    return vp.sweep(ROBOT, {"nu": [0.6, 0.9, 1.2]}, outputs=["impacts", "stability"])


def test_a_sweep_tells_the_largest_speed_and_its_way(sweep):
    speeds = sweep.housing_velocity_mean.values
    assert (np.diff(speeds) > 0).all()
    found = progress_answer(sweep)
    told = format_number(float(speeds[2]), 3)
    assert (
        found.lead
        == f"In the orbits reached from rest, the fastest progression of the housing is {told}, along x."
    )
    assert found.rest == "Its speed still rises at the end of the range of ν."


def test_a_sweep_tells_both_ways(sweep):
    speeds = sweep.housing_velocity_mean
    turned = sweep.assign(housing_velocity_mean=speeds.copy(data=[-0.02, 0.0, 0.01]))
    found = progress_answer(turned)
    assert (
        found.lead
        == "In the orbits reached from rest, the fastest progression of the housing is 0.02, against x."
    )
    assert (
        found.rest == "Its speed still rises at the end of the range of ν; along x it reaches 0.01."
    )
    inner = speeds.copy(data=[-0.01, -0.02, 0.01])
    found = progress_answer(sweep.assign(housing_velocity_mean=inner))
    assert found.rest == "It reaches 0.01 along x."
    still = sweep.assign(housing_velocity_mean=speeds.copy(data=[1e-17, 0.0, -1e-17]))
    between = "On the grid, the housing progresses against x only below ν = 1.2"
    assert sweep_title(sweep.assign(housing_velocity_mean=inner)) == between
    assert sweep_title(turned).endswith("progresses against x only below ν = 0.9")
    assert progress_answer(still).lead == "In no orbit does the housing progress."
    (panel,) = (each for each in panels_of(still) if each.series[0].name == "housing_velocity_mean")
    assert largest_title(still, panel.series[0]) == "In no orbit does the housing progress"
    held = replace(ROBOT, mass_ratio=0.0, housing_friction_1=0.0, housing_friction_2=0.0)
    assert progress_answer(vp.sweep(held, {"nu": [1.0]})) is None


def test_a_scale_has_a_negative_part_where_values_have_one(sweep):
    name = "housing_velocity_mean"
    assert value_norm(sweep, name).vmin == 0.0
    assert not has_negative(sweep, name)
    turned = sweep.assign({name: -sweep[name]})
    assert has_negative(turned, name)
    assert value_norm(turned, name).vmin == -value_norm(turned, name).vmax


def test_basins_tell_how_fast_each_motion_progresses():
    found = vp.basins(ROBOT, np.linspace(-2.7e-3, 2.7e-3, 5), np.linspace(-4e-3, 4e-3, 5))
    order = np.argsort(-found.basin_share.values)
    speeds = found.housing_velocity_mean.values[order]
    assert speeds.size == 2
    first, second = (digits(float(value)) for value in speeds)
    told = [each.lead for each in basin_answers(found)]
    assert (
        told[1] == f"The housing progresses at {first} along x on A and at {second} along x on B."
    )
    table = safety_table("s", found)
    assert [row[2] for row in table.rows] == [first, second]


def test_a_sweep_draws_first_how_fast_the_housing_creeps(sweep):
    lines = vp.sweep(ROBOT, {"nu": [0.6, 0.9, 1.2], "friction": [0.0, 0.01]})
    first, *others = panels_of(lines)
    assert first.series[0].name == "housing_velocity_mean"
    assert len(others) <= MAX_SIDE
    assert map_series(lines)[0].name == "housing_velocity_mean"
    assert sweep_title(lines).startswith("On the grid, the housing progresses fastest at ")
    assert "Progression: mean velocity of the housing." in describe_sweep(lines)
    assert "Progression: mean velocity of the housing." in describe_quantities(lines)
    assert axis_label(lines["housing_velocity_mean"]).startswith("progression of the housing ")
    assert bare_symbols({"a": lines}) == "fhd"
    assert bare_symbols({"a": sweep}) == "fh"
    assert bare_symbols({"a": vp.to_physical(sweep, 1.0, 1e4)}) == "CFHMP"
    fixed = vp.sweep(vp.Exciter(l=0.5, h=0.1, shaker=0.2), {"nu": [0.8]})
    assert bare_symbols({"a": fixed}) == "fhu"
    assert bare_symbols({"a": vp.to_physical(fixed, 1.0, 1e4)}) == "CFHPu"


def test_the_work_of_a_load_that_is_absent_is_not_told():
    own = vp.sweep(ROBOT, {"nu": [0.6, 0.9]}, outputs=["harmonics", "impacts", "energy"])
    told = [row[0] for row in energy_table("own", own).rows]
    assert "loss on the ground" in told
    assert "work of the loads" not in told
    drawn = own.assign(energy_housing_load=own.energy_housing_load + 0.1)
    assert "work of the loads" in [row[0] for row in energy_table("own", drawn).rows]


def test_the_label_of_the_velocity_of_a_housing_stays_on_the_page():
    record = solve_scene(study_of_text(TWO_MOTIONS, "two"), "moving")
    for factor in (0.02, 200.0):
        scaled = record.assign(housing_velocity=factor * record.housing_velocity)
        scaled["housing_velocity"].attrs = {**record.housing_velocity.attrs, "units": "mm/s"}
        with house_style():
            figure = draw_motion(scaled)
        labels = [text for text in texts(figure) if "housing" in text.get_text()]
        assert [text.get_text().count("\n") for text in labels] == [1]
        edges = labels[0].get_window_extent()
        assert edges.x0 >= 0.0
        panel = max(figure.axes[:-1], key=lambda ax: ax.get_ylabel().count("housing"))
        assert edges.height <= panel.get_window_extent().height + 1.0


def test_of_a_housing_that_slides_away_no_panel_is_empty():
    away = replace(ROBOT, housing_load=2 * ROBOT.housing_friction_1)
    lines, held = (
        vp.sweep(away, {"nu": [0.6, 0.9]}),
        vp.sweep(away, {"nu": [0.6], "housing_load": [-9, 0]}),
    )
    assert (lines.regime == Regime.UNBOUNDED).all()
    assert not any(panel.series[0].name == "housing_velocity_mean" for panel in panels_of(lines))
    assert map_series(lines)[0].name == "impact_velocity_max"
    for caption in (describe_sweep(lines), describe_sweep(lines, ["housing_velocity_mean"])):
        assert "Not drawn, since no row has a value: progression of the housing." in caption
        assert "Of 2 rows, all have no periodic orbit" in caption
        assert "outputs include neither" not in caption
    assert (
        sweep_answers(lines)[0].lead == "The mass slides away with its housing in all rows along ν."
    )
    assert panels_of(held)[0].series[0].name == "housing_velocity_mean"
    assert "Not drawn" not in describe_sweep(held)
    in_si = vp.to_physical(lines, 0.2, 8000.0, units={"force": "kN"})
    assert slides_away(in_si).all()
    assert slides_away(held).values.ravel().tolist() == [True, False]
    # an undamped mass that a force at its frequency drives moves without bound itself
    driven = vp.sweep(vp.Exciter(l=1e9, nu=1.0, f=1.0), {"nu": [1.0]})
    assert [region.does for region in regions_of(driven)[1]] == ["moves without bound"]


def test_a_motion_shows_and_tells_how_the_housing_creeps():
    study = study_of_text(TWO_MOTIONS, "two")
    moving, held = (solve_scene(study, name) for name in ("moving", "held"))
    mean = format_number(float(moving.housing_velocity_mean), 3)
    told = {each.lead: each.rest for each in motion_answers({"m": moving})["m"]}
    assert (
        told["The housing progresses along x."] == f"Its progression, the mean velocity, is {mean}."
    )
    assert panel_names(moving)[-1] == "housing_velocity"
    figure = draw_motion(moving)
    (line,) = figure.axes[-2].lines[-1:]
    assert (line.get_ydata() == moving.housing_velocity.values).all()
    assert "velocity of the housing over" in describe_motion(moving)
    (table,) = steady_tables({"m": moving})
    assert table.rows[0][table.head.index("progression")] == format_number(
        float(moving.housing_velocity_mean), 4
    )
    assert "Progression: mean velocity of the housing." in table.note
    assert "housing_velocity" not in panel_names(held)
    assert "housing" not in str(motion_answers({"m": held}))


def test_a_housing_that_is_pulled_away_has_no_mean_velocity() -> None:
    pulled = TWO_MOTIONS.replace("mass_ratio: 0.5", "mass_ratio: 0.5, housing_load: -0.3")
    away = solve_scene(study_of_text(pulled, "two"), "moving")
    (told,) = (each for each in motion_answers({"m": away})["m"] if "housing" in each.lead)
    assert told.lead == "The housing slides away."
    # between the supports it does not grow
    assert orbit_text(away) == "The mass slides away with its housing"
    assert not any("bound" in each.lead for each in motion_answers({"m": away})["m"])
    assert float(away.housing_velocity_end) < float(away.housing_velocity[0]) < -1.0


def test_a_force_that_a_scene_leaves_out_is_zero_there(sweep):
    loaded = vp.steady_state(replace(ROBOT, load=-0.02))
    assert values_text("load", {"a": loaded}) == "−0.02"
    assert values_text("load", {"a": loaded, "b": sweep}) == "−0.02, 0"


def test_a_housing_that_stays_is_not_said_to_progress():
    letters = np.arange(2)
    maps = xr.Dataset(
        {
            "basin_share": ("attractor_id", [0.6, 0.4]),
            "housing_velocity_mean": ("attractor_id", [-1e-17, 0.0], {"units": "1"}),
            "housing_velocity_max": ("attractor_id", [0.3, 0.0]),
            "impacts_per_orbit": (("attractor_id", "support"), np.ones((2, 2), int)),
        },
        {"attractor_id": letters, "support": [1, 2]},
    )
    assert [each.lead for each in progression_answers(maps)] == [
        "On A and B the housing does not progress."
    ]
    moving = maps.assign(housing_velocity_mean=("attractor_id", [-1e-17, -0.02], {"units": "1"}))
    moving["housing_velocity_max"][1] = 0.4
    (told,) = progression_answers(moving)
    assert told.lead == "The housing progresses at 0.0200 against x on B."


def test_tables_have_no_progression_of_rounding():
    text = TWO_MOTIONS.replace(
        "housing_friction_1: 0.1, housing_friction_2: 0.25",
        "housing_friction_1: 9, housing_friction_2: 9",
    )
    moving = solve_scene(study_of_text(text, "mine"), "moving")
    assert 0.0 <= abs(moving.housing_velocity_mean) < 1e-15 < moving.housing_velocity_max
    rounded = moving.assign(housing_velocity_mean=moving.housing_velocity_mean * 0 + 1e-18)
    assert progression_of(rounded) == 0.0
    (table, *_) = steady_tables({"moving": rounded})
    assert "× 10" not in " ".join(table.rows[0])
