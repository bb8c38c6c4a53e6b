"""The scripts of the page, which run in the browser."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from bokeh.models import CustomJS, CustomJSTickFormatter


def source_of(name: str) -> str:
    """Return the text of a script of this folder."""
    return Path(__file__).with_name(name).read_text(encoding="utf-8")


def short_ticks() -> CustomJSTickFormatter:
    """Return what writes ticks in their shortest form."""
    return CustomJSTickFormatter(code=source_of("ticks.js"))


def script(name: str, **arguments: Any) -> CustomJS:
    """Return a script of this folder as a callback; its arguments are models and values by name."""
    return CustomJS(args=arguments, code=source_of(name))
