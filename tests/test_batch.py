"""Many images: a result or a named error for each, in order, on any executor, whatever happens to one."""

from __future__ import annotations

import copy
import itertools
import multiprocessing
import os
import pickle
import threading
import time
from concurrent.futures import Executor, Future, ProcessPoolExecutor
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

import foldrs
from foldrs._killable import Killable
from foldrs.errors import (
    FitTimeoutError,
    FoldrsError,
    GarmentCutOffWarning,
    ImageNotFoundError,
    InvalidOutlineError,
    ParameterError,
    TemplateError,
    WorkerLostError,
)
from foldrs.result import FitResult
from foldrs.synth import SynthParameters, make_scene
from foldrs.template import builtin_templates

SCENE = SynthParameters(image_size=(320, 240), px_per_cm=2.5, tables=("plain",), cloths=("plain",))
SQUARE = [[0, 0], [90, 0], [90, 60], [0, 60]]
FLAG = [[0, 0], [120, 0], [120, 60], [0, 70]]
TOWEL = {"garment_type": "towel"}


def answer(result: foldrs.FitResult | Exception) -> Any:
    """All of an answer but how long it took."""
    if isinstance(result, Exception):
        return type(result).__name__, str(result)
    return {key: value for key, value in result.to_dict().items() if key not in ("seconds", "timings")}


@pytest.fixture(scope="module")
def photo(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("photos")
    make_scene(builtin_templates("towel")[0], seed=3, parameters=SCENE).write(folder, "towel")
    return folder / "towel.jpg"


def expected(images: list[Any]) -> list[Any]:
    answers = []
    for image in images:
        try:
            answers.append(answer(foldrs.fit(image, **TOWEL)))
        except FoldrsError as error:
            answers.append(answer(error))
    return answers


def test_answers_come_in_the_order_of_the_images(photo: Path) -> None:
    images = [SQUARE, photo, [[0, 0]], photo.with_name("nowhere.jpg"), FLAG, SQUARE]
    found = list(foldrs.fit_many(images, **TOWEL))
    assert [answer(one) for one in found] == expected(images)
    assert isinstance(found[2], InvalidOutlineError)
    assert isinstance(found[3], ImageNotFoundError)
    assert found[3].image == "nowhere.jpg"


def test_nothing_to_do_gives_nothing() -> None:
    assert list(foldrs.fit_many([])) == []
    assert list(foldrs.fit_many([], timeout=5)) == []


@pytest.mark.parametrize("way", ["threads", "processes", "killable", "processes, files sent"])
def test_every_way_to_run_gives_the_same(photo: Path, way: str) -> None:
    images: list[Any] = [photo, SQUARE, photo.with_name("nowhere.jpg"), FLAG]
    if way == "threads":
        found = list(foldrs.fit_many(images, jobs=2, **TOWEL))
    elif way == "killable":
        found = list(foldrs.fit_many(images, timeout=120, **TOWEL))
    else:
        with ProcessPoolExecutor(2, multiprocessing.get_context("spawn")) as pool:
            found = list(foldrs.fit_many(images, executor=pool, send_files="sent" in way, **TOWEL))
    assert [answer(one) for one in found] == expected(images)


def test_images_are_taken_as_they_are_needed() -> None:
    taken = itertools.count()
    endless = (SQUARE for _ in iter(lambda: next(taken), -1))
    answers = foldrs.fit_many(endless, jobs=2, **TOWEL)
    assert all(isinstance(one, FitResult) for one in itertools.islice(answers, 3))
    answers.close()  # type: ignore[attr-defined]
    assert next(taken) < 20


class Waiting:
    """An outline that is not there before something happens."""

    def __init__(self, event: threading.Event) -> None:
        self.event = event

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> np.ndarray:
        assert self.event.wait(60)
        return np.array(SQUARE, dtype=dtype)


def test_what_waits_for_a_slow_image_is_bounded() -> None:
    there, taken = threading.Event(), itertools.count()
    endless = (SQUARE if next(taken) == 0 else SQUARE[:2] for _ in itertools.count())
    images = itertools.chain([Waiting(there)], endless)
    answers = foldrs.fit_many(images, jobs=2, **TOWEL)  # type: ignore[arg-type]
    threading.Timer(1.0, there.set).start()
    assert isinstance(next(answers), FitResult)
    answers.close()  # type: ignore[attr-defined]
    # Every outline of two points is refused at once: a second is enough for thousands.
    assert next(taken) < 200


def test_opencv_has_its_threads_back_whichever_batch_ends_first() -> None:
    before = cv2.getNumThreads()
    try:
        cv2.setNumThreads(3)
        one, two = (foldrs.fit_many([SQUARE] * 9, **TOWEL) for _ in range(2))
        next(one), next(two)
        one.close()  # type: ignore[attr-defined]
        two.close()  # type: ignore[attr-defined]
        assert cv2.getNumThreads() == 3
    finally:
        cv2.setNumThreads(before)


def test_a_file_that_was_sent_is_named_as_it_was_given(tmp_path: Path) -> None:
    bad = tmp_path / "text.jpg"
    bad.write_text("no picture")
    with ProcessPoolExecutor(1, multiprocessing.get_context("spawn")) as pool:
        (found,) = foldrs.fit_many([bad], executor=pool, send_files=True)
    assert str(found).startswith(f"{bad} cannot be read")


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"timeout": 0}, "positive"),
        ({"timeout": float("nan")}, "positive"),
        ({"timeout": float("inf")}, "positive"),
        ({"jobs": 0}, "jobs"),
        ({"jobs": -1}, "jobs"),
        ({"jobs": 10**30}, "jobs"),
        ({"jobs": "2"}, "jobs"),
        ({"jobs": 1.5}, "jobs"),
        ({"timeout": "2"}, "timeout must be a positive number of seconds, not '2'"),
        ({"timeout": True}, "timeout"),
        ({"px_per_cm": -1}, "px_per_cm"),
        ({"px_per_cm": "4"}, "px_per_cm"),
        ({"method": "guess"}, "method"),
        ({"folds": 9}, "folds"),
        ({"parameters": {}}, "parameters"),
        ({"templates": [3]}, "templates"),
        ({"templates": ["nowhere.json"]}, "no such template file"),
        ({"garment_type": "ballgown"}, "ballgown"),
    ],
)
def test_limits_out_of_range(options: dict[str, Any], words: str) -> None:
    with pytest.raises((ParameterError, TemplateError), match=words):
        foldrs.fit_many([SQUARE], **options)  # at the call, not when the first answer is asked for


@pytest.mark.parametrize("images", ["no.png", Path("no.png"), b"no.png", 3, None])
def test_what_is_no_list_of_images_is_refused(images: Any) -> None:
    with pytest.raises(ParameterError, match="images must be a list"):
        foldrs.fit_many(images)


def test_an_unknown_option_is_refused_as_any_wrong_keyword() -> None:
    with pytest.raises(TypeError, match="garment"):
        foldrs.fit_many([SQUARE], garment="pants")
    with pytest.raises(TypeError, match="source"):
        foldrs.fit_many([SQUARE], source=SQUARE)


def test_templates_that_can_be_taken_once_serve_all_images() -> None:
    found = foldrs.fit_many([SQUARE, FLAG], templates=iter(builtin_templates("towel")))
    assert [answer(one) for one in found] == expected([SQUARE, FLAG])


def test_so_many_images_at_a_time(monkeypatch: pytest.MonkeyPatch) -> None:
    at_a_time, most = 0, 0
    lock = threading.Lock()

    def fit(source: object, **_: object) -> object:
        nonlocal at_a_time, most
        with lock:
            at_a_time += 1
            most = max(most, at_a_time)
        time.sleep(0.05)
        with lock:
            at_a_time -= 1
        return source

    foldrs.fit(SQUARE, **TOWEL)  # the pool is there, as large as it is
    monkeypatch.setattr("foldrs.pipeline.fit", fit)
    list(foldrs.fit_many([SQUARE] * 4, jobs=1))
    assert most == 1


def test_an_executor_has_its_own_workers() -> None:
    with ProcessPoolExecutor(1) as pool, pytest.raises(ParameterError, match="leave one out"):
        foldrs.fit_many([SQUARE], executor=pool, jobs=2)


def test_what_is_doubtful_is_warned_of_with_the_name(tmp_path: Path) -> None:
    scene = make_scene(builtin_templates("towel")[0], seed=3, parameters=SCENE)
    touching = scene.image[:, np.nonzero(scene.mask)[1].min() + 2 :]
    images = [tmp_path / "one.png", tmp_path / "two.png"]
    for image in images:
        cv2.imwrite(str(image), touching[..., ::-1])
    with pytest.warns(GarmentCutOffWarning) as warned:
        found = list(foldrs.fit_many(images, **TOWEL))
    assert all(isinstance(one, FitResult) for one in found)
    assert [str(one.message).split(":")[0] for one in warned] == ["one.png", "two.png"]
    (as_error,) = foldrs.fit_many(images[:1], **TOWEL)  # the tests run with warnings as errors
    assert isinstance(as_error, GarmentCutOffWarning)


def nap(seconds: float) -> tuple[float, tuple[str, ...]]:
    time.sleep(seconds)
    return seconds, ()


def vanish(status: int) -> None:
    os._exit(status)


def own_process(_: object) -> tuple[int, tuple[str, ...]]:
    return os.getpid(), ()


def chatter(word: str) -> tuple[str, tuple[str, ...]]:
    os.write(1, b"not a result")
    print(word)
    return word, ()


def test_what_takes_too_long_is_ended_and_the_next_one_runs() -> None:
    short = Killable(nap, 10.0)
    assert short(0.0) == (0.0, ())
    begin = time.monotonic()
    late, _ = short(600.0)
    assert isinstance(late, FitTimeoutError)
    assert isinstance(late, TimeoutError)
    assert "10 s" in str(late)
    assert time.monotonic() - begin < 120
    assert short(0.0) == (0.0, ())


def test_a_process_that_ends_costs_its_own_image_only() -> None:
    lost, _ = Killable(vanish, 120.0)(7)
    assert isinstance(lost, WorkerLostError)
    assert "status 7" in str(lost)
    assert Killable(nap, 120.0)(0.0) == (0.0, ())


def test_what_is_printed_does_not_get_between_the_results() -> None:
    assert Killable(chatter, 120.0)("a word") == ("a word", ())


def test_a_process_ends_with_its_thread() -> None:
    found: list[int] = []

    def serve() -> None:
        for _ in range(2):
            found.append(Killable(own_process, 120.0)(None)[0])

    thread = threading.Thread(target=serve)
    thread.start()
    thread.join()
    assert found[0] == found[1] != os.getpid()
    with pytest.raises(ProcessLookupError):
        os.kill(found[0], 0)


def test_an_image_that_takes_too_long_does_not_stop_the_others(photo: Path) -> None:
    found = list(foldrs.fit_many([photo, SQUARE], timeout=0.001, jobs=1))
    assert [type(one) for one in found] == [FitTimeoutError, FitTimeoutError]


class Napping:
    """An outline that takes its time."""

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> np.ndarray:
        time.sleep(300.0)
        return np.array(SQUARE, dtype=dtype)


def test_ending_a_batch_ends_the_processes_beside_it() -> None:
    answers = foldrs.fit_many([SQUARE, Napping(), Napping()], timeout=600, jobs=2, **TOWEL)  # type: ignore[list-item]
    assert isinstance(next(answers), FitResult)
    begin = time.monotonic()
    answers.close()  # type: ignore[attr-defined]
    assert time.monotonic() - begin < 100


class OnlyHere:
    """Can be sent, but not be built again."""

    def __reduce__(self) -> tuple[Any, ...]:
        return vanished, ()


def vanished() -> None:
    raise AttributeError("no such class here")


def test_what_a_process_cannot_read_is_told_and_the_next_one_runs() -> None:
    run = Killable(nap, 600.0)
    begin = time.monotonic()
    for argument, words in ((OnlyHere(), "no such class here"), (lambda: 0, "sent")):
        told, _ = run(argument)
        assert isinstance(told, ParameterError)
        assert words in str(told)
    assert run(0.0) == (0.0, ())
    assert time.monotonic() - begin < 300


class LosingExecutor(Executor):
    """Loses every second task."""

    def __init__(self) -> None:
        self.count = itertools.count()

    def submit(self, fn: Any, /, *args: Any, **kwargs: Any) -> Future[Any]:
        future: Future[Any] = Future()
        if next(self.count) % 2:
            future.set_exception(ConnectionError("gone"))
        else:
            future.set_result(fn(*args, **kwargs))
        return future


def test_an_executor_that_loses_tasks() -> None:
    found = list(foldrs.fit_many([SQUARE] * 4, executor=LosingExecutor(), **TOWEL))
    assert [type(one) for one in found] == [FitResult, WorkerLostError, FitResult, WorkerLostError]
    assert "ConnectionError: gone" in str(found[1])


@pytest.mark.parametrize(("method", "most"), [("best", 50_000), ("paper", 500_000)])
def test_results_can_be_sent_and_copied(photo: Path, method: Any, most: int) -> None:
    result = foldrs.fit(photo, method=method, **TOWEL)
    sent = pickle.dumps(result)
    assert len(sent) < most
    for same in (pickle.loads(sent), copy.deepcopy(result)):
        assert same is not result
        assert same.to_dict() == result.to_dict()
        assert len(same.stages) == len(result.stages)
        assert same.outline_image is not result.outline_image


def test_templates_and_errors_can_be_sent() -> None:
    (towel,) = builtin_templates("towel")
    for same in (pickle.loads(pickle.dumps(towel)), copy.deepcopy(towel)):
        assert np.array_equal(same.outline, towel.outline)
        assert list(same.landmarks) == list(towel.landmarks)
    error = TemplateError("no such landmark", field="grasp_pairs[0]")
    error.image = "photo.jpg"
    same_error = pickle.loads(pickle.dumps(error))
    assert (str(same_error), same_error.field, same_error.image) == (str(error), error.field, error.image)


def test_a_table_has_a_flat_row_for_every_answer(photo: Path) -> None:
    rows = foldrs.table(foldrs.fit_many([photo, photo.with_name("nowhere.jpg"), SQUARE], **TOWEL))
    good, bad, other = rows
    assert list(good) == list(bad) == list(other)
    assert all(
        value is None or isinstance(value, (str, bool, int, float)) for row in rows for value in row.values()
    )
    assert (good["image"], good["garment_type"], good["error"]) == ("towel.jpg", "towel", None)
    result = foldrs.fit(photo, **TOWEL)
    crease = [[good["crease_x1"], good["crease_y1"]], [good["crease_x2"], good["crease_y2"]]]
    assert np.array_equal(crease, result.fold.axis_image)
    best = result.grasp_pairs[0].landmarks if result.grasp_pairs else (None, None)
    assert (good["grasp_1"], good["grasp_2"]) == best
    assert (bad["image"], bad["garment_type"], bad["error"]) == ("nowhere.jpg", None, "ImageNotFoundError")
    assert foldrs.table([]) == []
