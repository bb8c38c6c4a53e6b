"""Small studies to explore, solved once."""

import numpy as np
import pytest
from small_study import EXCITER, NU, F

import vibropipe as vp
from vibropipe.store import load, save
from vibropipe.view.results import open_results


@pytest.fixture(scope="session")
def study(tmp_path_factory):
    """A folder with a map, curves followed both ways, and basins."""
    folder = tmp_path_factory.mktemp("results") / "small"
    grid = {"nu": NU, "f": F}
    save(vp.sweep(EXCITER, grid), folder / "map.nc")
    both = vp.sweep(
        EXCITER, {"f": [0.5, 1.0], "nu": np.linspace(0.8, 2.2, 15)}, follow=("nu", "both")
    )
    save(both, folder / "both_ways.nc")
    three = vp.Exciter(l=0.5, nu=3.48, f=0.7, h=0.1, delta=0.1, R1=0.8, R2=0.8)
    starts = np.linspace(-0.4, 0.6, 8), np.linspace(-2, 2, 8)
    save(vp.basins(three, *starts, starts=64), folder / "starts.nc")
    return folder


@pytest.fixture(scope="session")
def results(study):
    """The same, opened."""
    return open_results(study, study.parent)


@pytest.fixture(scope="session")
def with_units(study, tmp_path_factory):
    """The map in SI, of a study that writes Hz, mm and mm/s."""
    dataset = vp.to_physical(load(study / "map.nc"), m="2 kg", C="8 N/mm")
    units = "frequency: Hz; length: mm; velocity: mm/s; time: ms; stiffness: N/mm; mass: g"
    folder = tmp_path_factory.mktemp("results") / "units"
    save(dataset.assign_attrs(display_units=units), folder / "map.nc")
    return open_results(folder, folder.parent)
