"""Threads for many fits at a time."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager

import cv2

from foldrs import _core
from foldrs._killable import Crew


@contextmanager
def fitting_threads(count: int) -> Iterator[ThreadPoolExecutor]:
    """Threads that each fit one image; what they compute shares the crate's one pool.

    What ends the block early, such as Ctrl-C, which Python raises in its main thread only, ends the fits that
    are running as well, in these threads and in the processes beside them; those that wait are never begun.

    Parameters
    ----------
    count : int
        At least 1.
    """
    stop, crew = _core.Stop(), Crew()

    def begin() -> None:
        stop.heed()
        crew.join()

    pool = ThreadPoolExecutor(count, initializer=begin)
    with _one_opencv_thread_each(count):
        try:
            yield pool
        except BaseException:
            stop.request()
            crew.end()
            raise
        finally:
            pool.shutdown(cancel_futures=True)


_opencv_lock = threading.Lock()
_opencv_blocks: list[int] = []
"""For every block that limits OpenCV's threads how many there were; the number is the whole process's."""


@contextmanager
def _one_opencv_thread_each(count: int) -> Iterator[None]:
    """Keep OpenCV to one thread, or every image would bring as many threads as there are cores."""
    if count == 1:
        yield
        return
    with _opencv_lock:
        _opencv_blocks.append(_opencv_blocks[0] if _opencv_blocks else cv2.getNumThreads())
        cv2.setNumThreads(1)
    try:
        yield
    finally:
        with _opencv_lock:
            found = _opencv_blocks.pop()
            if not _opencv_blocks:
                cv2.setNumThreads(found)
