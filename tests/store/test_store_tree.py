"""A filter and a table of a lazily opened scene: impacts belong to no point and are not repeated for each."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import xarray as xr

import vibropipe as vp
from vibropipe.store import write
from vibropipe.words.regimes import Regime

EXCITER = vp.Exciter(l=0.5, nu=1.0, f=-1, h=0.2, R1=0.7, R2=0.7)
OVER = {"nu": [0.6, 1.0, 1.7, 2.9], "f": [0.02, 0.5, 1.0]}


@pytest.fixture(scope="module")
def sweep() -> xr.Dataset:
    return vp.sweep(EXCITER, OVER, harmonics=2)


@pytest.fixture
def node(sweep: xr.Dataset, tmp_path: Path) -> Iterator[xr.DataTree]:
    write(sweep, tmp_path / "map.nc")
    with vp.open_study(tmp_path) as tree:
        yield tree["map"]


def test_a_condition_on_points_leaves_impacts_out(node: xr.DataTree, sweep: xr.Dataset) -> None:
    stored, is_two_sided = sweep.drop_dims("impact"), sweep.regime == Regime.TWO_SIDED
    expected = stored.where(is_two_sided, drop=True)
    assert expected.sizes["f"] < sweep.sizes["f"]
    selected = node.where(node.regime == Regime.TWO_SIDED, drop=True)
    assert all(values.chunks is not None for values in selected.data_vars.values())
    xr.testing.assert_equal(selected.load(), expected)
    masked = node.where(node.regime == Regime.TWO_SIDED)
    assert masked.regime.dims == ("nu", "f")
    xr.testing.assert_equal(masked.load(), stored.where(is_two_sided))


def test_a_condition_on_impacts_selects_impacts(node: xr.DataTree, sweep: xr.Dataset) -> None:
    hard = np.abs(sweep.impact_velocity.values) > 0.8
    assert 0 < hard.sum() < hard.size
    selected = node.where(abs(node.impact_velocity) > 0.8, drop=True)
    assert set(selected.dims) == {"impact"}
    np.testing.assert_array_equal(selected.impact_velocity, sweep.impact_velocity.values[hard])


def test_a_node_becomes_the_table_of_its_points(node: xr.DataTree, sweep: xr.Dataset) -> None:
    pd.testing.assert_frame_equal(node.to_dataframe(), vp.table(sweep))
    part = node.isel(nu=1).sel(f=0.5)
    assert float(part.base_frequency) == 1.0
