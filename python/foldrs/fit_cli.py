"""The command ``foldrs fit``."""

from __future__ import annotations

import sys
import threading
import warnings
from collections.abc import Iterator, Sequence
from concurrent.futures import as_completed
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import click

from foldrs._camera_options import camera_options, known_of_table
from foldrs._options import folds_option, px_per_cm_option, report_option, rerun_option, template_option
from foldrs.errors import FoldrsError, GarmentCutOffWarning

if TYPE_CHECKING:
    from foldrs.joint_fit import Folds
    from foldrs.result import FitResult
    from foldrs.template import Template

_STAGES_SUFFIX = ".stages.png"

_at_work = threading.local()
"""Its `image` is the one that this thread is at work on."""


@dataclass(frozen=True)
class FitJob:
    """What is the same for every image of one call."""

    templates: list[Template]
    px_per_cm: float | None
    folds: Folds
    method: Literal["best", "paper"]
    mask: Path | None
    out: Path | None
    plot: bool
    plot_stages: bool
    known: dict[str, Any]
    """Of table and camera: arguments of `foldrs.fit`."""

    def run(self, image: Path) -> FitResult:
        """Fit one image and write its files, the picture first: where there is a JSON file, all is there."""
        from foldrs.pipeline import fit

        _at_work.image = image
        result = fit(
            image,
            templates=self.templates,
            px_per_cm=self.px_per_cm,
            folds=self.folds,
            method=self.method,
            mask=self.mask,
            **self.known,
        )
        if self.out is not None:
            if self.plot:
                from foldrs.matching_details import matching_details
                from foldrs.plot import save_picture

                details = matching_details(result)
                save_picture(result, image, self.out / f"{image.stem}.png", details=details)
            if self.plot_stages:
                from foldrs.stages_plot import save_stages

                save_stages(self._published(result), image, self.out / f"{image.stem}{_STAGES_SUFFIX}")
            result.save(self.out / f"{image.stem}.json")
        return result

    def _published(self, result: FitResult) -> FitResult:
        """Explain the outline of a result by the published method, unless that is where it comes from."""
        from foldrs.pipeline import fit

        if result.stages:
            return result
        flat = result.from_above
        published = fit(
            (flat.result if flat else result).outline_image,
            templates=self.templates,
            px_per_cm=flat.px_per_cm if flat else self.px_per_cm,
            method="paper",
        )
        published = replace(published, image=result.image)
        return replace(published, from_above=replace(flat, result=published)) if flat else published


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


@click.command("fit", cls=FitCommand)
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
@click.option("--jobs", type=click.IntRange(1), help="Images and hypotheses at a time; default: all cores.")
def fit_command(
    images: tuple[Path, ...],
    garment_type: str | None,
    templates: tuple[Path, ...],
    px_per_cm: float | None,
    folds: Folds,
    method: Literal["best", "paper"],
    mask: Path | None,
    out: Path | None,
    plot: bool,
    plot_stages: bool,
    report: Path | None,
    rerun: Path | None,
    timings: bool,
    jobs: int | None,
    **placing: Any,
) -> None:
    """Fit foldable templates to photographs of folded garments.

    A bad image does not stop the others: it is reported, and the exit status is 1 at the end.
    """
    from foldrs.fit_outputs import open_outputs
    from foldrs.pipeline import check_folds, check_scale, choose_templates

    if mask is not None and len(images) > 1:
        raise click.UsageError("--mask goes with a single IMAGE")
    plot = plot or plot_stages
    if plot and out is None:
        raise click.UsageError("--plot needs --out DIR to write to")
    try:
        check_scale(px_per_cm)
        check_folds(folds, method)
        chosen = choose_templates(templates or None, garment_type)
        known = known_of_table(placing, len(images))
        if out is not None:
            files = (mask, *(path for path in placing.values() if isinstance(path, Path)))
            read = (*images, *templates, *(path for path in files if path is not None))
            suffixes = (".json", *((".png",) if plot else ()), *((_STAGES_SUFFIX,) if plot_stages else ()))
            _check_outputs(images, out, suffixes, read)
            out.mkdir(parents=True, exist_ok=True)
        outputs = open_outputs(images, report, rerun)
    except (FoldrsError, OSError) as error:
        raise click.ClickException(str(error)) from error

    job = FitJob(chosen, px_per_cm, folds, method, mask, out, plot, plot_stages, known)
    failed = 0
    with _warnings_name_the_image(), outputs as show:
        for image, outcome in _run_all(job, images, jobs):
            if isinstance(outcome, BaseException):
                failed += 1
                click.secho(f"{image}: {_reason(outcome)}", fg="red", err=True)
                show(image, None, _reason(outcome))
                continue
            show(image, outcome)
            click.echo(_line(image, outcome))
            if timings:
                stages = ", ".join(f"{stage} {seconds:.3f} s" for stage, seconds in outcome.timings.items())
                click.echo(f"  {stages}")
    if failed:
        click.echo(f"{failed} of {len(images)} images failed", err=True)
        sys.exit(1)


def _check_outputs(images: Sequence[Path], out: Path, suffixes: Sequence[str], read: Sequence[Path]) -> None:
    """Refuse a call that would write a file twice, or over a file that it reads."""
    written: dict[Path, Path] = {}
    inputs = {path.resolve() for path in read}
    for image in images:
        for suffix in suffixes:
            path = out / f"{image.stem}{suffix}"
            if path in written:
                raise click.UsageError(
                    f"{written[path]} and {image} would both be written to {path}: "
                    "rename one, or use one call each with a folder of its own"
                )
            written[path] = image
            if path.resolve() in inputs:
                raise click.UsageError(
                    f"{path} is read here and would be overwritten: use another folder for --out"
                )


def _run_all(
    job: FitJob, images: tuple[Path, ...], jobs: int | None
) -> Iterator[tuple[Path, FitResult | BaseException]]:
    """Results, or what went wrong, in the order they are ready; a progress bar where it is of use."""
    from rich.console import Console
    from rich.progress import track

    from foldrs import _core
    from foldrs._workers import fitting_threads

    threads = _core.set_threads(jobs)
    with fitting_threads(min(jobs or threads, threads, len(images))) as pool:
        running = {pool.submit(job.run, image): image for image in images}
        console = Console(stderr=True)
        quiet = len(images) == 1 or not console.is_terminal
        for done in track(
            as_completed(running), "fitting", total=len(images), console=console, disable=quiet
        ):
            yield running[done], done.exception() or done.result()


@contextmanager
def _warnings_name_the_image() -> Iterator[None]:
    """Report what is doubtful about an image with its name, every time."""

    def show(message: Warning | str, category: type[Warning], *place: Any, **more: Any) -> None:
        if issubclass(category, GarmentCutOffWarning):
            click.secho(f"{_at_work.image}: warning: {message}", fg="yellow", err=True)
        else:
            show_others(message, category, *place, **more)

    with warnings.catch_warnings():
        show_others = warnings.showwarning
        warnings.showwarning = show
        warnings.simplefilter("always", GarmentCutOffWarning)
        yield


def _reason(error: BaseException) -> str:
    """Say what went wrong; an error that is not one of foldrs, so a defect, with its type."""
    return str(error) if isinstance(error, FoldrsError) else f"{type(error).__name__}: {error}"


def _folds_told(result: FitResult) -> str:
    if not result.folds:
        return "not folded,"
    if not result.accepted:
        return "no fold found better than none,"
    count = len(result.folds)
    return "folded" if count == 1 else f"folded {count} times,"


def _line(image: Path, result: FitResult) -> str:
    probability = result.alternatives[0].probability
    fold = _folds_told(result)
    pair = " + ".join(result.grasp_pairs[0].landmarks) if result.grasp_pairs else "none reachable"
    found = f"{result.garment_type}, {fold} p = {probability:.2f}, grasp {pair}"
    return f"{image.name}: {found}, {result.seconds:.2f} s"
