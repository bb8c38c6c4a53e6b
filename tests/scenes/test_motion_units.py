"""Pictures of motions with units: times that are shown in milliseconds."""

from __future__ import annotations

import pytest
import xarray as xr
from figures.sample_datasets import motion

import vibropipe as vp
from vibropipe.figures.style import house_style
from vibropipe.figures.units import display_units
from vibropipe.scenes.motion.captions import describe_impacts
from vibropipe.scenes.motion.impacts import draw_impacts_only

M, C = 1.0, 1e4  # 40 units of tau are then 0.4 s


@pytest.fixture(scope="module")
def shown() -> xr.Dataset:
    """Return a motion with units, as it is drawn."""
    return display_units({"motion": vp.to_physical(motion(), M, C)})["motion"]


def test_impacts_of_a_motion_without_samples_are_drawn_over_its_time(shown):
    bare = shown.drop_dims("time")
    with house_style():
        figure = draw_impacts_only(bare)
    assert figure.axes[0].get_xlabel() == "time $t$ (ms)"
    assert describe_impacts(bare).startswith("Velocity before each impact against t;")
