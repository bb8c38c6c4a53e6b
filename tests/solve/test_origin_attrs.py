"""Every dataset says how it was made, from Python as from a study."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import xarray as xr

import vibropipe as vp

EXCITER = vp.Exciter(l=0.5, h=0.2, nu=1.0, f=0.8, R1=0.7, R2=0.7)
EFFECTS = "damping, forcing, support_1, support_2, restitution, rest"
START = "x0 = 0, v0 = 0"
MADE = ("method", "effects", "start", "follow", "version", "steps_per_period")


def made(dataset: xr.Dataset) -> dict[str, object]:
    """Return the attributes that say how a dataset was made, without the version."""
    assert dataset.attrs["version"] == vp.__version__
    return {
        name: dataset.attrs[name] for name in MADE if name in dataset.attrs and name != "version"
    }


def test_datasets_from_python_say_how_they_were_made() -> None:
    exact = {"method": "exact", "effects": EFFECTS, "start": START}
    newmark = exact | {"method": "newmark", "steps_per_period": 40}
    assert made(vp.simulate(EXCITER, 3.0)) == exact
    assert made(vp.simulate(EXCITER, 3.0, method="newmark", steps_per_period=40)) == newmark
    assert made(vp.steady_state(EXCITER, x0=0.1)) == exact | {"start": "x0 = 0.1, v0 = 0"}
    over = {"nu": [1.0, 1.1]}
    assert made(vp.sweep(EXCITER, over)) == exact
    for way in ("up", "down", "both"):
        followed = vp.sweep(EXCITER, over, follow=("nu", way))
        assert made(followed) == exact | {"follow": f"nu {way}"}
    free = {"method": "exact", "effects": "support_1, support_2"}
    assert made(vp.backbone(0.1, 2.0)) == free | {"start": "free vibration"}
    start = "free vibration, tau = 0 at its end towards support 1"
    assert made(vp.amplitude_frequency(EXCITER, 2.0)) == free | {"start": start}


def test_an_accuracy_names_the_method_it_chose() -> None:
    # the march without steps is the cheapest, for a coarse accuracy too
    for accuracy in (1e-2, 1e-9):
        motion = vp.simulate(EXCITER, 3.0, accuracy=accuracy)
        assert motion.attrs["method"] == "exact"
        assert "steps_per_period" not in motion.attrs


STUDY = """\
title: t
exciter: {l: 0.5}
scenes:
  exact: {kind: motion, exciter: FORCED, tau_end: 3}
  newmark: {kind: motion, exciter: FORCED, tau_end: 3, solver: {method: newmark, steps_per_period: 40}}
  coarse: {kind: motion, exciter: FORCED, tau_end: 3, solver: {accuracy: 0.01}}
  sweep: {kind: sweep, exciter: SWEPT, over: {nu: [1, 1.1]}, follow: {along: nu, direction: down}}
  backbone: {kind: backbone, delta_over_l: [0.1], tau_bar: [2]}
  amplitude: {kind: backbone, amplitude: [2]}
"""


@pytest.mark.parametrize("name", ["exact", "newmark", "coarse", "sweep", "backbone", "amplitude"])
def test_a_study_says_the_same(name: str, tmp_path: Path) -> None:
    from vibropipe.jobs.solving import solve_to_file
    from vibropipe.study import load_study

    swept = "{f: 0.8, h: 0.2, R1: 0.7, R2: 0.7}"
    text = STUDY.replace("SWEPT", swept).replace("FORCED", "{nu: 1, " + swept[1:])
    (tmp_path / "t.yaml").write_text(text)
    solve_to_file(load_study(tmp_path / "t.yaml"), name, tmp_path / "s.nc", None, 1)
    over = {"nu": np.array([1, 1.1])}
    again = {
        "exact": lambda: vp.simulate(EXCITER, 3.0),
        "newmark": lambda: vp.simulate(EXCITER, 3.0, method="newmark", steps_per_period=40),
        "coarse": lambda: vp.simulate(EXCITER, 3.0, accuracy=0.01),
        "sweep": lambda: vp.sweep(EXCITER, over, follow=("nu", "down")),
        "backbone": lambda: vp.backbone(0.1, 2.0),
        "amplitude": lambda: vp.amplitude_frequency(EXCITER, 2.0),
    }
    stored, expected = made(vp.load(tmp_path / "s.nc")), made(again[name]())
    if "steps_per_period" in expected:
        # A study writes the method with its steps.
        expected["method"] = f"newmark, {expected['steps_per_period']} steps per forcing period"
    assert stored == expected
