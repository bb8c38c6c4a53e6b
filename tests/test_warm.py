"""Compiling ahead: each kind of work once, in miniature."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from vibropipe import warmed
from vibropipe.study import fingerprint, load_study
from vibropipe.warm import miniature, not_calibrated, not_compiled, work_of
from vibropipe.warmed import note

CONFIG = Path(__file__).parents[1] / "config"
STUDY = """\
title: All kinds of work
exciter: {l: 0.5, f: -1, h: 0.2, R1: 0.7}
scenes:
  exact: {kind: motion}
  longer: {kind: motion, tau_end: 1e6, exciter: {R1: 0.5}}
  settled: {kind: motion, settle_periods: 1000}
  newmark: {kind: motion, solver: {method: newmark, steps_per_period: 100}}
  finer: {kind: motion, solver: {method: newmark, steps_per_period: 200}}
  ends: {kind: motion, outputs: [impacts]}
  unforced: {kind: motion, exciter: {f: 0}}
  sweep: {kind: sweep, over: {nu: {start: 0.5, stop: 2, points: 500}}}
  other: {kind: sweep, over: {f: [1, 2, 3]}, harmonics: 7, outputs: [stability, impacts, harmonics]}
  energy: {kind: sweep, over: {f: [1, 2, 3]}, outputs: [energy]}
  curves: {kind: backbone, delta_over_l: [0, 0.1], tau_bar: {start: 2, stop: 6, points: 900}}
  free: {kind: backbone, amplitude: {start: 0.1, stop: 2, points: 900}}
"""


@pytest.fixture
def study(tmp_path):
    file = tmp_path / "works.yaml"
    file.write_text(STUDY)
    return load_study(file)


def test_scenes_that_differ_in_numbers_only_are_one_work(study):
    works = {name: work_of(scene) for name, scene in study.scenes.items()}
    assert works["exact"] == works["longer"]
    assert works["newmark"] == works["finer"]
    assert works["sweep"] == works["other"]
    assert len(set(works.values())) == len(works) - 3


def test_a_miniature_is_the_same_work_and_little_of_it(study):
    for scene in study.scenes.values():
        small = miniature(scene)
        assert work_of(small) == work_of(scene)
        assert small.row_count <= 100
        assert small.kind != "motion" or small.tau_span()[1] < 20
        assert small.resolved_exciter() == scene.resolved_exciter()


def test_only_what_was_not_compiled_before_is_compiled(study, tmp_path, monkeypatch):
    monkeypatch.setattr(warmed, "cache_folder", lambda: tmp_path)
    file = Path(study.source)
    works = not_compiled([file])
    assert set(works) == {work_of(scene) for scene in study.scenes.values()}
    note(works)
    assert not_compiled([file]) == {}
    file.write_text(
        STUDY + "  both: {kind: sweep, over: {f: [1, 2]}, outputs: [energy, impacts]}\n"
    )
    ((_, scene, _),) = not_compiled([file]).values()
    assert scene == "both"
    monkeypatch.setenv("NUMBA_CPU_NAME", "generic")
    assert set(not_compiled([file])) > set(works)


def test_a_study_is_calibrated_until_all_its_scenes_are(study, tmp_path, monkeypatch):
    monkeypatch.setattr(warmed, "cache_folder", lambda: tmp_path)
    file = Path(study.source)
    first, *others = [fingerprint(study, name) for name in study.scenes]
    assert not_calibrated([file]) == [file]
    note(others)
    assert not_calibrated([file]) == [file]
    note([first])
    assert not_calibrated([file]) == []
    file.write_text(STUDY.replace("1e6", "1e5"))
    assert not_calibrated([file]) == [file]


@pytest.mark.slow
def test_jobs_after_warm_compile_nothing(tmp_path):
    """From an empty cache; a minute."""
    cache = tmp_path / "cache"
    environment = os.environ | {"VIBROPIPE_CACHE_DIR": str(cache)}
    code = "from vibropipe.cli import main; main()"

    def vibropipe(*arguments: object) -> set[Path]:
        command = [sys.executable, "-c", code, *map(str, arguments)]
        subprocess.run(command, env=environment, check=True)
        return {path for path in cache.rglob("*") if path.is_file()}

    file = CONFIG / "paper.yaml"
    compiled = vibropipe("warm", file)
    assert compiled
    for name in load_study(file).scenes:
        output = tmp_path / f"{name}.nc"
        assert vibropipe("solve", file, "--scene", name, "--output", output) == compiled
