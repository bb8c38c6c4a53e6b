"""A study with its figures, and what the typesetter makes of it."""

from __future__ import annotations

import json
from types import SimpleNamespace

import pytest
import typst
from figures.sample_datasets import Scene, backbone, hard_cases, motion, steady, sweep
from report_text import HOSTILE, PROVENANCE

from vibropipe.jobs.drawing import draw_study
from vibropipe.jobs.reporting import report_data
from vibropipe.report import template_folder
from vibropipe.store import write, write_sidecar


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
    study = SimpleNamespace(
        name="small",
        title=HOSTILE,
        description=f"First {HOSTILE}\n\nSecond one.",
        scenes=scenes,
        fingerprints={},
    )
    results = tmp_path_factory.mktemp("results")
    for name, dataset in datasets.items():
        write(dataset, results / "small" / f"{name}.nc")
    write_sidecar(results / "small" / "response.nc", seconds=1.25, threads=2)
    draw_study(study, results)
    return study, results, datasets


@pytest.fixture(scope="session")
def data(solved):
    study, _, datasets = solved
    return report_data(study, datasets, {"response": {"seconds": 1.25}})


@pytest.fixture(scope="session")
def typeset_text(solved, data):
    """Return what the typesetter made of the data: {kind of element: its fields as JSON text}."""
    study, results, _ = solved
    pictures = {name: results / "small" / "figures" / f"{name}.pdf" for name in study.scenes}
    with template_folder(data, pictures) as folder:
        compiler = typst.Compiler(folder / "template.typ", root=folder, ignore_system_fonts=True)
        return {
            kind: json.loads(compiler.query(kind))
            for kind in ("figure", "heading", "par", "image", "table", "math.equation")
        }
