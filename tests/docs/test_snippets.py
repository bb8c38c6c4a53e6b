"""Code of the documents runs as it stands and shows what they show; the README is short."""

from __future__ import annotations

import re
import shlex
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from documents import README, ROOT, Block, Page, all_blocks
from first_steps import NOTEBOOK, executed, stored

from vibropipe.jobs.drawing import draw_study
from vibropipe.jobs.reporting import build_report
from vibropipe.study import load_study

CONFIG = Path(__file__).parents[2] / "config"
PYTHON, STUDIES = all_blocks("python"), all_blocks("yaml")
# What a snippet has that takes ten seconds and more; it is run with the patient tests.
PATIENT = ("vp.prove_knock(", "LocalCluster(", "fold_omega_up", 'tolerance={"delta"')


def lines(text: str) -> list[str]:
    return [line.rstrip() for line in text.strip().splitlines()]


@pytest.mark.parametrize(
    "block",
    [
        pytest.param(block, marks=pytest.mark.slow)
        if any(call in block.text for call in PATIENT)
        else block
        for block in PYTHON
    ],
    ids=str,
)
def test_a_snippet_runs_and_prints_what_is_shown(
    block: Block, folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(folder)
    exec(compile(block.text, str(block), "exec"), {"__name__": "__main__"})
    printed = capsys.readouterr().out
    assert printed.strip()
    assert "nan" not in printed
    if block.output is not None:
        assert lines(printed) == lines(block.output)


@pytest.mark.parametrize("block", STUDIES, ids=str)
def test_a_study_is_valid(block: Block, tmp_path: Path) -> None:
    path = tmp_path / "mine.yaml"
    path.write_text(block.text, encoding="utf-8")
    for table in CONFIG.glob("*.csv"):  # the documents name those
        shutil.copy(table, tmp_path)
    assert load_study(path).scenes


def test_the_tutorial_ends_with_a_pdf(folder: Path) -> None:
    study, results = load_study(folder / "mine.yaml"), folder / "results"
    draw_study(study, results)
    build_report(study, results, results / "mine/report.pdf")
    shown = [name for name in Page("docs/tutorial.md").quoted if name.startswith("figures/")]
    assert shown
    for name in ("report.pdf", "detail.json", *shown):
        assert (results / "mine" / name).is_file(), name


def test_it_is_short() -> None:
    assert len(README.text.splitlines()) <= 150


def test_the_queries_return_what_their_comments_state(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(folder)
    names: dict = {}
    exec(README.blocks("python")[0].text, names)
    rows = names["rows"].compute()
    velocities = [
        np.nanmax(rows.impact_velocity_max.values[index])
        for index in np.ndindex(rows.regime.shape)
        if rows.period_multiple.values[index] == 1
        and (rows.impacts_per_orbit.values[index] == 1).all()
        and rows.stable.values[index] == 1
    ]
    assert names["hardest"].max().item() == max(velocities)
    doubled = names["doubled"]
    twice = rows.period_multiple == 2
    assert twice.any()
    for nu in rows.nu.values:
        of_nu = rows.f.values[twice.sel(nu=nu).values]
        expected = of_nu.min() if of_nu.size else float("nan")
        assert doubled.sel(nu=nu).item() == pytest.approx(expected, nan_ok=True)


def test_its_study_is_short(tmp_path: Path) -> None:
    (block,) = README.blocks("yaml")
    path = tmp_path / "mine.yaml"
    path.write_text(block.text, encoding="utf-8")
    assert load_study(path).scene("response").row_count == 541 * 3
    assert len([line for line in block.text.splitlines() if line.strip()]) <= 12


def test_the_pictures_that_it_names_fit_its_study(tmp_path: Path) -> None:
    (block,) = README.blocks("yaml")
    (figure,) = (text for text in README.quoted if text.startswith("figure: "))
    path = tmp_path / "mine.yaml"
    path.write_text(f"{block.text}    {figure}\n", encoding="utf-8")
    assert load_study(path).scene("response").figure.pictures


def test_its_two_commands() -> None:
    make, test = (block.text for block in README.blocks("sh"))
    for command in (make, test):
        words = shlex.split(command)
        assert (ROOT / words[words.index("-c") + 1]).is_file()
    assert make.rstrip().endswith("snakemake --cores 2")
    *_, last_check = (ROOT / ".ci/run").read_text(encoding="utf-8").split("\nstep ")
    assert test.rstrip().endswith(f"&& {last_check.rstrip()}")
    assert last_check.startswith("pytest ")


def shown(book: Any) -> list[Any]:
    """Return what each cell of code prints, and how many pictures it draws."""
    return [
        (
            [output.text for output in cell.outputs if output.output_type == "stream"],
            [output.data.get("text/plain", "") for output in cell.outputs if "data" in output],
            sum("image/png" in output.get("data", {}) for output in cell.outputs),
        )
        for cell in book.cells
        if cell.cell_type == "code"
    ]


def without_sizes(cells: list[Any]) -> list[Any]:
    """Leave out the text of a figure, which stands beside its picture."""
    return [
        (printed, [text for text in values if "Figure" not in text], drawn)
        for printed, values, drawn in cells
    ]


def test_what_the_notebook_shows_is_what_its_cells_give() -> None:
    cells = without_sizes(shown(stored()))
    assert without_sizes(shown(executed())) == cells
    assert sum(drawn for *_, drawn in cells) == 5
    assert len(cells) > 7


def test_links_of_the_notebook_lead_to_files() -> None:
    text = "\n".join(cell.source for cell in stored().cells if cell.cell_type == "markdown")
    links = re.findall(r"\]\(([^)#]+)", text)
    assert links
    for link in links:
        assert (NOTEBOOK.parent / link).is_file()
