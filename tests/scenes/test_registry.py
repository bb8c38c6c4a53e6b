"""A kind of scene is a folder: a kind of these tests goes from YAML to PDF, and no module tests for a kind."""

import ast
from pathlib import Path

import numpy as np
import pendulum
import pytest
from command_line import run

import vibropipe as vp
from vibropipe.jobs.verify import verify
from vibropipe.scenes.registry import kinds, registered
from vibropipe.study import StudyError, json_schema, load_study, table_of_keys

STUDY = """
title: A clock
scenes:
  swing: {kind: pendulum, amplitude: {start: 0.1, stop: 2, points: 20}}
  motion: {kind: motion, exciter: {l: 0.5, nu: 1, f: -1}, tau_end: 5}
"""
PACKAGE = Path(vp.__file__).parent


@pytest.fixture
def known():
    with registered(pendulum.KIND):
        yield


@pytest.fixture
def folder(tmp_path, monkeypatch, known):
    monkeypatch.chdir(tmp_path)
    tmp_path.joinpath("clock.yaml").write_text(STUDY)
    return tmp_path


def test_a_kind_from_a_folder_of_tests_goes_from_yaml_to_pdf(folder, capsys):
    assert run("plan", "clock.yaml") == 0
    assert "20 amplitude" in capsys.readouterr().out
    for name in ("swing", "motion"):
        output = f"results/clock/{name}.nc"
        assert run("solve", "clock.yaml", "--scene", name, "--output", output) == 0
    assert run("figure", "clock.yaml") == 0
    assert run("report", "clock.yaml", "--output", "results/clock/report.pdf") == 0
    assert Path("results/clock/report.pdf").read_bytes().startswith(b"%PDF-")
    assert all(verdict.good and verdict.checked for verdict in verify("results/clock"))
    swing = vp.open_study("results/clock")["swing"]
    # the first terms of the series in the amplitude
    small = 2 * np.pi / np.sqrt(9.81) * (1 + 0.1**2 / 16 + 11 * 0.1**4 / 3072)
    assert float(swing["period"][0]) == pytest.approx(small, rel=1e-8)
    assert swing.attrs["kind"] == "pendulum"
    assert swing.attrs["kind_hash"] == pendulum.KIND.code_hash


def test_its_keys_are_checked_and_documented(folder):
    text = STUDY.replace("kind: pendulum", "kind: pendulum, exciter: {h: 1}, gravity: 0")
    Path("clock.yaml").write_text(text)
    with pytest.raises(StudyError) as error:
        load_study("clock.yaml")
    assert sorted(str(error.value).splitlines()) == [
        "clock.yaml: scenes.swing.exciter.h: must be left out, since a pendulum has no exciter, got 1.0",
        "clock.yaml: scenes.swing.gravity: must be a number above 0 up to 100, got 0",
    ]
    assert "### `kind: pendulum`" in table_of_keys()
    assert "PendulumScene" in json_schema()["$defs"]


def test_it_is_gone_with_its_registration(tmp_path):
    assert "pendulum" not in kinds()
    file = tmp_path / "clock.yaml"
    file.write_text(STUDY)
    with pytest.raises(
        StudyError, match=r"swing.kind: must be one of motion, sweep, .*, got 'pendulum'"
    ):
        load_study(file)


def test_two_kinds_of_one_name_are_refused(known):
    with pytest.raises(ValueError, match="a kind 'pendulum' already"), registered(pendulum.KIND):
        pass


def test_no_module_tests_which_kind_a_scene_is():
    tests_of_kind = [
        f"{path.relative_to(PACKAGE)}:{node.lineno}"
        for path in PACKAGE.rglob("*.py")
        for node in ast.walk(ast.parse(path.read_text()))
        if isinstance(node, ast.Call)
        and isinstance(node.func, ast.Name)
        and node.func.id in ("isinstance", "issubclass")
        and any(
            isinstance(name, ast.Name) and name.id.endswith("Scene") and name.id != "BaseScene"
            for name in ast.walk(node.args[1])
        )
    ]
    assert tests_of_kind == []
