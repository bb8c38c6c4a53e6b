"""YAML that is not taken as it stands; names and titles that are more than text."""

import pytest
from study_texts import BASE, faults, study_of

from vibropipe.study import StudyError, load_study, parse_config, parse_study


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("", "found nothing, allowed a mapping with title, description, exciter, scenes"),
        ("- 1", "found a list of 1, allowed a mapping"),
        ("title: [", "found broken YAML in line "),
        ("title: a\x00b", "found broken YAML"),
        ("title: T\n---\ntitle: U", "found a second YAML document"),
        ("title: *x", "title: found the alias '*x', allowed aliases of an anchor"),
        (
            "title: &x [*x]",
            "title[0]: found the alias '*x', allowed aliases of an anchor that is com",
        ),
        ("? [a]\n: 1", "found a key that is not plain text"),
        ("title: T\n<<: {a: 1}", "found the merge key `<<`"),
        ("title: " + "[" * 500, "title"),
    ],
)
def test_text_that_cannot_be_read_on_stops_with_one_message(tmp_path, text, told):
    (line,) = faults(text, tmp_path)
    assert line.startswith(told)


@pytest.mark.parametrize(
    "tag", ["!!python/object/apply:os.system ['true']", "!!str 1", "! x", "!mine {}", "!!set {a}"]
)
def test_tags_are_refused_and_make_nothing(tmp_path, tag):
    lines = faults(BASE + f"description: {tag}\n", tmp_path)
    assert any(line.startswith("description: found the YAML tag '") for line in lines)


@pytest.mark.parametrize("word", ["on", "No", "12:30", "010", "1_000", "2020-01-01", "0o17"])
def test_words_that_yaml_readers_disagree_on_are_refused(tmp_path, word):
    (line,) = faults(BASE.replace("tau_end: 20", f"tau_end: {word}"), tmp_path)
    assert line.startswith(
        f"scenes.forced.tau_end: found '{word}' unquoted, allowed a plain number"
    )
    (line,) = faults(BASE.replace("A study", word), tmp_path)
    assert line.startswith("title: found")
    assert study_of(BASE.replace("A study", f"'{word}'"), tmp_path).title == word


def test_duplicate_keys_are_refused_at_every_depth(tmp_path):
    assert faults(BASE.replace("h: 0.2", "h: 0.2, h: 0.3"), tmp_path) == [
        "exciter.h: found this key a second time, allowed each key once"
    ]
    assert faults(BASE.replace("nu: 1", "nu: 1, ν: 2"), tmp_path) == [
        "exciter.nu: found this key a second time, as 'ν', allowed each key once"
    ]
    assert faults(BASE + "title: U\n", tmp_path)[0].startswith(
        "title: found this key a second time"
    )


def test_a_tree_without_end_is_refused_too():
    tree = {"title": "T"}
    tree["description"] = tree
    with pytest.raises(StudyError, match="found more than 12 levels"):
        parse_study(tree)


def test_aliases_cannot_grow_without_bound(tmp_path):
    laughs = "a0: &a0 [1, 1]\n"
    laughs += "".join(f"a{n}: &a{n} [*a{n - 1}, *a{n - 1}]\n" for n in range(1, 11))
    assert all("unknown key" in line for line in faults(laughs + BASE, tmp_path))
    wide = "a0: &a0 [" + "1, " * 999 + "1]\na1: &a1 [" + "*a0, " * 999 + "*a0]\n"
    (line,) = faults(wide + BASE, tmp_path)
    assert line == "a1: found more than 200000 values, allowed at most 200000"
    tower = "a0: &a0 [1]\n" + "".join(f"a{n}: &a{n} [*a{n - 1}]\n" for n in range(1, 40))
    (line,) = faults(tower + BASE, tmp_path)
    assert "found more than 12 levels, allowed at most 12 levels of nesting" in line


@pytest.mark.parametrize(
    "name",
    ["../up", "a/b", "a.b", "A", "1st", "a b", "a-b", "ä", "", "_a", "a'b", "a" * 65, "/etc"],
)
def test_names_never_hold_pieces_of_paths(tmp_path, name):
    tree = {"title": "T", "scenes": {name: {"kind": "motion", "exciter": {"l": 1}}}}
    with pytest.raises(StudyError, match=r"scenes\..*allowed a name of a-z, 0-9 and _"):
        parse_study(tree)
    with pytest.raises(StudyError, match=r"studies\[0\].*allowed a name of a-z, 0-9 and _"):
        parse_config({"studies": [name]}, tmp_path)


def test_the_file_has_a_name_too(tmp_path):
    (line,) = faults(BASE, tmp_path, name="my study")
    assert line.startswith("found the file name 'my study.yaml', allowed a name of a-z")


@pytest.mark.parametrize(
    ("title", "told"),
    [
        ('"a\\x07b"', "found the character U+0007"),
        ('"a\\nb"', "found the character U+000A"),
        ('"a\\u2028b"', "found the character U+2028"),
        ("x" * 201, "found 201 characters, allowed one line of text, at most 200 characters"),
        ('" "', "found 0 characters"),
        ("12", "found 12, allowed one line of text, at most 200 characters (put it in quotes"),
        ("", "found nothing, allowed one line of text"),
    ],
)
def test_titles_are_printable_text(tmp_path, title, told):
    (line,) = faults(BASE.replace("A study", title), tmp_path)
    assert line.startswith(f"title: {told}")


@pytest.mark.parametrize("title", ["#set page", "$x$", "\\end{a}", "<b>", "{{x}}", "*a*"])
def test_markup_in_titles_is_only_text(tmp_path, title):
    assert study_of(BASE.replace("A study", f"'{title}'"), tmp_path).title == title


def test_files_that_cannot_be_read(tmp_path):
    with pytest.raises(
        StudyError, match=r"none\.yaml: found no such file or directory, allowed a rea"
    ):
        load_study(tmp_path / "none.yaml")
    with pytest.raises(StudyError, match="found is a directory"):
        load_study(tmp_path)
    (tmp_path / "latin.yaml").write_bytes("title: é".encode("latin-1"))
    with pytest.raises(StudyError, match="found a byte that is not UTF-8 at place 7"):
        load_study(tmp_path / "latin.yaml")
    (tmp_path / "big.yaml").write_bytes(b"#" * 1_000_001)
    with pytest.raises(StudyError, match="found more than 1000000 bytes"):
        load_study(tmp_path / "big.yaml")
    (tmp_path / "bom.yaml").write_bytes(b"\xef\xbb\xbf" + BASE.encode())
    assert load_study(tmp_path / "bom.yaml").title == "A study"
