"""What is installed: the package found from anywhere, and a wheel that holds all it needs."""

import os
import shutil
import subprocess
import sys
import tomllib
import zipfile
from importlib.metadata import version
from itertools import chain
from pathlib import Path

import pytest

import vibropipe as vp

ROOT = Path(__file__).parents[1]
BUILD = "import sys; from hatchling.build import build_wheel; print(build_wheel(sys.argv[1]))"


LAYOUT = (
    "Snakefile",
    "pyproject.toml",
    "config",
    "workflow",
    "vibropipe",
    "results",
    "tests",
    "README.md",
)


@pytest.mark.parametrize("name", LAYOUT)
def test_the_root_has_the_files_and_folders_that_users_know(name):
    assert (ROOT / name).exists()


@pytest.fixture(scope="module")
def wheel_files(tmp_path_factory):
    """The files of a wheel built from a copy of this tree, which git's ignored files may litter."""
    clone = tmp_path_factory.mktemp("clone") / "vibropipe"
    clone.mkdir()
    for folder in ("vibropipe", "workflow", "profiles", "tests"):
        shutil.copytree(ROOT / folder, clone / folder)
    for file in ("pyproject.toml", "README.md", "LICENSE", ".gitignore"):
        shutil.copy(ROOT / file, clone)
    command = [sys.executable, "-c", BUILD, str(clone.parent)]
    built = subprocess.run(command, cwd=clone, capture_output=True, text=True, check=True)
    with zipfile.ZipFile(clone.parent / built.stdout.strip()) as wheel:
        return set(wheel.namelist())


def sources(folder: str) -> set[str]:
    """All files of a folder that no interpreter has made, relative to the root of the tree."""
    paths = [path for path in (ROOT / folder).rglob("*") if path.is_file()]
    return {p.relative_to(ROOT).as_posix() for p in paths if "__pycache__" not in p.parts}


def test_a_script_beside_a_clone_imports_the_package(tmp_path):
    """The folder of the script comes first on the path, and a clone in it looks like a package without code."""
    (tmp_path / "vibropipe" / "vibropipe").mkdir(parents=True)
    script = tmp_path / "script.py"
    script.write_text("import vibropipe as vp\nprint(vp.Exciter(l=0.5).l)\n", encoding="utf-8")
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    command = [sys.executable, str(script)]
    done = subprocess.run(
        command, cwd=tmp_path, env=environment, capture_output=True, text=True, check=False
    )
    assert done.stdout == "0.5\n", done.stderr


def test_a_wheel_holds_the_package_with_its_data(wheel_files):
    package = {name for name in wheel_files if name.startswith("vibropipe/")}
    assert {name for name in package if "/_workflow/" not in name} == sources("vibropipe")
    suffixes = {Path(name).suffix for name in package}
    assert {".py", ".typed", ".typ"} <= suffixes


def test_a_wheel_holds_the_workflow_where_the_command_line_looks_for_it(wheel_files):
    workflow = {name for name in wheel_files if "/_workflow/" in name}
    wanted = sources("workflow") | {"profiles/default/config.yaml"}
    assert workflow == {f"vibropipe/_workflow/{name}" for name in wanted}
    assert "vibropipe/_workflow/workflow/Snakefile" in workflow


def test_a_wheel_holds_nothing_else(wheel_files):
    tops = {name.split("/")[0] for name in wheel_files}
    assert tops == {"vibropipe", f"vibropipe-{version('vibropipe')}.dist-info"}


def test_the_version_stands_once():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    assert vp.__version__ == version("vibropipe") == project["version"]
    assert "__version__" in dir(vp)


@pytest.mark.parametrize("python", ["3.11", "3.12", "3.13"])
@pytest.mark.parametrize("lock", ["constraints.txt", "constraints-oldest.txt"])
def test_locks_hold_every_dependency_within_its_bounds(lock, python):
    """Both locks pin what pyproject.toml asks for; the oldest one at the lower bound itself."""
    from packaging.requirements import Requirement
    from packaging.utils import canonicalize_name

    version = {"python_version": python, "python_full_version": f"{python}.0"}

    def required(lines):
        requirements = map(Requirement, lines)
        return [r for r in requirements if r.marker is None or r.marker.evaluate(version)]

    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    extras = chain(*project["optional-dependencies"].values())
    lines = (ROOT / lock).read_text(encoding="utf-8").splitlines()
    pins = required(line for line in lines if not line.startswith("#"))
    for wanted in required([*project["dependencies"], *extras]):
        if wanted.name == project["name"]:  # one extra contains another
            continue
        found = [
            next(iter(pin.specifier)).version
            for pin in pins
            if canonicalize_name(pin.name) == canonicalize_name(wanted.name)
        ]
        assert found, f"{lock}: {wanted.name} is missing"
        assert all(map(wanted.specifier.contains, found)), f"{lock}: {wanted}, {found}"
        if lock == "constraints-oldest.txt":
            lowest = next(s.version for s in wanted.specifier if s.operator == ">=")
            assert all(v == lowest or v.startswith(f"{lowest}.") for v in found), wanted
