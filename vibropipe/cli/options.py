"""Arguments and options that several commands share."""

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
        "--results",
        metavar="DIR",
        help="Folder of all results; each study has its own folder in it.",
    ),
]


def parameter_option(name: str) -> Any:
    """Return the option of a parameter; its help text is the long name in datasets."""
    return typer.Option(f"--{name}", help=f"{quantity(name).long_name.capitalize()}.")
