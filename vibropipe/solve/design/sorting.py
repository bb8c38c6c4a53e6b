"""What scattered parts keep: the yield, and which single quantity of a finished part foretells that it is good."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from vibropipe.solve.basins.attractors import shares
from vibropipe.solve.design.goals import Bound
from vibropipe.solve.rows.label import Variables
from vibropipe.solve.rows.named import Named, gathered, named
from vibropipe.solve.rows.points import Points

# What is stored of a sorting rule, in the order of its fields.
SORTING = ("sort_threshold", "sort_area", "sort_wrong", "sort_wrong_low", "sort_wrong_high")
# What stands in place of the name of the quantity that foretells, if none does, or if too few parts differ.
NONE, NO_RULE = "no single quantity", "no rule: too few parts fail, or too few do not"


class SortingRule(NamedTuple):
    """Parts are good on one side of a threshold of one quantity.

    threshold : in units of the quantity; NaN where no threshold sorts better than to take or to refuse all parts
    area : share of the pairs of a good and a bad part in which the good one has the larger value, ties counting half
        (area under the curve of the receiver). From 0.5 on, good parts lie above the threshold, else below
    wrong, wrong_low, wrong_high : share of parts that were not used for the threshold and that it sorts wrongly, with
        its 95 % interval
    fitted : share sorted wrongly of the parts that the threshold is fitted to. Rules are chosen by it, since the
        interval of the least of several shares would be too low
    """

    threshold: float
    area: float
    wrong: float
    wrong_low: float
    wrong_high: float
    fitted: float


def sorting_rule(values: np.ndarray, kept: np.ndarray) -> SortingRule:
    """Return the rule by one quantity with the fewest parts sorted wrongly.

    The first half of the parts gives area and threshold, the second half the share sorted wrongly: a share of the
    parts that the threshold was fitted to would be too small.

    values : (n,), the quantity of each part; NaN where the part has none, which counts as bad
    kept : (n,), whether a part keeps the specification. Both halves have to have good and bad parts
    """
    half = len(kept) // 2
    known = np.isfinite(values[:half])
    area = area_under_curve(values[:half][known], kept[:half][known])
    sign = -1.0 if area < 0.5 else 1.0
    scores = np.where(np.isfinite(values), sign * values, -np.inf)
    cut = _best_cut(scores[:half], kept[:half])
    wrong = (scores > cut) != kept
    share, low, high = shares(np.array([wrong[half:].sum()]), len(kept) - half)
    threshold = sign * cut if np.isfinite(cut) else np.nan
    fitted = float(wrong[:half].mean())
    return SortingRule(threshold, area, float(share[0]), float(low[0]), float(high[0]), fitted)


def area_under_curve(values: np.ndarray, kept: np.ndarray) -> float:
    """Return the share of pairs (good, bad) whose good part is larger, from ranks; 0.5 without such pairs."""
    from scipy.stats import rankdata

    good, bad = int(kept.sum()), int((~kept).sum())
    if not good * bad:
        return 0.5
    above: float = rankdata(values)[kept].sum() - 0.5 * good * (good + 1)
    return float(above / (good * bad))


def _best_cut(scores: np.ndarray, kept: np.ndarray) -> float:
    """Return where parts above are best taken as good: between two scores, or at -inf (all) or inf (none)."""
    order = np.argsort(scores)
    ordered, good = scores[order], kept[order]
    # Wrong with the n lowest refused: the good ones among them, and the bad ones above.
    wrong = np.append(0, np.cumsum(good)) + np.append(np.cumsum(~good[::-1])[::-1], 0)
    cuts = np.concatenate([[-np.inf], 0.5 * (ordered[1:] + ordered[:-1]), [np.inf]])
    # No cut lies between equal scores, nor in parts without a value.
    is_cut = np.concatenate([[True], ordered[1:] > ordered[:-1], [True]])
    is_cut[1:-1] &= np.isfinite(cuts[1:-1])
    return float(cuts[is_cut][np.argmin(wrong[is_cut])])


def foretells(wrong_high: float, kept: np.ndarray) -> bool:
    """Return whether at most this share of wrong parts is surely fewer than by taking all of them, or none."""
    tested = kept[len(kept) // 2 :]
    lesser = min(int(tested.sum()), int((~tested).sum()))
    _, low, _ = shares(np.array([lesser]), len(tested))
    return bool(wrong_high < low[0])


def can_sort(kept: np.ndarray) -> bool:
    """Return whether a rule can be fitted to the first half of the parts, and one without error shown by the second."""
    fitted = kept[: len(kept) // 2]
    _, _, high = shares(np.array([0]), len(kept) - len(fitted))
    return bool(fitted.any() and not fitted.all() and foretells(high[0], kept))


def yield_variables(
    bounds: Sequence[Bound], points: Points, law: np.ndarray, each: np.ndarray, all_kept: np.ndarray
) -> Variables:
    """Return the shares of the first points that keep a law of motion and bounds, together and each (`kept_parts`)."""
    n = len(all_kept)
    law_kept = points.has_law(law)[:n]
    share, low, high = shares(np.array([all_kept.sum()]), n)
    whole = {
        "yield": share[0],
        "yield_low": low[0],
        "yield_high": high[0],
        "law_yield": law_kept.mean(),
    }
    variables: Variables = {name: ((), np.array(value)) for name, value in whole.items()}
    for bound, kept in zip(bounds, each, strict=True):
        name = bound.quantity
        (_, *dims), values = points.variables[name.variable]
        empty = (tuple(dims), np.full(values.shape[1:], np.nan))
        if not name.part:
            _, shares_kept = variables.setdefault(f"{name.variable}_yield", empty)
            shares_kept[() if name.number is None else name.number - 1] = kept.mean()
    return variables


def kept_parts(
    bounds: Sequence[Bound], points: Points, law: np.ndarray, n: int, half: float
) -> tuple[np.ndarray, np.ndarray]:
    """Return which of the first n points keep each bound (bounds, n), and which all of them and a law (n,)."""
    each = np.array([bound.kept_at(points, half)[:n] for bound in bounds])
    return each, points.has_law(law)[:n] & each.all(axis=0)


def sorting_variables(
    names: Sequence[Named],
    scattered: Sequence[str],
    point: Points,
    points: Points,
    kept: np.ndarray,
) -> tuple[Variables, str]:
    """Return the sorting rules of a design, and the name of the best one; none where they cannot be shown.

    names : quantities that have a rule, all parts of each
    scattered : parameters that have a rule
    point : the design, one point
    points : its scattered parts, and others after them
    kept : (n,), which of the first n points are good
    """
    if not can_sort(kept):
        return {}, NO_RULE
    parameters = [named(name, "quantity") for name in scattered]
    rules = {}
    for name in (*names, *parameters):
        own = name.values(point.variables, point.parameters)[0]
        # Phases are compared on the turn of the nominal part.
        moved = name.difference(name.values(points.variables, points.parameters)[: len(kept)], own)
        rules[name] = sorting_rule(own + moved, kept)
    variables: Variables = {}
    for column, suffix in enumerate(SORTING):
        table = np.array([rules[name][column] for name in names])
        variables |= gathered(names, table, suffix, ())
        variables |= {
            f"{each.name}_{suffix}": ((), np.array(rules[each][column])) for each in parameters
        }
    best = min(rules, key=lambda name: rules[name].fitted)
    return variables, best.name if foretells(rules[best].wrong_high, kept) else NONE


def stacked(rules: Sequence[Variables], dim: str) -> Variables:
    """Return the rules of each design, or point, over a dimension; NaN of those that have none, if any has."""
    known = next(filter(None, rules), {})
    nothing = {
        name: (dims, np.full(values.shape, np.nan)) for name, (dims, values) in known.items()
    }
    whole = [each or nothing for each in rules]
    return {
        name: ((dim, *dims), np.stack([each[name][1] for each in whole]))
        for name, (dims, _) in known.items()
    }
