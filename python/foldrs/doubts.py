"""What is doubtful about an image, told to whoever asked: a warning, or a note that goes with a result.

Python's own way to catch warnings changes the whole process: two images at a time would catch each other's.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar

from foldrs.errors import GarmentCutOffWarning

_notes: ContextVar[list[str] | None] = ContextVar("foldrs_doubts", default=None)


@contextmanager
def noted_doubts() -> Iterator[list[str]]:
    """Collect the doubts of this thread in a list instead of warning of them."""
    notes: list[str] = []
    token = _notes.set(notes)
    try:
        yield notes
    finally:
        _notes.reset(token)


def doubt(message: str, stacklevel: int = 1) -> None:
    """Note what is doubtful, or issue a GarmentCutOffWarning where nobody takes notes."""
    notes = _notes.get()
    if notes is None:
        warnings.warn(message, GarmentCutOffWarning, stacklevel=stacklevel + 1)
    else:
        notes.append(message)
