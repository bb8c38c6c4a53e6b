"""What the mass settles on from rest, on branches of studies: against steady states, in pictures and tables."""

from dataclasses import replace

import numpy as np
import pytest
import xarray as xr
from drawing import draw
from matplotlib.colors import to_rgb

import vibropipe as vp
from vibropipe.scenes.branch.curves import REACHED
from vibropipe.scenes.branch.pictures import describe_branches
from vibropipe.scenes.branch.report import stable_table
from vibropipe.scenes.branch.stretches import rest_text, stretches_of
from vibropipe.scenes.registry import kinds
from vibropipe.study import study_of_text
from vibropipe.words.quantities import FLAGS

CODES = FLAGS["settled_same"]
EXCITER = vp.Exciter(l=0.5, nu=1.05, f=0.5, h=0.2, R1=0.7, R2=0.7)
STUDY = """
title: T
exciter: {l: 0.5, h: 0.2, f: 0.5, R1: 0.7, R2: 0.7}
scenes:
  one: {kind: branch, along: {nu: {from: 1.05, to: [0.9, 2.6]}}}
  shaken:
    kind: branch
    exciter: {f: 0, shaker: 0.3, delta: 0.02, load: 0.01}
    along: {nu: {from: 1.2, to: [1, 1.5]}}
  lopsided:
    kind: branch
    exciter: {f: 1, h: 0.1, R1: 0.8, R2: 0.8}
    along: {nu: {from: 2, to: 1.25}}
    switch: [pitchfork]
"""


@pytest.fixture(scope="module")
def made() -> dict[str, xr.Dataset]:
    study = study_of_text(STUDY, "mine")
    return {name: kinds()["branch"].solve(scene) for name, scene in study.scenes.items()}


def of_points(dataset: xr.Dataset, exciter: vp.Exciter) -> np.ndarray:
    """Return the codes by hand: the steady state from rest at every stable point, and its section."""
    found = []
    for point in range(0, dataset.sizes["point"], 3):
        one = dataset.isel(point=point)
        rest = vp.steady_state(
            replace(exciter, nu=float(one.nu)), outputs=("impacts", "poincare", "stability")
        )
        if int(one.stable) != 1:
            found.append(CODES["other"])
        elif int(rest.period_multiple) == 0:
            found.append(CODES["unknown"])
        else:
            visits = np.stack([rest.poincare_displacement, rest.poincare_velocity], axis=-1)
            state = np.array([one.displacement_strobe, one.velocity_strobe])
            near = (np.abs(visits - state) < 1e-6 * np.abs(visits).max()).all(axis=-1).any()
            found.append(CODES["same" if near else "other"])
    return np.array(found)


@pytest.mark.parametrize(
    ("name", "exciter"),
    [
        ("one", EXCITER),
        ("shaken", replace(EXCITER, f=0.0, shaker=0.3, delta=0.02, load=0.01)),
        ("lopsided", replace(EXCITER, f=1.0, h=0.1, R1=0.8, R2=0.8)),
    ],
)
def test_codes_are_those_of_steady_states_from_rest(
    made: dict[str, xr.Dataset], name: str, exciter: vp.Exciter
) -> None:
    codes = of_points(made[name], exciter)
    np.testing.assert_array_equal(made[name].from_rest[::3], codes)
    assert CODES["same"] in codes
    assert made[name].from_rest.attrs["flag_meanings"] == "unknown other same"


def test_of_mirror_images_at_most_one_is_reached(made: dict[str, xr.Dataset]) -> None:
    stretches = [s for s in stretches_of(made["lopsided"]) if np.ptp(s.values) > 0.1]
    pair = [s for s in stretches if abs(s.values[-1] - stretches[-1].values[-1]) < 1e-6]
    assert len(pair) == 2
    reached = [s.from_rest == CODES["same"] for s in pair]
    at = [s.values[is_reached] for s, is_reached in zip(pair, reached, strict=True)]
    assert not {*at[0].round(9)} & {*at[1].round(9)}
    assert rest_text(pair) in ("yes", "in part")
    table = stable_table("lopsided", made["lopsided"])
    assert table is not None
    assert table.head[-1] == "from rest"
    assert {len(row) for row in table.rows} == {len(table.head)}


@pytest.mark.parametrize(
    ("codes", "text"),
    [
        ([-2, 1, 1], "yes"),
        ([0, 0, -2], "no"),
        ([-1, 1, 1, -1], "yes"),
        ([-1, 0, 0], "no"),
        ([-2, 1, 0], "in part"),
        ([1, -1, 1], "in part"),
        ([0, -1, 0], "unknown"),
        ([-1, -1], "unknown"),
        ([-2], "unknown"),
    ],
)
def test_what_is_not_known_is_not_claimed(
    made: dict[str, xr.Dataset], codes: list[int], text: str
) -> None:
    one = replace(stretches_of(made["one"])[0], from_rest=np.array(codes))
    assert rest_text([replace(one, values=np.arange(len(codes), dtype=float))]) == text


def test_the_picture_has_wide_lines_where_the_mass_settles(made: dict[str, xr.Dataset]) -> None:
    dataset = made["one"]
    figure = draw("branch", dataset)
    wide = [line for line in figure.axes[0].lines if line.get_linewidth() == REACHED["linewidth"]]
    drawn = np.concatenate([line.get_xdata()[np.isfinite(line.get_ydata())] for line in wide])
    nu = dataset.nu.values[dataset.from_rest.values == CODES["same"]]
    assert {*nu} <= {*drawn}
    lines = {to_rgb(line.get_color()) for line in figure.axes[0].lines if line not in wide}
    assert {to_rgb(line.get_color()) for line in wide} <= lines
    assert "wide: what the mass settles on from rest" in describe_branches(dataset, [])
    older = dataset.drop_vars("from_rest")
    assert "from rest" not in describe_branches(older, [])
    table = stable_table("one", older)
    assert table is not None
    assert "from rest" not in table.head
