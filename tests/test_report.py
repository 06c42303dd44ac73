"""The page of results: what it holds, that it is one whole file, and that it loads nothing."""

from __future__ import annotations

import base64
import gc
import io
import json
import re
import tempfile
import time
import warnings
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path

import cv2
import numpy as np
import pytest
from click.testing import CliRunner
from numpy.typing import NDArray

import foldrs
from foldrs import _plot_panels as panels
from foldrs.cli import main
from foldrs.errors import ImageNotFoundError, ParameterError
from foldrs.report import Report, write
from foldrs.report.drawing import draw
from foldrs.report.frame import Frame, cut_photo
from foldrs.report.layers import LAYERS
from foldrs.synth import make_scene
from foldrs.template import builtin_templates
from test_plot import exact_result

Photo = NDArray[np.uint8]

VOID = {"meta", "link", "img", "input", "br"}


class Page(HTMLParser):
    """A page read: its elements by tag, what they refer to, and whether all were closed."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.elements: list[tuple[str, dict[str, str | None]]] = []
        self.open: list[str] = []
        self.feed(text)
        self.close()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.elements.append((tag, dict(attrs)))
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.elements.append((tag, dict(attrs)))

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def having(self, tag: str, attribute: str = "class", word: str = "") -> list[dict[str, str | None]]:
        return [
            attrs for name, attrs in self.elements if name == tag and word in (attrs.get(attribute) or "")
        ]


class SlowToRead(io.BytesIO):
    """A file that lets other threads come between finding the place and reading or writing there."""

    def seek(self, offset: int, whence: int = io.SEEK_SET) -> int:
        place = super().seek(offset, whence)
        time.sleep(0.002)
        return place


def read(path: Path) -> Page:
    return Page(path.read_text(encoding="utf-8"))


@pytest.fixture(scope="module")
def photo() -> Photo:
    return np.random.default_rng(0).integers(0, 255, (480, 640, 3), dtype=np.uint8)


def test_a_page_holds_every_image_with_all_layers(tmp_path: Path, photo: Photo) -> None:
    results = [exact_result("pants"), exact_result("towel")]
    write(results, tmp_path / "page.html", images=[photo, None], title="Two <b>garments</b>")
    page = read(tmp_path / "page.html")
    assert page.open == []
    assert "Two &lt;b&gt;garments&lt;/b&gt;" in (tmp_path / "page.html").read_text()
    assert len(page.having("article")) == 2
    assert len(page.having("img")) == 1
    switches = [box["value"] for box in page.having("input", "name", "layer")]
    assert switches == [layer.name for layer in LAYERS if layer.name != "truth"]
    for name in ("outline", "kept", "flap", "unfolded", "crease", "landmarks", "grasp"):
        drawn = [attrs for _, attrs in page.elements if f"layer-{name}" in (attrs.get("class") or "").split()]
        assert len(drawn) >= 2, name
    radios = page.having("input", "type", "radio")
    assert len(radios) == sum(len(result.alternatives) for result in results)


def test_a_page_is_drawn_in_the_colours_of_the_plots(tmp_path: Path) -> None:
    write([exact_result()], tmp_path / "page.html")
    text = (tmp_path / "page.html").read_text()
    for colour in (panels.SEEN, panels.CREASE, panels.UNFOLDED, panels.GRASP):
        assert colour in text


def test_a_page_refers_to_nothing_outside_it(tmp_path: Path, photo: Photo) -> None:
    write([exact_result()], tmp_path / "page.html", images=[photo])
    text = (tmp_path / "page.html").read_text()
    assert not re.findall(r"(?:https?:)?//[a-z]+\.[a-z]", text)
    for tag, attrs in Page(text).elements:
        for attribute in ("src", "href"):
            target = attrs.get(attribute) or "#"
            assert target.startswith(("#", "data:")), (tag, target)
    assert "default-src 'none'" in text


def test_names_and_errors_cannot_break_the_page(tmp_path: Path) -> None:
    nasty = "</script><img src=x onerror=alert(1)> & 'more\""
    with Report(tmp_path / "page.html") as page:
        page.add(None, None, name=nasty, error=nasty)
    found = read(tmp_path / "page.html")
    assert found.open == []
    assert not found.having("img")
    entries = re.search(r'id="entries">(.*?)</script>', (tmp_path / "page.html").read_text(), re.DOTALL)
    assert entries is not None
    assert json.loads(entries.group(1))["0"]["name"] == nasty


def test_the_order_does_not_depend_on_which_image_comes_first(tmp_path: Path, photo: Photo) -> None:
    results = [replace(exact_result(), image=f"photo-{k}.jpg") for k in range(6)]
    write(results, tmp_path / "in-order.html", images=[photo] * 6)
    with Report(tmp_path / "any-order.html") as page, ThreadPoolExecutor(3) as pool:
        for k in reversed(range(6)):
            pool.submit(page.add, results[k], photo, position=k).result()
    assert (tmp_path / "in-order.html").read_bytes() == (tmp_path / "any-order.html").read_bytes()


def test_a_page_is_written_whole_or_not_at_all(tmp_path: Path) -> None:
    with pytest.raises(ImageNotFoundError):
        write([exact_result()] * 2, tmp_path / "page.html", images=[None, tmp_path / "nowhere.jpg"])
    two = [exact_result()] * 2
    for results, images, words in (
        (two, [None], "2 results and 1 images"),
        (two, [None] * 3, "2 results and 3 images"),
        (iter(two), [None], "more than 1 results and 1 images"),
        (two, iter([None] * 3), "2 results and more than 2 images"),
    ):
        with pytest.raises(ParameterError, match=words):
            write(results, tmp_path / "page.html", images=images)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("with_images", [False, True])
def test_a_batch_with_failures_is_shown_whole(tmp_path: Path, photo: Photo, with_images: bool) -> None:
    """As ``foldrs fit --report`` does it; the photograph of a failure is shown where it can be read."""
    (tmp_path / "bad.jpg").write_text("no image")
    cv2.imwrite(str(tmp_path / "table.png"), np.full_like(photo, 128))
    paths = [tmp_path / name for name in ("table.png", "bad.jpg", "nowhere.jpg")]
    answers = [*foldrs.fit_many(paths), RuntimeError("a defect"), exact_result()]
    images = [*paths, photo, photo] if with_images else None
    write(answers, tmp_path / "page.html", images=images)
    page = read(tmp_path / "page.html")
    verdicts = [card["data-verdict"] for card in page.having("article")]
    assert verdicts == ["failed"] * 4 + ["fold accepted"]
    assert len(page.having("img")) == (3 if with_images else 0)
    text = (tmp_path / "page.html").read_text()
    for words in ("table.png", str(answers[0]), "cannot be read as an image", "There is no file"):
        assert words in text
    assert "RuntimeError: a defect" in text


def test_a_report_that_is_never_entered_leaves_nothing_open(tmp_path: Path) -> None:
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        Report(tmp_path / "page.html")
        gc.collect()
    assert [str(one.message) for one in told if one.category is ResourceWarning] == []


def test_images_may_be_added_while_the_page_is_written(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Every part is read where it is, though other threads write to the same file in between."""
    monkeypatch.setattr(tempfile, "TemporaryFile", SlowToRead)
    path, names = tmp_path / "page.html", [f"photo-{k}.jpg" for k in range(40)]

    def add(some: list[str]) -> None:
        for name in some:
            page.add(None, name=name, error="no garment")

    with Report(path) as page, ThreadPoolExecutor(1) as pool:
        add(names[:20])
        adding = pool.submit(add, names[20:])
        page.write()
        early = path.read_text()
        adding.result()
    for text, complete in ((early, names[:20]), (path.read_text(), names)):
        assert Page(text).open == []
        assert all(f'<h3 id="name-{k}">{name}</h3>' in text for k, name in enumerate(complete))


def test_a_page_may_have_no_images(tmp_path: Path) -> None:
    write([], tmp_path / "page.html")
    assert read(tmp_path / "page.html").open == []


def test_a_result_without_grasp_pair_landmarks_or_fold_can_be_drawn(photo: Photo, tmp_path: Path) -> None:
    result = exact_result()
    off = replace(result.fold, axis_image=result.fold.axis_image + 1e4)
    bare = replace(
        result,
        grasp_pairs=(),
        landmarks={},
        folds=(off,),
        accepted=False,
        alternatives=(),
        matching_cost=np.inf,
    )
    drawing = draw(bare, photo, None)
    assert drawing is not None
    assert drawing.names == drawing.grasp == drawing.moves == ()
    assert drawing.explanations[0].kept == ""
    assert draw(None, None, None) is None
    write([bare], tmp_path / "page.html")
    assert len(read(tmp_path / "page.html").having("article")) == 1


def test_the_photograph_lies_under_what_is_drawn_on_it(photo: Photo) -> None:
    """A white pixel of the photograph is white in the page where the frame draws its coordinates."""
    image = np.zeros((400, 500, 3), np.uint8)
    image[250:254, 130:134] = 255  # its middle is (131.5, 251.5)
    frame = Frame.around(np.array([[100.0, 220.0], [160.0, 280.0]]), 400, 300, 0.1)
    cut = cut_photo(image, frame, 95)
    assert cut is not None
    coded = np.frombuffer(base64.b64decode(cut.uri.split(",")[1]), np.uint8)
    seen = cv2.imdecode(coded, cv2.IMREAD_GRAYSCALE)
    y, x = (axis.mean() for axis in np.nonzero(seen > 128))
    share = (np.array([x, y]) + 0.5) / seen.shape[::-1]
    drawn = np.array([cut.left, cut.top]) + share * [cut.width, cut.height]
    expected = frame.view(np.array([131.5, 251.5])) / [frame.width, frame.height] * 100
    np.testing.assert_allclose(drawn, expected, atol=0.2)


@pytest.mark.parametrize("size", [(3000, 4000), (480, 640)])
def test_the_embedded_photograph_is_limited(size: tuple[int, int]) -> None:
    image = np.random.default_rng(1).integers(0, 255, (*size, 3), dtype=np.uint8)
    result = exact_result()
    whole = np.array([[0.0, 0.0], size[::-1]])
    drawing = draw(replace(result, outline_image=np.vstack([result.outline_image, whole])), image, None)
    assert drawing is not None
    assert drawing.photo is not None
    coded = np.frombuffer(base64.b64decode(drawing.photo.uri.split(",")[1]), np.uint8)
    assert max(cv2.imdecode(coded, cv2.IMREAD_COLOR).shape) <= 800


def test_a_photograph_beside_the_frame_is_left_out(photo: Photo) -> None:
    frame = Frame.around(np.array([[-900.0, -900.0], [-800.0, -800.0]]), 400, 300, 0.1)
    assert cut_photo(photo, frame, 80) is None


def test_fit_writes_a_page_with_failures_too(tmp_path: Path) -> None:
    make_scene(builtin_templates("towel")[0], seed=0).write(tmp_path, "towel")
    (tmp_path / "bad.jpg").write_text("no image")
    page = tmp_path / "new" / "page.html"
    arguments = ["fit", tmp_path / "towel.jpg", tmp_path / "bad.jpg", "--type", "towel", "--report", page]
    done = CliRunner().invoke(main, [str(argument) for argument in arguments])
    assert done.exit_code == 1
    verdicts = [card["data-verdict"] for card in read(page).having("article")]
    assert verdicts[1] == "failed"
    assert verdicts[0] in ("fold accepted", "no fold found better")
    assert "cannot be read as an image" in page.read_text()
    assert sorted(path.name for path in page.parent.iterdir()) == ["page.html"]


def test_evaluate_writes_a_page_with_tables_and_truth(tmp_path: Path) -> None:
    page = tmp_path / "page.html"
    arguments = ["evaluate", "--protocol", "synthetic", "--count", "2", "--report", str(page)]
    done = CliRunner().invoke(main, arguments)
    assert done.exit_code == 0, done.output
    found = read(page)
    assert len(found.having("article")) == 2
    assert "truth" in [box["value"] for box in found.having("input", "name", "layer")]
    text = page.read_text()
    assert "Table 1: fold axis localisation" in text
    assert "Table 2: landmark point error distance" in text
    assert len(re.findall(r'<th scope="row">Overall</th>', text)) == 3
    assert {card["data-verdict"] for card in found.having("article")} <= {"right", "wrong", "failed"}


@pytest.mark.parametrize("command", [["fit", "photo.jpg"], ["evaluate", "scenes"]])
def test_a_report_that_could_overwrite_a_photograph_is_refused(command: list[str], tmp_path: Path) -> None:
    done = CliRunner().invoke(main, [*command, "--report", str(tmp_path / "photo.jpg")])
    assert done.exit_code == 2
    assert "*.html" in done.stderr
