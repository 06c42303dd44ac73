"""Damaged and hostile images: a result or a named error, in bounded time and memory.

A hundred of them, made here, the same every time; ``FOLDRS_DAMAGED=1000`` makes more.
"""

from __future__ import annotations

import io
import os
import struct
import sys
import warnings
import zlib
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image

import foldrs
from foldrs.errors import (
    FitTimeoutError,
    FoldrsError,
    GarmentCutOffWarning,
    ImageTooLargeError,
    WorkerLostError,
)
from foldrs.result import FitResult
from foldrs.synth import SynthParameters, make_scene
from foldrs.template import builtin_templates

COUNT = int(os.environ.get("FOLDRS_DAMAGED", "100"))
SECONDS = 60.0
"""Given to an image: many times what any needs, even on a busy machine."""
MEGABYTES = 1200
"""Memory that a process may take at most, with all libraries loaded."""
LIMIT = replace(foldrs.Parameters(), outline=replace(foldrs.Parameters().outline, max_pixels=20_000_000))

Rng = np.random.Generator
Rgb = NDArray[np.uint8]
SUFFIXES = (".jpg", ".png", ".webp", ".tif")


def encoded(rgb: NDArray[np.generic], suffix: str) -> bytes:
    return cv2.imencode(suffix, rgb[..., ::-1] if rgb.ndim == 3 else rgb)[1].tobytes()


def any_suffix(rng: Rng) -> str:
    return SUFFIXES[rng.integers(len(SUFFIXES))]


def saved(image: Image.Image, kind: str, **options: object) -> bytes:
    with io.BytesIO() as file:
        image.save(file, kind, **options)
        return file.getvalue()


def cut(rgb: Rgb, rng: Rng) -> bytes:
    content = encoded(rgb, any_suffix(rng))
    return content[: rng.integers(1, len(content))]


def flipped_bytes(rgb: Rgb, rng: Rng) -> bytes:
    content = bytearray(encoded(rgb, any_suffix(rng)))
    for place in rng.integers(0, len(content), rng.integers(1, 40)):
        content[place] = rng.integers(256)
    return bytes(content)


def damaged_header(rgb: Rgb, rng: Rng) -> bytes:
    content = bytearray(encoded(rgb, any_suffix(rng)))
    for place in rng.integers(4, 60, 3):
        content[place] = rng.integers(256)
    return bytes(content)


def random_behind_a_header(rgb: Rgb, rng: Rng) -> bytes:
    head = encoded(rgb, any_suffix(rng))[: rng.integers(2, 64)]
    return head + rng.bytes(int(rng.integers(0, 4000)))


def random_bytes(rgb: Rgb, rng: Rng) -> bytes:
    return rng.bytes(int(rng.integers(0, 4000)))


def zeros(rgb: Rgb, rng: Rng) -> bytes:
    return bytes(int(rng.integers(0, 3)) * 1000)


def wrong_type(rgb: Rgb, rng: Rng) -> bytes:
    return (b"%PDF-1.7\n", b"PK\x03\x04", b"<svg width='9' height='9'/>", b"{}", b"\x7fELF")[rng.integers(5)]


def noise(rgb: Rgb, rng: Rng) -> bytes:
    return encoded(rng.integers(0, 256, rgb.shape).astype(np.uint8), any_suffix(rng))


def one_pixel(rgb: Rgb, rng: Rng) -> bytes:
    return encoded(rgb[:1, :1], any_suffix(rng))


def few_pixels(rgb: Rgb, rng: Rng) -> bytes:
    return encoded(rgb[: rng.integers(1, 9), : rng.integers(1, 400)], any_suffix(rng))


def very_wide(rgb: Rgb, rng: Rng) -> bytes:
    return encoded(cv2.resize(rgb, (20_000, int(rng.integers(1, 40)))), ".png")


def very_high(rgb: Rgb, rng: Rng) -> bytes:
    return encoded(cv2.resize(rgb, (int(rng.integers(1, 40)), 20_000)), ".jpg")


def png(width: int, height: int, data: bytes) -> bytes:
    """Build an 8-bit grey PNG of this size around compressed rows."""

    def chunk(name: bytes, content: bytes) -> bytes:
        return (
            struct.pack(">I", len(content)) + name + content + struct.pack(">I", zlib.crc32(name + content))
        )

    header = struct.pack(">IIBBBBB", width, height, 8, 0, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", data) + chunk(b"IEND", b"")


def bomb(rgb: Rgb, rng: Rng) -> bytes:
    return png(12_000, 12_000, zlib.compress(bytes(12_001) * 12_000, 9))


def claimed_bomb(rgb: Rgb, rng: Rng) -> bytes:
    return png(int(rng.integers(2**15, 2**31)), int(rng.integers(2**15, 2**31)), zlib.compress(b"\x00" * 99))


def claimed_chunk(rgb: Rgb, rng: Rng) -> bytes:
    """A PNG of which a chunk claims up to 4 GB that are not there."""
    content = bytearray(encoded(rgb, ".png"))
    struct.pack_into(">I", content, content.index(b"IDAT") - 4, int(rng.integers(2**30, 2**32)))
    return bytes(content)


def cmyk(rgb: Rgb, rng: Rng) -> bytes:
    return saved(Image.fromarray(rgb).convert("CMYK"), "JPEG")


def one_bit(rgb: Rgb, rng: Rng) -> bytes:
    return saved(Image.fromarray(rgb).convert("1"), ("PNG", "TIFF")[rng.integers(2)])


def palette(rgb: Rgb, rng: Rng) -> bytes:
    return saved(Image.fromarray(rgb).quantize(16), ("PNG", "GIF")[rng.integers(2)])


def animated(rgb: Rgb, rng: Rng) -> bytes:
    frames = [Image.fromarray(np.roll(rgb, shift, axis=1)) for shift in (0, 9, 18)]
    kind = ("GIF", "WEBP", "PNG")[rng.integers(3)]
    return saved(frames[0], kind, save_all=True, append_images=frames[1:])


def alpha(rgb: Rgb, rng: Rng) -> bytes:
    opacity = rng.integers(0, 256, (*rgb.shape[:2], 1)).astype(np.uint8)
    return saved(Image.fromarray(np.dstack([rgb, opacity])), "PNG")


def sixteen_bit(rgb: Rgb, rng: Rng) -> bytes:
    return encoded(rgb.astype(np.uint16) * 257, (".png", ".tif")[rng.integers(2)])


def whole(rgb: Rgb, rng: Rng) -> bytes:
    return encoded(rgb, any_suffix(rng))


DAMAGES: tuple[Callable[[Rgb, Rng], bytes], ...] = (
    cut,
    flipped_bytes,
    damaged_header,
    random_behind_a_header,
    random_bytes,
    zeros,
    wrong_type,
    noise,
    one_pixel,
    few_pixels,
    very_wide,
    very_high,
    bomb,
    claimed_bomb,
    claimed_chunk,
    cmyk,
    one_bit,
    palette,
    animated,
    alpha,
    sixteen_bit,
    whole,
)


@pytest.fixture(scope="module")
def rgb() -> Rgb:
    parameters = SynthParameters(image_size=(320, 240), px_per_cm=2.5, tables=("plain",), cloths=("plain",))
    return make_scene(builtin_templates("towel")[0], seed=3, parameters=parameters).image


@pytest.fixture(scope="module")
def answers(rgb: Rgb, tmp_path_factory: pytest.TempPathFactory) -> dict[str, FitResult | Exception]:
    """What comes of every damaged image, each fitted in a process that could be ended."""
    folder = tmp_path_factory.mktemp("damaged")
    images: list[Path] = []
    for number in range(COUNT):
        damage = DAMAGES[number % len(DAMAGES)]
        images.append(folder / f"{number:04}-{damage.__name__}{SUFFIXES[number % len(SUFFIXES)]}")
        images[-1].write_bytes(damage(rgb, np.random.default_rng(number)))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", GarmentCutOffWarning)  # half a towel may well touch the border
        found = list(foldrs.fit_many(images, timeout=SECONDS, garment_type="towel", parameters=LIMIT))
    return dict(zip((image.name for image in images), found, strict=True))


def test_every_damaged_image_gives_a_result_or_a_named_error(
    answers: dict[str, FitResult | Exception],
) -> None:
    assert len(answers) == COUNT
    for name, answer in answers.items():
        assert isinstance(answer, (FitResult, FoldrsError)), f"{name}: {answer!r}"
        assert not isinstance(answer, (FitTimeoutError, WorkerLostError)), f"{name}: {answer!r}"
        assert isinstance(answer, FitResult) or len(str(answer)) > 20, name


def test_what_is_not_damaged_is_still_read(answers: dict[str, FitResult | Exception]) -> None:
    for kind in ("whole", "cmyk", "palette", "animated", "sixteen_bit"):
        found = [answer for name, answer in answers.items() if f"-{kind}." in name]
        assert found
        assert all(isinstance(answer, FitResult) for answer in found), (kind, found)


def test_bombs_are_not_decoded(answers: dict[str, FitResult | Exception]) -> None:
    bombs = [answer for name, answer in answers.items() if "bomb." in name]
    assert bombs
    assert all(isinstance(answer, ImageTooLargeError) for answer in bombs), bombs


@pytest.mark.skipif(sys.platform == "win32", reason="the resource module is missing")
def test_memory_is_bounded(answers: dict[str, FitResult | Exception]) -> None:
    import resource

    assert answers
    most = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss  # of all processes that have ended
    megabytes = most / 1e6 if sys.platform == "darwin" else most / 1e3
    assert megabytes < MEGABYTES


def test_the_limit_is_a_parameter(rgb: Rgb, tmp_path: Path) -> None:
    path = tmp_path / "photo.png"
    path.write_bytes(encoded(rgb, ".png"))
    least = rgb.shape[0] * rgb.shape[1]
    for limit, fits in ((least, True), (least - 1, False)):
        outline = replace(LIMIT.outline, max_pixels=limit)
        for source in (path, rgb):
            (answer,) = foldrs.fit_many(
                [source], garment_type="towel", parameters=replace(LIMIT, outline=outline)
            )
            assert isinstance(answer, FitResult if fits else ImageTooLargeError)
    with pytest.raises(ImageTooLargeError, match="320 x 240"):
        foldrs.fit(rgb, mask=path, parameters=replace(LIMIT, outline=outline))
