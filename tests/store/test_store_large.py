"""Studies larger than memory: a join and a query hold a part of the data, however large the whole is.

The parts are made small here, so that a study of 120 MB is already many of them.
"""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from store_datasets import rows_of_sweep, write_shards

from vibropipe.solve.sweep.sweep_grid import SweepGrid

JOIN = """
import sys
import numpy as np
from vibropipe.solve.sweep.sweep_grid import SweepGrid
from vibropipe.store import join, sweep_files

sweep_files.BLOCK_ROWS = 1 << 13
folder, follow, rows = sys.argv[1], sys.argv[2], int(sys.argv[3])
dims = {"nu": np.arange(100.0), "f": np.arange(rows / 100)}
join([f"{folder}/shards/{start:04d}.nc" for start in range(0, rows, 5000)],
     f"{folder}/joined/map.nc", SweepGrid(dims, (follow, "up") if follow else None))
"""
SLICE = """
import sys
from vibropipe.store import files, open_study

files.DASK_BYTES, files.CACHE_BYTES = 1 << 20, 1 << 18
rows = open_study(f"{sys.argv[1]}/joined")["map"]
for name in rows.data_vars:
    rows[name][:2].values
"""
QUERY = """
import sys
from vibropipe.store import files, open_study

files.DASK_BYTES, files.CACHE_BYTES = 1 << 20, 1 << 18
rows = open_study(f"{sys.argv[1]}/joined")["map"]
for variable in rows.data_vars.values():
    variable.max().compute()
"""
PRINT_PEAK = """
print([line.split()[1] for line in open("/proc/self/status") if "VmHWM" in line][0])
"""

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(not Path("/proc/self/status").is_file(), reason="memory is read from /proc"),
]


def peak(script: str, *arguments: str) -> float:
    """Return the peak memory of a process that runs the script, in MB."""
    process = subprocess.run(
        [sys.executable, "-W", "ignore", "-c", script + PRINT_PEAK, *arguments],
        env=os.environ,
        capture_output=True,
        text=True,
        check=True,
    )
    return int(process.stdout.split()[-1]) / 1e3


@pytest.fixture(scope="module", params=["", "nu"])
def studies(request, tmp_path_factory):
    """What is followed, and shards of 5,000 rows: of 50,000 and of 500,000 rows."""
    folders, follow = {}, request.param
    for rows in (50_000, 500_000):
        folders[rows] = tmp_path_factory.mktemp(str(rows))
        dims = {"nu": np.arange(100.0), "f": np.arange(rows / 100)}
        write_shards(
            folders[rows] / "shards",
            rows_of_sweep(rows, phases=16),
            list(range(5000, rows, 5000)),
            SweepGrid(dims, (follow, "up") if follow else None),
        )
    size = sum(path.stat().st_size for path in (folders[500_000] / "shards").iterdir())
    assert size > 110e6
    return follow, folders


def test_memory_does_not_grow_with_the_number_of_rows(studies):
    follow, folders = studies
    for script in (JOIN, SLICE, QUERY):
        few, many = (peak(script, str(folders[n]), follow, str(n)) for n in folders)
        assert many - few < 30, script
