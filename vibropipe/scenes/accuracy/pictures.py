"""Pictures of an accuracy scene: time over error, and what is asked of the program and reached."""

from __future__ import annotations

from vibropipe.scenes.accuracy.asked import (
    describe_asked,
    draw_asked,
    has_asked,
    title_of_asked,
)
from vibropipe.scenes.accuracy.curves import draw_work_precision
from vibropipe.scenes.accuracy.text import describe_work_precision, title_of
from vibropipe.scenes.kind import Picture, showing

PICTURES = (
    Picture(
        "work_precision", draw_work_precision, describe_work_precision, keywords=showing,
        titled=title_of,
    ),
    Picture(
        "asked", draw_asked, describe_asked, fits=has_asked, keywords=showing, titled=title_of_asked,
        heading="What do I get if I ask for an accuracy?",
    ),
)  # fmt: skip
