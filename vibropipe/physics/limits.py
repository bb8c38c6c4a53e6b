"""Limits of what can be asked for, each (least, most): one place for calls from Python and for studies."""

from __future__ import annotations

# Error allowed; what double precision cannot reach is solved and marked so (status `inaccurate`).
ACCURACY = (1e-15, 0.1)
# Steps of Newmark's method in a forcing period, and steps of a whole march: some minutes.
STEPS_PER_PERIOD = (1, 10**8)
MAX_MARCH_STEPS = 10**11
# Samples of a motion: in a forcing period, and in all.
MAX_SAMPLES = 2 * 10**8
SAMPLES_PER_PERIOD = (0, MAX_SAMPLES)
# End of a motion of a study; a call from Python is bounded by its steps alone.
MAX_TAU = 1e9
# Harmonics of an orbit.
HARMONICS = (1, 1000)
# Forcing periods after which a chaotic row is left: as long as the window it is measured over, or the longest march.
PATIENCE = (256, 1000)


def within_text(limits: tuple[float, float], kind: str = "a whole number") -> str:
    """The limits in words: "a whole number from 1 to 1000"."""
    least, most = (f"{end:g}".replace("e+0", "e").replace("e-0", "e-") for end in limits)
    return f"{kind} from {least} to {most}"
