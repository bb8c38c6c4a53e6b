"""Exit codes of commands and runs. This module imports nothing, since each command reads it before all else."""

INTERRUPTED = 130
"""Ctrl-C: 128, as shells count signals, and the number of SIGINT."""
