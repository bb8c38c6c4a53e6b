"""Methods that solve a motion: the closed-form flow, and constant average acceleration."""

from __future__ import annotations

from typing import Literal, get_args

Method = Literal["exact", "newmark"]
METHODS: tuple[Method, ...] = get_args(Method)
