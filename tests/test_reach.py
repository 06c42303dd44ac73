"""Reach: how probable it is that a gripper holds the garment by a landmark where it is told to lie."""

from dataclasses import replace

import numpy as np
import pytest

import foldrs
from foldrs import Parameters, _core
from foldrs.landmark import carried
from foldrs.parameters import GraspParameters
from foldrs.reach import Reach, reach_over

CORNER_IN = np.array([[0, 0], [200, 0], [200, 160], [100, 260], [0, 260]], float)
"""A towel, 4 px a centimetre, one corner of which is turned over."""


@pytest.fixture(scope="module")
def towel() -> foldrs.FitResult:
    return foldrs.fit(CORNER_IN, garment_type="towel", px_per_cm=4)


@pytest.fixture(scope="module")
def in_halves() -> foldrs.FitResult:
    """A shirt folded along its middle; by the outline alone either layer may stick out."""
    template = foldrs.builtin_templates("t-shirt")[0]
    middle = np.array([[0.0, -20.0], [0.0, 120.0]])
    seen = _core.fold_layers(4 * template.outline + 100, 4 * middle + 100).outline
    return foldrs.fit(seen, garment_type="t-shirt", px_per_cm=4)


def test_probabilities_of_several_landmarks_are_of_all_at_once():
    within = np.array([[True, True, False], [True, False, True], [False, True, True]])
    reach = Reach(("a", "b", "c"), np.array([0.5, 0.3, 0.2]), within)
    assert [reach.of(name) for name in "abc"] == pytest.approx([0.8, 0.7, 0.5])
    assert reach.of("a", "b") == pytest.approx(0.5)
    assert reach.of("a", "b", "c") == 0.0


def test_the_corner_turned_over_is_out_of_reach_and_the_others_are_within(towel):
    reaches = sorted(mark.reach for mark in towel.landmarks.values())
    assert reaches[0] < 0.1
    assert min(reaches[1:]) > 0.9
    assert [mark.accessible for mark in towel.landmarks.values()].count(False) == 1


def test_pairs_are_told_the_most_probable_first_and_hold_accessible_landmarks(in_halves):
    chances = np.array([pair.probability for pair in in_halves.grasp_pairs])
    # Nothing that comes later is better by more than what counts as nothing.
    later = np.maximum.accumulate(chances[::-1])[::-1]
    assert chances.max() - chances.min() > 0.1
    assert (later - chances <= GraspParameters().as_good + 1e-9).all()
    for pair in in_halves.grasp_pairs:
        reach = [in_halves.landmarks[name].reach for name in pair.landmarks]
        assert all(in_halves.landmarks[name].accessible for name in pair.landmarks)
        assert 0.0 <= pair.probability <= min(reach)


def test_of_about_equally_probable_pairs_the_templates_order_decides(in_halves):
    listed = foldrs.builtin_templates("t-shirt")[0].grasp_pairs
    best = max(pair.probability for pair in in_halves.grasp_pairs)
    likely = [pair for pair in in_halves.grasp_pairs if pair.probability >= best - GraspParameters().as_good]
    assert list(in_halves.grasp_pairs[: len(likely)]) == likely
    places = [listed.index(pair.landmarks) for pair in likely]
    assert places == sorted(places)


def test_where_all_counts_as_good_the_order_is_the_templates():
    any_order = replace(Parameters(), grasp=replace(GraspParameters(), as_good=1.0))
    result = foldrs.fit(CORNER_IN, garment_type="towel", px_per_cm=4, parameters=any_order)
    listed = foldrs.builtin_templates("towel")[0].grasp_pairs
    told = [pair.landmarks for pair in result.grasp_pairs]
    assert len(told) > 1
    assert told == [pair for pair in listed if pair in told]


def test_of_a_garment_in_halves_nothing_is_sure_and_yet_something_is_told(in_halves):
    # Both layers lie on each other: whatever is told of their rims is about even.
    told = in_halves.grasp_pairs[0].probability
    assert 0.1 < told < 0.9
    assert max(mark.reach for mark in in_halves.landmarks.values()) < 0.95


def test_a_landmark_is_accessible_if_that_is_likely_enough(in_halves):
    least = Parameters().grasp.likely
    assert {m.accessible for m in in_halves.landmarks.values()} == {True, False}
    for mark in in_halves.landmarks.values():
        assert mark.accessible == (mark.reach >= least)
    strict = replace(Parameters(), grasp=replace(GraspParameters(), likely=1.0))
    again = foldrs.fit(in_halves.outline_image, garment_type="t-shirt", px_per_cm=4, parameters=strict)
    assert again.grasp_pairs == ()
    assert again.unfolding.two_arms is None


def test_the_published_method_tells_no_probabilities():
    result = foldrs.fit(CORNER_IN, garment_type="towel", px_per_cm=4, method="paper")
    assert {mark.reach for mark in result.landmarks.values()} == {None}
    assert {pair.probability for pair in result.grasp_pairs} == {None}
    told = result.to_dict()
    assert {mark["reach"] for mark in told["landmarks"].values()} == {None}


def test_probabilities_are_told_in_the_json_form(towel):
    told = towel.to_dict()
    assert [pair["probability"] for pair in told["grasp_pairs"]] == [
        round(pair.probability, 4) for pair in towel.grasp_pairs
    ]
    assert {name: mark["reach"] for name, mark in told["landmarks"].items()} == {
        name: round(mark.reach, 4) for name, mark in towel.landmarks.items()
    }


def test_the_same_input_gives_the_same_probabilities(in_halves):
    again = foldrs.fit(in_halves.outline_image, garment_type="t-shirt", px_per_cm=4)
    assert [pair.probability for pair in again.grasp_pairs] == [
        pair.probability for pair in in_halves.grasp_pairs
    ]


def test_without_draws_every_explanation_counts_whole():
    few = Parameters()
    few = replace(few, matching=replace(few.matching, fit=replace(few.matching.fit, draws=0)))
    result = foldrs.fit(CORNER_IN, garment_type="towel", px_per_cm=4, parameters=few)
    known = [one.probability for one in result.alternatives]
    sums = {
        round(sum(p for k, p in enumerate(known) if choice >> k & 1), 6) for choice in range(2 ** len(known))
    }
    for mark in result.landmarks.values():
        assert min(abs(mark.reach * sum(known) - total) for total in sums) < 1e-5


def test_nothing_told_means_nothing_to_reach():
    assert reach_over([], {}, 4.0, GraspParameters()) is None


def test_landmarks_are_carried_to_like_shares_of_their_edges():
    square = np.array([[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0]])
    moved = carried({"a": np.array([1.0, 0.0]), "b": np.array([4.0, 4.0])}, square, square * [2.0, 3.0])
    np.testing.assert_allclose(moved["a"], [2.0, 0.0])
    np.testing.assert_allclose(moved["b"], [8.0, 12.0])
    assert list(moved) == ["a", "b"]
    assert carried({}, square, square) == {}


def test_outlines_of_other_numbers_of_corners_carry_nothing():
    square = np.array([[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0]])
    with pytest.raises(ValueError, match="as many corners"):
        _core.carried(square, square, square[:3])


def test_one_arm_takes_the_landmark_that_may_be_expected_to_turn_most(in_halves):
    crease = in_halves.fold.axis_image
    away = {
        name: mark.reach * np.linalg.norm(_core.reflect(mark.image[None], crease)[0] - mark.image)
        for name, mark in in_halves.landmarks.items()
        if mark.accessible
    }
    assert in_halves.unfolding.one_arm.landmark == max(away, key=away.get)
