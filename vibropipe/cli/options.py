"""Arguments and options that several commands share."""

from __future__ import annotations

import functools
import inspect
import re
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Annotated, Any

import typer

from vibropipe.words.parameters import DEFAULTS, FOLLOWING, PARAMETERS

StudyFile = Annotated[Path, typer.Argument(metavar="FILE", help="The study, a YAML file.")]
SceneName = Annotated[str, typer.Option("--scene", metavar="S", help="Name of the scene.")]
SceneNames = Annotated[
    list[str] | None,
    typer.Option("--scene", metavar="S", help="Name of a scene; may be repeated (default: all)."),
]
Threads = Annotated[
    int | None,
    typer.Option(
        "--threads", min=1, metavar="T", help="Number of threads (default: all available)."
    ),
]
ResultsFolder = Annotated[
    Path,
    typer.Option(
        "--results",
        metavar="DIR",
        help="Folder of all results; each study has its own folder in it.",
    ),
]


def number(text: str | float) -> float:
    """Return the number of an option, or refuse it with the value and a hint."""
    from vibropipe.scenes.keys.values import number_hint
    from vibropipe.words.units import MINUS

    try:
        return float(str(text).replace(MINUS, "-"))
    except ValueError:
        hint = number_hint(text) or "numbers of this command have no unit"
        raise typer.BadParameter(f"must be a number, got {text!r} ({hint})") from None


def word(text: str) -> str | int:
    """Return the word of an option, or the number that stands for one."""
    return int(text) if text.isdecimal() else text


# For options that are numbers: the option's own messages name neither the value nor a remedy.
NUMBER: dict[str, Any] = {"parser": number, "metavar": "NUMBER"}
StartDisplacement = Annotated[
    float | None,
    typer.Option(
        "--x0",
        help="Displacement at tau = 0 (default: the equilibrium, or the support nearest to it).",
        **NUMBER,
    ),
]
StepsPerPeriod = Annotated[
    int | None, typer.Option("--steps-per-period", help="Steps per forcing period; newmark only.")
]
Accuracy = Annotated[
    float | None,
    typer.Option("--accuracy", help="Maximum error; selects method and step.", **NUMBER),
]


def file_option(help_text: str, *suffixes: str, names: Sequence[str] = ("--output", "-o")) -> Any:
    """Return the option of a file to write, which refuses a name that ends in none of some suffixes."""

    def check(file: Path | None) -> Path | None:
        if file is not None and file.suffix not in suffixes:
            allowed = ", ".join(suffixes)
            raise typer.BadParameter(f"must end in {allowed}, got {file.name}", param_hint=names[0])
        return file

    return typer.Option(*names, metavar="F", help=help_text, callback=check)


ResultFile = Annotated[Path, file_option("Dataset to write: .nc.", ".nc")]
ReportFile = Annotated[Path, file_option("Report to write: .pdf.", ".pdf")]
TableFile = Annotated[
    Path | None,
    file_option("Write to this file, which spreadsheets open: .csv or .xlsx.", ".csv", ".xlsx"),
]
ComparisonFile = Annotated[
    Path | None,
    file_option(
        "Write a table of what differs, .csv, or maps or curves of it, .pdf, .svg or .png.",
        ".csv", ".pdf", ".svg", ".png",
    ),
]  # fmt: skip
DatasetFile = Annotated[Path | None, file_option("Write the dataset: .nc.", ".nc")]
PlotFile = Annotated[
    Path | None,
    file_option("Write a figure: .svg, .pdf or .png.", ".svg", ".pdf", ".png", names=["--plot"]),
]
PageFile = Annotated[
    Path | None,
    file_option("Write a sweep as one page, F.html, and end.", ".html", names=["--save"]),
]


def takes_parameters(command: Callable[..., None]) -> Callable[..., None]:
    """Return a command with an option for each parameter of the exciter, before its others, in place of `**`."""
    words = {name: entry.range.words for name, entry in PARAMETERS.items() if entry.range.words}
    first = {name: each[0] for name, each in words.items()}
    defaults = {**DEFAULTS, **first, **dict.fromkeys(FOLLOWING)}
    others = [
        each
        for each in inspect.signature(command, eval_str=True).parameters.values()
        if each.kind is not each.VAR_KEYWORD
    ]
    options = [
        inspect.Parameter(
            name,
            inspect.Parameter.KEYWORD_ONLY,
            default=defaults.get(name, inspect.Parameter.empty),
            annotation=Annotated[
                str,
                typer.Option(
                    f"--{name}", help=f"{entry.key}.", parser=word, metavar="|".join(words[name])
                ),
            ]
            if name in words
            else Annotated[
                float if name in PARAMETERS.keys() - FOLLOWING else float | None,
                typer.Option(f"--{name}", help=f"{entry.long_name.capitalize()}.", **NUMBER),
            ],
        )
        for name, entry in PARAMETERS.items()
    ]
    options.sort(key=lambda option: option.default is not option.empty)  # the required one first
    keys = [*options, *(each.replace(kind=each.KEYWORD_ONLY) for each in others)]

    @functools.wraps(command)
    def taking(**values: Any) -> None:
        command(**values)

    taking.__signature__ = inspect.Signature(keys)  # type: ignore[attr-defined]
    taking.__annotations__ = {each.name: each.annotation for each in keys}
    return taking


def parse_shard(text: str) -> tuple[int, int]:
    """Return (I, N) of the option `I/N`, shard I of N."""
    match = re.fullmatch(r"(\d{1,9})/(\d{1,9})", text)
    if match is None:
        raise typer.BadParameter(f"must be I/N, such as 3/8, got {text!r}", param_hint="--shard")
    return int(match[1]), int(match[2])
