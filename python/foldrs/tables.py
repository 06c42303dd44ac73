"""Results as rows of a table."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from foldrs.result import FitResult


def table(results: Iterable[FitResult | BaseException]) -> list[dict[str, Any]]:
    """One flat row a result or error, ready for ``pandas.DataFrame(...)`` or :class:`csv.DictWriter`.

    Parameters
    ----------
    results : iterable of FitResult or Exception
        As :func:`foldrs.fit_many` yields them.

    Returns
    -------
    list of dict
        All rows have the same keys, and plain numbers, booleans and strings, or None where there is nothing
        to tell. ``error`` and ``message`` are None for results, all but these and ``image`` for errors.
        Coordinates are image px: ``crease_x1``, ``crease_y1``, ``crease_x2``, ``crease_y2`` of the last fold,
        ``grasp_x1`` ... of the best pair, whose landmarks are ``grasp_1`` and ``grasp_2``.

    Examples
    --------
    >>> import foldrs
    >>> square = [[0, 0], [90, 0], [90, 60], [0, 60]]
    >>> rows = foldrs.table(foldrs.fit_many([square, [[0, 0]]], garment_type="towel"))
    >>> [(row["garment_type"], row["error"]) for row in rows]
    [('towel', None), (None, 'InvalidOutlineError')]
    """
    return [_row(result) for result in results]


def _row(result: FitResult | BaseException) -> dict[str, Any]:
    if isinstance(result, BaseException):
        told = {"image": getattr(result, "image", ""), "error": type(result).__name__, "message": str(result)}
        return dict.fromkeys(_KEYS) | told
    row: dict[str, Any] = {
        "image": result.image,
        "garment_type": result.garment_type,
        "accepted": result.accepted,
        "probability": result.alternatives[0].probability,
        "matching_cost": result.matching_cost,
        "folds": len(result.folds),
        "seconds": result.seconds,
    }
    if result.fold is not None:
        row |= {"flap_on_top": result.fold.flap_on_top}
        row |= _points("crease", result.fold.axis_image.tolist())
    if result.grasp_pairs:
        best = result.grasp_pairs[0]
        row |= {"grasp_1": best.landmarks[0], "grasp_2": best.landmarks[1]}
        row |= {"grasp_probability": best.probability}
        row |= _points("grasp", best.image.tolist())
    return dict.fromkeys(_KEYS) | row


def _points(name: str, ends: list[list[float]]) -> dict[str, float]:
    return {
        f"{name}_{axis}{k}": value
        for k, end in enumerate(ends, 1)
        for axis, value in zip("xy", end, strict=True)
    }


_KEYS = (
    "image",
    "garment_type",
    "accepted",
    "probability",
    "matching_cost",
    "folds",
    "flap_on_top",
    *(f"crease_{end}" for end in ("x1", "y1", "x2", "y2")),
    "grasp_1",
    "grasp_2",
    "grasp_probability",
    *(f"grasp_{end}" for end in ("x1", "y1", "x2", "y2")),
    "seconds",
    "error",
    "message",
)
"""The columns, in their order."""
