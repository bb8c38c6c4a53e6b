"""A project for each test: a copy of the workflow, and a study that takes seconds."""

import os
import re
import shutil
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import pytest
from sharded_study import parts_of

REPOSITORY = Path(__file__).parents[2]
COPIED = ("workflow", "profiles")
STUDY = """\
title: A study of seconds
exciter: {l: 0.5, nu: 1, f: -1, h: 0.2, R1: 0.7, R2: 0.7}
scenes:
  free: {kind: motion, tau_end: 7, exciter: {f: 0}, start: {v0: -0.51}, samples_per_period: 16}
  forced:
    kind: motion
    caption: Impacts {{ on }} *both* supports.
    tau_end: 20
    samples_per_period: 16
  response:
    kind: sweep
    over: {f: [0.2, 0.6, 1], nu: [0.9, 1, 1.1, 1.2]}
    follow: {along: nu, direction: down}
"""


@dataclass
class Project:
    """A folder that contains the workflow."""

    folder: Path

    def path(self, *names: str) -> Path:
        return self.folder.joinpath(*names)

    def copied(self, folder: Path, *left_out: str) -> "Project":
        """Return a copy without the files and folders of some names."""
        ignored = shutil.ignore_patterns(*left_out)
        return Project(Path(shutil.copytree(self.folder, folder, ignore=ignored)))

    def own_package(self) -> None:
        """Copy the package into the project, to be edited there; its kernels are not compiled."""
        copy(REPOSITORY / "vibropipe", self.folder / "vibropipe")

    def edit(self, name: str, old: str, new: str) -> None:
        text = self.path(name).read_text()
        assert text.count(old) == 1
        self.path(name).write_text(text.replace(old, new))

    def snakemake(self, *arguments: str, code: int = 0, **environment: str) -> str:
        """Run snakemake, check its exit code and return its output."""
        process = self.start(*arguments, **environment)
        printed, _ = process.communicate()
        assert process.returncode == code, printed
        return printed

    def start(self, *arguments: str, **environment: str) -> subprocess.Popen:
        """Start snakemake in its own session and without a network."""
        nowhere = "http://127.0.0.1:9"
        # a package in the project is imported instead of the repository's
        path = str(self.folder if self.path("vibropipe").is_dir() else REPOSITORY)
        proxies = {"http_proxy": nowhere, "https_proxy": nowhere}
        return subprocess.Popen(
            [sys.executable, "-m", "snakemake", "--cores", "2", *arguments],
            cwd=self.folder,
            env=os.environ | {"PYTHONPATH": path} | proxies | environment,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            start_new_session=True,
        )

    def planned(self, *arguments: str, **environment: str) -> set[str]:
        """Return the jobs of the next run."""
        printed = self.snakemake("--dry-run", *arguments, **environment)
        assert "Nothing to be done" in printed or "This was a dry-run" in printed
        jobs = re.findall(r"^Job \d+: (?:tiny: )?(.+)$", printed, re.MULTILINE)
        return {part for job in jobs for part in parts_of(job)}


def copy(source: Path, target: Path) -> None:
    if source.is_dir():
        shutil.copytree(source, target, ignore=shutil.ignore_patterns("__pycache__"))
    else:
        shutil.copy2(source, target)


@pytest.fixture(scope="session")
def fresh(tmp_path_factory: pytest.TempPathFactory) -> Project:
    """A project before its first run."""
    folder = tmp_path_factory.mktemp("fresh")
    for name in COPIED:
        copy(REPOSITORY / name, folder / name)
    (folder / "config").mkdir()
    (folder / "config" / "config.yaml").write_text("studies: [tiny]\n")
    (folder / "config" / "tiny.yaml").write_text(STUDY)
    return Project(folder)


@pytest.fixture(scope="session")
def finished(fresh: Project, tmp_path_factory: pytest.TempPathFactory) -> Project:
    """A project after a complete run."""
    folder = tmp_path_factory.mktemp("finished") / "project"
    shutil.copytree(fresh.folder, folder)
    project = Project(folder)
    project.snakemake()
    return project


@pytest.fixture
def project(finished: Project, tmp_path: Path) -> Project:
    """A copy of the finished project with the modification times of its files."""
    folder = tmp_path / "project"
    shutil.copytree(finished.folder, folder)
    return Project(folder)
