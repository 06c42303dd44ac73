"""The demonstration behind ``foldrs demo``: a scene of known truth, drawn, explained and measured.

It needs nothing but the package: a built-in template is varied, folded and pictured by :mod:`foldrs.synth`,
the picture goes to :func:`foldrs.fit` as a photograph would, and :mod:`foldrs.evaluation` compares the answer
with what is true of the picture.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from rich.table import Table

from foldrs._fit_told import pair_told
from foldrs.evaluation.kinds import Kind
from foldrs.evaluation.measures import GRASP_MARGIN_CM, RIGHT, SceneMeasures, measure
from foldrs.evaluation.scenes import load_scenes
from foldrs.pipeline import fit
from foldrs.plot import save_picture
from foldrs.result import FitResult
from foldrs.synth import SynthParameters, make_scene
from foldrs.template import builtin_templates

NAME = "t-shirt"
"""Name of the files, and the kind of garment drawn."""
SEED = 18
"""Of the scene: a T-shirt folded across, its sleeve and hem in sight."""
SCENE = SynthParameters(
    px_per_cm=5.0,
    scenarios=("random", "landmarks"),
    flap_fraction=(0.2, 0.4),
    under=0.0,
    mirrored=0.0,
    tables=("wood",),
    cloths=("stripes", "print"),
)
"""What the scene is like: the flap on top, so that a reader sees in the picture what was done."""


@dataclass(frozen=True, eq=False)
class Demo:
    """What the demonstration found and wrote."""

    result: FitResult
    """The answer."""
    measures: SceneMeasures
    """How good it is."""
    image: Path
    """The picture that was explained; the truth lies beside it."""
    answer: Path
    """The result in its JSON form."""
    picture: Path
    """The picture of the result."""


def run_demo(folder: str | Path) -> Demo:
    """Draw a folded T-shirt, explain the picture, and compare with the truth.

    Parameters
    ----------
    folder : str or Path
        Where to write; made if missing. The scene goes to ``scene/``: image, mask, and the truth as JSON.

    Raises
    ------
    FoldrsError
        If the picture cannot be explained at all.
    """
    folder = Path(folder)
    templates = builtin_templates(NAME)
    make_scene(templates[0], seed=SEED, parameters=SCENE).write(folder / "scene", NAME)
    image = folder / "scene" / f"{NAME}.jpg"
    (scene,) = (one for one in load_scenes(folder / "scene") if one.name == NAME)

    result = fit(image)  # neither the kind nor the scale is given
    answer, picture = folder / f"{NAME}.json", folder / f"{NAME}.png"
    result.save(answer)
    save_picture(result, image, picture)
    measures = measure(scene, result.to_dict(), Kind.of(templates, scene.landmarks))
    return Demo(result, measures, image, answer, picture)


def table(demo: Demo) -> Table:
    """Tabulate what was found, what makes it right, and whether it is; one row a question."""
    result, measures = demo.result, demo.measures
    shown = Table(box=None, pad_edge=False, header_style="bold")
    for heading in ("", "found", "right if", ""):
        shown.add_column(heading)

    shown.add_row("kind", result.garment_type, measures.garment_type, _verdict(measures.type_right))
    if measures.axis_error is not None:
        shown.add_row(
            "fold axis", f"dA = {measures.axis_error:.3f}", f"dA < {RIGHT}", _verdict(measures.right)
        )
    if measures.landmarks_cm:
        mean = float(np.mean(measures.landmarks_cm))
        shown.add_row("landmarks", f"{mean:.1f} cm off, mean of {len(measures.landmarks_cm)}", "")
    reach = f"in reach, within {GRASP_MARGIN_CM:g} cm"
    shown.add_row("grasp pair", pair_told(result), reach, _verdict(measures.pair_right))
    shown.add_row("seconds", f"{result.seconds:.2f}", "")
    return shown


def _verdict(right: bool | None) -> str:
    return "[green]right[/]" if right else "[red]wrong[/]"
