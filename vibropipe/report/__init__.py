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

from vibropipe.report.data import Study, report_data
from vibropipe.store import StoreError, read_scenes, read_sidecar, whole_file

__all__ = ["build_report", "laid_out", "typeset"]

TEMPLATE = Path(__file__).parent
TEMPLATE_FILES = ("template.typ", "exciter.typ")


def build_report(study: Study, results: Path, output: Path) -> Path:
    """Typeset the report of ``study`` from ``results/<study>`` into the PDF ``output``.

    Reads ``<scene>.nc`` with its sidecar and ``figures/<scene>.pdf`` of every scene. Raises
    StoreError where one of them is missing, damaged or of another study. Returns ``output``.
    """
    place = results / study.name
    datasets = read_scenes(place, study.scenes, study.fingerprints)
    sidecars = {name: read_sidecar(place / f"{name}.nc") for name in study.scenes}
    pictures = {name: place / "figures" / f"{name}.pdf" for name in study.scenes}
    for path in pictures.values():
        _check_figure(path)
    pdf = typeset(report_data(study, datasets, sidecars), pictures)
    with whole_file(output) as temporary:
        temporary.write_bytes(pdf)
    return output


def _check_figure(path: Path) -> None:
    """Raise StoreError unless ``path`` is a whole PDF."""
    if not path.is_file():
        raise StoreError(f"there is no figure {path}: draw the figures of the study first")
    content = path.read_bytes()
    if not (content.startswith(b"%PDF-") and content.rstrip().endswith(b"%%EOF")):
        raise StoreError(f"{path} is damaged: draw the figures of the study again")


@contextmanager
def laid_out(data: dict[str, Any], pictures: Mapping[str, Path]) -> Iterator[Path]:
    """Yield a folder with all the typesetter sees: template, ``data``, ``pictures`` by scene."""
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
    """Return the PDF of ``data`` (see `report_data`) with the ``pictures`` by scene.

    Fonts are those the typesetter carries, not the machine's, so that the bytes are the same
    everywhere.
    """
    import typst

    with laid_out(data, pictures) as folder:
        template = folder / "template.typ"
        pdf: bytes = typst.compile(template, root=folder, ignore_system_fonts=True, format="pdf")
    return pdf
