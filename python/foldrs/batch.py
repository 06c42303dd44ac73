"""Many images, on one machine or several: a result or an error for each, whatever happens to any of them."""

from __future__ import annotations

import inspect
import os
import pickle
import tempfile
import warnings
from collections.abc import Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, Executor, Future, wait
from dataclasses import dataclass, field
from itertools import islice
from math import inf
from numbers import Integral, Real
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias, TypeVar

from foldrs import _core
from foldrs._killable import Killable
from foldrs._workers import fitting_threads
from foldrs.doubts import noted_doubts
from foldrs.errors import FoldrsError, GarmentCutOffWarning, ParameterError, WorkerLostError
from foldrs.result import FitResult

if TYPE_CHECKING:
    from foldrs.pipeline import Source

Answer: TypeAlias = FitResult | Exception
T = TypeVar("T")

_AHEAD = 64
"""Images handed to a foreign executor ahead of their turn: keeps a cluster busy, and memory bounded."""

_MOST_JOBS = 65_535
"""Threads a pool of the crate's can have."""

_HELD_BACK = 8
"""Times as many may be taken beyond the one whose turn it is: answers wait for a slow image before them."""


@dataclass(frozen=True)
class ImageContent:
    """An image file on its way to a machine that does not see this one's disk."""

    path: str
    """Where it came from."""
    content: bytes


@dataclass(frozen=True)
class Outcome:
    """What became of one image."""

    index: int
    """Its place among the images given."""
    answer: Answer
    """The result, or what went wrong."""
    doubts: tuple[str, ...] = ()
    """What is doubtful about it; `foldrs.fit` would have warned of that."""


@dataclass(frozen=True)
class FitTask:
    """Fits one image; can be sent to other processes and machines."""

    options: dict[str, Any] = field(default_factory=dict)
    """Those of :func:`foldrs.fit`."""

    def __call__(self, source: Source | ImageContent) -> tuple[Answer, tuple[str, ...]]:
        """Return the result or what went wrong, and what is doubtful; raises nothing of its own."""
        with noted_doubts() as doubts:
            try:
                answer: Answer = self._fit(source)
            except (KeyboardInterrupt, SystemExit):
                raise
            except BaseException as error:  # a panic in Rust is no Exception
                answer = _portable(error)
        return answer, tuple(doubts)

    def _fit(self, source: Source | ImageContent) -> FitResult:
        from foldrs import pipeline

        if not isinstance(source, ImageContent):
            return pipeline.fit(source, **self.options)
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder, Path(source.path).name)
            path.write_bytes(source.content)
            try:
                return pipeline.fit(path, **self.options)
            except FoldrsError as error:
                error.args = tuple(str(part).replace(str(path), source.path) for part in error.args)
                raise


def fit_many(
    images: Iterable[Source],
    *,
    executor: Executor | None = None,
    jobs: int | None = None,
    timeout: float | None = None,
    send_files: bool = False,
    **options: Any,
) -> Iterator[Answer]:
    """Explain many garments; yields a result or an error for every image, in the order given.

    No image stops the others. Images are taken from `images` a few ahead of the one whose turn it is, so it
    may be endless.

    Parameters
    ----------
    images : iterable of path, image array, mask or (n, 2) points
        As for :func:`foldrs.fit`, one garment each; a single one goes in a list too.
    executor : concurrent.futures.Executor, optional
        Where to run: a process pool, a Dask cluster (``Client(...).get_executor()``), anything that has
        ``submit``. It is not shut down. Default: threads of this process, which share the cores with the Rust
        code below them.
    jobs : int, optional
        Images and hypotheses at a time; default: all cores. Only without `executor`. Hypotheses keep to what
        was first said in this process: their threads stay.
    timeout : float, optional
        Seconds an image may take. Each is then fitted in a process of its own, beside the thread or worker
        that waits for it, because nothing else can be ended at any moment; that process serves image after
        image and is replaced where it was ended.
    send_files : bool
        Send the content of files to `executor` rather than their names: for machines that do not see this
        one's disk.
    **options
        As for :func:`foldrs.fit`.

    Yields
    ------
    FitResult or Exception
        An error is one of `foldrs.errors`; any other one is a defect, which costs its own image only.

    Raises
    ------
    ParameterError
        `images` is no iterable or a single path, `timeout` is not positive, `jobs` is less than 1 or was
        given with `executor`, or an option is out of its range; at the call, as all of these.
    TemplateError
        A template cannot be read.
    TypeError
        There is no such option.

    Warns
    -----
    GarmentCutOffWarning
        As :func:`foldrs.fit`, with the name of the image.

    Examples
    --------
    >>> import foldrs
    >>> square = [[0, 0], [90, 0], [90, 60], [0, 60]]
    >>> [getattr(one, "garment_type", one) for one in foldrs.fit_many([square], garment_type="towel")]
    ['towel']
    """
    check_batch(executor, jobs, timeout)
    check_images(images)
    task = FitTask(_checked(options))
    names: dict[int, str] = {}

    def named() -> Iterator[Source]:
        for index, source in enumerate(images):
            names[index] = Path(source).name if isinstance(source, (str, os.PathLike)) else ""
            yield source

    outcomes = _as_ready(task, named(), executor, jobs, timeout, send_files, held_back=_HELD_BACK)
    ordered = in_order((outcome.index, outcome) for outcome in outcomes)
    return (_answer(outcome, names.pop(outcome.index)) for outcome in ordered)


def fit_as_ready(
    images: Iterable[Source],
    *,
    executor: Executor | None = None,
    jobs: int | None = None,
    timeout: float | None = None,
    send_files: bool = False,
    **options: Any,
) -> Iterator[Outcome]:
    """Explain many garments as :func:`fit_many`, yielding each outcome when it is ready, in any order."""
    check_batch(executor, jobs, timeout)
    return _as_ready(FitTask(options), images, executor, jobs, timeout, send_files)


def _as_ready(
    task: FitTask,
    images: Iterable[Source],
    executor: Executor | None,
    jobs: int | None,
    timeout: float | None,
    send_files: bool,
    held_back: int | None = None,
) -> Iterator[Outcome]:
    if executor is not None:
        run = task if timeout is None else Killable(task, timeout)
        yield from _run(run, images, executor, _AHEAD, send_files, held_back)
        return
    threads = _core.set_threads(jobs)
    workers = min(threads, jobs or threads)
    if isinstance(images, (list, tuple)):
        workers = max(1, min(workers, len(images)))
    run = task if timeout is None else Killable(task, timeout, threads // workers)
    with fitting_threads(workers) as pool:
        yield from _run(run, images, pool, 2 * workers, send_files, held_back)


def in_order(numbered: Iterable[tuple[int, T]]) -> Iterator[T]:
    """Things numbered from 0 on, in that order; each is held back until those before it came."""
    waiting: dict[int, T] = {}
    turn = 0
    for number, thing in numbered:
        waiting[number] = thing
        while turn in waiting:
            yield waiting.pop(turn)
            turn += 1


def check_images(images: object) -> None:
    """Raise ParameterError unless these are several images: a path would be taken for its letters."""
    if isinstance(images, (str, bytes, os.PathLike)):
        raise ParameterError(f"images must be a list of them, not one path: pass [{images!r}]")
    if not isinstance(images, Iterable):
        raise ParameterError(f"images must be a list of them, not {type(images).__name__}")


def _checked(options: dict[str, Any]) -> dict[str, Any]:
    """Return options of :func:`foldrs.fit` with templates read, or raise what every image would fail by."""
    from foldrs import pipeline

    inspect.signature(pipeline.fit).bind(None, **options)  # a TypeError for an option that it does not have
    pipeline.check_options(**options)
    given, kind = options.get("templates"), options.get("garment_type")
    chosen = pipeline.choose_templates(given, kind, options.get("method", "best"))
    return options if given is None else {**options, "templates": chosen}


def check_batch(executor: Executor | None, jobs: int | None, timeout: float | None) -> None:
    """Raise ParameterError unless images can be fitted so."""
    if jobs is not None and not (_is_number(jobs, Integral) and 1 <= jobs <= _MOST_JOBS):
        raise ParameterError(f"jobs must be a whole number from 1 to {_MOST_JOBS}, not {jobs!r}")
    if timeout is not None and not (_is_number(timeout, Real) and 0 < timeout < inf):
        raise ParameterError(f"timeout must be a positive number of seconds, not {timeout!r}")
    if executor is not None and jobs is not None:
        raise ParameterError(
            "jobs goes without an executor, which has its own number of workers: leave one out"
        )


def _is_number(value: object, kind: type[Real] | type[Integral]) -> bool:
    return isinstance(value, kind) and not isinstance(value, bool)


def _run(
    task: FitTask | Killable,
    images: Iterable[Source],
    executor: Executor,
    ahead: int,
    send_files: bool,
    held_back: int | None,
) -> Iterator[Outcome]:
    """Run a task for every image, so many of them handed over at a time, none too far beyond the oldest."""
    sources = enumerate(images)
    running: dict[Future[Any], int] = {}
    taken = 0
    try:
        while True:
            room = ahead - len(running)
            if held_back is not None and running:
                room = min(room, min(running.values()) + held_back * ahead - taken)
            for index, source in islice(sources, max(0, room)):
                running[executor.submit(task, _with_content(source) if send_files else source)] = index
                taken = index + 1
            if not running:
                return
            done, _ = wait(running, return_when=FIRST_COMPLETED)
            for future in sorted(done, key=running.__getitem__):
                yield _outcome(running.pop(future), future)
    finally:
        for future in running:
            future.cancel()


def _outcome(index: int, future: Future[Any]) -> Outcome:
    try:
        return Outcome(index, *future.result())
    except Exception as error:  # the task raises nothing: this is the executor's
        lost = WorkerLostError(f"The worker was lost: {type(error).__name__}: {error}")
        lost.__cause__ = error
        return Outcome(index, lost)


def _with_content(source: Source) -> Source | ImageContent:
    """Read the file of a source, if it has one; a missing one is for the worker to tell of."""
    if isinstance(source, (str, os.PathLike)) and Path(source).is_file():
        return ImageContent(str(source), Path(source).read_bytes())
    return source


def _answer(outcome: Outcome, name: str) -> Answer:
    """Warn of what is doubtful, and name the image of an error."""
    answer = outcome.answer
    try:
        for doubt in outcome.doubts:
            warnings.warn(f"{name}: {doubt}" if name else doubt, GarmentCutOffWarning, stacklevel=3)
    except GarmentCutOffWarning as error:  # where warnings are errors, that is the answer
        answer = error
    if isinstance(answer, FoldrsError):
        answer.image = name
    return answer


def _portable(error: BaseException) -> Exception:
    """Make an error one that can be sent: without its frames, of a type that any process can build again."""
    if isinstance(error, FoldrsError):
        return error.with_traceback(None)
    try:
        pickle.loads(pickle.dumps(error))
    except Exception:
        return RuntimeError(f"{type(error).__name__}: {error}")
    return error if isinstance(error, Exception) else RuntimeError(f"{type(error).__name__}: {error}")
