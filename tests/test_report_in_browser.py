"""The page of results used as a reader would, in a browser; nothing is loaded, nothing goes wrong."""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from foldrs.evaluation import failed, virtual_scenes
from foldrs.report import Report, write
from foldrs.template import builtin_templates
from test_plot import exact_result

sync_api = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
expect = sync_api.expect

BROWSERS = ("chromium", "chromium-browser", "google-chrome")
SECONDS = {"b-10.jpg": 3.0, "b-9.jpg": 1.0, "a.jpg": 2.0, "c.jpg": None}  # c.jpg could not be explained


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    """A headless browser of the system."""
    path = next((found for name in BROWSERS if (found := shutil.which(name))), None)
    if path is None:
        pytest.skip(f"none of {', '.join(BROWSERS)} is installed")
    unboxed = ["--no-sandbox"] if hasattr(os, "geteuid") and os.geteuid() == 0 else []
    with sync_api.sync_playwright() as playwright:
        started = playwright.chromium.launch(executable_path=path, args=unboxed)
        yield started
        started.close()


@pytest.fixture
def window(browser: Any) -> Iterator[Any]:
    """An empty window; at the end nothing may have gone wrong in it, and nothing been asked of a network."""
    page = browser.new_page(viewport={"width": 1300, "height": 900}, color_scheme="light")
    wrong: list[str] = []
    page.on("console", lambda message: wrong.append(f"{message.type}: {message.text}"))
    page.on("pageerror", lambda error: wrong.append(str(error)))
    page.on(
        "request", lambda request: request.url.startswith(("file:", "data:")) or wrong.append(request.url)
    )
    yield page
    page.close()
    assert wrong == []


@pytest.fixture(scope="module")
def fitted(tmp_path_factory: pytest.TempPathFactory) -> str:
    """A page of four images: pants, towel, pants, and one that could not be explained."""
    path = tmp_path_factory.mktemp("page") / "page.html"
    photo = np.full((480, 640, 3), (10, 200, 60), dtype=np.uint8)
    with Report(path) as page:
        for k, (name, seconds) in enumerate(SECONDS.items()):
            if seconds is None:
                page.add(None, photo, name=name, error="no garment")
            else:
                result = exact_result("towel" if k == 1 else "pants")
                page.add(replace(result, image=name, seconds=seconds), photo)
    return path.as_uri()


@pytest.fixture(scope="module")
def measured(tmp_path_factory: pytest.TempPathFactory) -> str:
    """A page of three scenes of known truth: right, wrong, right."""
    path = tmp_path_factory.mktemp("page") / "page.html"
    with Report(path) as page:
        for k, (scene, template) in enumerate(virtual_scenes(builtin_templates("towel"), 3, seed=0)):
            row = replace(
                failed(scene, ""), type_right=True, right=k != 1, axis_error=(0.05, 0.3, 0.01)[k], seconds=1.0
            )
            page.add(exact_result(template.garment_type), scene=scene, measures=row, name=f"scene-{k}")
    return path.as_uri()


def names(page: Any) -> list[str]:
    """Names of the images shown, in order; of the document, since a card moved is only painted in time."""
    return list(page.locator(".card:not([hidden]) h3").all_text_contents())


def card(page: Any, name: str) -> Any:
    return page.locator(".card").filter(has=page.get_by_role("heading", name=name, exact=True))


def test_layers_are_switched_by_mouse_and_keyboard(window: Any, fitted: str) -> None:
    window.goto(fitted)
    for label, layer in (
        ("photograph", "photo"),
        ("outline seen", "outline"),
        ("unfolded garment", "unfolded"),
        ("crease", "crease"),
        ("landmarks", "landmarks"),
        ("grasp pair", "grasp"),
    ):
        shown = card(window, "a.jpg").locator(f".layer-{layer}").first
        expect(shown).to_be_visible()
        window.get_by_role("checkbox", name=label).uncheck()
        expect(shown).to_be_hidden()
        window.get_by_role("checkbox", name=label).focus()
        window.keyboard.press("Space")
        expect(shown).to_be_visible()
    flap = card(window, "a.jpg").locator(".layer-flap").first
    expect(flap).to_be_hidden()
    window.get_by_role("checkbox", name="flap").check()
    expect(flap).to_be_visible()


def test_images_are_sorted_and_what_does_not_apply_comes_last(window: Any, fitted: str) -> None:
    window.goto(fitted)
    assert names(window) == list(SECONDS)
    window.get_by_role("combobox", name="Sort by", exact=True).select_option("seconds")
    assert names(window) == ["b-9.jpg", "a.jpg", "b-10.jpg", "c.jpg"]
    window.get_by_role("button", name="largest first").click()
    assert names(window) == ["b-10.jpg", "a.jpg", "b-9.jpg", "c.jpg"]
    window.get_by_role("combobox", name="Sort by", exact=True).select_option("")
    assert names(window) == list(SECONDS)


def test_the_table_sorts_itself_and_the_images(window: Any, fitted: str) -> None:
    window.goto(fitted)
    window.get_by_text("All images as a table").click()
    heading = window.locator("#rows th[data-column=name]")
    for direction, order in (
        ("ascending", ["a.jpg", "b-9.jpg", "b-10.jpg", "c.jpg"]),
        ("descending", ["c.jpg", "b-10.jpg", "b-9.jpg", "a.jpg"]),
    ):
        heading.get_by_role("button").press("Enter")
        expect(heading).to_have_attribute("aria-sort", direction)
        assert window.locator("#rows tbody th").all_text_contents() == order
        assert names(window) == order
    window.get_by_role("link", name="b-9.jpg").click()
    expect(card(window, "b-9.jpg")).to_be_in_viewport()


def test_images_are_found_by_name_kind_and_verdict(window: Any, fitted: str) -> None:
    window.goto(fitted)
    told = window.locator("#shown")
    expect(told).to_have_text("4 of 4 shown")
    window.get_by_label("Find").fill("B-")
    assert names(window) == ["b-10.jpg", "b-9.jpg"]
    expect(told).to_have_text("2 of 4 shown")
    window.get_by_role("combobox", name="Kind", exact=True).select_option("towel")
    assert names(window) == ["b-9.jpg"]
    window.get_by_role("combobox", name="Verdict", exact=True).select_option("failed")
    assert names(window) == []
    expect(window.get_by_text("No image is like that.")).to_be_visible()
    window.get_by_label("Find").fill("")
    window.get_by_role("combobox", name="Kind", exact=True).select_option("")
    assert names(window) == ["c.jpg"]
    expect(card(window, "c.jpg")).to_contain_text("no garment")


def test_an_explanation_is_chosen_for_its_image_alone(window: Any, fitted: str) -> None:
    window.goto(fitted)
    chosen, other = card(window, "a.jpg"), card(window, "b-9.jpg")
    for one in (chosen, other):
        expect(one.locator(".picture [data-rank='0']").first).to_be_visible()
        expect(one.locator(".picture [data-rank='1']").first).to_be_hidden()
    chosen.get_by_role("radio").first.focus()
    window.keyboard.press("ArrowDown")
    expect(chosen.get_by_role("radio").nth(1)).to_be_checked()
    expect(chosen.locator(".picture [data-rank='1']").first).to_be_visible()
    expect(chosen.locator("svg.explanation[data-rank='1']")).to_be_visible()
    expect(chosen.locator(".picture [data-rank='0']").first).to_be_hidden()
    expect(chosen.locator(".layer-landmarks")).to_be_hidden()
    expect(chosen.locator(".layer-outline")).to_be_visible()
    expect(chosen.get_by_text("explanation 1 alone")).to_be_visible()
    expect(other.locator(".picture [data-rank='0']").first).to_be_visible()


def test_truth_tables_and_right_or_wrong(window: Any, measured: str) -> None:
    window.goto(measured)
    expect(window.get_by_role("table", name="Table 1: fold axis localisation")).to_be_visible()
    expect(window.get_by_role("table", name="Table 2: landmark point error distance")).to_be_visible()
    truth = card(window, "scene-0").locator(".layer-truth")
    expect(truth).to_be_visible()
    window.get_by_role("checkbox", name="truth").uncheck()
    expect(truth).to_be_hidden()
    window.get_by_role("combobox", name="Sort by", exact=True).select_option("dA")
    assert names(window) == ["scene-2", "scene-0", "scene-1"]
    window.get_by_role("combobox", name="Verdict", exact=True).select_option("wrong")
    assert names(window) == ["scene-1"]


def test_the_photograph_is_decoded_and_fills_its_place(window: Any, fitted: str) -> None:
    window.goto(fitted)
    photo = card(window, "b-10.jpg").locator("img")
    photo.scroll_into_view_if_needed()
    window.wait_for_function("image => image.complete && image.naturalWidth > 0", arg=photo.element_handle())


@pytest.mark.parametrize("look", ["light", "dark"])
def test_words_stand_out_from_their_ground(window: Any, fitted: str, look: str) -> None:
    """Contrast of at least 4.5, WCAG's level AA."""
    window.goto(fitted)
    window.get_by_role("combobox", name="Look", exact=True).select_option(look)
    contrasts = window.evaluate(
        """() => {
          const probe = document.body.appendChild(document.createElement("i"));
          const light = (name) => {
            probe.style.color = `var(--${name})`;
            const linear = getComputedStyle(probe).color.match(/[\\d.]+/g).slice(0, 3).map((part) => {
              const share = part / 255;
              return share <= 0.04045 ? share / 12.92 : ((share + 0.055) / 1.055) ** 2.4;
            });
            return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2];
          };
          const words = ["ink", "quiet", "accent", "good", "bad"], grounds = ["page", "raised"];
          return words.flatMap((word) => grounds.map((ground) => {
            const [low, high] = [light(word), light(ground)].sort((a, b) => a - b);
            return [word, ground, (high + 0.05) / (low + 0.05)];
          }));
        }"""
    )
    assert len(contrasts) == 10
    assert all(ratio >= 4.5 for _, _, ratio in contrasts), contrasts
    ground = window.evaluate("getComputedStyle(document.body).backgroundColor")
    channels = [int(part) for part in ground.strip("rgb()").split(",")]
    assert (sum(channels) > 384) == (look == "light")


def test_every_control_has_a_name_and_the_page_fits_a_telephone(window: Any, measured: str) -> None:
    window.set_viewport_size({"width": 360, "height": 700})
    window.goto(measured)
    nameless = window.evaluate(
        """() => [...document.querySelectorAll("input, select, button")].filter((control) =>
          !control.ariaLabel && !control.textContent.trim() &&
          ![...(control.labels ?? [])].some((label) => label.textContent.trim())).length"""
    )
    assert nameless == 0
    assert window.evaluate("document.documentElement.scrollWidth <= window.innerWidth")


def test_an_empty_page_opens(window: Any, tmp_path: Path) -> None:
    write([], tmp_path / "page.html")
    window.goto((tmp_path / "page.html").as_uri())
    expect(window.locator("#shown")).to_have_text("0 of 0 shown")
