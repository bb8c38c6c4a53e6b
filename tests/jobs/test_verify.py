"""Verification of datasets: equal ones, and every way in which one can differ."""

import json
import shutil
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from command_line import run
from sampling import sampled

from vibropipe.jobs.solving import join_to_file, solve_to_file
from vibropipe.jobs.verify import verify
from vibropipe.store import load, save
from vibropipe.study import load_study

STUDY = """\
title: A study of seconds
exciter: {l: 0.5, nu: 1, f: -1, h: 0.2, R1: 0.7, R2: 0.7}
scenes:
  forced: {kind: motion, tau_end: 20, samples_per_period: 16}
  curves: {kind: backbone, delta_over_l: [0, 0.2], tau_bar: {start: 2.5, stop: 6, points: 15}}
  free: {kind: backbone, amplitude: [0.3, 0.6, 0.7, 0.8]}
  followed:
    kind: sweep
    over: {nu: [0.9, 1, 1.1, 1.2], f: [0.2, 0.6, 1]}
    follow: {along: nu, direction: down}
  response: {kind: sweep, over: {f: [0.2, 1], nu: [0.9, 1, 1.1]}}
  borders: {kind: boundary, of: [grazing], over: {nu: [0.8, 2], f: [0.05, 1]}, lines: 1}
  laws: {kind: branch, along: {nu: {from: 1.05, to: 1.2}}, over: {f: [0.25, 0.5]}}
  cases: {kind: hard_cases, cases: [plastic_for_ever, coexisting]}
  race:
    kind: accuracy
    methods: [newmark, exact]
    steps_per_period: [16, 32]
    repeats: 2
    motions: {struck: {periods: 2}, quiet: {exciter: {f: 0.1}, periods: 2}}
  costs:
    kind: effects
    repeats: 2
    motions: {full: {exciter: {nu: 0.3, f: 1.5}, periods: 4}, struck: {periods: 8}}
"""
SCENES = (
    "borders",
    "cases",
    "costs",
    "curves",
    "followed",
    "forced",
    "free",
    "laws",
    "race",
    "response",
)


@pytest.fixture(scope="module")
def solved(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Results of every kind of scene, moved away from their study."""
    folder = tmp_path_factory.mktemp("solved")
    file = folder / "tiny.yaml"
    file.write_text(STUDY)
    study = load_study(file)
    for name in study.scenes:
        solve_to_file(study, name, folder / "results" / f"{name}.nc", None, 2)
    moved = tmp_path_factory.mktemp("elsewhere") / "under another name"
    shutil.move(folder / "results", moved)
    file.unlink()
    return moved


@pytest.fixture
def results(solved: Path, tmp_path: Path) -> Path:
    """A copy that a test may change."""
    return Path(shutil.copytree(solved, tmp_path / "results"))


def changed(path: Path, **attrs: str) -> None:
    """Change attributes of a file and renew its checksum."""
    save(load(path).assign_attrs(attrs), path)


def test_every_kind_of_scene_is_the_same_again_wherever_it_lies(solved, capsys):
    assert run("verify", solved, "--seed", 1) == 0
    printed = capsys.readouterr().out
    for name, checked in zip(
        SCENES,
        (*["all of it"] * 4, "all 12 rows", *["all of it"] * 4, "all 6 rows"),
        strict=True,
    ):  # fmt: skip
        assert f"{name}: {checked}: same, bit for bit\n" in printed
    assert "not compared: times" in printed
    assert printed.endswith("sample: --rows 100 --seed 1\n")


def test_a_sample_is_of_whole_chains_and_repeated_by_its_seed(solved):
    def verdicts(seed: int) -> list[str]:
        return [str(verdict) for verdict in verify(solved, rows=2, seed=seed)]

    assert verdicts(7) == verdicts(7)
    assert {line.splitlines()[0] for line in verdicts(7)} >= {
        "followed: 4 of 12 rows: same, bit for bit",
        "response: 2 of 6 rows: same, bit for bit",
        "free: all of it: same, bit for bit",
    }


@pytest.mark.parametrize(
    ("scene", "quantity"),
    [
        ("forced", "velocity"), ("response", "impact_velocity"), ("race", "error_end"),
        *sampled(
            [
                ("curves", "velocity_over_l"), ("free", "displacement_mean"), ("response", "nu"),
                ("followed", "displacement_mean"), ("cases", "measured"),
            ]
        ),
    ],
)  # fmt: skip
def test_one_changed_bit_is_found_though_the_checksum_is_right(scene, quantity, results, capsys):
    path = results / f"{scene}.nc"
    dataset = load(path)
    values = dataset[quantity].values.copy()
    index = tuple(int(i) for i in np.argwhere(np.isfinite(values))[-1])
    values[index] = np.nextafter(values[index], np.inf)
    save(
        dataset.assign({quantity: (dataset[quantity].dims, values, dataset[quantity].attrs)}), path
    )
    assert run("verify", results) == 1
    printed = capsys.readouterr().out
    assert f"{scene}: " in printed
    assert f"  {quantity}" in printed
    assert "in the file" in printed
    assert printed.count("same, bit for bit") == len(SCENES) - 1


def test_a_damaged_file_is_reported_and_the_others_are_verified(results, capsys):
    whole = (results / "free.nc").read_bytes()
    (results / "free.nc").write_bytes(whole[:-5])
    flipped = bytearray((results / "forced.nc").read_bytes())
    flipped[len(flipped) // 2] ^= 1
    (results / "forced.nc").write_bytes(flipped)
    assert run("verify", results) == 1
    printed = capsys.readouterr().out
    assert "free.nc: is truncated" in printed
    assert "forced.nc: is damaged (its checksum does not match)" in printed
    assert printed.count("same, bit for bit") == len(SCENES) - 2


def test_another_code_or_machine_is_named_as_the_reason(results, capsys):
    path = results / "forced.nc"
    versions = json.loads(load(path).attrs["versions"]) | {"numba": "0.1"}
    changed(path, kernel_hash="0123456789abcdef", versions=json.dumps(versions), machine="z80")
    assert run("verify", path) == 0
    printed = capsys.readouterr().out
    assert (
        "differences are possible on this system: kernel hash was 0123456789abcdef, here "
        in printed
    )
    assert "machine was z80, here " in printed
    assert "numba was 0.1, here " in printed

    dataset = load(path)
    save(dataset.assign(displacement=dataset["displacement"] + 1), path)
    assert run("verify", path) == 1
    assert "differences are expected on this system: kernel hash was" in capsys.readouterr().out


def test_a_joined_dataset_names_the_machines_that_solved_it(tmp_path, capsys):
    file, shards = tmp_path / "tiny.yaml", [tmp_path / "1.nc", tmp_path / "2.nc"]
    file.write_text(STUDY)
    study = load_study(file)
    for number, shard in enumerate(shards, 1):
        solve_to_file(study, "response", shard, (number, 2), 1)
    changed(shards[1], machine="z80")
    join_to_file(study, "response", shards, tmp_path / "response.nc")
    assert run("verify", tmp_path / "response.nc") == 0
    printed = capsys.readouterr().out
    assert "response: all 6 rows: same, bit for bit" in printed
    assert "machine was " in printed
    assert " and z80, here " in printed
    assert run("verify", shards[0]) == 0
    assert "1: not verified\n  not compared: is a shard" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("attrs", "words"),
    [
        ({"study": STUDY.replace("tau_end: 20", "tau_end: 21")}, "study_hash differs"),
        (
            {"title": "tiny: other"},
            "title: must name a scene of the study in the file, got 'tiny: other'",
        ),
    ],
)
def test_an_origin_that_contradicts_itself_is_a_fault(attrs, words, results, capsys):
    changed(results / "forced.nc", **attrs)
    assert run("verify", results / "forced.nc") == 1
    assert words in capsys.readouterr().out


def test_what_has_no_origin_is_not_verified(tmp_path, capsys):
    save(xr.Dataset({"displacement_end": ((), 0.25)}), tmp_path / "bare.nc")
    assert run("verify", tmp_path) == 0
    printed = capsys.readouterr().out
    assert "bare: not verified" in printed
    assert "contains no study text, so it cannot be recomputed" in printed


@pytest.mark.parametrize("folder", ["absent", "empty"])
def test_no_study_is_one_message_and_exit_code_2(folder, tmp_path, capsys):
    (tmp_path / "empty").mkdir()
    assert run("verify", tmp_path / folder) == 2
    printed = capsys.readouterr()
    assert not printed.out
    assert folder in printed.err
    assert "solve the study first" in printed.err


def test_a_scene_that_the_study_no_longer_has_is_named(tmp_path, capsys):
    file, results = tmp_path / "tiny.yaml", tmp_path / "results"
    moments = {"detail": "2026-01-01T00:00:00+00:00", "closeup": "2026-01-01T00:00:01+00:00"}
    for name, moment in moments.items():
        scene = "{kind: motion, tau_end: 5, samples_per_period: 16}"
        file.write_text(
            f"title: T\nexciter: {{l: 0.5, nu: 1, f: -1}}\nscenes:\n  {name}: {scene}\n"
        )
        solve_to_file(load_study(file), name, results / f"{name}.nc", None, 1)
        sidecar = results / f"{name}.json"
        sidecar.write_text(json.dumps(json.loads(sidecar.read_text()) | {"finished": moment}))
    assert run("verify", results, "--seed", 1) == 0
    closeup, detail, left, _ = capsys.readouterr().out.splitlines()
    assert closeup.startswith("closeup: ")
    assert detail.startswith("detail: ")
    newest = "the study that made closeup, the newest dataset"
    assert left == f"  not in {newest}: delete it if the study no longer has it"
    # one file alone says nothing of the study as it is now
    assert run("verify", results / "detail.nc", "--seed", 1) == 0
    assert "no longer" not in capsys.readouterr().out
