"""The sorting rule against two normal distributions, whose threshold, area and error are known."""

from __future__ import annotations

from statistics import NormalDist
from types import SimpleNamespace

import numpy as np
import pytest

from vibropipe.solve.design.sorting import (
    NONE,
    area_under_curve,
    can_sort,
    foretells,
    sorting_rule,
    sorting_variables,
    stacked,
)
from vibropipe.solve.rows.named import named

N = 40_000


@pytest.fixture
def kept():
    return np.random.default_rng(1).random(N) < 0.5


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_two_normal_distributions_have_their_closed_form(kept, sign):
    # Means 2 apart, deviation 1, equally many: the threshold is halfway, wrong is Phi(-1), the area Phi(sqrt 2).
    values = sign * (np.random.default_rng(2).normal(size=N) + 2.0 * kept)
    rule = sorting_rule(values, kept)
    assert rule.threshold == pytest.approx(sign, abs=0.1)
    area = NormalDist().cdf(2**0.5)
    assert rule.area == pytest.approx(area if sign > 0 else 1 - area, abs=0.01)
    assert rule.wrong_low < NormalDist().cdf(-1.0) < rule.wrong_high
    assert foretells(rule.wrong_high, kept)


def test_a_quantity_without_influence_foretells_nothing(kept):
    rule = sorting_rule(np.random.default_rng(3).normal(size=N), kept)
    assert rule.area == pytest.approx(0.5, abs=0.01)
    assert not foretells(rule.wrong_high, kept)
    constant = sorting_rule(np.full(N, 0.3), kept)
    assert np.isnan(constant.threshold)
    assert not foretells(constant.wrong_high, kept)


def test_the_threshold_is_the_best_of_all_and_the_area_that_of_all_pairs():
    random = np.random.default_rng(4)
    values = random.integers(0, 12, 120).astype(float)  # with ties
    kept = values + random.normal(0, 3, 120) > 5
    good, bad = values[:60][kept[:60]], values[:60][~kept[:60]]
    pairs = (good[:, None] > bad) + 0.5 * (good[:, None] == bad)
    assert area_under_curve(values[:60], kept[:60]) == pytest.approx(pairs.mean())
    rule = sorting_rule(values, kept)
    least = min(((values[:60] > cut) != kept[:60]).sum() for cut in np.arange(-1, 13) + 0.5)
    assert ((values[:60] > rule.threshold) != kept[:60]).sum() == least
    assert rule.wrong == ((values[60:] > rule.threshold) != kept[60:]).mean()


def test_a_part_without_the_quantity_counts_as_bad():
    kept = np.tile([True, False], 200)
    rule = sorting_rule(np.where(kept, np.linspace(1, 2, 400), np.nan), kept)
    assert rule.wrong == 0.0


def test_rules_need_as_many_good_and_bad_parts_as_show_that_they_sort():
    def bad(in_first, in_second, n=500):
        kept = np.ones(2 * n, bool)
        kept[:in_first] = False
        kept[n : n + in_second] = False
        return kept

    assert can_sort(bad(1, 20))
    assert can_sort(~bad(1, 20))
    assert not can_sort(bad(0, 20))
    # Four of 500 bad parts are within the interval of a rule that sorts all of 500 right.
    assert not can_sort(bad(20, 4))
    assert not can_sort(np.array([True, False, True, False]))


def test_the_best_rule_is_that_of_the_parts_that_do_not_judge_it():
    # Of two quantities one sorts the first half alone, the other the second alone: the better share is luck.
    kept = np.random.default_rng(6).random(800) < 0.5
    is_second = np.arange(800) >= 400
    noise = np.random.default_rng(7).normal(size=(2, 800))
    amplitudes = np.stack(
        [np.where(is_second, noise[0], kept), np.where(is_second, kept, noise[1])], axis=1
    )
    names = [named(f"displacement_amplitude_{n}", "names") for n in (1, 2)]

    def points(values):
        variables = {"displacement_amplitude": (("row", "harmonic"), values)}
        return SimpleNamespace(variables=variables, parameters=np.zeros((len(values), 15)))

    def best(values):
        return sorting_variables(names, [], points(values[:1]), points(values), kept)[1]

    assert best(amplitudes) == NONE
    both = np.where(is_second[:, None], kept[:, None], amplitudes)
    assert best(both) == "displacement_amplitude_1"


def test_designs_without_a_rule_have_nan_beside_one_with():
    rule = {"f_sort_area": ((), np.array(0.3))}
    dims, areas = stacked([{}, rule], "design")["f_sort_area"]
    assert dims == ("design",)
    np.testing.assert_array_equal(areas, [np.nan, 0.3])
    assert stacked([{}, {}], "design") == {}
