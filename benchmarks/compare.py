"""Time the heavy steps beside plain NumPy, SciPy and Shapely, in one run, and show how cost grows.

The yardstick is a file that is not part of the project; where it is missing its columns stay empty. Single
steps are timed by the processor time of one thread, so that other work on the machine hardly matters; whole
calls by the clock, on all cores.

    python benchmarks/compare.py [BASELINE.py]
"""

from __future__ import annotations

import importlib.util
import math
import sys
import time
from collections.abc import Callable, Sequence
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
Run = Callable[[], Any]

BASELINE = Path(__file__).resolve().parents[1] / "../shared/bench/baseline.py"
N = 100  # points of an outline
SIZES = (50, 100, 200, 400)
HYPOTHESES = (25, 50, 100, 200)
STARTS = 8  # of an alignment
LEAST_SECONDS = 0.2  # every step is repeated for so long, three times at least; the median counts


@dataclass(frozen=True)
class Step:
    """One thing done by both, or by us alone."""

    name: str
    ours: Run
    theirs: Run | None = None


def median_ms(run: Run, clock: Callable[[], float] = time.thread_time) -> float:
    """Median time of a call, ms."""
    run()
    times: list[float] = []
    while len(times) < 3 or sum(times) < LEAST_SECONDS:
        start = clock()
        run()
        times.append(clock() - start)
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


def kernels(n: int, b: Any) -> list[Step]:
    """The steps of one comparison of two outlines of n points; `b` is the yardstick, if it is there."""
    p, q = (_core.resample(seen(kind), n) for kind in ("pants", "shirt"))
    line = p.mean(axis=0) + np.array([[-1000.0, -300.0], [1000.0, 300.0]])  # longer than the outline
    parameters = asdict(Parameters().matching)
    parameters["shape_context"]["n_points"] = n
    matched = _core.Seen(q, parameters)
    candidate = matched.matches([p], cheapest_only=True)[0][0]
    costs = _core.matching_costs(p, q)
    starts = list(range(0, n, max(1, n // STARTS)))
    given = b.shape_context(q) if b else q
    steps: list[tuple[str, Run, Run]] = [
        ("fold", lambda: _core.fold_layers(p, line), lambda: b.fold(p, *line)),
        ("inner distances", lambda: _core.inner_distances(p), lambda: b.inner_distances(p)),
        ("shape context", lambda: _core.shape_contexts(p), lambda: b.shape_context(p)),
        (
            "two shape contexts, chi-squared",
            lambda: _core.matching_costs(p, q),
            lambda: b.chi2(b.shape_context(p), b.shape_context(q)),
        ),
        (
            f"alignment, {STARTS} starts",
            lambda: _core.alignment_costs(costs, starts),
            lambda: b.align(costs, starts=STARTS),
        ),
        (
            "partial matches, one face",
            lambda: _core.partial_matches(p, q, parameters),
            lambda: b.partial_matches(p, q),
        ),
        (
            "one hypothesis, both faces",
            lambda: matched.explain(p, candidate),
            lambda: plain_hypothesis(b, p, given, line),
        ),
    ]
    return [Step(name, ours, theirs if b else None) for name, ours, theirs in steps]


def plain_hypothesis(b: Any, p: Points, seen: Points, line: Points) -> float:
    """Fold, resample, describe, align with both faces of the seen shape contexts, by the yardstick."""
    contexts = b.shape_context(b.resample(b.fold(p, *line), len(seen)))
    return min(float(b.align(b.chi2(contexts, face), starts=STARTS)) for face in (seen, seen[::-1]))


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
        Step("fit, all kinds, as published", lambda: foldrs.fit(outline, method="paper")),
    ]


def comparison(b: Any) -> Table:
    """Every step at n = N beside the yardstick, then whole calls."""
    table = Table(title=f"Milliseconds a call, outlines of {N} points", title_justify="left")
    table.add_column("step")
    for heading in ("foldrs", "plain Python", "ratio"):
        table.add_column(heading, justify="right")

    def add(name: str, ours: float, theirs: float | None) -> None:
        compared = ("", "") if theirs is None else (f"{theirs:.2f}", f"{theirs / ours:.0f} x")
        table.add_row(name, f"{ours:.3f}", *compared)

    measured = {
        step.name: (median_ms(step.ours), median_ms(step.theirs) if step.theirs else None)
        for step in kernels(N, b)
    }
    for name, (ours, theirs) in measured.items():
        add(name, ours, theirs)
    # Not a call of its own here: what is left of the two contexts and their distances without the contexts.
    one, both = measured["shape context"], measured["two shape contexts, chi-squared"]
    left = None if both[1] is None or one[1] is None else max(both[1] - 2 * one[1], 0.0)
    add("chi-squared alone, by difference", max(both[0] - 2 * one[0], 1e-3), left)
    table.add_section()
    for call in calls():
        add(call.name, median_ms(call.ours, time.perf_counter), None)
    return table


def growth(title: str, sizes: Sequence[int], rows: dict[str, list[float]]) -> Table:
    """Milliseconds by size, and the exponent of the growth over the last doubling."""
    table = Table(title=title, title_justify="left")
    table.add_column("step")
    for size in sizes:
        table.add_column(str(size), justify="right")
    table.add_column("exponent", justify="right")
    for name, times in rows.items():
        exponent = math.log(times[-1] / times[-2], sizes[-1] / sizes[-2])
        table.add_row(name, *(f"{ms:.3f}" for ms in times), f"{exponent:.1f}")
    return table


def growth_with_points() -> Table:
    """How every step grows with the points of an outline."""
    rows: dict[str, list[float]] = {}
    for n in SIZES:
        for step in kernels(n, None):
            rows.setdefault(step.name, []).append(median_ms(step.ours))
    return growth("Milliseconds by points of an outline", SIZES, rows)


def growth_with_hypotheses() -> Table:
    """How matching grows with the hypotheses tested, by processor time over all threads."""
    parameters = asdict(Parameters().matching)
    template, outline = builtin_templates("t-shirt")[0].outline, seen("t-shirt")

    def test(most: int) -> Run:
        parameters["hypothesis"]["most"] = most
        matched = _core.Seen(outline, parameters)
        return lambda: matched.matches([template])

    claims = median_ms(test(1), time.process_time)
    times = [median_ms(test(most), time.process_time) - claims for most in HYPOTHESES]
    return growth("Milliseconds by hypotheses, their claims left out", HYPOTHESES, {"scoring": times})


def main() -> None:
    """Print the tables."""
    baseline = load(Path(sys.argv[1]) if len(sys.argv) > 1 else BASELINE)
    console = Console(width=100)
    for table in (comparison(baseline), growth_with_points(), growth_with_hypotheses()):
        console.print(table)
        console.print()


if __name__ == "__main__":
    main()
