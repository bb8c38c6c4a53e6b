"""How fast this is, measured side by side with peers in one run: `vibropipe bench`."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from vibropipe.bench.cases import items
    from vibropipe.bench.formatting import as_json, as_text
    from vibropipe.bench.measurement import measure

# Imported on first use: `vibropipe.bench.growth` measures the memory of processes that must not hold numba.
_HOME = {
    "as_json": "formatting",
    "as_text": "formatting",
    "items": "cases",
    "measure": "measurement",
}
__all__ = ["as_json", "as_text", "items", "measure"]


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_HOME[name]}"), name)
