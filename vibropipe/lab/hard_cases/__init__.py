"""Hard cases, each with what is known of it, measured by both methods: `solve_hard_cases`."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

import numpy as np

from vibropipe.lab.hard_cases.case import Case, Solver, judge, solvers
from vibropipe.lab.hard_cases.chatter import CHATTER
from vibropipe.lab.hard_cases.contacts import CONTACTS
from vibropipe.lab.hard_cases.energy import ENERGY
from vibropipe.lab.hard_cases.labels import LABELS
from vibropipe.lab.hard_cases.smooth import SMOOTH
from vibropipe.words.vocabulary import describe

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["CASES", "solve_hard_cases"]

CASES: tuple[Case, ...] = (*CONTACTS, *CHATTER, *SMOOTH, *ENERGY, *LABELS)
NOT_PASSED, PASSED, NOT_ASKED = 0, 1, 2


def solve_hard_cases(
    cases: Sequence[Case] = CASES,
    by: Sequence[Solver] | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> xr.Dataset:
    """Measure each case by each solver (the exact method, and Newmark's from coarse steps to fine).

    Returns a dataset over `case` and `solver` (their names): `asked` and `known` as text over `case`;
    `measured`, its `bound`, `passed` (not_passed, passed, not_asked where a case is not for a solver),
    `worst_status`, and the work: `motions` solved, `impacts` in them, `short_flight_motions`, those with
    flights shorter than the step. progress is told the cases measured and all of them.
    """
    import xarray as xr

    by = solvers() if by is None else by
    found = []
    for case in cases:
        found.append([judge(case, solver) for solver in by])
        if progress is not None:
            progress(len(found), len(cases))

    def column(name: str, dtype: type) -> tuple[tuple[str, str], np.ndarray]:
        return ("case", "solver"), np.array(
            [[getattr(one, name) for one in row] for row in found], dtype
        )

    passed = [
        [NOT_ASKED if one.passed is None else int(one.passed) for one in row] for row in found
    ]
    variables = {
        "asked": ("case", np.array([case.asked for case in cases])),
        "known": ("case", np.array([case.known for case in cases])),
        "measured": column("measured", float),
        "bound": column("bound", float),
        "passed": (("case", "solver"), np.array(passed, np.int8)),
        "worst_status": column("status", np.int8),
        "motions": column("motions", np.int64),
        "impacts": column("impacts", np.int64),
        "short_flight_motions": column("short_flights", np.int64),
    }
    names = ", ".join(solver.name for solver in by)
    coords = {"case": [case.name for case in cases], "solver": [solver.name for solver in by]}
    return describe(xr.Dataset(variables, coords, {"method": f"{names} steps per forcing period"}))
