"""Where the results of a batch go, so that nothing is lost or overwritten and a batch can be taken up again.

Every file appears whole or not at all, and the JSON file of an image last: where there is one, all is there.
It notes in ``made_by`` what it was made from, which decides whether it has to be made again.
"""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields, is_dataclass
from pathlib import Path
from typing import Any

import numpy as np

from foldrs import __version__
from foldrs.errors import OutputError
from foldrs.result import SCHEMA, FitResult, remove_parts, write_whole


@dataclass(frozen=True)
class Destination:
    """A folder for the results of one batch."""

    folder: Path
    images: Sequence[Path]
    """All images of the batch."""
    options: str
    """Fingerprint of the options, see :func:`fingerprint`."""
    pictures: Sequence[str] = ()
    """Suffixes of the pictures drawn beside each JSON file."""
    draw: Callable[[FitResult, Path, Path], None] | None = None
    """Draws them: result, image, and the path of the results without a suffix."""
    keep_folders: bool = False
    """Whether the folders of the images, as far as they differ, are made again below `folder`."""

    @property
    def errors(self) -> Path:
        """The file that lists the images without a result."""
        return self.folder / "errors.jsonl"

    def base(self, image: Path) -> Path:
        """Path of an image's results, without the suffix."""
        if not self.keep_folders:
            return self.folder / image.stem
        parents = [os.path.abspath(one.parent) for one in self.images]  # noqa: PTH100  (links are kept)
        common = os.path.commonpath(parents)
        return self.folder / os.path.relpath(os.path.abspath(image.parent), common) / image.stem  # noqa: PTH100

    def check(self, inputs: Sequence[Path]) -> None:
        """Refuse a batch that would write a file twice, or over a file that it reads.

        Raises
        ------
        OutputError
        """
        written: dict[Path, Path] = {}
        read = {path.resolve() for path in (*inputs, *self.images)}
        for image in self.images:
            for path in self._paths(image):
                if path in written:
                    raise OutputError(
                        f"{written[path]} and {image} would both be written to {path}: rename one, use "
                        "--keep-folders, or use one call each with a folder of its own"
                    )
                written[path] = image
                if path.resolve() in read:
                    raise OutputError(
                        f"{path} is read here and would be overwritten: use another folder for --out"
                    )

    def prepare(self) -> None:
        """Make the folder; clear away errors and half files of an earlier batch that may have been killed."""
        self.folder.mkdir(parents=True, exist_ok=True)
        self.errors.unlink(missing_ok=True)
        for folder in {self.base(image).parent for image in self.images}:
            if folder.is_dir():
                remove_parts(folder, {path.name for image in self.images for path in self._paths(image)})

    def finished(self, image: Path) -> dict[str, Any] | None:
        """Return an image's result if it need not be made again, in its JSON form.

        All its files are there, and the JSON file is valid and was made by this version of foldrs, with these
        options, from an image of this very content.
        """
        stored = _stored(self.base(image).with_name(f"{self.base(image).name}.json"))
        if stored is None or not all(path.is_file() for path in self._paths(image)):
            return None
        made_by = stored.get("made_by")
        if not isinstance(made_by, dict) or not image.is_file():
            return None
        wanted = self._made_by(image)
        same = all(made_by.get(key) == wanted[key] for key in ("foldrs", "options", "image_sha256"))
        return stored if same else None

    def save(self, image: Path, result: FitResult) -> None:
        """Write the pictures of a result, then its JSON file.

        Raises
        ------
        OutputError
            There is a result of another image of the same name.
        OSError
            A file cannot be written.
        """
        base = self.base(image)
        path = base.with_name(f"{base.name}.json")
        made_by = self._made_by(image)
        self._refuse_other(path, made_by)
        base.parent.mkdir(parents=True, exist_ok=True)
        if self.draw is not None:
            self.draw(result, image, base)
        content = {**result.to_dict(), "made_by": made_by}
        write_whole(path, json.dumps(content, separators=(",", ":")).encode())

    def note_error(self, image: Path, error: BaseException) -> None:
        """Add an image to the list of errors, at once: it is there if the batch is killed."""
        line = json.dumps(error_entry(image, error)) + "\n"
        with self.errors.open("a", encoding="utf-8") as file:
            file.write(line)

    def _paths(self, image: Path) -> list[Path]:
        base = self.base(image)
        return [base.with_name(f"{base.name}{suffix}") for suffix in (".json", *self.pictures)]

    def _made_by(self, image: Path) -> dict[str, str]:
        try:
            place = os.path.relpath(image, self.folder)
        except ValueError:  # on another drive
            place = str(image.resolve())
        content = hashlib.sha256(image.read_bytes()).hexdigest()
        return {"foldrs": __version__, "options": self.options, "image": place, "image_sha256": content}

    def _refuse_other(self, path: Path, made_by: Mapping[str, str]) -> None:
        stored = _stored(path)
        earlier = None if stored is None else stored.get("made_by")
        if not isinstance(earlier, dict):
            return
        if all(earlier.get(key) != made_by[key] for key in ("image", "image_sha256")):
            raise OutputError(
                f"{path} is the result of another image ({earlier.get('image')}, seen from there) and was "
                "left alone: use another folder for --out, or --keep-folders"
            )


def fingerprint(options: Mapping[str, Any]) -> str:
    """Return a number, in hexadecimal, that differs where any option of :func:`foldrs.fit` does.

    Templates, masks and parameters count by what is in them.
    """
    text = json.dumps(options, default=_plain, sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()


def error_entry(image: Path, error: BaseException) -> dict[str, str]:
    """Return what is told of an image without a result, in JSON form."""
    return {"image": str(image), "error": type(error).__name__, "message": str(error)}


def _plain(value: Any) -> Any:
    if is_dataclass(value) and not isinstance(value, type):
        return {one.name: getattr(value, one.name) for one in fields(value)}
    if isinstance(value, np.ndarray):
        return [value.shape, str(value.dtype), hashlib.sha256(value.tobytes()).hexdigest()]
    if isinstance(value, Mapping):
        return dict(value)
    return str(value)


def _stored(path: Path) -> dict[str, Any] | None:
    """Read a result's file; None where there is none, or something else in its place."""
    try:
        content = json.loads(path.read_bytes())
    except (OSError, ValueError, RecursionError):
        return None
    return content if isinstance(content, dict) and content.get("schema") == SCHEMA else None
