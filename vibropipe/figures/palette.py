"""The colours of all pictures, with their lightness L* (0 black, 100 white), and how legible they are.

What may touch differs by at least MIN_STEP in lightness, and hatch, marker or line style repeat it, for print in grey
and for colour-blind eyes. Cold colours are this program, warm ones other packages; magnitudes are drawn with
MAGNITUDES, signed quantities with SIGNED, symmetric about 0; FAILED marks what fails or is not as wanted, nothing else.
"""

from __future__ import annotations

import colorsys
from collections.abc import Mapping
from dataclasses import dataclass

from matplotlib.colors import LinearSegmentedColormap, to_hex, to_rgb

MIN_STEP = 12.0  # of L* between what may touch
MIN_CONTRAST = 4.5  # of text on white, by the WCAG 2

INK, GREY, BAND, HAIRLINE = "#1A1A1A", "#6B6B6B", "#E9E9E9", "#C9C9C9"  # 9, 45, 92, 81
FAILED = "#C8102E"  # 43


@dataclass(frozen=True)
class MethodStyle:
    """Colour, marker and name of a method."""

    colour: str
    marker: str
    label: str


METHODS: Mapping[str, MethodStyle] = {
    "exact": MethodStyle("#0B2A5B", "D", "exact"),  # 18
    "newmark": MethodStyle("#2F7FC1", "s", "Newmark"),  # 51
    "crude": MethodStyle("#86BDE3", "o", "impact at the end of a step"),  # 74
    "dop853": MethodStyle("#A33B0B", "v", "DOP853"),  # 39
    "rk45": MethodStyle("#E08A2E", "^", "RK45"),  # 65
    "radau": MethodStyle("#6E5A4B", "P", "Radau"),  # 40
    "heyoka": MethodStyle("#6B1A2E", "X", "heyoka"),  # 25
    "nivp": MethodStyle("#C9A227", "p", "solve-nivp"),  # 68
}
EXACT = METHODS["exact"].colour

SUPPORT_COLOURS = {1: "#E07B1A", 2: "#17559C"}  # 62, 36
SUPPORT_MARKERS = {1: "^", 2: "v"}
SUPPORT_TEXT = {1: "#B0630F", 2: "#17559C"}  # the same for words and numbers
BLUES = ("#86BDE3", "#0B2A5B")  # ends of an ordered family, light to dark
ORANGES = ("#F2BE85", "#8A3D06")


@dataclass(frozen=True)
class RegimeStyle:
    """Colour, and hatch with its colour, of a regime on maps and in strips."""

    colour: str
    hatch: str
    hatch_colour: str = INK


REGIME_STYLES: Mapping[str, RegimeStyle] = {
    "no_impact": RegimeStyle("#F7F7F5", ""),  # 97
    "with_rest": RegimeStyle("#E3D45E", "...."),  # 84
    "one_sided_1": RegimeStyle("#7FB5E0", "////"),  # 71
    "two_sided": RegimeStyle("#4F9A78", ""),  # 58
    # more than one impact on a support
    "two_sided_more": RegimeStyle("#26745B", "////"),  # 44
    "one_sided_2": RegimeStyle("#0F4A8A", "\\\\\\\\", "#FFFFFF"),  # 31
    "aperiodic": RegimeStyle("#5A1506", "xxxx", "#FFFFFF"),  # 19
    "unbounded": RegimeStyle("#050505", ""),  # 1
    # no regime but a row without one: white with red crosses
    "unresolved": RegimeStyle("#FFFFFF", "xxxx", FAILED),  # 100
}

# What is proved of an orbit, with lightnesses of their own as well.
PROOF_STYLES: Mapping[str, RegimeStyle] = {
    "not_tried": RegimeStyle("#F7F7F5", ""),  # 97
    "undecided": RegimeStyle("#E3D45E", "...."),  # 84
    "proved_stable": RegimeStyle("#7FB5E0", ""),  # 71
    "proved_unstable": RegimeStyle("#26745B", "////"),  # 44
    "disproved": RegimeStyle("#5A1506", "xxxx", "#FFFFFF"),  # 19
}

MAGNITUDES = "cividis"
SIGNED = LinearSegmentedColormap.from_list(
    "blue_white_orange",
    ["#0B2A5B", "#2F7FC1", "#A9D0EC", "#F7F7F5", "#F2BE85", "#E07B1A", "#8A3D06"],
)


def lightness(colour: str) -> float:
    """Return the lightness L* of a colour in CIELAB, 0 to 100."""
    luminance = _luminance(colour)
    cube = luminance ** (1 / 3)
    return 116 * cube - 16 if luminance > 216 / 24389 else 24389 / 27 * luminance


def contrast(colour: str) -> float:
    """Return the contrast of a colour on white, 1 to 21, by the WCAG 2."""
    return 1.05 / (_luminance(colour) + 0.05)


def readable(colour: str) -> str:
    """Return a colour for text on white: the same, darkened until its contrast is MIN_CONTRAST."""
    hue, light, saturation = colorsys.rgb_to_hls(*to_rgb(colour))
    shown = to_hex(to_rgb(colour))
    while contrast(shown) < MIN_CONTRAST:
        light *= 0.98
        shown = to_hex(colorsys.hls_to_rgb(hue, light, saturation))
    return shown


def shades(amount: int, ends: tuple[str, str] = BLUES) -> list[str]:
    """Return the colours of an ordered family such as amplitudes or offsets: one hue, light to dark."""
    light, dark = (to_rgb(end) for end in ends)
    parts = [1.0] if amount == 1 else [k / (amount - 1) for k in range(amount)]
    return [_mixed(light, dark, part) for part in parts]


def shaded(colour: str, shade: float) -> str:
    """Mix a colour with white (shade > 0) or black (shade < 0)."""
    return _mixed(to_rgb(colour), (1.0, 1.0, 1.0) if shade > 0 else (0.0, 0.0, 0.0), abs(shade))


Rgb = tuple[float, float, float]


def _mixed(first: Rgb, second: Rgb, part: float) -> str:
    """Return a colour between two, at `part` of the way from the first."""
    red, green, blue = ((1 - part) * a + part * b for a, b in zip(first, second, strict=True))
    return to_hex((red, green, blue))


def _luminance(colour: str) -> float:
    linear = [
        value / 12.92 if value <= 0.04045 else ((value + 0.055) / 1.055) ** 2.4
        for value in to_rgb(colour)
    ]
    return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]
