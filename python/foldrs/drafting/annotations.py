"""Annotations of flat garments: LabelMe and COCO keypoint files, read with the names of the fields at fault.

Both hold an outline and named points in px of a photograph, which is not needed itself.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from foldrs._template_fields import field_error, parse_point, parse_points, parse_word, shown
from foldrs.errors import TemplateError

Points = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Annotation:
    """What was marked of one garment, px."""

    label: str
    """Its label or category: the kind, unless told otherwise."""
    outline: Points
    """(n, 2) the polygon drawn."""
    landmarks: Mapping[str, Points]
    """Named points, in the order of the file."""


def read_labelme(path: Path, *, label: str | None = None) -> Annotation:
    """Read a LabelMe file: one shape of type ``polygon``, any number of type ``point``.

    Parameters
    ----------
    path : Path
        The JSON file.
    label : str, optional
        Label of the polygon to take, where there are several.

    Raises
    ------
    TemplateError
        If it is no such file; the message names file and field.
    """
    return _told_of(path, lambda data: _labelme(data, label))


def read_coco(path: Path, *, image_id: int | None = None) -> Annotation:
    """Read one garment of a COCO keypoint file: segmentation polygon, keypoints named by the category.

    Parameters
    ----------
    path : Path
        The JSON file.
    image_id : int, optional
        Image to take the garment of, where there are several.

    Raises
    ------
    TemplateError
        If it is no such file, or which garment is meant cannot be told; the message names file and field.
    """
    return _told_of(path, lambda data: _coco(data, image_id))


def _told_of(path: Path, read: Callable[[Mapping[str, Any]], Annotation]) -> Annotation:
    """Read a file; what is wrong with it is told with its name."""
    try:
        data = json.loads(path.read_text(encoding="utf-8-sig"))
        if not isinstance(data, Mapping):
            raise TemplateError(f"must be a JSON object, not {shown(data)}")
        return read(data)
    except TemplateError as error:
        raise TemplateError(f"{path}: {error}", error.field) from error
    except FileNotFoundError as error:
        raise TemplateError(f"{path}: there is no such file") from error
    except OSError as error:
        raise TemplateError(f"{path}: cannot be read ({error.strerror})") from error
    except (ValueError, RecursionError) as error:
        raise TemplateError(f"{path}: not JSON text in UTF-8 ({error})") from error


def _labelme(data: Mapping[str, Any], label: str | None) -> Annotation:
    polygons: list[tuple[str, Points]] = []
    landmarks: dict[str, Points] = {}
    for i, shape in _objects(data, "shapes"):
        field = f"shapes[{i}]"
        name = parse_word(shape.get("label"), f"{field}.label")
        kind = shape.get("shape_type", "polygon")
        points = parse_points(shape.get("points"), f"{field}.points")
        if kind == "polygon":
            polygons.append((name, points))
        elif kind == "point":
            if len(points) != 1:
                raise field_error(f"{field}.points", f"a point has one position, not {len(points)}")
            if name in landmarks:
                raise field_error(f"{field}.label", f"{shown(name)} is given twice; names must be unique")
            landmarks[name] = points[0]
        else:
            raise field_error(f"{field}.shape_type", f"must be 'polygon' or 'point', not {shown(kind)}")
    chosen = [polygon for polygon in polygons if label is None or polygon[0] == label]
    if len(chosen) != 1:
        there = ", ".join(sorted({name for name, _ in polygons})) or "none"
        raise field_error(
            "shapes", f"one polygon is wanted, {len(chosen)} fit; say which by its label (there are: {there})"
        )
    return Annotation(*chosen[0], landmarks)


def _coco(data: Mapping[str, Any], image_id: int | None) -> Annotation:
    categories = {category.get("id"): (i, category) for i, category in _objects(data, "categories")}
    found = [
        (i, one)
        for i, one in _objects(data, "annotations")
        if image_id is None or one.get("image_id") == image_id
    ]
    if len(found) != 1:
        there = sorted({str(one.get("image_id")) for _, one in _objects(data, "annotations")})
        raise field_error(
            "annotations",
            f"one garment is wanted, {len(found)} fit; say which by its image_id (there are: {_some(there)})",
        )
    i, one = found[0]
    field = f"annotations[{i}]"
    if one.get("category_id") not in categories:
        raise field_error(f"{field}.category_id", f"no category has the id {shown(one.get('category_id'))}")
    k, category = categories[one["category_id"]]
    names = category.get("keypoints", [])
    if not isinstance(names, list):
        raise field_error(f"categories[{k}].keypoints", f"must be a list of names, not {shown(names)}")
    return Annotation(
        parse_word(category.get("name"), f"categories[{k}].name"),
        _segmentation(one.get("segmentation"), f"{field}.segmentation"),
        _keypoints(one.get("keypoints", []), names, field, f"categories[{k}].keypoints"),
    )


def _segmentation(value: object, field: str) -> Points:
    """Return the one polygon [x, y, x, y, ...] of a segmentation."""
    if isinstance(value, Mapping):
        raise field_error(field, "is run-length encoded; a polygon is wanted: export the masks as polygons")
    if not isinstance(value, list) or len(value) != 1 or not isinstance(value[0], list):
        raise field_error(field, f"must be a list of one polygon, not {shown(value)}")
    flat = value[0]
    if len(flat) % 2:
        raise field_error(f"{field}[0]", f"must be x and y in turn, but holds {len(flat)} numbers")
    return parse_points([flat[k : k + 2] for k in range(0, len(flat), 2)], f"{field}[0]")


def _keypoints(value: object, names: list[object], field: str, names_field: str) -> dict[str, Points]:
    """Return the labelled ones of keypoints [x, y, v, ...]; v = 0 says that one is not marked."""
    if not isinstance(value, list) or len(value) != 3 * len(names):
        count = f"{len(value)} values" if isinstance(value, list) else shown(value)
        raise field_error(
            f"{field}.keypoints",
            f"must be x, y and v of the {len(names)} names of {names_field}, not {count}",
        )
    found: dict[str, Points] = {}
    for k, name in enumerate(names):
        word = parse_word(name, f"{names_field}[{k}]")
        if word in found:
            raise field_error(f"{names_field}[{k}]", f"{shown(word)} is given twice; names must be unique")
        if value[3 * k + 2] != 0:
            found[word] = parse_point(value[3 * k : 3 * k + 2], f"{field}.keypoints ({word})")
    return found


def _objects(data: Mapping[str, Any], field: str) -> list[tuple[int, Mapping[str, Any]]]:
    """Return the numbered objects of a list."""
    value = data.get(field)
    if not isinstance(value, list):
        raise field_error(field, f"must be a list of objects, not {shown(value)}")
    for i, one in enumerate(value):
        if not isinstance(one, Mapping):
            raise field_error(f"{field}[{i}]", f"must be an object, not {shown(one)}")
    return list(enumerate(value))


def _some(words: list[str]) -> str:
    return ", ".join(words[:10]) + (", ..." if len(words) > 10 else "")
