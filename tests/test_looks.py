"""Places of the cloth are told apart by how they look: the evidence of regions rests on it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

import foldrs
from foldrs import _core
from foldrs.joint_fit import flexible_template
from foldrs.looks import Looks, looks_of
from foldrs.parameters import MatchingParameters, PictureParameters

WIDTH, HEIGHT = 300, 240
CLOTH = np.array([[30, 40], [270, 40], [270, 200], [30, 200]], float)
MIDDLE = 150


def plain(colour: tuple[int, int, int]) -> NDArray[np.uint8]:
    return np.full((HEIGHT, WIDTH, 3), colour, np.uint8)


def stripes(angle: float) -> NDArray[np.uint8]:
    y, x = np.mgrid[:HEIGHT, :WIDTH]
    wave = np.sin((x * np.cos(angle) + y * np.sin(angle)) * 2 * np.pi / 10)
    return np.repeat((120 + 60 * wave).astype(np.uint8)[:, :, None], 3, axis=2)


def dots() -> NDArray[np.uint8]:
    picture = plain((120, 120, 120))
    for x in range(5, WIDTH, 12):
        for y in range(5, HEIGHT, 12):
            cv2.circle(picture, (x, y), 3, (200, 200, 200), -1)
    return picture


def beside(left: NDArray[np.uint8], right: NDArray[np.uint8]) -> NDArray[np.uint8]:
    noise = np.random.default_rng(0).normal(0, 2, left.shape)
    both = np.where(np.arange(WIDTH)[:, None] < MIDDLE, left, right)
    return np.clip(both + noise, 0, 255).astype(np.uint8)


def share_told(looks: Looks) -> float:
    """Share of places within the cloth whose look is found on their half only, or mostly."""
    ys, xs = np.mgrid[: looks.look.shape[0], : looks.look.shape[1]]
    x, y = xs / looks.scale + looks.origin[0], ys / looks.scale + looks.origin[1]
    inner = (x > 45) & (x < 255) & (y > 55) & (y < 185) & (abs(x - MIDDLE) > 15)
    right = (x > MIDDLE)[inner]
    of_look = looks.look[inner]
    mostly = [right[of_look == k].mean() > 0.5 if (of_look == k).any() else False for k in range(256)]
    return float((np.array(mostly)[of_look] == right).mean())


@pytest.mark.parametrize(
    ("left", "right"),
    [
        (lambda: plain((90, 60, 60)), lambda: plain((130, 95, 95))),
        (lambda: plain((120, 60, 60)), lambda: plain((60, 60, 120))),
        (dots, lambda: plain((128, 128, 128))),
        (lambda: stripes(0.6), lambda: stripes(-0.6)),
    ],
    ids=["lightness", "colour", "dots", "direction"],
)
def test_faces_that_differ_get_looks_of_their_own(
    left: Callable[[], NDArray[np.uint8]], right: Callable[[], NDArray[np.uint8]]
) -> None:
    looks = looks_of(beside(left(), right()), CLOTH, PictureParameters())
    assert share_told(looks) > 0.97


def test_one_face_has_no_halves() -> None:
    looks = looks_of(beside(dots(), dots()), CLOTH, PictureParameters())
    assert share_told(looks) < 0.8


def test_the_same_picture_has_the_same_looks_whatever_was_seen_before() -> None:
    picture = beside(dots(), plain((128, 128, 128)))
    first = looks_of(picture, CLOTH, PictureParameters())
    cv2.setRNGSeed(7)
    looks_of(beside(stripes(0.6), dots()), CLOTH, PictureParameters())
    again = looks_of(picture, CLOTH, PictureParameters())
    assert np.array_equal(first.look, again.look)


@pytest.mark.parametrize("size", [1, 4, 8])
def test_cloth_of_hardly_any_pixels_has_one_look(size: float) -> None:
    tiny = np.array([[30, 40], [30 + size, 40], [30 + size, 40 + size], [30, 40 + size]], float)
    assert not looks_of(plain((90, 60, 60)), tiny, PictureParameters()).look.any()


def test_an_outline_may_reach_beyond_the_picture() -> None:
    looks = looks_of(beside(dots(), dots()), CLOTH + np.array([60, -60]), PictureParameters())
    assert looks.origin == (90.0, 0.0)


def test_large_cloth_is_told_at_the_usual_size() -> None:
    large = cv2.resize(beside(dots(), plain((128, 128, 128))), None, fx=5, fy=5)
    looks = looks_of(np.asarray(large, np.uint8), CLOTH * 5, PictureParameters())
    assert looks.look.size < WIDTH * HEIGHT
    assert share_told(Looks(looks.look, looks.scale * 5, (30.0, 40.0))) > 0.97


def test_what_the_flap_covers_tells_how_far_it_reaches() -> None:
    """A towel longer than its template, its far face dotted: the outline alone makes the flap too short."""
    photo = np.full((340, 400, 3), (70, 110, 90), np.uint8)
    photo[100:260, 60:260] = (200, 190, 180)
    flap = photo[100:260, 60:132]
    for x in range(6, 72, 12):
        for y in range(6, 160, 12):
            cv2.circle(flap, (x, y), 3, (90, 60, 60), -1)
    photo = np.clip(photo + np.random.default_rng(1).normal(0, 2, photo.shape), 0, 255).astype(np.uint8)
    outline = np.array([[0, 0], [60, 0], [60, 40], [0, 40]], float)
    marks = dict(zip("abcd", outline, strict=True))
    template = foldrs.Template("towel", "towel", "cm", outline, marks)
    result = foldrs.fit(photo, templates=[template], px_per_cm=4)
    assert result.fold is not None
    assert np.ptp(result.unfolded_outline_image[:, 0]) / 4 == pytest.approx(68, abs=2.5)
    assert result.fold.flap_on_top is True


@pytest.mark.parametrize(("scale", "origin"), [(0.0, (0.0, 0.0)), (1.0, (np.nan, 0.0)), (np.inf, (0.0, 0.0))])
def test_looks_that_lie_nowhere_are_refused(scale: float, origin: tuple[float, float]) -> None:
    parameters = asdict(MatchingParameters())
    towel = foldrs.builtin_templates("towel")[0]
    seen = _core.Seen(towel.outline * 4 + 200, parameters)
    edges, look = np.zeros((40, 60, 3), np.float32), np.zeros((40, 60), np.uint8)
    with pytest.raises(ValueError, match="scale of looks"):
        _core.fit_jointly(
            seen,
            [towel.outline],
            [flexible_template(towel, parameters)],
            1,
            False,
            4.0,
            (edges, 1.0, None, (look, scale, origin)),
        )
