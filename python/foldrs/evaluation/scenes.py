"""Scenes: a photograph (or an outline) of a folded garment, and what is true of it.

A folder of scenes holds NAME.json, the ground truth, and NAME.jpg or another image format. The fields read
are ``type``, ``px_per_cm``, ``axis_garment``, ``outline_garment``, ``outline_image``, ``unfolded_image`` and
``landmarks`` (NAME: ``garment``, ``image``, ``on_outline``, ``accessible``); of scenes folded twice also
``second_fold.axis_image`` and ``creases_image``; of scenes not folded ``axis_garment`` is null; ``garment``
and ``scenario`` for the record, ``axis_image`` to be drawn. The garment frame is the unfolded garment, the
image frame the picture; both in px of one scale, unless NAME.homography.json (from image px to cm on the
table) tells that the picture was taken at an angle. NAME.depth.tiff, .png or .npy is a depth image.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from foldrs.camera import TablePlane, load_homography
from foldrs.errors import ParameterError

Points = NDArray[np.float64]

_DEPTHS = (".depth.tiff", ".depth.png", ".depth.npy")
_IMAGES = (".jpg", ".jpeg", ".png", ".webp", ".tif", ".tiff")


@dataclass(frozen=True, eq=False)
class TrueLandmark:
    """Where a landmark truly is."""

    garment: Points
    """(2,) px on the unfolded garment."""
    image: Points
    """(2,) px in the picture, seen or hidden."""
    on_outline: bool
    """Whether it lies on the folded outline."""
    accessible: bool
    """Whether it lies there with no double layer near it."""


@dataclass(frozen=True, eq=False)
class Scene:
    """The ground truth of one folded garment."""

    name: str
    garment_type: str
    garment: str
    """Which garment of its kind."""
    scenario: str
    """How the fold line was drawn."""
    px_per_cm: float
    outline_garment: Points
    """(n, 2) px: outline of the unfolded garment."""
    axis_garment: Points | None
    """(2, 2) px: the fold axis (of two folds the first), its ends on that outline; None if nothing is
    folded."""
    outline_image: Points
    """(n, 2) px: the outline seen."""
    unfolded_image: Points
    """(n, 2) px: the garment unfolded again where it lies."""
    landmarks: Mapping[str, TrueLandmark]
    creases: tuple[Points, ...] = ()
    """(2, 2) px each: of a scene folded twice the creases seen in the image; empty for one fold."""
    image: Path | None = None
    """The photograph; None if the outline is all there is."""
    axis_image: Points | None = None
    """(2, 2) px: the axis in the image, to be drawn; None if the truth does not tell."""
    plane: TablePlane | None = None
    """The table, of a picture taken at an angle."""
    depth: Path | None = None
    """The depth image, if there is one."""

    @property
    def folds(self) -> int:
        """Number of folds: none, one or two."""
        if self.axis_garment is None:
            return 0
        return 2 if self.creases else 1


def load_scenes(folder: Path) -> list[Scene]:
    """All scenes of a folder by name; JSON files that hold no ground truth are passed over.

    Raises
    ------
    ParameterError
        If the folder is missing or holds no scene, or if a scene lacks a field.
    """
    if not folder.is_dir():
        raise ParameterError(f"{folder}: there is no such folder of scenes")
    scenes = []
    for path in sorted(folder.glob("*.json")):
        try:
            truth = json.loads(path.read_text(encoding="utf-8"))
        except (OSError, ValueError) as error:
            raise ParameterError(f"{path}: cannot be read as JSON ({error})") from error
        if isinstance(truth, dict) and "axis_garment" in truth:
            scenes.append(scene_from_truth(truth, path))
    if not scenes:
        raise ParameterError(
            f"{folder}: no scenes; a scene is NAME.json with axis_garment, and NAME.jpg or NAME.png"
        )
    return scenes


def scene_from_truth(truth: Mapping[str, Any], path: Path) -> Scene:
    """Read the content of a scene's JSON file `path`, beside which the photograph lies."""
    try:
        second = truth.get("second_fold")
        creases = [second["axis_image"], *truth["creases_image"]] if second else []
        scene = Scene(
            name=path.stem,
            garment_type=str(truth["type"]),
            garment=str(truth.get("garment", "")),
            scenario=str(truth.get("scenario", "")),
            px_per_cm=float(truth["px_per_cm"]),
            outline_garment=_points(truth["outline_garment"], 3),
            axis_garment=None if truth["axis_garment"] is None else _points(truth["axis_garment"], 2),
            outline_image=_points(truth["outline_image"], 3),
            unfolded_image=_points(truth["unfolded_image"], 3),
            landmarks={
                name: TrueLandmark(
                    _points([mark["garment"]], 1)[0],
                    _points([mark["image"]], 1)[0],
                    bool(mark["on_outline"]),
                    bool(mark["accessible"]),
                )
                for name, mark in truth["landmarks"].items()
            },
            creases=tuple(_points(crease, 2) for crease in creases),
            image=_image_beside(path),
            axis_image=_points(truth["axis_image"], 2) if "axis_image" in truth else None,
            plane=_plane_beside(path),
            depth=_first_beside(path, _DEPTHS),
        )
    except KeyError as error:
        raise ParameterError(f"{path}: not the ground truth of a scene, field {error} is missing") from error
    except (TypeError, ValueError, AttributeError) as error:
        raise ParameterError(f"{path}: not the ground truth of a scene ({error})") from error
    if not (np.isfinite(scene.px_per_cm) and scene.px_per_cm > 0):
        raise ParameterError(f"{path}: px_per_cm must be a positive number, not {scene.px_per_cm}")
    return scene


def _image_beside(path: Path) -> Path:
    """Find the photograph of a scene; if there is none, the name it should have, for the error to tell."""
    return _first_beside(path, _IMAGES) or path.with_suffix(_IMAGES[0])


def _plane_beside(path: Path) -> TablePlane | None:
    """Read the homography of a scene, if there is one."""
    file = _first_beside(path, (".homography.json",))
    return None if file is None else load_homography(file)


def _first_beside(path: Path, suffixes: Sequence[str]) -> Path | None:
    """First file that has the scene's name and one of the suffixes."""
    found = (path.with_suffix(suffix) for suffix in suffixes)
    return next((file for file in found if file.is_file()), None)


def _points(values: object, least: int) -> Points:
    points = np.array(values, dtype=np.float64)
    if points.ndim != 2 or points.shape[1] != 2 or len(points) < least or not np.isfinite(points).all():
        raise ValueError(f"expected at least {least} finite points (x, y), got shape {points.shape}")
    return points
