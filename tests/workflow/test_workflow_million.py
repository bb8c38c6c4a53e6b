"""A study of a million points goes from YAML to PDF, with unresolved rows among its points."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import netCDF4
import numpy as np
import pytest

from vibropipe.words.regimes import Regime
from vibropipe.words.status import Status

# One of its rows once ended its shard, its job and the study.
STUDY = """\
title: A million points
exciter: {l: 0.5, h: 0.2, R1: 0.7, R2: 0.7}
scenes:
  regimes:
    kind: sweep
    over:
      nu: {start: 0.3, stop: 3, points: 1000}
      f: {start: 0.05, stop: 2, points: 1000}
"""


@pytest.mark.slow
def test_a_million_points_from_yaml_to_pdf(fresh: Any, tmp_path: Path) -> None:
    project = fresh.copied(tmp_path / "project")
    project.path("config/config.yaml").write_text("studies: [million]\n")
    project.path("config/million.yaml").write_text(STUDY)
    project.snakemake()
    folder = project.path("results/million")
    assert (folder / "report.pdf").read_bytes().startswith(b"%PDF")
    assert (folder / "figures" / "regimes.pdf").read_bytes().startswith(b"%PDF")
    with netCDF4.Dataset(folder / "regimes.nc") as file:
        regime, status, m = (
            np.asarray(file[name][...]) for name in ("regime", "status", "period_multiple")
        )
    assert regime.shape == (1000, 1000)
    orbit = regime <= Regime.WITH_REST
    np.testing.assert_array_equal(orbit, m > 0)
    np.testing.assert_array_equal(orbit, status == Status.OK)
    assert orbit.mean() > 0.85
    # motions that still grow after 1,000 periods
    unresolved = int((regime == Regime.UNRESOLVED).sum())
    assert unresolved < 100
    assert json.loads((folder / "regimes.json").read_text())["unresolved"] == unresolved
