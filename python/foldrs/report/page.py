"""The page: one HTML file with everything in it, written image by image."""

from __future__ import annotations

import os
import tempfile
import threading
from collections.abc import Iterable, Iterator, Sequence, Sized
from dataclasses import dataclass
from importlib.resources import files
from itertools import repeat
from pathlib import Path
from types import TracebackType
from typing import IO, TYPE_CHECKING

import jinja2
from markupsafe import Markup

from foldrs import __version__
from foldrs._fit_told import reason
from foldrs.errors import ParameterError
from foldrs.image import Source, read_any, read_if_any
from foldrs.report.columns import Value, columns, values
from foldrs.report.drawing import draw
from foldrs.report.layers import LAYERS, TRUE
from foldrs.result import FitResult
from foldrs.whole_files import written_whole

if TYPE_CHECKING:
    from foldrs.evaluation import Scene, SceneMeasures

_NO_IMAGE = object()

_environment = jinja2.Environment(
    loader=jinja2.PackageLoader("foldrs.report", "assets"),
    autoescape=True,
    undefined=jinja2.StrictUndefined,
    trim_blocks=True,
    lstrip_blocks=True,
)


@dataclass(frozen=True)
class _Entry:
    """An image of the page: what it is sorted and filtered by, and where its part of the page is kept."""

    values: dict[str, Value]
    offset: int
    length: int


class Report:
    """A page of results, :class:`~foldrs.result.FitResult`, that grows image by image.

    Use it in a ``with`` block: the page is written when the block ends, whole or, if an exception ends it,
    not at all. Until then the images' parts wait in a temporary file, so that memory does not grow with
    them. All methods may be called from several threads at once.

    Parameters
    ----------
    path : path
        The HTML file to write.
    title : str
        Heading of the page.

    Examples
    --------
    >>> from foldrs.report import Report
    >>> with Report("report.html") as page:  # doctest: +SKIP
    ...     for path in paths:
    ...         page.add(foldrs.fit(path), path)
    """

    def __init__(self, path: str | os.PathLike[str], title: str = "Folded garments") -> None:
        self.path = Path(path)
        self.title = title
        self._entries: dict[int, _Entry] = {}
        self._measures: dict[int, SceneMeasures] = {}
        self._next = 0
        self._parts: IO[bytes] | None = None  # opened for the first image, closed by __exit__
        self._lock = threading.Lock()

    def add(
        self,
        result: FitResult | Exception | None,
        image: Source = None,
        *,
        name: str = "",
        error: str = "",
        scene: Scene | None = None,
        measures: SceneMeasures | None = None,
        position: int | None = None,
    ) -> None:
        """Add an image: its picture in layers, its explanations, its numbers.

        Parameters
        ----------
        result : FitResult or Exception, optional
            What was found, or why nothing was; None too if the image could not be explained.
        image : path or image array, optional
            The photograph; without it the layers are drawn on a plain background.
        name : str
            Its name on the page; default: the result's `image`, or that of the scene or the file.
        error : str
            Why there is no result; default: what the exception says.
        scene, measures : Scene and SceneMeasures, optional
            The truth, and how near the result comes to it (:mod:`foldrs.evaluation`).
        position : int, optional
            Place in the order of the page; default: after all images added before. An image added at the
            place of another replaces it.

        Raises
        ------
        ImageNotFoundError
            There is no file `image`; only if there is a result.
        NotAnImageError
            `image` cannot be read as an image; only if there is a result.
        """
        name = name or str(getattr(result, "image", "")) or (scene.name if scene else "") or _file_name(image)
        if isinstance(result, Exception):
            error, result = error or reason(result), None
        photo = read_any(image) if result is not None else read_if_any(image)
        told = values(name or "unnamed", result, measures)
        drawing = draw(result, photo, scene)
        with self._lock:
            number = self._next if position is None else position
            self._next = max(self._next, number + 1)
        card = _environment.get_template("card.html").render(
            number=number,
            values=told,
            columns=columns(measures is not None),
            drawing=drawing,
            timings=dict(result.timings) if result else {},
            error=error or (measures.error if measures else ""),
        )
        part = card.encode()
        with self._lock:
            parts = self._opened()
            offset = parts.seek(0, os.SEEK_END)
            parts.write(part)
            self._entries[number] = _Entry(told, offset, len(part))
            if measures is not None:
                self._measures[number] = measures

    def write(self) -> None:
        """Write the page with all images added so far, whole or not at all."""
        with self._lock:
            order = sorted(self._entries)
            entries = [self._entries[number] for number in order]
            measures = [self._measures[number] for number in sorted(self._measures)]
        page = _environment.get_template("page.html").generate(
            title=self.title,
            version=__version__,
            layers=[layer for layer in LAYERS if layer != TRUE or measures],
            columns=columns(bool(measures)),
            numbers=order,
            entries=[entry.values for entry in entries],
            kinds=sorted(
                {str(entry.values.get("true_kind") or entry.values["kind"] or "") for entry in entries}
            ),
            values={number: entry.values for number, entry in zip(order, entries, strict=True)},
            tables=_tables(measures),
            cards=self._cards(entries),
            style=_asset("page.css"),
            script=_asset("page.js"),
        )
        with written_whole(self.path) as draft, draft.open("w", encoding="utf-8", newline="\n") as file:
            file.writelines(page)

    def _cards(self, entries: Iterable[_Entry]) -> Iterator[Markup]:
        for entry in entries:
            with self._lock:  # for one part at a time, so that adding does not wait for the whole page
                parts = self._opened()
                parts.seek(entry.offset)
                part = parts.read(entry.length)
            yield Markup(part.decode())

    def _opened(self) -> IO[bytes]:
        """Return the file of the images' parts; to be called, and the file used, with the lock held."""
        if self._parts is None:
            self._parts = tempfile.TemporaryFile()  # noqa: SIM115
        return self._parts

    def __enter__(self) -> Report:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        try:
            if kind is None:
                self.write()
        finally:
            if self._parts is not None:
                self._parts.close()


def write(
    results: Iterable[FitResult | Exception],
    path: str | os.PathLike[str],
    *,
    images: Iterable[Source] | None = None,
    title: str = "Folded garments",
) -> None:
    """Write results as one HTML page that needs nothing else, neither files nor a network.

    Parameters
    ----------
    results : iterable of FitResult or Exception
        What to show, as :func:`foldrs.fit_many` yields it: an error is shown as such. Taken one by one, so a
        generator that fits while the page is made will do.
    path : path
        The HTML file to write, whole or not at all.
    images : iterable of paths or image arrays, optional
        The photograph of every result; None draws on a plain background.
    title : str
        Heading of the page.

    Raises
    ------
    ImageNotFoundError, NotAnImageError
        The image of a result cannot be read; that of an error may be at fault itself.
    ParameterError
        There are more results than images, or fewer.
    """
    with Report(path, title) as page:
        for result, image in _paired(results, images):
            page.add(result, image)


def _paired(
    results: Iterable[FitResult | Exception], images: Iterable[Source] | None
) -> Iterator[tuple[FitResult | Exception, Source]]:
    """Each result with its image, or None without any; ParameterError where one has no other."""
    if images is None:
        yield from zip(results, repeat(None))
        return
    if isinstance(results, Sized) and isinstance(images, Sized) and len(results) != len(images):
        raise _unpaired(str(len(results)), str(len(images)))
    count, more = 0, iter(images)
    for result in results:
        try:
            image = next(more)
        except StopIteration:
            raise _unpaired(f"more than {count}", str(count)) from None
        yield result, image
        count += 1
    if next(more, _NO_IMAGE) is not _NO_IMAGE:
        raise _unpaired(str(count), f"more than {count}")


def _unpaired(results: str, images: str) -> ParameterError:
    return ParameterError(f"there are {results} results and {images} images: pass one image for every result")


def _file_name(image: Source) -> str:
    return Path(image).name if isinstance(image, (str, os.PathLike)) else ""


def _tables(measures: Sequence[SceneMeasures]) -> list[object]:
    """Return Tables 1 and 2 of the paper and the further measures, if there is anything to measure by."""
    if not measures:
        return []
    from foldrs.evaluation import text_tables  # loads shapely

    return list(text_tables(measures))


def _asset(name: str) -> Markup:
    return Markup((files("foldrs.report") / "assets" / name).read_text(encoding="utf-8"))
