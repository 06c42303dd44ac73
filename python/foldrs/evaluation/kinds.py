"""What the measures must know of a kind of garment: the order of its landmarks, and its symmetries.

Both come from the kind's templates. The order is that along the outline. A symmetry is a relabelling of the
landmarks that leaves the garment the same, so that a prediction which interchanges them is as right: left and
right of a shirt, any corners of a sheet. A relabelling that keeps or reverses their order counts as one if

* the template file pairs the landmarks so (``symmetry``), or
* an affine map that carries every landmark to the place of its new name carries the whole template onto
  itself, both up to a tolerance.

Affine, because a kind's proportions vary: a sheet of 50 x 65 cm turned by a right angle is one of 65 x 50.
An affine map is determined by three points, so three landmarks prove nothing; there it is a similarity. What
all templates of the kind agree on is a symmetry of the kind: one that tells its two ends apart does so for
all. The garments of the scenes have no say: ends that happen to be alike on one of them are still two ends.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely.geometry import LinearRing

from foldrs.errors import ParameterError
from foldrs.evaluation.geometry import area, similarity
from foldrs.evaluation.landmarked import LandmarkedOutline
from foldrs.template import Template

Points = NDArray[np.float64]
Relabelling = tuple[int, ...]

SYMMETRY_TOLERANCE = 0.05
"""Share of the square root of the area by which a template may miss itself (root mean square over landmarks,
mean over the outline): 2 to 3 cm, by which real garments miss their own mirror image. Templates that tell
their ends apart miss by three times as much and more."""

_SAMPLES = 100
"""Points of the outline that are carried."""


@dataclass(frozen=True)
class Kind:
    """The landmarks of a kind of garment in the order of its outline, and its symmetries."""

    landmarks: tuple[str, ...]
    relabellings: tuple[Relabelling, ...]
    """Symmetries: landmark k may be called ``landmarks[relabelling[k]]``. The first changes nothing."""

    @classmethod
    def of(cls, templates: Sequence[Template], landmarks: Collection[str]) -> Kind:
        """Learn of a kind from its templates, as far as the given landmarks go.

        Raises
        ------
        ParameterError
            If there is no template, one lacks a landmark, or the landmarks are fewer than three: then no
            axis can be carried by them.
        """
        if not templates:
            raise ParameterError("there is no template of the scene's kind: give one by --template")
        if len(landmarks) < 3:
            raise ParameterError(
                "the measures need three landmarks or more, in the scene and in its template"
            )
        for template in templates:
            missing = [name for name in landmarks if name not in template.landmarks]
            if missing:
                raise ParameterError(
                    f"template {template.name!r} lacks the scene's landmarks {', '.join(missing)}"
                )
        found = [_symmetries_by_name(template, landmarks) for template in templates]
        names = along_outline(templates[0], landmarks)
        return cls(
            names,
            tuple(
                tuple(names.index(new) for new in relabelled)
                for relabelled in (tuple(table[name] for name in names) for table in found[0])
                if all(dict(zip(names, relabelled, strict=True)) in others for others in found)
            ),
        )


def along_outline(template: Template, landmarks: Collection[str]) -> tuple[str, ...]:
    """Landmarks in their order along the template's outline, from the first one the template lists."""
    listed = [name for name in template.landmarks if name in landmarks]
    if not listed:
        return ()
    ring = LinearRing(template.outline)
    arc = shapely.line_locate_point(
        ring, shapely.points(np.array([template.landmarks[name] for name in listed]))
    )
    return tuple(listed[i] for i in np.argsort((arc - arc[0]) % ring.length, kind="stable"))


def _symmetries_by_name(template: Template, landmarks: Collection[str]) -> list[dict[str, str]]:
    """Every symmetry of a template as a table of old and new names, the identity first."""
    names = along_outline(template, landmarks)
    n = len(names)
    keep = [tuple((k + r) % n for k in range(n)) for r in range(n)]
    turn = [tuple((r - k) % n for k in range(n)) for r in range(n)]
    declared = _declared_mirror(template, names)
    outline = LandmarkedOutline(template.outline, np.array([template.landmarks[name] for name in names]))
    size = math.sqrt(area(template.outline))
    return [
        {name: names[new] for name, new in zip(names, relabelling, strict=True)}
        for relabelling in keep + turn
        if relabelling in (keep[0], declared) or _missed_by(outline, relabelling) <= SYMMETRY_TOLERANCE * size
    ]


def _declared_mirror(template: Template, names: tuple[str, ...]) -> Relabelling | None:
    """Relabel by the template's symmetric pairs; landmarks in no pair lie on the mirror axis."""
    if not template.symmetry:
        return None
    partner = {a: b for pair in template.symmetry for a, b in (pair, pair[::-1])}
    mirrored = [partner.get(name, name) for name in names]
    return tuple(names.index(name) for name in mirrored) if set(mirrored) == set(names) else None


def _missed_by(outline: LandmarkedOutline, relabelling: Relabelling) -> float:
    """How far the map of a relabelling carries the outline or its landmarks past themselves."""
    before, after = outline.landmarks, outline.landmarks[list(relabelling)]
    carried_landmarks, samples = _mapped(before, after, outline.spread(_SAMPLES))
    off_landmarks = math.sqrt(float(((carried_landmarks - after) ** 2).sum(axis=1).mean()))
    ring = LinearRing(outline.points)
    return max(off_landmarks, float(shapely.distance(ring, shapely.points(samples)).mean()))


def _mapped(before: Points, after: Points, others: Points) -> tuple[Points, Points]:
    """Points and others under the least-squares map before -> after, affine if that proves anything."""
    if len(before) > 3:
        coefficients, *_ = np.linalg.lstsq(_with_one(before), after, rcond=None)
        return _with_one(before) @ coefficients, _with_one(others) @ coefficients
    found = (similarity(before, after, reflecting=reflecting) for reflecting in (False, True))
    maps = [(before @ m[:, :2].T + m[:, 2], others @ m[:, :2].T + m[:, 2]) for m in found]
    return min(maps, key=lambda mapped: float(((mapped[0] - after) ** 2).sum()))


def _with_one(points: Points) -> Points:
    return np.column_stack([points, np.ones(len(points))])
