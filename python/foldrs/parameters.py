"""All parameters of the method, in one place, grouped by stage.

Every value is a plain number with its unit and the reason for its default. Lengths of the cloth are in
centimetres, of the picture in pixels (px); "share" is a number between 0 and 1.
"""

from __future__ import annotations

from dataclasses import dataclass, field


@dataclass(frozen=True)
class OutlineParameters:
    """Stage 0: from the photograph to the outline (section 2.1)."""


@dataclass(frozen=True)
class Parameters:
    """Parameters of all stages. ``Parameters()`` holds the defaults."""

    outline: OutlineParameters = field(default_factory=OutlineParameters)
