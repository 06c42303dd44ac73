"""Means over scenes: a summary for every kind of garment and one overall (Tables 1 and 2 and more)."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, fields

import numpy as np

from foldrs.evaluation.measures import SceneMeasures
from foldrs.evaluation.search import SAME_NATS

OVERALL = "overall"
"""Name of the last row of every table."""


@dataclass(frozen=True)
class Summary:
    """Means over some scenes; rates in %, NaN where nothing is to be averaged.

    "Right cases" are those whose axis is right after fitting. Deviations are those of the population.
    """

    n: int
    failed: int
    """Scenes without prediction; every rate counts them as failures."""
    type_rate: float
    segmentation_iou: float
    euc_dist_cm: float
    """Mean distance of the outlines of template and garment before folding."""
    clr_matched: float
    """CLRm: axis right on the original template."""
    clr_fitted: float
    """CLRf: axis right on the fitted template."""
    clr_top3: float
    """As CLRf, for the best of the first three alternatives."""
    da: float
    """dA, % of the template's area, right cases."""
    da_deviation: float
    dtheta: float
    """Degrees, right cases."""
    dtheta_deviation: float
    nmm: int
    """Mismatches: wrong cases with a right one among their alternatives."""
    mcd: float
    """Decrease of the matching cost by fitting, %, all cases."""
    landmark_px: float
    """Error of landmarks on the outline, right cases."""
    landmark_px_deviation: float
    landmark_cm: float
    landmark_cm_deviation: float
    pair_rate: float
    unfolded_iou: float
    crease_rate: float
    """Creases met in scenes folded twice."""
    folds_rate: float
    """Right number of folds."""
    missed_rate: float
    """Scenes for which a start from the truth ends better than anything that was found."""
    seconds: float
    """Median."""

    def to_dict(self) -> dict[str, float | int | None]:
        """Return the summary as JSON takes it: None for NaN."""
        values = {f.name: getattr(self, f.name) for f in fields(self)}
        return {name: None if math.isnan(value) else value for name, value in values.items()}


def table(rows: Sequence[SceneMeasures]) -> dict[str, Summary]:
    """Summarise every kind, by name, and all scenes."""
    kinds = sorted({row.garment_type for row in rows})
    by_kind = {kind: summary([row for row in rows if row.garment_type == kind]) for kind in kinds}
    return {**by_kind, OVERALL: summary(rows)}


def summary(rows: Sequence[SceneMeasures]) -> Summary:
    """Average over some scenes."""
    right = [row for row in rows if row.right]
    px = [error for row in right for error in row.landmarks_px]
    cm = [error for row in right for error in row.landmarks_cm]
    areas = [100 * row.axis_error for row in right if row.axis_error is not None]
    angles = [row.axis_angle for row in right if row.axis_angle is not None]
    seconds = [row.seconds for row in rows if row.seconds is not None]
    return Summary(
        n=len(rows),
        failed=sum(bool(row.error) for row in rows),
        type_rate=_rate(row.type_right for row in rows),
        segmentation_iou=_mean([row.segmentation_iou for row in rows]),
        euc_dist_cm=_mean([row.template_distance_cm for row in rows]),
        clr_matched=_rate(row.right_matched for row in rows),
        clr_fitted=_rate(row.right for row in rows),
        clr_top3=_rate(row.right_in_first for row in rows),
        da=_mean(areas),
        da_deviation=_deviation(areas),
        dtheta=_mean(angles),
        dtheta_deviation=_deviation(angles),
        nmm=sum(bool(row.mismatch) for row in rows),
        mcd=_mean([row.cost_decrease for row in rows]),
        landmark_px=_mean(px),
        landmark_px_deviation=_deviation(px),
        landmark_cm=_mean(cm),
        landmark_cm_deviation=_deviation(cm),
        pair_rate=_rate(row.pair_right for row in rows if row.pair_due),
        unfolded_iou=_mean([row.unfolded_iou for row in rows]),
        crease_rate=_rate(met for row in rows for met in row.creases_met),
        folds_rate=_rate(row.folds_found == row.folds for row in rows),
        missed_rate=_rate(None if row.missed_nats is None else row.missed_nats > SAME_NATS for row in rows),
        seconds=float(np.median(seconds)) if seconds else math.nan,
    )


def _rate(outcomes: Iterable[bool | None]) -> float:
    """Share of successes in %; None was not asked for."""
    asked = [outcome for outcome in outcomes if outcome is not None]
    return 100 * sum(asked) / len(asked) if asked else math.nan


def _mean(values: Sequence[float | None]) -> float:
    known = [value for value in values if value is not None]
    return float(np.mean(known)) if known else math.nan


def _deviation(values: Sequence[float]) -> float:
    return float(np.std(values)) if values else math.nan
