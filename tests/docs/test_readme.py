"""The README is short, its queries return what their comments state, its two commands are those of the checks."""

from __future__ import annotations

import shlex
from pathlib import Path

import numpy as np
import pytest
from documents import README, ROOT

from vibropipe.study import load_study


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
