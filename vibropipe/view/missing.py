"""The page needs Bokeh, which comes with the extra `view`."""

from __future__ import annotations

from importlib.util import find_spec

from vibropipe.store import StoreError


def check_installed() -> None:
    """Raise a StoreError that says how to install Bokeh, if it is missing."""
    if find_spec("bokeh") is None:
        raise StoreError("bokeh: is not installed: pip install 'vibropipe[view]'")
