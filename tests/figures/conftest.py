"""One scene for every kind of picture."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr
from drawing import draw
from figures.sample_datasets import Scene, amplitude_frequency, backbone, hard_cases, motion, sweep

from vibropipe.figures.style import house_style
from vibropipe.scenes.sweep.keys import SweepFigure


@pytest.fixture(scope="session")
def made() -> dict[str, tuple[str, xr.Dataset]]:
    """Return kind and dataset of one scene for every kind of picture."""
    return {
        "forced": ("motion", motion(exact=True, rest=True)),
        "impacts": ("motion", motion().drop_dims("tau")),
        "conservative": (
            "motion",
            motion(f=0.0, h=0.0, R1=1.0, R2=1.0, delta=0.01, v=-0.51, grazing=True),
        ),
        "law": ("backbone", backbone()),
        "free_0": ("backbone", amplitude_frequency(0.0)),
        "free_1": ("backbone", amplitude_frequency(0.01)),
        "hard": ("hard_cases", hard_cases()),
        "line": ("sweep", sweep()),
        "lines": ("sweep", sweep(f=[0.1, 0.2, 0.5], all_regimes=True)),
        "columns": ("sweep", sweep(f=[0.1, 0.5], delta=[0.0, 0.1])),
        "map": ("sweep", sweep(60, f=np.linspace(0.05, 2, 50), all_regimes=True)),
        "bands": ("sweep", sweep(40, f=np.linspace(0.05, 2, 40), delta=[0.0, 0.1])),
    }


@pytest.fixture(scope="session")
def figures(made):
    """Return every picture, laid out as it will be printed."""
    drawn = {}
    for name, (kind, dataset) in made.items():
        options = SweepFigure(backbone="free_1") if name == "lines" else None
        drawn[name] = draw(kind, dataset, options, {"free_1": made["free_1"][1]})
        with house_style():
            drawn[name].draw_without_rendering()
    return drawn


@pytest.fixture
def study(made) -> SimpleNamespace:
    scenes = {name: Scene(kind, name) for name, (kind, _) in made.items()}
    scenes["lines"].figure = SweepFigure(backbone="free_1")
    return SimpleNamespace(title="A study", description="", scenes=scenes)
