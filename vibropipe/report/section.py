"""A section of the report, in the form that the template reads."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from vibropipe.report.table import Table


@dataclass(frozen=True)
class Section:
    """A section: title, paragraphs, tables, and a list of named items between `opening` and `closing`.

    All but the title may be empty. `is_landscape` gives it a landscape page of its own, for wide tables.
    """

    title: str
    paragraphs: list[str] = field(default_factory=list)
    tables: list[Table] = field(default_factory=list)
    opening: str = ""
    items: list[dict[str, str]] = field(default_factory=list)
    closing: str = ""
    is_landscape: bool = False

    def as_data(self) -> dict[str, Any]:
        """Return the section as JSON data for the template."""
        return {
            "title": self.title,
            "paragraphs": [text for text in self.paragraphs if text],
            "tables": [table.as_data() for table in self.tables],
            "opening": self.opening,
            "items": self.items,
            "closing": self.closing,
            "landscape": self.is_landscape,
        }
