"""Fields of calibration files, whoever wrote them: JSON, ROS's YAML, OpenCV's YAML and JSON, text, NumPy."""

from __future__ import annotations

import io
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from foldrs.errors import CalibrationError

_OPENCV = re.compile(r"^%YAML:1\.0|!!opencv-(nd-)?matrix")
"""What OpenCV adds to YAML: a first line with a colon that YAML does not allow, and types of matrices."""

_METRES = {"m": 1.0, "cm": 0.01, "mm": 0.001}


def read_fields(path: Path) -> Mapping[str, Any] | np.ndarray[Any, Any]:
    """Read a file: its fields by name, lower case without underscores, or the matrix that is all it holds.

    Raises
    ------
    CalibrationError
        There is no such file, or it can be read in no way known here.
    """
    try:
        content = path.read_bytes()
    except OSError as error:
        raise CalibrationError(f"{path}: cannot be read ({error.strerror}).") from None
    if path.suffix.lower() == ".npy":
        try:
            return np.asarray(np.load(io.BytesIO(content), allow_pickle=False))
        except (ValueError, EOFError, OSError) as error:
            raise CalibrationError(f"{path}: is no NumPy array ({error}).") from None
    try:
        text = content.decode()
    except UnicodeDecodeError:
        raise CalibrationError(f"{path}: is no text: give JSON, YAML, numbers, or .npy.") from None
    numbers = _plain_numbers(text)
    if numbers is not None:
        return numbers
    parsed = _parsed(_OPENCV.sub("", text), path)
    if isinstance(parsed, list):
        parsed = {"matrix": parsed}
    if not isinstance(parsed, dict):
        raise CalibrationError(f"{path}: holds neither fields nor a matrix.")
    if "data" in parsed and ("rows" in parsed or "sizes" in parsed):
        parsed = {"matrix": parsed}
    return {str(name).lower().replace("_", ""): value for name, value in parsed.items()}


def numbers_of(value: Any, field: str, path: Path) -> np.ndarray[Any, Any]:
    """Numbers of a field: nested lists, or rows, cols (or sizes) and data as ROS and OpenCV write matrices.

    Raises
    ------
    CalibrationError
        They are no numbers, or not as many as rows and cols say.
    """
    shape = None
    try:
        if isinstance(value, Mapping):
            shape = value["sizes"] if "sizes" in value else (int(value["rows"]), int(value["cols"]))
            value = value["data"]
        matrix = np.asarray(value, dtype=np.float64)
        return matrix if shape is None else matrix.reshape(shape)
    except KeyError as error:
        raise CalibrationError(f"{path}: {field} lacks {error}.", field) from None
    except (TypeError, ValueError) as error:
        raise CalibrationError(f"{path}: {field} is no matrix of numbers ({error}).", field) from None


def first_of(fields: Mapping[str, Any], names: tuple[str, ...]) -> Any | None:
    """Value of the first of the names that is there."""
    return next((fields[name] for name in names if fields.get(name) is not None), None)


def metres(fields: Mapping[str, Any], path: Path) -> float:
    """Metres a unit of the file's lengths, by its field ``units``; metres without it.

    Raises
    ------
    CalibrationError
        The unit is none known here.
    """
    unit = fields.get("units", "m")
    if unit not in _METRES:
        raise CalibrationError(f"{path}: units is {unit!r}: give one of {', '.join(_METRES)}.", "units")
    return _METRES[unit]


def _plain_numbers(text: str) -> np.ndarray[Any, Any] | None:
    """Rows of numbers, parted by blanks or commas; None if the text is anything else."""
    try:
        rows = [[float(word) for word in line.replace(",", " ").split()] for line in text.splitlines()]
    except ValueError:
        return None
    rows = [row for row in rows if row]
    return np.array(rows) if rows and len({len(row) for row in rows}) == 1 else None


def _parsed(text: str, path: Path) -> Any:
    """Parse YAML, of which JSON is a part."""
    import yaml  # only where a file is read

    try:
        return yaml.safe_load(text)
    except yaml.YAMLError as error:
        reason = " ".join(str(error).split())
        raise CalibrationError(f"{path}: is neither JSON nor YAML ({reason}).") from None
