"""Ranges of parameters that are sought, and the exciter at their lower ends."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from vibropipe.physics.exciter import Exciter, ParameterError
from vibropipe.physics.parameter_error import check_keys
from vibropipe.physics.stated import stated_names
from vibropipe.physics.ties import Ties
from vibropipe.solve.checks import check_varied, with_frequency
from vibropipe.words.parameters import CONTINUOUS, PARAMETERS
from vibropipe.words.records import FINITE


def at_lower_ends(
    exciter: Exciter,
    ranges: Mapping[str, tuple[float, float]],
    ties: Ties,
    over: Mapping[str, float] | None = None,
) -> Exciter:
    """Return an exciter with the frequency that varies and, where any are tied, all at the lower ends of their ranges.

    over : values of parameters that the call gives as well
    Raises ParameterError where a tie has no value there, or one that its parameter cannot have.
    """
    lows = {name: ends[0] for name, ends in ranges.items()} | dict(over or {})
    tied = ties.checked({**exciter.numbers()._asdict(), **lows}, ties.parameters)
    given = {name: value for name, value in (lows | tied).items() if name in PARAMETERS}
    exciter = with_frequency(exciter, given)
    return replace(exciter, **given) if ties else exciter


def check_vary(
    exciter: Exciter,
    vary: Mapping[str, tuple[float, float]],
    ties: Ties,
    over: Mapping[str, float] | None = None,
) -> dict[str, tuple[float, float]]:
    """Return the ranges of varied parameters in the order of the parameters, or raise a ParameterError.

    Names of one's own that ties use come last.

    over : values of parameters that the call gives as well
    """
    if not vary:
        raise ParameterError("vary", vary, must="must have at least one parameter with its range")
    check_keys("vary", vary, (*CONTINUOUS, *ties.own, *ties.expressions))
    ties.check(stated_names(exciter), [*vary, *(over or ())], "vary")
    for name, ends in vary.items():
        try:
            low, high = map(float, ends)
        except (TypeError, ValueError):
            low, high = np.nan, np.nan
        if not low < high:
            raise ParameterError(f"vary.{name}", ends, "a pair of increasing numbers")
        limits = PARAMETERS[name].range if name in PARAMETERS else FINITE
        if not (limits.contains(low) and limits.contains(high)):
            raise ParameterError(f"vary.{name}", ends, f"within its range, {limits.text}")
    names = [name for name in (*PARAMETERS, *ties.own) if name in vary]
    ranges = {name: (float(vary[name][0]), float(vary[name][1])) for name in names}
    spans = ties.spans({**exciter.numbers()._asdict(), **(over or {})}, ranges)
    lows = {name: low for name, (low, _) in (ranges | spans).items() if name in PARAMETERS}
    check_varied("vary", exciter, lows, lows)
    return ranges
