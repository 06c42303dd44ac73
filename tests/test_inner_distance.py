"""Stage 4, inner distances and shape contexts, against plain versions of their definitions."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from conftest import simple_polygons, star
from foldrs import _core

# Radii and directions without symmetry: nothing lies on the border of two bins, where rounding decides.
generic_polygons = st.builds(
    lambda seed, n: star(np.random.default_rng(seed).uniform(1, 10, n).tolist(), turn=0.1234),
    st.integers(0, 2**32 - 1),
    st.integers(5, 40),
)

U = np.array([[0, 0], [5, 0], [5, 4], [4, 4], [4, 1], [1, 1], [1, 4], [0, 4]], float)


def turned(points, angle, scale=1.0, shift=(0.0, 0.0)):
    c, s = np.cos(angle), np.sin(angle)
    return scale * points @ np.array([[c, s], [-s, c]]) + shift


def simple_samples(outlines, n):
    """Every outline at n equal steps, but for those whose samples cut a corner across another part."""
    for outline in outlines:
        points = _core.resample(outline, n)
        try:
            _core.check_outline(points)
        except ValueError:
            continue
        yield points


def check_distances(points, baseline):
    expected, _ = baseline.inner_distances(points)
    actual = _core.inner_distances(points)
    np.testing.assert_allclose(actual, expected, rtol=0, atol=1e-6 * np.ptp(points))


@given(points=simple_polygons)
def test_random_outlines_agree_with_shortest_paths_in_the_visibility_graph(baseline, points):
    check_distances(points, baseline)


@pytest.mark.parametrize("n", [60, 100])
def test_real_outlines_agree_with_shortest_paths_in_the_visibility_graph(baseline, real_outlines, n):
    samples = list(simple_samples(real_outlines, n))
    assert len(samples) > 0.9 * len(real_outlines)
    for points in samples:
        check_distances(points, baseline)


def test_a_path_goes_around_a_notch():
    assert _core.inner_distances(U)[3, 6] == 9.0
    assert _core.inner_distances(U)[2, 3] == 1.0


@given(simple_polygons, st.floats(-4, 4), st.floats(0.01, 100), st.integers(0, 40), st.booleans())
def test_distances_do_not_depend_on_where_the_outline_lies_or_starts(points, angle, scale, start, mirrored):
    n = len(points)
    order = (np.arange(n) + start) % n
    order = order[::-1] if mirrored else order
    moved = turned(points * ([-1, 1] if mirrored else [1, 1]), angle, scale, (3.0, -70.0))[order]
    expected = scale * _core.inner_distances(points)[np.ix_(order, order)]
    np.testing.assert_allclose(_core.inner_distances(moved), expected, rtol=0, atol=1e-9 * (100 + 20 * scale))


@given(points=generic_polygons, n_dist=st.integers(1, 6), n_theta=st.integers(1, 16))
def test_shape_contexts_agree_with_the_plain_version(baseline, points, n_dist, n_theta):
    expected = baseline.shape_context(points, n_dist, n_theta)
    np.testing.assert_allclose(_core.shape_contexts(points, n_dist, n_theta), expected, atol=1e-6)


@given(generic_polygons, generic_polygons)
def test_matching_costs_are_chi_squared_distances(a, b):
    x, y = _core.shape_contexts(a)[:, None], _core.shape_contexts(b)[None]
    total = x + y
    expected = ((x - y) ** 2 / np.where(total > 0, total, 1)).sum(axis=-1)
    np.testing.assert_allclose(_core.matching_costs(a, b), expected, atol=1e-5)
    np.testing.assert_allclose(_core.matching_costs(b, a), expected.T, atol=1e-5)


@given(generic_polygons, st.floats(-3, 3), st.floats(0.1, 50))
def test_an_outline_turned_and_scaled_costs_nothing(points, angle, scale):
    cost = _core.matching_costs(points, turned(points, angle, scale, (5.0, -9.0)))
    assert np.diagonal(cost).max() < 1e-6


@pytest.mark.parametrize(
    ("points", "message"),
    [(U[:2], "at least three points"), (U * [1, np.nan], "not finite"), (np.zeros((4, 3)), "shape")],
)
def test_what_is_no_outline_is_named(points, message):
    for stage in (_core.inner_distances, _core.shape_contexts, lambda p: _core.matching_costs(U, p)):
        with pytest.raises(ValueError, match=message):
            stage(points)


@pytest.mark.parametrize("bins", [{"n_dist": 0}, {"n_theta": 0}])
def test_no_bins_are_named(bins):
    with pytest.raises(ValueError, match="at least one bin"):
        _core.shape_contexts(U, **bins)
