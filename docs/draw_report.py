"""Make the picture of the page of results, docs/images/report.webp: drawn scenes evaluated, in a browser."""

from __future__ import annotations

import os
import shutil
import tempfile
from pathlib import Path

import cv2
import numpy as np
from click.testing import CliRunner
from playwright.sync_api import sync_playwright

from foldrs.cli import main as foldrs

WIDTH, HEIGHT = 1440, 1000  # px
QUALITY = 80  # of 100
SCENES = ("--count", "12", "--seed", "3")
SCROLL = """
    document.querySelector(".cards").scrollIntoView();
    scrollBy(0, -document.querySelector(".bar").offsetHeight - 14);
"""


def run(*arguments: str) -> None:
    """Run a command of foldrs."""
    done = CliRunner().invoke(foldrs, arguments)
    if done.exit_code != 0:
        raise SystemExit(done.output)


def main() -> None:
    """Draw scenes, evaluate them, open the page and take its picture."""
    target = Path(__file__).resolve().parent / "images/report.webp"
    browser_path = shutil.which("chromium") or shutil.which("google-chrome")
    unboxed = ["--no-sandbox"] if hasattr(os, "geteuid") and os.geteuid() == 0 else []
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as playwright:
        scenes, page = f"{folder}/scenes", Path(folder) / "page.html"
        run("synth", "--out", scenes, *SCENES)
        run("evaluate", scenes, "--protocol", "open", "--report", str(page))
        browser = playwright.chromium.launch(executable_path=browser_path, args=unboxed)
        window = browser.new_page(viewport={"width": WIDTH, "height": HEIGHT}, color_scheme="light")
        window.goto(page.as_uri())
        window.evaluate(SCROLL)
        window.wait_for_function("[...document.images].slice(0, 6).every((image) => image.complete)")
        png = np.frombuffer(window.screenshot(), np.uint8)
        browser.close()
    picture = cv2.imdecode(png, cv2.IMREAD_COLOR)
    cv2.imwrite(str(target), picture, [cv2.IMWRITE_WEBP_QUALITY, QUALITY])


if __name__ == "__main__":
    main()
