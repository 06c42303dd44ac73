"""Templates: the outline of an unfolded garment, its landmarks and grasp pairs (section 3 of the paper).

A template is a small JSON file, see :meth:`Template.from_dict` for its fields. The built-in ones are files of
the same format, one or more for every kind of garment, and nothing in the program knows more of a kind than
they say. Template coordinates are (x, y) with y down, in the template's own units (centimetres for the
built-in ones).

Examples
--------
>>> from foldrs.template import builtin_templates
>>> for template in builtin_templates("pants"):
...     print(template.name, list(template.landmarks)[:2], template.grasp_pairs[0])
pants ['waist_left', 'hem_left_outer'] ('waist_left', 'waist_right')
"""

from __future__ import annotations

import functools
import json
import os
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field
from importlib import resources
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np
import numpy.typing as npt

from foldrs import _core
from foldrs._template_checks import (
    check_grasp_pairs,
    check_outline,
    check_spread,
    check_symmetry,
    read_only,
    snap_landmarks,
)
from foldrs._template_fields import (
    Pairs,
    field_error,
    parse_landmarks,
    parse_lengths,
    parse_pairs,
    parse_points,
    parse_word,
    required,
    shown,
)
from foldrs.errors import TemplateError
from foldrs.whole_files import write_whole

SCHEMA = 1
"""Version of the template file format that is read and written."""


@dataclass(frozen=True, eq=False)
class Template:
    """An unfolded garment: outline, landmarks, mirror symmetry and grasp pairs.

    A template is checked when it is made and cannot be changed afterwards: it holds read-only copies of what
    it is made of.

    Parameters
    ----------
    name : str
        Name that tells templates of one kind apart; the stem of the file it was read from.
    garment_type : str
        Kind of garment; several templates may share it.
    units : str
        Unit of all coordinates, for instance ``"cm"``.
    outline : (n, 2) float64 array
        Corners of the closed outline, (x, y) with y down; the first point is not repeated. Either winding.
    landmarks : mapping of str to (2,) float64 array
        Named points of the outline, in the order given. A landmark marked a little off it (up to 5 % of the
        square root of the area) is moved to the nearest point of the outline.
    symmetry : tuple of (str, str)
        Landmarks that are mirror images of each other. One on the mirror axis may be paired with itself.
    grasp_pairs : tuple of (str, str)
        Pairs of landmarks to grasp the garment by, the one with the most natural unfolded state first.
    spread : mapping of str to float
        How far landmarks of garments of the kind lie from where this template has them: standard deviation
        of each coordinate, after the garments were laid upon each other, in the template's units. Where it
        is empty the joint fit's parameter ``shape`` holds for all.

    Raises
    ------
    TemplateError
        If the outline is no simple polygon, a landmark does not lie on it, a pair names no landmark, or
        anything is of another shape or type. Its `field` says where, in the notation of the template file,
        for instance ``"grasp_pairs[2][0]"``.
    """

    name: str
    garment_type: str
    units: str
    outline: npt.NDArray[np.float64]
    landmarks: Mapping[str, npt.NDArray[np.float64]]
    symmetry: Pairs = ()
    grasp_pairs: Pairs = ()
    spread: Mapping[str, float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        outline = _numbers(self.outline, "outline")
        check_outline(outline)
        landmarks = snap_landmarks(outline, _landmark_points(self.landmarks))
        symmetry = parse_pairs(self.symmetry, "symmetry")
        check_symmetry(symmetry, landmarks)
        grasp_pairs = parse_pairs(self.grasp_pairs, "grasp_pairs")
        check_grasp_pairs(grasp_pairs, landmarks)
        spread = parse_lengths(self.spread, "spread")
        check_spread(spread, landmarks)
        # The way round a frozen dataclass's own lock: only here, before anyone else holds the object.
        object.__setattr__(self, "outline", outline)
        object.__setattr__(self, "landmarks", MappingProxyType(landmarks))
        object.__setattr__(self, "symmetry", symmetry)
        object.__setattr__(self, "grasp_pairs", grasp_pairs)
        object.__setattr__(self, "spread", MappingProxyType(spread))

    def __reduce__(self) -> tuple[type[Template], tuple[object, ...]]:
        """Pickle by the constructor's arguments (the read-only mapping cannot be pickled as it is)."""
        landmarks = dict(self.landmarks)
        arguments = (self.name, self.garment_type, self.units, self.outline, landmarks)
        return Template, (*arguments, self.symmetry, self.grasp_pairs, dict(self.spread))

    @property
    def landmark_array(self) -> npt.NDArray[np.float64]:
        """The landmarks as a (k, 2) array, in their order."""
        return np.array(list(self.landmarks.values()), dtype=np.float64).reshape(-1, 2)

    @property
    def area(self) -> float:
        """Area inside the outline, in square units."""
        return abs(float(_core.signed_area(self.outline)))

    @property
    def mirror_pairs(self) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
        """The landmarks of every symmetric pair: (k, 2) the first ones, (k, 2) the others."""
        one, other = (
            np.array([self.landmarks[pair[side]] for pair in self.symmetry], dtype=np.float64).reshape(-1, 2)
            for side in (0, 1)
        )
        return one, other

    def crooked_pairs(self) -> dict[tuple[str, str], float]:
        """Find the symmetric pairs that do not mirror each other, and by how much.

        The joint fit holds the two corners of a pair alike only where they do so within 2 % of the garment's
        size: of names interchanged by mistake, or a template traced of a garment that lies crooked, it knows
        nothing of the symmetry, and left and right are no longer the same to it.

        Returns
        -------
        dict of (str, str) to float
            Distance of either landmark from the other's mirror image, over the axis that fits all pairs
            best, in template units; infinite if the pairs tell no axis. Empty if all is well.

        Examples
        --------
        >>> towel = builtin_templates("towel")[0]
        >>> towel.crooked_pairs()
        {}
        >>> from dataclasses import replace
        >>> wrong = replace(towel, symmetry=(("corner_1", "corner_3"), ("corner_2", "corner_4")))
        >>> len(wrong.crooked_pairs())
        2
        """
        told = _core.mirrorings(self.outline, *self.mirror_pairs)
        return {pair: off for pair, (off, held) in zip(self.symmetry, told, strict=True) if not held}

    @classmethod
    def from_dict(cls, data: object, *, name: str) -> Template:
        """Make a template of the content of a template file.

        Parameters
        ----------
        data : mapping
            ``schema`` (1), ``type``, ``units``, ``outline`` ``[[x, y], ...]``, ``landmarks``
            ``{name: [x, y], ...}``, optionally ``symmetry`` ``[[name, name], ...]``, ``grasp_pairs``
            ``[[name, name], ...]``, best first, and optionally ``spread`` ``{name: number, ...}``. Further
            fields are ignored.
        name : str
            Name of the template.

        Raises
        ------
        TemplateError
            If a field is missing or wrong; its `field` says which.

        Examples
        --------
        >>> scarf = {
        ...     "schema": 1, "type": "scarf", "units": "cm",
        ...     "outline": [[0, 0], [180, 0], [180, 30], [0, 30]],
        ...     "landmarks": {"left": [0, 0], "right": [180, 0]},
        ...     "grasp_pairs": [["left", "right"]],
        ... }
        >>> template = Template.from_dict(scarf, name="long-scarf")
        >>> template.garment_type, template.area
        ('scarf', 5400.0)
        >>> Template.from_dict(scarf | {"grasp_pairs": [["left", "rihgt"]]}, name="long-scarf")
        Traceback (most recent call last):
        foldrs.errors.TemplateError: ...
        """
        if not isinstance(data, Mapping):
            raise TemplateError(f"a template must be an object with named fields, not {shown(data)}")
        schema = required(data, "schema")
        if type(schema) is not int or schema != SCHEMA:
            raise field_error("schema", f"must be {SCHEMA}, the version read here, not {shown(schema)}")
        return cls(
            name=name,
            garment_type=parse_word(required(data, "type"), "type"),
            units=parse_word(required(data, "units"), "units"),
            outline=parse_points(required(data, "outline"), "outline"),
            landmarks=parse_landmarks(required(data, "landmarks"), "landmarks"),
            symmetry=parse_pairs(data.get("symmetry", ()), "symmetry"),
            grasp_pairs=parse_pairs(required(data, "grasp_pairs"), "grasp_pairs"),
            spread=parse_lengths(data.get("spread", {}), "spread"),
        )

    def to_dict(self) -> dict[str, Any]:
        """Return the content of the template file: lists, texts and numbers only, ready for JSON."""
        return {
            "schema": SCHEMA,
            "type": self.garment_type,
            "units": self.units,
            "outline": self.outline.tolist(),
            "landmarks": {name: point.tolist() for name, point in self.landmarks.items()},
            "symmetry": [list(pair) for pair in self.symmetry],
            "grasp_pairs": [list(pair) for pair in self.grasp_pairs],
            **({"spread": dict(self.spread)} if self.spread else {}),
        }


def load_template(path: str | os.PathLike[str]) -> Template:
    """Read and check a template file; the template is named by the stem of the file.

    Raises
    ------
    TemplateError
        If the file is missing, is no JSON, or a field is missing or wrong. The message starts with the file.
    """
    path = Path(path)
    try:
        return _parse(path.read_text(encoding="utf-8-sig"), name=path.stem)
    except FileNotFoundError as error:
        raise TemplateError(f"{path}: there is no such template file") from error
    except OSError as error:
        raise TemplateError(f"{path}: cannot be read ({error.strerror})") from error
    except UnicodeDecodeError as error:
        raise TemplateError(f"{path}: not a template file, which is JSON text in UTF-8") from error
    except TemplateError as error:
        raise TemplateError(f"{path}: {error}", error.field) from error


def save_template(template: Template, path: str | os.PathLike[str]) -> None:
    """Write a template file, one point or pair a line; an existing file is replaced.

    The file is written whole or not at all: a failure leaves what was there before. Of several threads or
    processes that write one file, one has its way.

    Raises
    ------
    TemplateError
        If the file cannot be written, for instance because its folder does not exist.
    """
    path = Path(path)
    try:
        write_whole(path, _to_json(template.to_dict()).encode())
    except OSError as error:
        raise TemplateError(f"{path}: cannot be written ({error.strerror})") from error


def builtin_templates(garment_type: str | None = None) -> tuple[Template, ...]:
    """Return the templates that come with the package, sorted by name: the one named like the kind first.

    Parameters
    ----------
    garment_type : str, optional
        Return those of this kind only; there may be several.

    Raises
    ------
    TemplateError
        If there is none of that kind; the message lists the kinds there are.
    """
    templates = _all_builtin_templates()
    if garment_type is None:
        return templates
    chosen = tuple(template for template in templates if template.garment_type == garment_type)
    if not chosen:
        kinds = ", ".join(sorted({template.garment_type for template in templates}))
        raise field_error("type", f"no built-in template is of {shown(garment_type)}; the kinds are {kinds}")
    return chosen


@functools.cache
def _all_builtin_templates() -> tuple[Template, ...]:
    folder = resources.files("foldrs").joinpath("templates")
    files = {Path(file.name): file for file in folder.iterdir() if file.name.endswith(".json")}
    by_name = sorted(files, key=lambda path: path.stem)
    return tuple(_parse(files[path].read_text(encoding="utf-8"), name=path.stem) for path in by_name)


def _numbers(values: npt.ArrayLike, field: str) -> npt.NDArray[np.float64]:
    """Return a read-only copy of numbers."""
    try:
        array = np.asarray(values)
    except (TypeError, ValueError) as error:
        raise field_error(field, f"must be an array of numbers ({error})") from None
    if array.dtype.kind not in "uif":
        raise field_error(field, f"must be real numbers, not {array.dtype}")
    return read_only(array)


def _landmark_points(landmarks: Mapping[str, npt.ArrayLike]) -> dict[str, npt.NDArray[np.float64]]:
    """Return landmarks as (2,) arrays, or say which is no point."""
    if not isinstance(landmarks, Mapping):
        raise field_error("landmarks", f"must map names to points (x, y), not {shown(landmarks)}")
    points = {name: _numbers(point, f"landmarks.{name}") for name, point in landmarks.items()}
    for name, point in points.items():
        if point.shape != (2,) or not np.isfinite(point).all():
            raise field_error(
                f"landmarks.{name}", f"must be two finite numbers, not {shown(landmarks[name])}"
            )
    return points


def _parse(text: str, *, name: str) -> Template:
    try:
        data = json.loads(text, object_pairs_hook=_Object)
    except (ValueError, RecursionError) as error:
        raise TemplateError(f"not a template file, which is JSON ({error})") from error
    _refuse_names_given_twice(data)
    return Template.from_dict(data, name=name)


class _Object(dict[str, object]):
    """An object of a JSON file that knows a name given twice, of which it holds the last."""

    def __init__(self, items: list[tuple[str, object]]) -> None:
        super().__init__(items)
        self.twice = next(
            (name for name, count in Counter(name for name, _ in items).items() if count > 1), None
        )


def _refuse_names_given_twice(data: object) -> None:
    """Refuse them in a template and the fields of it that hold names."""
    if not isinstance(data, _Object):
        return
    for prefix, part in (("", data), *((f"{name}.", value) for name, value in data.items())):
        if isinstance(part, _Object) and part.twice is not None:
            raise field_error(f"{prefix}{part.twice}", "given twice; names must be unique")


def _to_json(data: Mapping[str, object]) -> str:
    """Return JSON that a person can read and edit: one point, landmark or pair a line."""
    fields = []
    for key, value in data.items():
        text = json.dumps(value, ensure_ascii=False)
        if isinstance(value, list):
            lines = [f"    {json.dumps(item, ensure_ascii=False)}" for item in value]
            text = "[\n" + ",\n".join(lines) + "\n  ]" if lines else "[]"
        elif isinstance(value, dict):
            lines = [
                f"    {json.dumps(name, ensure_ascii=False)}: {json.dumps(value[name])}" for name in value
            ]
            text = "{\n" + ",\n".join(lines) + "\n  }" if lines else "{}"
        fields.append(f'  "{key}": {text}')
    return "{\n" + ",\n".join(fields) + "\n}\n"
