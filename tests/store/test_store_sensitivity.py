"""Sensitivities of a sweep in shards: joined, they are those of the sweep in memory, parameters by name."""

import numpy as np
import pytest
from store_datasets import IDENTITY

import vibropipe as vp
from vibropipe import store
from vibropipe.physics.derivatives import DIFFERENTIATED
from vibropipe.solve.sweep.blocks import solve_shard
from vibropipe.solve.sweep.sweep import grid_of

EXCITER = vp.Exciter(l=0.5, h=0.2, R1=0.7, R2=0.7)
OVER = {"nu": np.array([0.4, 0.9, 1.3]), "f": np.array([0.3, 1.0])}
OUTPUTS = ("harmonics", "impacts", "sensitivity")


@pytest.mark.parametrize("follow", [None, ("nu", "up")])
def test_sensitivities_join_like_all_quantities(tmp_path, follow):
    whole = vp.sweep(EXCITER, OVER, outputs=OUTPUTS, follow=follow)
    grid, paths = grid_of(EXCITER, OVER, follow), []
    for cut in ((0, 3), (3, 6)):
        part = solve_shard(grid, *cut, outputs=OUTPUTS)
        paths.append(tmp_path / f"{cut[0]}.nc")
        store.write(part.assign_attrs(IDENTITY), paths[-1])
    store.join(paths, tmp_path / "joined.nc", grid)
    joined = store.load(tmp_path / "joined.nc")
    assert joined.parameter.values.tolist() == list(DIFFERENTIATED)
    names = [name for name in whole.data_vars if name.endswith("_sensitivity")]
    assert "impact_phase_sensitivity" in names
    for name in names:
        assert joined[name].dims == whole[name].dims
        np.testing.assert_array_equal(joined[name].values, whole[name].values)
