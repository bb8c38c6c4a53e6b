"""Hard cases: motions with known properties, measured by both methods (`solve_hard_cases`)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from vibropipe.lab.hard_cases.case import Case, Measured, Solver, evaluate_case, solvers
from vibropipe.lab.hard_cases.cases import CASES
from vibropipe.words.measurements import Passed
from vibropipe.words.progress import Progress
from vibropipe.words.vocabulary import describe

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["CASES", "solve_hard_cases"]

NOT_PASSED, PASSED, NOT_ASKED = Passed


def solve_hard_cases(
    cases: Sequence[Case] = CASES,
    by: Sequence[Solver] | None = None,
    progress: Progress | None = None,
) -> xr.Dataset:
    """Measure each case by each solver: the exact method, and Newmark's with coarse to fine steps.

    Parameters
    ----------
    cases : sequence of Case
        Cases to measure.
    by : sequence of Solver, optional
        Solvers; default `solvers()`.
    progress : callable, optional
        Called as `progress(done, total)` with the number of cases.

    Returns
    -------
    xarray.Dataset
        Over `case` and `solver`: `measured` deviation, its `bound`, `passed` (not_passed, passed, or not_asked where
        the case does not apply to the solver), `worst_status`, and the effort: `motions` solved, `impacts` in them, and
        `short_flight_motions`, those with flights shorter than the step. Over `case`, as text: `asked`, the
        description, and `known`, the known property.
    """
    import xarray as xr

    by = solvers() if by is None else by
    rows = []
    for case in cases:
        results = [evaluate_case(case, solver) for solver in by]
        rows.append(
            [[NOT_ASKED if value is None else value for value in result] for result in results]
        )
        if progress is not None:
            progress(len(rows), len(cases))
    table = np.array(rows, float)
    variables: dict[str, Any] = {
        "asked": ("case", np.array([case.description for case in cases])),
        "known": ("case", np.array([case.expected for case in cases])),
    }
    for index, name in enumerate(Measured._fields):
        is_code = name in ("passed", "worst_status")
        dtype = float if name in ("measured", "bound") else np.int8 if is_code else np.int64
        variables[name] = (("case", "solver"), table[..., index].astype(dtype))
    names = ", ".join(solver.name for solver in by)
    coords = {"case": [case.name for case in cases], "solver": [solver.name for solver in by]}
    return describe(xr.Dataset(variables, coords, {"method": f"{names} steps per forcing period"}))
