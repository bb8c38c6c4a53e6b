"""YAML that is rejected, and names and titles that are not plain text."""

import pytest
from study_texts import BASE, faults, study_of

from vibropipe.study import StudyError, load_study, parse_config, parse_study, study_of_text

KEYS = "title, question, description, answers, table, hero, exciter, ties, physical, units, scenes"


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("", f"must be a mapping with {KEYS}, got nothing"),
        ("- 1", f"must be a mapping with {KEYS}, got a list of 1"),
        ("title: [", "must be valid YAML, got a syntax error in line "),
        ("title: a\x00b", "must be valid YAML, got a syntax error ("),
        ("title: T\n---\ntitle: U", "must have one YAML document, got a second one (`---`)"),
        ("title: T\nunits: *x", "must have every alias after its anchor, got '*x' in line 2"),
        ("title: &x [*x]", "title[0]: must be a complete value, got an alias of what it stands in"),
        ("? [a]\n: 1", "must have keys of text, got a key that is not plain text"),
        ("title: T\n<<: {a: 1}", "must have every key written out, got the merge key `<<`"),
        (
            "title: " + "[" * 500,
            "must have at most 12 levels of nesting, got more than 12 in line 1",
        ),
    ],
)
def test_text_that_cannot_be_read_on_stops_with_one_message(tmp_path, text, told):
    (line,) = faults(text, tmp_path)
    assert line.startswith(told)


@pytest.mark.parametrize(
    ("text", "is_text"),
    [
        ("title: Which: frequency\n", True),
        ("scenes:\n  s: {kind: motion, title: Which: frequency}\n", True),
        ("title: T\n  scenes: 1\n", False),
        ("title: [1\nscenes: 2\n", False),
    ],
)
def test_a_text_with_a_colon_is_to_be_quoted(tmp_path, text, is_text):
    (line,) = faults(text, tmp_path)
    assert line.startswith("must be valid YAML, got a syntax error in line ")
    assert line.endswith(' (put a text with ": " in quotes)') == is_text


@pytest.mark.parametrize(
    "tag", ["!!python/object/apply:os.system ['true']", "!!str 1", "!x y", "!mine {}", "!!set {a}"]
)
def test_tags_are_refused_and_make_nothing(tmp_path, tag):
    lines = faults(BASE + f"description: {tag}\n", tmp_path)
    start = "description: must be a value without a YAML tag, got the tag '"
    assert any(line.startswith(start) for line in lines)


@pytest.mark.parametrize("word", ["on", "No", "12:30", "010", "1_000", "2020-01-01", "0o17"])
def test_words_that_yaml_readers_disagree_on_are_refused(tmp_path, word):
    (line,) = faults(BASE.replace("tau_end: 20", f"tau_end: {word}"), tmp_path)
    must = (
        f"must be a plain number or quoted text, got {word} (YAML 1.1 and 1.2 read it differently)"
    )
    assert line == f"scenes.forced.tau_end: {must}"
    (line,) = faults(BASE.replace("A study", word), tmp_path)
    assert line == f"title: {must}"
    assert study_of(BASE.replace("A study", f"'{word}'"), tmp_path).title == word


def test_duplicate_keys_are_refused_at_every_depth(tmp_path):
    assert faults(BASE.replace("h: 0.2", "h: 0.2, h: 0.3"), tmp_path) == [
        "exciter.h: must occur once, got a duplicate key"
    ]
    assert faults(BASE.replace("nu: 1", "nu: 1, ν: 2"), tmp_path) == [
        "exciter.nu: must occur once, got a duplicate key spelt 'ν'"
    ]
    assert faults(BASE + "title: U\n", tmp_path)[0] == "title: must occur once, got a duplicate key"


def test_a_tree_without_end_is_refused_too():
    tree = {"title": "T"}
    tree["description"] = tree
    with pytest.raises(
        StudyError, match="must have at most 12 levels of nesting, got more than 12"
    ):
        parse_study(tree)


def test_aliases_cannot_grow_without_bound(tmp_path):
    laughs = "a0: &a0 [1, 1]\n"
    laughs += "".join(f"a{n}: &a{n} [*a{n - 1}, *a{n - 1}]\n" for n in range(1, 11))
    assert all("unknown key" in line for line in faults(laughs + BASE, tmp_path))
    wide = "a0: &a0 [" + "1, " * 999 + "1]\na1: &a1 [" + "*a0, " * 999 + "*a0]\n"
    (line,) = faults(wide + BASE, tmp_path)
    assert line == "a1: must have at most 200000 values, got more than 200000"
    tower = "a0: &a0 [1]\n" + "".join(f"a{n}: &a{n} [*a{n - 1}]\n" for n in range(1, 40))
    (line,) = faults(tower + BASE, tmp_path)
    assert "must have at most 12 levels of nesting, got more than 12" in line


@pytest.mark.parametrize(
    "name",
    ["../up", "a/b", "a.b", "A", "1st", "a b", "a-b", "ä", "", "_a", "a'b", "a" * 65, "/etc"],
)
def test_names_never_hold_pieces_of_paths(tmp_path, name):
    tree = {"title": "T", "scenes": {name: {"kind": "motion", "exciter": {"l": 1}}}}
    with pytest.raises(StudyError, match=r"scenes\..*must be a name of a-z, 0-9 and _.*, got "):
        parse_study(tree)
    with pytest.raises(StudyError, match=r"studies\[0\].*must be a name of a-z, 0-9 and _.*, got "):
        parse_config({"studies": [name]}, tmp_path)


def test_the_file_has_a_name_too(tmp_path):
    (line,) = faults(BASE, tmp_path, name="my study")
    assert line.startswith("file name must be a name of a-z")
    assert line.endswith(", got 'my study.yaml'")


@pytest.mark.parametrize(
    ("title", "told"),
    [
        ('"a\\x07b"', "got the character U+0007 (it cannot be printed)"),
        ('"a\\nb"', "got the character U+000A (it cannot be printed)"),
        ('"a\\u2028b"', "got the character U+2028 (it cannot be printed)"),
        ("x" * 201, "got 201 characters"),
        ('" "', "got 0 characters"),
        ("12", "got 12 (put it in quotes if text is meant)"),
        ("", "got nothing"),
    ],
)
def test_titles_are_printable_text(tmp_path, title, told):
    (line,) = faults(BASE.replace("A study", title), tmp_path)
    assert line == f"title: must be one line of text, at most 200 characters, {told}"


@pytest.mark.parametrize("title", ["#set page", "$x$", "\\end{a}", "<b>", "{{x}}", "*a*"])
def test_markup_in_titles_is_only_text(tmp_path, title):
    assert study_of(BASE.replace("A study", f"'{title}'"), tmp_path).title == title


def test_files_that_cannot_be_read(tmp_path):
    with pytest.raises(
        StudyError, match=r"none\.yaml: cannot be read \(no such file or directory\): name a rea"
    ):
        load_study(tmp_path / "none.yaml")
    with pytest.raises(
        StudyError, match=r"cannot be read \(is a directory\): name a readable YAML file"
    ):
        load_study(tmp_path)
    (tmp_path / "latin.yaml").write_bytes("title: é".encode("latin-1"))
    with pytest.raises(
        StudyError, match="must be text in UTF-8, got an invalid byte at position 7"
    ):
        load_study(tmp_path / "latin.yaml")
    (tmp_path / "big.yaml").write_bytes(b"#" * 1_000_001)
    with pytest.raises(StudyError, match="must have at most 1000000 bytes, got more than 1000000"):
        load_study(tmp_path / "big.yaml")
    (tmp_path / "bom.yaml").write_bytes(b"\xef\xbb\xbf" + BASE.encode())
    assert load_study(tmp_path / "bom.yaml").title == "A study"


def test_words_that_stand_for_numbers_are_swept():
    text = (
        "title: t\nscenes:\n  s:\n    kind: sweep\n    exciter: {l: 0.5, k1: 90, R1: 0.6}\n"
        "    over: {contact_1: [pull, no_pull]}\n"
    )
    assert study_of_text(text, "t").scene("s").over["contact_1"].values == [0.0, 1.0]
    with pytest.raises(StudyError, match=r"over: must be a list of pull or no_pull.*in contact_1"):
        study_of_text(text.replace("[pull", "[push"), "t")
