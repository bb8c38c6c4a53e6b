"""A command hands its arguments and its standard streams to an idle worker of the run that it is part of.

This module imports nothing slow.
"""

from __future__ import annotations

import json
import os
import socket
import sys

# Environment variable with the socket of the workers of a run (`vibropipe.cli.workers`).
SOCKET = "VIBROPIPE_WORKERS"
# Exit code of a command whose worker was killed.
LOST = 1


def hand_over(arguments: list[str]) -> int | None:
    """Let a worker run a command and return its exit code; return None if there is no worker.

    Parameters
    ----------
    arguments : list of str
        Arguments of the command.
    """
    path = os.environ.get(SOCKET)
    if path is None:
        return None
    with socket.socket(socket.AF_UNIX) as link:
        try:
            link.connect(path)
        except OSError:
            return None
        task = json.dumps([os.getcwd(), arguments]).encode()
        try:
            socket.send_fds(link, [len(task).to_bytes(8, "big")], [0, 1, 2])
            link.sendall(task)
            answer = link.recv(1)
        except ConnectionError:
            answer = b""
    if not answer:
        print("vibropipe: the process that ran this command was killed", file=sys.stderr)
    return answer[0] if answer else LOST
