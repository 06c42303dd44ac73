"""Command-line options that tell where the table lies before the camera."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import click

if TYPE_CHECKING:
    from foldrs.scale import Reference

Command = TypeVar("Command", bound=Callable[..., Any])

_FILE = click.Path(path_type=Path, dir_okay=False)

_REFERENCE_OPTIONS = (
    click.option(
        "--marker",
        "marker_cm",
        type=float,
        metavar="CM",
        help="Printed ArUco or AprilTag markers of that size lie on the table.",
    ),
    click.option("--marker-family", metavar="NAME", help="Their family, for instance apriltag-36h11."),
    click.option("--a4", is_flag=True, help="A white sheet of A4 lies on the table."),
)

_CAMERA_OPTIONS = (
    click.option("--homography", type=_FILE, help="3 x 3 matrix from image px to cm on the table."),
    click.option(
        "--camera",
        type=_FILE,
        help="Calibration of the camera (ROS or OpenCV), perhaps with the table's pose.",
    ),
    click.option("--table-pose", type=_FILE, help="Pose of the table in the camera's frame, for --camera."),
    *_REFERENCE_OPTIONS,
    click.option(
        "--depth",
        type=_FILE,
        help="Depth image (PNG, TIFF, .npy; mm or, if floats, m), pixel on pixel with a single IMAGE.",
    ),
    click.option("--robot-base", type=_FILE, help="4 x 4 pose of the table in the robot's base, metres."),
)


def camera_options(command: Command) -> Command:
    """Add all options to a command; :func:`known_of_table` reads what they give."""
    return _with(command, _CAMERA_OPTIONS)


def reference_options(command: Command) -> Command:
    """Add those for markers and sheets; :func:`reference_of` reads what they give."""
    return _with(command, _REFERENCE_OPTIONS)


def _with(command: Command, options: Sequence[Callable[[Command], Command]]) -> Command:
    for option in reversed(options):
        command = option(command)
    return command


def reference_of(marker_cm: float | None, family: str | None, a4: bool) -> Reference | None:
    """Make what the options for markers and sheets ask for.

    Raises
    ------
    ParameterError
        The marker is none.
    click.UsageError
        Options contradict each other.
    """
    from foldrs.scale import A4, Marker

    if marker_cm is not None and a4:
        raise click.UsageError("of --marker and --a4 give one only")
    if family is not None and marker_cm is None:
        raise click.UsageError("--marker-family needs --marker")
    return A4 if a4 else None if marker_cm is None else Marker(marker_cm, family)


def known_of_table(options: Mapping[str, Any], images: int, max_pixels: int | None) -> dict[str, Any]:
    """Read the files that the options name.

    Parameters
    ----------
    options : mapping
        Values of the options by name.
    images : int
        Number of photographs.
    max_pixels : int or None
        Most pixels that a depth image may have; None: any number.

    Returns
    -------
    dict
        Arguments of :func:`foldrs.fit`.

    Raises
    ------
    FoldrsError
        A file is not what it should be.
    click.UsageError
        Options contradict each other.
    """
    from foldrs.camera import TablePlane, load_camera, load_homography, load_pose
    from foldrs.depth import read_depth

    reference = reference_of(options["marker_cm"], options["marker_family"], options["a4"])
    homography, calibration, pose_file = (options[name] for name in ("homography", "camera", "table_pose"))
    if homography is not None and (reference is not None or calibration is not None):
        raise click.UsageError("--homography goes without --camera, --marker and --a4")
    if pose_file is not None and (calibration is None or reference is not None):
        raise click.UsageError("--table-pose needs --camera, and goes without --marker and --a4")
    if options["depth"] is not None and images > 1:
        raise click.UsageError("--depth goes with a single IMAGE")

    depth = None if options["depth"] is None else read_depth(options["depth"], max_pixels)
    known: dict[str, Any] = {"depth": depth, "table": reference}
    if options["robot_base"] is not None:
        known["robot_base"] = load_pose(options["robot_base"])
    if homography is not None:
        known["table"] = load_homography(homography)
    if calibration is not None:
        camera, pose = load_camera(calibration)
        pose = pose if pose_file is None else load_pose(pose_file)
        if reference is None and pose is not None:
            known["table"] = TablePlane.of_pose(camera, pose)
        else:
            known["camera"] = camera
    return known
