"""Protocols: which templates a scene is matched with, and many scenes at a time.

========== ================================================================================================
synthetic  a template folded virtually, matched with itself; its outline is given and the scale is known
own        the scene's own garment, unfolded, is the template
generic    the kind is known: the built-in or given templates of that kind
open       nothing is known: all templates compete
========== ================================================================================================
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Sequence
from concurrent.futures import as_completed
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal, TypeAlias, get_args

import numpy as np

from foldrs import _core
from foldrs._workers import fitting_threads
from foldrs.errors import FoldrsError
from foldrs.evaluation.axes import template_distance
from foldrs.evaluation.kinds import Kind
from foldrs.evaluation.measures import SceneMeasures, failed, measure
from foldrs.evaluation.scenes import Scene
from foldrs.evaluation.search import missed_nats
from foldrs.joint_fit import Folds
from foldrs.pipeline import Method, fit
from foldrs.result import FitResult
from foldrs.scale import Reference
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
    """Known scale; None to have it found. Scenes with a homography need none."""
    method: Method = "best"
    folds: Folds | Literal["given"] = "given"
    """How many folds to undo; as many as there truly are if that is given as the kind is."""
    true_outlines: bool = False
    """Give the true outline instead of the photograph: the matching alone, without the segmentation."""
    calibrated: bool = True
    """Use the homographies and depth images that lie beside the scenes; they are always measured by them."""
    reference: Reference | None = None
    """A marker or sheet in the photographs that tells the table's plane, instead of the homographies."""
    search: bool = False
    """Also fit from the truth, to see what the search misses (one fold, true outlines, method best)."""
    out: Path | None = None
    """Folder for the predictions, NAME.json each."""
    watch: Callable[[Scene, FitResult | None, SceneMeasures], None] | None = None
    """Is shown every scene measured, from several threads; the result is None where there is none."""

    def run(self, scene: Scene, itself: Template | None = None) -> SceneMeasures:
        """Fit one scene, write its prediction and measure it; `itself` is what a synthetic scene folds."""
        row, result = failed(scene, ""), None
        try:
            competing, kind = self._competing(scene, itself)
            of_kind = [template for template in competing if template.garment_type == scene.garment_type]
            row = replace(row, template_distance_cm=template_distance(scene, of_kind, kind))
            result = self._predict(scene, competing)
            measured = measure(scene, result.to_dict(), kind)
            row = replace(measured, template_distance_cm=row.template_distance_cm)
            if self.search:
                missed = missed_nats(scene, result, of_kind, kind, self.px_per_cm)
                row = replace(row, missed_nats=missed)
        except FoldrsError as error:
            row = replace(row, error=str(error))
        if self.watch is not None:
            self.watch(scene, result, row)
        return row

    def _competing(self, scene: Scene, itself: Template | None) -> tuple[list[Template], Kind]:
        """Return the templates that compete for a scene, and what there is to know of its kind."""
        of_kind = [template for template in self.templates if template.garment_type == scene.garment_type]
        if itself is None and self.protocol == "own":
            itself = own_template(scene, of_kind)
        if itself is not None:
            return [itself], Kind.of(of_kind or [itself], scene.landmarks)
        competing = list(self.templates) if self.protocol == "open" else of_kind
        return competing, Kind.of(of_kind, scene.landmarks)

    def _predict(self, scene: Scene, competing: Sequence[Template]) -> FitResult:
        """Fit a scene; the JSON form of the result replaces what an earlier run has written."""
        path = None if self.out is None else self.out / f"{scene.name}.json"
        if path is not None:
            path.unlink(missing_ok=True)
        source = None if self.true_outlines else scene.image
        plane = self.reference or (scene.plane if self.calibrated else None)
        result = fit(
            scene.outline_image if source is None else source,
            garment_type=None if self.protocol == "open" else scene.garment_type,
            templates=competing,
            px_per_cm=self.px_per_cm if plane is None else None,
            folds=scene.folds if self.folds == "given" else self.folds,
            method=self.method,
            table=plane,
            depth=scene.depth if self.calibrated and source is not None else None,
        )
        if path is not None:
            result.save(path)
        return result


def run_all(
    evaluation: Evaluation,
    scenes: Sequence[Scene] | Sequence[tuple[Scene, Template]],
    jobs: int | None = None,
) -> Iterator[SceneMeasures]:
    """Measure all scenes, yielding in the order they are ready; virtual ones come with their template."""
    pairs = [(scene, None) if isinstance(scene, Scene) else scene for scene in scenes]
    threads = _core.set_threads(jobs)
    with fitting_threads(max(1, min(jobs or threads, threads, len(pairs)))) as pool:
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
