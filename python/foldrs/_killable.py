"""Calls that can be ended at any moment, because they run in a process of their own.

Threads cannot be ended, and a process pool that loses one process gives up all. Here every thread that calls
has one process beside it (:mod:`foldrs._worker`) as long as it lives; only that one is ended and replaced.
"""

from __future__ import annotations

import os
import pickle
import subprocess
import sys
import threading
import weakref
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from typing import Any, TypeAlias

from foldrs.errors import FitTimeoutError, ParameterError, WorkerLostError

Noted: TypeAlias = tuple[Any, tuple[str, ...]]
"""An answer, and what is doubtful about it."""

_own = threading.local()
"""Its `worker` is the process beside this thread, its `crew` that of the thread, if it has one."""


class Crew:
    """Threads whose processes can be ended together."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._processes: set[subprocess.Popen[bytes]] = set()
        self._ended = False

    def join(self) -> None:
        """Have the calling thread's processes belong to it from now on."""
        _own.crew = self

    def add(self, process: subprocess.Popen[bytes]) -> None:
        """Take a process in; after `end` only to end it."""
        with self._lock:
            self._processes = {one for one in self._processes if one.poll() is None} | {process}
            if self._ended:
                process.kill()

    def end(self) -> None:
        """End all processes, and those that are begun from now on."""
        with self._lock:
            self._ended = True
            for process in self._processes:
                process.kill()


@dataclass(frozen=True)
class Killable:
    """Runs `task` in the process beside the calling thread, no longer than `seconds`.

    The result is what the task returns, which must be a pair of an answer and notes; the answer is an error
    where time ran out or the process ended. Can itself be sent to other processes and machines.
    """

    task: Callable[[Any], Noted]
    seconds: float
    threads: int = 1
    """Threads of each process."""

    def __call__(self, argument: Any) -> Noted:
        """Run the task; starting a process is not counted."""
        try:
            call = pickle.dumps((self.task, argument))
        except Exception as error:  # whatever the argument's own pickling raises
            return ParameterError(f"An image could not be sent to a process of its own: {error}"), ()
        worker: _Worker | None = getattr(_own, "worker", None)
        if worker is None or worker.threads != self.threads or not worker.runs():
            worker = _own.worker = _Worker(self.threads)
        try:
            return worker.call(call, self.seconds)
        except (FitTimeoutError, WorkerLostError) as error:
            _own.worker = None
            return error.with_traceback(None), ()


class _Worker:
    """One process and the pipes to it. It ends with the thread that it serves."""

    def __init__(self, threads: int) -> None:
        self.threads = threads
        environment = {**os.environ, "PYTHONPATH": os.pathsep.join(path for path in sys.path if path)}
        self._process = subprocess.Popen(
            [sys.executable, "-m", "foldrs._worker", str(threads)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            env=environment,
        )
        crew: Crew | None = getattr(_own, "crew", None)
        if crew is not None:
            crew.add(self._process)
        # When its input closes the process ends, busy or not.
        self._close = weakref.finalize(self, _end, self._process)
        self._reply()

    def runs(self) -> bool:
        return self._process.poll() is None

    def call(self, call: bytes, seconds: float) -> Noted:
        """Have a pickled (task, argument) run."""
        late = threading.Event()
        process = self._process  # not `self`: the timer's thread must not keep this alive

        def kill() -> None:
            late.set()
            process.kill()

        timer = threading.Timer(seconds, kill)
        timer.daemon = True
        timer.start()
        try:
            stdin = self._process.stdin
            assert stdin is not None
            pickle.dump(call, stdin)
            stdin.flush()
            reply: Noted = self._reply()
            return reply
        except (WorkerLostError, OSError) as error:
            self._close()
            if late.is_set():
                raise FitTimeoutError(
                    f"The image took longer than {seconds:g} s and was given up: "
                    "allow more time, or make it smaller."
                ) from None
            raise WorkerLostError(
                f"The process at work on the image ended (status {self._process.wait()}): killed, out of "
                "memory, or by a defect. The image may be too large."
            ) from error
        finally:
            timer.cancel()

    def _reply(self) -> Any:
        stdout = self._process.stdout
        assert stdout is not None
        try:
            return pickle.load(stdout)
        except (EOFError, OSError, pickle.UnpicklingError) as error:
            raise WorkerLostError(
                f"A process for the images could not be started or ended: {error}"
            ) from error


def _end(process: subprocess.Popen[bytes]) -> None:
    """End a process and let go of its pipes."""
    process.kill()
    for pipe in (process.stdin, process.stdout):
        if pipe is not None:
            with suppress(OSError):  # what was still to be sent has no receiver any more
                pipe.close()
    process.wait()
