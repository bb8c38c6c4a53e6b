"""Ctrl-C while snakemake is busy: the run ends when it is done, not within."""

import subprocess
import sys

import pytest

from vibropipe.jobs.processes import STOPPED
from vibropipe.words.exit_codes import INTERRUPTED

BEFORE = """
import asyncio, logging, os, signal, time
from vibropipe.jobs.processes import Interrupt

interrupt = Interrupt(logging.getLogger("snakemake"))
interrupt.reading = False
"""
IN_A_LOOP = """
async def wait():
    await asyncio.sleep(0.01)

async def prepare():
    async with asyncio.TaskGroup() as group:
        group.create_task(wait())
        os.kill(os.getpid(), signal.SIGINT)
    print("prepared")

with asyncio.Runner() as runner:
    runner.run(prepare())
    time.sleep(10)
"""
IN_A_HANDLER = """
class Handler(logging.Handler):
    def emit(self, record):
        os.kill(os.getpid(), signal.SIGINT)
        print("logged")

logger = logging.getLogger("other")
logger.addHandler(Handler())
logger.warning("")
time.sleep(10)
"""
IN_A_WRITE = """
import io, sys

class Raw(io.RawIOBase):
    def writable(self):
        return True

    def write(self, text):
        os.kill(os.getpid(), signal.SIGINT)
        return os.write(1, text)

sys.stderr = io.TextIOWrapper(io.BufferedWriter(Raw()), write_through=True)
logger = logging.getLogger("other")
logger.addHandler(logging.StreamHandler(sys.stderr))
logger.warning("logged")
sys.stderr.flush()
time.sleep(10)
"""


@pytest.mark.parametrize(
    ("busy", "done"), [(IN_A_LOOP, "prepared"), (IN_A_HANDLER, "logged"), (IN_A_WRITE, "logged")]
)
def test_a_run_ends_after_what_must_not_be_interrupted(busy, done):
    script = subprocess.run(
        [sys.executable, "-c", BEFORE + busy], capture_output=True, text=True, timeout=60
    )
    assert script.returncode == INTERRUPTED
    assert script.stdout.split() == [done]
    assert script.stderr.splitlines() == [STOPPED]
