"""Make the pictures of docs/add_a_kind.md by running the commands of that page in a folder of its own."""

from __future__ import annotations

import os
import re
import shlex
import tempfile
from pathlib import Path

import cv2

from foldrs.cli import main as foldrs

WIDTH = 1280  # px: labels stay readable
QUALITY = 82  # of 100


def main() -> None:
    """Run the page, shrink its pictures and write them as WebP."""
    docs = Path(__file__).resolve().parent
    page = (docs / "add_a_kind.md").read_text(encoding="utf-8")
    with tempfile.TemporaryDirectory() as name:
        os.chdir(name)
        Path("waistcoats.json").write_text(
            re.findall(r"```json\n(.*?)```", page, re.DOTALL)[0], encoding="utf-8"
        )
        for command in re.findall(r"^    foldrs (.*)$", page, re.MULTILINE):
            foldrs(shlex.split(command), standalone_mode=False)
        for drawn, kept in (("waistcoat.png", "template"), ("results/waistcoat-01.png", "fit")):
            picture = cv2.imread(drawn)
            height = round(picture.shape[0] * WIDTH / picture.shape[1])
            small = cv2.resize(picture, (WIDTH, height), interpolation=cv2.INTER_AREA)
            path = docs / f"images/waistcoat-{kept}.webp"
            cv2.imwrite(str(path), small, [cv2.IMWRITE_WEBP_QUALITY, QUALITY])
        os.chdir(docs)  # a folder one stands in cannot be removed everywhere


if __name__ == "__main__":
    main()
