"""Files that hold the results of all images of a call: the page and the recording."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import AbstractContextManager, ExitStack, contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Protocol

from foldrs._options import make_folder

if TYPE_CHECKING:
    from foldrs.report import Report
    from foldrs.rerun_recording import RerunRecording
    from foldrs.result import FitResult


class Show(Protocol):
    """Takes one image after the other, in any order."""

    def __call__(self, image: Path, result: FitResult | None, error: str = "") -> None:
        """Take an image with its result, or with the reason why there is none."""


def open_outputs(
    images: Sequence[Path], report: Path | None, rerun: Path | None
) -> AbstractContextManager[Show]:
    """Open the files asked for; they are written when the context ends, the images in their own order.

    Raises
    ------
    MissingExtraError
        If a recording is asked for and rerun-sdk is not installed.
    click.ClickException
        If a folder cannot be made.
    """
    opened: list[Report | RerunRecording] = []
    for option, path in (("--report", report), ("--rerun", rerun)):
        if path is not None:
            make_folder(path.parent, option)
    if report is not None:
        from foldrs.report import Report

        opened.append(Report(report))
    if rerun is not None:
        from foldrs.rerun_recording import RerunRecording

        opened.append(RerunRecording(rerun))
    return _shown_to(opened, {image: position for position, image in enumerate(images)})


@contextmanager
def _shown_to(opened: Sequence[Report | RerunRecording], place: dict[Path, int]) -> Iterator[Show]:
    with ExitStack() as stack:
        for one in opened:
            stack.enter_context(one)

        def show(image: Path, result: FitResult | None, error: str = "") -> None:
            for one in opened:
                one.add(result, image, name=image.name, error=error, position=place[image])

        yield show
