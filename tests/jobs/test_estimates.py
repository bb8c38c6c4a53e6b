"""Estimates of time and disk space against the values measured on this machine."""

from __future__ import annotations

import signal
import time
from dataclasses import asdict
from types import SimpleNamespace

import pytest

from vibropipe.compiler import cache
from vibropipe.jobs import estimates
from vibropipe.jobs.estimates import (
    DEADLINE,
    Estimates,
    estimate_study,
    load_estimate,
    save_estimates,
)
from vibropipe.jobs.solving import join_to_file, solve_scene, solve_to_file
from vibropipe.jobs.terminal_tables import (
    COMPILE_SECONDS,
    FIGURE_SECONDS,
    REPORT_SECONDS,
    START_SECONDS,
    plan_text,
    run_seconds,
)
from vibropipe.lab import work_precision
from vibropipe.scenes.costs import Estimate, sampling
from vibropipe.scenes.registry import kind_of
from vibropipe.scenes.sweep.plan import growing_samples
from vibropipe.store import read_sidecar, write
from vibropipe.study import fingerprint, load_study
from vibropipe.words.measurements import OWN_METHODS

TEXT = """
title: Estimated and measured
exciter: {l: 0.5, nu: 1, f: -1, h: 0.2, R1: 0.7, R2: 0.7}
scenes:
  grid:
    kind: sweep
    over:
      nu: {start: 0.5, stop: 2, points: 60}
      f: {start: 0.1, stop: 2, points: 60}
  followed:
    kind: sweep
    over:
      f: [0.2, 0.5, 1]
      nu: {start: 0.5, stop: 2, points: 400}
    follow: {along: nu, direction: up}
  coarse:
    kind: motion
    exciter: {h: 10, nu: 0.1, f: 0.5, l: 0.5}
    tau_end: 500
    solver: {accuracy: 1e-2}
  long:
    kind: motion
    tau_end: 100000
    samples_per_period: 16
  curves:
    kind: backbone
    delta_over_l: [0, 0.1]
    tau_bar: {start: 1, stop: 6, points: 500}
  cases:
    kind: hard_cases
    cases: [ideal_free, damping, split]
  race:
    kind: accuracy
    motions:
      plain: {}
      chatter: {exciter: {nu: 0.3, f: 1.5}, periods: 2}
    methods: [newmark, exact, RK45, Radau]
    steps_per_period: [64, 4096]
    tolerances: [1e-6]
  costs:
    kind: effects
    motions:
      full: {exciter: {nu: 0.3, f: 1.5}}
      plain: {}
      row: {of: row, outputs: [harmonics]}
"""


@pytest.fixture
def study(tmp_path):
    file = tmp_path / "cost.yaml"
    file.write_text(TEXT)
    return load_study(file)


@pytest.fixture
def own_cache(tmp_path, monkeypatch):
    monkeypatch.setattr(estimates, "cache_folder", lambda: tmp_path / "kernels")
    (tmp_path / "kernels").mkdir()
    return tmp_path / "kernels"


@pytest.mark.slow
def test_the_bytes_expected_are_those_on_disk_within_bounds(study, own_cache, tmp_path):
    estimate = estimate_study(study, 60.0).by_scene
    for name in study.scenes:
        file = tmp_path / f"{name}.nc"
        write(solve_scene(study, name), file)
        assert estimate[name].bytes / 3 < file.stat().st_size < 3 * estimate[name].bytes + 2e4, name


@pytest.mark.benchmark
def test_the_time_expected_is_what_is_taken_within_bounds(study, own_cache, tmp_path):
    """Within a factor of 2 and 0.2 s, in CPU time of this process, since the machine may be busy."""
    for name in study.scenes:  # compiles what is missing
        solve_scene(study, name)
    estimate = estimate_study(study, 60.0).by_scene
    with sampling(lambda scene, path: None):
        for name in study.scenes:
            begin, file = time.process_time(), tmp_path / f"{name}.nc"
            write(solve_scene(study, name), file)
            elapsed, core = time.process_time() - begin, estimate[name].core_seconds
            assert core / 2 - 0.2 < elapsed < 2 * core + 0.2, (
                f"{name}: {core} s estimated, {elapsed} s measured"
            )


@pytest.mark.benchmark
def test_a_race_without_peers_is_expected_to_be_shorter(study, own_cache, monkeypatch):
    with_peers = estimate_study(study, 60.0).by_scene["race"].core_seconds
    monkeypatch.setattr(work_precision, "is_installed", lambda method: method in OWN_METHODS)
    alone = estimate_study(study, 60.0).by_scene["race"].core_seconds
    assert alone < with_peers / 2
    begin = time.process_time()
    solve_scene(study, "race")
    elapsed = time.process_time() - begin
    assert alone / 2 - 0.2 < elapsed < 2 * alone + 0.2


@pytest.mark.benchmark
def test_a_calibration_is_short(study, own_cache):
    estimate_study(study)
    begin = time.monotonic()
    estimate_study(study)
    assert time.monotonic() - begin < DEADLINE + 1.0


@pytest.mark.slow
def test_an_estimate_has_the_method_chosen(study):
    with sampling(estimates._solve_to_file) as sampler:
        sampler.budget = 1.0
        scene = study.scene("coarse")
        found = kind_of(scene).estimate(scene, sampler)  # compiles what is missing
    assert found.method.startswith("newmark, ")
    assert found.method.endswith(" steps for 0.01")
    assert asdict(estimate_study(study, 60.0).by_scene["coarse"]) | {"core_seconds": 0} == (
        asdict(found) | {"core_seconds": 0, "load_seconds": pytest.approx(0.7, abs=1.0)}
    )


def test_the_plan_names_the_method_chosen_and_the_time_on_this_machine(study):
    estimate = Estimate(3.0, 0.5, 2e5, False, "newmark, 40 steps for 0.01")
    text = plan_text(study, Estimates(dict.fromkeys(study.scenes, estimate)))
    line = next(line for line in text.splitlines() if line.startswith("coarse"))
    assert "newmark, 40 steps for 0.01" in line
    assert "on disk" in text.splitlines()[1]
    assert "estimated on this machine, with figures and report: 42 s on one core" in text
    rough = plan_text(study)
    assert "accuracy 0.01" in rough
    assert "estimated" not in rough


def busy(scene, sampler):
    while True:
        pass


def busy_in_a_kernel(scene, sampler):
    signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGALRM})
    busy(scene, sampler)


def compiling(scene, sampler):
    for callback in cache.on_compiling:
        callback("a.kernel")


def broken(scene, sampler):
    raise ValueError


@pytest.mark.parametrize("cost", [busy, busy_in_a_kernel, compiling, broken])
def test_a_plan_is_soon_there_whatever_a_sample_does(study, own_cache, monkeypatch, cost):
    kind = SimpleNamespace(solve=None, estimate=cost)
    monkeypatch.setattr(estimates, "kind_of", lambda scene: kind)
    monkeypatch.setattr(estimates, "MAX_LOAD_SECONDS", 0.0)
    monkeypatch.setattr(cache, "on_compiling", estimates.on_compiling)
    begin = time.monotonic()
    found = estimate_study(study, 2.0)
    assert time.monotonic() - begin < 4.0
    assert found.rough == tuple(study.scenes)
    assert found.uncompiled == (found.rough if cost is compiling else ())
    assert ("grid" in found.long) == (cost is busy)
    text = plan_text(study, found)
    assert "costs is rough: no sample was solved" in text
    assert ("compiling kernels for grid, followed, coarse" in text) == (cost is compiling)
    assert ("at least" in text) == (cost is busy)


def test_a_run_takes_longer_by_figures_report_and_compiling():
    plans = [SimpleNamespace(name=n, kind=n, shards=1, is_parallel=False) for n in ("a", "b")]
    work = {"a": 30.0, "b": 10.0}
    alone, shared = (run_seconds(plans, work, 4, (), cores) for cores in (1, 2))
    assert alone == 40 + START_SECONDS + 4 * FIGURE_SECONDS + REPORT_SECONDS
    assert shared == 30 + START_SECONDS + 2 * FIGURE_SECONDS + REPORT_SECONDS
    assert run_seconds(plans, work, 4, ("a", "b"), 1) == alone + 2 * COMPILE_SECONDS
    assert run_seconds(plans, work, 4, ("a", "b"), 2) == shared + COMPILE_SECONDS


def test_samples_grow_to_the_whole_and_lie_in_it(study):
    for name in ("grid", "followed"):
        scene = study.scene(name)
        counts = []
        for sample in growing_samples(scene):
            counts.append(sample.row_count)
            for key, values in sample.over_arrays().items():
                assert set(values) <= set(scene.over_arrays()[key])
            assert list(sample.over_arrays()) == list(scene.over_arrays())
        assert counts == sorted(counts)
        assert counts[0] <= 128
        assert counts[-1] == scene.row_count


def test_a_followed_parameter_is_sampled_in_one_piece(study):
    scene = study.scene("followed")
    whole = scene.over_arrays()["nu"].tolist()
    part = next(growing_samples(scene)).over_arrays()["nu"].tolist()
    assert whole[whole.index(part[0]) :][: len(part)] == part


def test_jobs_find_what_was_expected_of_them(study, own_cache, tmp_path):
    save_estimates({fingerprint(study, "followed"): Estimate(6.0, 0.5, 1e5, True, "exact")})
    solve_to_file(study, "followed", tmp_path / "whole.nc", None, 2)
    assert read_sidecar(tmp_path / "whole.nc")["expected_seconds"] == pytest.approx(3.5)
    parts = [tmp_path / f"{i}.nc" for i in (1, 2, 3)]
    for i, path in enumerate(parts):
        solve_to_file(study, "followed", path, (i + 1, 3), 1)
    assert read_sidecar(parts[0])["expected_seconds"] == pytest.approx(2.5)
    join_to_file(study, "followed", parts, tmp_path / "joined.nc")
    assert read_sidecar(tmp_path / "joined.nc")["expected_seconds"] == pytest.approx(7.5)
    solve_to_file(study, "coarse", tmp_path / "coarse.nc", None, 1)
    assert "expected_seconds" not in read_sidecar(tmp_path / "coarse.nc")


def test_expectations_outlive_others_and_nonsense(own_cache):
    one, two = Estimate(1.0, 0.5, 2.0, False, "exact"), Estimate(2.0, 0.5, 2.0, True, "exact")
    save_estimates({"one": one})
    save_estimates({"two": two})
    assert (load_estimate("one"), load_estimate("two"), load_estimate("three")) == (one, two, None)
    for nonsense in ("[1]", "{", '{"one": {"core": 1}}', '{"one": 3}'):
        (own_cache / "expected.json").write_text(nonsense)
        assert load_estimate("one") is None
    save_estimates({"one": one})
    assert asdict(load_estimate("one")) == asdict(one)


def test_threads_share_a_sweep_but_no_motion():
    assert Estimate(6.0, 1.0, 0.0, True, "").seconds(3) == 3.0
    assert Estimate(6.0, 1.0, 0.0, False, "").seconds(3) == 7.0
    assert Estimate(6.0, 1.0, 0.0, True, "").seconds(1, share=0.5) == 4.0
