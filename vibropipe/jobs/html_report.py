"""Texts of `snakemake --report`: the opening page, and the caption of each figure, as reStructuredText.

Captions are written from the data, as in the PDF.
"""

from __future__ import annotations

import re
from collections.abc import Collection
from pathlib import Path

from vibropipe.jobs.drawing import figure_entries, figures_of
from vibropipe.jobs.run import Run
from vibropipe.store import StoreError, read_scenes
from vibropipe.study import Study
from vibropipe.words.wording import count, paragraphs, series

INTRODUCTION = (
    "Each study has a category in the menu: its figures with their captions, and the whole study as a PDF. The graph "
    "beside this text shows the rules that made them."
)


def is_requested(arguments: Collection[str]) -> bool:
    """Return whether a command line of snakemake asks for a report."""
    return any(word == "--report" or word.startswith("--report=") for word in arguments)


def figure_labels(study: Study) -> dict[str, dict[str, str]]:
    """Return the labels of each figure of a study."""
    labels = {}
    for figure, scene in figures_of(study).items():
        picture = figure.removeprefix(scene.name).removeprefix("-")
        picture = picture or [*scene.figure.chosen(), scene.kind][0]
        labels[figure] = {"scene": scene.name, "title": scene.title or scene.name}
        labels[figure] |= {"picture": picture.replace("_", " ")}
    return labels


def caption_files(run: Run) -> dict[tuple[str, str], str]:
    """Write the captions of all figures as reStructuredText; return their files by study and figure."""
    texts = {(s, figure): text for s in run.studies for figure, text in captions(run, s).items()}
    return {key: _written(f"{'-'.join(key)}.rst", text) for key, text in texts.items()}


def captions(run: Run, name: str) -> dict[str, str]:
    """Return the caption of each figure of a study, as reStructuredText.

    They are written from the data where the study gives none. Datasets that are missing or of another study leave the
    titles of the scenes.
    """
    study = run.studies[name]
    texts = {
        figure: scene.caption or scene.title or scene.name
        for figure, scene in figures_of(study).items()
    }
    texts |= captions_from_data(study, Path(run.results))
    return {figure: escaped(text) for figure, text in texts.items()}


def captions_from_data(study: Study, results: Path) -> dict[str, str]:
    """Return the captions of the figures of a study as in its PDF; none if a dataset is missing."""
    try:
        datasets = read_scenes(results / study.name, study.scenes, study.fingerprints)
    except StoreError:
        return {}
    return {e["name"]: e["caption"] for e in figure_entries(study, study.shown(datasets))}


def write_opening(run: Run) -> str:
    """Write the opening page: what each study is, and what the report holds of it; return its file."""
    blocks = []
    for name in run.studies:
        study = run.studies[name]
        kinds = [scene.kind.replace("_", " ") for scene in study.scenes.values()]
        scenes = series(count(kinds.count(kind), f"{kind} scene") for kind in dict.fromkeys(kinds))
        figures = count(len(figures_of(study)), "figure")
        first, *_ = [*paragraphs(study.description or ""), ""]
        description = f"{escaped(first)} " if first else ""
        blocks.append(f"**{escaped(study.title)}**\n    {description}{scenes}, {figures}.")
    title = "Results of vibropipe"
    text = "\n\n".join([f"{title}\n{'=' * len(title)}", INTRODUCTION, *blocks])
    return _written("opening.rst", text)


def _written(name: str, text: str) -> str:
    """Write a text that snakemake reads, unless it is there: every job of a run reads the rules; return its file."""
    path = Path(".snakemake", "captions", name).absolute()
    if not path.is_file() or path.read_text(encoding="utf-8") != text + "\n":
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text + "\n", encoding="utf-8")
    return str(path)


def escaped(text: str) -> str:
    """Return text in one line with its marks escaped, for reStructuredText and for the template engine."""
    return re.sub(r"([^\w\s]|_)", r"\\\1", " ".join(text.split()))
