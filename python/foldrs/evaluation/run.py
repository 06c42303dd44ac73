"""Protocols: which templates a scene is matched with, and many scenes at a time.

========== ================================================================================================
synthetic  a template folded virtually, matched with itself; its outline is given and the scale is known
own        the scene's own garment, unfolded, is the template
generic    the kind is known: the built-in or given templates of that kind
open       nothing is known: all templates compete
========== ================================================================================================
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal, TypeAlias, get_args

import numpy as np

from foldrs import _core
from foldrs.errors import FoldrsError
from foldrs.evaluation.axes import template_distance
from foldrs.evaluation.kinds import Kind
from foldrs.evaluation.measures import SceneMeasures, failed, measure
from foldrs.evaluation.scenes import Scene
from foldrs.pipeline import Method, fit
from foldrs.template import Template

Protocol: TypeAlias = Literal["synthetic", "own", "generic", "open"]
PROTOCOLS: tuple[Protocol, ...] = get_args(Protocol)


@dataclass(frozen=True)
class Evaluation:
    """How scenes are evaluated: what is the same for all of them."""

    protocol: Protocol
    templates: Sequence[Template]
    """All templates there are. They tell what a kind's landmarks and symmetries are in every protocol."""
    px_per_cm: float | None = None
    """Known scale; None to have it found."""
    method: Method = "best"
    true_outlines: bool = False
    """Give the true outline instead of the photograph: the matching alone, without the segmentation."""
    out: Path | None = None
    """Folder for the predictions, NAME.json each."""

    def run(self, scene: Scene, itself: Template | None = None) -> SceneMeasures:
        """Fit one scene, write its prediction and measure it; `itself` is what a synthetic scene folds."""
        try:
            return self._run(scene, itself)
        except FoldrsError as error:
            return failed(scene, str(error))

    def _run(self, scene: Scene, itself: Template | None) -> SceneMeasures:
        of_kind = [t for t in self.templates if t.garment_type == scene.garment_type]
        if itself is not None:
            competing, of_kind = [itself], of_kind or [itself]
        elif self.protocol == "own":
            own = own_template(scene, of_kind)
            competing, of_kind = [own], of_kind or [own]
        else:
            competing = list(self.templates) if self.protocol == "open" else of_kind
        kind = Kind.of(of_kind, scene.landmarks)
        result = fit(
            scene.outline_image if self.true_outlines or scene.image is None else scene.image,
            garment_type=None if self.protocol == "open" else scene.garment_type,
            templates=competing,
            px_per_cm=self.px_per_cm,
            method=self.method,
        )
        if self.out is not None:
            result.save(self.out / f"{scene.name}.json")
        row = measure(scene, result.to_dict(), kind)
        right_ones = [t for t in competing if t.garment_type == scene.garment_type]
        return replace(row, template_distance_cm=template_distance(scene, right_ones, kind))


def run_all(
    evaluation: Evaluation,
    scenes: Sequence[Scene] | Sequence[tuple[Scene, Template]],
    jobs: int | None = None,
) -> Iterator[SceneMeasures]:
    """Measure all scenes, yielding in the order they are ready; virtual ones come with their template."""
    pairs = [(scene, None) if isinstance(scene, Scene) else scene for scene in scenes]
    threads = _core.set_threads(jobs)
    with ThreadPoolExecutor(max(1, min(jobs or threads, len(pairs)))) as pool:
        for done in as_completed([pool.submit(evaluation.run, *pair) for pair in pairs]):
            yield done.result()


def own_template(scene: Scene, like: Sequence[Template]) -> Template:
    """Make a template, in cm, of the scene's own garment.

    Landmark order, symmetric pairs and grasp pairs are those of the first of the templates `like` it. Without
    any, the landmarks keep the scene's order, and every two of them are a grasp pair.

    Raises
    ------
    TemplateError
        If the garment's outline or landmarks make no template.
    """
    names = list(scene.landmarks)
    symmetry: Sequence[tuple[str, str]] = ()
    grasp_pairs: Sequence[tuple[str, str]] = [(a, b) for i, a in enumerate(names) for b in names[i + 1 :]]
    if like:
        names = [name for name in like[0].landmarks if name in scene.landmarks]
        symmetry = _among(like[0].symmetry, names)
        grasp_pairs = _among(like[0].grasp_pairs, names)
    marks = np.array([scene.landmarks[name].garment for name in names], dtype=np.float64).reshape(-1, 2)
    on_outline, _, _ = _core.nearest_on_outline(scene.outline_garment, marks)
    return Template(
        name=scene.name,
        garment_type=scene.garment_type,
        units="cm",
        outline=scene.outline_garment / scene.px_per_cm,
        landmarks=dict(zip(names, on_outline / scene.px_per_cm, strict=True)),
        symmetry=tuple(symmetry),
        grasp_pairs=tuple(grasp_pairs),
    )


def _among(pairs: Sequence[tuple[str, str]], names: Collection[str]) -> list[tuple[str, str]]:
    return [(a, b) for a, b in pairs if a in names and b in names]
