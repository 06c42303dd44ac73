"""Make the picture of docs/camera.md, docs/images/camera.webp: a scene seen at an angle, and from above."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

import foldrs
from foldrs.depth import heights_above_table
from foldrs.parameters import DepthParameters
from foldrs.result import FitResult
from foldrs.scale import Marker
from foldrs.synth import SynthParameters, make_scene
from foldrs.template import builtin_templates

SEED = 18
MARKER_CM = 10.0
SCENE = SynthParameters(
    image_size=(960, 720),
    px_per_cm=6.0,
    tilt_deg=35.0,
    marker_cm=MARKER_CM,
    depth=True,
    thickness_cm=(0.3, 0.3),
    scenarios=("random", "landmarks"),
    flap_fraction=(0.2, 0.4),
    under=0.0,
    tables=("checks",),
    cloths=("stripes",),
)
QUALITY = 82  # of 100


def draw_result(ax: Axes, picture: np.ndarray, result: FitResult) -> None:
    """Draw the picture with outline, crease, unfolded outline and grasp pair."""
    ax.imshow(picture)
    for outline, style in ((result.unfolded_outline_image, "--"), (result.outline_image, "-")):
        closed = np.vstack([outline, outline[:1]])
        ax.plot(*closed.T, style, color="#e69f00" if style == "--" else "#0072b2", linewidth=2)
    ax.plot(*result.fold.axis_image.T, color="#d00000", linewidth=3)
    if result.grasp_pairs:
        ax.plot(*result.grasp_pairs[0].image.T, "o", color="#00b383", markersize=9, markerfacecolor="none")


def main() -> None:
    """Draw a scene with markers, explain it, and write the picture."""
    scene = make_scene(builtin_templates("t-shirt")[0], seed=SEED, parameters=SCENE)
    result = foldrs.fit(scene.image, garment_type="t-shirt", table=Marker(MARKER_CM))
    above = result.from_above
    if above is None or above.picture is None or scene.depth is None:
        raise SystemExit("the markers were not used")
    heights = heights_above_table(scene.depth, None, DepthParameters()).above

    figure = Figure(figsize=(12.8, 4.3), dpi=100, facecolor="white", layout="constrained")
    panels = figure.subplots(1, 3)
    draw_result(panels[0], scene.image, result)
    panels[0].set_xlim(-0.5, scene.image.shape[1] - 0.5)
    panels[0].set_ylim(scene.image.shape[0] - 0.5, -0.5)
    draw_result(panels[1], above.picture, above.result)
    panels[2].imshow(heights, cmap="gray", vmin=-5, vmax=60)
    titles = ("the photograph", "seen from above", "height above the table, from depth")
    for ax, title in zip(panels, titles, strict=True):
        ax.set_axis_off()
        ax.set_title(title, fontsize=11)
    path = Path(__file__).resolve().parent / "images/camera.webp"
    pixels = path.with_suffix(".png")
    figure.savefig(pixels)
    cv2.imwrite(str(path), cv2.imread(str(pixels)), [cv2.IMWRITE_WEBP_QUALITY, QUALITY])
    pixels.unlink()


if __name__ == "__main__":
    main()
