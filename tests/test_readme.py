"""The README's own snippets run, its study is valid, and its commands name what exists."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import numpy as np
import pytest

from vibropipe.jobs.solving import solve_to_file
from vibropipe.study import load_study

ROOT = Path(__file__).parents[1]
README = (ROOT / "README.md").read_text(encoding="utf-8")


def blocks(language: str) -> list[str]:
    return re.findall(rf"^```{language}\n(.*?)^```", README, re.MULTILINE | re.DOTALL)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a coarse copy of the study that the queries ask."""
    folder = tmp_path_factory.mktemp("readme")
    text = (
        (ROOT / "config/regimes.yaml")
        .read_text(encoding="utf-8")
        .replace("points: 200", "points: 24")
    )
    study_file = folder / "regimes.yaml"
    study_file.write_text(text, encoding="utf-8")
    results = folder / "results/regimes"
    results.mkdir(parents=True)
    solve_to_file(load_study(study_file), "regime_map", results / "regime_map.nc", None, 1)
    return folder


@pytest.mark.parametrize("number", range(len(blocks("python"))))
def test_a_snippet_runs_as_it_stands(
    number: int, folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(folder)
    names: dict[str, object] = {"__name__": "__main__"}
    exec(compile(blocks("python")[number], f"README snippet {number}", "exec"), names)
    said = capsys.readouterr().out
    assert said.strip()
    assert "nan" not in said


def test_the_queries_answer_what_their_comments_say(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(folder)
    names: dict = {}
    exec(blocks("python")[0], names)
    rows = names["rows"].compute()
    known = [
        np.nanmax(rows.impact_velocity_max.values[place])
        for place in np.ndindex(rows.regime.shape)
        if rows.period_multiple.values[place] == 1
        and (rows.impacts_per_orbit.values[place] == 1).all()
        and rows.stable.values[place] == 1
    ]
    assert names["hardest"].max().item() == max(known)
    doubled = names["doubled"]
    twice = rows.period_multiple == 2
    assert twice.any()
    for nu in rows.nu.values:
        of_nu = rows.f.values[twice.sel(nu=nu).values]
        expected = of_nu.min() if of_nu.size else float("nan")
        assert doubled.sel(nu=nu).item() == pytest.approx(expected, nan_ok=True)


def test_its_study_is_valid(tmp_path: Path) -> None:
    (text,) = blocks("yaml")
    path = tmp_path / "mine.yaml"
    path.write_text(text, encoding="utf-8")
    assert load_study(path).scene("response").row_count == 541 * 3
    assert len([line for line in text.splitlines() if line.strip()]) <= 12


def test_its_commands_name_what_exists() -> None:
    make, test = blocks("sh")
    for command in (make, test):
        words = shlex.split(command)
        assert (ROOT / words[words.index("-c") + 1]).is_file()
    assert make.rstrip().endswith("snakemake --cores 2")
    *_, last_check = (ROOT / ".ci/run").read_text(encoding="utf-8").split("\nstep ")
    assert test.rstrip().endswith(f"&& {last_check.rstrip()}")
    assert last_check.startswith("pytest ")
    for name in re.findall(
        r"`((?:vibropipe|tests|workflow|config|results|kernels|physics|study|batch)/[\w./]*)`",
        README,
    ):
        assert is_there(name), name


def is_there(name: str) -> bool:
    """A path of the tree or of the package, what a run makes, or a function as folder/module.function."""
    if name.startswith("results/") or name == "config/mine.yaml":
        return True
    if (ROOT / name).exists() or (ROOT / "vibropipe" / name).exists():
        return True
    module, _dot, function = name.rpartition(".")
    source = ROOT / "vibropipe" / f"{module}.py"
    return source.is_file() and f"\ndef {function}(" in source.read_text(encoding="utf-8")
