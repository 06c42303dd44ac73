"""From the values of a template file to typed ones; every error names the field at fault.

These functions look at one value at a time. What the values must be to each other (an outline that does not
cross itself, landmarks on it) is checked by :class:`foldrs.template.Template`.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from numbers import Real

import numpy as np
import numpy.typing as npt

from foldrs.errors import TemplateError

Pairs = tuple[tuple[str, str], ...]


def field_error(field: str, problem: str) -> TemplateError:
    """Return the error whose sentence starts with the field it is about."""
    return TemplateError(f"{field}: {problem}", field)


def required(data: Mapping[str, object], field: str) -> object:
    """Return ``data[field]``, or say that it is missing."""
    if field not in data:
        raise field_error(field, "missing; a template file must give it")
    return data[field]


def parse_word(value: object, field: str, what: str = "") -> str:
    """Return a text of printable characters that is not blank; `what` says which of the field it is."""
    must = f"{what} must" if what else "must"
    if not isinstance(value, str) or not value.strip():
        raise field_error(field, f"{must} be a text that is not empty, not {shown(value)}")
    if not value.isprintable():
        raise field_error(
            field, f"{must} be of printable characters, without line breaks, not {shown(value)}"
        )
    return value


def parse_points(value: object, field: str) -> npt.NDArray[np.float64]:
    """Return a list of ``[x, y]`` as an (n, 2) array."""
    points = [parse_point(point, f"{field}[{i}]") for i, point in enumerate(_as_list(value, field))]
    return np.array(points, dtype=np.float64).reshape(-1, 2)


def parse_point(value: object, field: str) -> npt.NDArray[np.float64]:
    """Return one ``[x, y]`` of finite numbers as a (2,) array."""
    coordinates = _as_list(value, field)
    if len(coordinates) != 2:
        raise field_error(field, f"must be two numbers [x, y], not {len(coordinates)} values")
    return np.array([_parse_number(number, field) for number in coordinates])


def parse_landmarks(value: object, field: str) -> dict[str, npt.NDArray[np.float64]]:
    """Return ``{name: [x, y]}`` as a dict of (2,) arrays, in the order given."""
    if not isinstance(value, Mapping):
        raise field_error(field, f"must map names to points [x, y], not {shown(value)}")
    return {
        parse_word(name, field, "the name of a landmark"): parse_point(point, f"{field}.{name}")
        for name, point in value.items()
    }


def parse_lengths(value: object, field: str) -> dict[str, float]:
    """Return ``{name: number}`` as a dict of positive numbers, in the order given."""
    if not isinstance(value, Mapping):
        raise field_error(field, f"must map names to lengths, not {shown(value)}")
    found = {}
    for name, number in value.items():
        if isinstance(number, bool) or not isinstance(number, Real) or not 0 < float(number) < math.inf:
            raise field_error(f"{field}.{name}", f"must be a positive number, not {shown(number)}")
        found[parse_word(name, field, "the name of a landmark")] = float(number)
    return found


def parse_pairs(value: object, field: str) -> Pairs:
    """Return a list of ``[name, name]`` as tuples."""
    pairs: list[tuple[str, str]] = []
    for i, pair in enumerate(_as_list(value, field)):
        names = _as_list(pair, f"{field}[{i}]")
        if len(names) != 2:
            raise field_error(f"{field}[{i}]", f"must be the names of two landmarks, not {len(names)} values")
        first, second = (parse_word(name, f"{field}[{i}][{j}]") for j, name in enumerate(names))
        pairs.append((first, second))
    return tuple(pairs)


def shown(value: object) -> str:
    """Return a value as an error message quotes it, cut where it is long."""
    text = repr(value)
    return text if len(text) <= 40 else text[:37] + "..."


def _as_list(value: object, field: str) -> Sequence[object]:
    if isinstance(value, np.ndarray):
        value = value.tolist()
    if not isinstance(value, (list, tuple)):
        raise field_error(field, f"must be a list, not {shown(value)}")
    return value


def _parse_number(value: object, field: str) -> float:
    # True and False are numbers to Python, not to the author of a template.
    if isinstance(value, bool) or not isinstance(value, Real):
        raise field_error(field, f"must be two numbers [x, y]; {shown(value)} is none")
    try:
        number = float(value)
    except OverflowError:
        number = math.inf
    if not math.isfinite(number):
        raise field_error(field, "must be finite; NaN and infinity are no places")
    return number
