"""What can be read on a picture."""

from functools import cache

import pytest
from matplotlib.text import Text

from vibropipe.figures.style import house_style


@cache
def texts(figure) -> list[Text]:
    """Return the texts that are drawn (labels of ticks outside an axis exist, but are not).

    A figure is drawn once for all that is asked of it.
    """
    drawn: list[Text] = []
    original = Text.draw

    def draw_text(self, renderer, *arguments, **keywords):
        drawn.append(self)
        original(self, renderer, *arguments, **keywords)

    with pytest.MonkeyPatch.context() as patch, house_style():
        patch.setattr(Text, "draw", draw_text)
        figure.draw_without_rendering()
    return [text for text in dict.fromkeys(drawn) if text.get_text().strip() and text.get_visible()]


def words(figure) -> str:
    return "\n".join(text.get_text() for text in texts(figure))
