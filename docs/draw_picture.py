"""Make the pictures of the documentation: what ``foldrs demo`` drew, and a garment folded twice."""

from __future__ import annotations

import tempfile
from pathlib import Path

import cv2

import foldrs
from foldrs.plot import save_picture
from foldrs.synth import SynthParameters, make_scene

WIDTH = 1280  # px: labels stay readable
QUALITY = 82  # of 100
SEED = 5  # of the garment folded twice


def main() -> None:
    """Draw both."""
    root = Path(__file__).resolve().parents[1]
    images = root / "docs/images"
    shrink(root / "demo/t-shirt.png", images / "demo.webp")
    scene = make_scene(foldrs.builtin_templates("t-shirt")[0], seed=SEED, parameters=SynthParameters(folds=2))
    result = foldrs.fit(scene.image, px_per_cm=4.0, folds="auto")
    with tempfile.TemporaryDirectory() as folder:
        drawn = Path(folder) / "twice.png"
        save_picture(result, scene.image, drawn)
        shrink(drawn, images / "twice.webp")


def shrink(drawn: Path, path: Path) -> None:
    """Write a picture smaller, as WebP."""
    picture = cv2.imread(str(drawn))
    height = round(picture.shape[0] * WIDTH / picture.shape[1])
    small = cv2.resize(picture, (WIDTH, height), interpolation=cv2.INTER_AREA)
    cv2.imwrite(str(path), small, [cv2.IMWRITE_WEBP_QUALITY, QUALITY])


if __name__ == "__main__":
    main()
