"""The configuration, the schema, the table of keys and the studies in `config/`."""

import inspect
import math
import re
import subprocess
import sys
from pathlib import Path

import jsonschema
import pytest
import yaml
from command_line import printed
from study_texts import BASE, faults, study_of

import vibropipe as vp
from vibropipe.jobs.plan import plan_scene
from vibropipe.study import StudyError, json_schema, load_config, load_study, parse_config
from vibropipe.study.reference import PYTHON, QUANTITIES_PAGE, python_page, quantities_page
from vibropipe.study.schema import readme_text, schema_text
from vibropipe.words.parameters import PARAMETERS

ROOT = Path(__file__).parents[2]
CONFIG, DOCS = ROOT / "config", ROOT / "docs"
FILES = [*CONFIG.glob("*.yaml"), *(ROOT / ".test" / "config").glob("*.yaml")]
STUDIES = sorted(file for file in FILES if file.name != "config.yaml")


def test_config_lists_studies_beside_it():
    config = load_config(CONFIG / "config.yaml")
    assert config.studies[:2] == ["paper", "regimes"]
    assert config.results == "results"
    assert config.study_file("paper") == CONFIG / "paper.yaml"


def test_config_takes_names_as_one_text(tmp_path):
    assert parse_config({"studies": "paper, regimes"}, tmp_path).studies == ["paper", "regimes"]


def test_a_study_without_a_file_is_named_with_the_nearest_that_has_one(tmp_path):
    (tmp_path / "paper.yaml").write_text(BASE)
    (tmp_path / "regimes.yaml").write_text(BASE)
    config = tmp_path / "config.yaml"
    config.write_text("studies: [papr, regimes, other]\n")
    with pytest.raises(StudyError) as caught:
        load_config(config)
    assert str(caught.value).splitlines() == [
        f"{config}: studies[0]: must be the name of a study beside this file (paper, regimes), "
        f"got 'papr', but {tmp_path / 'papr.yaml'} does not exist (did you mean 'paper'?)",
        f"{config}: studies[2]: must be the name of a study beside this file (paper, regimes), "
        f"got 'other', but {tmp_path / 'other.yaml'} does not exist",
    ]
    config.write_text("studies: [paper, regimes]\n")
    assert load_config(config).studies == ["paper", "regimes"]


@pytest.mark.parametrize(
    ("text", "told"),
    [
        *(
            (f"studies: [{name}]", r"studies\[0\]: .*did you mean 'paper'\?\)$")
            for name in ("paper.yaml", "config/paper.yaml", "Paper")
        ),
        ("studies: [mine]", r"must be the name of a study beside .*there is none\), got 'mine'"),
        ("studys: [one]", r"studys: is an unknown key; must be .*did you mean 'studies'"),
    ],
)
def test_what_names_no_study_is_told_with_what_may_be_meant(tmp_path, text, told):
    (tmp_path / "config.yaml").write_text(text)
    with pytest.raises(StudyError, match=told):
        load_config(tmp_path / "config.yaml")


@pytest.mark.parametrize("file", STUDIES, ids=lambda file: file.stem)
def test_shipped_studies_are_sound_and_named_in_the_schema(file):
    study = load_study(file)
    schema = json_schema()
    jsonschema.Draft202012Validator.check_schema(schema)
    jsonschema.validate(yaml.safe_load(file.read_text(encoding="utf-8")), schema)
    first = file.read_text(encoding="utf-8").splitlines()[0]
    _, _, where = first.partition("# yaml-language-server: $schema=")
    assert (file.parent / where).resolve() == CONFIG / "study.schema.json"
    for name, scene in study.scenes.items():
        assert scene.title, name


@pytest.mark.parametrize("file", STUDIES, ids=lambda file: file.stem)
def test_shipped_studies_can_be_planned(file):
    for scene in load_study(file).scenes.values():
        assert plan_scene(scene).effects


def test_schema_takes_greek_and_refuses_what_the_models_refuse():
    schema = json_schema()
    greek = BASE.replace("nu:", "ν:").replace("delta:", "δ:").replace("R1", "R₁")
    jsonschema.validate(yaml.safe_load(greek), schema)
    for bad in ("h: -1", "q: 1", "R₂: 2", "l: 0"):
        tree = yaml.safe_load(BASE.replace("R2: 0.7", bad))
        with pytest.raises(jsonschema.ValidationError):
            jsonschema.validate(tree, schema)


def test_schema_and_table_of_keys_have_not_drifted():
    remedy = "run `python -m vibropipe.study`"
    assert (CONFIG / "study.schema.json").read_text(encoding="utf-8") == schema_text(), remedy
    readme = (CONFIG / "README.md").read_text(encoding="utf-8")
    assert readme_text(readme) == readme, remedy
    for page, text in ((PYTHON, python_page()), (QUANTITIES_PAGE, quantities_page())):
        assert (DOCS / page).read_text(encoding="utf-8") == text, remedy


def test_the_reference_has_every_call_argument_and_quantity():
    page = python_page()
    for name in vp.__all__:
        call = getattr(vp, name)
        assert f"\n## `vp.{name}`\n" in page
        part = page.split(f"\n## `vp.{name}`\n")[1].split("\n## ")[0]
        if isinstance(call, type):
            continue
        for argument in inspect.signature(call).parameters:
            listed = re.search(rf"^- `[^`]*\b{argument}\b[^`]*`( \(|: |$)", part, re.MULTILINE)
            assert listed, (name, argument)
    text = quantities_page()
    for name in (*PARAMETERS, "impact_velocity_max", "power_input", "bifurcation_kind"):
        assert f"| `{name}`" in text
    assert "`bifurcation_<parameter>`" in text


def test_drift_is_seen_and_mended(tmp_path):
    readme = (CONFIG / "README.md").read_text(encoding="utf-8")
    (tmp_path / "README.md").write_text(
        readme.replace("| `tau_end` |", "| `tau` |"), encoding="utf-8"
    )
    command = [sys.executable, "-m", "vibropipe.study", str(tmp_path)]
    subprocess.run(command, check=True, cwd=ROOT)
    assert (tmp_path / "README.md").read_text(encoding="utf-8") == readme
    assert (tmp_path / "study.schema.json").read_bytes() == (
        CONFIG / "study.schema.json"
    ).read_bytes()
    with pytest.raises(StudyError, match=r"must have the lines .*, got no table of keys"):
        readme_text("# Nothing here")


def test_example_of_the_readme_is_a_study(tmp_path):
    readme = (CONFIG / "README.md").read_text(encoding="utf-8")
    text = readme.split("```yaml\n")[1].split("```")[0]
    assert set(study_of(text, tmp_path).scenes) == {"offset", "response"}
    bad = text.replace("delta: [0, 0.01, 0.1]", "R1: [0, 1.2]")
    (line,) = faults(bad, tmp_path)
    assert f"config/mine.yaml: {line}" in readme


def test_the_paper_is_all_there():
    """The sets of parameters of eqs. (11), (12) and (14) to (18), and the curves of figure 2."""
    paper = load_study(CONFIG / "paper.yaml")
    forced = {"nu": 1, "f": -1, "h": 0.2, "l": 0.5}
    sets = {
        "forced_symmetric": (0.7, 0.7, 0),
        "forced_offset": (0.7, 0.7, 0.01),
        "forced_unequal": (0.6, 0.8, 0),
        "forced_both": (0.6, 0.8, 0.01),
        "forced_both_swapped": (0.8, 0.6, 0.01),
    }
    for name, (R1, R2, delta) in sets.items():
        scene = paper.scene(name)
        assert scene.resolved_exciter() == {**forced, "R1": R1, "R2": R2, "delta": delta}
        assert scene.solver.arguments() == {"method": "newmark", "steps_per_period": 2000}
        assert scene.tau_end == pytest.approx(6 * math.pi, rel=1e-15)
    for name, delta in (("conservative_0", 0), ("conservative_offset", 0.01)):
        scene = paper.scene(name)
        assert scene.resolved_exciter() == {
            **{"nu": 1, "f": 0, "h": 0, "l": 0.5, "delta": delta, "R1": 1, "R2": 1}
        }
        assert (scene.start.x0, scene.start.v0) == (0, -0.51)
    assert paper.scene("backbone").over_arrays()["delta_over_l"].tolist() == [0, 0.1, 0.2, 0.3]
    told = [int(number) for row in paper.table.rows for number in row[0].split(", ")]
    assert told == list(range(2, 13))


def test_importing_studies_is_light():
    code = "import sys, vibropipe.study; print(*sys.modules)"
    loaded = {name.partition(".")[0] for name in printed(code, cwd=ROOT).split()}
    assert "pydantic" in loaded
    assert not loaded & {
        "numba",
        "xarray",
        "matplotlib",
        "scipy",
        "pandas",
        "netCDF4",
        "h5py",
        "dask",
    }
