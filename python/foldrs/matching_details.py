"""What of the matching stage a picture can show: candidate creases and the pieces matched (section 2.1.1)."""

from __future__ import annotations

from dataclasses import asdict

import numpy as np
from numpy.typing import NDArray

from foldrs import _core
from foldrs.parameters import Parameters
from foldrs.plot import MatchingDetails
from foldrs.registration import perimeter
from foldrs.result import FitResult

Points = NDArray[np.float64]

_SHOWN = 3
"""Pieces shown: more would hide each other."""


def matching_details(result: FitResult, parameters: Parameters | None = None) -> MatchingDetails:
    """Match the seen outline once more with the template of a result, on the face it was explained by.

    Parameters
    ----------
    result : FitResult
        The result to be drawn.
    parameters : Parameters, optional
        Those of the fit.

    Returns
    -------
    MatchingDetails
        The candidate creases, and for the best matches the piece of the seen outline with that of the
        template as given (template units); px, of the view from above if the result was found in it.
    """
    parameters = parameters or Parameters()
    if result.from_above is not None:
        result = result.from_above.result
    given, placed = result.original_template.outline, result.unfolded_outline_image
    scale = np.sqrt(abs(_core.signed_area(placed) / _core.signed_area(result.template.outline)))
    mirrored = _core.signed_area(placed) * _core.signed_area(result.template.outline) < 0
    way = np.array([-1.0 if mirrored else 1.0, 1.0])

    seen = _core.resample(_positive(result.outline_image * way), parameters.matching.partial_match.points)
    template = _positive(given)
    spacing = perimeter(seen) / len(seen)
    length = perimeter(template) * scale
    points = _core.resample(template, max(20, round(length / spacing)))

    matches: list[tuple[Points, Points]] = []
    taken = np.zeros(len(seen), np.bool_)
    for start, template_start, count, *_ in _core.partial_matches(seen, points, asdict(parameters.matching)):
        piece = (start + np.arange(count)) % len(seen)
        if len(matches) < _SHOWN and not taken[piece].any():
            taken[piece] = True
            partner = (template_start + np.arange(count)) % len(points)
            matches.append((seen[piece] * way, points[partner]))
    return MatchingDetails(sides=result.candidate_creases, matches=tuple(matches))


def _positive(outline: Points) -> Points:
    return outline if _core.signed_area(outline) > 0 else outline[::-1].copy()
