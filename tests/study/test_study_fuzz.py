"""Any input is accepted or rejected with readable lines."""

import copy

import pytest
import yaml
from hypothesis import example, given, settings
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


def judge(tree):
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
    judge(tree)


@pytest.mark.slow
@settings(max_examples=3000)
@given(mutants())
def test_many_mutated_studies_are_taken_or_refused_readably(tree):
    judge(tree)


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
