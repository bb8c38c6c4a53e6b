"""Datasets and figures for every kind of picture."""

from collections.abc import Iterator
from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr
from drawing import draw
from figures.sample_datasets import Scene, amplitude_frequency, backbone, hard_cases, motion, sweep

from vibropipe.figures.style import house_style
from vibropipe.scenes.sweep.keys import SweepFigure
from vibropipe.words.measurements import Outcome
from vibropipe.words.parameters import PARAMETERS
from vibropipe.words.vocabulary import describe

WORK_PRECISION_DIMS = ("motion", "method", "setting")
WORK_PRECISION_METHODS = ["crude", "newmark", "exact", "RK45"]


@pytest.fixture(scope="module", autouse=True)
def in_house_style() -> Iterator[None]:
    """Draw in the style in which the jobs of a study draw."""
    with house_style():
        yield


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


@pytest.fixture
def work_precision() -> xr.Dataset:
    """Return work-precision data of two motions; RK45 does not finish the second."""
    steps = np.array([16.0, 64, 256])
    error, time = np.full((2, 4, 3), np.nan), np.full((2, 4, 3), np.nan)
    outcome = np.full((2, 4, 3), Outcome.NOT_TRIED, np.int8)
    error[:, 0], error[:, 1], error[:, 2, 0] = 0.5 / steps, 5 / steps**2, 1e-14
    time[:, 0], time[:, 1], time[:, 2, 0] = 10 * steps, 20 * steps, 100
    error[0, 3], time[0, 3] = [1e-3, 1e-6, 1e-9], [1e5, 2e5, 4e5]
    outcome[:, :2], outcome[:, 2, 0], outcome[0, 3] = Outcome.OK, Outcome.OK, Outcome.OK
    outcome[1, 3] = Outcome.DID_NOT_END
    setting = np.array([steps, steps, [np.nan] * 3, [1e-3, 1e-6, 1e-9]])
    columns = {
        f"error_{n}": (WORK_PRECISION_DIMS, error) for n in ("end", "impact_tau", "impact_velocity")
    }
    columns |= {
        f"time_per_period{side}": (WORK_PRECISION_DIMS, time) for side in ("", "_low", "_high")
    }
    columns |= {
        f"work_{n}": (WORK_PRECISION_DIMS, error) for n in ("steps", "evaluations", "iterations")
    }
    columns |= {
        "error_harmonics": (WORK_PRECISION_DIMS, error),
        "outcome": (WORK_PRECISION_DIMS, outcome),
        "setting_value": (WORK_PRECISION_DIMS[1:], setting),
        "periods_run": ("motion", [4, 4]),
        "impacts_per_period": ("motion", [2.0, 2.0]),
    }
    coords = {name: ("motion", [1.0, 1.0]) for name in PARAMETERS}
    coords |= {
        "motion": ("motion", ["plain", "with_chatter"]),
        "method": ("method", WORK_PRECISION_METHODS),
    }
    return describe(xr.Dataset(columns, coords))
