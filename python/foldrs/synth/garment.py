"""Another garment of a kind: the outline given, varied in size, shape and rim.

Lengths are in centimetres, y points down, the garment lies unfolded.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from foldrs import _core
from foldrs.errors import InvalidOutlineError, ParameterError
from foldrs.registration import perimeter
from foldrs.synth.ordered_landmarks import follow_outline
from foldrs.synth.parameters import SynthParameters

Points = NDArray[np.float64]

STEP_CM = 0.5
"""Distance of the points of a garment's outline: fine for deformations that are centimetres wide."""

_ROUNDING_CM = 0.4  # sewn corners are a little round
_ALIKE_CM = 15.0  # distance within which landmarks move alike: the two ends of a cuff do
_ALONE = 0.15  # share of the variance of a landmark's displacement that is its own
_TRIES = 8  # each with half the variation of the one before, so the last is all but the garment given


class FlatGarment(Protocol):
    """What a scene is made from: any object with these attributes, for instance a template.

    Attributes
    ----------
    garment_type : str
        The kind, for instance ``"pants"``.
    outline : ndarray of shape (n, 2)
        The unfolded outline, cm.
    landmarks : mapping of str to ndarray of shape (2,)
        Named points of the outline, cm; may be empty.
    symmetry : sequence of pairs of str
        Landmarks that mirror each other; may be empty.
    """

    @property
    def garment_type(self) -> str: ...  # noqa: D102
    @property
    def outline(self) -> ArrayLike: ...  # noqa: D102
    @property
    def landmarks(self) -> Mapping[str, ArrayLike]: ...  # noqa: D102
    @property
    def symmetry(self) -> Sequence[tuple[str, str]]: ...  # noqa: D102


@dataclass(frozen=True, eq=False)
class Photograph:
    """A photograph of a garment that lies flat on a table.

    Attributes
    ----------
    path : Path
        The image file.
    outline : ndarray of shape (n, 2)
        Outline of the garment in it, image px.
    """

    path: Path
    outline: Points


@dataclass(frozen=True, eq=False)
class Garment:
    """One flat garment: the attributes of :class:`FlatGarment`, a name, and where its cloth is seen."""

    garment_type: str
    outline: Points
    landmarks: Mapping[str, Points]
    symmetry: Sequence[tuple[str, str]] = ()
    name: str = ""
    photograph: Photograph | None = None


def garment_from_outline(
    outline: ArrayLike,
    landmarks: Mapping[str, ArrayLike],
    garment_type: str,
    *,
    size_cm: float | None = None,
    area_cm2: float | None = None,
    symmetry: Sequence[tuple[str, str]] = (),
    order: Sequence[str] = (),
    name: str = "",
    photograph: str | Path | None = None,
) -> Garment:
    """Make a garment of an outline without scale, for instance one traced in a photograph.

    Parameters
    ----------
    outline : array_like of shape (n, 2)
        The unfolded outline in any unit, y down.
    landmarks : mapping of str to array_like of shape (2,)
        Named points of the outline, same unit.
    garment_type : str
        The kind.
    size_cm, area_cm2 : float
        The real size, one of the two: the longer side of the upright bounding box in cm, or the area in cm^2.
    symmetry : sequence of pairs of str, optional
        Landmarks that mirror each other.
    order : sequence of str, optional
        Landmarks in the order they have along the outline, in either direction; at least four say something.
        If the places nearest to them have another order, they are moved to places that keep it: one marked at
        a corner that lies turned in may be nearest to a place beyond its neighbour.
    name : str, optional
        Which garment it is, for the ground truth.
    photograph : str or Path, optional
        The image file in which the outline was traced, in px: scenes then show the garment's own cloth.

    Raises
    ------
    InvalidOutlineError
        If the outline encloses no area or crosses itself.
    ParameterError
        If not exactly one of ``size_cm`` and ``area_cm2`` is given, or it is not positive, or ``order`` names
        what is not among the landmarks.
    """
    ring = checked(Garment(garment_type, np.asarray(outline, dtype=np.float64), {})).outline
    given = [size for size in (size_cm, area_cm2) if size is not None]
    if len(given) != 1 or not (np.isfinite(given[0]) and given[0] > 0):
        raise ParameterError("Give the garment's real size: either size_cm or area_cm2, a positive number.")
    if size_cm is not None:
        scale = size_cm / float(np.ptp(ring, axis=0).max())
    else:
        scale = float(np.sqrt(given[0] / polygon_area(ring)))
    marks = {mark: np.asarray(point, dtype=np.float64) for mark, point in landmarks.items()}
    if unknown := [mark for mark in order if mark not in marks]:
        raise ParameterError(f"order names {', '.join(unknown)}, not among the landmarks.")
    if order:
        marks |= zip(order, follow_outline(ring, np.array([marks[mark] for mark in order])), strict=True)
    marks = {mark: point * scale for mark, point in marks.items()}
    seen = None if photograph is None else Photograph(Path(photograph), ring)
    return Garment(garment_type, ring * scale, marks, tuple(symmetry), name, seen)


def checked(source: FlatGarment) -> Garment:
    """Take of a source what scenes need, and check it.

    Raises
    ------
    InvalidOutlineError
        If the outline encloses no area or crosses itself.
    ParameterError
        If the source says that it is not in centimetres.
    """
    ring = np.asarray(source.outline, dtype=np.float64)
    if ring.ndim != 2 or ring.shape[1] != 2 or not is_simple(ring):
        raise InvalidOutlineError(
            "The garment's outline must be three or more finite points, shape (n, 2), that enclose an area "
            "and do not cross: trace it again."
        )
    units = getattr(source, "units", "cm")
    if units != "cm":
        raise ParameterError(
            f"The garment is given in {units!r}; scenes need its real size: see garment_from_outline."
        )
    marks = {name: np.asarray(point, dtype=np.float64) for name, point in source.landmarks.items()}
    name = str(getattr(source, "name", "")) or source.garment_type
    photograph = getattr(source, "photograph", None)
    return Garment(source.garment_type, ring, marks, tuple(source.symmetry), name, photograph)


def vary(source: Garment, rng: np.random.Generator, parameters: SynthParameters) -> Garment:
    """Draw another garment of the same kind.

    The size is drawn, then the proportions (stretch), then every landmark is moved, the two of a symmetric
    pair mostly alike and so neighbours, and the pieces of outline between them follow by the similarity that
    their two ends define; sides bulge a little and the rim gets small waves. A draw that makes the outline
    cross itself is drawn again with half the variation.

    Parameters
    ----------
    source : Garment
        The garment to vary, as :func:`checked` returns it.
    rng : numpy.random.Generator
        Source of all randomness.
    parameters : SynthParameters
        ``size_range``, ``stretch``, ``shape_cm``, ``asymmetry_cm``, ``bow`` and ``rim_cm``.

    Returns
    -------
    Garment
        With a dense outline (a point every ``STEP_CM``) around its centre.
    """
    scale = rng.uniform(*parameters.size_range)
    ring = source.outline * scale
    names = list(source.landmarks)
    marks = np.array([source.landmarks[name] * scale for name in names]).reshape(-1, 2)
    centre = (ring.min(axis=0) + ring.max(axis=0)) / 2
    ring, marks = ring - centre, marks - centre
    dense = resample(ring, STEP_CM)
    at = nearest_index(dense, marks)
    for attempt in range(_TRIES):
        amount = 0.5**attempt
        stretch = np.exp(rng.normal(0.0, amount * parameters.stretch / 2))
        factors = np.array([stretch, 1.0 / stretch])
        moved = dense * factors
        if len(names):
            shift = amount * _landmark_shifts(names, marks, source.symmetry, rng, parameters)
            moved = _carry(moved, at, shift, rng.normal(0.0, amount * parameters.bow, len(names)))
        moved = _smooth_ring(moved, _ROUNDING_CM / STEP_CM)
        moved += _waves(moved, rng, amount * parameters.rim_cm)
        if is_simple(moved):
            break
    else:
        moved = dense  # the garment as given
    landmarks = {name: moved[k] for name, k in zip(names, at, strict=True)}
    return replace(source, outline=moved, landmarks=landmarks)


def polygon_area(ring: Points) -> float:
    """Return the area of a closed outline, in its unit squared, whichever way round it runs."""
    return abs(float(_core.signed_area(np.ascontiguousarray(ring))))


def resample(ring: Points, step: float) -> Points:
    """Set points at equal distance, about ``step``, along a closed outline; the first one is kept."""
    return np.asarray(
        _core.resample(np.ascontiguousarray(ring), max(8, round(perimeter(ring) / step))), dtype=np.float64
    )


def nearest_index(ring: Points, points: Points) -> NDArray[np.intp]:
    """Find the index of the point of ``ring`` nearest to each of ``points``."""
    return np.array([int(((ring - p) ** 2).sum(axis=1).argmin()) for p in points], dtype=np.intp)


def is_simple(ring: Points) -> bool:
    """Tell whether points are an outline: finite, with an area, and not crossing itself."""
    try:
        _core.check_outline(np.ascontiguousarray(ring))
    except ValueError:
        return False
    return True


def _landmark_shifts(
    names: list[str],
    marks: Points,
    symmetry: Sequence[tuple[str, str]],
    rng: np.random.Generator,
    parameters: SynthParameters,
) -> Points:
    """Draw every landmark's displacement: a part mirrored between partners, and each one's own."""
    distance2 = ((marks[:, None] - marks[None]) ** 2).sum(axis=-1)
    likeness = (1 - _ALONE) * np.exp(-distance2 / (2 * _ALIKE_CM**2)) + _ALONE * np.eye(len(marks))
    mix = np.linalg.cholesky(likeness) / np.sqrt(2)
    own = parameters.asymmetry_cm * (mix @ rng.standard_normal(marks.shape))
    common = parameters.shape_cm * (mix @ rng.standard_normal(marks.shape))
    index = {name: k for k, name in enumerate(names)}
    pairs = [(index[a], index[b]) for a, b in symmetry if a in index and b in index and a != b]
    if pairs:
        left, right = np.array(pairs).T
        across = (marks[right] - marks[left]).sum(axis=0)
        across = across / max(float(np.linalg.norm(across)), 1e-12)
        common[right] = common[left] - 2 * np.outer(common[left] @ across, across)
    return np.asarray(common + own, dtype=np.float64)


def _carry(ring: Points, at: NDArray[np.intp], shift: Points, bows: Points) -> Points:
    """Move the points ``ring[at]`` by ``shift``; the pieces between them follow, and bulge by ``bows``."""
    n, moved = len(ring), ring.copy()
    at, first = np.unique(at, return_index=True)  # in the order of the outline; of two at one point the first
    shift = shift[first]
    for k in range(len(at)):
        after = (k + 1) % len(at)
        span = int((at[after] - at[k] - 1) % n) + 1  # the whole ring if there is one landmark only
        piece = (at[k] + np.arange(span + 1)) % n
        z = ring[piece, 0] + 1j * ring[piece, 1]
        ends = shift[[k, after], 0] + 1j * shift[[k, after], 1]
        t = np.linspace(0.0, 1.0, span + 1)
        chord = z[-1] - z[0]
        # A similarity carries the shape of the piece along; where its ends (almost) meet none is defined.
        length = float(np.abs(np.diff(z)).sum())
        if abs(chord) > 0.2 * length:
            out = (z - z[0]) * (1 + (ends[1] - ends[0]) / chord) + z[0] + ends[0]
        else:
            out = z + ends[0] * (1 - t) + ends[1] * t
        out = out + 1j * chord * (4 * t * (1 - t) * bows[k])
        moved[piece[:-1], 0], moved[piece[:-1], 1] = out[:-1].real, out[:-1].imag
    return np.asarray(moved, dtype=np.float64)


def _smooth_ring(ring: Points, sigma: float) -> Points:
    """Smooth a closed outline by a Gaussian, ``sigma`` in points."""
    z = np.fft.fft(ring[:, 0] + 1j * ring[:, 1])
    frequency = np.fft.fftfreq(len(ring))
    out = np.fft.ifft(z * np.exp(-2 * (np.pi * sigma * frequency) ** 2))
    return np.asarray(np.column_stack([out.real, out.imag]), dtype=np.float64)


def _waves(ring: Points, rng: np.random.Generator, rms: float) -> Points:
    """Draw small smooth displacements of the points of a rim, in waves of about 4 cm and longer."""
    waves = _smooth_ring(rng.normal(0.0, 1.0, ring.shape), 2.0 / STEP_CM)
    size = float(np.sqrt((waves**2).sum(axis=1).mean()))
    return np.asarray(waves * (rms / max(size, 1e-12)), dtype=np.float64)
