"""Draws answer.png, the picture in README.md, from the figures of the paper's collision.

python3 -m uv run retrodict reconstruct examples/brach-1977/scene.toml
python3 -m uv run python docs/pictures/answer.py out/brach-1977
"""

import sys
from pathlib import Path

from PIL import Image

HEIGHT, COLOURS = 640, 64


def main(result: Path) -> None:
    """Put the scene and the posterior side by side, few colours, so that the file is small."""
    parts = [Image.open(result / "figures" / f"{name}.png") for name in ("scene", "posterior")]
    parts = [part.convert("RGB") for part in parts]
    parts = [part.resize((round(part.width * HEIGHT / part.height), HEIGHT)) for part in parts]
    whole = Image.new("RGB", (sum(part.width for part in parts), HEIGHT), "white")
    left = 0
    for part in parts:
        whole.paste(part, (left, 0))
        left += part.width
    whole.quantize(COLOURS).save(Path(__file__).with_name("answer.png"), optimize=True)


if __name__ == "__main__":
    main(Path(sys.argv[1]))
