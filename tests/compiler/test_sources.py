"""The hash of the sources covers all that numbers depend on, and nothing else."""

import shutil
from dataclasses import replace
from pathlib import Path

import pytest
from command_line import printed

from vibropipe.compiler import sources
from vibropipe.compiler.sources import PACKAGE, SOLVERS, WORDS, closure, file_hash, source_hash
from vibropipe.scenes.registry import kinds
from vibropipe.words.exciter import EFFECTS, PARAMETERS
from vibropipe.words.quantities import QUANTITIES
from vibropipe.words.records import Range

SOLVING = """
import sys
import numpy as np
import vibropipe as vp
exciter = vp.Exciter(l=0.5, nu=1.0, f=-1.0, h=0.2, R1=0.7, R2=0.7)
vp.simulate(exciter, tau_end=3.0, energy=True)
vp.simulate(exciter, tau_end=3.0, accuracy=1e-2)
vp.steady_state(exciter)
outputs = ["harmonics", "impacts", "motion", "stability", "energy"]
vp.sweep(exciter, {"nu": [0.9, 1.0]}, follow=("nu", "up"), outputs=outputs, accuracy=1e-6)
vp.backbone([0.1], [3.0, 4.0])
vp.amplitude_frequency(exciter, [0.6, 0.7])
print(*(name for name in sys.modules if name.split(".")[0] == "vibropipe"))
"""
# Files whose edit changes the hash of the numbers, of some measurements of the program, or no hash.
NUMBERS = (
    "words/regimes.py",
    "words/parameters.py",
    "words/outputs.py",
    "words/status.py",
    "physics/saltation.py",
    "march/loop.py",
    "solve/rows/many.py",
    "compiler/__init__.py",
    "compiler/pieces.py",
)
MEASUREMENTS = {
    "lab/hard_cases/contacts.py": {"hard_cases"},
    "lab/peers/solve_ivp.py": {"accuracy", "effects", "hard_cases"},
    "lab/crude.py": {"accuracy", "effects", "hard_cases"},
    "scenes/effects/solve.py": {"effects"},
    "scenes/motion/solve.py": {"motion"},
    "lab/effect_costs.py": {"effects"},
}
NEITHER = (
    "words/exciter.py",
    "words/quantities.py",
    "words/records.py",
    "words/vocabulary.py",
    "words/quantities.toml",
    "figures/style.py",
    "report/parts.py",
    "study/models.py",
    "scenes/motion/keys.py",
    "scenes/sweep/keys.py",
    "scenes/sweep/cut.py",
    "scenes/accuracy/pictures.py",
    "cli/commands.py",
    "jobs/run.py",
    "lab/bench.py",
)


@pytest.fixture
def package(tmp_path):
    """Yield a copy of the package that tests may edit."""
    ignored = shutil.ignore_patterns("__pycache__")
    yield Path(shutil.copytree(PACKAGE, tmp_path / "vibropipe", ignore=ignored))
    sources._read.cache_clear()


def hashes(package: Path) -> dict[str, str]:
    """Return the hash of the solvers and of each kind of scene."""
    sources._read.cache_clear()
    own = {kind: file_hash(package / "scenes" / kind / "solve.py", package) for kind in kinds()}
    return {"numbers": source_hash(SOLVERS, package=package), **own}


def changed_hashes(package: Path, name: str) -> set[str]:
    """Edit a file and return the names of the hashes that change."""
    before = hashes(package)
    assert package.joinpath(name).is_file()
    with package.joinpath(name).open("a") as file:
        file.write("# an edit\n")
    after = hashes(package)
    return {kind for kind in before if before[kind] != after[kind]}


def test_a_solving_process_imports_hashed_modules_only():
    imported = set(printed(SOLVING).split())
    assert "vibropipe.solve.accuracy.orbit_errors" in imported
    # the vocabulary imports the codes of measurements and bifurcations, which no solver writes
    codes = "measurements", "bifurcations", "designs", "proofs"
    named = {f"vibropipe.words.{name}" for name in codes}
    # the face and what it checks of arguments
    face = {"vibropipe", "vibropipe.solve.argument_types"}
    assert imported - set(closure(SOLVERS)) == face | {*WORDS} | named


@pytest.mark.parametrize("name", NUMBERS)
def test_an_edit_of_a_solver_changes_the_hash_of_numbers(package, name):
    assert changed_hashes(package, name) >= {"numbers"}


@pytest.mark.parametrize(("name", "kinds"), MEASUREMENTS.items())
def test_an_edit_of_a_measurement_changes_its_own_hash_only(package, name, kinds):
    assert changed_hashes(package, name) == kinds


@pytest.mark.parametrize("name", NEITHER)
def test_an_edit_of_words_and_pictures_changes_no_hash(package, name):
    assert changed_hashes(package, name) == set()


def test_a_changed_regime_code_changes_the_hash(package):
    text = package.joinpath("words/regimes.py").read_text()
    before = hashes(package)["numbers"]
    package.joinpath("words/regimes.py").write_text(text.replace("TWO_SIDED = 3", "TWO_SIDED = 9"))
    assert hashes(package)["numbers"] != before


@pytest.mark.parametrize(
    "change",
    [
        {"default": 2.0},
        {"range": Range(0)},
        {"effect": "rest"},
        {"sign": -1},
        {"dimension": "rate"},
        {"acts": lambda values: {"h": 2 * values["nu"]}},
    ],
)
def test_a_changed_fact_of_a_parameter_changes_the_hash(monkeypatch, change):
    before = source_hash(SOLVERS)
    changed = [replace(PARAMETERS[0], **change), *PARAMETERS[1:]]
    monkeypatch.setattr("vibropipe.words.exciter.PARAMETERS", changed)
    assert source_hash(SOLVERS) != before


def test_a_changed_text_of_a_parameter_changes_no_hash(monkeypatch):
    before = source_hash(SOLVERS)
    parameters = [replace(PARAMETERS[0], long_name="rate", words="r", key="R"), *PARAMETERS[1:]]
    effects = [replace(EFFECTS[0], sentence="it is slow", unless="h is 0"), *EFFECTS[1:]]
    monkeypatch.setattr("vibropipe.words.exciter.PARAMETERS", parameters)
    monkeypatch.setattr("vibropipe.words.exciter.EFFECTS", effects)
    assert source_hash(SOLVERS) == before


@pytest.mark.parametrize(
    ("change", "is_fact"),
    [
        ({"output": "energy"}, True),
        ({"dims": ("harmonic",)}, True),
        ({"has_error": False}, True),
        ({"function": lambda quantities, parameters: quantities["velocity_mean"]}, True),
        ({"long_name": "middle", "short": "middle", "drawn": (), "is_signed": False}, False),
    ],
)
def test_facts_of_a_quantity_change_the_hash_and_its_texts_do_not(monkeypatch, change, is_fact):
    before = source_hash(SOLVERS)
    changed = replace(QUANTITIES["displacement_mean"], **change)
    monkeypatch.setitem(QUANTITIES, "displacement_mean", changed)
    assert (source_hash(SOLVERS) != before) == is_fact


def test_every_kernel_is_hashed_or_belongs_to_a_measurement():
    compiled = {
        ".".join(path.relative_to(PACKAGE.parent).with_suffix("").parts)
        for path in PACKAGE.rglob("*.py")
        if "\n@jit" in path.read_text()
    }
    scene_modules = [f"{kind.package}.solve" for kind in kinds().values()]
    lab = set(closure(scene_modules))
    assert compiled <= set(closure(SOLVERS)) | lab
    assert len(compiled) > 20


def test_imports_are_found_in_every_position(tmp_path):
    folder = tmp_path / "vibropipe"
    (folder / "a").mkdir(parents=True)
    files = {
        "__init__.py": "from vibropipe.never import x\n",
        "never.py": "",
        "a/__init__.py": "",
        "a/one.py": "def f():\n    from vibropipe.a import (\n        two,\n        three,\n    )\n",
        "a/two.py": "import vibropipe.a.four\nif TYPE_CHECKING:\n    from vibropipe.never import y\n",
        "a/three.py": "import os\n",
        "a/four.py": "from vibropipe.a.one import f\n",
    }
    for name, text in files.items():
        folder.joinpath(name).write_text(text)
    modules = closure(["vibropipe.a.one"], package=folder)
    assert set(modules) == {f"vibropipe.a{end}" for end in ("", ".one", ".two", ".three", ".four")}
    without = closure(["vibropipe.a.one"], ["vibropipe.a.two"], folder)
    assert set(without) == {"vibropipe.a", "vibropipe.a.one", "vibropipe.a.three"}
    with pytest.raises(ValueError, match=r"vibropipe\.a\.five"):
        closure(["vibropipe.a.five"], package=folder)
