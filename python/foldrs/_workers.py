"""Threads for many fits at a time."""

from __future__ import annotations

from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager

import cv2

from foldrs import _core


@contextmanager
def fitting_threads(count: int) -> Iterator[ThreadPoolExecutor]:
    """Threads that each fit one image; what they compute shares the crate's one pool.

    What ends the block early, such as Ctrl-C, which Python raises in its main thread only, ends the fits that
    are running as well; those that wait are never begun.

    Parameters
    ----------
    count : int
        At least 1.
    """
    opencv = cv2.getNumThreads()
    pool = ThreadPoolExecutor(count)
    try:
        if count > 1:
            cv2.setNumThreads(1)  # or every image would bring as many threads as there are cores
        yield pool
    except BaseException:
        _core.stop_all()
        raise
    finally:
        pool.shutdown(cancel_futures=True)
        _core.stop_all(False)
        cv2.setNumThreads(opencv)
