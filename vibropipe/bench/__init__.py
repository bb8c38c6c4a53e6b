"""How fast this is, measured side by side with peers in one run: `vibropipe bench`."""

from vibropipe.bench.items import items
from vibropipe.bench.rounds import measure
from vibropipe.bench.told import as_json, as_text

__all__ = ["as_json", "as_text", "items", "measure"]
