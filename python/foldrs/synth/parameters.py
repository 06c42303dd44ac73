"""Parameters of the scene renderer, each with its unit and the reason for its default."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from foldrs.errors import ParameterError

SCENARIOS = ("random", "landmarks", "parallel", "corner", "halves", "limb", "limbs")
"""How a fold line may be drawn, see :mod:`foldrs.synth.fold_lines`."""

TABLES = ("plain", "wood", "checks", "noise")
"""Textures of the table."""

CLOTHS = ("plain", "stripes", "checks", "dots", "print", "denim")
"""Textures of the cloth."""


@dataclass(frozen=True)
class SynthParameters:
    """What the scenes are like. ``SynthParameters()`` holds the defaults.

    Raises
    ------
    ParameterError
        If a value lies outside its range.
    """

    image_size: tuple[int, int] = (640, 480)
    """Width and height of the picture, px."""

    px_per_cm: float = 4.0
    """Scale of the picture: at 4 px/cm, 640 px show a table of 1.6 m."""

    margin_cm: float = 1.5
    """Least distance of the cloth from the border of the picture, so that its whole outline is seen."""

    size_range: tuple[float, float] = (0.80, 1.08)
    """Smallest and largest factor on the garment's size: from a child's to a large adult's."""

    shape_cm: float = 3.0
    """Typical distance (RMS) of a landmark from where the garment given has it, alike on both sides.

    Garments of a kind differ from their mean by 3 to 6 cm a corner; the stretch and the asymmetry below make
    up the rest. 0 keeps the shape of the garment given."""

    asymmetry_cm: float = 1.5
    """As ``shape_cm``, not alike on both sides: garments differ from their mirror image by 1.5 to 3 cm."""

    stretch: float = 0.06
    """Standard deviation of the factor between height and width; 0.06 turns a slim cut into a regular one."""

    bow: float = 0.015
    """Standard deviation of how far a side between two landmarks bulges, as a share of its length: hems and
    collars are curved, templates straight."""

    rim_cm: float = 0.12
    """RMS of the small waves of the garment's rim."""

    folds: int = 1
    """Number of folds, 0 to 2; without any it lies face up and nearly upright, as laid out for a picture."""

    flat_turn_deg: float = 15.0
    """Largest angle by which such a garment lies turned, degrees: by hand none lies straight."""

    scenarios: tuple[str, ...] = SCENARIOS
    """The ways of drawing the fold line to choose from, equally likely; one named twice is more likely.

    A second fold runs all across: of these "random", "parallel" or "corner", or any of the three if none
    of them is named."""

    flap_fraction: tuple[float, float] = (0.08, 0.5)
    """Smallest and largest share of the garment's area that is turned over. Below 0.08 hardly a fold is seen;
    above 0.5 the other part would be the flap."""

    under: float = 0.5
    """Probability that the flap lies under the kept part, as after a fold seen from behind."""

    mirrored: float = 0.5
    """Probability that the garment lies face down, so that its mirror image is seen."""

    flap_turn_deg: float = 1.0
    """Standard deviation of the angle by which the flap lies turned away from the exact fold, degrees."""

    deformation_cm: float = 0.4
    """RMS displacement of the smooth deformation of the whole: cloth laid by hand is never exact."""

    tables: tuple[str, ...] = TABLES
    """Textures of the table to choose from."""

    cloths: tuple[str, ...] = CLOTHS
    """Textures of the cloth to choose from."""

    contrast: float = 22.0
    """Least distance between the mean colours of cloth and table (CIE 1976 delta E). Under about 15 the
    outline is hard to see by eye, too."""

    wrinkles: float = 0.10
    """Strength of the shading by wrinkles: standard deviation of the brightness factor."""

    shadow: float = 0.4
    """Darkening of the table at the rim of the cloth, and of cloth at the rim of a layer above it (share)."""

    light: float = 0.12
    """Largest brightness difference between the side of the picture near the lamp and its middle (share)."""

    vignette: float = 0.25
    """Largest darkening of the picture's corners (share)."""

    warmth: float = 0.06
    """Standard deviation of the colour of the light: red gains what blue loses (share)."""

    noise: float = 2.0
    """Standard deviation of the camera's noise, grey levels of 256."""

    tilt_deg: float = 0.0
    """Angle between the camera's axis and the table's normal, degrees; its direction is random. 0 looks from
    straight above; the scale then holds for the middle of the picture."""

    marker_cm: float = 0.0
    """Side of the markers (AprilTag 36h11) that lie beside the cloth, cm; 0 lays none."""

    sheet: bool = False
    """Whether a white sheet of A4 lies beside the cloth."""

    depth: bool = False
    """Whether a depth image is made, too."""

    thickness_cm: tuple[float, float] = (0.12, 0.35)
    """Smallest and largest thickness of a layer of cloth in the depth image: a shirt's, and a towel's."""

    bulge_cm: float = 0.08
    """Typical height of the bulges by which cloth does not lie flat."""

    depth_noise_cm: float = 0.1
    """Standard deviation of the depth image's noise: a millimetre at a metre and a half is a good sensor."""

    on_outline_cm: float = 0.75
    """A landmark no farther than this from the folded outline counts as lying on it."""

    clear_cm: float = 2.0
    """A landmark is accessible if no double layer lies within this distance (section 3 of the paper)."""

    def __post_init__(self) -> None:
        """Check every range."""
        self._check("image_size", self.image_size, 64, 8192, count=2)
        if not all(isinstance(side, int) for side in self.image_size):
            raise ParameterError(f"image_size is {self.image_size}: give two whole numbers of pixels.")
        self._check("px_per_cm", self.px_per_cm, 0.5, 100)
        self._check("size_range", self.size_range, 0.05, 20, count=2)
        self._check("flap_fraction", self.flap_fraction, 0.01, 0.5, count=2)
        self._check("thickness_cm", self.thickness_cm, 0.01, 5, count=2)
        for name in ("size_range", "flap_fraction", "thickness_cm"):
            low_high = getattr(self, name)
            if low_high[0] > low_high[1]:
                raise ParameterError(f"{name} is {low_high}: give the smaller bound first.")
        for name in (
            "margin_cm",
            "shape_cm",
            "asymmetry_cm",
            "rim_cm",
            "deformation_cm",
            "on_outline_cm",
            "clear_cm",
        ):
            self._check(name, getattr(self, name), 0, 50)
        for name in ("under", "mirrored", "shadow", "light", "vignette"):
            self._check(name, getattr(self, name), 0, 1)
        for name in ("stretch", "bow", "wrinkles", "warmth"):
            self._check(name, getattr(self, name), 0, 0.5)
        self._check("flap_turn_deg", self.flap_turn_deg, 0, 10)
        self._check("marker_cm", self.marker_cm, 0, 100)
        self._check("tilt_deg", self.tilt_deg, 0, 60)
        self._check("bulge_cm", self.bulge_cm, 0, 5)
        self._check("depth_noise_cm", self.depth_noise_cm, 0, 10)
        self._check("contrast", self.contrast, 0, 60)
        self._check("noise", self.noise, 0, 64)
        self._check("flat_turn_deg", self.flat_turn_deg, 0, 180)
        if self.folds not in (0, 1, 2):
            raise ParameterError(f"folds is {self.folds}: scenes are folded 0, 1 or 2 times.")
        for name, known in (("scenarios", SCENARIOS), ("tables", TABLES), ("cloths", CLOTHS)):
            given = getattr(self, name)
            if isinstance(given, str) or not given or not set(given) <= set(known):
                raise ParameterError(
                    f"{name} is {given!r}: give a tuple with one or more of {', '.join(known)}."
                )

    @staticmethod
    def _check(name: str, value: float | Sequence[float], low: float, high: float, count: int = 1) -> None:
        """Raise if a number, or one of ``count`` numbers, is not within ``low`` to ``high``."""
        values = [value] if isinstance(value, (int, float)) else list(value)
        if len(values) != count:
            raise ParameterError(f"{name} is {value}: give {count} number{'s' * (count > 1)}.")
        if not all(math.isfinite(v) and low <= v <= high for v in values):
            raise ParameterError(f"{name} is {value}: give a number from {low:g} to {high:g}.")
