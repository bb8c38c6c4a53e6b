"""YAML that is rejected, names and titles that are not plain text, and numbers with a comma or in quotes."""

import pytest
from study_texts import BASE, faults, scene_faults, study_of

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


COMMA = "scenes.s.{0}: must be {2}, got '{1}' (write {3}, with a point)"


@pytest.mark.parametrize(
    ("text", "line"),
    [
        ("title: T\nexciter:\n\tl: 0.5\n", 3),
        ("title: T\nexciter:\n  l: 0.5\n\tf: 1\n", 4),
        ("title: T\nexciter: {l: 0.5}\nscenes:\n  s:\n    kind: motion\n  \ttau_end: 3\n", 6),
    ],
)
def test_a_tab_as_indentation(tmp_path, text, line):
    assert faults(text, tmp_path) == [
        f"must be indented by spaces, got a tab at the start of line {line} "
        "(put spaces in place of each tab)"
    ]


def test_a_tab_that_yaml_allows(tmp_path):
    assert study_of(BASE.replace("l: 0.5", "l:\t0.5"), tmp_path).exciter.l == 0.5


@pytest.mark.parametrize(
    ("scene", "told"),
    [
        ("{kind: motion, tau_end: 1,5}", [("tau_end", "1,5", "a number", "1.5")]),
        (
            "{kind: motion, start: {x0: -0,1, v0: +2,50e-1}}",
            [("start.x0", "-0,1", "a number", "-0.1"), ("start.v0", "+2,50e-1", "a number", "+2.50e-1")],
        ),
        (
            "{kind: sweep, over: {nu: {start: 0,05, stop: 1,5, points: 3}}}",
            [
                ("over.nu.start", "0,05", "a number", "0.05"),
                ("over.nu.stop", "1,5", "a number", "1.5"),
            ],
        ),
        (
            "{kind: motion, tau_end: '1,5'}",
            [("tau_end", "1,5", "a number above 0 up to 1e9", "1.5")],
        ),
        (
            "\n    kind: sweep\n    over:\n      nu:\n        - 0,5\n        - 1.5",
            [("over.nu[0]", "0,5", "a finite number", "0.5")],
        ),
        (
            "\n    kind: motion\n    exciter:\n      R1: 0,7",
            [("exciter.R1", "0,7", "a number from 0 to 1", "0.7")],
        ),
    ],
)  # fmt: skip
def test_a_decimal_comma(tmp_path, scene, told):
    assert scene_faults(scene, tmp_path) == [COMMA.format(*parts) for parts in told]


@pytest.mark.parametrize(
    ("values", "told"),
    [
        ("[0,5]", "must be a finite number > 0, got 0.0"),
        ("[0,5, 1,5]", "must be increasing numbers, each once, got 1.0 after 5.0"),
        ("{values: [0,5, 1,5]}", "must be increasing numbers, each once, got 1.0 after 5.0"),
    ],
)
def test_decimal_commas_in_a_list_that_is_refused(tmp_path, values, told):
    (line,) = scene_faults(f"{{kind: sweep, over: {{nu: {values}}}}}", tmp_path)
    path = "scenes.s.over.nu" + (".values" if "values" in values else "")
    assert line == f"{path}: {told} (if 0.5 is meant, write it with a point)"


@pytest.mark.parametrize(
    ("values", "found"),
    [("[0.5, 0.2]", "0.2 after 0.5"), ("[3, 2, 1]", "2.0 after 3.0"), ("[-1, -2]", "-2.0 after -1.0")],
)  # fmt: skip
def test_a_list_that_cannot_be_meant_with_commas_has_no_such_hint(tmp_path, values, found):
    (line,) = scene_faults(f"{{kind: sweep, over: {{f: {values}}}}}", tmp_path)
    assert line.endswith(f"must be increasing numbers, each once, got {found}")


def test_a_decimal_comma_in_a_bound(tmp_path):
    design = "{{kind: design, vary: {{nu: [1, 2]}}, subject_to: {{impact_velocity_max_1: {}}}}}"
    path = "scenes.s.subject_to.impact_velocity_max_1"
    for bound in ("< 1,5", "'< 1,5'"):
        (line,) = scene_faults(design.format(bound), tmp_path)
        assert line.startswith(f"{path}: must be ")
        assert line.endswith(", got '< 1,5' (write \"< 1.5\", with a point)")


def test_lists_and_mappings_without_spaces_stay_what_they_are(tmp_path):
    study = study_of(BASE.replace("[0.1, 0.4, 0.6]", "[1,5]"), tmp_path)
    assert study.scene("free").over_arrays()["amplitude"].tolist() == [1, 5]
    (line,) = scene_faults("{kind: motion, tau_end: 1,5: 2}", tmp_path)
    assert line.startswith("scenes.s.5: is an unknown key; must be one of title, ")


@pytest.mark.parametrize(
    ("scene", "path", "allowed"),
    [
        ("{kind: motion, tau_end: '20'}", "tau_end", "a number above 0 up to 1e9"),
        ('{kind: motion, settle_periods: "20"}', "settle_periods", "a whole number from 0 to 1e9"),
        ("{kind: motion, exciter: {f: '20'}}", "exciter.f", "a finite number"),
        ('{kind: sweep, over: {f: ["20"]}}', "over.f[0]", "a finite number"),
    ],
)
def test_a_number_in_quotes(tmp_path, scene, path, allowed):
    assert scene_faults(scene, tmp_path) == [
        f"scenes.s.{path}: must be {allowed}, got '20' (a number stands without quotes: write 20)"
    ]


def test_a_title_in_quotes_may_be_a_number(tmp_path):
    study = study_of(BASE.replace("A study", "'2024'"), tmp_path)
    assert study.title == "2024"
    assert type(study.title) is str
