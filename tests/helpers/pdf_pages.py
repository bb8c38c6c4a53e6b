"""What is printed on the pages of a PDF: ink, letters with their sizes and fonts, text."""

from __future__ import annotations

import ctypes
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pypdfium2 as pdfium
import pypdfium2.raw as raw

TOP, BOTTOM = 2.2, 2.2  # cm, the margins of a page
HEIGHT = 29.7


@dataclass(frozen=True)
class Letter:
    """A letter of a page: its size in pt as printed, and the name of its font."""

    page: int
    text: str
    size: float
    font: str


def page_texts(path: Path) -> list[str]:
    """Return the text of each page."""
    with pdfium.PdfDocument(path) as document:
        return [page.get_textpage().get_text_bounded() for page in document]


def filled(path: Path) -> list[float]:
    """Return the part of the text height of each page above its lowest ink, header and footer left out."""
    parts = []
    with pdfium.PdfDocument(path) as document:
        for page in document:
            pixels = np.squeeze(page.render(scale=1.0, grayscale=True).to_numpy())
            per_cm = pixels.shape[0] / HEIGHT
            first, last = int(TOP * per_cm), int((HEIGHT - BOTTOM) * per_cm)
            rows = np.flatnonzero((pixels[first:last] < 200).any(axis=1))
            parts.append((rows[-1] + 1) / (last - first) if rows.size else 0.0)
    return parts


def letters(path: Path) -> list[Letter]:
    """Return all letters that are not blank."""
    found = []
    with pdfium.PdfDocument(path) as document:
        for number, page in enumerate(document, 1):
            text = page.get_textpage()
            for index in range(text.count_chars()):
                letter = chr(raw.FPDFText_GetUnicode(text, index))
                if not letter.isspace() and letter.isprintable():
                    found.append(Letter(number, letter, _size(text, index), _font(text, index)))
    return found


def _size(text: pdfium.PdfTextPage, index: int) -> float:
    matrix = raw.FS_MATRIX()
    raw.FPDFText_GetMatrix(text, index, matrix)
    return float(raw.FPDFText_GetFontSize(text, index) * np.hypot(matrix.c, matrix.d))


def _font(text: pdfium.PdfTextPage, index: int) -> str:
    length = raw.FPDFText_GetFontInfo(text, index, None, 0, None)
    name = ctypes.create_string_buffer(length)
    raw.FPDFText_GetFontInfo(text, index, name, length, None)
    return name.value.decode().partition("+")[2] or name.value.decode()
