"""Images of every kind come out as the same RGB array, and what is no image is refused by name."""

from __future__ import annotations

import re
from pathlib import Path

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image

from foldrs.errors import FoldrsError, ImageNotFoundError, NotAnImageError
from foldrs.image import as_mask, as_rgb, read_image, read_mask


@pytest.fixture
def picture() -> np.ndarray:
    """Smooth RGB (48, 64, 3) without symmetry, so a turned or colour-swapped reading shows."""
    y, x = np.mgrid[:48, :64]
    return np.stack([x * 4, y * 5, 60 + x + y], axis=2).astype(np.uint8)


def difference(a: np.ndarray, b: np.ndarray) -> float:
    assert a.shape == b.shape
    return float(np.abs(a.astype(int) - b.astype(int)).mean())


@pytest.mark.parametrize(("suffix", "tolerance"), [("png", 0.0), ("tiff", 0.0), ("jpg", 4.0), ("webp", 4.0)])
def test_reads_the_formats(tmp_path: Path, picture: np.ndarray, suffix: str, tolerance: float) -> None:
    Image.fromarray(picture).save(tmp_path / f"Tüte 1.{suffix}")
    rgb = read_image(tmp_path / f"Tüte 1.{suffix}")
    assert rgb.dtype == np.uint8
    assert rgb.flags.c_contiguous
    assert difference(rgb, picture) <= tolerance


@pytest.mark.parametrize("suffix", ["png", "tiff"])
def test_reads_16_bit(tmp_path: Path, picture: np.ndarray, suffix: str) -> None:
    deep = picture.astype(np.uint16) * 257
    cv2.imwrite(str(tmp_path / f"rgb.{suffix}"), deep[..., ::-1])
    cv2.imwrite(str(tmp_path / f"grey.{suffix}"), deep[..., 0])
    assert difference(read_image(tmp_path / f"rgb.{suffix}"), picture) == 0
    assert difference(read_image(str(tmp_path / f"grey.{suffix}")), picture[..., [0, 0, 0]]) == 0


@pytest.mark.parametrize("suffix", ["png", "webp", "tiff"])
def test_transparent_parts_are_laid_on_white(tmp_path: Path, picture: np.ndarray, suffix: str) -> None:
    alpha = np.full(picture.shape[:2], 255, np.uint8)
    alpha[:10] = 0
    lossless = {"lossless": True, "exact": True} if suffix == "webp" else {}
    Image.fromarray(np.dstack([picture, alpha])).save(tmp_path / f"a.{suffix}", **lossless)
    rgb = read_image(tmp_path / f"a.{suffix}")
    assert (rgb[:10] == 255).all()
    assert difference(rgb[10:], picture[10:]) == 0


@pytest.mark.parametrize(
    ("orientation", "stored"),
    [
        (1, lambda a: a),
        (2, lambda a: a[:, ::-1]),
        (3, lambda a: a[::-1, ::-1]),
        (6, lambda a: np.rot90(a, 1)),
        (8, lambda a: np.rot90(a, -1)),
    ],
)
def test_exif_orientation_is_honoured(tmp_path: Path, picture: np.ndarray, orientation, stored) -> None:
    exif = Image.Exif()
    exif[0x0112] = orientation
    Image.fromarray(np.ascontiguousarray(stored(picture))).save(
        tmp_path / "turned.jpg", exif=exif, quality=95
    )
    assert difference(read_image(tmp_path / "turned.jpg"), picture) < 4


@given(
    dtype=st.sampled_from(["uint8", "uint16", "int16", "int32", "int64", "float32", "float64"]),
    channels=st.sampled_from([None, 1, 3, 4]),
    layout=st.sampled_from(["C", "F", "reversed", "strided", "readonly"]),
    unit=st.booleans(),
)
def test_arrays_of_any_type_and_layout_give_the_same_picture(dtype, channels, layout, unit) -> None:
    shape = (5, 7) if channels is None else (5, 7, channels)
    want = np.random.default_rng(3).integers(0, 256, shape).astype(np.uint8)
    want.flat[0] = 255
    if channels == 4:
        want[..., 3] = 255
    array = want.astype(dtype)
    if unit and array.dtype.kind == "f":
        array /= 255
    if layout == "F":
        array = np.asfortranarray(array)
    elif layout == "reversed":
        array = array[::-1, ::-1].copy()[::-1, ::-1]
    elif layout == "strided":
        array = np.repeat(array, 2, axis=1)[:, ::2]
    elif layout == "readonly":
        array.setflags(write=False)
    rgb = as_rgb(array)
    colour = want.reshape(5, 7, -1)[..., :3]
    assert np.array_equal(rgb, np.broadcast_to(colour, (5, 7, 3)))
    assert rgb.dtype == np.uint8
    assert rgb.flags.c_contiguous
    assert rgb.flags.writeable
    assert not np.shares_memory(rgb, array)


def test_booleans_are_black_and_white_and_16_bit_is_scaled() -> None:
    assert as_rgb(np.array([[True, False]])).tolist() == [[[255] * 3, [0] * 3]]
    assert as_rgb(np.array([[65535, 32768, 0]], np.uint16))[0, :, 0].tolist() == [255, 128, 0]


@pytest.mark.parametrize(
    ("array", "words"),
    [
        (np.zeros((0, 5, 3), np.uint8), "empty"),
        (np.zeros(12), "shape"),
        (np.zeros((3, 20, 20)), "shape"),
        (np.zeros((2, 20, 20, 3)), "shape"),
        (np.full((4, 4), np.nan), "NaN"),
        (np.full((4, 4), np.inf), "infinity"),
        (np.full((4, 4), -1), "negative"),
        (np.full((4, 4), 300.0), "300"),
        (np.full((4, 4), 70000), "70000"),
        (np.full((4, 4), 1j), "complex"),
        (np.full((4, 4), "a"), "real numbers"),
        (np.full((4, 4), None), "object"),
    ],
)
def test_what_is_no_image_is_refused(array: np.ndarray, words: str) -> None:
    with pytest.raises(NotAnImageError, match=words):
        as_rgb(array)


def test_files_that_are_no_images_are_refused(tmp_path: Path, picture: np.ndarray) -> None:
    with pytest.raises(ImageNotFoundError, match=r"missing\.jpg"):
        read_image(tmp_path / "missing.jpg")
    with pytest.raises(FileNotFoundError, match="folder"):
        read_image(tmp_path)
    (tmp_path / "empty.jpg").touch()
    (tmp_path / "text.png").write_text("no picture")
    Image.fromarray(picture).save(tmp_path / "whole.png")
    (tmp_path / "cut.png").write_bytes((tmp_path / "whole.png").read_bytes()[:20])
    for name in ["empty.jpg", "text.png", "cut.png"]:
        with pytest.raises(NotAnImageError, match=re.escape(name)):
            read_image(tmp_path / name)
        with pytest.raises(FoldrsError):
            read_mask(tmp_path / name)


@pytest.mark.parametrize("high", [1, 200, 255, 65535, 1.0, 0.4])
def test_masks_of_any_range(high: float) -> None:
    want = np.zeros((6, 8), bool)
    want[2:4, 3:7] = True
    array = want * np.array(high)
    assert np.array_equal(as_mask(array), want)
    assert np.array_equal(as_mask(np.dstack([array] * 3)), want)
    assert as_mask(array).dtype == np.bool_
    assert not as_mask(np.zeros_like(array)).any()


def test_mask_files(tmp_path: Path) -> None:
    want = np.zeros((40, 60), bool)
    want[10:30, 20:50] = True
    grey = (want * 255).astype(np.uint8)
    Image.fromarray(grey).save(tmp_path / "mask.png")
    Image.fromarray(grey).save(tmp_path / "mask.jpg")
    Image.fromarray(np.dstack([np.zeros((40, 60, 3), np.uint8), grey])).save(tmp_path / "alpha.png")
    for name in ["mask.png", "mask.jpg", "alpha.png"]:
        assert np.array_equal(read_mask(tmp_path / name), want)
