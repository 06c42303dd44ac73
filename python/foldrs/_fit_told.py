"""What ``foldrs fit`` prints of every image: a line, a line of JSON, or nothing, and of errors always."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import click

from foldrs.errors import FoldrsError

if TYPE_CHECKING:
    from foldrs.result import FitResult

_SCROLLED = 20
"""After more images than this, errors have scrolled out of sight and are listed again at the end."""


@dataclass(frozen=True)
class Entry:
    """What is told of one image."""

    image: Path
    result: FitResult | None = None
    error: BaseException | None = None
    """Why there is no result, or, beside one, no picture."""
    kept: dict[str, Any] | None = None
    """The JSON form of a result that was there already."""


def tell(
    entries: Iterable[Entry],
    told: Literal["nothing", "json"] | None,
    timings: bool,
    errors_file: Path | None,
    name: Callable[[Path], str] | None = None,
) -> int:
    """Print what became of every image, by its file's or another name, and return how many failed."""
    failures: list[tuple[Path, BaseException]] = []
    total = kept = 0
    for entry in entries:
        total += 1
        kept += entry.kept is not None
        if entry.error is not None:
            failures.append((entry.image, entry.error))
            click.secho(f"{entry.image}: {reason(entry.error)}", fg="red", err=True)
        if told == "json":
            named = {} if name is None else {"image": name(entry.image)}
            click.echo(json.dumps(_json(entry) | named, separators=(",", ":")))
        elif told is None and entry.result is not None:
            shown = entry.image.name if name is None else name(entry.image)
            click.echo(_line(shown, entry.result))
            if timings:
                stages = entry.result.timings.items()
                click.echo("  " + ", ".join(f"{stage} {seconds:.3f} s" for stage, seconds in stages))
    if kept and told != "nothing":
        click.echo(f"{kept} of {total} images were done already", err=True)
    if failures:
        _list_failures(failures, total, errors_file)
    return len(failures)


def _json(entry: Entry) -> dict[str, Any]:
    from foldrs.fit_files import error_entry

    if entry.error is not None and entry.result is None:  # one with a result lacks a picture only
        return dict(error_entry(entry.image, entry.error))
    if entry.kept is not None:
        return {key: value for key, value in entry.kept.items() if key != "made_by"}
    return {} if entry.result is None else entry.result.to_dict()


def _list_failures(failures: list[tuple[Path, BaseException]], total: int, errors_file: Path | None) -> None:
    if total > _SCROLLED:
        counts = Counter(type(error).__name__ for _, error in failures).most_common()
        click.echo("failed: " + ", ".join(f"{count} {name}" for name, count in counts), err=True)
        for image, error in failures:
            click.secho(f"{image}: {reason(error)}", fg="red", err=True)
    listed = "" if errors_file is None else f", listed in {errors_file}"
    click.echo(f"{len(failures)} of {total} images failed{listed}", err=True)


def reason(error: BaseException) -> str:
    """Say what went wrong; an error that is not one of foldrs, so a defect, with its type."""
    return str(error) if isinstance(error, FoldrsError) else f"{type(error).__name__}: {error}"


def _line(image: str, result: FitResult) -> str:
    probability = result.alternatives[0].probability
    pair = pair_told(result)
    found = f"{result.garment_type}, {_folds_told(result)} p = {probability:.2f}, grasp {pair}"
    return f"{image}: {found}, {result.seconds:.2f} s"


def pair_told(result: FitResult) -> str:
    """Name the best grasp pair, with its probability where there is one."""
    if not result.grasp_pairs:
        return "none reachable"
    best = result.grasp_pairs[0]
    sure = "" if best.probability is None else f" (p = {best.probability:.2f})"
    return " + ".join(best.landmarks) + sure


def _folds_told(result: FitResult) -> str:
    if not result.folds:
        return "not folded,"
    if not result.accepted:
        return "no fold found better than none,"
    count = len(result.folds)
    return "folded" if count == 1 else f"folded {count} times,"
