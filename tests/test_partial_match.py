"""Stage 1, partial matching by chord angles, against its definition."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from conftest import star
from foldrs import _core

DELTA = 5


def wavy(seed, n):
    """A smooth outline without symmetry, at n equal steps."""
    rng = np.random.default_rng(seed)
    angle = np.arange(400) * 2 * np.pi / 400
    waves = sum(rng.uniform(-0.5, 0.5) / k * np.cos(k * angle + rng.uniform(0, 6)) for k in range(1, 8))
    return _core.resample(star((2 + waves).tolist()), n)


outlines = st.builds(wavy, st.integers(0, 2**32 - 1), st.integers(24, 60))


def parameters(**changes):
    every = _core.default_parameters()
    assert every["partial_match"]["delta"] == DELTA
    every["partial_match"].update(changes)
    return every


def mirrored(points):
    """Mirror image over the y axis, wound as before; point i is the image of point -i."""
    return np.roll(points[::-1] * [-1, 1], 1, axis=0)


def moved(points, angle, scale, shift):
    c, s = np.cos(angle), np.sin(angle)
    return scale * points @ np.array([[c, s], [-s, c]]) + shift


def signed_angle(u, v):
    """From u to v, positive from x towards y."""
    return np.arctan2(u[..., 0] * v[..., 1] - u[..., 1] * v[..., 0], (u * v).sum(axis=-1))


def chord_angles(points, start, length):
    """Both angles of all pairs of points of a piece, (pairs, 2), from the definition."""
    first, second = np.triu_indices(length, DELTA + 1)
    i, j = start + first, start + second

    def p(index):
        return points[index % len(points)]

    at_end = signed_angle(p(i) - p(j), p(j - DELTA) - p(j))
    at_start = signed_angle(p(j) - p(i), p(i + DELTA) - p(i))
    return np.stack([at_end, at_start], axis=1)


def mean_square(differences):
    wrapped = (differences + np.pi) % (2 * np.pi) - np.pi
    return (wrapped**2).mean()


def direct_difference(a, start, b, template_start, length):
    return mean_square(chord_angles(a, start, length) - chord_angles(b, template_start, length))


def check_scores(a, b, group):
    found = _core.partial_matches(a, b, {**parameters(), "partial_match": group})
    for start, template_start, length, difference, affinity in found:
        expected = direct_difference(a, start, b, template_start, length)
        assert difference == pytest.approx(expected, abs=1e-4 * (1 + expected))
        likeness = np.exp(-expected / group["likeness"] ** 2)
        assert affinity == pytest.approx(likeness * (1 - np.exp(-length / group["length"])), abs=1e-4)
        assert affinity >= group["affinity"] - 1e-6
        assert group["shortest"] <= length <= group["longest"] * min(len(a), len(b))
    return found


@settings(max_examples=30)
@given(outlines, outlines)
def test_every_score_follows_the_definition(a, b):
    group = parameters(affinity=1e-3, likeness=1.5)["partial_match"]
    assert check_scores(a, b, group)


def test_every_score_on_real_outlines_follows_the_definition(real_outlines):
    group = parameters(affinity=0.02)["partial_match"]
    samples = [_core.resample(outline, 80 + 10 * (k % 3)) for k, outline in enumerate(real_outlines[::40])]
    found = [check_scores(a, b, group) for a, b in pairwise(samples)]
    assert sum(map(len, found)) > len(found)


@settings(max_examples=20)
@given(outlines, outlines)
def test_the_best_come_first_and_say_different_things(a, b):
    found = _core.partial_matches(a, b, parameters(affinity=1e-3))
    affinities = [match[4] for match in found]
    assert affinities == sorted(affinities, reverse=True)
    for k, (s, t, length, *_) in enumerate(found):
        for other_s, other_t, other_length, *_ in found[:k]:
            same_offset = (s - t) % len(a) == (other_s - other_t) % len(a) and len(a) == len(b)
            ahead = (other_s - s + len(a) // 2) % len(a) - len(a) // 2
            shared = min(length, ahead + other_length) - max(ahead, 0)
            assert not same_offset or 2 * shared <= min(length, other_length)


@settings(max_examples=10)
@given(st.integers(0, 2**32 - 1), st.integers(0, 2**32 - 1))
def test_no_piece_matches_better_than_the_best(seed, other_seed):
    a, b = wavy(seed, 20), wavy(other_seed, 22)
    changes = {"shortest": 14, "longest": 0.8, "affinity": 1e-9, "likeness": 2.0}
    group = parameters(**changes)["partial_match"]

    def affinity(s, t, length):
        difference = direct_difference(a, s, b, t, length)
        return np.exp(-difference / group["likeness"] ** 2) * (1 - np.exp(-length / group["length"]))

    pieces = ((s, t, k) for s in range(20) for t in range(22) for k in range(14, 17))
    best = _core.partial_matches(a, b, parameters(**changes))[0]
    assert best[4] == pytest.approx(max(affinity(*piece) for piece in pieces), abs=1e-4)


@settings(max_examples=30)
@given(outlines, outlines, st.floats(-4, 4), st.floats(0.1, 50))
def test_turning_moving_and_scaling_change_nothing(a, b, angle, scale):
    everything = parameters(affinity=0.02)
    found = _core.partial_matches(a, b, everything)
    again = _core.partial_matches(moved(a, angle, scale, (7.0, -30.0)), b, everything)
    assert len(again) == len(found)
    np.testing.assert_allclose([m[4] for m in again], [m[4] for m in found], atol=1e-4)
    for first, second in zip(found[:1], again[:1], strict=True):
        assert second == pytest.approx(first, abs=1e-4)


@given(outlines, outlines, st.integers(0, 99), st.integers(0, 99), st.integers(DELTA + 2, 24))
def test_two_pieces_mirrored_differ_as_before(a, b, start, template_start, length):
    s, t = start % len(a), template_start % len(b)
    image_s, image_t = -(s + length - 1) % len(a), -(t + length - 1) % len(b)
    before = _core.piece_difference(a, s, b, t, length)
    after = _core.piece_difference(mirrored(a), image_s, mirrored(b), image_t, length)
    assert after == pytest.approx(before, abs=1e-5)


@given(outlines, st.integers(0, 99), st.integers(DELTA + 2, 24))
def test_mirroring_one_outline_negates_its_chord_angles(points, start, length):
    s = start % len(points)
    image = -(s + length - 1) % len(points)
    # In the image the piece runs backwards: pairs swap their ends.
    first, second = np.triu_indices(length, DELTA + 1)
    place = {(i, j): k for k, (i, j) in enumerate(zip(first, second, strict=True))}
    swapped = [place[length - 1 - j, length - 1 - i] for i, j in zip(first, second, strict=True)]
    angles = chord_angles(points, s, length)
    negated = -angles[swapped][:, ::-1]
    actual = _core.piece_difference(points, s, mirrored(points), image, length)
    assert actual == pytest.approx(mean_square(angles - negated), abs=1e-4)


@settings(max_examples=30)
@given(outlines, st.integers(0, 59))
def test_an_outline_is_found_in_itself(points, by):
    best = _core.partial_matches(points, np.roll(points, by, axis=0), parameters())[0]
    assert (best[1] - best[0]) % len(points) == by % len(points)
    assert best[3] < 1e-6
    assert best[2] == int(0.8 * len(points))


SQUARE = star([1.0] * 8)


def test_outlines_shorter_than_any_piece_have_no_matches():
    assert _core.partial_matches(SQUARE, SQUARE, parameters()) == []


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"start": 30}, "start = 30 is no point"),
        ({"template_start": 30}, "template_start = 30 is no point"),
        ({"length": DELTA + 1}, "from delta"),
        ({"length": 31}, "to 30 points"),
        ({"seen_points": SQUARE[:2]}, "at least three points"),
        ({"seen_points": SQUARE * np.nan}, "not finite"),
    ],
)
def test_pieces_that_cannot_be_are_named(arguments, message):
    points = wavy(1, 30)
    piece = {"seen_points": points, "start": 0, "template_points": points, "template_start": 0, "length": 12}
    with pytest.raises(ValueError, match=message):
        _core.piece_difference(**{**piece, **arguments})


def test_an_unknown_parameter_is_named():
    with pytest.raises(ValueError, match="nonsense"):
        _core.partial_matches(SQUARE, SQUARE, parameters(nonsense=1))
