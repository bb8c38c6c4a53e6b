"""Workers: a command is run by an idle one as by itself, ends with its client, and does without them."""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from vibropipe.cli.handing_over import SOCKET
from vibropipe.cli.workers import Workers

CLIENT = "import os; print(os.getpid(), flush=True); from vibropipe.cli import main; main()"
PATIENCE = 300  # seconds: a worker imports for long where others keep the machine busy
LONG = """\
title: T
exciter: {l: 0.5, nu: 1, f: 1, h: 0.2, R1: 0.7, R2: 0.7}
scenes: {s: {kind: sweep, over: {nu: {start: 0.3, stop: 3, points: 400000}}}}
"""


@pytest.fixture
def workers(monkeypatch: pytest.MonkeyPatch) -> Iterator[Workers]:
    monkeypatch.setenv(SOCKET, "")
    started = Workers()
    started.start()
    yield started
    assert started.listener is not None
    started.listener.close()
    for end in started.lifeline:
        os.close(end)
    assert started.first is not None
    started.first.wait(PATIENCE)
    shutil.rmtree(Path(os.environ[SOCKET]).parent, ignore_errors=True)


def start(*arguments: str, folder: Path | None = None) -> subprocess.Popen[str]:
    return subprocess.Popen(
        [sys.executable, "-c", CLIENT, *arguments],
        cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
    )  # fmt: skip


def answer(*arguments: str, folder: Path | None = None) -> tuple[int, str]:
    """Return exit code and output of a command, without the number of its process."""
    client = start(*arguments, folder=folder)
    printed, _ = client.communicate(timeout=PATIENCE)
    return client.returncode, printed.partition("\n")[2]


def test_a_worker_answers_like_the_command_itself(workers, tmp_path, monkeypatch):
    calls = [["--version"], ["plan", "none.yaml"], ["plan", "--rough", "one.yaml"], ["solve"]]
    (tmp_path / "one.yaml").write_text(LONG)
    found = [answer(*call, folder=tmp_path) for call in calls]
    assert [code for code, _ in found] == [0, 2, 0, 2]
    socket = os.environ[SOCKET]
    monkeypatch.delenv(SOCKET)
    assert found == [answer(*call, folder=tmp_path) for call in calls]
    monkeypatch.setenv(SOCKET, socket)


def test_a_killed_client_ends_its_command_and_a_killed_worker_is_reported(workers, tmp_path):
    (tmp_path / "long.yaml").write_text(LONG)
    solve = ["solve", "long.yaml", "--scene", "s", "--output", "s.nc"]

    def under_way() -> subprocess.Popen[str]:
        client = start(*solve, folder=tmp_path)
        deadline = time.monotonic() + PATIENCE
        while not list(tmp_path.glob(".s.nc*")) and time.monotonic() < deadline:
            time.sleep(0.05)
        return client

    client = under_way()
    client.kill()
    assert workers.first.wait(PATIENCE) == 0  # not killed: interrupted, it has cleaned up
    assert [path.name for path in tmp_path.iterdir()] == ["long.yaml"]

    workers.start()
    client = under_way()
    workers.first.send_signal(signal.SIGKILL)
    printed, _ = client.communicate(timeout=PATIENCE)
    assert client.returncode == 1
    assert printed.endswith("the process that ran this command was killed\n")

    workers.complete(1)
    workers.first.kill()
    workers.first.wait(PATIENCE)
    assert answer("--version")[0] == 0  # by itself


def test_a_forked_worker_answers_while_the_first_one_is_busy(workers, tmp_path):
    (tmp_path / "long.yaml").write_text(LONG)
    workers.complete(2)
    client = start("solve", "long.yaml", "--scene", "s", "--output", "s.nc", folder=tmp_path)
    assert client.stdout.readline()
    assert answer("--version")[0] == 0
    assert client.poll() is None
    client.kill()
