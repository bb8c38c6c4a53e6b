"""What designs settle on from rest, against steady states, where two motions are stable and where one is."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest
import xarray as xr

import vibropipe as vp
from vibropipe.solve.branch.from_rest import reached_from_rest
from vibropipe.words.quantities import FLAGS

CODES = FLAGS["settled_same"]
# From rest the weaker forces lead to a motion that strikes no support, from v0 = 1.5 to one that strikes both.
TWO_MOTIONS = vp.Exciter(l=0.5, nu=1.9, h=0.2, R1=0.7, R2=0.7)
RANGES = {"f": (0.45, 0.95), "R1": (0.5, 0.9)}


def from_rest_by_sections(exciter: vp.Exciter, designs: xr.Dataset) -> Iterator[int]:
    """Yield the code of each design: whether its section is one of those of the steady state from rest."""
    for n in range(designs.sizes["design"]):
        own = designs.isel(design=n)
        made = replace(
            exciter, **{name: float(own[name]) for name in str(own.attrs["vary"]).split()}
        )
        rest = vp.steady_state(made, outputs=("poincare",))
        if int(rest.period_multiple) == 0:
            yield CODES["unknown"]
            continue
        visits = np.stack([rest.poincare_displacement, rest.poincare_velocity], axis=-1)
        state = np.array([own.displacement_strobe, own.velocity_strobe])
        is_near = (np.abs(visits - state) < 1e-6 * np.abs(visits).max()).all(axis=-1).any()
        yield CODES["same" if is_near else "other"]


def test_from_another_start_some_designs_are_not_reached_from_rest() -> None:
    ds = vp.design(TWO_MOTIONS, RANGES, {"impact_velocity_max_1": 0.75}, v0=1.5, samples=64)
    codes = [*from_rest_by_sections(TWO_MOTIONS, ds)]
    assert {CODES["same"], CODES["other"]} == {*codes}
    assert ds.from_rest.values.tolist() == codes
    assert ds.from_rest.attrs["flag_meanings"] == "unknown other same"
    assert ds.from_rest.dims == ("design",)


@pytest.mark.parametrize(
    "more",
    [
        {"load": 0.05},
        {"k2": 200.0, "h2": 3.0, "friction": 0.1},
        {"mass_ratio": 0.5, "housing_friction_1": 0.3, "housing_friction_2": 0.45},
    ],
)
def test_designs_from_rest_are_reached_from_rest(more: dict[str, float]) -> None:
    exciter = vp.Exciter(l=0.5, nu=1.0, f=-1.0, h=0.2, R1=0.7, delta=0.02, **more)
    bound = {"impact_velocity_max_1": "< 0.9"}
    ds = vp.design(exciter, {"f": (-1.2, -0.5)}, subject_to=bound, samples=16, designs=2)
    codes = [*from_rest_by_sections(exciter, ds)]
    assert {*codes} == {CODES["same"]}
    assert ds.from_rest.values.tolist() == codes
    assert ds.attrs["start"] == f"x0 = {more.get('load', 0):g}, v0 = 0"


def test_of_a_motion_without_an_orbit_it_is_not_known() -> None:
    one = vp.steady_state(replace(TWO_MOTIONS, f=0.5), v0=1.5).expand_dims("design")
    assert reached_from_rest(one).tolist() == [CODES["other"]]
    chaotic = one.assign(period_multiple=("design", [0]))
    assert reached_from_rest(chaotic).tolist() == [CODES["unknown"]]


@pytest.mark.slow
def test_a_cost_is_lowered_as_far_as_the_start_leads_to_the_design() -> None:
    """Targets and the bound can be met; the least power lies at an end of the law, not reached from rest."""
    exciter = vp.Exciter(l=0.5, nu=1.0, f=-1.0, h=0.2, R1=0.7, R2=0.6)
    found = vp.design(
        exciter,
        {"nu": (0.6, 2.0), "f": (-1.5, -0.3), "delta": (-0.2, 0.2)},
        target={"displacement_mean": 0.02, "impacts_per_period_1": 1, "impacts_per_period_2": 1},
        subject_to={"impact_velocity_max_1": "< 0.8"},
        minimise="power_input",
        samples=8,
        designs=1,
    )
    design = found.isel(design=0)
    assert int(design.design_result) == 0
    made = replace(exciter, **{name: float(design[name]) for name in ("nu", "f", "delta")})
    state = vp.steady_state(made, outputs=("harmonics", "impacts", "power"))
    assert float(state.displacement_mean) == pytest.approx(0.02, abs=1e-8)
    assert state.impacts_per_period.values.tolist() == [1, 1]
    assert float(state.impact_velocity_max[0]) < 0.8
    assert float(state.power_input) < 0.03
