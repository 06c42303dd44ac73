"""A result found in the view from above, carried back into the photograph."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from foldrs.camera.frames import ResultInFrame, carried_unfolding
from foldrs.camera.pose import Pose
from foldrs.camera.view import ViewFromAbove
from foldrs.image import RgbImage
from foldrs.result import FitResult, Fold, FromAbove

Points = npt.NDArray[np.float64]


def carried_back(
    flat: FitResult,
    view: ViewFromAbove,
    outline: Points,
    picture: RgbImage | None,
    robot_base: Pose | None,
) -> FitResult:
    """Carry a result into the photograph, and tell it on the table and in the robot's base.

    Parameters
    ----------
    flat : FitResult
        Found in the view from above; its image coordinates are px of the view.
    view : ViewFromAbove
    outline : (n, 2) array
        The outline as it was seen in the photograph, px.
    picture : (h, w, 3) uint8 array, optional
        The photograph as the view shows it.
    robot_base : Pose, optional
        Where the table lies in the robot's base.
    """
    carry = view.to_image
    in_base: Callable[[Points], Points] | None = None
    if robot_base is not None:
        base = robot_base

        def in_base(points: Points) -> Points:
            return base.of_table(view.to_table(points))

    def moved(fold: Fold) -> Fold:
        return replace(fold, axis_image=carry(fold.axis_image))

    marks = carry(np.array([mark.image for mark in flat.landmarks.values()]).reshape(-1, 2))
    return replace(
        flat,
        outline_image=outline,
        folds=tuple(moved(fold) for fold in flat.folds),
        unfolded_outline_image=carry(flat.unfolded_outline_image),
        landmarks={
            name: replace(mark, image=point)
            for (name, mark), point in zip(flat.landmarks.items(), marks, strict=True)
        },
        grasp_pairs=tuple(replace(pair, image=carry(pair.image)) for pair in flat.grasp_pairs),
        unfolding=None if flat.unfolding is None else carried_unfolding(flat.unfolding, carry),
        unfolding_plan=tuple(carried_unfolding(action, carry) for action in flat.unfolding_plan),
        alternatives=tuple(
            replace(
                other,
                folds=tuple(moved(fold) for fold in other.folds),
                unfolded_outline_image=carry(other.unfolded_outline_image),
            )
            for other in flat.alternatives
        ),
        candidate_creases=tuple(carry(crease) for crease in flat.candidate_creases),
        from_above=FromAbove(flat, picture, view.px_per_cm),
        table=ResultInFrame.of(flat, "cm", view.to_table),
        robot=None if in_base is None else ResultInFrame.of(flat, "m", in_base),
    )
