"""Long calls: Ctrl-C ends them, other threads go on meanwhile."""

from __future__ import annotations

import multiprocessing
import os
import signal
import subprocess
import sys
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict
from pathlib import Path

import numpy as np
import pytest

import foldrs
from foldrs import _core
from foldrs._workers import fitting_threads
from foldrs.parameters import Parameters
from foldrs.synth import make_scene
from foldrs.template import builtin_templates, save_template

SOON = 20.0
"""Seconds: a busy machine may take its time, but the calls below take minutes unless they are ended."""

LONG_CALL = """
import numpy as np
from foldrs import _core
from foldrs.template import builtin_templates
p = _core.default_parameters()
p["partial_match"].update(points=400, affinity=1e-6, most=4000)
p["hypothesis"].update(most=100_000)
p["shape_context"].update(n_points=400)
templates = [t.outline for t in builtin_templates()]
seen = _core.Seen(templates[0], p)
print("ready", flush=True)
seen.matches(templates * 20)
"""

posix = pytest.mark.skipif(os.name != "posix", reason="signals of this kind are POSIX's")


@pytest.fixture(scope="module")
def outline() -> np.ndarray:
    return np.array(make_scene(builtin_templates("shorts")[0], seed=1).truth["outline_image"])


def begun(code: str) -> subprocess.Popen[str]:
    """A child that runs `code` and has printed that it is ready."""
    # Whoever runs the tests in the background ignores Ctrl-C, and children would take that over.
    heeding = f"import signal; signal.signal(signal.SIGINT, signal.default_int_handler)\n{code}"
    child = subprocess.Popen(
        [sys.executable, "-c", heeding], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    assert child.stdout is not None
    assert child.stdout.readline() == "ready\n"
    return child


def interrupted_after(child: subprocess.Popen[str], seconds: float) -> tuple[float, str]:
    """Seconds from SIGINT to the end of a child, and what it wrote to stderr."""
    try:
        time.sleep(seconds)
        assert child.poll() is None, "it was over before it could be interrupted"
        sent = time.monotonic()
        child.send_signal(signal.SIGINT)
        _, told = child.communicate(timeout=SOON)
        return time.monotonic() - sent, told
    finally:
        child.kill()
        child.wait()


@posix
def test_ctrl_c_ends_a_call() -> None:
    child = begun(LONG_CALL)
    taken, told = interrupted_after(child, 0.5)
    assert taken < SOON
    assert told.rstrip().endswith("KeyboardInterrupt")
    assert child.returncode != 0


@posix
@pytest.mark.parametrize("images", [1, 2])
def test_ctrl_c_ends_the_command(tmp_path: Path, images: int) -> None:
    names = [f"photo-{k}" for k in range(images)]
    for name in names:
        make_scene(builtin_templates("shorts")[0], seed=1).write(tmp_path, name)
    save_template(builtin_templates("shorts")[0], tmp_path / "shorts.json")
    out = tmp_path / "out"
    arguments = [
        *["fit", *(str(tmp_path / f"{name}.jpg") for name in names), "--out", str(out), "--method", "paper"],
        *["--template", str(tmp_path / "shorts.json")] * 1000,  # minutes of work
    ]
    code = f"from foldrs.cli import main; print('ready', flush=True); main({arguments!r})"
    child = begun(code)
    taken, told = interrupted_after(child, 3.0)
    assert taken < SOON
    assert "Aborted" in told
    assert "Traceback" not in told
    assert child.returncode == 1
    assert not list(out.glob("*"))


def test_a_stop_ends_calls_in_the_threads_that_heed_it(outline: np.ndarray) -> None:
    parameters = asdict(Parameters().matching)
    seen = _core.Seen(outline, parameters)
    templates = [t.outline for t in builtin_templates()] * 200
    stop = _core.Stop()
    with ThreadPoolExecutor(2, initializer=stop.heed) as pool:
        calls = [pool.submit(seen.matches, templates) for _ in range(2)]
        time.sleep(0.2)
        stop.request()
        for call in calls:
            with pytest.raises(KeyboardInterrupt):
                call.result(timeout=SOON)
        with pytest.raises(KeyboardInterrupt):
            pool.submit(seen.matches, templates).result(timeout=SOON)
    assert seen.matches(templates[:1])[0]


def test_ending_one_batch_leaves_other_fits_alone(outline: np.ndarray) -> None:
    one = next(foldrs.fit_many([outline], garment_type="shorts"))
    ended, told = threading.Event(), []

    def fit_meanwhile() -> None:
        while not ended.is_set():
            told.append(foldrs.fit(outline, garment_type="shorts"))

    with ThreadPoolExecutor(1) as pool:
        meanwhile = pool.submit(fit_meanwhile)
        for _ in range(3):
            answers = foldrs.fit_many([outline] * 20, garment_type="shorts")
            next(answers)
            answers.close()  # type: ignore[attr-defined]
        ended.set()
        meanwhile.result(timeout=SOON)
    assert isinstance(one, foldrs.FitResult)
    assert {each.matching_cost for each in told} == {one.matching_cost}


def test_what_ends_the_block_early_ends_its_fits(outline: np.ndarray) -> None:
    seen = _core.Seen(outline, asdict(Parameters().matching))
    templates = [t.outline for t in builtin_templates()] * 200

    def fit_two() -> None:
        with fitting_threads(1) as pool:
            calls.extend(pool.submit(seen.matches, templates) for _ in range(2))
            time.sleep(0.1)
            raise KeyboardInterrupt

    calls: list[object] = []
    with pytest.raises(KeyboardInterrupt):
        fit_two()
    running, waiting = calls
    assert isinstance(running.exception(), KeyboardInterrupt)  # type: ignore[attr-defined]
    assert waiting.cancelled()  # type: ignore[attr-defined]


def test_python_goes_on_while_a_call_runs(outline: np.ndarray) -> None:
    seen = _core.Seen(outline, asdict(Parameters().matching))
    templates = [t.outline for t in builtin_templates()]
    over = threading.Event()

    def match() -> None:
        try:
            seen.matches(templates)
        finally:
            over.set()

    steps = 0
    thread = threading.Thread(target=match)
    thread.start()
    while not over.is_set():
        steps += 1
    thread.join()
    # With the GIL held, the loop would have stood still until the call was over.
    assert steps > 1000


def test_threads_tell_what_one_tells(outline: np.ndarray) -> None:
    def told(kind: str) -> object:
        answer = foldrs.fit(outline, garment_type=kind).to_dict()
        return {field: value for field, value in answer.items() if field not in ("seconds", "timings")}

    kinds = ["shorts", "towel", "skirt", "pants"]
    alone = [told(kind) for kind in kinds]
    with ThreadPoolExecutor(4) as pool:
        assert list(pool.map(told, kinds)) == alone


FORKED = """
import multiprocessing, sys
from concurrent.futures import ProcessPoolExecutor
import foldrs
image = sys.argv[1]
foldrs.fit(image, garment_type="towel")  # so there are threads that a fork does not take along
with ProcessPoolExecutor(1, multiprocessing.get_context("fork")) as pool:
    for answer in foldrs.fit_many([image] * 2, executor=pool, garment_type="towel"):
        print(answer.garment_type, flush=True)
"""


@pytest.mark.skipif("fork" not in multiprocessing.get_all_start_methods(), reason="this system does not fork")
def test_a_forked_process_has_threads_of_its_own(tmp_path: Path) -> None:
    make_scene(builtin_templates("towel")[0], seed=3).write(tmp_path, "towel")
    run = [sys.executable, "-W", "ignore", "-c", FORKED, str(tmp_path / "towel.jpg")]
    told = subprocess.run(run, capture_output=True, text=True, timeout=10 * SOON, check=True)
    assert told.stdout.split() == ["towel", "towel"]
