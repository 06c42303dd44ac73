"""The commands ``foldrs synth`` and ``foldrs demo``."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from foldrs._options import check_folder, template_option
from foldrs.errors import FoldrsError, ParameterError

if TYPE_CHECKING:
    from foldrs.synth import FlatGarment, Garment, SynthParameters
    from foldrs.template import Template

_OPTIONS = {"image_size": "--size", "px_per_cm": "--px-per-cm", "tilt_deg": "--tilt", "marker_cm": "--marker"}
"""Options by the parameters they set."""

_SCENARIOS = ("random", "landmarks", "parallel", "corner", "halves", "limb", "limbs")


@click.command("synth")
@click.option(
    "--out",
    required=True,
    type=click.Path(path_type=Path, file_okay=False),
    help="Folder for KIND-NUMBER.jpg, .mask.png and .json.",
)
@click.option("--count", type=click.IntRange(1), default=10, show_default=True, help="Number of scenes.")
@click.option(
    "--type", "kinds", multiple=True, metavar="KIND", help="Garments of this kind only; may be repeated."
)
@template_option
@click.option(
    "--outlines",
    type=click.Path(path_type=Path, dir_okay=False),
    help='Real outlines instead of templates: JSON list of {"type", "outline", "landmarks"}, in any unit; '
    'with "size_cm" (longer side) or else as large as the template of the kind.',
)
@click.option(
    "--photos",
    type=click.Path(path_type=Path, file_okay=False),
    metavar="FOLDER",
    help='Where the photographs are that the outlines were traced in (the field "image" of each). Scenes '
    "then show real cloth upon tables of these photographs, and shapes stay as they are.",
)
@click.option(
    "--folds",
    type=click.IntRange(0, 2),
    default=1,
    show_default=True,
    help="Folds of every garment; 0: flat and nearly upright, to make templates of.",
)
@click.option(
    "--scenario",
    "scenarios",
    multiple=True,
    type=click.Choice(_SCENARIOS),
    help="How the fold line is drawn; may be repeated; default: any way.",
)
@click.option("--px-per-cm", type=float, default=4.0, show_default=True, help="Scale of the pictures.")
@click.option(
    "--size",
    type=(int, int),
    default=(640, 480),
    show_default=True,
    metavar="WIDTH HEIGHT",
    help="Of the pictures, px.",
)
@click.option(
    "--tilt",
    type=float,
    default=0.0,
    metavar="DEGREES",
    help="Tilt of the camera; also writes NAME.homography.json and NAME.camera.json.",
)
@click.option(
    "--marker",
    "marker_cm",
    type=float,
    default=0.0,
    metavar="CM",
    help="Lay AprilTag markers of that size beside the garment.",
)
@click.option("--a4", is_flag=True, help="Lay a white sheet of A4 beside the garment.")
@click.option("--depth", is_flag=True, help="Also write a depth image, NAME.depth.tiff (floats, m).")
@click.option(
    "--seed", type=click.IntRange(0), default=0, show_default=True, help="The same seed, the same scenes."
)
@click.option("--png", is_flag=True, help="Write PNG images, without loss, instead of JPEG.")
@click.option("--jobs", type=click.IntRange(1), help="Scenes at a time; default: all cores.")
def synth_command(
    out: Path,
    count: int,
    kinds: tuple[str, ...],
    templates: tuple[Path, ...],
    outlines: Path | None,
    photos: Path | None,
    folds: int,
    scenarios: tuple[str, ...],
    px_per_cm: float,
    size: tuple[int, int],
    tilt: float,
    marker_cm: float,
    a4: bool,
    depth: bool,
    seed: int,
    png: bool,
    jobs: int | None,
) -> None:
    """Draw scenes of folded garments with their ground truth.

    Every scene is another garment of its kind, folded and laid on a table of its own; the templates take
    turns, and so do the garments of a file.
    """
    from rich.console import Console
    from rich.progress import Progress

    from foldrs.synth import SCENARIOS, make_scenes

    if photos is not None and outlines is None:
        raise click.UsageError("--photos needs --outlines, the outlines traced in them")
    if folds == 0 and scenarios:
        raise click.UsageError("--scenario tells how a fold is drawn: leave it out with --folds 0")
    parameters = _parameters(
        image_size=size,
        px_per_cm=px_per_cm,
        folds=folds,
        scenarios=scenarios or SCENARIOS,
        tilt_deg=tilt,
        marker_cm=marker_cm,
        sheet=a4,
        depth=depth,
    )
    check_folder(out, "--out")
    try:
        if photos is not None:  # photographed cloth belongs to its shape
            parameters = replace(parameters, shape_cm=0.0, asymmetry_cm=0.0, stretch=0.0, bow=0.0)
        sources = garments(kinds, templates, outlines, photos)
        console = Console(stderr=True)
        with Progress(console=console, disable=not console.is_terminal) as progress:
            task = progress.add_task("drawing", total=count)
            written = make_scenes(
                sources,
                count,
                seed,
                out,
                parameters=parameters,
                suffix=".png" if png else ".jpg",
                jobs=jobs,
                progress=lambda done, _: progress.update(task, completed=done),
            )
    except FoldrsError as error:
        raise click.ClickException(str(error)) from error
    except OSError as error:
        raise click.ClickException(
            f"--out: {out} cannot be written to ({error.strerror or error})"
        ) from error
    click.echo(f"wrote {len(written)} scene{'s' * (len(written) > 1)} to {out}")


def _parameters(**values: Any) -> SynthParameters:
    """Make the parameters; a number out of range is told by the name of its option."""
    from foldrs.synth import SynthParameters

    try:
        return SynthParameters(**values)
    except ParameterError as error:
        name, _, rest = str(error).partition(" ")
        raise click.UsageError(f"{_OPTIONS.get(name, name)} {rest}") from error


def garments(
    kinds: Sequence[str], templates: Sequence[Path], outlines: Path | None, photos: Path | None = None
) -> list[FlatGarment]:
    """Gather the garments to draw: outlines of a file, template files, or built-in templates; of some kinds.

    Raises
    ------
    TemplateError
        If a template file is not valid.
    ParameterError
        If the file of outlines is not valid, or nothing of the kinds asked for is there.
    """
    from foldrs.template import builtin_templates, load_template

    known = [load_template(path) for path in templates] if templates else list(builtin_templates())
    sources: list[FlatGarment] = (
        list(known) if outlines is None else list(read_outlines(outlines, known, photos))
    )
    there = sorted({one.garment_type for one in sources})
    missing = [kind for kind in kinds if kind not in there]
    if missing:
        raise ParameterError(
            f"there is no garment of kind {', '.join(missing)}; the kinds are {', '.join(there)}"
        )
    return [one for one in sources if not kinds or one.garment_type in kinds]


def read_outlines(path: Path, templates: Sequence[Template], photos: Path | None = None) -> list[Garment]:
    """Read a file of real outlines.

    Parameters
    ----------
    path : Path
        JSON list of objects with ``type``, ``outline`` and ``landmarks``, in any unit, y down; optionally
        ``size_cm``, the longer side of the upright bounding box.
    templates : sequence of Template
        Where ``size_cm`` is missing, the garment is as large as the first template of its kind. It has the
        symmetry of that kind.
    photos : Path, optional
        Folder of the photographs that the outlines were traced in; their names there are the field ``image``.

    Raises
    ------
    ParameterError
        If the file is no such list, the size of a garment cannot be told, or its photograph is not there.
    """
    try:
        entries = json.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError as error:
        raise ParameterError(f"{path}: there is no such file of outlines") from error
    except OSError as error:
        raise ParameterError(f"{path}: cannot be read ({error.strerror or error})") from error
    except (ValueError, RecursionError) as error:
        raise ParameterError(f"{path}: cannot be read as JSON ({error})") from error
    if not isinstance(entries, list) or not entries:
        raise ParameterError(f"{path}: expected a JSON list of outlines, with one at least")
    found = []
    for number, entry in enumerate(entries):
        if not isinstance(entry, dict):
            raise ParameterError(
                f"{path}: outline {number} must be an object with the fields type, outline and landmarks"
            )
        try:
            found.append(_garment(entry, templates, f"{path.stem} {number}", photos))
        except KeyError as error:
            raise ParameterError(f"{path}: outline {number} lacks the field {error}") from error
        except (FoldrsError, TypeError, ValueError, AttributeError) as error:
            raise ParameterError(f"{path}: outline {number}: {error}") from error
    return found


def _garment(entry: dict[str, Any], templates: Sequence[Template], name: str, photos: Path | None) -> Garment:
    from foldrs.evaluation.kinds import along_outline
    from foldrs.synth import garment_from_outline

    kind, outline, landmarks = entry["type"], entry["outline"], entry["landmarks"]
    alike = [template for template in templates if template.garment_type == kind]
    symmetry = tuple(pair for pair in alike[0].symmetry if set(pair) <= set(landmarks)) if alike else ()
    order = along_outline(alike[0], landmarks) if alike else ()
    photograph = None if photos is None else photos / entry["image"]
    if photograph is not None and not photograph.is_file():
        raise ParameterError(f"its photograph {photograph} is not there")
    size: dict[str, float] = {}
    if "size_cm" in entry:
        size["size_cm"] = float(entry["size_cm"])
    elif alike:
        size["area_cm2"] = alike[0].area
    else:
        raise ParameterError(f"no template tells how large a garment of kind {kind!r} is: give its size_cm")
    return garment_from_outline(
        outline, landmarks, kind, **size, symmetry=symmetry, order=order, name=name, photograph=photograph
    )


@click.command("demo")
@click.option(
    "--out",
    type=click.Path(path_type=Path, file_okay=False),
    default=Path("demo"),
    show_default=True,
    help="Folder for the scene, the result and its picture.",
)
def demo_command(out: Path) -> None:
    """Draw a folded garment, explain the picture, and show how well that went."""
    from rich.console import Console

    from foldrs.demo import run_demo, table

    check_folder(out, "--out")
    try:
        demo = run_demo(out)
    except FoldrsError as error:
        raise click.ClickException(str(error)) from error
    Console().print(table(demo))
    for what, path in (("photograph", demo.image), ("result", demo.answer), ("picture", demo.picture)):
        click.echo(f"{what:<11} {path}")
