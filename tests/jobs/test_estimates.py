"""Estimates of time and disk space: rates of this machine, and the values that they are measured from."""

import time
from dataclasses import replace
from types import SimpleNamespace

import pytest

from vibropipe.jobs import plan as estimates
from vibropipe.jobs.plan import Estimate, Estimates, estimate_study, plan_scene, record, slowdown
from vibropipe.jobs.solving import solve_to_file
from vibropipe.jobs.terminal_tables import (
    COMPILE_SECONDS,
    COMPILE_SECONDS_FURTHER,
    FIGURE_SECONDS,
    REPORT_SECONDS,
    START_SECONDS,
    plan_text,
    run_seconds,
)
from vibropipe.scenes.costs import SLOWER
from vibropipe.study import fingerprint, study_of_text

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
def study():
    return study_of_text(TEXT, "cost")


@pytest.fixture
def rates_file(tmp_path, monkeypatch):
    """A machine on which nothing has been solved."""
    monkeypatch.setattr(estimates, "cache_root", lambda: tmp_path)
    return tmp_path / estimates.FILE_NAME


@pytest.fixture
def plan(study):
    return plan_scene(study.scene("grid"))


@pytest.mark.benchmark
def test_times_and_bytes_are_those_of_scenes_solved_before_within_bounds(
    study, rates_file, tmp_path
):
    """Times within a factor of 2 and 0.2 s, in CPU time of this process, since the machine may be busy."""
    for _ in range(2):  # the first compiles what is missing
        taken = {}
        for name in study.scenes:
            begin, file = time.process_time(), tmp_path / f"{name}.nc"
            solve_to_file(study, name, file, None, 1)
            taken[name] = time.process_time() - begin, file.stat().st_size
    found = estimate_study(study).by_scene
    for name, (seconds, size) in taken.items():
        assert found[name].seconds / 2 - 0.2 < seconds < 2 * found[name].seconds + 0.2, name
        assert found[name].bytes / 3 < size < 3 * found[name].bytes + 2e4, name


def test_a_fresh_machine_has_usual_rates(study, rates_file):
    found = estimate_study(study)
    assert found.rough == found.uncompiled == tuple(study.scenes)
    for name, scene in study.scenes.items():
        plan = plan_scene(scene)
        seconds = estimates.SCENE_SECONDS + slowdown() * plan.seconds
        assert found.by_scene[name] == pytest.approx((seconds, plan.bytes))


def test_motions_of_pieces_take_longer(study):
    sweep = study.scene("grid")
    rigid, soft = (
        plan_scene(sweep.model_copy(update={"effects": e})) for e in (["forcing"], ["soft"])
    )
    assert soft.seconds == SLOWER * rigid.seconds


def test_each_shard_loads(plan, rates_file):
    cut = replace(plan, seconds=10.0, shards=4)
    loading = estimates.SCENE_SECONDS + 4 * estimates.JOB_SECONDS
    assert estimates._estimate(cut, {}).seconds == pytest.approx(slowdown() * 10 + loading)


@pytest.mark.parametrize("share", [1.0, 0.25])
def test_what_solved_scenes_took_is_the_rate_of_their_kind(study, plan, rates_file, share):
    long = replace(plan, seconds=1000.0, bytes=1e9)
    for _ in range(3):
        record(long, share, share * 3000.0, share * 2e8)
    assert estimate_study(study).rough == tuple(
        name for name in study.scenes if name not in ("grid", "followed")
    )
    found = estimates._estimate(long, estimates._load()["rates"])
    assert found == pytest.approx((3000.0, 2e8), rel=0.02)
    soft = replace(long, effects=(*plan.effects, "soft"))
    assert estimates._estimate(soft, estimates._load()["rates"]) == estimates._estimate(soft, {})
    for _ in range(12):  # the machine has become slower
        record(long, 1.0, 9000.0, 2e8)
    assert estimates._estimate(long, estimates._load()["rates"]).seconds == pytest.approx(
        9000, rel=0.02
    )


def test_a_small_scene_does_not_make_a_rate(plan, rates_file):
    """It takes a thousand times as long as planned, since it has little work beside its beginning and its file."""
    small = replace(plan, seconds=1e-4, bytes=1e3)
    for _ in range(100):
        record(small, 1.0, estimates.SCENE_SECONDS + 0.5, 1e5)
    large = replace(plan, seconds=1e3, bytes=1e9)
    seconds, size = estimates._estimate(large, estimates._load()["rates"])
    assert seconds < 2e3 * max(1.0, slowdown())
    assert size < 2e9


def test_a_solved_scene_leaves_its_rate(study, rates_file, tmp_path):
    solve_to_file(study, "grid", tmp_path / "grid.nc", None, 1)
    rates = estimates._load()["rates"]
    plan = plan_scene(study.scene("grid"))
    _, seconds, size, stored = rates["sweep"]
    assert (seconds, size, stored) == (
        plan.seconds,
        (tmp_path / "grid.nc").stat().st_size,
        plan.bytes,
    )
    solve_to_file(study, "followed", tmp_path / "first.nc", (1, 3), 1)
    rows = plan_scene(study.scene("followed")).seconds / 3
    assert estimates._load()["rates"]["sweep"][1] == pytest.approx(
        estimates.MEMORY * seconds + rows
    )
    found = estimate_study(study)
    assert "grid" not in (*found.rough, *found.uncompiled)
    assert {"long", "costs"} <= {*found.rough} & {*found.uncompiled}


def test_another_version_keeps_the_rates_and_compiles_anew(study, plan, rates_file, monkeypatch):
    record(plan, 1.0, 1.0, 1e5)
    before = estimate_study(study)
    assert {"grid", "followed"}.isdisjoint(before.uncompiled)
    monkeypatch.setattr(estimates, "kernel_hash", lambda: "another")
    after = estimate_study(study)
    assert {"grid", "followed"} <= {*after.uncompiled}
    assert after.by_scene == before.by_scene
    assert after.rough == before.rough
    record(plan, 1.0, 1.0, 1e5)
    monkeypatch.undo()
    monkeypatch.setattr(estimates, "cache_root", lambda: rates_file.parent)
    assert estimate_study(study).uncompiled == before.uncompiled


def test_rates_outlive_nonsense_and_a_cache_that_cannot_be_written(
    study, plan, rates_file, monkeypatch
):
    for nonsense in ("[1]", "{", '{"rates": {"sweep": [1]}, "compiled": {}}', '{"rates": 3}'):
        rates_file.write_text(nonsense)
        assert estimate_study(study).rough == tuple(study.scenes)
    record(plan, 1.0, 1.0, 1e5)
    assert [*estimates._load()["rates"]] == ["sweep"]
    monkeypatch.setattr(estimates, "cache_root", lambda: rates_file)
    record(plan, 1.0, 1.0, 1e5)


def test_the_plan_says_what_its_times_include(study):
    found = dict.fromkeys(study.scenes, Estimate(3.5, 2e5))
    text = plan_text(study, Estimates(found))
    assert "on disk" in text.splitlines()[1]
    assert "estimated on this machine, with figures and report: 42 s on one core" in text
    assert "compiling" not in text
    assert "is rough" not in text
    text = plan_text(study, Estimates(found, rough=("grid", "race"), uncompiled=("race",)))
    assert "\nThis includes compiling kernels for race, once for this version." in text
    assert (
        "\nThe time of grid and race is rough: no such scene was solved on this machine yet."
        in text
    )
    rough = plan_text(study)
    assert "accuracy 0.01" in rough
    assert "estimated" not in rough


def test_a_run_takes_longer_by_figures_report_and_compiling():
    plans = [
        SimpleNamespace(name=n, kind=n, shards=1, is_parallel=False, effects=()) for n in ("a", "b")
    ]
    work = {"a": 30.0, "b": 10.0}
    alone, shared = (run_seconds(plans, work, 4, (), cores) for cores in (1, 2))
    assert alone == 40 + START_SECONDS + 4 * FIGURE_SECONDS + REPORT_SECONDS
    assert shared == 30 + START_SECONDS + 2 * FIGURE_SECONDS + REPORT_SECONDS
    assert run_seconds(plans, work, 4, ("a",), 1) == alone + COMPILE_SECONDS[False]
    both = COMPILE_SECONDS[False] + COMPILE_SECONDS_FURTHER[False]
    assert run_seconds(plans, work, 4, ("a", "b"), 1) == alone + both
    assert run_seconds(plans, work, 4, ("a", "b"), 2) == shared + both
    plans[1].effects = ("soft",)
    mixed = COMPILE_SECONDS[True] + COMPILE_SECONDS_FURTHER[False]
    assert run_seconds(plans, work, 4, ("a", "b"), 2) == shared + mixed
    plans[0].effects = ("friction",)
    soft = COMPILE_SECONDS[True] + COMPILE_SECONDS_FURTHER[True]
    assert run_seconds(plans, work, 4, ("a", "b"), 2) == shared + soft


def test_the_plan_does_not_pretend_to_know_what_a_search_finds():
    """Four kinds of curves with 24 lines over a wide range: 28,701 points, 35 s, where four curves were planned."""
    of = "[fold, flip, pitchfork, grazing]"
    text = (
        "title: wide\nexciter: {l: 0.5, h: 0.2, R1: 0.7, R2: 0.6}\nscenes:\n"
        f"  many: {{kind: boundary, of: {of}, over: {{nu: [0.3, 3], f: [0.05, 2]}}, lines: 24}}\n"
        f"  few: {{kind: boundary, of: {of}, over: {{nu: [0.3, 3], f: [0.05, 2]}}, lines: 12}}\n"
        "  one: {kind: motion, exciter: {nu: 1, f: 1}, tau_end: 10}\n"
    )
    study = study_of_text(text, "wide")
    found = estimate_study(study)
    told = "The time of many and few is that of a usual scene: it depends on what is found."
    assert plan_text(study, found).endswith(told)
    many, few, _one = (plan_scene(scene).seconds for scene in study.scenes.values())
    assert many == 2 * few


def test_a_scene_that_was_solved_here_takes_what_it_took(rates_file):
    text = "title: t\nexciter: {l: 0.5, h: 0.2, f: 1}\nscenes:\n"
    text += "  found: {kind: branch, along: {nu: {from: 1, to: 2}}}\n  grid: {kind: sweep, over: {nu: [1, 2]}}\n"
    study = study_of_text(text, "twice")
    assert estimate_study(study).searched == ("found",)
    for name, scene in study.scenes.items():
        record(plan_scene(scene), 0.5, 1.0, 1e3, fingerprint(study, scene))
        assert estimate_study(study).by_scene[name].seconds < 100
        record(plan_scene(scene), 1.0, 123.0, 1e6, fingerprint(study, scene))
    known = estimate_study(study)
    assert known.by_scene == dict.fromkeys(study.scenes, Estimate(123.0, 1e6))
    assert "depends on what is found" not in plan_text(study, known)
    changed = study_of_text(text.replace("h: 0.2", "h: 0.3"), "twice")
    assert estimate_study(changed).searched == ("found",)


def test_kernels_of_rests_that_are_not_there_are_told(rates_file, monkeypatch):
    text = "title: t\nexciter: {l: 0.5, h: 0.2, f: 1}\nscenes:\n"
    text += "  rigid: {kind: branch, along: {nu: {from: 1, to: 2}}}\n"
    text += "  soft: {kind: branch, exciter: {k1: 50}, along: {nu: {from: 1, to: 2}}}\n"
    study = study_of_text(text, "rests")
    told = "\nIf a motion of rigid rests on a support, compiling kernels for that takes up to 26 s more, once."
    for is_there in (True, False):
        monkeypatch.setattr(estimates, "has_kernels", lambda module, found=is_there: found)
        assert (told in plan_text(study, estimate_study(study))) is not is_there
    # as it stands it was solved here: whatever it needs is compiled
    scene = study.scenes["rigid"]
    record(plan_scene(scene), 1.0, 5.0, 1e4, fingerprint(study, scene))
    assert told not in plan_text(study, estimate_study(study))
