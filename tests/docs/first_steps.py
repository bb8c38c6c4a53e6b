"""The notebook of docs/, executed anew; run as a script, it is written with what its cells print and draw."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import nbformat
from nbclient import NotebookClient

NOTEBOOK = Path(__file__).parents[2] / "docs" / "first-steps.ipynb"


def stored() -> Any:
    """Return the notebook as it stands."""
    return nbformat.read(NOTEBOOK, as_version=4)


def executed() -> Any:
    """Return the notebook with fresh outputs, made in a process of its own; nothing tells when."""
    return NotebookClient(
        stored(), kernel_name="python3", timeout=600, record_timing=False
    ).execute()


if __name__ == "__main__":
    nbformat.write(executed(), NOTEBOOK)
