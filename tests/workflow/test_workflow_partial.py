"""A scene that fails leaves the report of the others made, named there and by the exit code."""

from pathlib import Path

from command_line import called

from vibropipe.store.atomic import scenes_of

STUDY = """\
title: Chaos beside order
exciter: {l: 0.5, nu: 1, f: 2, h: 0.05, R1: 0.8, R2: 0.8, delta: 0.1}
scenes:
  good: {kind: motion, tau_end: 7, samples_per_period: 16}
  bad: {kind: branch, along: {nu: {from: 0.633, to: 0.64}}}
"""
REASON = (
    "scenes.bad.exciter: must lead from (x0, v0) to an orbit that repeats with the force, got a motion with the regime"
    " aperiodic: begin at another value (along.nu.from) or from another start"
)


def run(folder: Path, code: int) -> str:
    return called(folder, "run", "mine.yaml", "--cores", "2", code=code).stderr


def test_a_branch_that_cannot_start_fails_alone(tmp_path):
    (tmp_path / "mine.yaml").write_text(STUDY)
    report = tmp_path / "results/mine/report.pdf"
    for _ in range(2):  # it is tried again by each call
        report.unlink(missing_ok=True)
        printed = run(tmp_path, 1)
        assert "mine: results/mine/report.pdf, without bad" in printed
        assert printed.splitlines()[-1] == f"vibropipe: {REASON}"
        assert report.is_file()
    assert not (tmp_path / "results/mine/bad.nc").exists()
    # once the scene is gone, so is the line on it
    before = report.read_bytes()
    (tmp_path / "mine.yaml").write_text(STUDY[: STUDY.index("  bad:")])
    assert "mine: made report; up to date: good, figures (" in run(tmp_path, 0)
    assert report.read_bytes() != before
    assert scenes_of(report) == ["good"]
