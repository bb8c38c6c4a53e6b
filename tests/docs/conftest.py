"""Results that the snippets of the documents query: a coarse regime map, and the study of the tutorial."""

from __future__ import annotations

from pathlib import Path

import pytest
from documents import ROOT, Page

from vibropipe.cli.results import new
from vibropipe.jobs.solving import solve_to_file
from vibropipe.study import load_study


def solve_study(file: Path) -> None:
    study = load_study(file)
    for name in study.scenes:
        path = file.parent / "results" / study.name / f"{name}.nc"
        path.parent.mkdir(parents=True, exist_ok=True)
        solve_to_file(study, name, path, None, 1)


@pytest.fixture(scope="session")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder in which the studies `regimes`, `mine` and `robot` are solved."""
    folder = tmp_path_factory.mktemp("documents")
    coarse = (ROOT / "config/regimes.yaml").read_text(encoding="utf-8")
    assert "points: 200" in coarse
    regimes = folder / "regimes.yaml"
    regimes.write_text(coarse.replace("points: 200", "points: 24"), encoding="utf-8")
    new(folder / "mine")
    mine = folder / "mine.yaml"
    (tutorial,) = Page("docs/tutorial.md").blocks("yaml")
    mine.write_text(tutorial.text, encoding="utf-8")
    new(folder / "robot", units=True)
    (units,) = Page("docs/units.md").blocks("yaml")
    robot = folder / "robot.yaml"
    assert robot.read_text(encoding="utf-8") == units.text
    for file in (regimes, mine, robot):
        solve_study(file)
    return folder
