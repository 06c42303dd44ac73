"""How many outlines of garments laid out flat are told flat.

    python benchmarks/flat_outlines.py FILE... [--every N --first K]

FILE is a JSON list of {"type", "outline"}, as `foldrs synth --outlines` takes it. The kind is given, the
scale and the number of folds are not. Prints for every file and kind how many are told flat, and which not.
"""

from __future__ import annotations

import argparse
import json
from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console
from rich.progress import track
from rich.table import Table

import foldrs
from foldrs.errors import FoldrsError


def is_told_flat(garment: dict[str, Any]) -> bool:
    """Whether no fold is found in an outline."""
    outline = np.array(garment["outline"], float)
    try:
        return not foldrs.fit(outline, garment_type=garment["type"], folds="auto").folds
    except FoldrsError:
        return False


def main() -> None:
    """Fit all outlines and print one table."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("files", type=Path, nargs="+")
    parser.add_argument("--every", type=int, default=1, help="take every N-th outline of each file")
    parser.add_argument("--first", type=int, default=0, help="from this one on")
    given = parser.parse_args()
    shown = Table("file", "kind", "told flat", "of", "not so, by their places in the file")
    flat_in_all = outlines = 0
    for path in given.files:
        every = list(enumerate(json.loads(path.read_text())))[given.first :: given.every]
        with ThreadPoolExecutor() as pool:
            told = pool.map(is_told_flat, [garment for _, garment in every])
            flat = list(track(told, path.name, total=len(every)))
        kinds = Counter(garment["type"] for _, garment in every)
        folded = [
            (place, garment["type"]) for (place, garment), one in zip(every, flat, strict=True) if not one
        ]
        for kind, number in kinds.items():
            rest = [str(place) for place, of_kind in folded if of_kind == kind]
            shown.add_row(path.name, kind, str(number - len(rest)), str(number), ", ".join(rest))
        flat_in_all, outlines = flat_in_all + sum(flat), outlines + len(flat)
    shown.add_row("all", "", str(flat_in_all), f"{outlines}: {100 * flat_in_all / outlines:.1f} %", "")
    Console().print(shown)


if __name__ == "__main__":
    main()
