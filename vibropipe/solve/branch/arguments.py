"""Arguments of `branch`, as they must be."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from typing import TYPE_CHECKING

from vibropipe.orbits.branches.switching import SWITCHES
from vibropipe.physics.exciter import Exciter, ParameterError
from vibropipe.physics.ties import TIED, Ties
from vibropipe.solve.checks import check_outputs
from vibropipe.solve.design.scattered_parts import check_tolerances
from vibropipe.words.bifurcations import BESIDE_LAW, without_slope
from vibropipe.words.outputs import OF_BRANCH
from vibropipe.words.regimes import Regime

if TYPE_CHECKING:
    import xarray as xr

MUST_REPEAT = "must lead from (x0, v0) to an orbit that repeats with the force"


def check_branch_outputs(outputs: Sequence[str]) -> tuple[str, ...]:
    """Return the outputs of points, or raise a ParameterError."""
    requested = check_outputs(outputs)
    if not set(requested) <= set(OF_BRANCH):
        raise ParameterError("outputs", outputs, f"a list of {', '.join(OF_BRANCH)}")
    return requested


def check_place_tolerance(
    exciter: Exciter,
    along: str,
    tolerance: Mapping[str, float] | None,
    outputs: Sequence[str],
    ties: Ties,
) -> dict[str, float] | None:
    """Return the standard deviations of parameters, or raise a ParameterError."""
    if tolerance is None:
        return None
    sigma = check_tolerances(exciter, tolerance)
    missing = without_slope(exciter.numbers()._asdict(), along)
    missing |= dict.fromkeys(ties.parameters, TIED)
    for name in sigma:
        if name in missing:
            raise ParameterError(f"tolerance.{name}", sigma[name], must=missing[name])
    if "sensitivity" in outputs:
        must = "must leave out sensitivity beside tolerance: both have a dimension parameter of their own"
        raise ParameterError("outputs", outputs, must=must)
    return sigma


def check_switch(switch: Collection[str]) -> tuple[str, ...]:
    """Return the kinds of bifurcation to switch at, or raise a ParameterError."""
    if isinstance(switch, str) or not set(switch) <= set(SWITCHES):
        raise ParameterError("switch", switch, f"a list of {', '.join(SWITCHES)}")
    return tuple(switch)


def check_start(exciter: Exciter, start: xr.Dataset) -> None:
    """Raise a ParameterError unless a steady state is an orbit that repeats with the force."""
    regime = Regime(int(start.regime))
    is_free = exciter.f == exciter.f2 == 0.0 and exciter.h == 0.0
    if int(start.period_multiple) == 0 or is_free:
        got = f"a motion with the regime {regime.name.lower()}"
        raise ParameterError("exciter", exciter, must=MUST_REPEAT, got=got)


def check_alone(x0: float | None, v0: float | None, switch: Collection[str]) -> None:
    """Raise a ParameterError where a start or bifurcations stand beside a law."""
    for name, value in (("x0", x0), ("v0", v0), ("switch", switch or None)):
        if value is not None:
            raise ParameterError(name, value, must=BESIDE_LAW)
