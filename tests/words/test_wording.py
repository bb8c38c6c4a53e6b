"""Amounts agree with their nouns in every text, and columns are aligned."""

import numpy as np
import pytest
import xarray as xr

from vibropipe.jobs.plan import plan_scene
from vibropipe.jobs.terminal_tables import plan_text
from vibropipe.jobs.verify import Verdict
from vibropipe.scenes.costs import PlanError
from vibropipe.scenes.hard_cases.report import on_cases
from vibropipe.scenes.rows import part_text
from vibropipe.scenes.sweep.captions import row_kinds_text
from vibropipe.scenes.sweep.cut import row_range
from vibropipe.store.atomic import StoreError
from vibropipe.store.shards import _check_cover
from vibropipe.study import parse_study
from vibropipe.words.quantities import REGIMES
from vibropipe.words.wording import aligned, count, series, share


def study_with(**scenes):
    return parse_study({"title": "T", "exciter": {"l": 0.5}, "scenes": scenes})


def test_counts_and_series():
    assert [count(1, "row"), count(3, "row"), count(0, "row")] == ["1 row", "3 rows", "0 rows"]
    assert count(2, "analysis", "analyses") == "2 analyses"
    assert [share(1, 1, "check"), share(2, 3, "check")] == ["1 of 1 check is", "2 of 3 checks are"]
    assert [series([]), series("a"), series("abc")] == ["", "a", "a, b and c"]


def test_a_plan_of_one_scene_and_one_row():
    one = plan_text(study_with(only={"kind": "motion"}))
    assert "\n1 scene, 1 row, roughly" in one
    two = plan_text(study_with(a={"kind": "motion"}, b={"kind": "sweep", "over": {"nu": [1, 2]}}))
    assert "\n2 scenes, 3 rows, roughly" in two


def test_sizes_of_scenes():
    study = study_with(
        case={"kind": "hard_cases", "cases": ["ideal_free"]},
        race={"kind": "accuracy", "motions": {"m": {}}},
    )
    assert [plan_scene(scene).size for scene in study.scenes.values()] == ["1 case", "1 motion"]


def test_a_cut_into_one_shard_too_many():
    scene = study_with(s={"kind": "sweep", "over": {"nu": [1, 2]}}).scenes["s"]
    with pytest.raises(PlanError, match=r"^scenes\.s: must be cut into 1 to 2 shards, got 3$"):
        row_range(scene, 1, 3)


def test_verdicts():
    assert str(Verdict("s", faults=["x"])).startswith("s: 1 fault\n")
    assert str(Verdict("s", faults=["x", "y"])).startswith("s: 2 faults\n")
    parts = [part_text(1, 1), part_text(3, 3), part_text(1, 12000)]
    assert parts == ["the only row", "all 3 rows", "1 of 12,000 rows"]


def test_rows_that_no_shard_holds():
    class Held:
        start, stop = 0, 1

    with pytest.raises(StoreError, match="rows 1 to 2 of 3 are not in the only shard"):
        _check_cover([Held], 3)


def test_one_row_of_a_sweep_has_no_orbit():
    codes = [REGIMES["two_sided"], REGIMES["aperiodic"]]
    one = xr.Dataset({"regime": ("nu", np.array(codes, np.int8))})
    assert row_kinds_text(one, are_drawn=False).startswith(
        "Of 2 rows, 1 has no periodic orbit that was found;"
    )


def test_one_case_and_one_bound():
    passed = xr.Dataset({"passed": (("case", "solver"), np.array([[1]], np.int8))})
    assert on_cases(passed).lead == "1 case: every bound is kept."
    assert on_cases(passed * 0).lead == "1 case: 1 bound exceeded."


def test_columns_are_as_wide_as_their_widest_cell():
    assert aligned([("a", "bb", "c"), ("long", "b", "")]) == ["a     bb  c", "long  b"]


def test_an_accent_takes_no_column():
    dotted = "x\u0307"
    assert aligned([(dotted, "1"), ("xy", "2")]) == [f"{dotted}   1", "xy  2"]
