"""Time the heavy steps beside what one would write in plain NumPy, SciPy and Shapely, in one run.

The yardstick is a file that is not part of the project; where it is missing its columns stay empty.

    python benchmarks/compare.py [BASELINE.py]
"""

from __future__ import annotations

import importlib.util
import sys
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
from numpy.typing import NDArray
from rich.console import Console
from rich.table import Table

import foldrs
from foldrs import _core
from foldrs.parameters import Parameters
from foldrs.synth import make_scene
from foldrs.template import builtin_templates

Points = NDArray[np.float64]

BASELINE = Path(__file__).resolve().parents[1] / "../shared/bench/baseline.py"
N = 100  # points of an outline
STARTS = 8  # of an alignment
LEAST_SECONDS = 0.3  # every step is repeated for so long, three times at least; the median counts


@dataclass(frozen=True)
class Step:
    """One thing done by both, or by us alone."""

    name: str
    ours: Callable[[], Any]
    theirs: Callable[[], Any] | None = None


def median_ms(run: Callable[[], Any]) -> float:
    """Median time of a call, ms."""
    run()
    times: list[float] = []
    while len(times) < 3 or sum(times) < LEAST_SECONDS:
        start = time.perf_counter()
        run()
        times.append(time.perf_counter() - start)
    return 1000 * float(np.median(times))


def load(path: Path) -> ModuleType | None:
    """Load the yardstick, if it is there."""
    if not path.is_file():
        return None
    spec = importlib.util.spec_from_file_location("baseline", path)
    if spec is None or spec.loader is None:
        return None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def seen(kind: str) -> Points:
    """The outline of a folded garment, px."""
    return np.array(make_scene(builtin_templates(kind)[0], seed=3).truth["outline_image"])


def kernels(b: Any) -> list[Step]:
    """The steps of one comparison of two outlines of N points; `b` is the yardstick, if it is there."""
    parameters = asdict(Parameters().matching)
    parameters["alignment"]["starts"] = STARTS
    p, q = (_core.resample(seen(kind), N) for kind in ("pants", "shirt"))
    line = p.mean(axis=0) + np.array([[-1000.0, -300.0], [1000.0, 300.0]])  # longer than the outline
    costs = _core.matching_costs(p, q)
    starts = list(range(0, N, N // STARTS))
    steps = [
        ("fold", lambda: _core.fold_layers(p, line), b and (lambda: b.fold(p, *line))),
        ("inner distances", lambda: _core.inner_distances(p), b and (lambda: b.inner_distances(p))),
        ("shape context", lambda: _core.shape_contexts(p), b and (lambda: b.shape_context(p))),
        (
            "two shape contexts and their distances",
            lambda: _core.matching_costs(p, q),
            b and (lambda: b.chi2(b.shape_context(p), b.shape_context(q))),
        ),
        (
            f"alignment, {len(starts)} starts",
            lambda: _core.alignment_costs(costs, starts),
            b and (lambda: b.align(costs, starts=STARTS)),
        ),
        (
            "partial matches, one face",
            lambda: _core.partial_matches(p, q, parameters),
            b and (lambda: b.partial_matches(p, q)),
        ),
    ]
    return [Step(name, ours, theirs) for name, ours, theirs in steps]


def calls() -> list[Step]:
    """Whole calls on one outline."""
    outline = seen("t-shirt")
    return [
        Step("fit, kind given", lambda: foldrs.fit(outline, garment_type="t-shirt")),
        Step("fit, all kinds", lambda: foldrs.fit(outline)),
        Step(
            "fit, kind given, as published",
            lambda: foldrs.fit(outline, garment_type="t-shirt", method="paper"),
        ),
    ]


def main() -> None:
    """Print one table: ms a call, and how many times faster."""
    baseline = load(Path(sys.argv[1]) if len(sys.argv) > 1 else BASELINE)
    table = Table(title=f"Milliseconds a call, outlines of {N} points", title_justify="left")
    table.add_column("step")
    for heading in ("foldrs", "plain Python", "ratio"):
        table.add_column(heading, justify="right")
    for step in [*kernels(baseline), *calls()]:
        ours = median_ms(step.ours)
        theirs = median_ms(step.theirs) if step.theirs else None
        compared = ("", "") if theirs is None else (f"{theirs:.2f}", f"{theirs / ours:.0f} x")
        table.add_row(step.name, f"{ours:.3f}", *compared)
    Console(width=100).print(table)


if __name__ == "__main__":
    main()
