"""Piecewise registration by local similarities (sections 2.2.1 and 2.2.2).

Points of the plane are complex numbers here: a non-reflective similarity (eq. 2) is then
``z -> turn * z + offset``, and the least-squares one has a closed form, so all of them are found at once from
weighted sums.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from foldrs import _core
from foldrs.parameters import FittingParameters

Points = NDArray[np.float64]
Complex = NDArray[np.complex128]

KEPT, FLAP, CREASE = 0, 1, 2
"""Codes of the layers of a folded outline, as the crate gives them."""


@dataclass(frozen=True, eq=False)
class LocalSimilarities:
    """One non-reflective similarity (eq. 2) a place: ``z -> turn * z + offset``."""

    turn: Complex
    """(k,) rotation and scale."""
    offset: Complex
    """(k,) translation."""

    def apply(self, points: Points, place: NDArray[np.intp] | slice = slice(None)) -> Points:
        """Move (k, 2) points, each by the similarity of its place (by default point i by similarity i)."""
        return as_points(self.turn[place] * as_complex(points) + self.offset[place])


@dataclass(frozen=True, eq=False)
class RegisteredFold:
    """A virtually folded template laid onto the seen outline piece by piece (section 2.2.1).

    All coordinates are seen px; x runs the other way if the garment shows its other face, so that no
    similarity has to reflect.
    """

    folded: Points
    """(m, 2) RVFC, the registered points of the folded outline."""
    axis: Points
    """(2, 2) RFAxis, the axis moved with its points."""
    arc: NDArray[np.float64]
    """(v,) arc lengths on the unfolded template at which it is visible."""
    unfolded: Points
    """(v, 2) VUC, the visible points of the virtually unfolded outline; hidden ones are missing."""


def local_similarities(weights: Points, source: Points, target: Points) -> LocalSimilarities:
    """Least-squares similarities of weighted points.

    Parameters
    ----------
    weights : (k, m) array
        Weight of every pair of points for each of the k similarities, not negative.
    source, target : (m, 2) arrays
        Corresponding points.

    Returns
    -------
    LocalSimilarities
        k of them. One whose points do not spread is the mere translation of their mean.
    """
    share = weights / weights.sum(axis=1, keepdims=True)
    origin = source.mean(axis=0)  # far from the points, their spread would be lost in rounding
    z, w = as_complex(source - origin), as_complex(target)
    # Not by `@`: for arrays this small the threads of a BLAS cost far more than the sums.
    moments = np.einsum("km,cm->ck", share, np.stack([z, w, z * z.conj(), w * z.conj()]))
    mean_z, mean_w = moments[0], moments[1]
    spread = moments[2].real - np.abs(mean_z) ** 2
    cross = moments[3] - mean_w * mean_z.conj()
    flat = spread <= 1e-12 * np.ptp(source, axis=0).max() ** 2
    turn = np.where(flat, 1.0, cross / np.where(flat, 1.0, spread))
    return LocalSimilarities(turn, mean_w - turn * (mean_z + as_complex(origin)))


def register_fold(
    laid: _core.Explanation, seen: Points, axis: Points, parameters: FittingParameters
) -> RegisteredFold | None:
    """Register a folded template to the seen outline, then unfold it virtually (section 2.2.1).

    Parameters
    ----------
    laid : _core.Explanation
        The folded template with its correspondences.
    seen : (n, 2) array
        The seen points that they refer to, px.
    axis : (2, 2) array
        The axis on the template, template units.
    parameters : FittingParameters
        Size of the neighbourhoods.

    Returns
    -------
    RegisteredFold or None
        None if fewer than three points correspond.
    """
    paired = laid.partner >= 0
    if paired.sum() < 3:
        return None
    mirrored = float(np.linalg.det(laid.to_seen[:, :2])) < 0
    target = seen * [-1.0, 1.0] if mirrored else seen

    count = len(laid.folded)
    step = np.abs(np.arange(count)[:, None] - np.flatnonzero(paired))
    near = np.minimum(step, count - step) <= parameters.neighbours // 2
    # All pairs take part a little, so that a neighbourhood without partners moves with the whole.
    maps = local_similarities(near + parameters.whole, laid.folded[paired], target[laid.partner[paired]])
    folded = maps.apply(laid.folded)

    of_crease = np.flatnonzero(laid.layer == CREASE)
    of_crease = of_crease if len(of_crease) else np.arange(count)
    apart = np.linalg.norm(axis[:, None] - laid.folded[of_crease], axis=2)
    moved_axis = maps.apply(axis, of_crease[apart.argmin(axis=1)])

    cloth = laid.layer != CREASE
    flap = (laid.layer == FLAP)[cloth]
    unfolded = np.where(flap[:, None], _core.reflect(folded[cloth], moved_axis), folded[cloth])
    return RegisteredFold(folded, moved_axis, laid.arc[cloth], unfolded)


def register_template(
    outline: Points, at: NDArray[np.float64], fold: RegisteredFold, parameters: FittingParameters
) -> Points:
    """Register points of the template to the virtually unfolded outline (section 2.2.2).

    Every point moves by the similarity of the visible points around it, weighted by a Gaussian over the arc
    length between them.

    Parameters
    ----------
    outline : (n, 2) array
        The template.
    at : (k,) array
        Arc lengths on it.
    fold : RegisteredFold
        Where its visible points lie.
    parameters : FittingParameters
        Width of the Gaussian.

    Returns
    -------
    (k, 2) array
        RUC, seen px, in the frame of `fold`.
    """
    apart = shares_apart(outline, at, fold.arc)
    weights = np.exp(-0.5 * (apart / parameters.width) ** 2) + parameters.whole
    maps = local_similarities(weights, _core.points_at(outline, fold.arc), fold.unfolded)
    return maps.apply(_core.points_at(outline, at))


def shares_apart(outline: Points, at: NDArray[np.float64], others: NDArray[np.float64]) -> Points:
    """Return (k, v) distances between arc lengths of a closed outline, as shares of its whole length."""
    length = perimeter(outline)
    apart = np.abs(at[:, None] - others)
    return np.minimum(apart, length - apart) / length


def perimeter(outline: Points) -> float:
    """Length of a closed outline."""
    return float(np.linalg.norm(np.roll(outline, -1, axis=0) - outline, axis=1).sum())


def as_complex(points: Points) -> Complex:
    """Points (..., 2) as complex numbers."""
    return np.asarray(points[..., 0] + 1j * points[..., 1], dtype=np.complex128)


def as_points(numbers: Complex) -> Points:
    """Complex numbers as points (..., 2)."""
    return np.stack([numbers.real, numbers.imag], axis=-1)
