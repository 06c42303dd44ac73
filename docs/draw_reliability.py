"""Draw the reliability diagram of the documentation.

    python docs/draw_reliability.py EVALUATION.json [PICTURE]

EVALUATION.json is what ``foldrs evaluate SCENES --out FOLDER`` writes.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path

from matplotlib.figure import Figure


def draw(evaluation: Path, picture: Path) -> None:
    """Draw what happened over what was said, the area of a dot telling the number of cases."""
    content = json.loads(evaluation.read_text(encoding="utf-8"))
    bins = content["reliability"]
    figure = Figure(figsize=(4.6, 4.2), layout="constrained")
    axes = figure.add_subplot()
    axes.plot([0, 1], [0, 1], color="0.7", linewidth=1, zorder=0)
    axes.scatter(
        [one["said"] for one in bins],
        [one["happened"] for one in bins],
        s=[4 * one["cases"] ** 0.5 * 6 for one in bins],
        color="tab:blue",
    )
    for one in bins:
        axes.annotate(
            str(one["cases"]), (one["said"], one["happened"]), textcoords="offset points", xytext=(9, -9)
        )
    axes.set(xlabel="probability said", ylabel="share right", xlim=(-0.03, 1.06), ylim=(-0.03, 1.06))
    axes.set_title(f"{len(content['scenes'])} scenes; beside each dot its explanations", fontsize=9)
    figure.savefig(picture, dpi=110)


if __name__ == "__main__":
    draw(Path(sys.argv[1]), Path(sys.argv[2] if len(sys.argv) > 2 else "docs/images/reliability.webp"))
