"""The same exciter has the same intervals of coexistence in the default studies `laws`, `coexistence` and `paper`.

All three have l = 0.5, h = 0.2, delta = 0, R1 = R2 = 0.7 and a force of 1: along its branches, over the basins of a
grid of frequencies, and in a sweep that is followed up and down.
"""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from vibropipe.scenes.basins.report import share_answers, together_ranges
from vibropipe.scenes.branch.answers import branch_answers
from vibropipe.scenes.branch.stretches import common_intervals, stretches_of
from vibropipe.scenes.registry import kind_of
from vibropipe.scenes.sweep.answers import sweep_answers
from vibropipe.scenes.sweep.neighbours import differing_rows
from vibropipe.study import study_of_text

CONFIG = Path(__file__).parents[2] / "config"
# Frequencies that all three have.
LOW, HIGH = 0.7, 3.0
SAYS = "Among the motions followed here, at least two "


def solved(study: str, scene: str, *changes: tuple[str, str]) -> Any:
    """Return the dataset of a scene of a default study with a smaller grid."""
    text = (CONFIG / f"{study}.yaml").read_text(encoding="utf-8")
    for old, new in changes:
        assert text.count(old) == 1, old
        text = text.replace(old, new)
    loaded = study_of_text(text, study).scenes[scene]
    return kind_of(loaded).solve(loaded)


def intervals_of(dataset: Any) -> np.ndarray:
    """Return the intervals of coexistence of branches within the frequencies of all studies, (n, 2)."""
    ends = np.array(common_intervals(stretches_of(dataset))).clip(LOW, HIGH)
    return ends[ends[:, 1] > ends[:, 0]]


@pytest.fixture(scope="module")
def studies():
    laws = solved("laws", "response", ("over: {f: [0.25, 0.5, 1]}", "over: {f: [1]}"))
    branches = solved("coexistence", "branches_over_frequency")
    shares = solved(
        "coexistence",
        "shares_over_frequency",
        ("nu: {start: 0.3, stop: 4, points: 75}", "nu: {start: 0.775, stop: 3, points: 21}"),
        ("x0: {start: -0.5, stop: 0.5, points: 30}", "x0: {start: -0.5, stop: 0.5, points: 7}"),
        ("v0: {start: -2, stop: 2, points: 30}", "v0: {start: -2, stop: 2, points: 8}"),
        ("starts: 256", "starts: 32"),
    )
    text = (CONFIG / "paper.yaml").read_text(encoding="utf-8")
    begin, end = text.index("  response_0:"), text.index("  response_offset:")
    whole = text[begin:end]
    paper = solved("paper", "response_0", (whole, whole.replace("0.1, 0.25, 0.5, 1", "1")))
    return laws, branches, shares, paper


@pytest.mark.slow
def test_branches_of_two_studies_have_the_same_intervals(studies) -> None:
    laws, branches, _shares, _paper = studies
    assert intervals_of(laws) == pytest.approx(intervals_of(branches), abs=1e-9)
    # a fold and a grazing; two pitchforks; and again, up to the end of the range
    assert intervals_of(laws) == pytest.approx(
        np.array([[0.7336, 0.8317], [1.153, 1.379], [1.723, 3.0]]), abs=5e-4
    )
    for dataset in (laws, branches):
        assert branch_answers(dataset)[0].lead.startswith("The start decides which motion settles ")


def test_attractors_coexist_within_the_intervals_of_the_branches(studies) -> None:
    laws, _branches, shares, _paper = studies
    expected, nu = intervals_of(laws), shares["nu"].values
    several = shares["basin_share"].count("attractor_id").values > 1
    inside = ((nu[:, None] > expected[:, 0]) & (nu[:, None] <= expected[:, 1])).any(axis=1)
    assert np.array_equal(several, inside)
    places = expected.ravel()
    for ends in together_ranges(shares):
        for end in ends:
            if end is None:
                continue
            low, high = min(end), max(end)
            # Located to four digits (docs/numerics.md), or between two values of the grid.
            near = 1e-4 * places
            assert ((places >= low - near) & (places <= high + near)).any(), (end, places)
    assert share_answers(shares)[0].lead.startswith("The start decides which motion settles from ")


def test_a_followed_sweep_has_two_motions_within_the_intervals_of_the_branches(studies) -> None:
    laws, _branches, _shares, paper = studies
    expected, step = intervals_of(laws), 0.005
    rows = [each for each in differing_rows(paper, "nu") if each.low >= LOW]
    assert any(each.lead.startswith(SAYS) for each in sweep_answers(paper))
    for each in rows:
        inside = (each.low >= expected[:, 0] - 1e-9) & (each.high <= expected[:, 1] + 1e-9)
        assert inside.any(), each
        low, high = expected[inside][0]
        # a motion is left early by a few steps
        assert each.low - low < 3 * step
        assert high - each.high < 3 * step
    # Where a fold and a grazing bound them; up and down may fall on the same one of a mirrored pair.
    assert len(rows) >= 2
