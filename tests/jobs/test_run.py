"""The studies of a call, as the rules of the workflow read them."""

from types import SimpleNamespace

import pytest
import xarray as xr

from vibropipe.compiler.sources import kernel_hash, source_hash
from vibropipe.jobs.run import FIRST, ROWS, read_run
from vibropipe.jobs.solving import identity
from vibropipe.jobs.summary import HOW_TO_RESUME, causes, summarise
from vibropipe.scenes.costs import PlanError
from vibropipe.scenes.registry import kinds
from vibropipe.store import save

SCENES = """\
title: T
exciter: {{l: 0.5, nu: 1, f: -1, h: 0.2, R1: 0.7}}
scenes:
  one: {{kind: motion, tau_end: 5}}
  wide: {{kind: sweep, over: {{nu: {{start: 0.5, stop: 2, points: {points}}}}}}}
  cases: {{kind: hard_cases}}
  race: {{kind: accuracy, motions: {{plain: {{}}}}}}
"""


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    tmp_path.joinpath("config").mkdir()
    for name, points in (("first", 20), ("second", 2_000_000), ("third", 10)):
        tmp_path.joinpath("config", f"{name}.yaml").write_text(SCENES.format(points=points))
    tmp_path.joinpath("config/config.yaml").write_text("studies: [first, second]\n")
    return tmp_path


@pytest.mark.parametrize(
    ("arguments", "more"),
    [
        ([], set()),
        (["results/third/report.pdf"], {"third"}),
        (["./results/third/one.nc", "results/first/one.nc"], {"third"}),
        (["--target-jobs", "solve:study=third,scene=one"], {"third"}),
        (["--report", "results.html"], set()),
    ],
)
def test_a_study_on_no_list_is_read_if_a_file_of_it_is_requested(folder, arguments, more):
    run = read_run(None, {}, arguments)
    assert set(run.studies) == {"first", "second"} | more
    assert run.default == ("first", "second")


def test_the_command_line_names_files_and_the_folder_of_results(folder):
    settings = {"studies": [str(folder / "config/third.yaml"), "first"], "results": "made"}
    run = read_run(None, settings, ["made/second/one.nc"])
    assert list(run.studies) == ["third", "first", "second"]
    assert run.report("third") == "made/third/report.pdf"
    with pytest.raises(PlanError, match="--config: must be studies or results, got result "):
        read_run(None, {"result": "made"})


def test_what_measures_times_has_all_cores_and_a_hash_of_its_own(folder):
    run = read_run(None, {})
    assert run.threads("first", ["race"], 8) == 8
    assert run.threads("first", ["race"], None) == 1
    assert run.threads("first", ["cases"], 8) == 1
    study = run.studies["first"]
    said = {name: identity(study, study.scene(name)) for name in ("one", "cases", "race")}
    assert {attrs["kernel_hash"] for attrs in said.values()} == {kernel_hash()}
    assert said["one"]["kind_hash"] == kinds()["motion"].code_hash
    assert said["race"]["lab_hash"] == kinds()["accuracy"].code_hash


def test_a_scene_takes_fewer_cores_where_its_kernels_have_to_be_compiled_first(
    folder, tmp_path, monkeypatch
):
    run, wide = read_run(None, {}), ("second", ["wide"], 64)
    monkeypatch.setattr("vibropipe.compiler.cache.cache_root", lambda: tmp_path / "cache")
    assert run.threads(*wide) == round(2e6 * 4e-5 / 30)
    # the folder alone, which importing the module creates, is not enough
    kernels = tmp_path / f"cache/solve.rows.many-{source_hash([ROWS])}/__pycache__"
    kernels.mkdir(parents=True)
    assert run.threads(*wide) == round(2e6 * 4e-5 / 30)
    kernels.joinpath("rows.solve_piece.nbi").touch()
    assert run.threads(*wide) == round(2e6 * 4e-5 / 4)


def test_jobs_share_the_cores_by_their_work(folder, monkeypatch):
    monkeypatch.setattr("vibropipe.jobs.run.has_kernels", lambda module: True)
    sweep = "{{kind: sweep, over: {{nu: {{start: 0.5, stop: 2, points: {}}}}}}}"
    text = "title: T\nexciter: {l: 0.5, nu: 1, f: -1}\nscenes:\n"
    for name, sizes in (("first", (300_000, 300_000)), ("second", (200_000,)), ("third", (100,))):
        scenes = (f"  s{k}: {sweep.format(size)}\n" for k, size in enumerate(sizes))
        (folder / f"config/{name}.yaml").write_text(text + "".join(scenes))
    both = {name: [f"s{k}" for k in range(n)] for name, n in (("first", 2), ("second", 1))}
    alone = read_run(None, {"studies": ["first"]})
    assert alone.threads("first", both["first"], 2) == 2
    run = read_run(None, {"studies": ["first", "second", "third"]})
    assert [run.threads("first", both["first"], cores) for cores in (1, 2, 4, 64)] == [1, 1, 3, 3]
    assert [run.threads("second", both["second"], cores) for cores in (1, 2, 4, 64)] == [1, 1, 1, 2]
    assert run.threads("third", ["s0"], 64) == 1
    # on a cluster, whatever its nodes
    assert run.threads("first", both["first"], None) == 2
    assert run.threads("third", ["s0"], None) == 1
    assert run.drawing_threads("first", None) == 2
    # each sweep has one figure
    assert [run.drawing_threads("first", cores) for cores in (1, 2, 4, 64)] == [1, 1, 2, 2]
    assert alone.drawing_threads("first", 64) == 2


def test_long_work_comes_first(folder):
    run = read_run(None, {})
    at = {name: run.priority("first", [name]) for name in ("race", "cases", "wide", "one")}
    assert at["race"] == FIRST > at["cases"] > at["wide"] >= at["one"] >= len(run.plans["first"])
    # a scene in shards takes one core for each, so it need not start before a measurement
    assert FIRST > run.priority("second", ["wide"]) > at["cases"]


def test_small_scenes_are_one_job_and_long_ones_and_measurements_jobs_of_their_own(
    folder, monkeypatch
):
    alone = [["race"]]
    batches = [*read_run(None, {}).batches()]
    assert [scenes for study, scenes in batches if study == "first"] == [
        ["one", "wide", "cases"],
        *alone,
    ]
    assert [scenes for study, scenes in batches if study == "second"] == [["one", "cases"], *alone]
    monkeypatch.setenv("VIBROPIPE_SHARD_SECONDS", "1e-9")
    first = [scenes for study, scenes in read_run(None, {}).batches() if study == "first"]
    assert first == [["one"], ["cases"], *alone]  # the sweep is cut


def test_a_long_sweep_is_cut_into_shards(folder):
    run = read_run(None, {})
    wide = SimpleNamespace(study="second", scene="wide", shard="0003")
    assert len(run.shards(wide)) == 4
    assert run.cut(wide) == "3/4"
    assert run.shard_sidecars(wide)[0] == "results/second/shards/wide/0001.json"


def test_a_summary_names_what_is_missing_and_what_was_not_made_again(folder):
    paths = {name: f"results/first/{name}.nc" for name in ("one", "cases", "race")}
    run = read_run(None, {}, paths.values())
    study = run.studies["first"]
    old = identity(study, study.scene("one")) | {"fingerprint": "old"}
    save(xr.Dataset(attrs=old), paths["one"])
    assert set(paths.values()) <= run.stale
    save(xr.Dataset(attrs=identity(study, study.scene("cases"))), paths["cases"])
    summary = summarise(run)
    assert summary.missing == [paths["one"], paths["race"]]
    assert summary.lines[0] == "first: made cases; not made: one, race (results/first/)"
    assert summary.lines[-1] == HOW_TO_RESUME
    assert summary.lines[-3:-1] == [f"  {path}" for path in summary.missing]


def test_a_summary_names_scenes_that_were_removed(folder):
    foreign = folder / "results/first/foreign.nc"
    foreign.parent.mkdir(parents=True, exist_ok=True)
    foreign.touch()
    for name in ("old", "one"):
        save(xr.Dataset(attrs={"fingerprint": "f"}), folder / f"results/first/{name}.nc")
    summary = summarise(read_run(None, {}, ["results/first/one.nc"]))
    assert summary.lines[1] == (
        "  kept, though no longer in the study: results of old; delete them if not needed"
    )
    assert folder.joinpath("results/first/old.nc").exists()


def test_the_causes_of_a_failed_run_are_the_errors_at_the_ends_of_logs(tmp_path):
    texts = {
        "one": "vibropipe: the kernel cache\nvibropipe: two\nlines\n",
        "again": "vibropipe: two\nlines\n",
        "bug": "Traceback: vibropipe: no\n",
    }
    for name, text in texts.items():
        (tmp_path / name).write_text(text)
    logs = [str(tmp_path / name) for name in (*texts, "missing")]
    assert causes(logs) == ["vibropipe: two\nlines"]
