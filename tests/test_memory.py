"""How memory grows, measured in processes of their own."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

pytestmark = pytest.mark.skipif(
    not Path("/proc/self/status").is_file(), reason="the peak of a process is read as Linux tells it"
)

# Not getrusage: there a process begins with the peak of the one that started it.
PEAK = """
from pathlib import Path
def peak():
    lines = Path("/proc/self/status").read_text().splitlines()
    return next(1024 * int(line.split()[1]) for line in lines if line.startswith("VmHWM:"))
"""


def run(code: str) -> list[int]:
    """Run code in a process of its own; the numbers of bytes it prints."""
    told = subprocess.run([sys.executable, "-c", PEAK + code], check=True, capture_output=True, text=True)
    return [int(word) for word in told.stdout.split()]


def test_partial_matching_takes_memory_of_the_square_of_the_points() -> None:
    n = 700
    before, after = run(
        f"""
import numpy as np
from foldrs import _core
angle = np.arange(5000) * 2 * np.pi / 5000
radius = 2 + 0.5 * np.sin(5 * angle) + 0.3 * np.cos(3 * angle)
points = _core.resample(radius[:, None] * np.stack([np.cos(angle), np.sin(angle)], 1), {n})
before = peak()
_core.partial_matches(points, points[::-1].copy(), _core.default_parameters())
print(before, peak())
"""
    )
    # A few numbers a pair of points; one a pair and length would be 0.8 n = 560 times four bytes.
    assert after - before < 150 * n**2


@pytest.mark.parametrize("method", ["best", "paper"])
def test_a_fit_stays_below_250_megabytes(method: str) -> None:
    (peak,) = run(
        f"""
import foldrs
from foldrs.synth import make_scene
from foldrs.template import builtin_templates
foldrs.fit(make_scene(builtin_templates("shorts")[0], seed=1).image, method={method!r})
print(peak())
"""
    )
    assert peak < 250e6
