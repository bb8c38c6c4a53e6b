"""A scene followed in both directions, from its keys to files, tables and verification."""

from pathlib import Path

import netCDF4
import numpy as np
import pytest
import xarray as xr

import vibropipe as vp
from vibropipe.jobs.plan import plan_scene
from vibropipe.jobs.solving import join_to_file, solve_scene, solve_to_file
from vibropipe.jobs.verify import verify
from vibropipe.study import Study, study_of_text

# The followed parameter is not the last one, so that the order of the rows differs from that of the dataset.
TEXT = """\
title: t
exciter: {l: 0.5, h: 0.2, R1: 0.7, R2: 0.7}
scenes:
  map:
    kind: sweep
    over: {nu: {start: 0.9, stop: 2.7, points: 9}, f: [0.2, 0.5, 1]}
    follow: {along: nu, direction: both}
"""


@pytest.fixture(scope="module")
def study() -> Study:
    return study_of_text(TEXT, "t")


@pytest.fixture(scope="module")
def whole(study: Study, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("results") / "t" / "map.nc"
    solve_to_file(study, "map", path, None, 1)
    return path


def halves() -> list[xr.Dataset]:
    """Return the sweeps up and down."""
    exciter = vp.Exciter(l=0.5, h=0.2, R1=0.7, R2=0.7)
    over = {"nu": np.linspace(0.9, 2.7, 9), "f": [0.2, 0.5, 1]}
    return [vp.sweep(exciter, over, follow=("nu", way)) for way in ("up", "down")]


def test_the_plan_counts_the_rows_of_both(study: Study) -> None:
    plan = plan_scene(study.scene("map"))
    assert (plan.rows, plan.size) == (54, "2 direction x 9 nu x 3 f")
    assert plan.method == "exact, nu both"


def test_a_scene_holds_the_sweeps_up_and_down(whole: Path) -> None:
    stored = vp.load(whole)
    assert stored.regime.dims == ("direction", "nu", "f")
    assert stored.direction.dtype.kind == "U"
    parts = halves()
    for way, part in zip(("up", "down"), parts, strict=True):
        half = stored.sel(direction=way, drop=True)
        for name, values in part.data_vars.items():
            if "impact" not in values.dims:
                assert half[name].values.tobytes() == values.values.tobytes(), name
    velocity = np.concatenate([part.impact_velocity.values for part in parts])
    assert stored.impact_velocity.values.tobytes() == velocity.tobytes()


@pytest.mark.parametrize("shards", [2, 3, 6])
def test_the_file_does_not_depend_on_the_cut(
    study: Study, whole: Path, tmp_path: Path, shards: int
) -> None:
    parts = [tmp_path / "shards" / f"{part}.nc" for part in range(1, shards + 1)]
    for part, path in enumerate(parts, 1):
        solve_to_file(study, "map", path, (part, shards), 1)
    join_to_file(study, "map", parts[::-1], tmp_path / "map.nc")
    joined = tmp_path / "map.nc"
    assert joined.read_bytes() == whole.read_bytes()
    xr.testing.assert_identical(vp.load(joined), solve_scene(study, "map").assign_attrs(
        vp.load(joined).attrs
    ))  # fmt: skip


def test_it_is_verified_and_a_changed_direction_is_found(whole: Path, tmp_path: Path) -> None:
    verdicts = list(verify(whole, rows=1000))
    assert [str(verdict) for verdict in verdicts] == ["map: all 54 rows: same, bit for bit"]
    changed = vp.load(whole)
    changed["residual"][1, 4, 2] += 1e-16
    from vibropipe.store import write

    write(changed, tmp_path / "map.nc")
    (verdict,) = verify(tmp_path / "map.nc", rows=1000)
    assert len(verdict.faults) == 1
    assert verdict.faults[0].startswith("residual at direction = down, nu = ")
    turned = vp.load(whole).assign_coords(direction=["down", "up"])
    turned["direction"].attrs = changed["direction"].attrs
    write(turned, tmp_path / "map.nc")
    (verdict,) = verify(tmp_path / "map.nc", rows=1000)
    assert set(verdict.faults) == {"direction at [0]: 'down' in the file, 'up' computed again"}


def test_a_study_opens_lazily_and_becomes_a_table(whole: Path) -> None:
    node = vp.open_study(whole.parent)["map"]
    assert node.displacement_amplitude.chunks is not None
    assert node.direction.dtype.kind == "U"
    up = node.impact_velocity_max.sel(direction="up", f=0.5, support=1)
    np.testing.assert_array_equal(up.values, halves()[0].impact_velocity_max.sel(f=0.5, support=1))
    for table in (vp.table(node), vp.table(whole)):
        assert list(table.columns[:3]) == ["direction", "nu", "f"]
        assert table["direction"].tolist() == ["up"] * 27 + ["down"] * 27
    impacts = vp.table(whole, impacts=True)
    assert len(impacts) == sum(part.sizes["impact"] for part in halves())
    with netCDF4.Dataset(whole) as file:
        assert file.variables["direction"].long_name == "direction in which the sweep was followed"
