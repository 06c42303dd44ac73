"""Stage 4, order-preserving alignment, against all matchings there are and a plain dynamic programme."""

from __future__ import annotations

from itertools import combinations, pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from conftest import star
from foldrs import _core


def cost_matrices(most):
    """Costs (n, m) from 0 to 2, up to `most` points each."""
    sizes = st.tuples(st.integers(1, most), st.integers(1, most))
    return st.builds(
        lambda size, seed: np.random.default_rng(seed).uniform(0, 2, size), sizes, st.integers(0, 2**32 - 1)
    )


penalties = st.floats(0.05, 1.0)


def exhaustive(cost, penalty, start):
    """Least cost a row over every matching that keeps the order from `start` on."""
    n, m = cost.shape
    cut = np.roll(cost, -start, axis=1)
    matchings = (
        cut[rows, columns].sum() + penalty * (n + m - 2 * k)
        for k in range(min(n, m) + 1)
        for rows in map(list, combinations(range(n), k))
        for columns in map(list, combinations(range(m), k))
    )
    return min(matchings) / n


def plain(cost, penalty, start):
    """The same by dynamic programming, cell by cell."""
    n, m = cost.shape
    cut = np.roll(cost, -start, axis=1)
    table = np.add.outer(np.arange(n + 1.0), np.arange(m + 1.0)) * penalty
    for i in range(1, n + 1):
        for j in range(1, m + 1):
            skip = min(table[i - 1, j], table[i, j - 1]) + penalty
            table[i, j] = min(skip, table[i - 1, j - 1] + cut[i - 1, j - 1])
    return table[n, m] / n


@given(cost_matrices(4), penalties)
def test_costs_are_the_least_of_all_matchings(cost, penalty):
    starts = range(cost.shape[1])
    expected = [exhaustive(cost, penalty, s) for s in starts]
    np.testing.assert_allclose(_core.alignment_costs(cost, list(starts), penalty), expected, atol=1e-5)


@given(cost_matrices(14), penalties)
def test_costs_are_those_of_the_plain_programme(cost, penalty):
    starts = range(cost.shape[1])
    expected = [plain(cost, penalty, s) for s in starts]
    np.testing.assert_allclose(_core.alignment_costs(cost, list(starts), penalty), expected, atol=1e-5)


@given(cost_matrices(14), penalties)
def test_the_cheapest_of_all_starts_is_found_with_the_pairs_that_cost_it(cost, penalty):
    n, m = cost.shape
    found, pairs = _core.align(cost, penalty)
    assert found == pytest.approx(min(plain(cost, penalty, s) for s in range(m)), abs=1e-5)
    total = cost[pairs[:, 0], pairs[:, 1]].sum() + penalty * (n + m - 2 * len(pairs))
    assert total / n == pytest.approx(found, abs=1e-5)
    assert (np.diff(pairs[:, 0]) > 0).all()
    # Once round: the steps from each column to the next, and back to the first, add up to m at most.
    assert np.sum(np.diff(pairs[:, 1]) % m) < m
    assert len(set(pairs[:, 1])) == len(pairs)


def check_against_baseline(cost, baseline):
    starts = list(range(0, cost.shape[1], max(1, cost.shape[1] // 8)))
    from_its_starts = _core.alignment_costs(cost, starts).min()
    assert from_its_starts == pytest.approx(baseline.align(cost), abs=1e-5)
    assert _core.align(cost)[0] <= from_its_starts + 1e-6


def test_the_plain_version_agrees_for_its_starts(baseline):
    rng = np.random.default_rng(5)
    for n, m in [(3, 20), (20, 3), (40, 40), (30, 57)]:
        check_against_baseline(rng.uniform(0, 2, (n, m)), baseline)


def test_the_plain_version_agrees_on_real_outlines(baseline, real_outlines):
    samples = [_core.resample(outline, 60) for outline in real_outlines[::25]]
    for a, b in pairwise(samples):
        check_against_baseline(_core.matching_costs(a, b), baseline)


@given(st.integers(0, 2**32 - 1), st.integers(12, 40), st.integers(0, 39))
def test_an_outline_started_elsewhere_is_matched_point_by_point(seed, n, by):
    points = star(np.random.default_rng(seed).uniform(1, 10, n).tolist(), turn=0.1)
    cost, pairs = _core.align(_core.matching_costs(points, np.roll(points, by, axis=0)))
    assert cost < 1e-5
    np.testing.assert_array_equal(pairs[:, 1], (np.arange(n) + by) % n)


def test_points_too_dear_to_match_are_skipped():
    cost, pairs = _core.align(np.full((2, 2), 1.3))
    assert cost == pytest.approx(1.2)
    assert pairs.shape == (0, 2)


@pytest.mark.parametrize(
    ("cost", "penalty", "message"),
    [
        (np.zeros((0, 3)), 0.6, "at least one row"),
        (np.full((2, 2), np.nan), 0.6, "finite"),
        (np.full((2, 2), -1.0), 0.6, "not negative"),
        (np.ones((2, 2)), -0.1, "skip penalty"),
        (np.ones((2, 2)), np.inf, "skip penalty"),
    ],
)
def test_what_are_no_costs_is_named(cost, penalty, message):
    with pytest.raises(ValueError, match=message):
        _core.align(cost, penalty)
    with pytest.raises(ValueError, match=message):
        _core.alignment_costs(cost, [0], penalty)


@pytest.mark.parametrize("start", [-1, 2])
def test_a_start_that_is_no_column_is_named(start):
    with pytest.raises(ValueError, match="no column"):
        _core.alignment_costs(np.ones((3, 2)), [0, start])
