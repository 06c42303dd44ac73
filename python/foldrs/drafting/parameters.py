"""Parameters of drafting templates, each with its unit and the reason for its default."""

from __future__ import annotations

from dataclasses import dataclass, field

from foldrs.parameters import FittingParameters


@dataclass(frozen=True)
class DraftParameters:
    """How templates are made of flat garments. ``DraftParameters()`` holds the defaults.

    "Of the size" means as a share of the square root of the garment's area (50 cm of a shirt); "of the half"
    as a share of the outline's length from the top of the mirror axis to its bottom.
    """

    samples: int = 300
    """Points of every half of the outline: one every 0.5 cm."""
    directions: int = 36
    """Directions from which the mirror axis is looked for: 5 degrees apart, well within its reach."""
    axis_points: int = 160
    """Points of the outline whose mirror images are compared with it."""
    axis_iterations: int = 25
    """Steps of the axis towards the best mirror symmetry; it comes to rest after some ten."""
    posed: tuple[float, float] = (0.15, 0.03)
    """Distance to the mirror image, of the size, at which a point counts a quarter; first and last step.
    Small at last, so that a sleeve laid otherwise than its partner does not turn the axis."""
    match_points: int = 120
    """Points of the outline matched with those of its mirror image by their shape contexts; IDSC's 100."""
    match_reach: float = 0.25
    """Distance of a point from its partner's mirror image, of the size, that costs as much as a shape
    quite unlike: a sleeve may lie that far off."""
    axis_tie: tuple[float, float] = (1.25, 0.02)
    """Axes whose deviation is up to this multiple of the best one's, and this share of the area more, are as
    good: of those the one nearest to the picture's vertical is taken."""
    asymmetric: float = 0.16
    """Share of the area covered by garment or mirror image alone, beyond which a garment has no mirror axis:
    95 of 100 real garments laid out by hand stay below 0.14, a glove has 0.20, a boot 0.22."""
    outline_tolerance: float = 0.012
    """Tolerance of the template's outline, of the size: half a centimetre; the joint fit sees no more."""
    corner_tolerance: float = 0.035
    """Tolerance of the simplification whose corners become landmarks, of the size: 2 cm. Corners that stand
    out less are bends, not places to grasp."""
    same_corner: float = 0.03
    """Corners this near, of the half, are one; one so near to the mirror axis lies on it."""
    snap: float = 0.05
    """A landmark marked by hand is moved to a corner this near, of the size, else to the outline."""
    paired: float = 0.08
    """Two landmarks mirror each other if their places along their halves differ by less, of the half."""
    meeting: FittingParameters = field(default_factory=lambda: FittingParameters(largest_shift=0.04))
    """When the straight sides' meeting replaces a corner: moved 2 cm at most, rounding takes off no more."""
    usual_garments: float = 3.0
    """So many garments' worth the usual spread of corners counts beside those measured: the spread of two or
    three garments alone is chance."""
    size_cm: float = 60.0
    """Longer side of the upright garment where neither it nor the scale is known, cm."""
