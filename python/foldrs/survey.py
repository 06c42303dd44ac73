"""What is known of the table before the garment is looked for: its plane, and how high things lie on it."""

from __future__ import annotations

import os
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from foldrs.camera.carry import carried_back
from foldrs.camera.pinhole import Camera
from foldrs.camera.plane import TablePlane
from foldrs.camera.pose import Pose
from foldrs.camera.view import ViewFromAbove
from foldrs.depth import Heights, cloth_by_height, heights_above_table, read_depth, resized_heights
from foldrs.errors import DepthError, OutlineError, ParameterError
from foldrs.image import Mask, RgbImage
from foldrs.outline import OutlineInImage, as_photograph
from foldrs.parameters import Parameters
from foldrs.result import FitResult
from foldrs.scale.paint import painted_over
from foldrs.scale.reference import Reference
from foldrs.segmentation import refined, segment

Source = str | os.PathLike[str] | ArrayLike


@dataclass(frozen=True, eq=False)
class Survey:
    """The table, and the photograph as it is to be segmented."""

    source: Source
    """What was given; a photograph with its markers or sheet painted over."""
    mask: Source | None
    """The garment's mask, if it was given or the depth image tells it."""
    plane: TablePlane | None
    """The table's plane, if anything tells it."""
    heights: Heights | None
    """Heights above the table, if there is a depth image."""
    robot_base: Pose | None

    def sight(self, found: OutlineInImage) -> Sight:
        """Look at the garment found: from straight above, if the table's plane is known."""
        height, width = (0, 0) if found.rgb is None else found.rgb.shape[:2]
        above = None if self.heights is None else resized_heights(self.heights.above, (height, width))
        if self.plane is None:
            return Sight(found, found.points, found.rgb, above, None, None)
        view = ViewFromAbove.of(self.plane, found.points)
        return Sight(
            found=found,
            points=view.from_image(found.points),
            rgb=None if found.rgb is None else np.asarray(view.picture(found.rgb), dtype=np.uint8),
            heights=None if above is None else np.asarray(view.picture(above), dtype=np.float32),
            view=view,
            robot_base=self.robot_base,
        )


@dataclass(frozen=True, eq=False)
class Sight:
    """The garment as the method is to see it."""

    found: OutlineInImage
    """As it was found in the photograph."""
    points: NDArray[np.float64]
    """(n, 2): the outline seen."""
    rgb: RgbImage | None
    """(h, w, 3) uint8: the picture."""
    heights: NDArray[np.float32] | None
    """(h, w): heights above the table, in spreads of its own, if known."""
    view: ViewFromAbove | None
    """What px of these are; None if they are those of the photograph."""
    robot_base: Pose | None

    @property
    def px_per_cm(self) -> float | None:
        """Scale, if the table's plane is known."""
        return None if self.view is None else self.view.px_per_cm

    def in_photograph(self, result: FitResult) -> FitResult:
        """Carry a result found in this sight back into the photograph."""
        if self.view is None:
            return result
        return carried_back(result, self.view, self.found.points, self.rgb, self.robot_base)


def survey(
    source: Source,
    mask: Source | None,
    *,
    px_per_cm: float | None,
    table: TablePlane | Reference | None,
    camera: Camera | None,
    depth: Source | None,
    robot_base: Pose | None,
    parameters: Parameters,
) -> Survey:
    """Survey the table; see :func:`foldrs.fit` for what can be given.

    Raises
    ------
    ParameterError
        What is given contradicts itself, or does not go with an outline or mask.
    CalibrationError, ScaleReferenceError, DepthError
        The camera does not go with the photograph; there is no marker or sheet; no depth image, or no table.
    ImageTooLargeError
        Photograph or depth image have more pixels than `parameters` allow; a file is not decoded then.
    ImageNotFoundError, NotAnImageError
        There is no photograph.
    """
    _check(px_per_cm, table, camera, depth, robot_base)
    if table is None and depth is None:
        return Survey(source, mask, None, None, None)
    if isinstance(table, TablePlane) and camera is None:
        camera = table.camera
    rgb = as_photograph(source, parameters.outline.max_pixels)
    if rgb is None:
        if not isinstance(table, TablePlane) or depth is not None:
            raise ParameterError(
                "Markers, sheets and depth images go with a photograph, not with an outline or mask."
            )
        return Survey(source, mask, table, None, robot_base)
    height, width = rgb.shape[:2]
    if camera is not None:
        camera.check_size(width, height)

    covered: NDArray[np.bool_] | None = None
    plane = table if isinstance(table, TablePlane) else None
    if table is not None and not isinstance(table, TablePlane):
        reference = table.find(rgb, camera, parameters.scale)
        plane, covered = reference.plane, reference.covered
        rgb = painted_over(rgb, covered)
    heights = None if depth is None else _heights(depth, (height, width), camera, parameters)
    if heights is not None:
        if plane is None and camera is not None:
            plane = heights.plane(camera)
        if mask is None:
            cloth = cloth_by_height(heights, (height, width), parameters.depth, parameters.outline)
            if cloth is not None:
                mask = _agreed(rgb, cloth if covered is None else cloth & ~covered, parameters)
    return Survey(rgb, mask, plane, heights, robot_base)


def _agreed(rgb: RgbImage, by_height: Mask, parameters: Parameters) -> Mask:
    """Tell the garment by its colours if they agree with the heights, else by these."""
    try:
        by_colour = segment(rgb, parameters.outline)
        union = np.count_nonzero(by_colour | by_height)
        if np.count_nonzero(by_colour & by_height) >= parameters.depth.agreement * union:
            return by_colour
    except OutlineError:  # the cloth looks like the table
        pass
    return refined(rgb, by_height, parameters.outline)


def _check(
    px_per_cm: float | None,
    table: TablePlane | Reference | None,
    camera: Camera | None,
    depth: Source | None,
    robot_base: Pose | None,
) -> None:
    """Refuse what contradicts itself or would be left unused."""
    if table is not None and px_per_cm is not None:
        raise ParameterError("The table's plane, a marker or a sheet tells the scale: leave px_per_cm out.")
    if camera is not None and isinstance(table, TablePlane):
        raise ParameterError("The table's plane comes with its camera: leave camera out.")
    if camera is not None and table is None and depth is None:
        raise ParameterError(
            "A camera alone does not tell where the table is: give its pose (TablePlane.of_pose), a marker, "
            "a sheet or a depth image as well."
        )
    if camera is not None and depth is not None and px_per_cm is not None:
        raise ParameterError("Camera and depth image tell the scale: leave px_per_cm out.")
    if robot_base is not None and table is None and (camera is None or depth is None):
        raise ParameterError(
            "For points in the robot's base the table's plane must be known: give a homography, a camera "
            "with its pose, a marker or a sheet."
        )


def _heights(depth: Source, shape: tuple[int, int], camera: Camera | None, parameters: Parameters) -> Heights:
    metres = read_depth(depth, parameters.outline.max_pixels)
    if metres.shape != shape:
        raise DepthError(
            f"The depth image is {metres.shape[1]} x {metres.shape[0]} pixels, the photograph {shape[1]} x "
            f"{shape[0]}: pass one that is aligned to the photograph."
        )
    return heights_above_table(metres, camera, parameters.depth)
