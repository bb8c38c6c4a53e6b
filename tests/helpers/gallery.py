"""Pictures of `results/gallery`: the first picture of each default study, drawn from its datasets.

`python tests/helpers/gallery.py [RESULTS]`, after `snakemake --cores 2`.
"""

from __future__ import annotations

import sys
from io import BytesIO
from pathlib import Path

from PIL import Image

import vibropipe as vp

GALLERY = Path(__file__).parents[2] / "results/gallery"
HEROES = {
    "accuracy": "one_motion",
    "coexistence": "three_motions",
    "design": "shifted",
    "effects": "effects",
    "hard_cases": "hard_cases",
    "laws": "response",
    "paper": "free_response_0",
    "regimes": "regime_map",
}
WIDTH, COLOURS = 1280, 256


def reduced(picture: BytesIO) -> Image.Image:
    """Return a picture with `WIDTH` pixels a row and `COLOURS` colours."""
    image = Image.open(picture).convert("RGB")
    size = WIDTH, round(WIDTH * image.height / image.width)
    image = image.resize(size, Image.Resampling.LANCZOS)
    # Coverage keeps the colours of small marks, and means those of areas.
    return image.quantize(COLOURS, Image.Quantize.MAXCOVERAGE, kmeans=3, dither=Image.Dither.NONE)


def main(results: Path) -> None:
    for study, scene in HEROES.items():
        drawn = BytesIO()
        vp.plot(vp.open_study(results / study)[scene]).savefig(drawn, format="png", dpi=300)
        file = GALLERY / f"{study}.png"
        reduced(drawn).save(file, optimize=True)
        print(f"{file.name}: {file.stat().st_size / 1e3:.0f} kB")


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "results"))
