"""The commands ``foldrs template ...``: make, check, show and list templates."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import click

from foldrs._options import same_file
from foldrs.errors import FoldrsError, ParameterError
from foldrs.whole_files import check_names_file

if TYPE_CHECKING:
    from collections.abc import Iterator

    from foldrs.drafting import Draft
    from foldrs.drafting.annotations import Annotation
    from foldrs.template import Template

_TEMPLATE_FIELDS = {"schema", "type", "units", "outline", "landmarks"}

_Command = TypeVar("_Command", bound=Callable[..., Any])


@click.group("template")
def template_group() -> None:
    """Make templates of flat garments, and look at template files."""


@template_group.command("list")
def list_command() -> None:
    """List the built-in templates: kind, size, number of landmarks, the best grasp pair."""
    from foldrs.template import builtin_templates

    for template in builtin_templates():
        click.echo(_line(template))


@template_group.command("check")
@click.argument("files", nargs=-1, required=True, type=click.Path(path_type=Path), metavar="FILE...")
def check_command(files: tuple[Path, ...]) -> None:
    """Check template FILEs; what is wrong is told by field, and the exit status is 1 then.

    Symmetric pairs that do not mirror each other are told as well: the fit makes nothing of them.
    """
    from foldrs.template import load_template

    failed = 0
    for file in files:
        try:
            template = load_template(file)
            click.echo(f"{file}: {_line(template)}")
            _tell_crooked(template)
        except FoldrsError as error:
            failed += 1
            click.secho(str(error), fg="red", err=True)
    if failed:
        raise SystemExit(1)


@template_group.command("show")
@click.argument("template", metavar="FILE")
@click.option(
    "--out",
    type=click.Path(path_type=Path, dir_okay=False),
    help="Picture to write; default: FILE's stem .png",
)
def show_command(template: str, out: Path | None) -> None:
    """Draw a template FILE (or a built-in KIND) with its landmarks and grasp pairs."""
    from foldrs.template import builtin_templates, load_template
    from foldrs.template_plot import save_template_picture

    with _told():
        chosen = load_template(template) if Path(template).suffix else builtin_templates(template)[0]
        path = out or Path(f"{chosen.name}.png")
        if path.suffix.lower() == ".json" or same_file(path, Path(template)):
            raise click.UsageError(f"{path} is no place for a picture: give --out the name of a picture")
        save_template_picture(chosen, path)
    click.echo(f"wrote {path}")


@dataclass(frozen=True)
class DraftOptions:
    """The options that all ways of making a template share."""

    kind: str | None
    out: Path | None
    symmetric: bool
    px_per_cm: float | None
    size_cm: float | None
    plot: bool

    def __post_init__(self) -> None:
        """Refuse, before anything is done, what can be told to be wrong without the inputs."""
        if self.px_per_cm is not None and self.size_cm is not None:
            raise click.UsageError("--px-per-cm goes without --size-cm: either tells the scale")
        if self.out is not None and self.out.suffix.lower() != ".json":
            raise click.UsageError(f"--out: {self.out} is not named *.json, as a template file is")
        if self.out is None and self.kind is not None:
            try:
                _file_of(self.kind)
            except ParameterError as error:
                raise click.UsageError(f"--kind: {error} Or name the file with --out.") from error

    def _checked_path(self, kind: str, inputs: Sequence[Path]) -> Path:
        """Return where the template goes; neither it nor its picture may take the place of an input."""
        path = self.out or _file_of(kind)
        for written in (path, path.with_suffix(".png")) if self.plot else (path,):
            if any(same_file(written, one) for one in inputs):
                raise click.UsageError(f"{written} is read here and would be overwritten: use another --out")
        if self.plot and same_file(path, path.with_suffix(".png")):
            raise click.UsageError(f"{path} and its picture would be one file: use another --out")
        if not _may_replace(path):
            raise click.UsageError(
                f"{path} is no template file and would be overwritten: move it, or use another --out"
            )
        return path

    def write(self, drafts: Sequence[Draft], inputs: Sequence[Path], photograph: Any = None) -> None:
        """Write the template of one garment, or the mean of several, and tell what was proposed and why."""
        from foldrs.drafting import mean_template
        from foldrs.drafting.plot import save_draft_picture
        from foldrs.template import load_template, save_template
        from foldrs.template_plot import save_template_picture

        template = drafts[0].template if len(drafts) == 1 else mean_template(drafts)
        path = self._checked_path(template.garment_type, inputs)
        save_template(template, path)
        load_template(path)  # by the reader that every other command uses
        if self.plot and len(drafts) == 1:
            save_draft_picture(drafts[0], path.with_suffix(".png"), photograph=photograph)
        elif self.plot:
            save_template_picture(template, path.with_suffix(".png"))
        click.echo(f"wrote {path}: {_line(template)}")
        if not drafts[0].symmetric:
            click.echo("no mirror axis found: it lies as in the picture, without symmetric pairs")
        if self.px_per_cm is None and self.size_cm is None:
            click.echo("its size is assumed: give --size-cm or --px-per-cm if it is known")
        if len(drafts) == 1:
            for pair, reason in zip(template.grasp_pairs, drafts[0].reasons, strict=True):
                click.echo(f"  grasp {pair[0]} + {pair[1]}: {reason}")
        for name, spread in template.spread.items():
            click.echo(f"  {name}: within {spread:.1f} cm")


def _draft_options(command: _Command) -> _Command:
    """Add the options of :class:`DraftOptions`."""
    for option in reversed(
        (
            click.option("--kind", metavar="KIND", help="The kind of garment."),
            click.option(
                "--out",
                type=click.Path(path_type=Path, dir_okay=False),
                help="Template file to write; default: KIND.json",
            ),
            click.option("--symmetric", is_flag=True, help="Make it symmetric: the mean of both halves."),
            click.option("--px-per-cm", type=float, help="Scale of the picture."),
            click.option("--size-cm", type=float, help="Or the longer side of the upright garment."),
            click.option("--plot", is_flag=True, help="Also draw it, beside the file: FILE's stem .png"),
        )
    ):
        command = option(command)
    return command


@template_group.command("from-photo")
@click.argument("images", nargs=-1, required=True, type=click.Path(path_type=Path), metavar="IMAGE...")
@click.option(
    "--landmarks",
    metavar="NAME,...",
    help="Names of the corners, from the top down the left side and up the right one; - for a corner that is "
    "no landmark. So many corners are looked for.",
)
@click.option("--mask", type=click.Path(path_type=Path), help="The garment's mask for a single IMAGE.")
@_draft_options
def photo_command(images: tuple[Path, ...], landmarks: str | None, mask: Path | None, **options: Any) -> None:
    """Make a template of a kind of the photograph of a flat garment, its upper end up.

    Of several photographs, each of another garment of the kind, it has the mean proportions, and notes how
    far they differ.
    """
    from foldrs.drafting import draft_template
    from foldrs.outline import find_outline

    chosen = DraftOptions(**options)
    if chosen.kind is None:
        raise click.UsageError("--kind names the kind of garment: give it")
    if mask is not None and len(images) > 1:
        raise click.UsageError("--mask goes with a single IMAGE")
    names = [name.strip() for name in landmarks.split(",")] if landmarks else []
    with _told():
        drafts, photograph = [], None
        for image in images:
            with _named(image, len(images)):
                found = find_outline(image, mask=mask)
                photograph = found.rgb
                drafts.append(
                    draft_template(
                        found.points,
                        chosen.kind,
                        landmarks=names,
                        symmetric=chosen.symmetric,
                        px_per_cm=chosen.px_per_cm,
                        size_cm=chosen.size_cm,
                    )
                )
        chosen.write(drafts, [*images, *([] if mask is None else [mask])], photograph)


@template_group.command("from-labelme")
@click.argument("files", nargs=-1, required=True, type=click.Path(path_type=Path), metavar="FILE...")
@click.option("--label", help="Label of the polygon to take, where there are several.")
@_draft_options
def labelme_command(files: tuple[Path, ...], label: str | None, **options: Any) -> None:
    """Make a template of LabelMe annotations: a polygon, its landmarks as points.

    The kind is the polygon's label, unless given. Of several files it has the mean proportions.
    """
    from foldrs.drafting.annotations import read_labelme

    chosen = DraftOptions(**options)
    with _told():
        _write_annotated(chosen, files, [read_labelme(file, label=label) for file in files])


@template_group.command("from-coco")
@click.argument("file", type=click.Path(path_type=Path))
@click.option(
    "--image-id",
    "image_ids",
    type=int,
    multiple=True,
    help="Image to take the garment of, where there are several; may be repeated.",
)
@_draft_options
def coco_command(file: Path, image_ids: tuple[int, ...], **options: Any) -> None:
    """Make a template of COCO keypoint annotations: a segmentation polygon and named keypoints.

    The kind is the category's name, unless given. Of several images it has the mean proportions.
    """
    from foldrs.drafting.annotations import read_coco

    chosen = DraftOptions(**options)
    with _told():
        read = [read_coco(file, image_id=one) for one in image_ids or (None,)]
        _write_annotated(chosen, [file] * len(read), read)


def _write_annotated(options: DraftOptions, files: Sequence[Path], annotations: Sequence[Annotation]) -> None:
    """Draft a template of every annotation, and write what comes of them."""
    from foldrs.drafting import draft_template

    drafts = []
    for file, annotation in zip(files, annotations, strict=True):
        with _named(file, 2):
            drafts.append(
                draft_template(
                    annotation.outline,
                    options.kind or annotation.label,
                    landmarks=annotation.landmarks,
                    symmetric=options.symmetric,
                    px_per_cm=options.px_per_cm,
                    size_cm=options.size_cm,
                )
            )
    options.write(drafts, files)


def _file_of(kind: str) -> Path:
    """Return the file that a template of a kind goes to, where none is named."""
    check_names_file(kind)
    return Path(f"{kind}.json")


def _may_replace(path: Path) -> bool:
    """Whether a template may be written to a file: there is none, it is empty, or it is a template."""
    if not path.exists():
        return not path.is_symlink()
    try:
        content = path.read_bytes()
        found = json.loads(content) if content.strip() else None
    except (OSError, ValueError, RecursionError):
        return False
    return found is None or (isinstance(found, dict) and found.keys() >= _TEMPLATE_FIELDS)


@contextmanager
def _told() -> Iterator[None]:
    """Tell an error of foldrs as the command line does."""
    try:
        yield
    except FoldrsError as error:
        raise click.ClickException(str(error)) from error


@contextmanager
def _named(file: Path, files: int) -> Iterator[None]:
    """Tell which of several files an error is about."""
    try:
        yield
    except FoldrsError as error:
        if files == 1:
            raise
        raise click.ClickException(f"{file}: {error}") from error


def _tell_crooked(template: Template) -> None:
    """Tell the symmetric pairs that the fit makes nothing of."""
    crooked = template.crooked_pairs()
    for pair, off in crooked.items():
        by = (
            f"{off:.1f} {template.units} from mirroring each other" if off < math.inf else "of no mirror axis"
        )
        click.secho(f"  symmetry: {' and '.join(pair)} are {by}, and not held alike", fg="yellow")
    if crooked:
        click.echo(
            "  Are these the right pairs? Of a garment that lay crooked --symmetric makes a straight one"
        )


def _line(template: Template) -> str:
    """Return a template in one line."""
    width, height = template.outline.max(axis=0) - template.outline.min(axis=0)
    pair = " + ".join(template.grasp_pairs[0]) if template.grasp_pairs else "none"
    marks = len(template.landmarks)
    return (
        f"{template.name} ({template.garment_type}), {width:.0f} x {height:.0f} {template.units}, "
        f"{marks} landmark{'s' * (marks > 1)}, grasp {pair}"
    )
