"""Text that would be markup, attributes of datasets, and what can be read in a typeset report."""

from __future__ import annotations

HOSTILE = (
    '#panic("no") $x$ *b* _i_ `c` @a <l> \\ // /* "q" #import "x": * https://a.b'
    ' = - + ~ {{}} [#read("/etc/passwd")]'
)
PROVENANCE = {
    "source": "vibropipe 0.1.0",
    "git_commit": "0123456789abcdef",
    "kernel_hash": "f4b9249e4ecc5c1e",
    "study_hash": "0636f6f3127e35600f6b",
    "fingerprint": "764a982da44fcee6fb30",
    "versions": '{"python": "3.11.7", "numpy": "2.4.6"}',
    "accuracy_asked": 1e-8,
    "accuracy_reached": "none",
}


def plain(element) -> str:
    """Return all text inside a queried element, spaces run together."""
    if isinstance(element, dict):
        if element.get("func") == "space":
            return " "
        parts = [plain(value) for key, value in element.items() if key not in ("func", "alt")]
        return "".join(parts)
    if isinstance(element, list):
        return "".join(plain(item) for item in element)
    return element if isinstance(element, str) else ""
