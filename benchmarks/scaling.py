"""How much more threads help: scoring, the joint fit, and many images, each in a process of its own.

    python benchmarks/scaling.py [--threads N] [--repeat K]

Prints seconds by the clock on 1 and on N threads (default: all cores), their ratio, and the processor
seconds, which must not grow. On a machine that does other work meanwhile only the latter mean anything.
Then, of a single image, the processor time of the calling thread, which runs alone, and of each one of the
pool: their sum is what N idle cores would take by the clock.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console
from rich.table import Table

import foldrs
from foldrs import _core
from foldrs.joint_fit import flexible_template
from foldrs.parameters import Parameters
from foldrs.synth import make_scene
from foldrs.template import builtin_templates

IMAGES = 8
CALLS: dict[str, dict[str, Any]] = {
    "kind given": {},
    "all kinds": {},
    "kind given, as published": {"method": "paper"},
    "all kinds, as published": {"method": "paper"},
}


def work(name: str, folder: Path) -> Callable[[], Any]:
    """What is measured under a name."""
    kinds = [template.garment_type for template in builtin_templates()]
    if name == "many images":
        from click.testing import CliRunner

        from foldrs.cli import main

        images = sorted(str(image) for image in folder.glob("*.jpg"))
        arguments = ["fit", *images, "--jobs", str(_core.set_threads())]
        return lambda: CliRunner().invoke(main, arguments, catch_exceptions=False)
    parameters = asdict(Parameters().matching)
    outline = np.array(make_scene(builtin_templates(kinds[0])[0], seed=3).truth["outline_image"])
    seen, outlines = _core.Seen(outline, parameters), [t.outline for t in builtin_templates()]
    if name == "scoring":
        return lambda: seen.matches(outlines)
    flexible = [flexible_template(t, parameters) for t in builtin_templates()]
    return lambda: _core.fit_jointly(seen, outlines, flexible, 1)


def measure(name: str, threads: int, repeat: int, folder: Path) -> None:
    """Print the least seconds by the clock, and the processor seconds of that run, as JSON."""
    _core.set_threads(threads)
    run = work(name, folder)
    run()
    best = (float("inf"), 0.0)
    for _ in range(repeat):
        clock, processor = time.perf_counter(), time.process_time()
        run()
        best = min(best, (time.perf_counter() - clock, time.process_time() - processor))
    print(json.dumps(best))


def one_image(threads: int, folder: Path) -> Table:
    """Processor time of fits of one image, by who spends it: medians over the images in a folder."""
    _core.set_threads(threads)
    table = Table(title=f"One image, processor ms, a pool of {threads}", title_justify="left")
    for heading in ("fit", "alone", "pool, each", "alone + pool"):
        table.add_column(heading, justify="left" if heading == "fit" else "right")
    photographs = [(image, image.with_suffix(".json")) for image in sorted(folder.glob("*.jpg"))]
    for name, options in CALLS.items():
        spent = []
        for image, truth in photographs:
            known = json.loads(truth.read_text())
            kind = {"garment_type": known["type"]} if name.startswith("kind") else {}
            alone, both = time.thread_time(), time.process_time()
            foldrs.fit(image, px_per_cm=known["px_per_cm"], **kind, **options)
            alone, both = time.thread_time() - alone, time.process_time() - both
            spent.append((alone, (both - alone) / threads, alone + (both - alone) / threads))
        table.add_row(name, *(f"{1000 * ms:.0f}" for ms in np.median(spent, axis=0)))
    return table


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--threads", type=int, default=os.cpu_count() or 1)
    parser.add_argument("--repeat", type=int, default=5)
    parser.add_argument("--measure", nargs=2, metavar=("NAME", "FOLDER"), help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.measure:
        name, folder = options.measure
        measure(name, options.threads, options.repeat, Path(folder))
        return
    table = Table(title=f"1 and {options.threads} threads", title_justify="left")
    table.add_column("work")
    for heading in ("1 thread, s", f"{options.threads} threads, s", "ratio", "processor, s", "processor, s"):
        table.add_column(heading, justify="right")
    with tempfile.TemporaryDirectory() as folder:
        for k in range(IMAGES):
            template = builtin_templates()[k % len(builtin_templates())]
            make_scene(template, seed=k).write(Path(folder), f"scene-{k}")
        for name in ("scoring", "joint fit", "many images"):
            (one, busy), (many, busy_many) = (
                json.loads(
                    subprocess.run(
                        [
                            *[sys.executable, __file__, "--measure", name, folder],
                            *["--threads", str(threads), "--repeat", str(options.repeat)],
                        ],
                        check=True,
                        capture_output=True,
                        text=True,
                    ).stdout
                )
                for threads in (1, options.threads)
            )
            row = (f"{one:.3f}", f"{many:.3f}", f"{one / many:.2f} x", f"{busy:.3f}", f"{busy_many:.3f}")
            table.add_row(name, *row)
        alone = one_image(options.threads, Path(folder))
    for one in (table, alone):
        Console(width=100).print(one)


if __name__ == "__main__":
    main()
