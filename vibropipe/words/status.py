"""What became of a row: a kernel never raises and never returns a plausible number on failure."""

from __future__ import annotations

from enum import IntEnum


class Status(IntEnum):
    """Outcome of one motion or one row; `remedy` says what to change."""

    OK = 0
    MAX_IMPACTS = 1
    MAX_PERIODS = 2
    ROOT_BOUND = 3
    NOT_FINITE = 4
    SHORT_FLIGHTS = 5
    LOG_FULL = 6
    INACCURATE = 7
    SUPPORT_REACHED = 8
    MAX_STEPS = 9

    @property
    def remedy(self) -> str:
        """One sentence for people: what happened and what to change."""
        return _REMEDIES[self]


_REMEDIES = {
    Status.OK: "The motion was computed as asked.",
    Status.MAX_IMPACTS: (
        "The bound on impacts was reached before tau_end, or within a forcing period of a steady state: shorten "
        "tau_end, raise max_impacts, or keep R further from 1."
    ),
    Status.MAX_PERIODS: (
        "No periodic orbit was found within the period limit; outputs are averages over the last `window_periods`."
    ),
    Status.ROOT_BOUND: (
        "The search for an impact reached its bound: raise steps_per_period, or check that the parameters are "
        "within ten decades of each other."
    ),
    Status.NOT_FINITE: (
        "The motion left the range of floating-point numbers: reduce f, tau_end or the ratio of the parameters."
    ),
    Status.SHORT_FLIGHTS: (
        "Some flights were shorter than a step: raise steps_per_period or use the exact method."
    ),
    Status.LOG_FULL: (
        "More contacts happened in one orbit, or in one forcing period of a motion without one, than are kept: its "
        "outputs would be incomplete, so it has none. Raise nu, or lower f or R."
    ),
    Status.INACCURATE: (
        "Rounding errors grow beyond the requested accuracy; the reported error estimates are valid. Shorten tau_end "
        "or allow a larger error."
    ),
    Status.SUPPORT_REACHED: (
        "The motion reaches a support that `effects` leaves out, and was stopped there: add the support to them."
    ),
    Status.MAX_STEPS: (
        "A forcing period of this row takes more than 1e8 steps, so it was not marched: raise nu, or lower h."
    ),
}
