"""Make the picture of the README, docs/images/demo.webp, of what ``foldrs demo`` drew into demo/."""

from __future__ import annotations

from pathlib import Path

import cv2

WIDTH = 1280  # px: labels stay readable
QUALITY = 82  # of 100


def main() -> None:
    """Shrink the picture and write it as WebP."""
    root = Path(__file__).resolve().parents[1]
    picture = cv2.imread(str(root / "demo/t-shirt.png"))
    height = round(picture.shape[0] * WIDTH / picture.shape[1])
    small = cv2.resize(picture, (WIDTH, height), interpolation=cv2.INTER_AREA)
    cv2.imwrite(str(root / "docs/images/demo.webp"), small, [cv2.IMWRITE_WEBP_QUALITY, QUALITY])


if __name__ == "__main__":
    main()
