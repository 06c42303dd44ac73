"""One scene, from a flat garment and a seed."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from foldrs.errors import FoldrsError, ParameterError
from foldrs.synth.camera import TableCamera, draw_camera, straight_above
from foldrs.synth.depth import draw_depth
from foldrs.synth.fold_lines import draw_fold, draw_second_fold
from foldrs.synth.garment import FlatGarment, Garment, Photograph, checked, vary
from foldrs.synth.layers import Fold, Layer, fold_again, fold_flat
from foldrs.synth.parameters import SynthParameters
from foldrs.synth.pose import Pose, draw_pose
from foldrs.synth.raster import LayerMasks, coverage, draw_masks
from foldrs.synth.render import render
from foldrs.synth.truth import describe, seen_at_an_angle, seen_outline
from foldrs.whole_files import write_whole

_TRIES = 40
"""Garments and folds drawn for one scene before it is given up."""

_JPEG_QUALITY = 95

_CAMERA = 1 << 20
"""Number of the camera's random sequence among the children of a scene's."""


@dataclass(frozen=True, eq=False)
class Scene:
    """A picture of a folded garment and what is true of it.

    Attributes
    ----------
    image : ndarray of shape (height, width, 3), uint8
        RGB.
    mask : ndarray of shape (height, width), uint8
        255 where at least half of a pixel is cloth, else 0.
    truth : dict
        The ground truth, see :mod:`foldrs.synth.truth`.
    camera : TableCamera
        What pictured it.
    depth : ndarray of shape (height, width), float32, optional
        Depth image, metres.
    """

    image: NDArray[np.uint8]
    mask: NDArray[np.uint8]
    truth: dict[str, Any]
    camera: TableCamera
    depth: NDArray[np.float32] | None = None

    @property
    def tilted(self) -> bool:
        """Whether the camera looks at an angle."""
        return "tilt_deg" in self.truth

    def write(self, folder: str | Path, name: str, *, suffix: str = ".jpg") -> Path:
        """Write ``NAME.jpg`` (or another kind of image), ``NAME.mask.png`` and ``NAME.json``.

        Of a camera that looks at an angle also ``NAME.homography.json``, from image px to cm on the table;
        of that and of one with depth ``NAME.camera.json``, its calibration, and ``NAME.depth.tiff``, metres
        as floats. Each file appears whole or not at all, the JSON of the scene last.

        Parameters
        ----------
        folder : str or Path
            Where to; made if missing.
        name : str
            The scene's name; becomes its ``id``.
        suffix : {".jpg", ".png"}
            Kind of image; PNG keeps every grey level.

        Returns
        -------
        Path
            The JSON file.

        Raises
        ------
        ParameterError
            If the suffix is no kind of image known here.
        """
        check_suffix(suffix)
        folder = Path(folder)
        folder.mkdir(parents=True, exist_ok=True)
        quality = [cv2.IMWRITE_JPEG_QUALITY, _JPEG_QUALITY] if suffix == ".jpg" else []
        picture = cv2.imencode(suffix, np.ascontiguousarray(self.image[..., ::-1]), quality)[1]
        write_whole(folder / f"{name}{suffix}", picture.tobytes())
        write_whole(folder / f"{name}.mask.png", cv2.imencode(".png", self.mask)[1].tobytes())
        size = (self.image.shape[1], self.image.shape[0])
        if self.tilted:
            homography = {
                "from": "image px",
                "to": "table cm",
                "homography": np.linalg.inv(self.camera.table_to_image).tolist(),
            }
            write_whole(folder / f"{name}.homography.json", json.dumps(homography).encode())
        if self.tilted or self.depth is not None:
            write_whole(folder / f"{name}.camera.json", json.dumps(self.camera.written(size)).encode())
        if self.depth is not None:
            write_whole(folder / f"{name}.depth.tiff", cv2.imencode(".tiff", self.depth)[1].tobytes())
        truth = {"id": name, "image": f"{name}{suffix}", **self.truth}
        path = folder / f"{name}.json"
        write_whole(path, json.dumps(truth).encode())
        return path


def make_scene(
    template_or_outline: FlatGarment,
    *,
    seed: int | np.random.SeedSequence,
    parameters: SynthParameters | None = None,
    tables: Sequence[Photograph] = (),
) -> Scene:
    """Make one scene.

    Parameters
    ----------
    template_or_outline : FlatGarment
        A template, or a garment made with :func:`foldrs.synth.garment_from_outline`; in centimetres.
    seed : int or numpy.random.SeedSequence
        The same seed gives the same scene.
    parameters : SynthParameters, optional
        What the scene is like.
    tables : sequence of Photograph, optional
        A garment with a photograph shows its own cloth, on the table of one of these; by default of its own.

    Raises
    ------
    ImageNotFoundError, NotAnImageError
        If a photograph to be shown cannot be read.
    ParameterError
        If the garment cannot be folded, or does not fit into the picture, in the way the parameters ask for,
        if the seed is negative, or if its outline encloses
        nothing in its photograph.
    InvalidOutlineError
        If the garment's outline encloses no area or crosses itself.
    """
    parameters = SynthParameters() if parameters is None else parameters
    if not isinstance(seed, np.random.SeedSequence):
        if seed < 0:
            raise ParameterError(f"seed is {seed}: give a whole number from 0 up.")
        seed = np.random.SeedSequence(seed)
    rng = np.random.default_rng(seed)
    # The camera has a random sequence of its own: the same scene is pictured from above and at an angle.
    aside = np.random.default_rng(np.random.SeedSequence(seed.entropy, spawn_key=(*seed.spawn_key, _CAMERA)))
    drawn = _drawn(checked(template_or_outline), rng, aside, parameters)
    garment, folds, layers, pose, masks, outline, camera = drawn
    truth = describe(garment, folds, layers, pose, masks, outline, parameters)
    tilted = parameters.tilt_deg > 0
    if tilted:
        pose = replace(pose, camera=camera.from_above)
        rings = [pose.to_image(layer.place(layer.ring)) for layer in layers]
        masks = draw_masks(rings, parameters.image_size)
        truth = {"tilt_deg": parameters.tilt_deg} | seen_at_an_angle(truth, camera.from_above)
    image = render(garment, layers, pose, masks, rng, parameters, camera, aside, tables)
    depth = draw_depth(masks, camera, aside, parameters) if parameters.depth else None
    mask = np.zeros(image.shape[:2], np.uint8)
    mask[masks.window] = np.where(coverage(masks.union()) >= 0.5, 255, 0)
    child = "".join(f".{k}" for k in seed.spawn_key)
    source = f"foldrs synth {garment.name} seed {seed.entropy}{child}"
    return Scene(image, mask, {"source": source, **truth}, camera, depth)


def _drawn(
    source: Garment, rng: np.random.Generator, aside: np.random.Generator, parameters: SynthParameters
) -> tuple[Garment, list[Fold], list[Layer], Pose, LayerMasks, NDArray[np.float64], TableCamera]:
    """Draw garment, folds and pose until all of them go together; what stands in the way last is told."""
    reason: FoldrsError = ParameterError(
        "The folded garment falls into pieces, or has a hole, however it is folded."
    )
    for _ in range(_TRIES):
        try:
            garment = vary(source, rng, parameters)
            folds = [draw_fold(garment, rng, parameters)] if parameters.folds else []
            layers = fold_flat(garment.outline, folds[0]) if folds else [Layer(garment.outline)]
            if parameters.folds == 2:
                folds.append(draw_second_fold(folds[0].outline, rng, parameters))
                layers = fold_again(layers, folds[1])
            rings = [layer.place(layer.ring) for layer in layers]
            pose = draw_pose(rings, rng, parameters)
            seen = [pose.to_image(ring) for ring in rings]
            tilted = parameters.tilt_deg > 0
            camera = draw_camera(np.vstack(seen), aside, parameters) if tilted else straight_above(parameters)
        except ParameterError as error:
            reason = error
            continue
        masks = draw_masks(seen, parameters.image_size)
        outline = seen_outline(masks, parameters)
        if outline is not None:
            return garment, folds, layers, pose, masks, outline, camera
    raise reason


def check_suffix(suffix: str) -> None:
    """Raise ParameterError if a suffix is no kind of image that scenes are written as."""
    if suffix not in (".jpg", ".png"):
        raise ParameterError(f"Scenes are written as .jpg or .png, not as {suffix!r}.")
