"""The tables as they are shown, and as CSV and JSON."""

from __future__ import annotations

import csv
import io
import json
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
from rich.cells import cell_len
from rich.console import Console
from rich.table import Table

from foldrs.evaluation.measures import SceneMeasures
from foldrs.evaluation.reliability import Reliability, reliability, reliability_of_pairs
from foldrs.evaluation.tables import Summary, table
from foldrs.whole_files import write_whole

Column = tuple[str, Callable[[Summary], str]]


def _number(value: float, digits: int = 1) -> str:
    return "-" if math.isnan(value) else f"{value:.{digits}f}"


def _with_deviation(value: float, deviation: float, digits: int = 1) -> str:
    return "-" if math.isnan(value) else f"{value:.{digits}f} ± {deviation:.{digits}f}"


_AXIS: tuple[Column, ...] = (
    ("n", lambda s: str(s.n)),
    ("EucDist (cm)", lambda s: _number(s.euc_dist_cm)),
    ("CLRm (%)", lambda s: _number(s.clr_matched)),
    ("CLRf (%)", lambda s: _number(s.clr_fitted)),
    ("dA (%)", lambda s: _with_deviation(s.da, s.da_deviation)),
    ("dθ (°)", lambda s: _with_deviation(s.dtheta, s.dtheta_deviation)),
    ("NMM", lambda s: str(s.nmm)),
    ("MCD (%)", lambda s: _number(s.mcd)),
)

_LANDMARKS: tuple[Column, ...] = (
    ("Pixels", lambda s: _with_deviation(s.landmark_px, s.landmark_px_deviation, 2)),
    ("cm", lambda s: _with_deviation(s.landmark_cm, s.landmark_cm_deviation, 2)),
)

_FURTHER: tuple[Column, ...] = (
    ("failed", lambda s: str(s.failed)),
    ("type (%)", lambda s: _number(s.type_rate)),
    ("seg IoU", lambda s: _number(s.segmentation_iou, 3)),
    ("top 3 (%)", lambda s: _number(s.clr_top3)),
    ("pair (%)", lambda s: _number(s.pair_rate)),
    ("unf IoU", lambda s: _number(s.unfolded_iou, 3)),
    ("crease (%)", lambda s: _number(s.crease_rate)),
    ("folds (%)", lambda s: _number(s.folds_rate)),
    ("missed (%)", lambda s: _number(s.missed_rate)),
    ("median s", lambda s: _number(s.seconds, 2)),
)

_TABLES = (
    ("Table 1: fold axis localisation", _AXIS),
    ("Table 2: landmark point error distance", _LANDMARKS),
    ("Further measures", _FURTHER),
)


@dataclass(frozen=True)
class TextTable:
    """A table in words: its cells as they are shown."""

    title: str
    header: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    """One a kind, the last of all scenes."""


def text_tables(rows: Sequence[SceneMeasures]) -> list[TextTable]:
    """Table 1, Table 2 and the further measures, per kind and overall."""
    summaries = table(rows)
    return [
        TextTable(
            title,
            ("Type", *(name for name, _ in columns)),
            tuple(
                (kind.capitalize(), *(cell(one) for _, cell in columns)) for kind, one in summaries.items()
            ),
        )
        for title, columns in _TABLES
    ]


def print_tables(rows: Sequence[SceneMeasures], console: Console) -> None:
    """Print Table 1, Table 2 and the further measures, per kind and overall, and what probabilities mean."""
    for content in text_tables(rows):
        for part in _parts(content, console.width):
            console.print(_rich_table(part))
    for of, bins in _meanings(rows):
        if not bins:
            continue
        meaning = Table(title=f"Probabilities of {of}: said, and happened", title_justify="left")
        meaning.add_column("said (%)")
        for one in bins:
            meaning.add_column(_number(100 * one.said), justify="right")
        meaning.add_row("right (%)", *(_number(100 * one.happened) for one in bins))
        meaning.add_row("cases", *(str(one.cases) for one in bins))
        console.print(meaning)


def _meanings(rows: Sequence[SceneMeasures]) -> tuple[tuple[str, list[Reliability]], ...]:
    """Tell of what probabilities are told, and what they mean."""
    return (
        ("all alternatives", reliability(rows)),
        ("the chosen explanations", reliability(rows, first_only=True)),
        ("the first grasp pairs", reliability_of_pairs(rows)),
    )


def write_csv(rows: Sequence[SceneMeasures], path: Path) -> None:
    """Write one line a scene; empty cells are measures that do not apply."""
    text = io.StringIO()
    records = [_record(row) for row in rows]
    writer = csv.DictWriter(text, fieldnames=list(records[0]), lineterminator="\n")
    writer.writeheader()
    writer.writerows(records)
    write_whole(path, text.getvalue().encode())


def write_json(rows: Sequence[SceneMeasures], options: Mapping[str, Any], path: Path) -> None:
    """Write the options of the run, the table (kinds and overall) and one record a scene."""
    content = {
        "schema": 1,
        "options": dict(options),
        "table": {kind: summary.to_dict() for kind, summary in table(rows).items()},
        "reliability": [asdict(one) for one in reliability(rows)],
        "reliability_of_chosen": [asdict(one) for one in reliability(rows, first_only=True)],
        "reliability_of_pairs": [asdict(one) for one in reliability_of_pairs(rows)],
        "scenes": [{**_record(row), "landmarks_px": list(row.landmarks_px)} for row in rows],
    }
    write_whole(path, json.dumps(content, indent=1, ensure_ascii=False, allow_nan=False).encode())


def _parts(content: TextTable, width: int) -> list[TextTable]:
    """Take a table that is wider than the page apart: some measures each, every part with the kinds."""
    lines = (content.header, *content.rows)
    # Every cell has a space on either side and a rule behind it; one more rule stands before the first.
    needed = [max(map(cell_len, column)) + 3 for column in zip(*lines, strict=True)]
    parts: list[list[int]] = [[]]
    for index in range(1, len(needed)):
        if parts[-1] and 1 + needed[0] + sum(needed[one] for one in (*parts[-1], index)) > width:
            parts.append([])
        parts[-1].append(index)
    return [
        TextTable(
            content.title if number == 0 else f"{content.title}, continued",
            _taken(content.header, part),
            tuple(_taken(row, part) for row in content.rows),
        )
        for number, part in enumerate(parts)
    ]


def _taken(row: tuple[str, ...], part: Sequence[int]) -> tuple[str, ...]:
    return (row[0], *(row[index] for index in part))


def _rich_table(content: TextTable) -> Table:
    shown = Table(title=content.title, title_justify="left")
    kind, *measures = content.header
    shown.add_column(kind, no_wrap=True)
    for name in measures:
        shown.add_column(name, justify="right", no_wrap=True)
    *kinds, overall = content.rows
    for row in kinds:
        shown.add_row(*row)
    shown.add_section()
    shown.add_row(*overall)
    return shown


def _record(row: SceneMeasures) -> dict[str, Any]:
    """One scene flat, by the names the measures have in the tables."""
    return {
        "scene": row.scene,
        "type": row.garment_type,
        "garment": row.garment,
        "scenario": row.scenario,
        "error": row.error,
        "predicted_type": row.predicted_type,
        "type_right": row.type_right,
        "seg_iou": row.segmentation_iou,
        "euc_dist_cm": row.template_distance_cm,
        "dA_m": _finite(row.axis_error_matched),
        "dA": _finite(row.axis_error),
        "dtheta": row.axis_angle,
        "right_m": row.right_matched,
        "right_f": row.right,
        "right_top3": row.right_in_first,
        "mismatch": row.mismatch,
        "mcd": row.cost_decrease,
        "landmarks": len(row.landmarks_px),
        "landmark_px": float(np.mean(row.landmarks_px)) if row.landmarks_px else None,
        "landmark_cm": float(np.mean(row.landmarks_cm)) if row.landmarks_cm else None,
        "pair_due": row.pair_due,
        "pair_right": row.pair_right,
        "pair_said": row.pair_said,
        "unf_iou": row.unfolded_iou,
        "folds": row.folds,
        "folds_found": row.folds_found,
        "creases": len(row.creases_met) if row.folds == 2 else None,
        "creases_met": sum(row.creases_met) if row.folds == 2 else None,
        "missed_nats": _finite(row.missed_nats),
        "seconds": row.seconds,
    }


def _finite(value: float | None) -> float | None:
    """JSON knows no infinity: dA on a template without area."""
    return value if value is not None and math.isfinite(value) else None
