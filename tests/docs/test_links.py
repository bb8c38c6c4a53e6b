"""Links, paths and commands in the documents lead to something that exists, and their tables are complete."""

from __future__ import annotations

import importlib.util
import re
import shlex
import tomllib
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path

import pytest
from documents import CHANGELOG, CONTRIBUTING, PAGES, README, ROOT, Block, Page, all_blocks
from typer.main import get_command
from typer.testing import CliRunner

from vibropipe.cli.commands import app
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


PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
EXTRAS = PROJECT["project"]["optional-dependencies"]
MARKERS = {text.split(":")[0] for text in PROJECT["tool"]["pytest"]["ini_options"]["markers"]}
STUDIES = {path.stem for path in (ROOT / "config").glob("*.yaml")}


def vibropipe(arguments: list[str], whole: bool) -> None:
    """Check arguments by the parser of the command line; within a sentence, required ones may be missing."""
    group = get_command(app)
    name, *rest = arguments
    if name.startswith("--"):
        assert any(name in option.opts for option in group.params), name
        return
    try:
        group.commands[name].make_context(name, rest)
    except Exception as error:
        if whole or type(error).__name__ != "MissingParameter":
            raise


def snakemake(arguments: list[str], whole: bool) -> None:
    from snakemake.cli import get_argument_parser

    parsed = get_argument_parser().parse_args(arguments)
    if parsed.workflow_profile:
        assert (ROOT / parsed.workflow_profile / "config.yaml").is_file()
    for target in parsed.targets:
        folder, study, *_ = target.split("/")
        assert folder == "results"
        assert study in STUDIES


def pytest_call(arguments: list[str], whole: bool) -> None:
    for option, value in pairwise(arguments):
        assert option != "-m" or value in MARKERS, value
    for argument in arguments:
        assert "/" not in argument or (ROOT / argument).exists(), argument


def pip(arguments: list[str], whole: bool) -> None:
    assert arguments[0] == "install"
    assert (ROOT / arguments[arguments.index("-c") + 1]).is_file()
    for extra in re.findall(r"\[(\w+)\]", " ".join(arguments)):
        assert extra in EXTRAS, extra


def python(arguments: list[str], whole: bool) -> None:
    if arguments[0] == "-m":
        assert importlib.util.find_spec(arguments[1]) is not None, arguments[1]
    else:
        assert (ROOT / arguments[0]).is_file(), arguments[0]


def export(arguments: list[str], whole: bool) -> None:
    name = arguments[0].split("=")[0]
    sources = (ROOT / "vibropipe").rglob("*.py")
    assert any(f'"{name}"' in path.read_text(encoding="utf-8") for path in sources), name


def tool(arguments: list[str], whole: bool) -> None:
    for argument in arguments:
        assert not argument.endswith((".toml", ".txt")) or (ROOT / argument).is_file(), argument


CHECKS: dict[str, Callable[[list[str], bool], None]] = {
    "vibropipe": vibropipe,
    "snakemake": snakemake,
    "pytest": pytest_call,
    "pip": pip,
    "python": python,
    "python3": python,
    "export": export,
    ".": lambda arguments, whole: None,
} | dict.fromkeys(("ruff", "mypy", "lint-imports", "snakefmt", "uv"), tool)
INLINE = ("vibropipe", "snakemake", "pytest", "python")
# Commands that take long, are run by other tests, or serve until Ctrl-C.
NOT_RUN = ("new", "run", "bench", "view")


def check(line: str, whole: bool) -> None:
    for command in line.split(" && "):
        name, *arguments = shlex.split(command)
        if name in INLINE and not arguments and not whole:
            continue
        CHECKS[name](arguments, whole)


@pytest.mark.parametrize("block", all_blocks("sh", "bash"), ids=str)
def test_commands_of_a_block(block: Block) -> None:
    for line in block.text.splitlines():
        check(line, whole=True)


def quick_commands() -> list[str]:
    """Return the commands of the package in the order of the documents, each once."""
    lines = [line for block in all_blocks("bash") for line in block.text.splitlines()]
    quick = [
        line for line in lines if line.startswith("vibropipe ") and line.split()[1] not in NOT_RUN
    ]
    return list(dict.fromkeys(quick))


def test_quick_commands_run(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """In order, in one folder, since a join needs the shards solved before it."""
    monkeypatch.chdir(folder)
    assert len(quick_commands()) >= 8
    for line in quick_commands():
        done = CliRunner().invoke(app, shlex.split(line)[1:])
        assert done.exit_code == 0, f"{line}\n{done.output}"


def test_every_command_is_explained() -> None:
    listed = re.findall(r"^\| `vibropipe (\w+)` \|", Page("docs/tutorial.md").text, re.MULTILINE)
    assert sorted(listed) == sorted(get_command(app).commands)


@pytest.mark.parametrize("page", [page for page in PAGES if page is not CHANGELOG], ids=str)
def test_commands_in_sentences(page: Page) -> None:
    for text in page.quoted:
        if text.split()[0] in INLINE:
            check(text, whole=False)


def test_a_wrong_command_is_found() -> None:
    """The checks see a wrong subcommand, option, extra, marker, module and study."""
    for line in (
        "vibropipe warm mine.yaml",
        "vibropipe plan mine.yaml --ruff",
        "pip install -c constraints.txt -e '.[pears]'",
        "pytest -m quick",
        "python -m vibropipe.growth",
        "snakemake --cores 2 results/acuracy/report.pdf",
    ):
        with pytest.raises(Exception):  # noqa: B017, PT011 - each parser has an error of its own
            check(line, whole=True)
