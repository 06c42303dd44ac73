"""Scenes pictured at an angle, measured in the view from above: there a centimetre is one everywhere."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from foldrs.evaluation.scenes import Scene

Points = NDArray[np.float64]


def scene_from_above(scene: Scene) -> Scene:
    """Carry the truth about a scene into the view from above, in px of the scene's scale."""
    return replace(
        scene,
        outline_image=_above(scene, scene.outline_image),
        unfolded_image=_above(scene, scene.unfolded_image),
        landmarks={
            name: replace(mark, image=_above(scene, mark.image)) for name, mark in scene.landmarks.items()
        },
        creases=tuple(_above(scene, crease) for crease in scene.creases),
        plane=None,
    )


def prediction_from_above(scene: Scene, prediction: Mapping[str, Any]) -> dict[str, Any]:
    """Carry the image points of a prediction, in its JSON form, into the view from above of its scene.

    Raises
    ------
    CalibrationError
        Some of them lie beyond the table's horizon.
    """

    def fold(one: Mapping[str, Any]) -> dict[str, Any]:
        return {**one, "axis_image": _above(scene, one["axis_image"])}

    return {
        **prediction,
        "outline_image": _above(scene, prediction["outline_image"]),
        "unfolded_outline_image": _above(scene, prediction["unfolded_outline_image"]),
        "fold": None if prediction["fold"] is None else fold(prediction["fold"]),
        "folds": [fold(one) for one in prediction["folds"]],
        "landmarks": {
            name: {**mark, "image": _above(scene, mark["image"])}
            for name, mark in prediction["landmarks"].items()
        },
        "grasp_pairs": [
            {**pair, "image": _above(scene, pair["image"])} for pair in prediction["grasp_pairs"]
        ],
    }


def _above(scene: Scene, points: Any) -> Points:
    """Carry points of any shape (..., 2)."""
    if scene.plane is None:
        return np.asarray(points, dtype=np.float64)
    image = np.asarray(points, dtype=np.float64)
    return scene.plane.to_table(image.reshape(-1, 2)).reshape(image.shape) * scene.px_per_cm
