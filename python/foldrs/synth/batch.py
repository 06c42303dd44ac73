"""Many scenes, by all cores."""

from __future__ import annotations

import multiprocessing
import os
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from pathlib import Path

import cv2
import numpy as np

from foldrs.errors import ParameterError
from foldrs.synth.garment import FlatGarment, Garment, Photograph, checked
from foldrs.synth.parameters import SynthParameters
from foldrs.synth.scene import check_suffix, make_scene
from foldrs.whole_files import check_names_file


def make_scenes(
    sources: Sequence[FlatGarment],
    count: int,
    seed: int,
    folder: str | Path,
    *,
    parameters: SynthParameters | None = None,
    suffix: str = ".jpg",
    jobs: int | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> list[Path]:
    """Make many scenes, the garments in turn, and write them.

    Scene k has the seed sequence's child k, so it is the same whatever the number of scenes and of jobs.

    Parameters
    ----------
    sources : sequence of FlatGarment
        The garments to make scenes of; scene k takes number k modulo their count. Those with a photograph
        lie on tables of any of the photographs.
    count : int
        Number of scenes.
    seed : int
        Seed of the whole set.
    folder : str or Path
        Where to write; made if missing.
    parameters : SynthParameters, optional
        What the scenes are like.
    suffix : {".jpg", ".png"}
        Kind of image.
    jobs : int, optional
        Number of processes; by default one a core.
    progress : callable, optional
        Called with (scenes written, ``count``) after every scene.

    Returns
    -------
    list of Path
        The JSON files, named KIND-NUMBER.json, in order.

    Raises
    ------
    ParameterError
        If ``sources`` is empty, ``count``, ``seed`` or ``jobs`` is too small, or a kind can name no file; and
        as :func:`make_scene`.
    """
    jobs = (os.cpu_count() or 1) if jobs is None else jobs
    if not sources:
        raise ParameterError("There is no garment to make scenes of: give at least one template or outline.")
    for name, value, least in (("count", count, 1), ("jobs", jobs, 1), ("seed", seed, 0)):
        if value < least:
            raise ParameterError(f"{name} is {value}: give a whole number from {least} up.")
    check_suffix(suffix)
    for source in sources:
        check_names_file(source.garment_type)
    parameters = SynthParameters() if parameters is None else parameters
    folder = Path(folder)
    garments = [checked(sources[k % len(sources)]) for k in range(min(count, len(sources)))]
    taken = [garments[k % len(garments)] for k in range(count)]
    tables = [one.photograph for one in garments if one.photograph is not None]
    digits = max(2, len(str(count)))
    names = [f"{garment.garment_type}-{k + 1:0{digits}d}" for k, garment in enumerate(taken)]
    write = partial(
        _write_scene, seed=seed, folder=folder, suffix=suffix, parameters=parameters, tables=tables
    )
    written: list[Path] = []

    def gather(paths: Iterable[Path]) -> None:
        for path in paths:
            written.append(path)
            if progress is not None:
                progress(len(written), count)

    if jobs == 1 or count == 1:
        gather(map(write, taken, range(count), names))
        return written
    # Spawned processes work on every platform, and inherit no threads in the middle of something.
    with ProcessPoolExecutor(
        min(jobs, count),
        mp_context=multiprocessing.get_context("spawn"),
        initializer=cv2.setNumThreads,
        initargs=(1,),
    ) as pool:
        try:
            gather(
                pool.map(write, taken, range(count), names, chunksize=max(1, min(16, count // (4 * jobs))))
            )
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)  # one scene cannot be made: make no more of them
            raise
    return written


def _write_scene(
    source: Garment,
    number: int,
    name: str,
    *,
    seed: int,
    folder: Path,
    suffix: str,
    parameters: SynthParameters,
    tables: Sequence[Photograph],
) -> Path:
    child = np.random.SeedSequence(seed, spawn_key=(number,))
    scene = make_scene(source, seed=child, parameters=parameters, tables=tables)
    return scene.write(folder, name, suffix=suffix)
