"""Accuracy in studies, and the first touch between rows of a sweep."""

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import vibropipe as vp
from vibropipe.figures.units import display_units
from vibropipe.jobs.solving import join_to_file, solve_scene, solve_to_file
from vibropipe.scenes.sweep.answers import sweep_answers
from vibropipe.scenes.sweep.neighbours import first_touch
from vibropipe.store import load
from vibropipe.study import Study, study_of_text
from vibropipe.words.status import Status

STUDY = """
title: Digits instead of steps
exciter: {l: 0.5, nu: 1, f: -1, h: 0.2, R1: 0.7, R2: 0.7}
scenes:
  settled:
    kind: motion
    settle_periods: 30
    tau_end: 12.6
    samples_per_period: 32
    solver: {accuracy: 1e-9}
    outputs: [motion, impacts, harmonics, stability]
  coarse:
    kind: motion
    exciter: {h: 10, nu: 0.1, f: 0.5, l: 0.5}
    tau_end: 500
    solver: {accuracy: 1e-2}
  response:
    kind: sweep
    over: {f: [0.2, 1.0], nu: [0.8, 1.0, 1.2]}
    solver: {accuracy: 1e-9}
"""


@pytest.fixture
def study() -> Study:
    return study_of_text(STUDY, "digits")


def test_a_settled_motion_has_its_errors_and_its_orbit_one_of_its_own(study: Study) -> None:
    ds = solve_scene(study, "settled")
    assert (ds.attrs["method"], ds.attrs["accuracy_asked"]) == ("exact", 1e-9)
    assert 0 < ds.attrs["accuracy_reached"] <= 1e-9
    assert 0 < float(ds.orbit_error) <= 1e-12
    assert int(ds.status) == Status.OK
    assert float(ds.displacement_error.max()) < 1e-9
    # After thirty periods the motion is its orbit, to the rest of the transient.
    amplitude = np.abs(np.fft.rfft(ds.displacement.values[:32])[1]) / 16
    assert amplitude == pytest.approx(float(ds.displacement_amplitude[0]), rel=1e-2)


def test_the_method_that_was_chosen_is_named(study: Study) -> None:
    ds = solve_scene(study, "coarse")
    assert ds.attrs["method"].startswith("newmark, ")
    assert ds.attrs["method"].endswith("steps per forcing period")
    assert ds.attrs["accuracy_reached"] <= 1e-2


def test_a_sweep_carries_its_errors_through_shards_and_files(study: Study, tmp_path: Path) -> None:
    parts: list[Any] = [tmp_path / f"{i}.nc" for i in (1, 2)]
    for i, path in enumerate(parts):
        solve_to_file(study, "response", path, (i + 1, 2), 1)
    join_to_file(study, "response", parts, tmp_path / "response.nc")
    joined, whole = load(tmp_path / "response.nc"), solve_scene(study, "response")
    np.testing.assert_array_equal(joined.error.values, whole.error.values)
    assert joined.attrs["accuracy_asked"] == 1e-9
    assert (joined.error < 1e-12).all()


EXCITER = vp.Exciter(l=0.5, nu=0.8, f=0.1, h=0.15, delta=0.05, load=0.02, R1=0.7, R2=0.6)
GRIDS = {
    "nu": (np.linspace(0.5, 0.95, 19), 2),
    "f": (np.linspace(0.05, 0.4, 15), 2),
    "l": (np.linspace(0.2, 0.6, 9), 2),
    "delta": (np.linspace(-0.1, 0.45, 12), 2),
}


def line_of(name: str, **changes: float):
    return vp.sweep(
        replace(EXCITER, **changes), over={name: GRIDS[name][0]}, outputs=("harmonics",)
    )


def border(line, name: str) -> tuple[float, float]:
    """Return both values of the parameter between which the motion without impacts ends."""
    first = np.flatnonzero(np.diff((line.regime.values == 0).astype(int)))[0]
    return float(line[name][first]), float(line[name][first + 1])


@pytest.mark.parametrize("name", GRIDS)
def test_there_the_linear_amplitude_is_the_gap(name: str) -> None:
    line = line_of(name)
    low, high = border(line, name)
    place = first_touch(line, name, low, high)
    assert place is not None
    assert low < place < high
    e = replace(EXCITER, **{name: place})
    size = math.hypot(1 - e.nu**2, e.h * e.nu)
    assert abs(e.f) / size == pytest.approx(e.l - abs(e.delta - e.load), rel=1e-12)


def test_it_is_the_same_in_the_units_that_are_shown() -> None:
    plain = line_of("nu")
    m, C = 0.35, 6000.0
    shown = display_units({"line": vp.to_physical(plain, m, C)})["line"]
    low, high = border(plain, "nu")
    p = math.sqrt(C / m)
    place = first_touch(shown, "omega", low * p, high * p)
    assert place == pytest.approx(first_touch(plain, "nu", low, high) * p, rel=1e-12)


def test_none_is_told_where_there_is_no_such_form() -> None:
    line = line_of("f")
    low, high = border(line, "f")
    assert first_touch(line, "f", 0.05, low) is None
    assert first_touch(line.assign_coords(friction=0.1), "f", low, high) is None
    assert first_touch(line.assign_coords(f2=0.1), "f", low, high) is None
    assert first_touch(line.drop_vars("nu"), "f", low, high) is None
    assert first_touch(line.assign_coords(mass_ratio=0.0), "f", low, high) is not None
    assert first_touch(line.assign_coords(mass_ratio=0.5), "f", low, high) is None
    # from rest and undamped the motion is f (sin(nu tau) - nu sin(tau)) / (1 - nu^2): it touches at f / |1 - nu| = l
    exciter = vp.Exciter(l=0.5, f=0.05, h=0.0, R1=0.6, R2=0.6)
    undamped = vp.sweep(exciter, over={"nu": [0.75, 0.85, 0.96]}, outputs=("impacts",))
    assert (undamped.regime.values != 0).tolist() == [False, False, True]
    assert first_touch(undamped, "nu", 0.85, 0.96) is None


def test_a_finding_tells_it_with_more_digits_than_the_step() -> None:
    line = line_of("f")
    place = first_touch(line, "f", *border(line, "f"))
    assert (
        f"The motion without impacts touches a support at f = {place:.5g}"[:-2]
        in sweep_answers(line)[0].rest
    )
