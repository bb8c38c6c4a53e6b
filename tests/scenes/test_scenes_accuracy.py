"""`solver: {accuracy: ...}` in a study: what was chosen and what was reached is in the dataset."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from vibropipe.jobs.solving import join_to_file, solve_scene, solve_to_file
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
