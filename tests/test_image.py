"""Images of every kind come out as the same RGB array, and what is no image is refused by name."""

from __future__ import annotations

import re
import struct
import zlib
from pathlib import Path

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image

from foldrs.errors import FoldrsError, ImageNotFoundError, NotAnImageError
from foldrs.image import as_mask, as_rgb, read_image, read_mask

TURNED = {
    1: lambda a: a,
    2: lambda a: a[:, ::-1],
    3: lambda a: a[::-1, ::-1],
    4: lambda a: a[::-1],
    5: lambda a: a.swapaxes(0, 1),
    6: lambda a: np.rot90(a, -1),
    7: lambda a: np.rot90(a, 2).swapaxes(0, 1),
    8: lambda a: np.rot90(a, 1),
}
"""What each EXIF orientation does to the picture stored."""


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


@pytest.mark.parametrize("orientation", range(1, 9))
@pytest.mark.parametrize(
    ("suffix", "transparent"),
    [("jpg", False), *((suffix, alpha) for suffix in ("png", "webp", "tiff") for alpha in (False, True))],
)
def test_exif_orientation_is_honoured(
    tmp_path: Path, picture: np.ndarray, orientation: int, suffix: str, transparent: bool
) -> None:
    """Cut out as well as whole: the parts hidden by alpha, coloured like the rest, lie on white."""
    alpha = np.full(picture.shape[:2], 255, np.uint8)
    alpha[:20, :10] = 0
    exif = Image.Exif()
    exif[0x0112] = orientation
    stored = np.dstack([picture, alpha]) if transparent else picture
    how = {"jpg": {"quality": 95}, "webp": {"lossless": True, "exact": True}}.get(suffix, {})
    Image.fromarray(stored).save(tmp_path / f"turned.{suffix}", exif=exif, **how)
    want = TURNED[orientation](np.where(alpha[..., None] == 0, 255, picture) if transparent else picture)
    found = read_image(tmp_path / f"turned.{suffix}")
    assert difference(found, want) <= (4 if suffix == "jpg" else 0)
    assert found.flags.c_contiguous


@pytest.mark.parametrize("orientation", range(1, 9))
def test_exif_orientation_of_16_bit_with_alpha(tmp_path: Path, picture: np.ndarray, orientation: int) -> None:
    """Motorola's order of bytes too, the block behind the pixels, and a mask in the alpha channel."""
    alpha = np.full(picture.shape[:2], 255, np.uint8)
    alpha[:20, :10] = 0
    deep = np.dstack([picture[..., ::-1], alpha]).astype(np.uint16) * 257
    tags = struct.pack(">4sIHHHIHHI", b"MM\0*", 8, 1, 0x0112, 3, 1, orientation, 0, 0)
    (tmp_path / "deep.png").write_bytes(with_exif(cv2.imencode(".png", deep)[1].tobytes(), tags))
    want = TURNED[orientation](np.where(alpha[..., None] == 0, 255, picture))
    assert difference(read_image(tmp_path / "deep.png"), want) == 0
    Image.fromarray(np.dstack([np.zeros_like(picture), alpha])).save(tmp_path / "mask.png")
    (tmp_path / "mask.png").write_bytes(with_exif((tmp_path / "mask.png").read_bytes(), tags))
    assert np.array_equal(read_mask(tmp_path / "mask.png"), TURNED[orientation](alpha > 0))


def with_exif(png: bytes, exif: bytes) -> bytes:
    """A PNG file with an EXIF block behind the pixels, before its last chunk."""
    chunk = b"eXIf" + exif
    return png[:-12] + struct.pack(">I", len(exif)) + chunk + struct.pack(">I", zlib.crc32(chunk)) + png[-12:]


@pytest.mark.parametrize(
    "exif", [b"", b"MM", b"II*\0\xff\xff\xff\xff", b"MM\0*\0\0\0\x08\0\x09", b"no exif at all"]
)
def test_a_damaged_exif_block_turns_nothing(tmp_path: Path, picture: np.ndarray, exif: bytes) -> None:
    Image.fromarray(picture).save(tmp_path / "a.png", exif=exif)
    Image.fromarray(picture).save(tmp_path / "a.webp", exif=exif, lossless=True)
    for name in ("a.png", "a.webp"):
        assert difference(read_image(tmp_path / name), picture) == 0


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


@pytest.mark.parametrize("mode", ["RGB", "RGBA", "CMYK", "1", "P", "LA", "L", "I;16", "transparent P"])
@pytest.mark.parametrize("orientation", [1, 6])
def test_an_image_of_pillow_is_its_file(
    tmp_path: Path, picture: np.ndarray, mode: str, orientation: int
) -> None:
    alpha = np.full(picture.shape[:2], 255, np.uint8)
    alpha[:20, :10] = 0
    whole = Image.fromarray(np.dstack([picture, alpha]))
    exif = Image.Exif()
    exif[0x0112] = orientation
    how: dict[str, object] = {}
    if mode == "I;16":
        image = Image.fromarray(picture[..., 0].astype(np.uint16) * 257)
    elif mode.endswith("P"):
        image = whole.convert("RGB").quantize(32)
        how = {"transparency": image.getpixel((0, 0))} if mode != "P" else {}
    else:
        image = whole.convert("LA" if mode == "LA" else "RGBA" if mode == "RGBA" else "RGB").convert(mode)
    path = tmp_path / "a.png"
    if mode == "CMYK":  # compressed: Pillow does not turn all uncompressed TIFFs right
        path, how = tmp_path / "a.tiff", {"compression": "tiff_lzw"}
    image.save(path, exif=exif, **how)
    want = read_image(path)
    with Image.open(path) as opened:
        assert difference(as_rgb(opened), want) <= (1 if mode == "CMYK" else 0)
        assert as_mask(opened).shape == want.shape[:2]
    assert want.shape == (TURNED[orientation](picture)).shape
    assert difference(want, TURNED[orientation](picture)) < 150


def test_an_image_of_pillow_of_other_colours_or_cut_short(tmp_path: Path, picture: np.ndarray) -> None:
    assert difference(as_rgb(Image.fromarray(picture).convert("YCbCr")), picture) < 3
    Image.fromarray(picture).save(tmp_path / "a.png")
    (tmp_path / "cut.png").write_bytes((tmp_path / "a.png").read_bytes()[:-40])
    with Image.open(tmp_path / "cut.png") as cut, pytest.raises(NotAnImageError, match="Pillow"):
        as_rgb(cut)


@pytest.mark.parametrize("shape", [(20, 30), (20, 30, 3)])
def test_a_floating_point_tiff_is_refused_as_such(
    tmp_path: Path, shape: tuple[int, ...], capfd: pytest.CaptureFixture[str]
) -> None:
    cv2.imwrite(str(tmp_path / "a.tiff"), np.zeros(shape, np.float32))
    with pytest.raises(NotAnImageError, match="floating-point TIFF"):
        read_image(tmp_path / "a.tiff")
    assert capfd.readouterr().err == ""


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("", "path is empty"),
        ("https://example.com/a.jpg", "^https://example.com/a.jpg is a URL"),
        (Path("https://example.com/a.jpg"), "is a URL, which is not read"),
        ("file:///home/a.jpg", "URL"),
    ],
)
def test_what_names_no_file_is_told_as_it_was_given(name: str | Path, words: str) -> None:
    for read in (read_image, read_mask):
        with pytest.raises(ImageNotFoundError, match=words):
            read(name)


@pytest.mark.parametrize("name", ["x" * 300 + ".jpg", "nul\0.jpg", "file/below.jpg", "."])
def test_names_that_no_image_can_have_are_refused(tmp_path: Path, name: str) -> None:
    (tmp_path / "file").write_bytes(b"x")
    with pytest.raises(ImageNotFoundError) as caught:
        read_image(tmp_path / name)
    assert Path(name).name[:40].split("\0")[0] in str(caught.value)
    with pytest.raises(ImageNotFoundError):
        read_mask(tmp_path / name)


@pytest.mark.parametrize(
    "error", [PermissionError(13, "Permission denied"), OSError(5, "Input/output error")]
)
def test_a_file_that_cannot_be_read_is_named_with_the_reason(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, error: OSError
) -> None:
    def refused(_: Path) -> bytes:
        raise error

    (tmp_path / "locked.jpg").write_bytes(b"x")
    monkeypatch.setattr(Path, "read_bytes", refused)
    with pytest.raises(NotAnImageError) as caught:
        read_image(tmp_path / "locked.jpg")
    for word in ("locked.jpg", error.strerror, "check"):
        assert word in str(caught.value)
