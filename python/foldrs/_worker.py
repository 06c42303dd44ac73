"""A process that runs what it is sent, one call after the other: ``python -m foldrs._worker THREADS``.

Calls come in as pickled pairs (function, argument), each as the bytes of its pickle; results go out pickled.
It belongs to :mod:`foldrs._killable`.
"""

from __future__ import annotations

import os
import pickle
import queue
import signal
import sys
import threading
from typing import Any, BinaryIO

_Calls = queue.SimpleQueue[bytes]


def main() -> None:
    """Serve until the input closes."""
    # Whatever prints must not get between the results.
    replies = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)
    # Ctrl-C is for the process that waits for this one.
    signal.signal(signal.SIGINT, signal.SIG_IGN)

    import foldrs.pipeline  # noqa: F401  (what takes long to load is not to count as an image's time)
    from foldrs import _core

    _core.set_threads(int(sys.argv[1]))
    calls: _Calls = queue.SimpleQueue()
    threading.Thread(target=_listen, args=(sys.stdin.buffer, calls), daemon=True).start()
    _send(replies, "ready")
    while True:
        _send(replies, _run(calls.get()))


def _run(call: bytes) -> Any:
    try:
        function, argument = pickle.loads(call)
    except Exception as error:  # a type that only the sender can import, for instance
        from foldrs.errors import ParameterError

        return ParameterError(
            f"An image could not be read in the process of its own: {type(error).__name__}: {error}. "
            "Give a path or a plain array."
        ), ()
    return function(argument)


def _listen(pipe: BinaryIO, calls: _Calls) -> None:
    """Take in calls; when nobody is there any more, end, whatever is being computed."""
    while True:
        try:
            calls.put(pickle.load(pipe))
        except (EOFError, OSError):
            os._exit(0)


def _send(pipe: BinaryIO, value: Any) -> None:
    pickle.dump(value, pipe)
    pipe.flush()


if __name__ == "__main__":
    main()
