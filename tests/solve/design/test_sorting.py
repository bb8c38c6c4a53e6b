"""The sorting rule against two normal distributions, whose threshold, area and error are known."""

from __future__ import annotations

from statistics import NormalDist

import numpy as np
import pytest

from vibropipe.solve.design.sorting import area_under_curve, can_sort, foretells, sorting_rule

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
    assert foretells(rule, kept)


def test_a_quantity_without_influence_foretells_nothing(kept):
    rule = sorting_rule(np.random.default_rng(3).normal(size=N), kept)
    assert rule.area == pytest.approx(0.5, abs=0.01)
    assert not foretells(rule, kept)
    constant = sorting_rule(np.full(N, 0.3), kept)
    assert np.isnan(constant.threshold)
    assert not foretells(constant, kept)


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


def test_rules_need_good_and_bad_parts_in_both_halves():
    assert can_sort(np.array([True, False, True, False]))
    assert not can_sort(np.array([True, False, True, True]))
