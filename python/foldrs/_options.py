"""Command-line options that several commands share."""

from __future__ import annotations

from pathlib import Path

import click

template_option = click.option(
    "--template",
    "templates",
    multiple=True,
    type=click.Path(path_type=Path),
    help="Template file to use instead of the built-in ones; may be repeated.",
)
px_per_cm_option = click.option("--px-per-cm", type=float, help="Known scale; without it the scale is found.")
