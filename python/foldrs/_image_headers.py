"""What image files tell of themselves before they are decoded: kind, size, orientation, being whole."""

from __future__ import annotations

import io
import struct
from collections.abc import Iterator

import imagesize

from foldrs.errors import ImageTooLargeError

_JPEG_MAGIC = b"\xff\xd8"
_PNG_MAGIC = b"\x89PNG\r\n\x1a\n"
_RIFF_MAGIC = b"RIFF"
_PNG_FRAME, _PNG_CHECKSUM = 12, 4
"""Bytes of a PNG chunk besides its content (length, name, checksum), and of the last of these."""
_RIFF_HEADER = 12
_TIFF_MAGICS = (b"II*\0", b"MM\0*")
_ORIENTATION_TAG, _SAMPLE_FORMAT_TAG = 0x0112, 0x0153
_FLOATS = 3
"""Sample format of floating-point numbers."""


def is_jpeg(content: bytes) -> bool:
    """Whether a file is a JPEG by its first bytes."""
    return content.startswith(_JPEG_MAGIC)


def is_png(content: bytes) -> bool:
    """Whether a file is a PNG by its first bytes."""
    return content.startswith(_PNG_MAGIC)


def is_webp(content: bytes) -> bool:
    """Whether a file is a RIFF container, of which WebP is the only one that holds a picture."""
    return content.startswith(_RIFF_MAGIC)


def is_floating_point_tiff(content: bytes) -> bool:
    """Whether a file is a TIFF of floating-point numbers."""
    return _first_short(content, _SAMPLE_FORMAT_TAG) == _FLOATS


def orientation(content: bytes) -> int:
    """EXIF orientation of a PNG or WebP file, 1 to 8; 1, which turns nothing, where it tells none."""
    chunks = _png_chunks(content) if is_png(content) else _riff_chunks(content)
    exif = next((place for name, *place in chunks if name in (b"eXIf", b"EXIF")), None)
    if exif is None:
        return 1
    told = _first_short(content[exif[0] : exif[1]].removeprefix(b"Exif\0\0"), _ORIENTATION_TAG)
    return told if told is not None and 1 <= told <= 8 else 1


def _first_short(tagged: bytes, wanted: int) -> int | None:
    """First number, of 16 bits, of a tag in a TIFF file, or an EXIF block, which has the form of one."""
    order = "<" if tagged.startswith(_TIFF_MAGICS[0]) else ">"
    if not tagged.startswith(_TIFF_MAGICS):
        return None
    try:
        (start,) = struct.unpack_from(f"{order}I", tagged, 4)
        (count,) = struct.unpack_from(f"{order}H", tagged, start)
        for entry in range(start + 2, start + 2 + 12 * count, 12):
            tag, _, values, place = struct.unpack_from(f"{order}HHII", tagged, entry)
            if tag == wanted:
                # As many as four bytes hold stand in the entry itself.
                return int(struct.unpack_from(f"{order}H", tagged, place if values > 2 else entry + 8)[0])
    except struct.error:  # cut short
        pass
    return None


def can_be_decoded(content: bytes, max_pixels: int | None, what: str) -> bool:
    """Whether an image file may be given to OpenCV: it tells its size, and asks for no more than it has.

    Raises
    ------
    ImageTooLargeError
        The header tells of more pixels than allowed; `what` names the image.
    """
    size = _size_in_header(content)
    if size is None:
        return False
    check_size(*size, max_pixels, what)
    return _png_is_whole(content)


def _size_in_header(content: bytes) -> tuple[int, int] | None:
    """Width and height as the file's header tells them, without decoding; None where it does not."""
    try:
        width, height = imagesize.get(io.BytesIO(content))
    except Exception:  # whatever a damaged header makes the reader stumble over
        return None
    return (int(width), int(height)) if width > 0 and height > 0 else None


def _png_is_whole(content: bytes) -> bool:
    """Whether no chunk of a PNG file reaches beyond its end; True for other files.

    OpenCV makes room for a chunk of any length, up to 4 GB, before it finds that the file is shorter.
    """
    if not is_png(content):
        return True
    return all(end + _PNG_CHECKSUM <= len(content) for _, _, end in _png_chunks(content))


def _png_chunks(content: bytes) -> Iterator[tuple[bytes, int, int]]:
    """Name of every chunk of a PNG file, and where its content begins and ends."""
    place = len(_PNG_MAGIC)
    while place + _PNG_FRAME <= len(content):
        length, name = struct.unpack_from(">I4s", content, place)
        start = place + _PNG_FRAME - _PNG_CHECKSUM
        yield name, start, start + length
        place += length + _PNG_FRAME
        if name == b"IEND":
            return


def _riff_chunks(content: bytes) -> Iterator[tuple[bytes, int, int]]:
    """Name of every chunk of a WebP file, and where its content begins and ends."""
    place = _RIFF_HEADER
    while place + 8 <= len(content):
        name, length = struct.unpack_from("<4sI", content, place)
        yield name, place + 8, place + 8 + length
        place += 8 + length + length % 2  # padded to an even number of bytes


def check_size(width: int, height: int, max_pixels: int | None, what: str) -> None:
    """Raise ImageTooLargeError beyond the number of pixels allowed."""
    if max_pixels is not None and width * height > max_pixels:
        raise ImageTooLargeError(
            f"{what} has {width} x {height} pixels, more than the {max_pixels} allowed: make it smaller, or "
            "raise the limit (max_pixels)."
        )
