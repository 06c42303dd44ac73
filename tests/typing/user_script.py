"""A user's script: type checkers in their strictest mode must take what is right and refuse what is wrong.

Checked by mypy and pyright, never run. What must be refused carries an ignore comment; one that is not needed
is an error itself.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import foldrs
from foldrs.errors import FoldrsError, TemplateError
from foldrs.evaluation import load_scenes
from foldrs.parameters import GraspParameters, Parameters
from foldrs.plot import save_picture
from foldrs.synth import SynthParameters, make_scene


def pick_points(photo: Path) -> Iterator[tuple[str, NDArray[np.float64]]]:
    """Landmarks of the best pair within reach, and where they lie."""
    careful = Parameters(grasp=GraspParameters(clearance=3.0))
    result = foldrs.fit(photo, garment_type="pants", px_per_cm=4, method="best", parameters=careful)
    kind: str = result.garment_type
    sure: float = result.alternatives[0].probability
    print(kind, f"{sure:.0%}", result.template.landmarks["crotch"])
    if result.fold is not None:
        crease: NDArray[np.float64] = result.fold.axis_image
        print(crease.tolist())
    if result.accepted and result.grasp_pairs:
        best = result.grasp_pairs[0]
        yield from zip(best.landmarks, best.image, strict=True)
    save_picture(result, photo, "picture.png")
    result.save(photo.with_suffix(".json"))


def inputs_of_all_kinds(pixels: NDArray[np.uint8], mask: NDArray[np.bool_]) -> list[foldrs.FitResult]:
    """Everything `fit` takes."""
    outline = [[0.0, 0.0], [60.0, 0.0], [60.0, 40.0], [0.0, 40.0]]
    towels = foldrs.builtin_templates("towel")
    return [
        foldrs.fit("photo.jpg"),
        foldrs.fit(pixels, mask=mask),
        foldrs.fit(mask, templates=towels),
        foldrs.fit(outline, templates=["apron.json", Path("towel.json"), towels[0]]),
    ]


def own_template(path: Path) -> foldrs.Template | None:
    """A template file, or nothing and a word why."""
    try:
        template = foldrs.load_template(path)
    except TemplateError as error:
        print(error.field, error)
        return None
    foldrs.save_template(template, path)
    return template


def scenes(folder: Path) -> int:
    """Number of scenes in a folder, one more drawn into it."""
    one_scenario = SynthParameters(scenarios=("corner",))
    scene = make_scene(foldrs.builtin_templates()[0], seed=1, parameters=one_scenario)
    scene.write(folder, "scene")
    return len(load_scenes(folder))


def refused() -> None:
    """Mistakes a checker must find."""
    foldrs.fit("photo.jpg", method="bset")  # type: ignore[arg-type]
    foldrs.fit("photo.jpg", "pants")  # type: ignore[call-arg]
    foldrs.fit("photo.jpg", px_per_cm="4")  # type: ignore[arg-type]
    print(foldrs.fit("photo.jpg").garment_kind)  # type: ignore[attr-defined]
    foldrs.fit("photo.jpg").garment_type = "skirt"  # type: ignore[misc]
    foldrs.load_template({"type": "towel"})  # type: ignore[arg-type]


if __name__ == "__main__":
    try:
        for name, point in pick_points(Path(sys.argv[1])):
            print(name, np.round(point))
    except FoldrsError as problem:
        sys.exit(str(problem))
