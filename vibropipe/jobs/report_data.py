"""What a report says and shows, in the form that its template reads: answers, figures and tables by scene."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Mapping
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Any

import xarray as xr

from vibropipe.jobs.drawing import figure_entries, figure_names, figures_of, words_of
from vibropipe.report.exciter import bare_symbols, drawing_of, said_beside, side_of
from vibropipe.report.findings import UNSOLVED_HEADING, unsolved_line, unsolved_table
from vibropipe.report.methods import Sidecars, again_line, footer, model_line, solved_line
from vibropipe.report.parts import (
    MAX_LINES,
    Answer,
    Datasets,
    Line,
    Table,
    beside_pictures,
    not_repeated,
    own_answers,
    own_table,
)
from vibropipe.scenes.kind import Kind
from vibropipe.scenes.registry import kind_of
from vibropipe.study import Study
from vibropipe.words.wording import capitalised, paragraphs, series

MAX_LABEL = 36  # letters of a scene's title that stands for it in tables and sentences


@dataclass
class Group:
    """Figures and tables that stand together under a heading, with their answers, in the form the template reads.

    follows : whether they are of the scene of what stands before them, from which nothing may part them
    """

    heading: str = ""
    follows: bool = False
    answers: list[dict[str, str]] = field(default_factory=list)
    items: list[dict[str, Any]] = field(default_factory=list)


def report_data(
    study: Study, datasets: Datasets, sidecars: Sidecars, results: Path = Path("results")
) -> dict[str, Any]:
    """Return the data of the template: strings, lists and mappings only, so that JSON holds it without loss.

    results : folder of all results, as the command names it
    """
    datasets = study.shown(datasets)
    labels, titles = scene_labels(study), scene_labels(study, math.inf)
    parts: dict[Kind, dict[str, xr.Dataset]] = {}
    for name, data in datasets.items():
        parts.setdefault(kind_of(study.scenes[name]), {})[labels[name]] = data
    hero_scene, hero_name = hero_of(study)
    main, label = kind_of(study.scenes[hero_scene]), labels[hero_scene]
    figures = list(figure_entries(study, datasets))
    drawn = {labels[entry["scene"]] for entry in figures}
    together = {labels[name]: len(s.figure.drawn_together()) for name, s in study.scenes.items()}
    chief = {
        kind: max(own, key=lambda label: (label in drawn, together[label]))
        for kind, own in parts.items()
    }
    order = dict.fromkeys([hero_scene, *(entry["scene"] for entry in figures)])
    shown = {labels[name]: datasets[name] for name in order}
    answers = _answers(parts, main, label, chief, shown)
    hero = next(entry for entry in figures if entry["name"] == hero_name)
    groups = _groups(study, labels, figures, answers, parts, hero)
    if study.table is not None:
        groups.insert(0, Group(items=[own_table(**dict(study.table)).as_data()]))
    titled = {titles[name]: data for name, data in datasets.items()}
    unsolved = unsolved_table(titled)
    if unsolved is not None:
        groups.append(Group(UNSOLVED_HEADING, items=[unsolved.as_data()]))
    if main.report.side:
        side = main.report.side({label: parts[main][label], **parts[main]})
    else:
        side = side_of({labels[name]: data for name, data in datasets.items()})
    drawn_beside = side.drawn or datasets
    if side.has_drawing:
        hero["caption"] = said_beside(hero["caption"], datasets[hero_scene], drawn_beside)
    return {
        "title": study.title,
        "kind": " · ".join(dict.fromkeys(kind.report.noun for kind in (main, *parts))),
        "question": study.question or main.report.asked(parts[main]),
        "answers": [
            *warning_answers(study),
            *(map(asdict, own_answers(study.answers)) if study.answers else answers.pop("", [])),
        ],
        "side": {
            "rows": [asdict(row) for row in side.rows],
            "drawing": drawing_of(drawn_beside) if side.has_drawing else None,
        },
        "symbols": bare_symbols(datasets),
        "hero": hero,
        "groups": [asdict(group) for group in groups],
        "fixed": int(unsolved is not None),
        "methods": [
            asdict(line)
            for line in _methods(study, parts, datasets, sidecars, unsolved_line(titled), results)
        ],
        "footer": footer(study.name, datasets, sidecars),
    }


def warning_answers(study: Study) -> list[dict[str, str]]:
    """Return what is hardly meant in a study, and in which scenes, to stand before its answers; none for nothing."""
    odd: dict[str, list[str]] = {}
    for name, scene in study.scenes.items():
        odd.setdefault(scene.warning(), []).append(name)
    labels = scene_labels(study)
    where = {
        text: "" if len(names) == len(study.scenes) else f"In {series(labels[n] for n in names)}: "
        for text, names in odd.items() if text
    }  # fmt: skip
    return [
        asdict(Answer(f"{place}{text if place else capitalised(text)}."))
        for text, place in where.items()
    ]


def scene_labels(study: Study, most: float = MAX_LABEL) -> dict[str, str]:
    """Return how each scene is called in tables and sentences: by its title if that is short, else by its head or name.

    The title of a picture of several scenes is short for none of them; each has its own head there.

    most : letters of a title that is short.
    """
    titles = [scene.title for scene in study.scenes.values()]
    heads = {
        name: head
        for own, scene in study.scenes.items()
        for name, head in zip(
            [own, *getattr(scene.figure, "together", [])],
            getattr(scene.figure, "heads", []),
            strict=False,
        )
    }
    return {
        name: scene.title
        if 0 < len(scene.title) <= most
        and titles.count(scene.title) == 1
        and (most == math.inf or not scene.figure.drawn_together())
        else heads.get(name, name.replace("_", " "))
        for name, scene in study.scenes.items()
    }


def hero_of(study: Study) -> tuple[str, str]:
    """Return the scene and the figure on page 1: the study's, else the first of the scene of the lowest rank."""
    if study.hero is None:
        scenes = {each.name: each for each in figures_of(study).values()}.values()
        scene = min(scenes, key=lambda scene: kind_of(scene).report.rank)
        return scene.name, figure_names(scene)[0]
    scene = study.scenes[study.hero.scene]
    index = scene.figure.chosen().index(study.hero.picture) if study.hero.picture else 0
    return scene.name, figure_names(scene)[index]


def _answers(
    parts: Mapping[Kind, Datasets],
    main: Kind,
    hero_label: str,
    chief: Mapping[Kind, str],
    shown: Datasets,
) -> dict[str, list[dict[str, str]]]:
    """Return the answers by the labels of scenes; those of page 1 have the key "".

    `chief` is the scene of each kind beside whose figures those on all of the kind stand, `shown` are the datasets in
    the order of the report.
    """
    found: dict[str, list[Answer]] = {}
    for kind, own in parts.items():
        for label, answers in kind.report.answers(own).items():
            of_all = "" if kind is main else chief[kind]
            found.setdefault(label or of_all, []).extend(answers)
    found = not_repeated(found, shown)
    if "" not in found:
        found[""] = found.pop(hero_label, [])
    return {label: [*map(asdict, own)] for label, own in found.items()}


def _groups(
    study: Study,
    labels: Mapping[str, str],
    figures: list[dict[str, str]],
    answers: Mapping[str, list[dict[str, str]]],
    parts: Mapping[Kind, Datasets],
    hero: dict[str, str],
) -> list[Group]:
    """Return the groups after the hero: those of its scene, then of the other scenes, in the order of the study."""
    drawn = {labels[entry["scene"]] for entry in figures}
    placed = [
        (heading, table)
        for kind, own in parts.items()
        for heading, table in _placed(kind, own, drawn)
        if table.scene in drawn
    ]
    groups: list[Group] = []
    first = hero["scene"]
    scenes = dict.fromkeys([first, *(entry["scene"] for entry in figures)])
    for scene in scenes:
        label = labels[scene]
        before = len(groups)
        group = Group(answers=answers.get(label, []))
        groups.append(group)
        told = ["", *(each.heading for each in groups)]
        own_figures = _by_heading([e for e in figures if e["scene"] == scene], hero, told)
        pictures = {entry["picture"] for entry in own_figures}
        own_tables = [
            kept
            for heading, table in placed
            if table.scene == label and not heading
            if (kept := beside_pictures(table, pictures)) is not None
        ]
        for figure in own_figures:
            if figure is not hero:
                begins = scene != first and figure is own_figures[0]
                # what follows the hero in its scene stands under the title of the report
                heading = _heading(study, figure, begins) if scene != first else figure["heading"]
                if begins and not heading and any(each.heading for each in groups):
                    # else it would stand under the question of another scene
                    heading = kind_of(study.scenes[scene]).report.noun
                if heading and heading not in [each.heading for each in groups]:
                    group = group if not group.items else Group()
                    group.heading = heading
                    if group not in groups:
                        groups.append(group)
                group.items.append(figure)
            group.items += [t.as_data() for t in own_tables if t.picture == figure["picture"]]
        rest = [t.as_data() for t in own_tables if not t.picture]
        if rest and len(groups) > before + 1:
            group = Group("Further numbers")
            groups.append(group)
        group.items += rest
        for n, each in enumerate(groups[before:]):
            each.follows = n > 0 or scene == first
        for heading, table in placed:  # of several scenes, not under the question of one
            if table.scene == label and heading:
                same = next((each for each in groups if each.heading == heading), Group(heading))
                groups += [] if same in groups else [same]
                same.items.append(table.as_data())
    return [group for group in groups if group.items]


def _by_heading(
    figures: list[dict[str, str]], hero: Mapping[str, str], told: Collection[str]
) -> list[dict[str, str]]:
    """Return the figures of a scene in the order in which their headings come up: the hero, then those told already.

    Elsewhere these would stand under the question of another figure.
    """
    new = [each for each in dict.fromkeys(e["heading"] for e in figures) if each not in told]
    place = {heading: n for n, heading in enumerate(new)}
    return sorted(figures, key=lambda each: (each is not hero, place.get(each["heading"], -1)))


def _heading(study: Study, figure: Mapping[str, str], begins: bool) -> str:
    """Return the heading of a figure: its question, else the title of its scene unless the figure has or names that.

    One that begins a scene has its title first.
    """
    scene = study.scenes[figure["scene"]]
    title = scene.title or words_of(scene.name)
    is_said = title == figure["title"] or scene.figure.drawn_together()
    of_scene = "" if is_said or len(study.scenes) == 1 else title
    return (begins and of_scene) or figure["heading"] or of_scene


def _placed(kind: Kind, own: Datasets, drawn: Collection[str]) -> Iterator[tuple[str, Table]]:
    """Yield the tables of a kind, those without a scene after the last one that is drawn.

    Before each stands its own heading, if it is of several scenes that are drawn.
    """
    shown = [label for label in own if label in drawn]
    for table in kind.report.tables(own):
        heading = kind.report.noun if len(shown) > 1 and not table.scene else ""
        yield heading, table if table.scene else replace(table, scene=(shown or list(own))[-1])


def _methods(
    study: Study,
    parts: Mapping[Kind, Datasets],
    datasets: Datasets,
    sidecars: Sidecars,
    unsolved: Line,
    results: Path,
) -> list[Line]:
    """Return the lines on methods and provenance, at most MAX_LINES; a description of the study comes first."""
    about = [
        Line("" if n else "About", text, plain=True)
        for n, text in enumerate(paragraphs(study.description or ""))
    ]
    own = [line for kind, data in parts.items() for line in kind.report.methods(data)]
    source = Path(study.source).name if study.source else ""
    last = [
        unsolved,
        solved_line(datasets),
        model_line(datasets),
        again_line(study.name, source, datasets, sidecars, results),
    ]
    room = max(MAX_LINES - len(about[:1]) - sum(1 for line in last if line.text), 0)
    return [line for line in (*about, *own[:room], *last) if line.text]
