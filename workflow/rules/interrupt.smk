# How snakemake ends on Ctrl-C: included before anything that takes time.
import atexit
import os
import signal
import sys

from snakemake.logging import logger

INTERRUPTED = 130
STOPPED = "interrupted; what is finished is kept: the same command goes on from there"
stopped = []
reading = [True]  # until all rules are read there is nothing to end but this process


def say(text):
    """Print for people; on stderr, since stdout may be a graph or a summary."""
    print(text, file=sys.stderr, flush=True)


def stop(number, frame):
    """End on Ctrl-C with one line; jobs have had it too, and what snakemake tells of their ends is noise."""
    if not stopped:
        stopped.append(number)
        signal.signal(signal.SIGINT, lambda *_: None)
        signal.signal(signal.SIGALRM, stop)
        logger.setLevel("CRITICAL")
        say(STOPPED)
    if reading:
        os._exit(INTERRUPTED)
    if is_told(frame):
        signal.setitimer(signal.ITIMER_REAL, 0.05)
    else:
        raise SystemExit(INTERRUPTED)


def leave():
    """See that the exit code tells of Ctrl-C, by whatever way snakemake ends."""
    if stopped:
        sys.stdout.flush()
        os._exit(INTERRUPTED)


def is_told(frame):
    """Tell whether a log handler is at work: those of snakemake swallow whatever ends a program."""
    while frame is not None and frame.f_code.co_name != "emit":
        frame = frame.f_back
    return frame is not None


# where Ctrl-C is left to the shell (a job in the background), it stays so
if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
    signal.signal(signal.SIGINT, stop)
    atexit.register(leave)
