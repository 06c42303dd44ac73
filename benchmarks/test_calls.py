"""How long the calls take that a user makes, and the steps they spend their time in.

Run with ``make bench``. Every number is of one call on all cores.
"""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import foldrs
from foldrs import _core
from foldrs.outline import find_outline
from foldrs.parameters import Parameters
from foldrs.synth import Scene
from foldrs.template import builtin_templates

Points = NDArray[np.float64]
PARAMETERS = asdict(Parameters().matching)


@pytest.mark.parametrize("method", ["best", "paper"])
@pytest.mark.parametrize("kind", ["t-shirt", None], ids=["kind given", "kind open"])
def test_fit_of_an_outline(benchmark: Any, outline: Points, kind: str | None, method: Any) -> None:
    result = benchmark(lambda: foldrs.fit(outline, garment_type=kind, method=method))
    assert result.alternatives


def test_fit_of_a_photograph(benchmark: Any, scene: Scene) -> None:
    result = benchmark(lambda: foldrs.fit(scene.image, garment_type="t-shirt"))
    assert result.alternatives


def test_finding_the_outline(benchmark: Any, scene: Scene) -> None:
    found = benchmark(lambda: find_outline(scene.image))
    assert len(found.points) > 100


def test_matching_against_one_template(benchmark: Any, outline: Points) -> None:
    template = builtin_templates("t-shirt")[0].outline
    candidates, _ = benchmark(lambda: _core.Seen(outline, PARAMETERS).matches([template]))
    assert candidates


def test_fold(benchmark: Any) -> None:
    template = builtin_templates("t-shirt")[0].outline
    axis = template.mean(axis=0) + np.array([[-99.0, -33.0], [99.0, 33.0]])
    layers = benchmark(lambda: _core.fold_layers(template, axis))
    assert layers.flap


def test_making_a_scene(benchmark: Any) -> None:
    from foldrs.synth import make_scene

    made = benchmark(lambda: make_scene(builtin_templates("t-shirt")[0], seed=3))
    assert made.mask.any()
