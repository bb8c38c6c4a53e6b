"""The report of a study: one PDF typeset from its datasets and figures.

Data reach the template as JSON, so that a user's text is never read as markup. Equal results give equal bytes.
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
    """Yield a temporary folder with the template, `data` as JSON, and the pictures by name."""
    with TemporaryDirectory(prefix="vibropipe-report-") as path_text:
        folder = Path(path_text)
        (folder / "figures").mkdir()
        for name in TEMPLATE_FILES:
            shutil.copyfile(TEMPLATE / name, folder / name)
        for name, path in pictures.items():
            shutil.copyfile(path, folder / "figures" / f"{name}.pdf")
        text = json.dumps(data, ensure_ascii=False, allow_nan=False, sort_keys=True)
        (folder / "data.json").write_text(text, encoding="utf-8")
        yield folder


def typeset(data: dict[str, Any], pictures: Mapping[str, Path]) -> bytes:
    """Typeset a report.

    Only fonts of the typesetter are used, not those of the machine, so that the bytes are the same everywhere.

    data : contents, as `jobs.report_data.report_data` returns them
    pictures : PDF files of the figures by scene
    """
    import typst

    with template_folder(data, pictures) as folder:
        template = folder / "template.typ"
        pdf: bytes = typst.compile(template, root=folder, ignore_system_fonts=True, format="pdf")
    return pdf
