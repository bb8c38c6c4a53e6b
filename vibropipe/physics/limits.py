"""Limits of requests, each (least, largest), for calls from Python and for studies."""

from __future__ import annotations

from vibropipe.words.exciter import Range

# Requested error. One that double precision cannot reach is accepted; the result has the status `inaccurate`.
ACCURACY = (1e-15, 0.1)
# Newmark steps per forcing period, and steps of a whole march: of free flights (5 ns each, some twenty seconds),
# and of pieces with soft supports or friction, each of which has a polynomial (200 to 460 ns, two to five seconds).
STEPS_PER_PERIOD = (1, 10**8)
MAX_MARCH_STEPS, MAX_PIECE_STEPS = 4 * 10**9, 10**7
# Samples of a motion: in all (3 GB of displacement and velocity), and per forcing period.
MAX_SAMPLES = 2 * 10**8
SAMPLES_PER_PERIOD = (0, MAX_SAMPLES)
# Largest tau_end of a study; a call from Python is limited by MAX_MARCH_STEPS alone.
MAX_TAU = 1e9
# Number of harmonics of an orbit.
HARMONICS = (1, 1000)
# Forcing periods before a row may be labelled aperiodic: from the window that it is then measured over to the longest
# march.
PATIENCE = (128, 1000)
# Lines along each parameter from which boundaries are sought.
BOUNDARY_LINES = (1, 200)


def within_text(limits: tuple[float, float], whole: bool = True) -> str:
    """Return limits as a noun phrase: "a whole number from 1 to 1000"."""
    return Range(*limits, whole=whole).text
