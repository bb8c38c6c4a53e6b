"""Any input, and any file of the command line, is accepted or rejected with readable lines."""

import copy
import itertools

import pytest
import yaml
from command_line import run
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st
from study_texts import A_FAULT, BASE

from vibropipe.physics.exciter import Exciter
from vibropipe.study import StudyError, fingerprint, parse_study
from vibropipe.study.yaml_reader import read_text

JUNK = [
    None,
    True,
    "",
    "x",
    "..",
    "a/b",
    -1,
    0,
    1e308,
    float("nan"),
    10**400,
    [],
    {},
    [[1]],
    {"a": 1},
]
JUNK += ["1e999", 1e12, "ν", "#", "\ud800", {1: 2}, {"": None}, ["motion"], {"start": 0}]


# Each value anew: a mutant may put one inside another.
JUNK_VALUES = st.sampled_from(JUNK).map(copy.deepcopy)


@st.composite
def mutants(draw):
    """A valid study with a few places deleted, replaced or given an unknown neighbour."""
    tree = copy.deepcopy(yaml.safe_load(BASE))
    for _ in range(draw(st.integers(1, 3))):
        here, path = tree, []
        while isinstance(here, dict) and here:
            path.append(draw(st.sampled_from(sorted(here, key=str))))
            parent, here = here, here[path[-1]]
            if draw(st.booleans()) and len(path) > 1:
                break
        action = draw(st.sampled_from(["replace", "delete", "add", "rename"]))
        if action == "replace":
            parent[path[-1]] = draw(JUNK_VALUES)
        elif action == "delete":
            del parent[path[-1]]
        elif action == "add":
            parent[draw(st.sampled_from(["x", "kind", "l", "δ", "a b", "..", "figure"]))] = draw(
                JUNK_VALUES
            )
        else:
            parent[draw(st.sampled_from(["nu", "R1", "over", "<sweep>", "[key]", "tau"]))] = (
                parent.pop(path[-1])
            )
        if not tree:
            break
    return tree


def told_by(read):
    """Return the study that `read` gives, or the lines of the error that refuses it."""
    try:
        return read(), []
    except StudyError as error:
        return None, str(error).splitlines()


def judge_tree(tree):
    study, lines = told_by(lambda: parse_study(tree, source="f.yaml"))
    if study is None:
        assert lines
        for line in lines:
            assert line.startswith("f.yaml: ")
            assert A_FAULT.search(line)
            line.encode()  # printable on any terminal that takes UTF-8
        return
    for scene in study.scenes.values():
        if scene.row_count < 10**6:
            scene.over_arrays()
        Exciter(**scene.resolved_exciter())
        assert len(fingerprint(study, scene)) == 64


@given(mutants())
def test_mutated_studies_are_taken_or_refused_readably(tree):
    judge_tree(tree)


@pytest.mark.slow
@settings(max_examples=3000)
@given(mutants())
def test_many_mutated_studies_are_taken_or_refused_readably(tree):
    judge_tree(tree)


@settings(max_examples=150)
@given(st.integers(0, len(BASE) - 1), st.text(max_size=4), st.integers(0, 6))
@example(0, "\ufeff", 0)
@example(7, "\x85", 0)
def test_mutated_text_is_taken_or_refused_readably(place, text, cut):
    mutant = BASE[:place] + text + BASE[place + cut :]

    def read():
        tree, problems = read_text(mutant, "f.yaml")
        return parse_study(tree, source="f.yaml", problems=problems)

    study, lines = told_by(read)
    assert (study is None) == bool(lines)
    assert all(line.startswith("f.yaml: ") for line in lines)


NESTED = "[" * 400 + "1" + "]" * 400
# Replacements of a value and of a key, and inserted lines.
VALUES = [
    "!!python/object/apply:os.system ['touch hacked']", "!!binary aGk=", "!own 1", "&a 1", "*a", "*absent",
    "&loop [*loop]", "{<<: *a}", NESTED, "{a: {b: {c: {d: {e: {f: {g: {h: {i: {j: {k: {l: {m: 1}}}}}}}}}}}}}",
    ".nan", "-.inf", "1e999", "-1e308", "1e12", "0x1F", "1_000", "12:30", "on", "~", "''", "'a", "\"\\ud800\"",
    "[1, [2, [3]]]", "{start: 0.5, stop: 1.5, points: 1000000000000}", "{values: []}", "2026-01-01", "|", "- 1",
    "'#read(\"/etc/passwd\")'", "'$x^2$ *bold* @ref <label> \\\\u{0}'", "'../../../etc/passwd'", "'a/b'", "'a\"b'",
]  # fmt: skip
KEYS = [
    "ν", "v", "nυ", "δ", "∂", "R₁", "ѕcenes", "sсenes", "'..'", "'a/b'", "'a b'", "'a\"b'", "\"a'b\"", "'.'", "''",
    "'<motion>'", "'[key]'", "!!str k", "? [1]", "<<", "1", "~", "on", "*a", "&a k", "title", "kind", "con", "A",
    "x" * 300, "'{study}'", "'\\0'", "é",
]  # fmt: skip
LINES = [
    "%YAML 1.2",
    "---",
    "...",
    "title: again",
    "\tx: 1",
    "scenes: {}",
    "#" * 100,
    "}",
    "\x00",
    "\ufeff",
]


@st.composite
def texts(draw):
    """A valid study with another key, another value or an inserted line in a few places."""
    lines = BASE.splitlines()
    for _ in range(draw(st.integers(1, 3))):
        index = draw(st.integers(0, len(lines) - 1))
        line = lines[index]
        indent = line[: len(line) - len(line.lstrip())]
        key, _, value = line.strip().partition(":")
        action = draw(st.sampled_from(["value", "key", "line", "twice", "delete", "inside"]))
        if action == "value":
            lines[index] = f"{indent}{key}: {draw(st.sampled_from(VALUES))}"
        elif action == "key":
            lines[index] = f"{indent}{draw(st.sampled_from(KEYS))}:{value}"
        elif action == "line":
            lines.insert(index, draw(st.sampled_from(LINES)))
        elif action == "twice":
            lines.insert(index, line)
        elif action == "inside":
            inserted = f"{draw(st.sampled_from(KEYS))}: {draw(st.sampled_from(VALUES))}"
            lines.insert(index + 1, f"{indent}  {inserted}")
        else:
            del lines[index]
        if not lines:
            break
    return "\n".join(lines) + "\n"


@pytest.fixture
def judge_text(tmp_path, monkeypatch, capsys):
    """See what `vibropipe plan` makes of a text: code 0 and a plan, or 2 and what is wrong."""
    monkeypatch.chdir(tmp_path)
    counted = itertools.count()

    def judged(text: str) -> None:
        folder = tmp_path / str(next(counted))
        folder.mkdir()
        file = folder / "mine.yaml"
        file.write_text(text, encoding="utf-8", errors="surrogatepass")
        code = run("plan", file, "--rough")
        said = capsys.readouterr()
        assert [path.name for path in folder.iterdir()] == ["mine.yaml"]
        assert not (tmp_path / "hacked").exists()
        if code == 0:
            assert said.out.startswith("mine: ")
            assert not said.err
            return
        assert code == 2
        assert not said.out
        lines = said.err.splitlines()
        assert lines
        assert lines[0].startswith(f"vibropipe: {file}: ")
        for line in (lines[0].removeprefix("vibropipe: "), *lines[1:]):
            assert line.startswith(f"{file}: ")
            assert A_FAULT.search(line)
            assert len(line) < 1500

    return judged


ONE_FIXTURE = [HealthCheck.function_scoped_fixture, HealthCheck.too_slow]


@settings(suppress_health_check=ONE_FIXTURE)
@given(text=texts())
@example(text=BASE)
@example(text="")
@example(text="- 1\n")
@example(text=NESTED)
def test_a_mutated_file_is_planned_or_refused_readably(text, judge_text):
    judge_text(text)


@pytest.mark.slow
@settings(max_examples=3000, suppress_health_check=ONE_FIXTURE)
@given(text=texts())
def test_many_mutated_files_are_planned_or_refused_readably(text, judge_text):
    judge_text(text)
