"""Settings shared by all tests."""

import signal

from hypothesis import HealthCheck, settings

# What a shell starts in the background ignores Ctrl-C, and so would all that the tests start and interrupt.
signal.signal(signal.SIGINT, signal.default_int_handler)

# The same examples every time: a red run can be repeated, and the slow marker looks further.
settings.register_profile(
    "vibropipe",
    max_examples=300,
    deadline=None,
    derandomize=True,
    suppress_health_check=[HealthCheck.too_slow],
)
settings.load_profile("vibropipe")
