"""Results as a recording for the Rerun viewer: every image with its layers, one step of a timeline each."""

from __future__ import annotations

import os
from contextlib import ExitStack
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any

import cv2
import numpy as np
from numpy.typing import NDArray

from foldrs.errors import MissingExtraError
from foldrs.image import Source, read_any, read_if_any
from foldrs.report import layers
from foldrs.result import FitResult
from foldrs.whole_files import written_whole

if TYPE_CHECKING:
    from foldrs.image import RgbImage

Points = NDArray[np.float64]

TIMELINE = "image"
"""Name of the timeline; its steps are the places of the images."""
ROOT = "garment"
"""Entity of the photograph, above those of the other layers: ``garment/outline``, ``garment/crease``, ..."""

_QUALITY = 90  # of the photographs, of 100: they are kept in full size
_THIN, _THICK = 1.5, 3.0  # radii of lines, in units of the screen, which are negative for Rerun
_POINT, _RING = 5.0, 9.0
_IN_REACH, _OUT_OF_REACH = (255, 255, 255), (130, 130, 130)


class RerunRecording:
    """A Rerun recording of results, a step of the timeline ``image`` each; needs ``foldrs[rerun]``.

    Use it in a ``with`` block: the file appears when the block ends, whole or, if an exception ends it, not
    at all. What is added is written at once, so memory does not grow with the images.

    Parameters
    ----------
    path : path
        The ``.rrd`` file to write.

    Raises
    ------
    MissingExtraError
        If rerun-sdk is not installed.

    Examples
    --------
    >>> from foldrs.rerun_recording import RerunRecording
    >>> with RerunRecording("results.rrd") as recording:  # doctest: +SKIP
    ...     for path in paths:
    ...         recording.add(foldrs.fit(path), path)
    """

    def __init__(self, path: str | os.PathLike[str]) -> None:
        try:
            import rerun
        except ImportError as error:
            raise MissingExtraError(
                "a recording needs the package rerun-sdk: pip install 'foldrs[rerun]'"
            ) from error
        self.path = Path(path)
        self._rerun: Any = rerun
        self._stream: Any = None
        self._open = ExitStack()
        self._count = 0

    def __enter__(self) -> RerunRecording:
        draft = self._open.enter_context(written_whole(self.path))
        self._stream = self._rerun.RecordingStream("foldrs")
        self._open.callback(self._stream.disconnect)  # before the draft is moved to its place
        self._stream.save(draft)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._open.__exit__(kind, error, trace)

    def add(
        self,
        result: FitResult | None,
        image: Source = None,
        *,
        name: str = "",
        error: str = "",
        position: int | None = None,
    ) -> None:
        """Add an image: the photograph, and each layer as an entity below it, in px of the photograph.

        Parameters
        ----------
        result : FitResult, optional
            What was found; None if the image could not be explained.
        image : path or image array, optional
            The photograph.
        name : str
            Its name; default: the result's `image`.
        error : str
            Why there is no result.
        position : int, optional
            Step of the timeline; default: after all images added before.

        Raises
        ------
        ImageNotFoundError, NotAnImageError
            `image` cannot be read; only if there is a result.
        """
        photo = read_any(image) if result is not None else read_if_any(image)
        step = self._count if position is None else position
        self._count = max(self._count, step + 1)
        self._stream.set_time(TIMELINE, sequence=step)
        # A viewer shows the latest of every entity: what this image lacks must not stay from the one before.
        self._stream.log(ROOT, self._rerun.Clear(recursive=True))
        self._log("about", self._rerun.TextDocument(_about(result, name, error), media_type="text/markdown"))
        if photo is not None:
            self._stream.log(ROOT, self._photograph(photo))
        if result is not None:
            self._log_layers(result)

    def _log_layers(self, result: FitResult) -> None:
        outline, unfolded = result.outline_image, result.unfolded_outline_image
        self._log(layers.OUTLINE.name, self._lines([_closed(outline)], layers.OUTLINE.colour, _THIN))
        self._log(layers.UNFOLDED.name, self._lines([_closed(unfolded)], layers.UNFOLDED.colour, _THIN))
        creases = [fold.axis_image for fold in result.folds]
        self._log(layers.CREASE.name, self._lines(creases, layers.CREASE.colour, _THICK))
        marks = result.landmarks
        if marks:
            colours = [_IN_REACH if mark.accessible else _OUT_OF_REACH for mark in marks.values()]
            points = np.array([mark.image for mark in marks.values()])
            self._log(layers.LANDMARKS.name, self._points(points, colours, _POINT, list(marks)))
        if result.grasp_pairs:
            pair = result.grasp_pairs[0]
            colour = _rgb(layers.GRASP.colour)
            self._log(layers.GRASP.name, self._points(pair.image, [colour] * 2, _RING, list(pair.landmarks)))

    def _log(self, entity: str, content: Any) -> None:
        self._stream.log(f"{ROOT}/{entity}", content)

    def _photograph(self, photo: RgbImage) -> Any:
        _, data = cv2.imencode(".jpg", photo[:, :, ::-1], [cv2.IMWRITE_JPEG_QUALITY, _QUALITY])
        return self._rerun.EncodedImage(contents=data.tobytes(), media_type="image/jpeg")

    def _lines(self, lines: list[Points], colour: str, radius: float) -> Any:
        strips = [_as_rerun(line) for line in lines]
        return self._rerun.LineStrips2D(strips, colors=[_rgb(colour)] * len(strips), radii=-radius)

    def _points(
        self, points: Points, colours: list[tuple[int, int, int]], radius: float, labels: list[str]
    ) -> Any:
        return self._rerun.Points2D(_as_rerun(points), colors=colours, radii=-radius, labels=labels)


def _as_rerun(points: Points) -> Points:
    """Shift points by half a pixel: for Rerun an integer is a pixel's upper left corner, not its centre."""
    shifted: Points = points + 0.5
    return shifted


def _closed(outline: Points) -> Points:
    return np.vstack([outline, outline[:1]])


def _rgb(colour: str) -> tuple[int, int, int]:
    """Read #rrggbb."""
    red, green, blue = bytes.fromhex(colour.removeprefix("#"))
    return red, green, blue


def _about(result: FitResult | None, name: str, error: str) -> str:
    """Say in a few words of Markdown what was found."""
    if result is None:
        return f"# {name}\n\n{error or 'not explained'}"
    found = "\n".join(
        f"{rank}. {one.garment_type}, {one.probability:.1%}"
        for rank, one in enumerate(result.alternatives, 1)
    )
    verdict = "accepted" if result.accepted else "not accepted: none is better than no fold"
    return f"# {name or result.image}\n\nFold {verdict}. {result.seconds:.2f} s.\n\n{found}"
