"""Limits of requests, each (least, largest), for calls from Python and for studies."""

from __future__ import annotations

from vibropipe.words.records import Range

# Requested error. One that double precision cannot reach is accepted; the result has the status `inaccurate`.
ACCURACY = (1e-15, 0.1)
# Newmark steps per forcing period. Work of a march, in steps: of free flights (5 ns each, some three seconds), and of
# pieces with soft supports or friction, each of which has a polynomial (200 to 460 ns) that takes as long as 40 to 90.
STEPS_PER_PERIOD, POLYNOMIAL_STEPS = (1, 10**8), 100
# Largest number of steps per forcing period whose force is tabulated: both tables then fit a second-level cache. A step
# whose force is computed takes as long as so many others.
MAX_TABLE, COMPUTED_STEPS = 8192, 4
# A step of the integrals of all derivatives (8 us) takes as long as so many steps of a march.
INTEGRAL_STEPS = 1500
MAX_MARCH_STEPS = 6 * 10**8
# The same of a row: a quarter of a second. No row of the default sweeps needs more than a quarter of it.
MAX_ROW_WORK = 5 * 10**7
MAX_PIECE_STEPS = MAX_MARCH_STEPS // POLYNOMIAL_STEPS
# What the many marches of a call share: some two seconds. A row gets MIN_ROW_WORK of it at least, and a start adds
# START_WORK, several times what it usually takes.
MAX_CALL_WORK, MIN_ROW_WORK, START_WORK = 3 * 10**8, 5 * 10**6, 5 * 10**5
# Samples of a motion: in all (some four seconds), and per forcing period.
MAX_SAMPLES = 2 * 10**7
SAMPLES_PER_PERIOD = (0, MAX_SAMPLES)
# Largest tau_end of a study; a call from Python is limited by MAX_MARCH_STEPS alone.
MAX_TAU = 1e9
# Number of harmonics of an orbit.
HARMONICS = (1, 1000)
# Forcing periods before a row may be labelled aperiodic: from the window that it is then measured over to the longest
# march.
PATIENCE = (128, 1000)
# Forcing periods, and impacts on each support, of a law of motion whose stretches are sought.
LAW_PERIODS, LAW_IMPACTS = (1, 32), (0, 64)
LAW_TEXT = "a period multiple from 1 to 32, and impacts on each support from 0 to 64"
# Lines along each parameter from which boundaries are sought.
BOUNDARY_LINES = (1, 200)


def max_march_steps(per_period: float) -> int:
    """Return the largest number of steps of a march with so many steps per forcing period."""
    return MAX_MARCH_STEPS // (COMPUTED_STEPS if per_period > MAX_TABLE else 1)


def row_work(n: int) -> int:
    """Return what each of n rows of a call may take, in steps."""
    return min(MAX_ROW_WORK, max(MIN_ROW_WORK, MAX_CALL_WORK // max(1, n)))


def within_text(limits: tuple[float, float], whole: bool = True) -> str:
    """Return limits as a noun phrase: "a whole number from 1 to 1000"."""
    return Range(*limits, whole=whole).text
