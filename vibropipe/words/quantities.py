"""Every quantity that a dataset can hold, once, as a record (`quantities.toml`) that all other modules read.

Stored numbers depend on `facts` of these records alone; their texts may change without a new result.
"""

from __future__ import annotations

import tomllib
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from enum import IntEnum
from operator import attrgetter
from pathlib import Path
from typing import Any

from vibropipe.words.bifurcations import Bifurcation, BranchEnd, Meeting
from vibropipe.words.designs import DesignResult, FitResult, FoundResult, ToleranceResult, Twin
from vibropipe.words.exciter import PARAMETERS, source_of
from vibropipe.words.measurements import Outcome, Passed
from vibropipe.words.proofs import Proved, ProvedStable, Why
from vibropipe.words.regimes import Chaos, Regime
from vibropipe.words.status import Status
from vibropipe.words.units import DIMENSIONS


def _members(kind: type[IntEnum]) -> dict[str, int]:
    return {member.name.lower(): int(member) for member in kind}


REGIMES: Mapping[str, int] = _members(Regime)
FLAGS: Mapping[str, Mapping[str, int]] = {
    "regime": REGIMES,
    "status": _members(Status),
    "outcome": _members(Outcome),
    "support": {"support_1": 1, "support_2": 2},
    "chaos": _members(Chaos),
    "stable": {"unstable": 0, "stable": 1},
    "settled_from": {"ramp": 0, "rest": 1},
    "settled_same": {"unknown": -1, "other": 0, "same": 1},
    "admissible": {"inadmissible": 0, "admissible": 1},
    "passed": _members(Passed),
    "bifurcation_kind": _members(Bifurcation),
    "end_reason": _members(BranchEnd),
    "border": {"inside": 0, "at_border": 1},
    "attractor_change": {"vanishes": 0, "appears": 1},
    "boundary_kind": {
        **{name: code for name, code in _members(Bifurcation).items() if code < Bifurcation.END},
        "level": 4,
    },
    "meeting_kind": _members(Meeting),
    "meeting_ends": {"goes_on": 0, "ends": 1},
    "jump_way": {"lowered": 0, "raised": 1},
    "design_result": _members(DesignResult),
    "tolerance_result": _members(ToleranceResult),
    "fit_result": _members(FitResult),
    "parameter_result": _members(FoundResult),
    "twin_kind": _members(Twin),
    "proved": _members(Proved),
    "proved_stable": _members(ProvedStable),
    "why": _members(Why),
}
"""Names of integer values."""


@dataclass(frozen=True)
class Quantity:
    """A quantity of a dataset.

    long_name, symbol, plain : as in datasets and on axes; as matplotlib mathtext, and as plain text where sentences
        need it
    dims : its dimensions in the smallest dataset that holds it. Swept dimensions (or `row` in a shard) come before
        them, and a motion over one orbit runs over `phase` in place of `tau`
    units : lengths are in the unit chosen for l, times in 1/p with p = sqrt(C/m), eqs. (2)-(4)
    flags : the names of its integer values
    sample_dimension : of a count per row, the dimension of what it counts (CF)
    dimension : its physical dimension (`words.units.DIMENSIONS`), as that of its error; "" of a pure number
    si : its name in a dataset in SI, if another one, and its words there
    comment : an attribute in datasets
    axis : of a coordinate: "parts" of a quantity, which are columns of a table, or "events", listed one after the other
    output : of a steady state, the output that has it, "" of every row; else None
    effect : of a steady state, the effect without which none has it
    bytes : of a number on disk
    is_signed, is_complex, is_constant, is_loss : whether it may be negative, is complex, is the same in all steady
        states, or is energy that is lost
    has_error, has_derivative : whether steady states have an estimate of its error, and its derivatives by the
        parameters
    largest_of : the quantity of impacts of which it is the largest at a support
    goal : whether a design may take it: "smooth" in the parameters, a whole number or fraction of the "law" of motion,
        or the "place" of a bifurcation
    short : two to four words, where the long name would be too long
    drawn : the kinds of scenes whose pictures show it if a study asks for it
    function : of a quantity that others give: takes the quantities of the rows and their parameters, both by name, and
        returns its values (rows, *dims)
    """

    long_name: str
    symbol: str
    dims: tuple[str, ...] = ()
    units: str = "1"
    plain: str = ""
    flags: Mapping[str, int] | None = None
    sample_dimension: str | None = None
    dimension: str = ""
    si: Mapping[str, str] = field(default_factory=dict)
    comment: str = ""
    axis: str = ""
    output: str | None = None
    effect: str = ""
    bytes: int = 8
    is_signed: bool = False
    is_complex: bool = False
    is_constant: bool = False
    is_loss: bool = False
    has_error: bool = False
    has_derivative: bool = False
    largest_of: str = ""
    goal: str = ""
    short: str = ""
    drawn: tuple[str, ...] = ()
    function: Callable[[Mapping[str, Any], Mapping[str, Any]], Any] | None = None

    def in_si(self) -> Quantity:
        """Return the record in a dataset in SI."""
        symbol = self.symbol.replace(r"\nu\tau", r"\omega t").replace(r"\tau", "t")
        dims = tuple(QUANTITIES[dim].si.get("name", dim) for dim in self.dims)
        units = DIMENSIONS[self.dimension].units if self.dimension else self.units
        words: dict[str, Any] = {key: text for key, text in self.si.items() if key != "name"}
        return replace(self, **{"symbol": symbol, "dims": dims, "units": units, **words})

    def of_the_orbit(self) -> Quantity:
        """Return the record of the same of the steady state of a motion."""
        where = "of the steady state" if self.output == "energy" else "in the orbit"
        dims = tuple("orbit_impact" if dim == "impact" else dim for dim in self.dims)
        long_name = f"{self.long_name} {where}"
        return replace(self, long_name=long_name, dims=dims, output=None, goal="", drawn=())


def _of_each_parameter(name: str, words: dict[str, Any]) -> dict[str, dict[str, Any]]:
    """Return the entries of the table for one whose name stands for a quantity of each parameter."""
    if "{}" not in name:
        return {name: words}
    entries = {}
    for each in PARAMETERS:
        # beside another noun the name of a parameter has no remark, "0 if rigid"
        noun = each.long_name if name == "{}" else each.long_name.partition(",")[0]
        entry = {
            **words,
            **{"symbol": each.symbol, "plain": each.plain, "units": each.units},
            "long_name": words["long_name"].format(noun),
            "dimension": each.dimension if each.units == "1" else "",
        }
        if each.physical is not None and each.physical.name != each.name:
            si = {key: getattr(each.physical, key) for key in ("symbol", "plain", "long_name")}
            if each.physical.dimension:
                si["units"] = DIMENSIONS[each.physical.dimension].units
            si = {key: text for key, text in si.items() if text}
            if "long_name" in si:
                si["long_name"] = words["long_name"].format(si["long_name"])
            entry["si"] = {"name": name.format(each.physical.name), **si}
        entries[name.format(each.name)] = entry
    return entries


def _table() -> dict[str, Quantity]:
    """Return the quantities of `quantities.toml`, and those that a motion has of its steady state."""
    text = Path(__file__).with_name("quantities.toml").read_text(encoding="utf-8")
    table = {
        each: Quantity(
            dims=tuple(entry.pop("dims", "").split()),
            drawn=tuple(entry.pop("drawn", "").split()),
            flags=FLAGS.get(entry.pop("flags", "")),
            **entry,
        )
        for subject in tomllib.loads(text).values()
        for name, words in subject.items()
        for each, entry in _of_each_parameter(name, dict(words)).items()
    }
    of_orbit = {
        f"orbit_{name}": entry.of_the_orbit()
        for name, entry in table.items()
        if entry.output == "energy"
        or (entry.output in ("impacts", "frame") and entry.dims == ("impact",))
    }
    return {**table, **{name: entry for name, entry in of_orbit.items() if name not in table}}


QUANTITIES: dict[str, Quantity] = _table()
"""The order of quantities in files."""


def facts() -> str:
    """Return what stored numbers depend on in the records."""
    facts_of = attrgetter("dims", "output", "largest_of", "has_error", "has_derivative")
    rows = [(name, each) for name, each in QUANTITIES.items() if each.output is not None]
    return repr([(name, *facts_of(each), source_of(each.function)) for name, each in rows])
