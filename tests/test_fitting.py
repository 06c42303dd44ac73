"""Stage 5, the fitting stage: registration, straight sides, the update of a template, and the iteration."""

from __future__ import annotations

from dataclasses import asdict, replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from foldrs import _core
from foldrs.fitting import fit_iteratively
from foldrs.landmark import carried
from foldrs.parameters import Parameters
from foldrs.registration import local_similarities
from foldrs.straight_sides import SampledSides, new_corners, straight_lines
from foldrs.template import builtin_templates
from foldrs.template_update import in_template_units

PARAMETERS = Parameters()
FITTING = replace(PARAMETERS.fitting, starts=1)
PX_PER_CM = 4.0
SQUARE = np.array([[0.0, 0.0], [40.0, 0.0], [40.0, 40.0], [0.0, 40.0]])


def turned(points, angle, scale=1.0, shift=(0.0, 0.0)):
    c, s = np.cos(angle), np.sin(angle)
    return scale * points @ np.array([[c, s], [-s, c]]) + shift


def photographed(outline, axis, mirrored=False):
    """The outline of a garment folded over an axis, as a picture shows it: px, turned, either face up."""
    folded = _core.fold_layers(outline, axis).outline
    return turned(folded * ([-1, 1] if mirrored else [1, 1]), 0.7, PX_PER_CM, (300, 250))


def fitted(template, outline, axis, mirrored=False, scale=PX_PER_CM, parameters=FITTING):
    seen = _core.Seen(photographed(outline, axis, mirrored), asdict(PARAMETERS.matching))
    return fit_iteratively(seen, [template], scale, parameters, PARAMETERS.alternatives)


def axis_across(outline, level):
    """A fold parallel to the hem: what lies above a share of the height is turned down."""
    low, high = outline.min(axis=0), outline.max(axis=0)
    y = low[1] + level * (high[1] - low[1])
    return np.array([[high[0] + 1, y], [low[0] - 1, y]])


def overlap_of_shapes(a, b):
    """Intersection over union with centroids laid on each other; both are upright."""
    return _core.outline_iou(a - _core.resample(a, 400).mean(axis=0), b - _core.resample(b, 400).mean(axis=0))


@given(st.floats(-3.0, 3.0), st.floats(0.2, 5.0), st.floats(-100.0, 100.0), st.integers(0, 1000))
def test_local_similarities_recover_a_similarity_and_leave_out_what_has_no_weight(angle, scale, shift, seed):
    rng = np.random.default_rng(seed)
    source = rng.uniform(-10, 10, (12, 2))
    target = turned(source, angle, scale, (shift, -shift))
    target[-1] += 50.0
    weights = np.concatenate([rng.uniform(0.1, 1.0, (3, 11)), np.zeros((3, 1))], axis=1)
    moved = local_similarities(weights, source, target).apply(source[:3])
    np.testing.assert_allclose(moved, target[:3], atol=1e-6)


def test_a_similarity_never_reflects():
    source = np.array([[0.0, 0.0], [2.0, 0.0], [2.0, 1.0]])
    maps = local_similarities(np.ones((1, 3)), source, source * [-1, 1])
    moved = maps.apply(source, np.zeros(3, dtype=np.intp))
    assert _core.signed_area(moved) * _core.signed_area(source) >= 0


def test_points_without_spread_are_translated():
    one = np.array([[3.0, 4.0]])
    np.testing.assert_allclose(local_similarities(np.ones((1, 1)), one, one + 5).apply(one), one + 5)


def test_lines_leave_out_outliers_and_sides_that_are_not_visible():
    sides = SampledSides.of(SQUARE, 2.0)
    points = _core.points_at(SQUARE, sides.at)
    points[3] += [0.0, 9.0]
    supported = sides.side != 2
    lines = straight_lines(points, sides.side, supported, 40.0, FITTING)
    assert sorted(lines) == [0, 1, 3]
    middle, direction = lines[0]
    assert abs(middle[1]) < 1e-9
    assert abs(direction[1]) < 1e-9
    again = straight_lines(points, sides.side, supported, 40.0, FITTING)
    assert all(np.array_equal(lines[i], again[i]) for i in lines)


def test_corners_are_where_neighbouring_lines_meet_and_else_stay_registered():
    lines = {
        0: np.array([[20.0, 1.0], [1.0, 0.0]]),
        1: np.array([[41.0, 20.0], [0.0, 1.0]]),
        2: np.array([[20.0, 41.0], [0.02, 1.0]]),
    }
    corners = new_corners(SQUARE, lines, 40.0, FITTING)
    np.testing.assert_allclose(corners[1], [41.0, 1.0])  # sides 0 and 1 meet
    np.testing.assert_array_equal(corners[2], SQUARE[2])  # sides 1 and 2 are nearly parallel
    np.testing.assert_array_equal(corners[[0, 3]], SQUARE[[0, 3]])  # side 3 has no line


def test_a_corner_does_not_move_far():
    lines = {0: np.array([[20.0, 30.0], [1.0, 0.0]]), 1: np.array([[41.0, 20.0], [0.0, 1.0]])}
    np.testing.assert_array_equal(new_corners(SQUARE, lines, 40.0, FITTING), SQUARE)


def test_landmarks_stay_at_their_share_of_their_edge():
    moved = SQUARE * [2.0, 0.5]
    marks = carried({"corner": SQUARE[3], "quarter": np.array([10.0, 0.0])}, SQUARE, moved)
    np.testing.assert_allclose(marks["corner"], moved[3], atol=1e-9)
    np.testing.assert_allclose(marks["quarter"], [20.0, 0.0], atol=1e-9)


@given(st.floats(-3.0, 3.0), st.floats(0.5, 2.0))
def test_a_fitted_template_is_upright_and_true_to_a_known_scale(angle, size):
    seen = turned(SQUARE * size, angle, PX_PER_CM, (500, 100))
    middle = SQUARE.mean(axis=0)
    expected = middle + (SQUARE - middle) * size
    np.testing.assert_allclose(in_template_units(seen, SQUARE, PX_PER_CM), expected, atol=1e-6)
    np.testing.assert_allclose(in_template_units(seen, SQUARE, None), SQUARE, atol=1e-6)


@pytest.mark.parametrize("mirrored", [False, True])
@pytest.mark.parametrize("kind", ["t-shirt", "pants"])
def test_a_template_that_fits_already_keeps_its_shape(kind, mirrored):
    (template, *_) = builtin_templates(kind)
    axis = axis_across(template.outline, 0.3)
    (fit,) = fitted(template, template.outline, axis, mirrored)
    explanation = fit.explanation
    assert _core.axis_difference(explanation.fitted.axis, axis) < 0.1 * template.area
    assert overlap_of_shapes(explanation.fitted.outline, template.outline) > 0.93


@pytest.mark.parametrize("width", [0.87, 1.15])
def test_the_template_takes_the_proportions_of_the_garment(width):
    (template, *_) = builtin_templates("towel")
    garment = template.outline * [width, 1.0]
    (fit,) = fitted(template, garment, np.array([[60.0, 30.0], [-60.0, 12.0]]))
    before = overlap_of_shapes(template.outline, garment)
    assert overlap_of_shapes(fit.explanation.fitted.outline, garment) > before + (1 - before) / 3


def test_the_cheapest_stage_wins_and_the_matching_stage_s_axis_is_kept():
    (template, *_) = builtin_templates("skirt")
    axis = axis_across(template.outline * [1.1, 0.95], 0.4)
    (fit,) = fitted(template, template.outline * [1.1, 0.95], axis)
    costs = [stage.explanation.cost for stage in fit.stages]
    assert 2 <= len(costs) <= FITTING.iterations + 1
    assert fit.explanation.cost == min(costs) < costs[0]
    first = fit.stages[0].explanation
    np.testing.assert_array_equal(first.fitted.outline, template.outline)
    np.testing.assert_array_equal(first.fitted.axis, fit.explanation.original_axis)
    assert fit.explanation.original_cost == costs[0]
    for stage, following in zip(fit.stages, fit.stages[1:], strict=False):
        assert stage.update is not None
        np.testing.assert_array_equal(stage.update.outline, following.explanation.fitted.outline)
        assert following.explanation.fitted.outline.shape == template.outline.shape
        _core.check_outline(following.explanation.fitted.outline)
        landmarks = following.explanation.fitted.landmarks
        assert list(landmarks) == list(template.landmarks)


def test_starts_are_distinct_bounded_and_at_least_one_a_template():
    templates = builtin_templates()
    outline = templates[0].outline
    seen = _core.Seen(photographed(outline, axis_across(outline, 0.35)), asdict(PARAMETERS.matching))
    parameters = replace(PARAMETERS.fitting, starts=3, starts_in_all=len(templates) + 1, iterations=0)
    fits = fit_iteratively(seen, templates, PX_PER_CM, parameters, PARAMETERS.alternatives)
    named = [fit.explanation.template.name for fit in fits]
    assert len(fits) <= len(templates) + 1
    assert set(named) == {t.name for t in templates}
    costs = [fit.explanation.cost for fit in fits]
    assert costs == sorted(costs)


def test_the_same_input_gives_the_same_output():
    (template, *_) = builtin_templates("shorts")
    axis = axis_across(template.outline, 0.45)
    one, other = (fitted(template, template.outline * [0.95, 1.05], axis)[0].explanation for _ in range(2))
    np.testing.assert_array_equal(one.fitted.outline, other.fitted.outline)
    np.testing.assert_array_equal(one.fitted.axis, other.fitted.axis)


def test_an_unknown_scale_leaves_the_size_of_the_template():
    (template, *_) = builtin_templates("t-shirt")
    axis = axis_across(template.outline, 0.3)
    (fit,) = fitted(template, template.outline, axis, scale=None)
    area = abs(_core.signed_area(fit.explanation.fitted.outline))
    assert 0.8 < area / template.area < 1.25
