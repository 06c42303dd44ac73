"""Where the results of a batch go, so that nothing is lost or overwritten and a batch can be taken up again.

Every file appears whole or not at all, and the JSON file of an image last: where there is one, all is there.
It notes in ``made_by`` what it was made from, which decides whether it has to be made again, and the pictures
drawn with it, which are replaced and removed with it. What foldrs did not make stays where it is.
"""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, fields, is_dataclass
from pathlib import Path
from typing import Any

import numpy as np

from foldrs import __version__
from foldrs.errors import OutputError
from foldrs.result import SCHEMA, FitResult
from foldrs.whole_files import remove_parts, written_whole

_RESULT_FIELDS = {"garment_type", "accepted", "matching_cost", "alternatives"}
_BEGINNING = b'{"schema":1,"image":'
"""How every JSON file written here begins, one that was cut off as well."""
_ERROR_BEGINNING = b'{"image": '

STAGES = ".stages.png"
PICTURES = (".png", STAGES)
"""Suffixes of all pictures there are."""


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
        return self.folder / (self._below_common(image) if self.keep_folders else Path()) / image.stem

    def told(self, image: Path) -> str:
        """Name by which an image is told of: with the folders that tell it from others, if they are kept."""
        return (self._below_common(image) / image.name).as_posix() if self.keep_folders else image.name

    def _below_common(self, image: Path) -> Path:
        """Folder of an image, seen from the one that all images lie below."""
        parents = [os.path.abspath(one.parent) for one in self.images]  # noqa: PTH100  (links are kept)
        return Path(os.path.relpath(os.path.abspath(image.parent), os.path.commonpath(parents)))  # noqa: PTH100

    def check(self, inputs: Sequence[Path]) -> None:
        """Refuse a batch that would write a file twice, over a file that it reads, or over a list not ours.

        Raises
        ------
        OutputError
        """
        written: dict[Path, Path] = {}
        read = {path.resolve() for path in (*inputs, *self.images)}
        for image in self.images:
            for path in self._paths(image):
                if path in written:
                    kept = "" if self.keep_folders else "use --keep-folders, "
                    raise OutputError(
                        f"{written[path]} and {image} would both be written to {path}: rename one, {kept}"
                        "or use one call each with a folder of its own"
                    )
                written[path] = image
                if path.resolve() in read:
                    raise OutputError(
                        f"{path} is read here and would be overwritten: use another folder for --out"
                    )
        if not _is_list_of_errors(self.errors):
            raise OutputError(
                f"{self.errors} is not a list of errors by foldrs and would be overwritten: move it, or use "
                "another folder for --out"
            )

    def prepare(self) -> None:
        """Make the folder; clear away errors and half files of an earlier batch that may have been killed."""
        self.folder.mkdir(parents=True, exist_ok=True)
        self.errors.unlink(missing_ok=True)
        for folder in {self.base(image).parent for image in self.images}:
            if folder.is_dir():
                self._remove_pictures_without_result(folder)
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
        if not set(self.pictures) <= set(_drawn(made_by) or ()):
            return None  # the picture beside is an older one, or none of foldrs
        wanted = self._made_by(image)
        same = all(made_by.get(key) == wanted[key] for key in ("foldrs", "options", "image_sha256"))
        return stored if same else None

    def save(self, image: Path, result: FitResult) -> None:
        """Write the pictures of a result, then its JSON file; pictures of an earlier one do not stay behind.

        Raises
        ------
        OutputError
            There is a result of another image of the same name, or a file that foldrs did not make.
        OSError
            A file cannot be written.
        """
        base = self.base(image)
        path = _json_of(base)
        made_by = self._made_by(image)
        earlier = _made_by_of(path)
        self._refuse_other(path, made_by)
        self._refuse_foreign(base, earlier)
        base.parent.mkdir(parents=True, exist_ok=True)
        content = {**result.to_dict(), "made_by": made_by}
        # The draft lies there while pictures are drawn: it tells, after a kill, that they are foldrs's.
        with written_whole(path) as draft:
            draft.write_bytes(json.dumps(content, separators=(",", ":")).encode())
            for suffix in set(_drawn(earlier) or ()) - set(self.pictures):
                _beside(base, suffix).unlink(missing_ok=True)
            if self.draw is not None:
                with self._pictures_or_none(base):
                    self.draw(result, image, base)

    @contextmanager
    def _pictures_or_none(self, base: Path) -> Iterator[None]:
        """Leave no picture without its result where one of them cannot be drawn."""
        try:
            yield
        except BaseException:
            for suffix in self.pictures:
                _beside(base, suffix).unlink(missing_ok=True)
            raise

    def _remove_pictures_without_result(self, folder: Path) -> None:
        """Remove the pictures that a batch drew which was killed before the result was in its place."""
        ours = {_json_of(self.base(image)) for image in self.images}
        for draft in folder.glob(".*.json.*.part"):
            path = folder / draft.name[1:].removesuffix(".part").rpartition(".")[0]
            if path not in ours:
                continue
            kept = _drawn(_made_by_of(path)) or ()
            for suffix in set(_drawn(_made_by_of(draft)) or ()) - set(kept):
                _beside(path.with_suffix(""), suffix).unlink(missing_ok=True)

    def note_error(self, image: Path, error: BaseException) -> None:
        """Add an image to the list of errors, at once: it is there if the batch is killed."""
        line = json.dumps(error_entry(image, error)) + "\n"
        with self.errors.open("a", encoding="utf-8") as file:
            file.write(line)

    def _paths(self, image: Path) -> list[Path]:
        base = self.base(image)
        return [_beside(base, suffix) for suffix in (".json", *self.pictures)]

    def _made_by(self, image: Path) -> dict[str, Any]:
        try:
            place = os.path.relpath(image, self.folder)
        except ValueError:  # on another drive
            place = str(image.resolve())
        content = hashlib.sha256(image.read_bytes()).hexdigest()
        return {
            "foldrs": __version__,
            "options": self.options,
            "image": place,
            "image_sha256": content,
            "pictures": list(self.pictures),
        }

    def _refuse_other(self, path: Path, made_by: Mapping[str, Any]) -> None:
        earlier = _made_by_of(path)
        if earlier is None:
            return
        if all(earlier.get(key) != made_by[key] for key in ("image", "image_sha256")):
            raise OutputError(
                f"{path} is the result of another image ({earlier.get('image')}, seen from there) and was "
                "left alone: use another folder for --out"
                + ("" if self.keep_folders else ", or --keep-folders")
            )

    def _refuse_foreign(self, base: Path, earlier: Mapping[str, Any] | None) -> None:
        """Refuse to replace a file that foldrs did not make: a ground truth, an annotation, a mask."""
        path = _json_of(base)
        in_the_way = [] if may_replace(path) else [path]
        drawn = _drawn(earlier)
        if drawn is None:  # nothing is noted: those beside a result are its pictures
            drawn = self.pictures if _is_there(path) and may_replace(path) else ()
        for suffix in self.pictures:
            if suffix not in drawn and _is_there(_beside(base, suffix)):
                in_the_way.append(_beside(base, suffix))
        if in_the_way:
            raise OutputError(
                f"{' and '.join(map(str, in_the_way))} was not made by foldrs, is in the way, and was left "
                "alone: move it, or use another folder for --out"
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


def _beside(base: Path, suffix: str) -> Path:
    return base.with_name(f"{base.name}{suffix}")


def _json_of(base: Path) -> Path:
    return _beside(base, ".json")


def _is_there(path: Path) -> bool:
    """Whether there is anything of that name, a link that leads nowhere included."""
    return path.exists() or path.is_symlink()


def _made_by_of(path: Path) -> Mapping[str, Any] | None:
    stored = _stored(path)
    made_by = None if stored is None else stored.get("made_by")
    return made_by if isinstance(made_by, dict) else None


def _drawn(made_by: Mapping[str, Any] | None) -> Sequence[str] | None:
    """Suffixes of the pictures drawn with a result; None where that is not noted."""
    noted = None if made_by is None else made_by.get("pictures")
    if not isinstance(noted, list):
        return None
    return [one for one in noted if one in PICTURES]


def may_replace(path: Path) -> bool:
    """Whether nothing is lost with a result's file: there is none, it holds nothing, or foldrs made it."""
    if not _is_there(path):
        return True
    return path.is_file() and (not path.read_bytes().strip(b"\0 \r\n\t") or _looks_like_result(path))


def _looks_like_result(path: Path) -> bool:
    """Whether a file is a result, perhaps one that was cut off."""
    stored = _stored(path)
    if stored is not None:
        return stored.keys() >= _RESULT_FIELDS
    try:
        content = path.read_bytes()
        json.loads(content)
    except OSError:
        return False
    except (ValueError, RecursionError):
        return content.startswith(_BEGINNING)
    return False


def _is_list_of_errors(path: Path) -> bool:
    """Whether a file is a list that :meth:`Destination.note_error` writes, or there is none."""
    if not _is_there(path):
        return True
    if not path.is_file():
        return False
    *lines, last = path.read_bytes().split(b"\n")
    # A batch that was killed may have left its last line half written.
    return all(map(_is_error_entry, lines)) and (not last or last.startswith(_ERROR_BEGINNING))


def _is_error_entry(line: bytes) -> bool:
    try:
        entry = json.loads(line)
    except (ValueError, RecursionError):
        return False
    return isinstance(entry, dict) and entry.keys() >= {"image", "error"}
