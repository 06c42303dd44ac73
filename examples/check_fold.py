"""Was the fold made as planned? Fit the garment's own template, and compare creases."""

import numpy as np

import foldrs
from foldrs.evaluation.geometry import area, hull_share
from foldrs.synth import SynthParameters, make_scene

ALIKE = 0.1
"""Area between two creases, as a share of the garment's, up to which they count as the same (dA)."""


def main() -> None:
    """Draw a towel folded as planned, and look whether the photograph agrees with the plan."""
    towel = foldrs.builtin_templates("towel")[0]
    exactly_this_towel = SynthParameters(
        size_range=(1.0, 1.0), shape_cm=0.0, asymmetry_cm=0.0, stretch=0.0, scenarios=("corner",)
    )
    scene = make_scene(towel, seed=7, parameters=exactly_this_towel)
    planned = np.array(scene.truth["axis_image"])  # where the crease should lie in the picture

    result = foldrs.fit(scene.image, templates=[towel], px_per_cm=4.0)
    whole = area(result.unfolded_outline_image)
    off = hull_share(result.fold.axis_image, planned, whole)
    print(f"matching cost {result.matching_cost:.3f}, area between the creases {off:.1%} of the garment")
    print("as planned" if result.accepted and off < ALIKE else "not as planned: fold again")


if __name__ == "__main__":
    main()
