"""Stage 3, virtual folding, against shapely."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from shapely import affinity
from shapely.geometry import LineString, Polygon
from shapely.ops import split, unary_union

from conftest import simple_polygons
from foldrs import _core


def line_through(outline, angle, shift):
    """An axis spanning the whole outline: direction ``angle``, ``shift`` of the extent beside its centre."""
    d = np.array([np.cos(angle), np.sin(angle)])
    size = np.ptp(outline, axis=0).max()
    middle = outline.mean(axis=0) + shift * size * np.array([-d[1], d[0]])
    return np.array([middle - 4 * size * d, middle + 4 * size * d])


def mirror(axis):
    """Coefficients of the reflection over an axis, as shapely takes them."""
    a, d = axis[0], (axis[1] - axis[0]) / np.linalg.norm(axis[1] - axis[0])
    c, s = d[0] ** 2 - d[1] ** 2, 2 * d[0] * d[1]
    return [c, s, s, -c, a[0] - c * a[0] - s * a[1], a[1] - s * a[0] + c * a[1]]


def folded_by_shapely(outline, axis):
    d = axis[1] - axis[0]
    parts = split(Polygon(outline), LineString(axis)).geoms

    def on_left(part):
        p = part.representative_point()
        return d[0] * (p.y - axis[0][1]) - d[1] * (p.x - axis[0][0]) > 0

    kept = [p for p in parts if not on_left(p)]
    flap = [affinity.affine_transform(p, mirror(axis)) for p in parts if on_left(p)]
    return kept, flap


def union_area_and_outline(pieces):
    union = unary_union([p.buffer(1e-9) for p in pieces])
    largest = max(getattr(union, "geoms", [union]), key=lambda g: g.area)
    return Polygon(largest.exterior)


def check_against_shapely(outline, axis):
    area = Polygon(outline).area
    kept, flap = folded_by_shapely(outline, axis)
    folded = _core.fold_layers(outline, axis)
    ours = Polygon(folded.outline)
    assert ours.buffer(0).symmetric_difference(union_area_and_outline([*kept, *flap])).area < 1e-6 * area
    # Cloth is neither lost nor made, layer by layer.
    for mine, theirs in ((folded.kept, kept), (folded.flap, flap)):
        assert sum(Polygon(p).area for p in mine) == pytest.approx(
            sum(p.area for p in theirs), abs=1e-9 * area
        )


def check_unfolds(outline, axis):
    """Turning the flap back over the same crease gives the original."""
    folded = _core.fold_layers(outline, axis)
    back = [affinity.affine_transform(Polygon(p), mirror(axis)) for p in folded.flap]
    original = unary_union([g.buffer(1e-9) for g in [*map(Polygon, folded.kept), *back]])
    assert original.symmetric_difference(Polygon(outline)).area < 1e-6 * Polygon(outline).area


@given(simple_polygons, st.floats(0, 2 * np.pi), st.floats(-0.3, 0.3))
def test_folding_random_outlines_over_a_whole_line(outline, angle, shift):
    axis = line_through(outline, angle, shift)
    kept, flap = folded_by_shapely(outline, axis)
    assume(min(sum(p.area for p in ps) for ps in (kept, flap)) > 1e-3)
    check_against_shapely(outline, axis)
    check_unfolds(outline, axis)


def test_folding_real_outlines(real_outlines):
    rng = np.random.default_rng(7)
    for outline in real_outlines:
        axis = line_through(outline, rng.uniform(0, 2 * np.pi), rng.uniform(-0.2, 0.2))
        check_against_shapely(outline, axis)
        check_unfolds(outline, axis)


H = np.array(
    [[0, 0], [1, 0], [1, 2], [2, 2], [2, 0], [3, 0], [3, 5], [2, 5], [2, 3], [1, 3], [1, 5], [0, 5]], float
)


def test_only_the_chord_under_the_axis_is_creased():
    one = _core.fold_layers(H, np.array([[3.2, 1.0], [1.8, 1.0]]))
    both = _core.fold_layers(H, np.array([[3.2, 1.0], [-0.2, 1.0]]))
    assert (len(one.creases), len(both.creases)) == (1, 2)
    assert sum(Polygon(p).area for p in one.flap) == pytest.approx(1.0)
    assert sum(Polygon(p).area for p in both.flap) == pytest.approx(2.0)


def test_turning_the_other_side_gives_the_mirror_image():
    axis = np.array([[-1.0, 3.4], [4.0, 3.9]])
    one, other = _core.fold_layers(H, axis), _core.fold_layers(H, axis[::-1])
    mirrored = affinity.affine_transform(Polygon(other.outline), mirror(axis))
    assert mirrored.symmetric_difference(Polygon(one.outline)).area < 1e-6


def test_a_vertex_on_the_axis_is_no_trouble():
    diamond = np.array([[0, -1], [1, 0], [0, 1], [-1, 0]], float)
    folded = _core.fold_layers(diamond, np.array([[-2.0, 0.0], [2.0, 0.0]]))
    assert Polygon(folded.outline).area == pytest.approx(1.0)


def test_holes_are_named():
    """A long arm turned back so that its hand lies on the body encloses the table."""
    angle = np.array([[0, 0], [10, 0], [10, 1], [1, 1], [1, 6], [0, 6]], float)
    elbow, d = np.array([4.0, 0.5]), np.array([np.cos(3 * np.pi / 8), np.sin(3 * np.pi / 8)])
    folded = _core.fold_layers(angle, np.array([elbow + d, elbow - d]))
    assert folded.holes == 1
    assert _core.fold_layers(H, np.array([[3.2, 1.0], [1.8, 1.0]])).holes == 0


@pytest.mark.parametrize(
    ("axis", "message"),
    [
        ([[5, 5], [6, 6]], "does not cross"),
        ([[0, 0], [0, 0]], "no direction"),
        ([[np.nan, 0], [1, 1]], "no direction"),
    ],
)
def test_degenerate_folds_are_named(axis, message):
    with pytest.raises(ValueError, match=message):
        _core.fold_layers(H[:, ::-1].copy() * 0.5, np.array(axis, float))


def test_folding_over_a_side_has_no_flap():
    square = np.array([[0, 0], [1, 0], [1, 1], [0, 1]], float)
    for axis in ([[0, 1], [1, 1]], [[1, 1], [0, 1]], [[0, 0], [1, 0]]):
        with pytest.raises(ValueError, match="fold axis"):
            _core.fold_layers(square, np.array(axis, float))
