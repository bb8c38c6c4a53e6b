"""What is said and drawn of branches, from small datasets: jumps that are counted, mirror images, intervals, lines."""

import re
from dataclasses import replace

import numpy as np
import pytest
import xarray as xr
from matplotlib.colors import to_hex

from vibropipe.figures.motion_words import motion_words, orbit_text
from vibropipe.report.parts import Answer
from vibropipe.scenes.basins.report import (
    family_table,
    share_answers,
    title_shares,
    together_ranges,
)
from vibropipe.scenes.basins.report import together_answer as share_together
from vibropipe.scenes.branch.answers import (
    branch_answers,
    gap_answer,
    jump_answer,
    kinds_answer,
    lopsided_answer,
    velocity_answer,
)
from vibropipe.scenes.branch.answers import together_answer as branch_together
from vibropipe.scenes.branch.curves import REACHED, draw_branches, drawn_pieces, enlarged
from vibropipe.scenes.branch.jumps import arrows_of, jumps_of
from vibropipe.scenes.branch.lines import velocities_of
from vibropipe.scenes.branch.pictures import describe_branches, title_branches
from vibropipe.scenes.branch.report import cascade_table, stable_table
from vibropipe.scenes.branch.stretches import Stretch, image_groups, stable_words, stretches_of
from vibropipe.words.bifurcations import Bifurcation
from vibropipe.words.quantities import FLAGS
from vibropipe.words.vocabulary import describe

NU = np.linspace(1.0, 2.0, 6)


def stretch(
    low: float, high: float, height: float, words: str, *ends: str, mean: float = 0.0
) -> Stretch:
    """Return a stable stretch of one amplitude, and of an impact velocity as large."""
    same = np.full(2, height)
    return Stretch(
        np.array([low, high]),
        same,
        same,
        words,
        words,
        0.0,
        (ends[0], ends[1]),
        np.zeros(2),
        np.full(2, mean),
        np.arange(2),
        has_image=True,
    )


def mirrored(second: tuple[float, ...] = (1.1, 0.9)) -> xr.Dataset:
    """Return two branches along nu that strike the supports with velocities in turn: of mirror images."""
    n, first = NU.size, np.linspace(0.0, 0.1, NU.size)
    velocity = np.empty((2 * n, 2))
    velocity[:n] = np.array([0.9, 1.1]) + first[:, None]
    velocity[n:] = np.array(second) + first[:, None]
    dataset = xr.Dataset(
        {
            "impact_velocity_max": (("point", "support"), velocity),
            "displacement_amplitude": (("point", "harmonic"), np.full((2 * n, 1), 0.4)),
            "displacement_mean": ("point", np.repeat([0.1, -0.1], n)),
            "stable": ("point", np.ones(2 * n, np.int8)),
            "regime": ("point", np.full(2 * n, 3, np.int8)),
            "period_multiple": ("point", np.ones(2 * n, int)),
            "impacts_per_orbit": (("point", "support"), np.ones((2 * n, 2))),
            "floquet_multiplier": (("point", "multiplier"), np.full((2 * n, 2), 0.5 + 0j)),
            "from_rest": (
                "point",
                np.repeat([FLAGS["settled_same"][name] for name in ("same", "other")], n),
            ),
            "branch_id": ("point", np.repeat([0, 1], n)),
            "bifurcation_nu": ("bifurcation", np.empty(0)),
            "bifurcation_kind": ("bifurcation", np.empty(0, int)),
            "bifurcation_point": ("bifurcation", np.empty(0, int)),
            "nu": ("point", np.tile(NU, 2)),
            "f": 1.0, "h": 0.1, "l": 0.5, "delta": 0.0, "R1": 0.8, "R2": 0.8,
        },
        {"support": [1, 2], "harmonic": [1]},
        attrs={"follow": "nu both"},
    )  # fmt: skip
    return describe(dataset)


def test_orbits_that_were_followed_twice_are_one_stretch():
    twice = mirrored((0.9, 1.1))
    twice["displacement_mean"][:] = 0.1
    assert len(stretches_of(twice)) == 1
    assert "mirror" not in " ".join(stable_table("s", with_a_fold(twice)).rows[0])
    assert len(stretches_of(mirrored())) == 2
    twice["displacement_mean"][NU.size :] = -0.1
    assert len(stretches_of(twice)) == 2
    # mirror images are one orbit at the pitchforks where they begin and end
    ends = [0, NU.size - 1, NU.size, -1]
    twice["displacement_mean"][ends] = 0.0
    twice["impact_velocity_max"][ends] = 1.0
    assert len(stretches_of(twice)) == 2


def with_a_fold(dataset: xr.Dataset) -> xr.Dataset:
    """Return a dataset with a fold at its first point."""
    empty = dataset.drop_dims("bifurcation")
    return empty.assign(
        bifurcation_nu=("bifurcation", [1.0]),
        bifurcation_kind=("bifurcation", [0]),
        bifurcation_point=("bifurcation", [0]),
    )


def test_small_steps_may_be_jumps_as_well():
    lower = stretch(1.0, 2.0, 0.1, "no impact", "", "")
    upper = stretch(1.0, 1.7, 0.5, "both supports, once a period", "grazing", "fold")
    near = stretch(1.2, 1.3, 0.1001, "support 1, once a period", "grazing", "fold")
    answer = jump_answer(mirrored(), [lower, upper, near])
    assert answer.lead == "Followed motions jump at folds, in at least one place."
    assert answer.rest == (
        "The jump leaves “both supports, once a period” as ν grows past 1.7, a fold; stable beyond: no impact."
    )
    other = stretch(1.0, 1.5, 0.3, "support 2, once a period", "", "fold")
    answer = jump_answer(mirrored(), [lower, upper, near, other])
    assert answer.lead == "Followed motions jump at folds, in at least two places."
    assert answer.rest.startswith(
        "The largest jump of the impact velocity leaves “both supports, once a period” as ν grows past 1.7, "
    )


def test_jumps_that_are_as_large_are_not_the_largest_alone():
    lower = stretch(1.0, 2.0, 0.1, "no impact", "", "")
    upper = stretch(1.3, 1.7, 0.5, "both supports, once a period", "fold", "fold")
    told = jump_answer(mirrored(), [lower, upper])
    assert told.lead == "Followed motions jump at folds, in at least two places."
    assert told.rest.startswith(
        "One of the largest jumps of the impact velocity leaves “both supports, once a period” as ν "
    )


def test_a_jump_is_an_arrow_where_it_leads_to_one_height():
    both = "both supports, once a period"
    upper = replace(stretch(1.0, 1.6, 0.5, both, "", "fold"), points=np.array([0, 3]))
    lower = replace(stretch(1.0, 2.0, 0.1, "no impact", "", ""), points=np.array([6, 11]))
    other = replace(stretch(1.0, 2.0, 0.1, "no impact", "", ""), points=np.array([4, 5]))
    heights = np.linspace(0.5, 0.1, 12)[:, None]
    heights[[6, 11]] = 0.1
    (jump,) = jumps_of(mirrored(), [upper, lower])
    (arrow,) = arrows_of([jump], heights)
    assert arrow[:3] == pytest.approx((1.6, heights[3, 0], 0.1))
    assert arrows_of([replace(jump, targets=(lower, other))], heights) == []
    assert arrows_of([jump], np.tile(heights, 2)) == []  # of several impacts


def test_where_no_orbit_is_stable_is_told():
    both = "both supports, once a period"
    left, right = stretch(1.0, 1.2, 0.4, both, "", "grazing"), stretch(1.6, 2.0, 0.4, both, "", "")
    dataset = mirrored()
    assert gap_answer(dataset, [left, right]) is None  # a point between is stable
    dataset["stable"][:] = np.tile([1, 1, 0, 0, 1, 1], 2)
    assert gap_answer(dataset, [left, right]) == Answer(
        "No orbit that is followed here is stable from ν = 1.2 to 1.6."
    )
    # as the table of the stable motions writes them
    narrow = stretch(1.2, 1.20007, 0.4, both, "pitchfork", "grazing")
    assert gap_answer(dataset, [left, narrow, right]) == Answer(
        "No orbit that is followed here is stable from ν = 1.2001 to 1.6."
    )


@pytest.mark.parametrize(
    ("second", "where"),
    [((1.1, 0.9), "on one support, is 1.2"), ((1.1, 1.2), "on support 2, is 1.3")],
)
def test_mirror_images_strike_either_support_as_hard(second, where):
    assert where in velocity_answer(mirrored(second)).rest


def test_what_is_reached_from_rest_is_wide_on_both_supports():
    dataset = mirrored()
    figure = draw_branches(dataset, ("impact_velocity_max",))
    (ax, *_) = figure.axes
    assert "each support" in "".join(text.get_text() for text in figure.findobj(type(ax.title)))
    drawn = [line for line in ax.lines if line.get_linewidth() == REACHED["linewidth"]]
    heights = sorted(float(line.get_ydata()[0]) for line in drawn)
    assert heights == pytest.approx([0.9, 1.1])
    assert len({to_hex(line.get_color()) for line in drawn}) == 1


def test_intervals_are_those_of_the_motions_that_are_followed():
    assert title_branches(mirrored(), ()) == (
        "At least two of these motions are stable in one interval of ν"
    )


def shares(*places: float) -> xr.Dataset:
    """Return shares of two motions; the second appears at the first and vanishes at the second of some places."""
    dataset = xr.Dataset(
        {
            "basin_share": (
                ("attractor_id", "nu"),
                [[1.0, 0.5, 0.5, 1.0], [np.nan, 0.5, 0.5, np.nan]],
            ),
            "attractor": (("nu", "x0", "v0"), np.zeros((4, 1, 1), int)),
            "regime": (("nu", "attractor_id"), np.full((4, 2), 3, np.int8)),
            "period_multiple": (("nu", "attractor_id"), np.ones((4, 2), int)),
            "impacts_per_orbit": (
                ("nu", "attractor_id", "support"),
                np.tile([[1.0, 2.0], [2.0, 1.0]], (4, 1, 1)),
            ),
            "displacement_mean": (
                ("nu", "attractor_id"),
                np.stack([[0.0, 0.1, 0.1, 0.0], [np.nan, -0.1, -0.1, np.nan]], axis=1),
            ),
            "displacement_amplitude": (("nu", "attractor_id", "harmonic"), np.full((4, 2, 1), 0.4)),
            "bifurcation_nu": ("bifurcation", np.array(places)),
            "changed_attractor": ("bifurcation", np.ones(len(places), int)),
            "other_attractor": ("bifurcation", np.zeros(len(places), int)),
            "attractor_change": ("bifurcation", (np.arange(len(places)) + 1) % 2),
        },
        {"nu": [1.0, 1.1, 1.2, 1.3], "attractor_id": [0, 1], "support": [1, 2], "harmonic": [1]},
    )
    return describe(dataset)


def test_one_motion_at_all_values_has_no_ends():
    one = shares().isel(attractor_id=[0])
    one["basin_share"][:] = 1.0
    assert [answer.lead for answer in share_answers(one)] == [
        "The same motion is found at all values of ν on the grid."
    ]
    assert family_table("s", one) is None
    one["basin_share"][:, 0] = 0.5  # of the other starts no motion was found
    assert len(family_table("s", one).rows) == 1


def test_one_value_is_told_as_such():
    """A scene has one value of its parameter, beside which other scalars stand."""
    dataset = shares().isel(nu=[1], bifurcation=[]).assign_coords(f=-1.0, h=0.2)
    dataset["basin_share"][:] = [[0.25], [0.75]]
    assert title_shares(dataset) == "Motions coexist at ν = 1.1"
    leads = [answer.lead for answer in share_answers(dataset)]
    assert leads == ["The start decides which motion settles at ν = 1.1."]
    one = dataset.isel(attractor_id=[0])
    one["basin_share"][:] = 1.0
    assert title_shares(one) == "At ν = 1.1, all starts settle on one motion"
    assert [answer.lead for answer in share_answers(one)] == ["One motion is found at ν = 1.1."]


def test_motions_coexist_between_values_of_the_grid_too():
    """The first motion ends between two values, at neither of which there is another, after the second appears."""
    dataset = shares(1.124, 1.138)
    dataset["basin_share"][:] = [[1.0, 1.0, np.nan, np.nan], [np.nan, np.nan, 1.0, 1.0]]
    dataset["changed_attractor"][:] = [1, 0]
    assert together_ranges(dataset) == [((1.124,), (1.138,))]
    assert title_shares(dataset) == "Motions coexist in at least one range of ν"
    dataset["bifurcation_nu"][:] = [1.138, 1.124]
    assert together_ranges(dataset) == []


def test_mirror_images_are_told_apart_from_motions_in_the_same_words():
    first, second = family_table("s", shares(1.05432, 1.25678)).rows
    assert first[1].endswith(" (in part mirror image of B)")
    assert second[1].endswith(" (mirror image of A)")


def test_a_border_has_the_same_digits_everywhere():
    together = share_together(shares(1.05432, 1.25678))
    assert together.lead == "The start decides which motion settles from ν = 1.054 to 1.257."
    assert re.fullmatch(r"There A \(.*\) and B \(.*\) coexist\.", together.rest)
    assert "from at least ν = 1.1 to at least ν = 1.2" in share_together(shares()).lead
    motions = stretch(1.05432, 1.65678, 0.4, "a", "fold", ""), stretch(1.0, 1.7, 0.1, "b", "", "")
    told = branch_together(mirrored(), list(motions))
    assert told == Answer(
        "The start decides which motion settles from ν = 1.054 to 1.657.", "Stable there: a; b."
    )


def test_motions_of_an_interval_are_told_in_few_words():
    laws = {orbit_text(1, *hits): motion_words(3, 1, hits, (0, 0)) for hits in ((2, 1), (1, 2))}
    pair = [replace(stretch(1.0, 2.0, 0.4, words, "", ""), law=law) for law, words in laws.items()]
    first = "support 1 twice, support 2 once a period"
    part = stretch(1.2, 1.4, 0.4, "no impact", "", "")
    assert stable_words(pair, 1.0, 2.0) == f"{first} (mirror images)"
    assert (
        stable_words([*pair, part], 1.0, 2.0) == f"{first} (mirror images); one more in parts of it"
    )
    assert stable_words([part, part], 1.0, 2.0) == "two motions, each in a part of it"


@pytest.mark.parametrize("name", ["delta", "load", "f2", "R1", "k2"])
def test_other_exciters_than_symmetric_ones_have_no_mirror_images(name):
    # two motions of one law, both stable over all of the range
    pair = with_a_fold(mirrored())
    assert "mirror images" in str(branch_answers(pair))
    pair[name] = 0.003
    assert "mirror" not in str(branch_answers(pair))
    table = stable_table("s", pair)
    assert len(table.rows) == 2
    assert "irror" not in str(table)


def test_a_further_parameter_may_end_the_symmetry():
    pair = mirrored()
    both = {name: values for name, values in pair.items() if "bifurcation" in values.dims}
    points = pair.drop_vars(["delta", *both])
    two = [points.assign(delta=("point", np.full(points.sizes["point"], d))) for d in (0, 0.003)]
    dataset = xr.concat(two, "point", data_vars="minimal").assign(both)
    dataset["branch_id"][points.sizes["point"] :] += 2
    alike = [(each[0].over, len(each)) for each in image_groups(stretches_of(dataset))]
    assert alike == [(0.0, 2), (0.003, 1), (0.003, 1)]


def test_two_symmetric_motions_of_one_law_are_no_mirror_images():
    pair = [stretch(1.0, 2.0, height, "both", "", "") for height in (0.4, 0.1)]
    assert stable_words(pair, 1.0, 2.0) == "both (two motions)"


def test_steps_of_a_cascade_are_seen_in_its_places():
    at = [1.1, 1.6, 1.7, 1.72, 1.7204]
    dataset = mirrored().drop_dims("bifurcation")
    dataset["period_multiple"][:5] = [1, 2, 4, 8, 16]
    dataset = dataset.assign(
        bifurcation_nu=("bifurcation", at),
        bifurcation_kind=("bifurcation", np.full(5, Bifurcation.FLIP)),
        bifurcation_point=("bifurcation", np.arange(5)),
    )
    table = cascade_table("s", dataset)
    assert stable_table("s", dataset) is None  # it would repeat the flips
    low, high = enlarged(dataset)
    assert at[1] < low < at[2] < at[4] < high < at[4] + 0.01
    dataset["stable"][:6] = 0
    drawn = {int(dataset["period_multiple"][each.points.start]) for each in drawn_pieces(dataset)}
    assert drawn == {1, 2}  # of many periods, unstable orbits lie on others
    assert [row[1] for row in table.rows] == [
        "1.100000", "1.600000", "1.700000", "1.720000", "1.720400"
    ]  # fmt: skip
    assert [row[2] for row in table.rows] == ["–", "0.500000", "0.100000", "0.020000", "0.000400"]


def test_where_motions_are_lopsided_is_told_if_nothing_else_coexists():
    both = "both supports, once a period"
    left, right = (
        stretch(1.2, 1.5, 0.4, both, "pitchfork", "grazing", mean=mean) for mean in (0.1, -0.1)
    )
    alone = stretch(1.5, 2.0, 0.4, both, "grazing", "")
    assert lopsided_answer(mirrored(), [left, right, alone]) == Answer(
        "Lopsided motions are stable from ν = 1.2 to 1.5.",
        "Each is one of two mirror images; the start decides which.",
    )
    other = stretch(1.2, 1.5, 0.4, both, "pitchfork", "grazing", mean=-0.2)
    for stretches in (
        [left, other],
        [alone, alone],
        [left, right, stretch(1.3, 2.0, 0.1, "no impact", "", "")],
    ):
        assert lopsided_answer(mirrored(), stretches) is None
    assert branch_answers(mirrored())[0].lead == "Lopsided motions are stable from ν = 1 to 2."


def test_mirror_images_are_named_in_the_table():
    (row,) = stable_table("s", with_a_fold(mirrored())).rows
    assert row[0] == "both supports, once a period (mirror images)"


def test_lines_of_impacts_cross_instead_of_turning_back():
    along = np.linspace(-1, 1, 9)
    first, second = 0.4 + 0.1 * along, 0.4 - 0.1 * along
    # From the sixth point on the orbit begins with its second impact.
    orbits = [
        (a, b) if n < 5 else (b, a) for n, (a, b) in enumerate(zip(first, second, strict=True))
    ]
    dataset = xr.Dataset(
        {"impact_velocity": ("impact", np.ravel(orbits)), "row_size": ("point", np.full(9, 2))},
        {"branch_id": ("point", np.zeros(9, int))},
    )
    np.testing.assert_array_equal(velocities_of(dataset), np.stack([first, second], axis=1))


def test_a_branch_of_its_own_begins_anew():
    dataset = xr.Dataset(
        {
            "impact_velocity": ("impact", [0.3, 0.2, -0.4, 0.2, 0.3]),
            "row_size": ("point", [2, 1, 2]),
        },
        {"branch_id": ("point", [0, 0, 1])},
    )
    expected = [[0.3, 0.2], [0.4, np.nan], [0.2, 0.3]]
    np.testing.assert_array_equal(velocities_of(dataset), expected)


def test_what_a_change_is_is_told():
    dataset = mirrored().drop_dims("bifurcation").assign(friction=0.1)
    dataset["stable"][3] = 0
    codes = [int(Bifurcation[name]) for name in ("CHANGE", "CHANGE")]
    at = {"nu": [1.2, 1.4], "point": [1, 2], "kind": codes}
    found = {f"bifurcation_{name}": ("bifurcation", values) for name, values in at.items()}
    alone = dataset.isel(point=range(NU.size)).assign(found)
    assert kinds_answer(alone) is None
    assert title_branches(alone, []) == "A contact, turn or stick begins or ends at two values of ν"
    # right at a change those beside it tell whether an orbit is stable
    found["bifurcation_point"] = ("bifurcation", [2, 3])
    whole = alone.assign(found)
    assert title_branches(whole, []) == "All orbits followed along ν are stable"
    assert describe_branches(whole, []).startswith("Orbits along ν; solid: stable, wide: ")
    assert stable_table("s", whole) is None
    (only,) = stretches_of(whole)
    assert only.values[[0, -1]].tolist() == [1.0, 2.0]
    found["bifurcation_point"] = ("bifurcation", [1, 2])
    found["bifurcation_kind"] = ("bifurcation", [codes[0], int(Bifurcation["FOLD"])])
    with_fold = alone.assign(found)
    answer = kinds_answer(with_fold)
    assert answer is not None
    assert answer.rest == "At a change a contact, turn or stick begins or ends."
