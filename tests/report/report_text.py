"""Text that would be markup, attributes of datasets, and studies as a report reads them."""

from types import SimpleNamespace

from vibropipe.figures.units import display_units

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


def flat(text: str) -> str:
    """Return text without any blanks, since lines of a PDF may break anywhere."""
    return "".join(text.split())


def items(data, kind: str):
    """Return the figures or tables of a report in order, without the hero."""
    return [item for group in data["groups"] for item in group["items"] if item["type"] == kind]


def study_of(scenes, **given) -> SimpleNamespace:
    """Return a study with the keys that a report reads."""
    keys = {"name": "small", "title": "One", "question": "", "description": "", "hero": None}
    keys |= {"scenes": scenes, "fingerprints": {}, "source": "", "display_units": ""}
    keys |= {"answers": [], "table": None}
    return SimpleNamespace(**{**keys, "shown": display_units, **given})
