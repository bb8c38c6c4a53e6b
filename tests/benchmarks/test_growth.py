"""Growth measurement: its sweeps are valid studies, and its results are finite and drawn."""

import math
import subprocess
import sys
from pathlib import Path

import growth
import numpy as np
import pytest
from growth_figure import draw_growth

from vibropipe.figures.style import house_style


@pytest.mark.parametrize("points", [1, 7, 1000, 10_000, 1_000_000])
def test_points_lie_in_the_middles_of_equal_cells(points):
    over = growth.sweep_of(points).over_arrays()
    assert math.prod(values.size for values in over.values()) == points
    for name, (low, high) in growth.SPAN.items():
        step = (high - low) / over[name].size
        np.testing.assert_allclose(np.diff(over[name]), step)
        assert over[name][0] == pytest.approx(low + step / 2)
        assert over[name][-1] == pytest.approx(high - step / 2)


@pytest.mark.parametrize("arguments", [["many"], ["1e3", "-1"], ["inf"], ["1e99"], ["nan"]])
def test_invalid_numbers_of_points_are_named(arguments):
    assert growth.parse_points(["1e3", "20"]) == [1000, 20]
    assert growth.parse_points([]) == growth.POINTS
    with pytest.raises(
        SystemExit, match=rf"must be numbers from 1 to 1e\+08, got .*{arguments[-1]}"
    ):
        growth.parse_points(arguments)


@pytest.mark.slow
def test_a_small_study_is_measured_and_drawn(tmp_path, monkeypatch):
    lines = []
    measured = growth.measure_growth(tmp_path, [60], threads=[1], on_progress=lines.append)
    assert measured.time_per_point.shape == (1, 1)
    assert measured.sizes == {"points": 1, "threads": 1}
    assert all((variable > 0).all() for variable in measured.values())
    assert len(lines) == 1
    assert list(tmp_path.iterdir()) == []
    with house_style():
        figure = draw_growth(measured)
    assert [ax.get_xlabel() for ax in figure.axes] == ["number of points $N$"] * 2


def test_joining_and_querying_are_measured_without_the_compiler():
    """Only processes that solve load numba, in a workflow as in this measurement."""
    folder = Path(growth.__file__).parent
    code = "import sys; from growth import join_shards, query; sys.exit('numba' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], cwd=folder, check=False).returncode == 0


@pytest.mark.slow
def test_joining_takes_less_memory_than_solving(tmp_path):
    measured = growth.measure_growth(tmp_path, [60], threads=[1])
    assert measured.joining_memory.item() < 160 < measured.solving_memory.item() < 500


@pytest.mark.slow
def test_memory_does_not_grow_with_the_number_of_points(tmp_path):
    """Real rows; the largest study takes two minutes to solve."""
    measured = growth.measure_growth(tmp_path, [30_000, 300_000], threads=[2])
    assert (measured.solving_memory < 500).all()
    few, many = measured.isel(points=0), measured.isel(points=1)
    assert many.solving_memory < 1.1 * few.solving_memory
    # the data of ten times the points are 120 MB larger
    assert many.joining_memory - few.joining_memory < 70
    assert many.query_memory - few.query_memory < 70
