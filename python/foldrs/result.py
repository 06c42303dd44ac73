"""What :func:`foldrs.fit` returns, and its JSON form.

All image coordinates are (x, y) px with y down, an integer being the centre of a pixel; template coordinates
are in the template's own units (centimetres for the built-in ones). Outlines are closed implicitly.

Examples
--------
>>> import foldrs
>>> result = foldrs.fit([[0, 0], [200, 0], [200, 160], [100, 260], [0, 260]], garment_type="towel")
>>> chosen = result.alternatives[0]
>>> bool((chosen.fold.axis_image == result.fold.axis_image).all())
True
>>> result.template.axis.shape, result.unfolded_outline_image.shape[1]
((2, 2), 2)
>>> result.to_dict()["garment_type"]
'towel'
"""

from __future__ import annotations

import json
import math
import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from foldrs.whole_files import write_whole

if TYPE_CHECKING:
    from foldrs.camera.frames import ResultInFrame
    from foldrs.image import RgbImage
    from foldrs.stages import FittingPass

SCHEMA = 1
"""Version of the JSON form."""

Points = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class FittedTemplate:
    """A template with its fold axis on it, in template units."""

    outline: Points
    """(n, 2) corners."""
    landmarks: Mapping[str, Points]
    """Named points of the outline, (2,) each."""
    axis: Points | None
    """(2, 2) end points of the fold axis, of several folds that of the first made; the part on its left
    (from x towards y) is the flap. None if there is no fold."""


@dataclass(frozen=True, eq=False)
class Fold:
    """One fold: the crease in the image and the axis on the fitted template.

    Both lie where the fold was made, in the frame of the part of the garment that no fold turned over: the
    garment unfolded again where it lies, and folded over all creases in their order, is what is seen. Of the
    last fold that is the crease seen; an earlier one may have been turned over since, in part or whole.
    """

    axis_image: Points
    """(2, 2) px."""
    axis_template: Points
    """(2, 2) template units; of a later fold it runs over the template folded by the earlier ones."""
    flap_on_top: bool | None = None
    """Whether the flap lies on top of the kept part; None where it cannot be told. Of one fold the
    joint fit calls the smaller part the flap: which of the two was turned over cannot be seen."""


@dataclass(frozen=True, eq=False)
class LandmarkInImage:
    """Where a landmark lies in the image, under a layer or not."""

    image: Points
    """(2,) px."""
    accessible: bool
    """Whether it lies on the outline with no double layer near it (section 3.2), so far as can be told: with
    method "best" if `reach` is no less than `GraspParameters.likely`."""
    reach: float | None = None
    """Probability of that, and of its lying within `GraspParameters.margin` of where it is told to; None
    with method "paper", which has no doubts."""


@dataclass(frozen=True, eq=False)
class GraspPair:
    """Two accessible landmarks to grasp the garment by."""

    landmarks: tuple[str, str]
    image: Points
    """(2, 2) px, in the order of the names."""
    probability: float | None = None
    """Probability that both are within reach; None with method "paper"."""


@dataclass(frozen=True, eq=False)
class GraspMove:
    """Where to pick one point of the garment, and where to put it down to undo the fold."""

    landmark: str
    pick: Points
    """(2,) px."""
    place: Points
    """(2,) px: the mirror image of `pick` over the crease."""
    clearance: float
    """Distance of `pick` from the nearest double layer, template units; infinite if there is none."""


@dataclass(frozen=True, eq=False)
class UnfoldingAction:
    """How to undo one fold: with two arms, and with one."""

    two_arms: tuple[GraspMove, GraspMove] | None
    """The moves of the best grasp pair; None if no pair is accessible."""
    one_arm: GraspMove | None
    """The move of the accessible landmark that may be expected to turn the most cloth: its distance from the
    crease times its `reach`, where there is one, is largest. None if no landmark is accessible."""


@dataclass(frozen=True, eq=False)
class Alternative:
    """One of the distinct explanations of the outline."""

    garment_type: str
    """Kind of garment it takes the outline for."""
    probability: float
    """How probable it is, 0 to 1; those of all explanations told sum to at most 1."""
    folds: tuple[Fold, ...]
    """First made first; empty for a garment that lies unfolded."""
    template: FittedTemplate
    """The template fitted as this explanation has it, with its axis, template units."""
    unfolded_outline_image: Points
    """(n, 2) px: the garment unfolded again where it lies, as this explanation has it."""

    @property
    def fold(self) -> Fold | None:
        """The last fold made; None without any."""
        return self.folds[-1] if self.folds else None


@dataclass(frozen=True, eq=False)
class FromAbove:
    """The garment as seen from straight above, where the camera looks at the table at an angle."""

    result: FitResult
    """The same answer; its image coordinates are px of this view."""
    picture: RgbImage | None
    """(h, w, 3) uint8: the photograph as seen from above, the part around the garment; None if there is
    none."""
    px_per_cm: float
    """Scale of the view."""


@dataclass(frozen=True, eq=False)
class FitResult:
    """A folded garment explained.

    `original_template` holds the axis the matching stage found on the template as given, `template` the
    fitted template with its axis.
    """

    garment_type: str
    """Kind of garment, as the template that explains the outline best has it."""
    accepted: bool
    """Whether the folds explain the outline better than the unfolded template does; False without a fold."""
    matching_cost: float
    """How ill the fitted template, folded, explains the outline: less is better; comparable within one method
    only. Of method "paper" a cost without unit, not negative. Of method "best" minus the log evidence, in
    nats, which may be negative."""
    original_matching_cost: float
    """The same of the template as given (MC_m of eq. 5), in the unit of `matching_cost`; method "best" fits
    at once, so it is the same number there."""
    outline_image: Points
    """(n, 2) px: the outline of the garment as segmented, or as given."""
    folds: tuple[Fold, ...]
    """First made first; empty for a garment that lies unfolded."""
    original_template: FittedTemplate
    template: FittedTemplate
    unfolded_outline_image: Points
    """(n, 2) px: the garment unfolded again where it lies."""
    landmarks: Mapping[str, LandmarkInImage]
    """Where every landmark of the template lies, by its name, in the template's order."""
    grasp_pairs: tuple[GraspPair, ...]
    """Accessible pairs, best first: the most probable ones, of about equally probable ones
    (`GraspParameters.as_good`) those that the template lists first."""
    unfolding: UnfoldingAction | None
    """How to undo the last fold; None if there is none."""
    unfolding_plan: tuple[UnfoldingAction, ...]
    """How to undo all folds, one after the other, the last made first."""
    alternatives: tuple[Alternative, ...]
    """Distinct explanations, the chosen one first; probabilities sum to at most 1."""
    image: str = ""
    """Name of the image file; empty for arrays."""
    seconds: float = 0.0
    """Wall time, reading the image included."""
    timings: Mapping[str, float] = field(default_factory=dict)
    """Seconds by stage."""
    candidate_creases: tuple[Points, ...] = ()
    """(2, 2) px each: the sides of the outline considered as crease (section 2.1.2); not in the JSON form."""
    stages: tuple[FittingPass, ...] = ()
    """Every intermediate outline of the published method, pass by pass, the template as given first; empty
    for other methods; not in the JSON form."""
    from_above: FromAbove | None = None
    """The view in which the answer was found, if the table's plane is known; not in the JSON form. `stages`
    are in its px."""
    table: ResultInFrame | None = None
    """The same on the table, in cm, if its plane is known."""
    robot: ResultInFrame | None = None
    """The same in the robot's base, in metres, if it is given."""

    @property
    def fold(self) -> Fold | None:
        """The last fold made; None if the garment lies unfolded."""
        return self.folds[-1] if self.folds else None

    def to_dict(self) -> dict[str, Any]:
        """Return the result as plain numbers, lists and dictionaries: the JSON form."""
        return self._in_image() | {
            name: frame.to_dict() for name, frame in (("table", self.table), ("robot", self.robot)) if frame
        }

    def _in_image(self) -> dict[str, Any]:
        return {
            "schema": SCHEMA,
            "image": self.image,
            "seconds": round(self.seconds, 6),
            "garment_type": self.garment_type,
            "accepted": self.accepted,
            "matching_cost": self.matching_cost,
            "original_matching_cost": self.original_matching_cost,
            "outline_image": _plain(self.outline_image),
            "fold": _crease(self.fold),
            "folds": [_fold(fold) for fold in self.folds],
            "original_template": _template(self.original_template),
            "template": _template(self.template),
            "unfolded_outline_image": _plain(self.unfolded_outline_image),
            "landmarks": {
                name: {
                    "image": _plain(mark.image),
                    "accessible": mark.accessible,
                    "reach": plain_probability(mark.reach),
                }
                for name, mark in self.landmarks.items()
            },
            "grasp_pairs": [
                {
                    "landmarks": list(p.landmarks),
                    "image": _plain(p.image),
                    "probability": plain_probability(p.probability),
                }
                for p in self.grasp_pairs
            ],
            "unfolding": None if self.unfolding is None else action_to_dict(self.unfolding),
            "unfolding_plan": [action_to_dict(action) for action in self.unfolding_plan],
            "alternatives": [
                {
                    "garment_type": a.garment_type,
                    "probability": a.probability,
                    "fold": _crease(a.fold),
                    "folds": [_fold(fold) for fold in a.folds],
                    "template": _template(a.template),
                    "unfolded_outline_image": _plain(a.unfolded_outline_image),
                }
                for a in self.alternatives
            ],
            "timings": {stage: round(seconds, 6) for stage, seconds in self.timings.items()},
        }

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the JSON form, whole or not at all."""
        write_whole(Path(path), json.dumps(self.to_dict(), separators=(",", ":")).encode())


def _plain(points: Points, digits: int = 4) -> list[Any]:
    rounded: list[Any] = np.round(points, digits).tolist()
    return rounded


def plain_probability(probability: float | None) -> float | None:
    """Return a probability, where there is one, in the JSON form."""
    return None if probability is None else round(probability, 4)


def _crease(fold: Fold | None) -> dict[str, Any] | None:
    return None if fold is None else {"axis_image": _plain(fold.axis_image)}


def _fold(fold: Fold) -> dict[str, Any]:
    return {
        "axis_image": _plain(fold.axis_image),
        "axis_template": _plain(fold.axis_template),
        "flap_on_top": fold.flap_on_top,
    }


def action_to_dict(action: UnfoldingAction, digits: int = 4) -> dict[str, Any]:
    """Return an unfolding action in the JSON form, points rounded to so many decimals."""
    both, one = action.two_arms, action.one_arm
    return {
        "two_arms": None if both is None else [_move(move, digits) for move in both],
        "one_arm": None if one is None else _move(one, digits),
    }


def _move(move: GraspMove, digits: int) -> dict[str, Any]:
    return {
        "landmark": move.landmark,
        "pick": _plain(move.pick, digits),
        "place": _plain(move.place, digits),
        "clearance": round(move.clearance, 4) if math.isfinite(move.clearance) else None,
    }


def _template(template: FittedTemplate) -> dict[str, Any]:
    return {
        "outline": _plain(template.outline),
        "landmarks": {name: _plain(point) for name, point in template.landmarks.items()},
        "axis": None if template.axis is None else _plain(template.axis),
    }
