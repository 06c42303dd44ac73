"""Command-line options that tell where the table lies before the camera."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, TypeVar

import click

Command = TypeVar("Command", bound=Callable[..., Any])

_FILE = click.Path(path_type=Path, dir_okay=False)

_OPTIONS = (
    click.option("--homography", type=_FILE, help="3 x 3 matrix from image px to cm on the table."),
    click.option(
        "--camera", type=_FILE, help="Calibration of the camera (ROS or OpenCV), perhaps with the table's pose."
    ),
    click.option("--table-pose", type=_FILE, help="Pose of the table in the camera's frame, for --camera."),
    click.option(
        "--marker",
        "marker_cm",
        type=float,
        metavar="CM",
        help="Printed ArUco or AprilTag markers of that size lie on the table.",
    ),
    click.option("--marker-family", metavar="NAME", help="Their family, for instance apriltag-36h11."),
    click.option("--a4", is_flag=True, help="A white sheet of A4 lies on the table."),
    click.option(
        "--depth",
        type=_FILE,
        help="Depth image (PNG, TIFF, .npy; mm or, if floats, m), pixel on pixel with a single IMAGE.",
    ),
    click.option("--robot-base", type=_FILE, help="4 x 4 pose of the table in the robot's base, metres."),
)


def camera_options(command: Command) -> Command:
    """Add the options to a command; :func:`known_of_table` reads what they give."""
    for option in reversed(_OPTIONS):
        command = option(command)
    return command


def known_of_table(options: Mapping[str, Any], images: int) -> dict[str, Any]:
    """Read the files that the options name.

    Parameters
    ----------
    options : mapping
        Values of the options by name.
    images : int
        Number of photographs.

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
    from foldrs.scale import A4, Marker

    told = [name for name in ("homography", "marker_cm", "a4") if options[name]]
    if len(told) > 1:
        raise click.UsageError("of --homography, --marker and --a4 give one only")
    for name, needed in (("table_pose", "camera"), ("marker_family", "marker_cm")):
        if options[name] is not None and options[needed] is None:
            raise click.UsageError(f"--{name.replace('_', '-')} needs --{needed.removesuffix('_cm')}")
    if options["depth"] is not None and images > 1:
        raise click.UsageError("--depth goes with a single IMAGE")
    if options["homography"] is not None and options["camera"] is not None:
        raise click.UsageError("of --homography and --camera give one only")

    known: dict[str, Any] = {"depth": options["depth"]}
    if options["robot_base"] is not None:
        known["robot_base"] = load_pose(options["robot_base"])
    if options["homography"] is not None:
        known["table"] = load_homography(options["homography"])
    elif options["marker_cm"] is not None:
        known["table"] = Marker(options["marker_cm"], options["marker_family"])
    elif options["a4"]:
        known["table"] = A4
    if options["camera"] is not None:
        camera, pose = load_camera(options["camera"])
        pose = pose if options["table_pose"] is None else load_pose(options["table_pose"])
        if pose is None or told:
            known["camera"] = camera
        else:
            known["table"] = TablePlane.of_pose(camera, pose)
    return known
