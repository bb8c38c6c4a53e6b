"""Common style of all figures: sizes, fonts, and files that are reproducible to the byte.

To draw a picture, call `canvas.new_canvas` and `canvas.axes` inside `house_style`, with colours of `palette`; the
figure is 16 or 7.75 cm wide and is printed at that width, so that 8 pt here is 8 pt on the page. Titles and captions
stand in the report, not in the figure. Letters and formulas are those of the report, Libertinus Serif, whose files
are in `fonts/`. Write a derivative with a dot, since the prime of this font sits badly, and powers, units and indices
in 7 pt as letters (10⁻⁶, m/s², $R$₁): mathtext makes them smaller.
"""

from __future__ import annotations

import functools
import io
import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import matplotlib as mpl
from matplotlib import _mathtext, font_manager
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.figure import Figure
from matplotlib.text import Text
from matplotlib.ticker import FixedLocator, LogFormatterSciNotation, MaxNLocator, ScalarFormatter

from vibropipe.figures.canvas import BODY, CM_PER_INCH, SMALL, EvenTicks, size_of, width_of
from vibropipe.figures.palette import INK
from vibropipe.figures.units import LOWERED, RAISED
from vibropipe.store import atomic_file, with_fingerprint

FONTS = Path(__file__).with_name("fonts")
FAMILY = "Libertinus Serif"
SHRINKING = 0.88  # of indices and powers in formulas: 7.04 pt in labels, and 6.5 in a report that has smaller pictures
# Symbols in a text that has no formulas.
SYMBOLS = re.compile(r"[νδτωκ]|\b[fhlR](?= =)|\b[A-Za-z](?=[₀-₉])|\bm/M\b")
MAX_VECTOR = 20_000  # points or shapes of one artist that are stored as curves
NOTEBOOK_DPI = 110
MAX_TICK = 8  # letters of a tick that has room at the end of an axis
LONG_TICK_CM = 2.0  # room for a longer one
ROUNDING = 1e-9  # relative to the neighbouring curves; anything below is drawn as zero

BLACK, ORANGE, SKY, GREEN = "#000000", "#E69F00", "#56B4E9", "#009E73"
YELLOW, BLUE, VERMILLION, PURPLE = "#F0E442", "#0072B2", "#D55E00", "#CC79A7"
GREY, NEUTRAL = "#7F7F7F", "#D8D8D8"
EXACT_COLOUR = "#A9D3F2"

LINES: tuple[Mapping[str, Any], ...] = (
    {"color": BLUE, "linestyle": "-"},
    {"color": VERMILLION, "linestyle": (0, (5, 1.5))},
    {"color": GREEN, "linestyle": (0, (5, 1.5, 1, 1.5))},
    {"color": PURPLE, "linestyle": (0, (1, 1))},
    {"color": ORANGE, "linestyle": (0, (5, 1.5, 1, 1.5, 1, 1.5))},
    {"color": SKY, "linestyle": (0, (8, 2))},
    {"color": BLACK, "linestyle": (0, (3, 1))},
)
DOTTED: Any = (0, (1, 1.2))  # of unstable motions
LINE_MARKERS = ("o", "s", "D", "^", "v", "P", "X")

TICKS: Mapping[str, Any] = {
    "labelsize": SMALL,
    "color": INK,
    "major.width": 0.5,
    "minor.width": 0.3,
    "major.size": 3.0,
    "minor.size": 1.6,
    "major.pad": 2.5,
}
# What differs from the defaults of matplotlib, or must not follow a change of them.
SETTINGS: Mapping[str, Any] = {
    "font.family": [FAMILY],
    "mathtext.fontset": "custom",
    "mathtext.rm": FAMILY,
    "mathtext.it": f"{FAMILY}:italic",
    "mathtext.bf": f"{FAMILY}:bold",
    "mathtext.bfit": f"{FAMILY}:bold",
    "mathtext.cal": f"{FAMILY}:italic",
    "mathtext.sf": FAMILY,
    "mathtext.tt": FAMILY,
    "mathtext.fallback": "stix",
    "font.size": BODY,
    "axes.titlesize": BODY,
    "legend.title_fontsize": BODY,
    "figure.titlesize": BODY,
    "axes.linewidth": 0.5,
    "axes.edgecolor": INK,
    "axes.labelcolor": INK,
    "axes.labelpad": 3.0,
    "axes.formatter.useoffset": False,  # ticks are read without a sum
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.axisbelow": True,
    "ytick.alignment": "center",  # else digits, which have no descenders, stand below their ticks
    "text.color": INK,
    **{f"{axis}tick.{name}": value for axis in "xy" for name, value in TICKS.items()},
    "lines.linewidth": 1.2,
    "lines.markersize": 3.6,
    "hatch.linewidth": 0.35,
    "legend.frameon": False,
    "legend.handlelength": 2.2,
    "legend.columnspacing": 1.1,
    "savefig.dpi": 300,
    "svg.hashsalt": "vibropipe",
    "pdf.fonttype": 3,  # OpenType files with cubic outlines cannot be embedded as type 42
}
# Metadata of files, without the time of writing.
METADATA: Mapping[str, Mapping[str, None]] = {"svg": {"Date": None}, "pdf": {"CreationDate": None}}


@functools.cache
def add_fonts() -> None:
    """Make the fonts of the package known to matplotlib, once per process."""
    for path in sorted(FONTS.glob("*.otf")):
        font_manager.fontManager.addfont(path)


@contextmanager
def house_style() -> Iterator[None]:
    """Apply SETTINGS over matplotlib's defaults, ignoring the user's; draw and save inside."""
    add_fonts()
    usual = _mathtext.SHRINK_FACTOR
    with mpl.rc_context():
        mpl.rcdefaults()
        mpl.rcParams.update(dict[Any, Any](SETTINGS))
        _mathtext.SHRINK_FACTOR = SHRINKING
        try:
            yield
        finally:
            _mathtext.SHRINK_FACTOR = usual


class HouseFigure(Figure):
    """A figure that is drawn and saved in the house style wherever that happens."""

    def draw(self, renderer: Any) -> None:
        """Draw the figure."""
        with house_style():
            super().draw(renderer)

    def savefig(self, fname: Any, **options: Any) -> None:
        """Write the figure into a file."""
        with house_style():
            super().savefig(fname, **options)

    def _repr_png_(self) -> bytes:
        """Return the figure as a notebook shows it; pyplot, to which notebooks listen, is not used."""
        picture = io.BytesIO()
        self.savefig(picture, format="png", dpi=NOTEBOOK_DPI)
        return picture.getvalue()


def in_style(draw: Callable[[], Figure]) -> Figure:
    """Return a figure drawn in the house style, which it keeps wherever it is saved."""
    with house_style():
        figure = draw()
        use_letters_for_indices(figure)
    figure.__class__ = HouseFigure
    return figure


def write_centred(ax: Axes, *lines: str) -> None:
    """Write centred lines on an axis, the reason why it is empty."""
    ax.text(
        0.5, 0.5, "\n".join(lines), transform=ax.transAxes, ha="center", va="center", color=GREY
    )


def keep_zero_scale(ax: Axes, size: float, largest_value: float) -> None:
    """Keep an axis on which only rounding errors are drawn from being scaled to them.

    `size` is the largest magnitude on the axis, `largest_value` that on the neighbouring axes.
    """
    if size <= ROUNDING * largest_value:
        ax.set_ylim(-0.05 * largest_value or -1.0, 0.05 * largest_value or 1.0)
    if largest_value == 0.0:
        ax.set_yticks([0.0])


def rasterise_many(artists: Iterable[Artist], amount: int) -> None:
    """Store artists of more than MAX_VECTOR points or shapes as pixels, so that files remain small."""
    if amount > MAX_VECTOR:
        for artist in artists:
            artist.set_rasterized(True)


def save(figure: Figure, folder: Path, name: str, fingerprint: str = "") -> list[Path]:
    """Write `folder/name.svg` and `.pdf` atomically and return their paths; call it inside `house_style`.

    The bytes depend on the figure and on the fingerprint of what it was made from, which the files carry if given.
    """
    use_letters_for_indices(figure)
    paths = [folder / f"{name}{suffix}" for suffix in (".svg", ".pdf")]
    for path in paths:
        save_as(figure, path, fingerprint)
    return paths


class RaisedPowers(LogFormatterSciNotation):
    """Ticks of a logarithmic axis, whose powers of ten are letters of the font; 10⁰ is written as 1, 10¹ as 10."""

    def __call__(self, x: float, pos: int | None = None) -> str:
        """Return the label of a tick."""
        text = with_letters(super().__call__(x, pos))
        text = re.sub(r"(\\times)?10⁰", lambda power: "" if power[1] else "1", text)
        return re.sub(r"(?:(\d)\\times1|1)0¹", lambda power: f"{power[1] or 1}0", text)


def use_letters_for_indices(figure: Figure) -> None:
    """Write indices and powers of small type as letters: in formulas they would be too small to read.

    Ticks get equal decimals, apostrophes are curly, symbols are slanted, and a unit stands a little away from one.
    """
    for ax in figure.axes:
        for axis in (ax.xaxis, ax.yaxis):
            if type(axis.get_major_formatter()) is ScalarFormatter:
                if is_plain(axis):
                    axis.set_major_formatter(EvenTicks())
                elif axis is ax.yaxis:  # beside the title, which begins at the axis
                    axis.get_offset_text().set(horizontalalignment="right", x=-0.01)
            if axis is ax.xaxis and type(axis.get_major_formatter()) is EvenTicks:
                part_long_ticks(figure, ax)
            if type(axis.get_major_formatter()) is LogFormatterSciNotation:
                axis.set_major_formatter(RaisedPowers())
            if type(axis.get_minor_formatter()) is LogFormatterSciNotation:
                axis.set_minor_formatter(RaisedPowers(minor_thresholds=(1, 0.4)))
    for text in figure.findobj(Text):
        text.set_text(set_apart(text.get_text()))
        if float(text.get_fontsize()) < BODY and "$" in text.get_text():
            text.set_text(with_letters(text.get_text()))


def part_long_ticks(figure: Figure, ax: Axes) -> None:
    """Leave room between long ticks of a horizontal axis, with none at its ends; leave out what the figure cuts off."""
    axis = ax.xaxis
    low, high = sorted(ax.get_xlim())
    places = [place for place in axis.get_majorticklocs().tolist() if low <= place <= high]
    texts = axis.get_major_formatter().format_ticks(places)
    if max(map(len, texts), default=0) > MAX_TICK:
        number = max(3, int(size_of(ax)[0] / LONG_TICK_CM))
        axis.set_major_locator(MaxNLocator(number, steps=[1, 2, 5, 10], prune="both"))
        return
    right = figure.get_figwidth() * CM_PER_INCH
    at = [ax.transData.transform((x, 0.0))[0] / figure.dpi * CM_PER_INCH for x in places]
    half = [0.5 * width_of(figure, text, SMALL) for text in texts]
    kept = [x for x, cm, wide in zip(places, at, half, strict=True) if wide <= cm <= right - wide]
    if len(kept) < len(places):
        axis.set_major_locator(FixedLocator(kept))


def is_plain(axis: Axis) -> bool:
    """Return whether the usual labels of the ticks of an axis have no common power of ten."""
    formatter = axis.get_major_formatter()
    formatter.format_ticks(axis.get_majorticklocs().tolist())
    return not formatter.get_offset()


def set_apart(text: str) -> str:
    r"""Return a text with curly apostrophes, slanted symbols, and a wider space before a unit after a formula.

    A power of a letter with an accent stands as low as that of one without, and a bracket does not touch an x.

    >>> set_apart("Newmark's velocity $U$ (mm/s)")
    'Newmark’s velocity $U\\,$ (mm/s)'
    >>> set_apart("at ν = 0.3, f = 1.5 and R₁")
    'at $ν$ = 0.3, $f$ = 1.5 and $R$₁'
    >>> set_apart(r"$\dot{x}^-$, $\dot{x}(0)$")
    '$\\dot{x}{}^-$, $\\dot{x}\\hspace{0.1}(0)$'
    """
    shown = re.sub(r"(?<=\w)'", "’", text)
    if "$" not in shown:
        shown = SYMBOLS.sub(r"$\g<0>$", shown)
    shown = re.sub(r"(\\[a-z]+\{\w\})\^", r"\1{}^", shown)
    shown = re.sub(r"(\\dot\{x\}|\$x)\(", r"\1\\hspace{0.1}(", shown)
    return re.sub(r"(?<!\\,)\$ \(", r"\\,$ (", shown)


def with_letters(text: str) -> str:
    """Return mathtext with the digits of indices and powers as letters.

    >>> with_letters("$R_1$ of $10^{-3}$")
    '$R₁$ of $10⁻³$'
    >>> with_letters("$x^-$")
    '$x⁻$'
    """
    lowered = re.sub(r"_(\d)|_\{(\d+)\}", lambda m: (m[1] or m[2]).translate(LOWERED), text)
    return re.sub(
        r"\^([\d−-])|\^\{([−-]?\d+)\}", lambda m: (m[1] or m[2]).translate(RAISED), lowered
    )


def save_as(figure: Figure, path: Path, fingerprint: str = "") -> None:
    """Write one file atomically, in the format of its suffix."""
    kind = path.suffix.removeprefix(".").lower()
    with atomic_file(path) as temporary:
        figure.savefig(
            temporary,
            format=kind,
            dpi=SETTINGS["savefig.dpi"],
            metadata=dict(METADATA.get(kind, {})),
        )
        if fingerprint:
            temporary.write_bytes(with_fingerprint(temporary.read_bytes(), fingerprint))
