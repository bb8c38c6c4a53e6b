"""A study with its figures and its report."""

import pytest
from figures.sample_datasets import Scene, backbone, hard_cases, motion, steady, sweep
from report_text import HOSTILE, PROVENANCE, study_of

from vibropipe.jobs.drawing import draw_study
from vibropipe.jobs.report_data import report_data
from vibropipe.jobs.reporting import build_report
from vibropipe.store import save, write_sidecar


@pytest.fixture(scope="session")
def solved(tmp_path_factory):
    """Return a study with its results on disk, figures drawn: (study, results, datasets)."""
    datasets = {
        "law": backbone(),
        "free": motion(f=0.0, h=0.0, R1=1.0, R2=1.0, v=-0.51, tau_end=10.0),
        "symmetric": steady(tau_end=13.0),
        "offset": steady(0.035, delta=0.01, tau_end=13.0),
        "very_unequal_scene": steady(-0.02, R1=0.6, R2=0.8, tau_end=13.0),
        "response": sweep(f=[0.1, 0.2, 0.5], all_regimes=True),
        "hard": hard_cases(),
    }
    datasets = {name: dataset.assign_attrs(PROVENANCE) for name, dataset in datasets.items()}
    kinds = {"law": "backbone", "response": "sweep", "hard": "hard_cases"}
    scenes = {name: Scene(kinds.get(name, "motion"), name, title="") for name in datasets}
    scenes["offset"].title = HOSTILE
    scenes["offset"].caption = f"Look at {HOSTILE}."
    study = study_of(scenes, title=HOSTILE, description=f"First {HOSTILE}\n\nSecond one.")
    results = tmp_path_factory.mktemp("results")
    for name, dataset in datasets.items():
        save(dataset, results / "small" / f"{name}.nc")
    write_sidecar(results / "small" / "response.nc", seconds=1.25, threads=2)
    draw_study(study, results)
    return study, results, datasets


@pytest.fixture(scope="session")
def data(solved):
    study, _, datasets = solved
    sidecars = {"response": {"seconds": 1.25, "finished": "2026-11-24T23:05:00+00:00"}}
    return report_data(study, datasets, sidecars)


@pytest.fixture(scope="session")
def report(solved):
    """Return the PDF of the study."""
    study, results, _ = solved
    return build_report(study, results, results / "report.pdf")
