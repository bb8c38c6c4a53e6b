"""What a proof is about, and how it ended."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from enum import IntEnum
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from vibropipe.words.designs import Reasoned
from vibropipe.words.parameters import PARAMETERS
from vibropipe.words.records import POSITIVE, Range

if TYPE_CHECKING:
    import xarray as xr

BOXED = (
    *("nu", "f", "h", "l", "delta", "R1", "R2", "load", "f2", "phi2", "shaker"),
    *("k1", "h1", "k2", "h2", "friction"),
)
"""The parameters on which the motions that are proved depend, those of the boxes of a proof."""
PREFIX = "proof_"
"""Of what a certificate adds to the dataset of a scene: `proof_<name>` is `<name>` of the proof."""
REFUSED = f"{PREFIX}refused"
"""Attribute: why nothing was tried to prove."""
SAME_PLACE = 1e-9  # of points of branches, as a share of the largest value
MISSING = "python-flint: is required for proofs and not installed"


def range_in_boxes(name: str) -> Range:
    """Return the range of a parameter in a box: without stiffness a support would be another one, a rigid one."""
    return POSITIVE if name in ("k1", "k2") else PARAMETERS[name].range


# Of each support, R, k and h.
_OF_SUPPORTS = {f"{kind}{n}": (kind, n) for kind in "Rkh" for n in (1, 2)}


def kept_from_boxes(
    name: str, values: Mapping[str, Any], states: Callable[[str], bool]
) -> str | None:
    """Return why a parameter may not vary in a proof; None if it may.

    values : of the exciter; states : returns whether it states the damping of a support by itself.
    """
    if name == "friction" and not np.all(values.get(name, 0.0)):
        return "there is no friction"
    kind, n = _OF_SUPPORTS.get(name, ("", 0))
    is_soft = n > 0 and bool(np.all(values.get(f"k{n}", 0.0)))
    if kind in ("k", "h") and not is_soft:
        return f"support {n} is rigid"
    if kind in ("R", "k") and is_soft and not states(f"h{n}"):
        return f"h{n} is not stated and would follow it"
    return None


def holds_by_more(values: Mapping[str, Any]) -> bool:
    """Return whether friction may hold a mass against more than it slides against: proofs know one friction."""
    ratio = np.asarray(values.get("friction_ratio", 1.0))
    return bool(np.any(values.get("friction", 0.0)) and np.any(ratio != 1.0))


class Proved(IntEnum):
    """Whether a statement is proved, or disproved by a counterexample."""

    UNDECIDED = 0
    PROVED = 1
    DISPROVED = 2


class ProvedStable(IntEnum):
    """Which stability of an orbit is proved."""

    UNDECIDED = -1
    UNSTABLE = 0
    STABLE = 1


class Why(Reasoned):
    """What of a statement is not proved, or is disproved."""

    NONE = 0, "nothing"
    EXISTENCE = 1, "that the orbit exists and is the only one nearby"
    MOTION = 2, "that the mass does between its impacts what its law says"
    PERIOD = 3, "that the orbit has no shorter period"
    STABILITY = 4, "on which side of the unit circle the multipliers lie"
    FAMILY = 5, "that the orbits of all parts are one family"
    PARTS = 6, "with the parts that were allowed"
    NOT_TRIED = 7, "since only orbits that strike a support and do not rest on one are tried"
    SYMMETRY = 8, "that exciter and orbit are their own mirror images along this parameter"
    RETURN = 9, "that motions from near the orbit settle on it"


class Tally(NamedTuple):
    """Numbers of rows that are proved, disproved, were tried and were not."""

    proved: int
    disproved: int
    tried: int
    not_tried: int


def _begin_at_bifurcations(branches: xr.Dataset) -> list[int]:
    """Return the points with which branches begin at a bifurcation of another one."""
    firsts = np.flatnonzero(np.diff(branches["branch_id"].values)) + 1
    points = branches["bifurcation_point"].values
    along = next(
        name for name in map(str, branches.coords)
        if name != "point" and f"bifurcation_{name}" in branches.coords
    )  # fmt: skip
    values = branches[along].values
    reach = SAME_PLACE * np.abs(values).max()
    return [n for n in firsts.tolist() if (np.abs(values[points] - values[n]) <= reach).any()]


def tally(rows: xr.Dataset, proved: np.ndarray, why: np.ndarray) -> Tally:
    """Count rows, or points of a branch, by how their proofs ended.

    Orbits at a bifurcation, also those with which a branch begins there, are about to end, by rounding on either side:
    they are left out.
    """
    if "bifurcation_point" in rows:
        at = [*rows["bifurcation_point"].values, *_begin_at_bifurcations(rows)]
        proved, why = np.delete(proved, at), np.delete(why, at)
    tried = int((why != Why.NOT_TRIED).sum())
    yes, no = (int((proved == code).sum()) for code in (Proved.PROVED, Proved.DISPROVED))
    return Tally(yes, no, tried, why.size - tried)
