"""A result as the shapes of a drawing: what every layer of its picture shows, in units of the view."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from foldrs import _core
from foldrs import _plot_panels as panels
from foldrs import _plot_pens as pens
from foldrs._plot_labels import place_labels
from foldrs.report.frame import Frame, Photo, cut_photo

if TYPE_CHECKING:
    from foldrs.evaluation.scenes import Scene
    from foldrs.image import RgbImage
    from foldrs.result import Alternative, FitResult, FittedTemplate, GraspMove

Points = NDArray[np.float64]

_WIDTH, _HEIGHT = 800, 600  # units of the view, and px of the largest photograph embedded
_TEMPLATE_SIZE = 240  # units of the view of a template
_MARGIN = 0.07  # share of a view kept free around what is drawn
_LIKELY = 0.05  # least probability of an alternative that the view makes room for
_QUALITY = 78  # of the photographs, of 100: half the bytes of 90, and no seams to see
_NAME_HEIGHT = 20.0  # units: readable in a picture of half its size
_LETTER = 0.56  # mean width of a letter, in its height
_LEAST_MOVE = 25.0  # units: shorter arrows would hide under the rings at their ends


@dataclass(frozen=True)
class Name:
    """A landmark: where it is, where its name is written, and whether it is in reach."""

    text: str
    x: float
    y: float
    text_x: float
    text_y: float
    accessible: bool
    grasped: bool


@dataclass(frozen=True)
class TemplateDrawing:
    """A fitted template with its fold axis: data of SVG paths."""

    width: int
    outline: str
    given: str
    """The template as given, where it differs; else empty."""
    kept: str
    flap: str
    axis: str


@dataclass(frozen=True)
class Explanation:
    """One explanation of the outline: data of SVG paths."""

    garment_type: str
    probability: float | None
    """None if the result tells none."""
    unfolded: str
    creases: tuple[str, ...]
    kept: str
    flap: str
    template: TemplateDrawing


@dataclass(frozen=True)
class Truth:
    """What is true of a scene: data of SVG paths."""

    outline: str
    unfolded: str
    creases: tuple[str, ...]


@dataclass(frozen=True)
class Drawing:
    """All layers of the picture of an image."""

    width: int
    height: int
    photo: Photo | None
    truth: Truth | None
    outline: str
    explanations: tuple[Explanation, ...]
    """The chosen one first."""
    names: tuple[Name, ...]
    grasp: tuple[tuple[float, float], ...]
    """The points of the best grasp pair; empty if none is in reach."""
    grasp_line: str
    moves: tuple[str, ...]
    """Arrows from where the points are picked to where they are put down to undo the fold."""


def draw(result: FitResult | None, image: RgbImage | None, scene: Scene | None) -> Drawing | None:
    """Draw a result over its photograph, with the truth if it is known; None if there is nothing to draw.

    Parameters
    ----------
    result : FitResult, optional
        None if the image could not be explained: then only photograph and truth are drawn.
    image : (h, w, 3) uint8, optional
        The photograph.
    scene : Scene, optional
        The truth.
    """
    shown = _extent(result, image, scene)
    if shown is None:
        return None
    frame = Frame.around(shown, _WIDTH, _HEIGHT, _MARGIN)
    pair = result.grasp_pairs[0] if result and result.grasp_pairs else None
    moves = _moves(result) if result else ()
    return Drawing(
        width=frame.width,
        height=frame.height,
        photo=None if image is None else cut_photo(image, frame, _QUALITY),
        truth=None if scene is None else _truth(scene, frame),
        outline=frame.outline(result.outline_image) if result else "",
        explanations=_explanations(result, frame) if result else (),
        names=_names(result, frame) if result else (),
        grasp=tuple(map(tuple, frame.view(pair.image).round(1).tolist())) if pair else (),
        grasp_line=frame.line(pair.image) if pair else "",
        moves=tuple(
            frame.line(np.array([move.pick, move.place]))
            for move in moves
            if np.linalg.norm(move.place - move.pick) * frame.scale > _LEAST_MOVE
        ),
    )


def _extent(result: FitResult | None, image: RgbImage | None, scene: Scene | None) -> Points | None:
    """Return points that the view must show."""
    points: list[Points] = []
    if scene is not None:
        points += [scene.outline_image, scene.unfolded_image]
    if result is not None:
        points += [result.outline_image, result.unfolded_outline_image]
        likely = (one for one in result.alternatives if one.probability >= _LIKELY)
        points += [one.unfolded_outline_image for one in likely]
        points += [move.place[None] for move in _moves(result)]
    if not points and image is not None:
        points = [np.array([[0.0, 0.0], image.shape[1::-1]])]
    return np.vstack(points) if points else None


def _moves(result: FitResult) -> tuple[GraspMove, ...]:
    """Return the moves of two arms that undo the last fold; none without a fold or a pair in reach."""
    return (result.unfolding.two_arms or ()) if result.unfolding else ()


def _explanations(result: FitResult, frame: Frame) -> tuple[Explanation, ...]:
    """Return the chosen explanation, all its folds with it, and the others with theirs."""
    kept, flap = _layers(result)
    given = result.original_template if panels.is_fitted(result) else None
    chosen = Explanation(
        garment_type=result.garment_type,
        probability=result.alternatives[0].probability if result.alternatives else None,
        unfolded=frame.outline(result.unfolded_outline_image),
        creases=tuple(frame.line(fold.axis_image) for fold in result.folds),
        kept=frame.outlines(kept),
        flap=frame.outlines(flap),
        template=_template(result.template, given),
    )
    return (chosen, *(_alternative(other, frame) for other in result.alternatives[1:]))


def _alternative(one: Alternative, frame: Frame) -> Explanation:
    kept, flap = _layers(one)
    return Explanation(
        garment_type=one.garment_type,
        probability=one.probability,
        unfolded=frame.outline(one.unfolded_outline_image),
        creases=tuple(frame.line(fold.axis_image) for fold in one.folds),
        kept=frame.outlines(kept),
        flap=frame.outlines(flap),
        template=_template(one.template, None),
    )


def _layers(one: FitResult | Alternative) -> tuple[list[Points], list[Points]]:
    """Return the layers that the last fold kept and those it turned over; none if a crease folds nothing."""
    layers = panels.folded_layers(one)
    return panels.kept_and_flap(layers) if layers else ([], [])


def _template(fitted: FittedTemplate, given: FittedTemplate | None) -> TemplateDrawing:
    axis = fitted.axis
    shown = [fitted.outline, *([] if axis is None else [axis]), *([given.outline] if given else [])]
    frame = Frame.around(np.vstack(shown), _TEMPLATE_SIZE, _TEMPLATE_SIZE, _MARGIN)
    layers = None if axis is None else panels.fold_once(fitted.outline, axis)
    flap = [_core.reflect(piece, axis) for piece in layers.flap] if layers and axis is not None else []
    return TemplateDrawing(
        width=frame.width,
        outline=frame.outline(fitted.outline),
        given=frame.outline(given.outline) if given else "",
        kept=frame.outlines(layers.kept) if layers else "",
        flap=frame.outlines(flap),
        axis="" if axis is None else frame.line(axis),
    )


def _truth(scene: Scene, frame: Frame) -> Truth:
    axis = [] if scene.axis_image is None else [scene.axis_image]
    return Truth(
        outline=frame.outline(scene.outline_image),
        unfolded=frame.outline(scene.unfolded_image),
        creases=tuple(frame.line(one) for one in scene.creases or axis),
    )


def _names(result: FitResult, frame: Frame) -> tuple[Name, ...]:
    """Place the landmarks' names where they hide neither each other nor the crease."""
    if not result.landmarks:
        return ()
    grasped = result.grasp_pairs[0].landmarks if result.grasp_pairs else ()
    texts = [pens.short_name(name) for name in result.landmarks]
    anchors = frame.view(np.array([mark.image for mark in result.landmarks.values()]))
    sizes = np.array([(_LETTER * _NAME_HEIGHT * len(text) + 6, 1.2 * _NAME_HEIGHT) for text in texts])
    creases = [pens.along(fold.axis_image) for fold in result.folds]
    crease = frame.view(np.vstack([np.empty((0, 2)), *creases]))
    corner = np.array([frame.width, frame.height], dtype=np.float64)
    centres = place_labels(anchors, sizes, crease, np.zeros(2), corner)
    places = np.hstack([anchors, centres]).round(1).tolist()
    return tuple(
        Name(text, x, y, text_x, text_y, mark.accessible, name in grasped)
        for text, (x, y, text_x, text_y), (name, mark) in zip(
            texts, places, result.landmarks.items(), strict=True
        )
    )
