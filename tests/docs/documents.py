"""The documents of the project: their code blocks, links, headings and texts in backticks."""

from __future__ import annotations

import re
from collections.abc import Iterator
from functools import cached_property
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).parents[2]
BLOCK = re.compile(r"^```(\w+)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
OUTPUT = re.compile(r"\n\n```text\n(.*?)^```$", re.MULTILINE | re.DOTALL)


class Block(NamedTuple):
    """A code block; `output` is the text block that follows it, or None."""

    page: str
    line: int
    text: str
    output: str | None

    def __str__(self) -> str:
        return f"{self.page}:{self.line}"


class Page:
    """A document, by its path from the root of the repository."""

    def __init__(self, name: str) -> None:
        self.name = name
        self.path = ROOT / name

    def __str__(self) -> str:
        return self.name

    @cached_property
    def text(self) -> str:
        return self.path.read_text(encoding="utf-8")

    @cached_property
    def prose(self) -> str:
        """The text without code blocks."""
        return BLOCK.sub("", self.text)

    def blocks(self, *languages: str) -> list[Block]:
        return list(self._blocks(languages))

    def _blocks(self, languages: tuple[str, ...]) -> Iterator[Block]:
        for match in BLOCK.finditer(self.text):
            if match[1] in languages:
                line = self.text.count("\n", 0, match.start()) + 2
                output = OUTPUT.match(self.text, match.end())
                yield Block(self.name, line, match[2], output[1] if output else None)

    @property
    def anchors(self) -> set[str]:
        """The anchors that GitHub gives the headings."""
        headings = re.findall(r"^#+ (.*)$", self.prose, re.MULTILINE)
        return {re.sub(r"[^\w\- ]", "", text.lower()).replace(" ", "-") for text in headings}

    @property
    def links(self) -> list[str]:
        return re.findall(r"\]\(([^)\s]+)\)", self.prose)

    @property
    def quoted(self) -> list[str]:
        """Texts in backticks in the prose, with spaces for line breaks."""
        return [" ".join(text.split()) for text in re.findall(r"`([^`]+)`", self.prose)]


GUIDES = [Page(path.relative_to(ROOT).as_posix()) for path in sorted((ROOT / "docs").glob("*.md"))]
README, CONTRIBUTING, CHANGELOG = map(Page, ("README.md", "CONTRIBUTING.md", "CHANGELOG.md"))
PAGES = [README, *GUIDES, CONTRIBUTING, CHANGELOG, Page("results/README.md")]


def all_blocks(*languages: str) -> list[Block]:
    return [block for page in PAGES for block in page.blocks(*languages)]
