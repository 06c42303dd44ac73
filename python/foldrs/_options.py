"""Command-line options that several commands share."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import click

from foldrs.errors import FoldrsError, ParameterError

_TELL_SCALE = {"homography": "--homography", "camera": "--camera", "marker_cm": "--marker", "a4": "--a4"}
"""Options that tell where the table lies, and so the scale."""

template_option = click.option(
    "--template",
    "templates",
    multiple=True,
    type=click.Path(path_type=Path),
    help="Template file to use instead of the built-in ones; may be repeated.",
)


def _with_suffix(*suffixes: str) -> Callable[[click.Context, click.Parameter, Path | None], Path | None]:
    """Refuse a file of another kind than the one that is written: it may be one of the user's inputs."""

    def check(context: click.Context, parameter: click.Parameter, path: Path | None) -> Path | None:
        if path is not None and path.suffix.lower() not in suffixes:
            raise click.BadParameter(f"{path} is not named *{suffixes[0]}")
        return path

    return check


report_option = click.option(
    "--report",
    type=click.Path(path_type=Path, dir_okay=False),
    help="Also write all results as one HTML page, FILE, to look through in a browser.",
    metavar="FILE",
    callback=_with_suffix(".html", ".htm"),
)
rerun_option = click.option(
    "--rerun",
    type=click.Path(path_type=Path, dir_okay=False),
    help="Also write all results as a recording, FILE.rrd, for the Rerun viewer (needs foldrs[rerun]).",
    metavar="FILE",
    callback=_with_suffix(".rrd"),
)
px_per_cm_option = click.option("--px-per-cm", type=float, help="Known scale; without it the scale is found.")


def folds_option(default: str, help: str) -> Callable[[Any], Any]:
    """Return the option ``--folds``: a whole number, ``auto``, or the word that is its default."""

    def read(context: click.Context, parameter: click.Parameter, value: str) -> int | str:
        if value in ("auto", default) and not value.isdigit():
            return value
        try:
            return int(value)
        except ValueError:
            raise click.BadParameter(f"{value!r} is neither a whole number nor 'auto'") from None

    return click.option(
        "--folds", default=default, show_default=True, metavar="N|auto", callback=read, help=help
    )


@contextmanager
def about(option: str) -> Iterator[None]:
    """Tell which option an error of foldrs is about."""
    try:
        yield
    except FoldrsError as error:
        raise click.ClickException(f"{option}: {error}") from error


def check_marker(marker_cm: float | None, family: str | None) -> None:
    """Refuse a marker of no size, and a family that there is not."""
    from foldrs.scale import Marker

    if marker_cm is None:
        return
    for option, arguments in (("--marker", (marker_cm, None)), ("--marker-family", (marker_cm, family))):
        try:
            Marker(*arguments)
        except ParameterError as error:
            raise click.UsageError(f"{option}: {error}") from error


def check_table_options(px_per_cm: float | None, given: Mapping[str, Any]) -> None:
    """Refuse options of scale, camera and table that contradict each other, before any file is read."""
    check_marker(given["marker_cm"], given["marker_family"])
    telling = [option for name, option in _TELL_SCALE.items() if given[name] not in (None, False)]
    if px_per_cm is not None and telling:
        raise click.UsageError(f"--px-per-cm goes without {telling[0]}, which tells the scale")
    if given["robot_base"] is not None and not telling:
        raise click.UsageError(
            "--robot-base needs to know where the table lies: give --homography, --camera, --marker or --a4"
        )


def check_pose(known: Mapping[str, Any]) -> None:
    """Refuse a camera that nothing tells the table's place of."""
    if known.get("camera") is not None and known.get("table") is None and known.get("depth") is None:
        raise click.ClickException(
            "--camera: the file tells no pose of the table: give --table-pose, --marker, --a4 or --depth too"
        )


def check_folder(folder: Path, option: str) -> None:
    """Refuse a folder that cannot be: it, or one that it is to lie in, is a file."""
    there = next(one for one in (folder, *folder.parents, Path()) if one.exists())
    if not there.is_dir():
        inside = "" if there == folder else f", so the folder {folder} cannot be made"
        raise click.ClickException(f"{option}: {there} is not a folder{inside}")


def make_folder(folder: Path, option: str) -> None:
    """Make the folder that an option names, if it is not there."""
    check_folder(folder, option)
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        reason = error.strerror or error
        raise click.ClickException(f"{option}: the folder {folder} cannot be made ({reason})") from error


def same_file(one: Path, other: Path) -> bool:
    """Whether two paths lead to one file, there already or not."""
    if one.resolve() == other.resolve():
        return True
    return one.exists() and other.exists() and one.samefile(other)
