"""Settings shared by all tests."""

import signal
from pathlib import Path

import pytest
from hypothesis import HealthCheck, settings

# What a shell starts in the background ignores Ctrl-C, and so would all that the tests start and interrupt.
signal.signal(signal.SIGINT, signal.default_int_handler)

# The same examples every time: a red run can be repeated, and the slow marker looks further.
settings.register_profile(
    "vibropipe",
    max_examples=40,
    deadline=None,
    derandomize=True,
    suppress_health_check=[HealthCheck.too_slow],
)
settings.load_profile("vibropipe")


def pytest_ignore_collect(collection_path: Path, config: pytest.Config) -> bool | None:
    """Leave out what measures time where tests run side by side (`pytest -n 2`)."""
    return True if collection_path.name == "benchmarks" and hasattr(config, "workerinput") else None


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Begin with the workflow: side by side, its long runs of snakemake would be what all wait for at the end, and
    taken apart they would need a finished project each."""
    items.sort(key=lambda item: not item.nodeid.startswith("tests/workflow/"))
