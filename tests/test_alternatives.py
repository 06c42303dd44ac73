"""Alternatives: several templates of a kind compete with each other, not against other kinds."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import foldrs
from foldrs.alternatives import distinct, with_probabilities
from foldrs.evaluation import Evaluation
from foldrs.evaluation.scenes import load_scenes
from foldrs.explanation import Explanation
from foldrs.parameters import AlternativeParameters
from foldrs.result import FittedTemplate, Fold
from foldrs.synth import make_scene
from foldrs.template import Template, builtin_templates

TEMPERATURE = 3.0


def explained(template: Template, cost: float, offset: float = 0.0) -> Explanation:
    """The template folded at half its height, where it lies moved by `offset`."""
    low, high = template.outline.min(axis=0), template.outline.max(axis=0)
    middle = (low[1] + high[1]) / 2
    axis = np.array([[low[0], middle], [high[0], middle]])
    fitted = FittedTemplate(template.outline, dict(template.landmarks), axis)
    to_image = np.array([[1.0, 0.0, offset], [0.0, 1.0, 0.0]])
    crease = axis + np.array([offset, 0.0])
    return Explanation(template, axis, fitted, to_image, (Fold(crease, axis),), cost, cost, np.inf)


def probabilities(explanations: list[Explanation], templates: list[Template]) -> list[tuple[str, float]]:
    kept = distinct(explanations, templates, TEMPERATURE, AlternativeParameters())
    return [(a.garment_type, a.probability) for a in with_probabilities(kept, TEMPERATURE)]


@pytest.fixture
def pants() -> Template:
    return builtin_templates("pants")[0]


@pytest.fixture
def skirt() -> Template:
    return builtin_templates("skirt")[0]


def test_a_kind_gains_nothing_by_a_template_given_twice(pants: Template, skirt: Template) -> None:
    twin = replace(skirt, name="twin")
    once = probabilities([explained(pants, 1.0), explained(skirt, 2.0)], [pants, skirt])
    twice = probabilities(
        [explained(pants, 1.0), explained(skirt, 2.0), explained(twin, 2.0)], [pants, skirt, twin]
    )
    assert [kind for kind, _ in twice] == [kind for kind, _ in once]
    np.testing.assert_allclose([p for _, p in twice], [p for _, p in once])


def test_a_kind_with_one_good_template_of_two_has_half_its_prior(pants: Template, skirt: Template) -> None:
    other = replace(skirt, name="other")
    (first, p), (second, q) = probabilities(
        [explained(skirt, 1.0), explained(pants, 1.0)], [pants, skirt, other]
    )
    assert (first, second) == ("pants", "skirt")
    assert p == pytest.approx(2 * q)


def test_what_templates_of_a_kind_explain_alike_adds_up(skirt: Template) -> None:
    twin = replace(skirt, name="twin")
    told = [explained(skirt, 1.0, offset=60.0), explained(skirt, 1.5), explained(twin, 1.5)]
    kept = distinct(told, [skirt, twin], TEMPERATURE, AlternativeParameters())
    assert [round(one.cost, 1) for one in kept] == [1.5, 1.0]


def test_one_template_a_kind_keeps_the_order_of_cost(pants: Template, skirt: Template) -> None:
    told = [explained(pants, 1.0), explained(skirt, 1.1), explained(pants, 1.2, offset=60.0)]
    kept = distinct(told, [pants, skirt], TEMPERATURE, AlternativeParameters())
    assert [(one.cost, one.weight) for one in kept] == [(1.0, 1.0), (1.1, 1.0), (1.2, 1.0)]


@pytest.mark.parametrize("method", ["best", "paper"])
def test_two_templates_of_a_kind_fit_and_evaluate(method: str, tmp_path, skirt: Template) -> None:
    twin = replace(skirt, name="twin")
    make_scene(skirt, seed=2).write(tmp_path, "skirt")
    (scene,) = load_scenes(tmp_path)
    one = foldrs.fit(scene.outline_image, templates=[skirt], px_per_cm=4.0, method=method)
    two = foldrs.fit(scene.outline_image, templates=[skirt, twin], px_per_cm=4.0, method=method)
    np.testing.assert_allclose(two.fold.axis_image, one.fold.axis_image)
    assert two.alternatives[0].probability == pytest.approx(one.alternatives[0].probability, abs=0.02)
    row = Evaluation("generic", [skirt, twin], 4.0, method, true_outlines=True).run(scene)
    assert not row.error
    assert row.type_right
