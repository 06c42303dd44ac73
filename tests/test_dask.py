"""Many images on a Dask cluster of several processes: the same answers, also when a worker is killed."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner

import foldrs
from foldrs.cli import main
from foldrs.synth import SynthParameters, make_scene
from foldrs.template import builtin_templates

distributed = pytest.importorskip("distributed", reason="Dask is not here: pip install 'foldrs[dask]'")
# Dask leaves sockets and loops to the garbage collector when a peer is killed.
pytestmark = [
    pytest.mark.filterwarnings("ignore"),
    pytest.mark.skipif(os.name == "nt", reason="there is no SIGKILL"),
]

SCENE = SynthParameters(image_size=(320, 240), px_per_cm=2.5, tables=("plain",), cloths=("plain",))
STARTING = 90.0


def started(*words: str) -> subprocess.Popen[bytes]:
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(path for path in sys.path if path)}
    return subprocess.Popen(
        [sys.executable, "-m", "distributed.cli." + words[0], *words[1:]],
        env=environment,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )


@contextmanager
def cluster(folder: Path, count: int) -> Iterator[tuple[str, list[subprocess.Popen[bytes]]]]:
    """A scheduler and workers on this machine, as anyone would start them on several."""
    known = folder / "scheduler.json"
    processes = [
        started(
            "dask_scheduler",
            "--host",
            "127.0.0.1",
            "--port",
            "0",
            "--no-dashboard",
            *("--scheduler-file", str(known)),
        )
    ]
    try:
        end = time.monotonic() + STARTING
        while not known.is_file() and time.monotonic() < end:
            time.sleep(0.05)
        address = json.loads(known.read_text())["address"]
        for _ in range(count):
            options = ["--nthreads", "1", "--no-nanny", "--no-dashboard", "--local-directory", str(folder)]
            processes.append(started("dask_worker", address, *options))
        with distributed.Client(address, set_as_default=False) as client:
            client.wait_for_workers(count, timeout=STARTING)
        yield address, processes[1:]
    finally:
        for process in reversed(processes):
            process.kill()
            process.wait()


@pytest.fixture(scope="module")
def photos(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    folder = tmp_path_factory.mktemp("photos")
    for seed in range(8):
        make_scene(builtin_templates("towel")[0], seed=seed, parameters=SCENE).write(folder, f"towel-{seed}")
    (folder / "towel-4.jpg").write_text("no picture")
    return sorted(folder.glob("*.jpg"))


def results(folder: Path) -> dict[str, Any]:
    return {
        path.name: {
            key: value
            for key, value in json.loads(path.read_text()).items()
            if key not in ("seconds", "timings")
        }
        for path in folder.glob("*.json")
    }


def fit(*arguments: object) -> Any:
    return CliRunner().invoke(main, ["fit", "--type", "towel", *(str(argument) for argument in arguments)])


def test_the_answers_are_those_of_one_machine(photos: list[Path], tmp_path: Path) -> None:
    local = fit(*photos, "--out", tmp_path / "local")
    with cluster(tmp_path, 2) as (address, _):
        far = fit(*photos, "--out", tmp_path / "far", "--dask", address)
        late = fit(photos[0], "--dask", address, "--timeout", 0.001)
    assert local.exit_code == far.exit_code == 1
    assert "towel-4.jpg" in far.stderr
    assert len(results(tmp_path / "far")) == len(photos) - 1
    assert results(tmp_path / "far") == results(tmp_path / "local")
    errors = [(tmp_path / out / "errors.jsonl").read_text() for out in ("far", "local")]
    assert errors[0] == errors[1]
    assert "longer than" in late.stderr


def test_a_worker_that_is_killed_costs_time_only(photos: list[Path], tmp_path: Path) -> None:
    good = [photo for photo in photos if photo.stem != "towel-4"]
    expected = [foldrs.fit(photo, garment_type="towel") for photo in good]
    with cluster(tmp_path, 3) as (address, workers):
        client = distributed.Client(address, set_as_default=False)
        with client:
            executor = client.get_executor(pure=False)
            answers = foldrs.fit_many(good * 3, executor=executor, garment_type="towel")
            found = [next(answers)]
            at_work = {name for name, tasks in client.processing().items() if tasks}
            assert len(at_work) > 1, "only one worker has anything to do"
            threading.Timer(0.0, workers[0].send_signal, [signal.SIGKILL]).start()
            found += list(answers)
            assert len(client.scheduler_info()["workers"]) == 2
    assert len(found) == 3 * len(good)
    for one, (index, _) in zip(found, enumerate(good * 3), strict=True):
        assert isinstance(one, foldrs.FitResult), one
        assert one.folds[0].axis_image.tolist() == expected[index % len(good)].folds[0].axis_image.tolist()


def test_a_cluster_that_is_not_there_is_named(photos: list[Path], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("foldrs.fit_cli._CONNECTING", "1s")
    done = fit(photos[0], "--dask", "tcp://127.0.0.1:9")
    assert done.exit_code == 1
    assert "tcp://127.0.0.1:9" in done.stderr
