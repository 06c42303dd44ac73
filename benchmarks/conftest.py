"""Outlines and photographs that the benchmarks share; made by the package, the same at every run."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from foldrs.synth import Scene, make_scene
from foldrs.template import builtin_templates


@pytest.fixture(scope="session")
def scene() -> Scene:
    """A folded T-shirt on a table, 640 x 480 px."""
    return make_scene(builtin_templates("t-shirt")[0], seed=3)


@pytest.fixture(scope="session")
def outline(scene: Scene) -> NDArray[np.float64]:
    """The outline seen in it, px."""
    return np.array(scene.truth["outline_image"])
