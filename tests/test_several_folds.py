"""Several folds, and none: from outlines folded virtually to explanations, models and unfolding plans."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import pytest

import foldrs
from foldrs import _core
from foldrs.errors import ParameterError
from foldrs.explanation import Explanation
from foldrs.model import FoldedModel
from foldrs.parameters import GraspParameters
from foldrs.result import FitResult, FittedTemplate, Fold

PX = 4.0
SHIRT = foldrs.builtin_templates("t-shirt")[0]
AXES = [np.array([[-60.0, 45.0], [60.0, 55.0]]), np.array([[3.0, -90.0], [-3.0, 90.0]])]
"""The hem turned up, then one half over the other, cm; both lines run all across."""


def folded_twice() -> tuple[Any, Any]:
    """The T-shirt folded twice, px: the outline seen and the garment unfolded."""
    laid = SHIRT.outline * PX
    stack = _core.fold_stack(laid, [axis * PX for axis in AXES])
    return stack.outline, laid


def model_of(axes: list[Any]) -> FoldedModel:
    folds = tuple(Fold(axis * PX, axis) for axis in axes)
    told = Explanation(
        template=SHIRT,
        original_axis=axes[0] if axes else None,
        fitted=FittedTemplate(SHIRT.outline, SHIRT.landmarks, axes[0] if axes else None),
        to_image=np.array([[PX, 0.0, 0.0], [0.0, PX, 0.0]]),
        folds=folds,
        cost=0.0,
        original_cost=0.0,
        unfolded_cost=1.0,
    )
    return FoldedModel(told, PX, GraspParameters(), told.layers.outline)


@pytest.fixture(scope="module")
def twice() -> FitResult:
    seen, _ = folded_twice()
    return foldrs.fit(seen, garment_type="t-shirt", px_per_cm=PX, folds=2)


@pytest.fixture(scope="module")
def flat() -> FitResult:
    return foldrs.fit(SHIRT.outline * PX, garment_type="t-shirt", px_per_cm=PX, folds="auto")


def test_two_folds_are_undone_jointly(twice: FitResult) -> None:
    seen, unfolded = folded_twice()
    assert twice.accepted
    assert len(twice.folds) == 2
    assert [len(one.folds) for one in twice.alternatives] == [2] * len(twice.alternatives)
    model = _core.fold_stack(twice.unfolded_outline_image, [fold.axis_image for fold in twice.folds])
    assert _core.outline_iou(model.outline, seen) > 0.95
    area = abs(_core.signed_area(unfolded))
    assert abs(_core.signed_area(twice.unfolded_outline_image)) == pytest.approx(area, rel=0.1)


def test_the_number_of_folds_is_found() -> None:
    seen, _ = folded_twice()
    assert len(foldrs.fit(seen, garment_type="t-shirt", px_per_cm=PX, folds="auto").folds) == 2


@pytest.mark.parametrize(("turned", "folds"), [(0.04, 0), (0.2, 1)])
def test_a_corner_turned_in_leaves_a_towel_flat_if_it_is_small(turned: float, folds: int) -> None:
    towel = foldrs.builtin_templates("towel")[0].outline * PX
    corner = towel.min(axis=0)
    leg = np.sqrt(2.0 * turned * abs(_core.signed_area(towel)))
    cut = np.array([[leg, 0.0], [0.0, leg]]) + corner
    along = cut[1] - cut[0]
    seen = _core.fold_stack(towel, [np.array([cut[1] + along, cut[0] - along])]).outline
    assert abs(_core.signed_area(seen)) == pytest.approx(
        (1 - turned) * abs(_core.signed_area(towel)), rel=0.01
    )
    assert len(foldrs.fit(seen, garment_type="towel", px_per_cm=PX, folds="auto").folds) == folds
    assert foldrs.fit(seen, garment_type="towel", px_per_cm=PX, folds=1).accepted


def test_a_flat_garment_comes_out_flat(flat: FitResult) -> None:
    assert not flat.accepted
    assert flat.fold is None
    assert flat.folds == ()
    assert flat.unfolding is None
    assert flat.unfolding_plan == ()
    assert _core.outline_iou(flat.unfolded_outline_image, SHIRT.outline * PX) > 0.97
    assert all(mark.accessible for mark in flat.landmarks.values())
    assert len(flat.grasp_pairs) == len(SHIRT.grasp_pairs)


def test_the_json_form_of_a_flat_garment_names_no_fold(flat: FitResult) -> None:
    told = json.loads(json.dumps(flat.to_dict()))
    assert told["fold"] is None
    assert told["folds"] == []
    assert told["template"]["axis"] is None
    assert told["original_template"]["axis"] is None
    assert told["alternatives"][0]["fold"] is None
    assert told["unfolding"] is None


def test_the_json_form_tells_every_fold_first_made_first(twice: FitResult) -> None:
    told = twice.to_dict()
    assert told["fold"]["axis_image"] == told["folds"][1]["axis_image"]
    assert told["template"]["axis"] == told["folds"][0]["axis_template"]
    assert len(told["unfolding_plan"]) == 2
    assert told["unfolding_plan"][0] == told["unfolding"]


def test_landmarks_lie_where_all_folds_carry_them() -> None:
    model = model_of(AXES)
    arc = _core.nearest_on_outline(SHIRT.outline, SHIRT.landmark_array)[2]
    stack = _core.fold_stack(SHIRT.outline, AXES)
    carried = stack.place(SHIRT.landmark_array, arc) * PX
    now = np.array([mark.image for mark in model.landmarks.values()])
    moved = np.linalg.norm(now - carried, axis=1)
    assert moved.max() <= GraspParameters().snap * PX
    by_hand = SHIRT.landmark_array.copy()
    for axis in AXES:
        along = (axis[1] - axis[0]) / np.linalg.norm(axis[1] - axis[0])
        left = along[0] * (by_hand - axis[0])[:, 1] - along[1] * (by_hand - axis[0])[:, 0] > 0
        by_hand[left] = _core.reflect(by_hand[left], axis)
    np.testing.assert_allclose(carried, by_hand * PX, atol=1e-6)


def test_the_plan_undoes_the_last_fold_first() -> None:
    plan = model_of(AXES).unfolding_plan
    assert len(plan) == 2
    for action, axis in zip(plan, AXES[::-1], strict=True):
        assert action.one_arm is not None
        turned = _core.reflect(action.one_arm.pick[None], axis * PX)[0]
        np.testing.assert_allclose(action.one_arm.place, turned, atol=1e-6)
    once = model_of(AXES[:1]).unfolding
    assert once is not None
    assert once.one_arm is not None
    assert plan[1].one_arm is not None
    assert plan[1].one_arm.landmark == once.one_arm.landmark


def test_one_fold_is_a_stack_of_one() -> None:
    stack, layers = _core.fold_stack(SHIRT.outline, AXES[:1]), _core.fold_layers(SHIRT.outline, AXES[0])
    assert _core.outline_iou(stack.outline, layers.outline) > 1 - 1e-6
    doubled = [sum(abs(_core.signed_area(r)) for r in one.double_layer) for one in (stack, layers)]
    assert doubled[0] == pytest.approx(doubled[1], rel=1e-6)
    assert stack.turned == [[False], [True]]


def test_layers_keep_their_order_and_their_cloth() -> None:
    stack = _core.fold_stack(SHIRT.outline, AXES)
    areas = [abs(_core.signed_area(layer)) for layer in stack.layers]
    assert sum(areas) == pytest.approx(abs(_core.signed_area(SHIRT.outline)))
    # Each flap is laid on top; what was on top of it comes to lie at its bottom.
    assert stack.turned == [[False, False], [True, False], [True, True], [False, True]]
    below = _core.fold_stack(SHIRT.outline, AXES, [True, False])
    assert below.turned == [[True, True], [False, True], [False, False], [True, False]]


def test_a_fold_that_creases_nothing_is_named() -> None:
    with pytest.raises(ValueError, match="does not cross"):
        _core.fold_stack(SHIRT.outline, [AXES[0], AXES[1] + 500.0])
    with pytest.raises(ParameterError, match="whole number"):
        foldrs.fit(SHIRT.outline, folds=7)
