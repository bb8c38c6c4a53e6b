"""A sweep in three shards, solved once undisturbed, and a disk that can be full or read-only."""

import subprocess
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from command_line import run
from sharded_study import PROGRAM, SHARDS, STUDY


class Work:
    """The study in a folder, and the commands that solve it."""

    def __init__(self, folder: Path) -> None:
        self.study = folder / "tiny.yaml"
        self.study.write_text(STUDY)
        self.shards = [folder / f"{shard}.nc" for shard in range(1, SHARDS + 1)]
        self.whole = folder / "response.nc"

    def solve_arguments(self, output: Path, *options: object) -> list[str]:
        arguments = ["solve", self.study, "--scene", "response", "--output", output, *options]
        return [str(argument) for argument in arguments]

    def solve(self, output: Path, *options: object) -> int:
        return run(*self.solve_arguments(output, *options))

    def solve_shard(self, shard: int) -> int:
        return self.solve(self.shards[shard - 1], "--shard", f"{shard}/{SHARDS}")

    def solve_apart(
        self, output: Path, *options: object, **how
    ) -> subprocess.CompletedProcess[str]:
        """Solve in a process of its own."""
        command = [*PROGRAM, *self.solve_arguments(output, *options)]
        return subprocess.run(command, capture_output=True, text=True, check=False, **how)

    def join(self, output: Path) -> int:
        return run("join", self.study, "--scene", "response", "--output", output, *self.shards)


@pytest.fixture(scope="session")
def work(tmp_path_factory: pytest.TempPathFactory) -> Work:
    """The study with its shards and its dataset, undisturbed."""
    made = Work(tmp_path_factory.mktemp("undisturbed"))
    for shard in range(1, SHARDS + 1):
        assert made.solve_shard(shard) == 0
    assert made.join(made.whole) == 0
    return made


@pytest.fixture
def said(capsys: pytest.CaptureFixture[str]) -> Callable[[], str]:
    """Return a function that returns the only message of a failed command; lines of progress are ignored."""

    def message() -> str:
        captured = capsys.readouterr()
        assert not captured.out
        lines = [line for line in captured.err.splitlines() if not line.startswith("response")]
        assert len(lines) == 1, captured.err
        return lines[0]

    return message


@pytest.fixture
def disk(tmp_path: Path) -> Iterator[Callable[..., Path]]:
    """Yield a function that mounts a disk with some options, or remounts it with others."""
    mount_point = tmp_path / "disk"
    mount_point.mkdir()
    mounted = False

    def mount(options: str) -> Path:
        nonlocal mounted
        remount = "remount," if mounted else ""
        command = ["mount", "-t", "tmpfs", "-o", remount + options, "tmpfs", str(mount_point)]
        try:
            done = subprocess.run(command, capture_output=True, text=True, check=False)
        except OSError as error:
            pytest.skip(f"nothing can be mounted here: {error}")
        if done.returncode != 0:
            pytest.skip(f"mounting is not permitted here: {done.stderr.strip()}")
        mounted = True
        return mount_point

    yield mount
    if mounted:
        # lazily: HDF5 may hold a file that it failed to write until the process ends
        subprocess.run(["umount", "--lazy", str(mount_point)], check=True)
