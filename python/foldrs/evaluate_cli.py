"""The command ``foldrs evaluate``: the paper's tables for scenes, or for templates folded virtually."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Literal

import click

from foldrs._camera_options import reference_of, reference_options
from foldrs._options import (
    about,
    check_marker,
    folds_option,
    make_folder,
    px_per_cm_option,
    report_option,
    same_file,
    template_option,
)
from foldrs.errors import FoldrsError

if TYPE_CHECKING:
    from collections.abc import Sequence

    from foldrs.evaluation import Evaluation, Scene, SceneMeasures
    from foldrs.joint_fit import Folds
    from foldrs.result import FitResult
    from foldrs.template import Template

    Scenes = Sequence[Scene] | Sequence[tuple[Scene, Template]]

_PROTOCOLS = ("synthetic", "own", "generic", "open")  # as in foldrs.evaluation, which loads the whole method

_WIDTH = 160
"""Columns of text where no terminal says how many there are: the widest table has room."""


@click.command("evaluate")
@click.argument("scenes", required=False, type=click.Path(path_type=Path), metavar="SCENES")
@click.option(
    "--protocol",
    type=click.Choice(_PROTOCOLS),
    default="generic",
    show_default=True,
    help="synthetic: templates folded virtually, no SCENES read; own: each garment's own flat outline is its "
    "template; generic: the kind is given; open: all templates compete.",
)
@template_option
@px_per_cm_option
@click.option("--method", type=click.Choice(["best", "paper"]), default="best", show_default=True)
@folds_option(default="given", help="Folds to undo; given: as many as the scene has; auto: to be found.")
@click.option(
    "--outlines", is_flag=True, help="Use the true outlines, not the photographs: the matching alone."
)
@click.option(
    "--uncalibrated",
    is_flag=True,
    help="Do not use the homographies and depth images beside the scenes, as if they were not known.",
)
@click.option(
    "--search",
    is_flag=True,
    help="Also fit from the truth and tell what the search missed: the rate of scenes where that ends better "
    "than anything found. Implies --outlines.",
)
@reference_options
@click.option(
    "--count", type=click.IntRange(1), default=60, show_default=True, help="Folds of --protocol synthetic."
)
@click.option(
    "--seed", type=click.IntRange(0), default=0, show_default=True, help="Seed of --protocol synthetic."
)
@click.option("--jobs", type=click.IntRange(1), help="Scenes and hypotheses at a time; default: all cores.")
@click.option(
    "--out",
    type=click.Path(path_type=Path, file_okay=False),
    help="Folder for evaluation.csv, evaluation.json and the predictions, NAME.json.",
)
@report_option
def evaluate_command(
    scenes: Path | None,
    protocol: Literal["synthetic", "own", "generic", "open"],
    templates: tuple[Path, ...],
    px_per_cm: float | None,
    method: Literal["best", "paper"],
    folds: Folds | Literal["given"],
    outlines: bool,
    uncalibrated: bool,
    search: bool,
    marker_cm: float | None,
    marker_family: str | None,
    a4: bool,
    count: int,
    seed: int,
    jobs: int | None,
    out: Path | None,
    report: Path | None,
) -> None:
    """Measure how well folds are found, and print Tables 1 and 2 of the paper, per kind and overall.

    SCENES is a folder of photographs NAME.jpg (or .png, ...) with the truth about each in NAME.json. A scene
    that cannot be explained counts as a failure in every rate and is listed with the reason.
    """
    from rich.console import Console

    from foldrs.evaluation import Evaluation, load_scenes, print_tables, virtual_scenes, write_csv, write_json
    from foldrs.evaluation.virtual import PX_PER_CM
    from foldrs.pipeline import check_folds, check_scale, choose_templates

    found: Scenes
    check_marker(marker_cm, marker_family)
    try:
        with about("--px-per-cm"):
            check_scale(px_per_cm)
        if folds != "given":
            with about("--folds"):
                check_folds(folds, method)
        chosen = choose_templates(templates or None, None, method)
        reference = reference_of(marker_cm, marker_family, a4)
        if search and (method != "best" or protocol == "open" or folds not in ("given", 1)):
            raise click.UsageError("--search measures the method best with the kind given and one fold")
        outlines = outlines or search
        if protocol == "synthetic":
            found, px_per_cm, outlines = virtual_scenes(chosen, count, seed), PX_PER_CM, True
        elif scenes is None:
            raise click.UsageError(f"--protocol {protocol} needs SCENES")
        else:
            found = load_scenes(scenes)
    except FoldrsError as error:
        raise click.ClickException(str(error)) from error
    if out is not None:
        _check_spared(out, scenes, found)
        make_folder(out, "--out")
    if report is not None:
        make_folder(report.parent, "--report")

    evaluation = Evaluation(
        protocol,
        chosen,
        px_per_cm,
        method,
        folds,
        true_outlines=outlines,
        calibrated=not uncalibrated,
        reference=reference,
        search=search,
        out=out,
    )
    if report is None:
        rows = _run(evaluation, found, jobs)
    else:
        rows = _run_with_page(evaluation, found, jobs, report)
    console = Console()
    print_tables(rows, console if console.is_terminal else Console(width=_WIDTH))
    for row in rows:
        if row.error:
            click.secho(f"{row.scene}: {row.error}", fg="red", err=True)
    if out is not None:
        options = {
            "protocol": protocol,
            "method": method,
            "folds": folds,
            "px_per_cm": px_per_cm,
            "true_outlines": outlines,
        }
        options |= {"calibrated": not uncalibrated, "marker_cm": marker_cm, "a4": a4}
        if protocol == "synthetic":
            options |= {"count": count, "seed": seed}
        write_csv(rows, out / "evaluation.csv")
        write_json(rows, options, out / "evaluation.json")


def _check_spared(out: Path, folder: Path | None, scenes: Scenes) -> None:
    """Refuse predictions that would take the place of the truth, or of another file not made here."""
    from foldrs.fit_files import may_replace

    if folder is not None and same_file(out, folder):
        raise click.UsageError(
            f"--out {out} is the folder of the scenes, whose truth the predictions would overwrite: use "
            "another folder"
        )
    for scene in scenes:
        path = out / f"{(scene[0] if isinstance(scene, tuple) else scene).name}.json"
        if not may_replace(path):
            raise click.UsageError(
                f"{path} is no prediction of foldrs and would be overwritten: move it, or use another folder "
                "for --out"
            )


def _run_with_page(
    evaluation: Evaluation, scenes: Scenes, jobs: int | None, path: Path
) -> list[SceneMeasures]:
    """As :func:`_run`, and write the page of all scenes by name."""
    from foldrs.report import Report

    title = f"Evaluation: protocol {evaluation.protocol}, method {evaluation.method}"
    names = sorted((one[0] if isinstance(one, tuple) else one).name for one in scenes)
    place = {name: position for position, name in enumerate(names)}
    with Report(path, title) as page:

        def add(scene: Scene, result: FitResult | None, row: SceneMeasures) -> None:
            page.add(result, scene.image, scene=scene, measures=row, position=place[scene.name])

        return _run(replace(evaluation, watch=add), scenes, jobs)


def _run(evaluation: Evaluation, scenes: Scenes, jobs: int | None) -> list[SceneMeasures]:
    """Measures of all scenes by name, with a progress bar if there is a terminal to see it."""
    from rich.console import Console
    from rich.progress import track

    from foldrs.evaluation import run_all

    console = Console(stderr=True)
    running = run_all(evaluation, scenes, jobs)
    shown = track(running, "evaluating", total=len(scenes), console=console, disable=not console.is_terminal)
    return sorted(shown, key=lambda row: row.scene)
