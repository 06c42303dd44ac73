"""Command-line options that several commands share."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import click

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
