"""What reports say of a housing that slides: how fast it creeps and which way, and scales of one sign."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import xarray as xr

import vibropipe as vp
from vibropipe.figures.text import digits, format_number
from vibropipe.report.exciter import values_text
from vibropipe.scenes.basins.text import basin_answers, creep_answers, safety_table
from vibropipe.scenes.sweep.answers import progress_answer
from vibropipe.scenes.sweep.maps import has_negative, value_norm

ROBOT = vp.Exciter.from_physical(
    m="0.2 kg", M="0.5 kg", C="8 N/mm", H="4 N s/m", l="3 mm", F="20 N", omega="60 Hz",
    D1="1.5 N", D2="4 N", R1=0.6, R2=0.6,
)  # fmt: skip


@pytest.fixture(scope="module")
def sweep():
    return vp.sweep(ROBOT, {"nu": [0.6, 0.9, 1.2]}, outputs=["impacts", "stability"])


def test_a_sweep_tells_the_largest_speed_and_its_way(sweep):
    speeds = sweep.housing_velocity_mean.values
    assert (np.diff(speeds) > 0).all()
    found = progress_answer(sweep)
    told = format_number(float(speeds[2]), 3)
    assert found.lead == f"In orbits the housing creeps with at most {told}, along x."
    assert found.rest == "Its speed still rises at the end of the range of ν."


def test_a_sweep_tells_both_ways(sweep):
    speeds = sweep.housing_velocity_mean
    turned = sweep.assign(housing_velocity_mean=speeds.copy(data=[-0.02, 0.0, 0.01]))
    found = progress_answer(turned)
    assert found.lead == "In orbits the housing creeps with at most 0.02, against x."
    assert found.rest == "It reaches 0.01 along x."
    still = sweep.assign(housing_velocity_mean=speeds.copy(data=[1e-17, 0.0, -1e-17]))
    assert progress_answer(still).lead == "In no orbit does the housing creep."
    held = replace(ROBOT, mass_ratio=0.0, housing_friction_1=0.0, housing_friction_2=0.0)
    assert progress_answer(vp.sweep(held, {"nu": [1.0]})) is None


def test_a_scale_has_a_negative_part_where_values_have_one(sweep):
    name = "housing_velocity_mean"
    assert value_norm(sweep, name).vmin == 0.0
    assert not has_negative(sweep, name)
    turned = sweep.assign({name: -sweep[name]})
    assert has_negative(turned, name)
    assert value_norm(turned, name).vmin == -value_norm(turned, name).vmax


def test_basins_tell_how_fast_each_motion_creeps():
    found = vp.basins(ROBOT, np.linspace(-2.7e-3, 2.7e-3, 5), np.linspace(-4e-3, 4e-3, 5))
    order = np.argsort(-found.basin_share.values)
    speeds = found.housing_velocity_mean.values[order]
    assert speeds.size == 2
    first, second = (digits(float(value)) for value in speeds)
    told = [each.lead for each in basin_answers(found)]
    assert told[1] == f"The housing creeps on A with {first} and B with {second}, along x."
    table = safety_table("s", found)
    assert [row[2] for row in table.rows] == [first, second]


def test_a_force_that_a_scene_leaves_out_is_zero_there(sweep):
    loaded = vp.steady_state(replace(ROBOT, load=-0.02))
    assert values_text("load", {"a": loaded}) == "−0.02"
    assert values_text("load", {"a": loaded, "b": sweep}) == "−0.02, 0"


def test_a_housing_that_stays_is_not_said_to_creep():
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
    assert [each.lead for each in creep_answers(maps)] == ["On A and B the housing does not creep."]
    moving = maps.assign(housing_velocity_mean=("attractor_id", [-1e-17, -0.02], {"units": "1"}))
    moving["housing_velocity_max"][1] = 0.4
    (told,) = creep_answers(moving)
    assert told.lead == "The housing creeps on B with 0.02, against x."
