"""Outlines shared by the tests: random ones, and real ones where the data is at hand."""

from __future__ import annotations

import importlib.util
import json
from functools import cache
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
from hypothesis import HealthCheck, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

SHARED = Path(__file__).resolve().parents[1] / "../shared"

settings.register_profile(
    "foldrs",
    deadline=None,
    derandomize=True,
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.filter_too_much],
)
settings.load_profile("foldrs")


def star(radii: list[float], turn: float = 0.0) -> NDArray[np.float64]:
    """A simple polygon around the origin with the given distances at equal angles."""
    angle = turn + np.arange(len(radii)) * 2 * np.pi / len(radii)
    return np.array(radii)[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1)


simple_polygons = st.builds(
    star,
    st.lists(st.floats(1.0, 10.0), min_size=5, max_size=40),
    st.floats(0.0, 6.0),
)


@cache
def _real_outlines() -> tuple[NDArray[np.float64], ...]:
    outlines = []
    for name in ("artf-dev.json", "flat-clothes.json"):
        entries = json.loads((SHARED / "data/outlines" / name).read_text())
        outlines += [np.array(e["outline"], float) for e in entries]
    return tuple(outlines)


@pytest.fixture(scope="session")
def real_outlines() -> tuple[NDArray[np.float64], ...]:
    """Real garment outlines; tests that ask for them are skipped where they are missing."""
    if not (SHARED / "data/outlines").is_dir():
        pytest.skip("the real outlines (../shared/data/outlines) are not here")
    return _real_outlines()


@pytest.fixture(scope="session")
def scenes() -> Path:
    """The folder of real scenes; tests that ask for it are skipped where it is missing."""
    folder = SHARED / "data/scenes/once"
    if not folder.is_dir():
        pytest.skip("the real scenes (../shared/data/scenes/once) are not here")
    return folder


@pytest.fixture(scope="session")
def baseline() -> ModuleType:
    """The heavy steps in NumPy, SciPy and Shapely; tests that ask for it are skipped where it is missing."""
    path = SHARED / "bench/baseline.py"
    if not path.is_file():
        pytest.skip("the plain versions of the steps (../shared/bench/baseline.py) are not here")
    spec = importlib.util.spec_from_file_location("baseline", path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module
