"""The command ``foldrs fit``."""

from __future__ import annotations

import sys
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import click

from foldrs._camera_options import camera_options, known_of_table
from foldrs._fit_told import Entry, reason, tell
from foldrs._options import (
    about,
    check_pose,
    check_table_options,
    folds_option,
    make_folder,
    px_per_cm_option,
    report_option,
    rerun_option,
    template_option,
)
from foldrs.errors import FoldrsError, OutputError, ParameterError

if TYPE_CHECKING:
    from concurrent.futures import Executor

    from foldrs.batch import Outcome
    from foldrs.fit_files import Destination
    from foldrs.fit_outputs import Show
    from foldrs.joint_fit import Folds
    from foldrs.result import FitResult

_CONNECTING = "20s"
"""How long a Dask scheduler is waited for."""

_HELP = """\
Fit foldable templates to photographs of folded garments.

A bad image does not stop the others: it is reported, and the exit status is 1 at the end.
A batch that was interrupted, or killed, is taken up again with --resume.

\b
Examples:
  foldrs fit photo.jpg
  foldrs fit photos/*.jpg --out results --plot
  foldrs fit photos/*.jpg --out results --resume --timeout 60
  foldrs fit photo.jpg --type pants --px-per-cm 4
  foldrs fit photos/*.jpg --jsonl | jq .garment_type
  foldrs fit photos/*.jpg --out results --dask tcp://scheduler:8786

\b
Exit status:
  0  every image has a result
  1  an image, or another input, could not be used
  2  the command was called wrongly; nothing was done
"""


class FitCommand(click.Command):
    """Reads ``--plot stages`` as ``--plot-stages``, though ``--plot`` is a flag that takes no value."""

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Parse the arguments, the two words made one; not behind ``--``, where all are images."""
        end = args.index("--") if "--" in args else len(args)
        read: list[str] = []
        for word in args[:end]:
            if word == "stages" and read[-1:] == ["--plot"]:
                read[-1] = "--plot-stages"
            else:
                read.append(word)
        return super().parse_args(ctx, [*read, *args[end:]])


@click.command("fit", cls=FitCommand, help=_HELP)
@click.argument("images", nargs=-1, required=True, type=click.Path(path_type=Path), metavar="IMAGE...")
@click.option("--type", "garment_type", metavar="KIND", help="Match templates of this kind only.")
@template_option
@px_per_cm_option
@folds_option(default="1", help="Folds to undo; auto: as many as explain more than their freedom costs.")
@click.option("--method", type=click.Choice(["best", "paper"]), default="best", show_default=True)
@click.option(
    "--mask", type=click.Path(path_type=Path), help="The garment's mask (image file) for a single IMAGE."
)
@click.option(
    "--out", type=click.Path(path_type=Path, file_okay=False), help="Folder for STEM.json (and STEM.png)."
)
@click.option("--keep-folders", is_flag=True, help="Make the folders of the images again below --out.")
@click.option(
    "--resume", is_flag=True, help="Leave out images whose results in --out are whole and the same."
)
@click.option("--plot", is_flag=True, help="Also write the picture of the result to --out.")
@click.option(
    "--plot-stages",
    is_flag=True,
    help="Or --plot stages: as --plot, and also STEM.stages.png with every stage of the published method, "
    "which is run for that picture too if --method is best. Name an image stages as ./stages.",
)
@report_option
@rerun_option
@camera_options
@click.option("--timings", is_flag=True, help="Also print the seconds of every stage.")
@click.option("--quiet", "told", flag_value="nothing", help="Print nothing but errors and warnings.")
@click.option("--jsonl", "told", flag_value="json", help="Print every result, or error, as a line of JSON.")
@click.option("--jobs", type=click.IntRange(1), help="Images and hypotheses at a time; default: all cores.")
@click.option("--timeout", type=float, metavar="SECONDS", help="Give an image up that takes longer.")
@click.option(
    "--max-pixels", type=click.IntRange(1), help="Refuse larger images unread; default: 120 million pixels."
)
@click.option("--dask", metavar="ADDRESS", help="Run on the Dask cluster with this scheduler.")
def fit_command(
    images: tuple[Path, ...],
    garment_type: str | None,
    templates: tuple[Path, ...],
    px_per_cm: float | None,
    folds: Folds,
    method: Literal["best", "paper"],
    mask: Path | None,
    out: Path | None,
    keep_folders: bool,
    resume: bool,
    plot: bool,
    plot_stages: bool,
    report: Path | None,
    rerun: Path | None,
    timings: bool,
    told: Literal["nothing", "json"] | None,
    jobs: int | None,
    timeout: float | None,
    max_pixels: int | None,
    dask: str | None,
    **placing: Any,
) -> None:
    """Fit every image; `_HELP` is what the command tells of itself."""
    from foldrs.fit_outputs import open_outputs

    if mask is not None and len(images) > 1:
        raise click.UsageError("--mask goes with a single IMAGE")
    plot = plot or plot_stages
    if out is None:
        for wanted, name in ((plot, "--plot"), (resume, "--resume"), (keep_folders, "--keep-folders")):
            if wanted:
                raise click.UsageError(f"{name} needs --out DIR to write to")
    if resume and (report is not None or rerun is not None):
        raise click.UsageError("--report and --rerun show what is fitted now: leave --resume out")
    if dask is not None and jobs is not None:
        raise click.UsageError("--jobs goes without --dask: the cluster has its own number of workers")
    _check_timeout(timeout)
    check_table_options(px_per_cm, placing)
    try:
        options = _fit_options(templates, garment_type, px_per_cm, folds, method, mask, max_pixels)
        options |= known_of_table(placing, len(images), options["parameters"].outline.max_pixels)
        check_pose(options)
        pictures = _Pictures(plot, _published_options(options, bool(templates), garment_type, plot_stages))
        destination = None
        if out is not None:
            files = (mask, *(path for path in placing.values() if isinstance(path, Path)))
            read = (*templates, *(path for path in files if path is not None))
            destination = _destination(out, images, options, pictures, keep_folders)
            destination.check(read)
            make_folder(out, "--out")
            destination.prepare()
        outputs = open_outputs(images, report, rerun)
    except OutputError as error:
        raise click.UsageError(str(error)) from error
    except (FoldrsError, OSError) as error:
        raise click.ClickException(str(error)) from error

    run = _Run(images, destination, pictures, options, jobs, timeout)
    with _cluster(dask) if dask is not None else nullcontext() as executor, outputs as show:
        entries = _shown(run.entries(resume, executor, quiet=told is not None), show)
        errors = None if destination is None else destination.errors
        told_by = destination.told if destination is not None and keep_folders else None
        failed = tell(entries, told, timings, errors, told_by)
    if failed:
        sys.exit(1)


def _fit_options(
    templates: tuple[Path, ...],
    garment_type: str | None,
    px_per_cm: float | None,
    folds: Folds,
    method: Literal["best", "paper"],
    mask: Path | None,
    max_pixels: int | None,
) -> dict[str, Any]:
    """Check and read everything but the images: the options of :func:`foldrs.fit`."""
    from foldrs.image import read_mask
    from foldrs.parameters import Parameters
    from foldrs.pipeline import check_folds, check_scale, choose_templates

    with about("--px-per-cm"):
        check_scale(px_per_cm)
    with about("--folds"):
        check_folds(folds, method)
    parameters = Parameters()
    if max_pixels is not None:
        parameters = replace(parameters, outline=replace(parameters.outline, max_pixels=max_pixels))
    return {
        "templates": choose_templates(templates or None, garment_type, method),
        "px_per_cm": px_per_cm,
        "folds": folds,
        "method": method,
        "mask": None if mask is None else read_mask(mask, parameters.outline.max_pixels),
        "parameters": parameters,
    }


def _check_timeout(timeout: float | None) -> None:
    from foldrs.batch import check_batch

    try:
        check_batch(None, None, timeout)
    except ParameterError as error:
        raise click.UsageError(f"--{error}") from error


def _published_options(
    options: dict[str, Any], own_templates: bool, garment_type: str | None, wanted: bool
) -> dict[str, Any] | None:
    """Return the options by which the published method explains what another one did; None if unwanted."""
    from foldrs.pipeline import choose_templates

    if not wanted:
        return None
    templates = options["templates"] if own_templates else None
    return options | {"templates": choose_templates(templates, garment_type, "paper")}


def _destination(
    out: Path, images: Sequence[Path], options: dict[str, Any], pictures: _Pictures, keep_folders: bool
) -> Destination:
    from foldrs.fit_files import Destination, fingerprint

    draw = pictures.draw if pictures.plot else None
    return Destination(out, images, fingerprint(options), pictures.suffixes, draw, keep_folders)


@dataclass(frozen=True)
class _Pictures:
    """Draws the pictures of results; one stands without that of the stages, whose failure is told later."""

    plot: bool
    """Whether any is drawn."""
    published: dict[str, Any] | None
    """Options of the published method, whose stages are drawn as well; None if they are not."""
    failed: dict[Path, Exception] = field(default_factory=dict)
    """Why the stages of an image could not be drawn."""

    @property
    def suffixes(self) -> tuple[str, ...]:
        """Ends of the names of all pictures of a result."""
        from foldrs.fit_files import STAGES

        return ((".png",) if self.plot else ()) + ((STAGES,) if self.published is not None else ())

    def draw(self, result: FitResult, image: Path, base: Path) -> None:
        """Draw the pictures of a result; `base` is the path of its files without a suffix."""
        from foldrs.fit_files import STAGES
        from foldrs.matching_details import matching_details
        from foldrs.plot import save_picture

        details = matching_details(result)
        save_picture(result, image, base.with_name(f"{base.name}.png"), details=details)
        if self.published is not None:
            self._draw_stages(result, image, base.with_name(f"{base.name}{STAGES}"), self.published)

    def _draw_stages(self, result: FitResult, image: Path, path: Path, published: dict[str, Any]) -> None:
        from foldrs.stages_plot import save_stages

        try:
            save_stages(_published(result, published), image, path)
        except Exception as error:
            path.unlink(missing_ok=True)  # it would be that of an earlier result
            failure = FoldrsError(f"{path} could not be drawn ({reason(error)}), but the result is written")
            failure.__cause__ = error
            self.failed[image] = failure


def _published(result: FitResult, options: dict[str, Any]) -> FitResult:
    """Explain the outline of a result by the published method, unless that is where it comes from."""
    from foldrs.pipeline import fit

    if result.stages:
        return result
    flat = result.from_above
    published = fit(
        (flat.result if flat else result).outline_image,
        templates=options["templates"],
        px_per_cm=flat.px_per_cm if flat else options["px_per_cm"],
        method="paper",
        parameters=options["parameters"],
    )
    published = replace(published, image=result.image)
    return replace(published, from_above=replace(flat, result=published)) if flat else published


@contextmanager
def _cluster(address: str) -> Iterator[Executor]:
    """Connect to a Dask cluster."""
    try:
        from distributed import Client
    except ImportError:
        raise click.ClickException("--dask needs Dask: pip install 'foldrs[dask]'") from None
    try:
        client = Client(address, timeout=_CONNECTING, set_as_default=False)  # type: ignore[no-untyped-call]
    except (OSError, ValueError) as error:
        raise click.ClickException(f"there is no Dask scheduler at {address}: {error}") from error
    with client:
        executor: Executor = client.get_executor(pure=False)  # type: ignore[no-untyped-call]
        yield executor


@dataclass(frozen=True)
class _Run:
    """One call: images, where results go, and how they are made."""

    images: tuple[Path, ...]
    destination: Destination | None
    pictures: _Pictures
    options: dict[str, Any]
    jobs: int | None
    timeout: float | None

    def entries(self, resume: bool, executor: Executor | None, quiet: bool) -> Iterator[Entry]:
        """Fit, write what is ready, and yield what became of every image, in the order given."""
        from foldrs.batch import in_order

        return in_order(self._as_ready(resume, executor, quiet))

    def _as_ready(self, resume: bool, executor: Executor | None, quiet: bool) -> Iterator[tuple[int, Entry]]:
        from foldrs.batch import fit_as_ready

        left = []
        for index, image in enumerate(self.images):
            kept = self.destination.finished(image) if self.destination is not None and resume else None
            if kept is None:
                left.append(index)
            else:
                yield index, Entry(image, kept=kept)
        outcomes = fit_as_ready(
            [self.images[index] for index in left],
            executor=executor,
            jobs=self.jobs,
            timeout=self.timeout,
            send_files=executor is not None,
            **self.options,
        )
        for outcome in _with_progress(outcomes, len(left), quiet):
            index = left[outcome.index]
            yield index, self._written(self.images[index], outcome)

    def _written(self, image: Path, outcome: Outcome) -> Entry:
        """Write what became of an image, at once, and warn of what is doubtful."""
        for doubt in outcome.doubts:
            click.secho(f"{image}: warning: {doubt}", fg="yellow", err=True)
        result: FitResult | None = None
        error: BaseException | None = None
        if isinstance(outcome.answer, BaseException):
            error = outcome.answer
        else:
            result = outcome.answer
        if self.destination is not None and result is not None:
            try:
                self.destination.save(image, result)
                error = self.pictures.failed.pop(image, None)
            except Exception as raised:
                result, error = None, raised
        if self.destination is not None and error is not None:
            self.destination.note_error(image, error)
        return Entry(image, result=result, error=error)


def _shown(entries: Iterable[Entry], show: Show) -> Iterator[Entry]:
    """Add every image to the page and the recording, if there are any."""
    for entry in entries:
        # A result that lacks a picture beside its file is shown as any other.
        failed = entry.error if entry.result is None else None
        show(entry.image, entry.result, "" if failed is None else reason(failed))
        yield entry


def _with_progress(outcomes: Iterable[Outcome], total: int, quiet: bool) -> Iterable[Outcome]:
    """Show a progress bar where it is of use."""
    from rich.console import Console
    from rich.progress import track

    console = Console(stderr=True)
    hidden = quiet or total <= 1 or not console.is_terminal
    return track(outcomes, "fitting", total=total, console=console, disable=hidden)
