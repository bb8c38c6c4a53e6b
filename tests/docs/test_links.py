"""Links and paths in the documents lead to something, and their tables are complete."""

from __future__ import annotations

import re
import tomllib

import pytest
from documents import CHANGELOG, CONTRIBUTING, PAGES, README, ROOT, Page

from vibropipe.physics.limits import LAW_IMPACTS, LAW_PERIODS
from vibropipe.scenes.motion import keys as motion
from vibropipe.scenes.sweep import figure_keys as sweep
from vibropipe.words.exciter import EFFECTS
from vibropipe.words.regimes import Regime
from vibropipe.words.status import Status

FOLDERS = (
    "vibropipe", "tests", "workflow", "config", "docs", "profiles", ".ci", "words", "compiler",
    "physics", "march", "orbits", "solve", "store", "figures", "report", "lab", "scenes", "study",
    "jobs", "cli",
)  # fmt: skip
A_PATH = re.compile(
    rf"(?:{'|'.join(map(re.escape, FOLDERS))})/[\w./-]*|[\w.-]+\.(?:txt|toml|cff|md)"
)


@pytest.mark.parametrize("page", PAGES, ids=str)
def test_links_lead_somewhere(page: Page) -> None:
    for link in page.links:
        name, _, anchor = link.partition("#")
        target = (page.path.parent / name).resolve() if name else page.path
        assert target.exists(), link
        if anchor:
            assert anchor in Page(target.relative_to(ROOT).as_posix()).anchors, link


@pytest.mark.parametrize("page", [page for page in PAGES if page is not CHANGELOG], ids=str)
def test_paths_exist(page: Page) -> None:
    for name in page.quoted:
        if A_PATH.fullmatch(name) and not is_result(page, name):
            assert (ROOT / name).exists(), name


def is_result(page: Page, name: str) -> bool:
    """Whether a path is that of a result beside a dataset, as the tutorial and the list of results have it."""
    return name.startswith("figures/") and page.name in ("docs/tutorial.md", "results/README.md")


def test_every_document_is_linked_from_the_readme() -> None:
    linked = {link.partition("#")[0] for link in README.links}
    assert {page.name for page in PAGES} - linked <= {"README.md", "results/README.md"}


def first_column(page: Page, heading: str) -> set[str]:
    """The names in backticks in the first column of the table under a heading."""
    section = page.text.split(f"\n{heading}\n")[1].split("\n## ")[0]
    cells = re.findall(r"^\| (`[^|]*) \|", section, re.MULTILINE)
    return set(re.findall(r"`(\w+)`", " ".join(cells)))


def test_pictures_need_the_outputs_that_the_tutorial_names() -> None:
    rows = re.findall(
        r"^\| `(\w+)` \| (.*) \| .* \| (.*) \|$", Page("docs/tutorial.md").text, re.MULTILINE
    )
    needs = {"motion": motion.PICTURE_NEEDS, "sweep": sweep.PICTURE_NEEDS}
    assert len(rows) == 6
    for picture, kinds, stated in rows:
        if stated != "these quantities":
            needed = {
                output for kind in kinds.split(", ") for output in needs[kind].get(picture, ())
            }
            assert set(re.findall(r"`(\w+)`", stated)) == needed, picture


def test_all_effects_are_counted() -> None:
    number = {12: "twelve", 13: "thirteen", 14: "fourteen"}[len(EFFECTS)]
    assert f"each of the {number} effects" in Page("docs/speed.md").text


def test_the_calls_tell_the_limits_of_a_law() -> None:
    text = f"Period multiple, up to {LAW_PERIODS[1]}, and impacts on each support, up to {LAW_IMPACTS[1]}"
    assert Page("docs/python.md").text.count(text) == 2  # of a branch and of a boundary


def test_every_status_has_its_remedy() -> None:
    listed = first_column(Page("docs/troubleshooting.md"), "## Status")
    assert listed == {"status"} | {status.name.lower() for status in Status}


def test_every_regime_is_explained() -> None:
    listed = first_column(Page("docs/theory.md"), "## Steady states")
    assert listed == {"regime"} | {regime.name.lower() for regime in Regime}


def test_the_layout_has_every_folder_on_the_layer_of_the_contract() -> None:
    folders = {path.parent.name for path in (ROOT / "vibropipe").glob("*/__init__.py")}
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    layers = project["tool"]["importlinter"]["contracts"][0]["layers"]
    contract = {
        name: level for level, layer in enumerate(reversed(layers)) for name in layer.split(" : ")
    }
    rows = re.findall(r"^\| (\d+) \| `vibropipe/(\w+)/`", CONTRIBUTING.text, re.MULTILINE)
    assert {name: int(level) for level, name in rows} == contract
    assert contract.keys() == folders
