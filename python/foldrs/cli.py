"""The command line: ``foldrs fit``, ``foldrs template show``, and the commands of `foldrs.synth_cli`."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor, as_completed
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Literal

import click

from foldrs import __version__
from foldrs.errors import FoldrsError
from foldrs.evaluate_cli import evaluate_command
from foldrs.synth_cli import demo_command, synth_command

if TYPE_CHECKING:
    from foldrs.result import FitResult
    from foldrs.template import Template


@click.group(context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(__version__, prog_name="foldrs")
def main() -> None:
    """Tell which garment lies folded on a table, where it is folded, and where to grasp it."""


main.add_command(demo_command)
main.add_command(evaluate_command)
main.add_command(synth_command)


@dataclass(frozen=True)
class FitJob:
    """What is the same for every image of one call."""

    templates: list[Template]
    px_per_cm: float | None
    method: Literal["best", "paper"]
    mask: Path | None
    out: Path | None
    plot: bool

    def run(self, image: Path) -> FitResult:
        """Fit one image and write its files."""
        from foldrs.pipeline import fit

        result = fit(
            image, templates=self.templates, px_per_cm=self.px_per_cm, method=self.method, mask=self.mask
        )
        if self.out is not None:
            if self.plot:
                from foldrs.plot import save_picture

                save_picture(result, image, self.out / f"{image.stem}.png")
            result.save(self.out / f"{image.stem}.json")
        return result


@main.command("fit")
@click.argument("images", nargs=-1, required=True, type=click.Path(path_type=Path), metavar="IMAGE...")
@click.option("--type", "garment_type", metavar="KIND", help="Match templates of this kind only.")
@click.option(
    "--template",
    "templates",
    multiple=True,
    type=click.Path(path_type=Path),
    help="Template file to use instead of the built-in ones; may be repeated.",
)
@click.option("--px-per-cm", type=float, help="Known scale; without it the scale is found.")
@click.option("--method", type=click.Choice(["best", "paper"]), default="best", show_default=True)
@click.option(
    "--mask", type=click.Path(path_type=Path), help="The garment's mask (image file) for a single IMAGE."
)
@click.option(
    "--out", type=click.Path(path_type=Path, file_okay=False), help="Folder for STEM.json (and STEM.png)."
)
@click.option("--plot", is_flag=True, help="Also write the picture of the result to --out.")
@click.option("--jobs", type=click.IntRange(1), help="Images and hypotheses at a time; default: all cores.")
def fit_command(
    images: tuple[Path, ...],
    garment_type: str | None,
    templates: tuple[Path, ...],
    px_per_cm: float | None,
    method: Literal["best", "paper"],
    mask: Path | None,
    out: Path | None,
    plot: bool,
    jobs: int | None,
) -> None:
    """Fit foldable templates to photographs of folded garments.

    A bad image does not stop the others: it is reported, and the exit status is 1 at the end.
    """
    from foldrs.pipeline import check_scale, choose_templates

    if mask is not None and len(images) > 1:
        raise click.UsageError("--mask goes with a single IMAGE")
    if plot and out is None:
        raise click.UsageError("--plot needs --out DIR to write to")
    try:
        check_scale(px_per_cm)
        chosen = choose_templates(templates or None, garment_type)
    except FoldrsError as error:
        raise click.ClickException(str(error)) from error
    if out is not None:
        out.mkdir(parents=True, exist_ok=True)

    job = FitJob(chosen, px_per_cm, method, mask, out, plot)
    failed = 0
    for image, outcome in _run_all(job, images, jobs):
        if isinstance(outcome, FoldrsError):
            failed += 1
            click.secho(f"{image}: {outcome}", fg="red", err=True)
        else:
            click.echo(_line(image, outcome))
    if failed:
        click.echo(f"{failed} of {len(images)} images failed", err=True)
        sys.exit(1)


def _run_all(
    job: FitJob, images: tuple[Path, ...], jobs: int | None
) -> Iterator[tuple[Path, FitResult | FoldrsError]]:
    """Results in the order they are ready, with a progress bar if there are several and a terminal to see it."""
    from rich.console import Console
    from rich.progress import track

    from foldrs import _core

    threads = _core.set_threads(jobs)
    with ThreadPoolExecutor(min(threads, len(images))) as pool:
        running = {pool.submit(job.run, image): image for image in images}
        console = Console(stderr=True)
        quiet = len(images) == 1 or not console.is_terminal
        for done in track(
            as_completed(running), "fitting", total=len(images), console=console, disable=quiet
        ):
            error = done.exception()
            if error is not None and not isinstance(error, FoldrsError):
                raise error
            yield running[done], error if isinstance(error, FoldrsError) else done.result()


def _line(image: Path, result: FitResult) -> str:
    probability = result.alternatives[0].probability
    fold = "folded" if result.accepted else "no fold found better than none,"
    pair = " + ".join(result.grasp_pairs[0].landmarks) if result.grasp_pairs else "none reachable"
    return f"{image.name}: {result.garment_type}, {fold} p = {probability:.2f}, grasp {pair}, {result.seconds:.2f} s"


@main.group("template")
def template_group() -> None:
    """Look at template files."""


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

    try:
        chosen = load_template(template) if Path(template).suffix else builtin_templates(template)[0]
        path = out or Path(f"{chosen.name}.png")
        save_template_picture(chosen, path)
    except FoldrsError as error:
        raise click.ClickException(str(error)) from error
    click.echo(f"wrote {path}")
