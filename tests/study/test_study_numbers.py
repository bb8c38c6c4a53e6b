"""Numbers with a comma or in quotes, and tabs: messages of their own, with the remedy."""

import pytest
from study_texts import BASE, faults, scene_faults, study_of

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
