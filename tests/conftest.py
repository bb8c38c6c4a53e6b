"""Settings shared by all tests."""

from hypothesis import HealthCheck, settings

# The same examples every time: a red run can be repeated, and the slow marker looks further.
settings.register_profile(
    "vibropipe",
    max_examples=300,
    deadline=None,
    derandomize=True,
    suppress_health_check=[HealthCheck.too_slow],
)
settings.load_profile("vibropipe")
