"""Stage 6: the polygon model, accessible landmarks, grasp pairs and the unfolding action (section 3)."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import foldrs
from foldrs import _core
from foldrs.explanation import Explanation
from foldrs.model import FoldedModel, turns_at
from foldrs.parameters import GraspParameters
from foldrs.result import FittedTemplate, Fold

PX = 4.0


def model_of(axis, kind="towel"):
    """The built-in template, folded over an axis (cm) and laid 4 px/cm at (50, 50)."""
    template = foldrs.builtin_templates(kind)[0]
    to_image = np.array([[PX, 0.0, 50.0], [0.0, PX, 50.0]])
    crease = axis @ to_image[:, :2].T + to_image[:, 2]
    laid = template.outline @ to_image[:, :2].T + to_image[:, 2]
    told = Explanation(
        template=template,
        original_axis=axis,
        fitted=FittedTemplate(template.outline, template.landmarks, axis),
        to_image=to_image,
        folds=(Fold(crease, axis),),
        cost=0.0,
        original_cost=0.0,
        unfolded_cost=1.0,
    )
    return FoldedModel(told, PX, GraspParameters(), _core.fold_layers(laid, crease).outline)


def corner_fold():
    """A towel with one corner turned over: the axis cuts off a third of two sides."""
    outline = foldrs.builtin_templates("towel")[0].outline
    low, high = outline.min(axis=0), outline.max(axis=0)
    size = high - low
    return np.array([[low[0] + size[0] / 3 + 1, low[1] - 1], [low[0] - 1, low[1] + size[1] / 3 + 1]])


def test_landmarks_on_the_flap_are_reflected_and_the_others_stay():
    model = model_of(corner_fold())
    stay = PX * model.explanation.template.landmark_array + 50.0
    now = np.array([mark.image for mark in model.landmarks.values()])
    moved = np.linalg.norm(now - stay, axis=1) > 1e-6
    assert moved.sum() == 1
    turned = _core.reflect(stay[moved], model.explanation.folds[-1].axis_image)
    np.testing.assert_allclose(now[moved], turned, atol=1e-6)


def test_a_landmark_under_or_on_a_double_layer_is_not_accessible():
    model = model_of(corner_fold())
    accessible = [mark.accessible for mark in model.landmarks.values()]
    assert accessible.count(False) == 1


def test_pairs_keep_their_order_and_leave_out_what_cannot_be_reached():
    model = model_of(corner_fold())
    template = model.explanation.template
    hidden = next(name for name, mark in model.landmarks.items() if not mark.accessible)
    expected = [pair for pair in template.grasp_pairs if hidden not in pair]
    assert [pair.landmarks for pair in model.grasp_pairs] == expected
    for pair in model.grasp_pairs:
        np.testing.assert_array_equal(pair.image, [model.landmarks[name].image for name in pair.landmarks])


def test_pairs_with_ample_room_come_first_and_none_is_lost():
    near, far = (
        replace(model_of(corner_fold()), parameters=GraspParameters(ample=ample)) for ample in (0, 1e3)
    )
    assert [pair.landmarks for pair in near.grasp_pairs] == [pair.landmarks for pair in far.grasp_pairs]
    clearances = {
        name: float(near.layers.distance_to_double_layer(mark.image[None])[0]) / PX
        for name, mark in near.landmarks.items()
    }
    rooms = [min(clearances[name] for name in pair.landmarks) for pair in near.grasp_pairs]
    assert min(rooms) < max(rooms)  # else there is nothing to prefer
    between = (min(rooms) + max(rooms)) / 2
    model = replace(near, parameters=GraspParameters(ample=between))
    ample = [all(clearances[name] > between for name in pair.landmarks) for pair in model.grasp_pairs]
    assert sorted(ample, reverse=True) == ample
    assert {pair.landmarks for pair in model.grasp_pairs} == {pair.landmarks for pair in near.grasp_pairs}


@pytest.mark.parametrize("way", [1, -1])
def test_an_outline_turns_outwards_at_a_corner_and_inwards_at_a_notch(way):
    notched = np.array([[0, 0], [10, 0], [20, 0], [20, 20], [10, 12], [0, 20]], float)[::way].copy()
    turns = turns_at(notched, np.array([[20.0, 0.5], [10.0, 12.5], [10.0, 0.0]]), 5.0)
    np.testing.assert_allclose(np.degrees(turns), [90.0, -77.3, 0.0], atol=10.0)


def test_the_double_layer_is_the_turned_corner():
    model = model_of(corner_fold())
    area = sum(abs(_core.signed_area(ring)) for ring in model.layers.double_layer)
    flap = sum(abs(_core.signed_area(piece)) for piece in model.layers.layers[1:])
    assert area == pytest.approx(flap, rel=1e-6)


def test_what_is_picked_is_put_down_mirrored_over_the_crease():
    model = model_of(corner_fold())
    action = model.unfolding
    assert action.two_arms is not None
    assert action.one_arm is not None
    for move in (*action.two_arms, action.one_arm):
        np.testing.assert_allclose(
            _core.reflect(move.place[None], model.explanation.folds[-1].axis_image)[0], move.pick, atol=1e-9
        )
        assert move.clearance > GraspParameters().clearance
    assert tuple(move.landmark for move in action.two_arms) == model.grasp_pairs[0].landmarks


def test_one_arm_takes_the_accessible_landmark_farthest_from_the_crease():
    model = model_of(corner_fold())
    assert model.unfolding.one_arm is not None
    crease = model.explanation.folds[-1].axis_image
    direction = (crease[1] - crease[0]) / np.linalg.norm(crease[1] - crease[0])

    def away(point):
        v = point - crease[0]
        return abs(direction[0] * v[1] - direction[1] * v[0])

    far = max(away(mark.image) for mark in model.landmarks.values() if mark.accessible)
    assert away(model.unfolding.one_arm.pick) == pytest.approx(far)


def test_two_layers_exactly_on_each_other_leave_nothing_accessible():
    outline = foldrs.builtin_templates("towel")[0].outline
    middle = (outline.min(axis=0) + outline.max(axis=0)) / 2
    half = np.array([[outline[:, 0].min() - 1, middle[1]], [outline[:, 0].max() + 1, middle[1]]])
    model = model_of(half)
    assert not any(mark.accessible for mark in model.landmarks.values())
    assert model.grasp_pairs == ()
    assert model.unfolding.two_arms is None
    assert model.unfolding.one_arm is None
