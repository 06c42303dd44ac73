"""The picture of a result: what it shows, that it is a whole PNG file, threads, and what bad input raises."""

from __future__ import annotations

import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from matplotlib.text import Annotation
from numpy.typing import NDArray

import foldrs
from foldrs import _core
from foldrs import _plot_panels as panels
from foldrs._plot_labels import place_labels
from foldrs.errors import ImageNotFoundError, NotAnImageError, ParameterError
from foldrs.matching_details import matching_details
from foldrs.plot import MatchingDetails, draw_result, save_picture
from foldrs.result import (
    Alternative,
    FitResult,
    FittedTemplate,
    Fold,
    GraspPair,
    LandmarkInImage,
    UnfoldingAction,
)
from foldrs.template import builtin_templates

Points = NDArray[np.float64]

TO_IMAGE = np.array([[3.0, 1.0, 250.0], [-1.0, 3.0, 120.0]])  # px a cm, with a turn


def to_image(points: Points) -> Points:
    return points @ TO_IMAGE[:, :2].T + TO_IMAGE[:, 2]


def exact_result(kind: str = "pants") -> FitResult:
    """A built-in template folded across its middle: the outline seen is exactly what the fold predicts."""
    given = builtin_templates(kind)[0]
    low, high = given.outline.min(axis=0), given.outline.max(axis=0)
    y = 0.45 * low[1] + 0.55 * high[1]
    axis = np.array([[high[0] + 1, y - 3], [low[0] - 1, y + 3]])  # what lies below is the flap
    crease, unfolded = to_image(axis), to_image(given.outline)
    layers = _core.fold_layers(unfolded, crease)
    landmarks = {}
    for i, (name, point) in enumerate(given.landmarks.items()):
        place = to_image(point[None])
        on_flap = point[1] > y
        landmarks[name] = LandmarkInImage((_core.reflect(place, crease) if on_flap else place)[0], i % 2 == 0)
    pairs = [
        GraspPair((a, b), np.array([landmarks[a].image, landmarks[b].image]))
        for a, b in given.grasp_pairs[:2]
    ]
    template = FittedTemplate(given.outline, given.landmarks, axis)
    fold = Fold(crease, axis)
    return FitResult(
        garment_type=kind,
        accepted=True,
        matching_cost=0.173,
        original_matching_cost=0.25,
        outline_image=layers.outline,
        folds=(fold,),
        original_template=template,
        template=template,
        unfolded_outline_image=unfolded,
        landmarks=landmarks,
        grasp_pairs=tuple(pairs),
        unfolding=UnfoldingAction(two_arms=None, one_arm=None),
        unfolding_plan=(UnfoldingAction(two_arms=None, one_arm=None),),
        alternatives=tuple(Alternative(kind, p, (fold,), template, unfolded) for p in (0.7, 0.2, 0.004)),
        image="pants-on-table.jpg",
        seconds=0.4,
    )


@pytest.fixture(scope="module")
def result() -> FitResult:
    return exact_result()


@pytest.fixture(scope="module")
def figure(result: FitResult) -> Figure:
    """The picture of `result`, to look at only."""
    return draw_result(result, None)


@pytest.fixture(scope="module")
def photo() -> NDArray[np.uint8]:
    return np.full((480, 640, 3), (10, 200, 60), dtype=np.uint8)


def texts(figure: Figure) -> str:
    words = [text.get_text() for text in figure.texts]
    for ax in figure.axes:
        words += [text.get_text() for text in ax.texts] + [ax.get_title(loc="left")]
    return "\n".join(words)


def evidence(figure: Figure) -> Axes:
    return figure.axes[0]


def arrows(figure: Figure) -> list[Annotation]:
    return [text for text in evidence(figure).texts if isinstance(text, Annotation)]


def read(path: Path) -> NDArray[np.uint8]:
    picture = cv2.imread(str(path))
    assert picture is not None
    return np.asarray(picture[:, :, ::-1], dtype=np.uint8)


def count(picture: NDArray[np.uint8], colour: str | tuple[int, int, int]) -> int:
    wanted = np.rint(np.array(to_rgb(colour)) * 255) if isinstance(colour, str) else np.array(colour)
    return int((np.abs(picture.astype(int) - wanted).max(axis=2) <= 2).sum())


# -- what is written --


def test_picture_is_a_png_with_photo_crease_and_outline(
    result: FitResult, photo: NDArray[np.uint8], tmp_path: Path
) -> None:
    path = tmp_path / "picture.png"
    save_picture(result, photo, path)
    assert path.read_bytes().startswith(b"\x89PNG\r\n\x1a\n")
    picture = read(path)
    assert picture.shape == (1000, 1600, 3)
    assert count(picture, (10, 200, 60)) > 100_000
    for colour in (panels.CREASE, panels.SEEN, panels.UNFOLDED, panels.GRASP):
        assert count(picture, colour) > 500
    assert [file.name for file in tmp_path.iterdir()] == ["picture.png"]


def test_picture_without_image_has_a_plain_background(result: FitResult, tmp_path: Path) -> None:
    save_picture(result, None, tmp_path / "plain.png")
    picture = read(tmp_path / "plain.png")
    assert count(picture, "0.93") > 500_000
    assert count(picture, panels.CREASE) > 500


def test_image_file_gives_the_same_picture_as_its_pixels(
    result: FitResult, photo: NDArray[np.uint8], tmp_path: Path
) -> None:
    cv2.imwrite(str(tmp_path / "photo.png"), photo[:, :, ::-1])
    save_picture(result, tmp_path / "photo.png", tmp_path / "a.png")
    save_picture(result, photo, tmp_path / "b.png")
    assert (tmp_path / "a.png").read_bytes() == (tmp_path / "b.png").read_bytes()


@pytest.mark.parametrize(
    "image",
    [
        [[0, 0], [1, 1]],
        np.zeros((10, 10, 3), np.uint8),
        np.zeros((240, 320), np.uint8),
        np.zeros((480, 300), np.uint8),
        exact_result().outline_image.astype(np.uint16),
    ],
)
def test_an_image_that_does_not_hold_the_outline_is_refused(
    result: FitResult, tmp_path: Path, image: object
) -> None:
    with pytest.raises(ParameterError, match="pass the photograph that it was found in"):
        save_picture(result, image, tmp_path / "a.png")  # type: ignore[arg-type]
    assert list(tmp_path.iterdir()) == []


def test_threads_write_the_same_pictures_as_one_alone(photo: NDArray[np.uint8], tmp_path: Path) -> None:
    results = [exact_result(kind) for kind in ("towel", "t-shirt")]
    for i, result in enumerate(results):
        save_picture(result, photo, tmp_path / f"alone-{i}.png")
    with ThreadPoolExecutor(2) as pool:
        paths = [tmp_path / f"together-{i}.png" for i in range(len(results))]
        list(pool.map(save_picture, results, [photo] * len(results), paths))
    for i in range(len(results)):
        assert (tmp_path / f"together-{i}.png").read_bytes() == (tmp_path / f"alone-{i}.png").read_bytes()


def test_large_photograph_is_drawn_where_it_belongs(result: FitResult, tmp_path: Path) -> None:
    """A photograph reduced for drawing still lies under the outline: the garment's pixels are within it."""
    tall = 4000
    image = np.full((tall, tall, 3), 255, dtype=np.uint8)
    enlarged = replace(
        result,
        outline_image=result.outline_image * 6,
        unfolded_outline_image=result.unfolded_outline_image * 6,
        folds=(Fold(result.fold.axis_image * 6, result.fold.axis_template),),
        landmarks={},
        grasp_pairs=(),
    )
    cv2.fillPoly(image, [np.rint(enlarged.outline_image).astype(np.int32)], (200, 0, 200))
    figure = draw_result(enlarged, image)
    ax = evidence(figure)
    shown = np.asarray(ax.images[0].get_array())
    assert max(shown.shape) <= 1200
    left, right, bottom, top = ax.images[0].get_extent()
    pixels = np.argwhere((shown == (200, 0, 200)).all(axis=2))[:, ::-1]
    scale = np.array([(right - left) / shown.shape[1], (bottom - top) / shown.shape[0]])
    garment = np.array([left, top]) + (pixels + 0.5) * scale
    reach = np.array([enlarged.outline_image.min(axis=0), enlarged.outline_image.max(axis=0)])
    np.testing.assert_allclose([garment.min(axis=0), garment.max(axis=0)], reach, atol=12)


# -- what is shown --


def test_evidence_panel_holds_everything_it_speaks_of(result: FitResult, figure: Figure) -> None:
    ax = evidence(figure)
    marks = np.array([mark.image for mark in result.landmarks.values()])
    for points in (result.outline_image, result.unfolded_outline_image, result.fold.axis_image, marks):
        (x0, x1), (y1, y0) = ax.get_xlim(), ax.get_ylim()
        assert (points > [x0, y0]).all()
        assert (points < [x1, y1]).all()
    creases = [line for line in ax.lines if line.get_color() == panels.CREASE]
    np.testing.assert_allclose(creases[0].get_xydata(), result.fold.axis_image)


def test_pixels_are_square_in_every_panel(figure: Figure) -> None:
    for ax in figure.axes:
        if ax.axison:
            across, down = np.ptp(ax.get_xlim()) / ax.bbox.width, np.ptp(ax.get_ylim()) / ax.bbox.height
            assert across == pytest.approx(down)
            assert ax.yaxis_inverted()


def test_landmarks_in_reach_are_filled_the_others_hollow(result: FitResult, figure: Figure) -> None:
    dots = [line for line in evidence(figure).lines if line.get_markersize() == 7]
    shown = {tuple(np.round(line.get_xydata()[0], 6)): line.get_markerfacecolor() for line in dots}
    wanted = {
        tuple(np.round(mark.image, 6)): "black" if mark.accessible else "white"
        for mark in result.landmarks.values()
    }
    assert shown == wanted


def test_grasp_points_on_the_flap_point_to_where_they_unfold(result: FitResult) -> None:
    template = builtin_templates("pants")[0]
    moved = [replace(result, grasp_pairs=(pair,)) for pair in result.grasp_pairs]
    waist, hems = (arrows(draw_result(one, None)) for one in moved)
    assert waist == []
    names = result.grasp_pairs[1].landmarks
    wanted = to_image(np.array([template.landmarks[name] for name in names]))
    np.testing.assert_allclose([arrow.xy for arrow in hems], wanted, atol=1e-6)


def test_exact_fold_agrees_with_the_outline(figure: Figure) -> None:
    assert "overlap 100%, mean distance 0.0 px" in texts(figure)


def test_alternatives_have_bars_as_long_as_they_are_probable(figure: Figure) -> None:
    bars = [ax.patches[-1].get_width() for ax in figure.axes if not ax.axison]
    assert bars == pytest.approx([0.7, 0.2, 0.004])
    words = texts(figure)
    assert "1  pants   70%" in words
    assert "3  pants   <1%" in words


def test_heading_tells_the_decision(result: FitResult, figure: Figure) -> None:
    words = texts(figure)
    for part in ("pants   70%", "fold accepted", "matching cost 0.173", "pants-on-table.jpg"):
        assert part in words
    refused = texts(draw_result(replace(result, accepted=False), None))
    assert "fold NOT accepted" in refused
    assert "fold accepted" not in refused


def test_fitted_template_is_drawn_over_the_one_given(result: FitResult, figure: Figure) -> None:
    fitted = replace(
        result.template, outline=result.template.outline * 1.05, axis=result.template.axis * 1.05
    )
    fitted_figure = draw_result(replace(result, template=fitted), None)
    outlines = [line.get_xydata()[:-1] for line in fitted_figure.axes[1].lines]
    for outline in (result.original_template.outline, fitted.outline):
        assert any(o.shape == outline.shape and np.allclose(o, outline) for o in outlines)
    assert "fitted template" in texts(fitted_figure)
    assert "matching cost 0.173 (as given 0.250)" in texts(fitted_figure)
    assert "template as given" in texts(figure)


def test_details_are_drawn(result: FitResult, figure: Figure) -> None:
    side, piece = result.fold.axis_image, result.outline_image[:8]
    details = MatchingDetails(sides=[side], matches=[(piece, result.template.outline[:4])])
    detailed = draw_result(result, None, details=details)
    assert len(evidence(detailed).lines) == len(evidence(figure).lines) + 4  # a side, its ticks, a piece
    assert any(np.array_equal(line.get_xydata(), piece) for line in evidence(detailed).lines)
    assert "pieces matched" in texts(detailed)


@pytest.mark.parametrize(
    "change",
    [
        {"grasp_pairs": ()},
        {"alternatives": ()},
        {"landmarks": {}, "grasp_pairs": ()},
        {"image": ""},
        {"unfolded_outline_image": np.array([[900.0, 900], [950, 900], [950, 950]])},  # the crease misses it
    ],
    ids=["no pair", "no alternatives", "no landmarks", "no name", "folds nothing"],
)
def test_incomplete_results_are_drawn(
    result: FitResult, photo: NDArray[np.uint8], tmp_path: Path, change: dict[str, object]
) -> None:
    save_picture(replace(result, **change), photo, tmp_path / "a.png")  # type: ignore[arg-type]
    assert count(read(tmp_path / "a.png"), panels.CREASE) > 500


def test_second_fold_is_laid_over_the_first(result: FitResult) -> None:
    """The outline of a garment folded twice agrees with its result, whose earlier crease is drawn too."""
    once = result.outline_image
    middle = once.mean(axis=0)
    across = np.array([[-1000.0, -300.0], [1000.0, 300.0]]) + middle
    second = Fold(across, result.fold.axis_template)
    twice = replace(
        result, outline_image=_core.fold_layers(once, across).outline, folds=(result.fold, second)
    )
    figure = draw_result(twice, None)
    assert "overlap 100%" in texts(figure)
    creases = [line.get_xydata() for line in evidence(figure).lines if line.get_color() == panels.CREASE]
    assert len(creases) == 2


def test_odd_names_are_written_as_they_are(result: FitResult, tmp_path: Path) -> None:
    """Dollar signs and backslashes are no formulas, and names too long for their place are cut."""
    mark = next(iter(result.landmarks.values()))
    odd = replace(result, garment_type=r"$\frac{", image="x" * 300 + ".jpg", landmarks={r"a$\b_left$": mark})
    odd = replace(odd, grasp_pairs=())
    figure = draw_result(odd, None)
    save_picture(odd, None, tmp_path / "a.png")
    words = texts(figure)
    assert r"$\frac{   70%" in words
    assert r"a$\b left$" in words
    assert "x" * 23 + "…" in words
    assert "x" * 24 not in words


def test_draws_into_a_given_figure(result: FitResult) -> None:
    figure = Figure(figsize=(8, 5))
    assert draw_result(result, None, figure) is figure
    assert len(figure.axes) > 3


def test_matplotlib_waits_for_the_first_picture_and_pyplot_stays_out(tmp_path: Path) -> None:
    code = (
        "import sys; import foldrs.plot; assert 'matplotlib' not in sys.modules\n"
        f"sys.path.insert(0, {str(Path(__file__).parent)!r}); from test_plot import exact_result\n"
        f"foldrs.plot.save_picture(exact_result(), None, {str(tmp_path / 'a.png')!r})\n"
        "assert 'matplotlib.pyplot' not in sys.modules"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


# -- bad input --


def test_missing_image_leaves_nothing_behind(result: FitResult, tmp_path: Path) -> None:
    with pytest.raises(ImageNotFoundError, match=r"missing\.jpg"):
        save_picture(result, tmp_path / "missing.jpg", tmp_path / "a.png")
    assert list(tmp_path.iterdir()) == []


def test_unreadable_image_leaves_an_earlier_picture_as_it_was(result: FitResult, tmp_path: Path) -> None:
    (tmp_path / "notes.jpg").write_text("no picture")
    (tmp_path / "a.png").write_bytes(b"earlier")
    with pytest.raises(NotAnImageError):
        save_picture(result, tmp_path / "notes.jpg", tmp_path / "a.png")
    with pytest.raises(NotAnImageError):
        save_picture(result, np.zeros((4, 4, 7)), tmp_path / "a.png")
    assert (tmp_path / "a.png").read_bytes() == b"earlier"


def test_picture_into_a_missing_folder_is_refused(result: FitResult, tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError):
        save_picture(result, None, tmp_path / "nowhere" / "a.png")


# -- names of points --


def boxes_share_area(a: Points, b: Points, size_a: Points, size_b: Points) -> bool:
    return bool((np.abs(a - b) < (size_a + size_b) / 2 - 1e-9).all())


def test_names_of_crowded_points_do_not_cover_one_another_or_the_points() -> None:
    anchors = np.array([[200.0, 200], [200, 200], [208, 203], [260, 210], [265, 190], [120, 300], [122, 304]])
    sizes = np.array([[70.0, 18]] * len(anchors))
    low, high = np.zeros(2), np.array([500.0, 400])
    centres = place_labels(anchors, sizes, np.empty((0, 2)), low, high)
    assert ((centres - sizes / 2 >= low) & (centres + sizes / 2 <= high)).all()
    for i in range(len(anchors)):
        assert (np.abs(anchors - centres[i]) >= sizes[i] / 2).any(axis=1).all()
        for j in range(i):
            assert not boxes_share_area(centres[i], centres[j], sizes[i], sizes[j])


def test_names_leave_a_line_uncovered_and_stay_within_the_panel() -> None:
    line = np.column_stack([np.linspace(0, 300, 100), np.full(100, 95.0)])
    anchors = np.array([[5.0, 100], [295, 90]])
    sizes = np.array([[60.0, 16]] * 2)
    centres = place_labels(anchors, sizes, line, np.zeros(2), np.array([300.0, 200]))
    for centre, size in zip(centres, sizes, strict=True):
        assert (np.abs(line - centre) > size / 2).any(axis=1).all()
        assert ((centre - size / 2 >= 0) & (centre + size / 2 <= [300, 200])).all()


def test_no_points_have_no_names() -> None:
    assert place_labels(
        np.empty((0, 2)), np.empty((0, 2)), np.empty((0, 2)), np.zeros(2), np.ones(2)
    ).shape == (0, 2)


def test_the_details_of_a_fit_are_pieces_of_both_outlines():
    """Pieces matched run along the seen outline and along the template as given."""
    template = builtin_templates("pants")[0]
    laid = to_image(template.outline)
    axis = np.array([[-40.0, 30.0], [40.0, 38.0]])
    seen = _core.fold_layers(laid, to_image(axis)).outline
    result = foldrs.fit(seen, garment_type="pants")
    details = matching_details(result)
    assert len(details.sides) > 3
    assert 1 <= len(details.matches) <= 3
    for on_seen, on_template in details.matches:
        assert len(on_seen) == len(on_template) >= 14
        assert _core.nearest_on_outline(result.outline_image, on_seen)[1].max() < 1e-6
        assert _core.nearest_on_outline(template.outline, on_template)[1].max() < 1e-6


def test_grasp_points_unfold_to_where_their_corner_of_the_garment_lies(result: FitResult) -> None:
    """Also where no one map lays the template into the image, as after a piecewise registration."""
    given, pair = result.template, result.grasp_pairs[1]
    corners = np.arange(len(given.outline))
    bent = result.unfolded_outline_image + 9.0 * np.column_stack([np.sin(3.0 * corners), np.cos(corners)])
    shown = arrows(draw_result(replace(result, grasp_pairs=(pair,), unfolded_outline_image=bent), None))
    wanted = [
        bent[np.abs(given.outline - given.landmarks[name]).sum(axis=1).argmin()] for name in pair.landmarks
    ]
    np.testing.assert_allclose([arrow.xy for arrow in shown], wanted, atol=1e-6)
