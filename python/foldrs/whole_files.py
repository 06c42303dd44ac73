"""Files that appear whole or not at all, however many threads and processes write them; what can name one."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterator, Set
from contextlib import contextmanager
from pathlib import Path

from foldrs.errors import ParameterError

_PART = ".part"

# The mask can only be read by setting it, which no two threads may do at once: read it on loading.
_UMASK = os.umask(0o022)
os.umask(_UMASK)


def write_whole(path: Path, content: bytes) -> None:
    """Write a file so that no reader ever sees a part of it.

    Parameters
    ----------
    path : Path
        The file; one that is there is replaced.
    content : bytes
        All of it.

    Raises
    ------
    OSError
        It cannot be written; what was there before is left as it was.
    """
    with written_whole(path) as draft:
        draft.write_bytes(content)


@contextmanager
def written_whole(path: Path) -> Iterator[Path]:
    """Give a file beside `path` to write to, and move it there at the end; an exception leaves nothing.

    Raises
    ------
    OSError
        The file beside it cannot be made or moved.
    """
    handle, name = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.", suffix=_PART)
    os.close(handle)
    draft = Path(name)
    try:
        yield draft
        # A temporary file is its owner's alone; the result is to be as readable as any file made here.
        draft.chmod(0o666 & ~_UMASK)
        draft.replace(path)
    except BaseException:
        draft.unlink(missing_ok=True)
        raise


def remove_parts(folder: Path, names: Set[str]) -> None:
    """Remove the parts of files of these names that :func:`write_whole` left when it was killed."""
    for path in folder.glob(f".*{_PART}"):
        if path.name.removesuffix(_PART)[1:].rpartition(".")[0] in names:
            path.unlink(missing_ok=True)


def check_names_file(kind: str) -> None:
    """Raise ParameterError if files named by a kind of garment would lie elsewhere, or have no clean name."""
    if any(sign in "/\\" or not sign.isprintable() for sign in kind):
        raise ParameterError(
            f"The kind {kind!r} can name no file: give it a name without slashes and control characters."
        )
