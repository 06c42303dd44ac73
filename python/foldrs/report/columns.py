"""What the page tells of every image in numbers and words, to read, to sort by and to filter by."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

if TYPE_CHECKING:
    from foldrs.evaluation import SceneMeasures
    from foldrs.result import FitResult

Value: TypeAlias = str | float | None
"""None where a column does not apply: sorted last."""

FOLDED, NOT_FOLDED, FAILED = "fold accepted", "no fold found better", "failed"
RIGHT, WRONG = "right", "wrong"


@dataclass(frozen=True)
class Column:
    """One column of the table of images."""

    name: str
    label: str
    digits: int | None = None
    """Decimals of a number; None for words."""

    def text(self, value: Value) -> str:
        """Return a value as it is shown."""
        if value is None:
            return "-"
        return f"{value:.{self.digits}f}" if isinstance(value, (int, float)) else value


def verdict(result: FitResult | None, measures: SceneMeasures | None) -> str:
    """Say in a word how it went: right or wrong where the truth is known."""
    if result is None:
        return FAILED
    if measures is None:
        return FOLDED if result.accepted else NOT_FOLDED
    if measures.folds == 0:
        return RIGHT if measures.folds_found == 0 else WRONG
    if measures.folds == 2:
        return RIGHT if measures.creases_met and all(measures.creases_met) else WRONG
    return RIGHT if measures.right else WRONG


_OF_RESULTS: tuple[tuple[Column, Callable[[FitResult], Value]], ...] = (
    (Column("kind", "kind"), lambda r: r.garment_type),
    (Column("probability", "probability (%)", 0), lambda r: _percent(_probability(r))),
    (Column("pair", "grasp pair"), lambda r: _pair(r)),
    (Column("in_reach", "in reach (%)", 0), lambda r: _percent(_in_reach(r))),
    (Column("cost", "matching cost", 3), lambda r: r.matching_cost),
    (Column("seconds", "seconds", 2), lambda r: r.seconds),
)

_OF_MEASURES: tuple[tuple[Column, Callable[[SceneMeasures], Value]], ...] = (
    (Column("true_kind", "true kind"), lambda m: m.garment_type),
    (Column("dA", "dA (%)", 1), lambda m: _percent(m.axis_error)),
    (Column("dtheta", "dθ (°)", 1), lambda m: m.axis_angle),
    (
        Column("landmarks", "landmarks off (cm)", 2),
        lambda m: float(np.mean(m.landmarks_cm)) if m.landmarks_cm else None,
    ),
    (Column("unfolded", "unfolded IoU (%)", 0), lambda m: 100 * m.unfolded_iou if m.type_right else None),
    (Column("outline", "outline IoU (%)", 1), lambda m: None if m.error else 100 * m.segmentation_iou),
)


def columns(measured: bool) -> tuple[Column, ...]:
    """Return the columns of a page, those of the measures too if the truth is known."""
    further = tuple(column for column, _ in _OF_MEASURES) if measured else ()
    own = tuple(column for column, _ in _OF_RESULTS)
    return (Column("name", "image"), Column("verdict", "verdict"), *own, *further)


def values(name: str, result: FitResult | None, measures: SceneMeasures | None) -> dict[str, Value]:
    """Return the values of one image by the columns' names."""
    found: dict[str, Value] = {"name": name, "verdict": verdict(result, measures)}
    for column, of_result in _OF_RESULTS:
        found[column.name] = None if result is None else of_result(result)
    if measures is not None:
        for column, of_measures in _OF_MEASURES:
            found[column.name] = of_measures(measures)
    return {column: _finite(value) for column, value in found.items()}


def _finite(value: Value) -> Value:
    """JSON knows no infinity: dA on a template without area."""
    return None if isinstance(value, float) and not np.isfinite(value) else value


def _pair(result: FitResult) -> str:
    return " + ".join(result.grasp_pairs[0].landmarks) if result.grasp_pairs else "none in reach"


def _in_reach(result: FitResult) -> float | None:
    return result.grasp_pairs[0].probability if result.grasp_pairs else None


def _probability(result: FitResult) -> float | None:
    return result.alternatives[0].probability if result.alternatives else None


def _percent(share: float | None) -> float | None:
    return None if share is None else 100 * share
