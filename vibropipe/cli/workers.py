"""Processes that run the commands of jobs one after another, with everything imported and kernels loaded once.

A run of the workflow starts them; a command that finds them hands over to an idle one (`vibropipe.cli.handing_over`),
one that finds none runs by itself.
"""

from __future__ import annotations

import atexit
import os
import shutil
import socket
import subprocess
import sys
import tempfile
from pathlib import Path

from vibropipe.cli.handing_over import SOCKET

COMMAND = "from vibropipe.cli.serving import serve; serve()"


class Workers:
    """The workers of a run. They end with the process that holds this object."""

    def __init__(self) -> None:
        self.listener: socket.socket | None = None
        self.lifeline = (-1, -1)
        self.first: subprocess.Popen[bytes] | None = None

    def start(self) -> None:
        """Start the first worker unless it runs; none where a socket cannot pass on open files."""
        if not hasattr(socket, "send_fds"):
            return
        if self.listener is None:
            path = Path(tempfile.mkdtemp(prefix="vibropipe-"), "jobs")
            self.listener = socket.socket(socket.AF_UNIX)
            self.listener.bind(str(path))
            self.listener.listen(128)
            self.listener.setblocking(False)
            self.lifeline = os.pipe()
            os.environ[SOCKET] = str(path)
        if self.first is None or self.first.poll() is not None:
            passed = (self.listener.fileno(), self.lifeline[0])
            # -P: the working directory may hold another copy of this package
            command = [sys.executable, "-P", "-c", COMMAND, *map(str, passed)]
            nothing = subprocess.DEVNULL
            self.first = subprocess.Popen(
                command, pass_fds=passed, stdin=nothing, stdout=nothing, stderr=nothing
            )

    def complete(self, count: int) -> None:
        """Let the first worker fork until there are `count`. If all are killed later, commands run by themselves."""
        self.start()
        if self.listener is not None:
            os.write(self.lifeline[1], bytes(count - 1))
            self.listener.close()
            atexit.register(remove_socket)


WORKERS = Workers()


def remove_socket() -> None:
    """Remove the socket of the workers and its folder."""
    if SOCKET in os.environ:
        shutil.rmtree(Path(os.environ[SOCKET]).parent, ignore_errors=True)
