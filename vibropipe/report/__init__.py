"""The report of a study: one PDF typeset from its datasets and figures.

The template is the project's own; what differs between studies reaches it as JSON, so that a
user's text is text whatever it holds. Equal results give equal bytes.
"""

from __future__ import annotations

import json
import shutil
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

__all__ = ["template_folder", "typeset"]

TEMPLATE = Path(__file__).parent
TEMPLATE_FILES = ("template.typ", "exciter.typ")


@contextmanager
def template_folder(data: dict[str, Any], pictures: Mapping[str, Path]) -> Iterator[Path]:
    """Yield a folder with all the typesetter sees: template, ``data``, ``pictures`` by name."""
    with TemporaryDirectory(prefix="vibropipe-report-") as made:
        folder = Path(made)
        (folder / "figures").mkdir()
        for name in TEMPLATE_FILES:
            shutil.copyfile(TEMPLATE / name, folder / name)
        for name, path in pictures.items():
            shutil.copyfile(path, folder / "figures" / f"{name}.pdf")
        text = json.dumps(data, ensure_ascii=False, allow_nan=False, sort_keys=True)
        (folder / "data.json").write_text(text, encoding="utf-8")
        yield folder


def typeset(data: dict[str, Any], pictures: Mapping[str, Path]) -> bytes:
    """Return the PDF of ``data`` (see `jobs.reporting`) with the ``pictures`` by name.

    Fonts are those the typesetter carries, not the machine's, so that the bytes are the same
    everywhere.
    """
    import typst

    with template_folder(data, pictures) as folder:
        template = folder / "template.typ"
        pdf: bytes = typst.compile(template, root=folder, ignore_system_fonts=True, format="pdf")
    return pdf
