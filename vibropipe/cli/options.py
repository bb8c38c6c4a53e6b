"""Arguments and options that several commands take, each said once."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from vibropipe.words.vocabulary import quantity

StudyFile = Annotated[Path, typer.Argument(metavar="FILE", help="The study, a YAML file.")]
SceneName = Annotated[str, typer.Option("--scene", metavar="S", help="Name of the scene.")]
OutputFile = Annotated[Path, typer.Option("--output", "-o", metavar="F", help="File to write.")]
ResultsFolder = Annotated[
    Path,
    typer.Option(
        "--results", metavar="DIR", help="Folder of all results; each study has its own in it."
    ),
]


def number_of(name: str) -> Any:
    """Return the option of a parameter, with the words that datasets have for it."""
    return typer.Option(f"--{name}", help=f"{quantity(name).long_name.capitalize()}.")
