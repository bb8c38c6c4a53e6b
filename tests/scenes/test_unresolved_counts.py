"""How many rows of a sweep are unresolved stands beside its file, and with the reasons in its caption and report."""

import json
from pathlib import Path
from typing import Any

import yaml

import vibropipe as vp
from vibropipe.jobs.solving import join_to_file, solve_to_file
from vibropipe.scenes.sweep.answers import sweep_answers
from vibropipe.scenes.sweep.captions import describe_map, describe_sweep
from vibropipe.study import study_of_text

STUDY = """
title: Crowded
exciter: {l: 1.0e-3, nu: 1, f: 10, h: 0.1}
scenes:
  rows: {kind: sweep, over: {nu: [0.01, 0.011, 1]}, outputs: [impacts], effects: &all
      [damping, forcing, support_1, support_2, restitution, rest]}
  map: {kind: sweep, over: {nu: [0.01, 0.011, 1], f: [9, 10]}, outputs: [impacts], effects: *all}
  one: {kind: motion, tau_end: 1, outputs: [impacts], effects: *all}
"""


def test_unresolved_rows_are_counted_beside_the_file(tmp_path: Path) -> None:
    study = study_of_text(STUDY, "crowded")

    def unresolved(name: str) -> Any:
        return json.loads((tmp_path / f"{name}.json").read_text())["unresolved"]

    for name, expected in (("rows", 2), ("map", 4), ("one", 0)):
        solve_to_file(study, name, tmp_path / f"{name}.nc", None, 1)
        assert unresolved(name) == expected
    parts = [tmp_path / f"{part}.nc" for part in (1, 2)]
    for number, part in enumerate(parts, 1):
        solve_to_file(study, "map", part, (number, 2), 1)
    join_to_file(study, "map", parts, tmp_path / "joined.nc")
    assert unresolved("joined") == 4
    assert unresolved("1") + unresolved("2") == 4


def test_captions_say_how_many_rows_are_unresolved_and_why() -> None:
    tree = yaml.safe_load(STUDY)["exciter"]
    line = vp.sweep(vp.Exciter(**tree), {"nu": [0.01, 0.011, 1.0]})
    grid = vp.sweep(vp.Exciter(**tree), {"nu": [0.01, 0.011, 1.0], "f": [9.0, 10.0]})
    why = "too many impacts in a forcing period"
    assert f"Unresolved: 2 of 3 rows, {why}." in describe_sweep(line)
    # without values nothing is drawn of them
    assert "and 2 have no result; bars" in describe_sweep(line)
    still = line.fillna({"displacement_mean": 0.1})  # as of motions that still change
    assert "all have no periodic orbit that was found (dots: in a window);" in describe_sweep(still)
    assert f"Unresolved: 4 of 6 rows, {why}." in describe_map(grid)
    # Also where the author wrote the caption.
    last = sweep_answers(line)[-1]
    assert (last.lead, last.rest) == ("2 of 3 rows are unresolved.", f"Reason: {why}.")
    assert "Unresolved" not in describe_sweep(line.isel(nu=[2]))
