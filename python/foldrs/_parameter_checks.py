"""Parameters out of their range, told by name before anything is done with them.

Those of the matching and the joint fit are the crate's to check; see ``Parameters::check`` there.
"""

from __future__ import annotations

import math
from dataclasses import fields, is_dataclass
from numbers import Integral, Real

from foldrs.errors import ParameterError
from foldrs.parameters import Parameters

_POSITIVE = {
    "outline": ("max_pixels", "coarse_side", "fine_side", "smoothing", "table_noise", "mixture_samples"),
    "fitting": ("iterations", "starts", "starts_in_all", "neighbours", "width", "points", "fewest", "trials"),
    "picture": ("longest", "blur", "cloth", "look_blur", "looks", "look_samples"),
    "grasp": ("corner_arm",),
    "alternatives": ("most", "most_folds", "temperature", "nats"),
    "scale": ("corner_noise", "focal", "focal_spread", "tilt_spread"),
    "depth": ("side", "samples", "tolerance", "trials", "blur", "step_blur"),
}
"""What is divided by, or how many there must be one of at least; the others may be 0, which leaves out what
they are for."""


def check_parameters(parameters: Parameters) -> None:
    """Raise ParameterError unless they are :class:`~foldrs.parameters.Parameters` that can be worked with.

    Every number must be of its default's type and finite, none negative, and what is divided by positive.
    """
    if not isinstance(parameters, Parameters):
        raise ParameterError(
            f"parameters must be foldrs.parameters.Parameters, not {type(parameters).__name__}: "
            "dataclasses.replace(Parameters(), ...) changes some of them"
        )
    for group, positive in _POSITIVE.items():
        _check(getattr(parameters, group), getattr(Parameters(), group), group, positive)


def _check(given: object, usual: object, name: str, positive: tuple[str, ...] = ()) -> None:
    if is_dataclass(usual):
        if type(given) is not type(usual):
            raise ParameterError(f"{name} must be a {type(usual).__name__}, not {type(given).__name__}")
        for field in fields(usual):
            part = f"{name}.{field.name}"
            _check(getattr(given, field.name), getattr(usual, field.name), part)
            if field.name in positive and not getattr(given, field.name) > 0:
                raise ParameterError(f"{part} must be positive, not {getattr(given, field.name)}")
    elif isinstance(usual, tuple):
        if not isinstance(given, (tuple, list)) or len(given) != len(usual):
            raise ParameterError(f"{name} must be {len(usual)} numbers, not {given!r}")
        for one, like in zip(given, usual, strict=True):
            _check(one, like, name)
    else:
        kind, words = (Integral, "a whole number") if isinstance(usual, int) else (Real, "a number")
        if isinstance(given, bool) or not isinstance(given, kind):
            raise ParameterError(f"{name} must be {words}, not {given!r}")
        if not (math.isfinite(given) and float(given) >= 0.0):
            raise ParameterError(f"{name} must be 0 or a positive number, not {given!r}")
