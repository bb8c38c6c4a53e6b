"""Status of a motion or row: a kernel reports every failure here, since it never raises."""

from __future__ import annotations

from enum import IntEnum


class UnsolvedWarning(UserWarning):
    """A motion or rows of a sweep did not end as requested, or branches or boundaries are left.

    Notes
    -----
    A call warns once for each status other than `ok`, with the number of rows and the remedy; the variable `status` of
    the dataset says which rows have it. A call that follows branches or boundaries warns of those that it left, as the
    attribute `incomplete` says. `warnings.simplefilter("error", vp.UnsolvedWarning)` makes an error of each.
    """


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
        """What happened and what to change, in a sentence or two."""
        return _REMEDIES[self]


_REMEDIES = {
    Status.OK: "The motion was computed as requested.",
    Status.MAX_IMPACTS: (
        "The limit on impacts was reached before `tau_end`, or within a forcing period of a steady state. Shorten "
        "`tau_end`, raise `max_impacts`, or keep R further from 1."
    ),
    Status.MAX_PERIODS: (
        "No orbit was found within the period limit; outputs are averages over the last forcing periods."
    ),
    Status.ROOT_BOUND: (
        "The search for an impact reached its limit. Raise `steps_per_period`, or check that the parameters are "
        "within ten decades of each other."
    ),
    Status.NOT_FINITE: (
        "The motion left the range of floating-point numbers. Reduce f, `tau_end` or the ratio of the parameters."
    ),
    Status.SHORT_FLIGHTS: (
        "Some flights were shorter than a step. Raise `steps_per_period` or use the exact method."
    ),
    Status.LOG_FULL: (
        "One orbit, or one forcing period of a motion without an orbit, has more contacts than the log holds; "
        "the row has no outputs. Raise nu, or lower f or R."
    ),
    Status.INACCURATE: (
        "Rounding errors grow beyond the requested accuracy; the reported error estimates are valid. Shorten `tau_end` "
        "or allow a larger error."
    ),
    Status.SUPPORT_REACHED: (
        "The motion was stopped at a support that `effects` leaves out. Add the support to `effects`."
    ),
    Status.MAX_STEPS: (
        "The march takes too many steps, more than in some seconds. Raise nu, shorten `tau_end`, or lower h or the "
        "stiffness of the soft supports, or give these damping: fast vibrations in contact then decay."
    ),
}
