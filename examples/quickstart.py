"""Explain one photograph and print where to grasp: python examples/quickstart.py [PHOTO]."""

import sys
import tempfile
from pathlib import Path

import foldrs
from foldrs.synth import make_scene


def drawn_photograph(folder: Path) -> Path:
    """Draw a photograph to try with: trousers, folded once."""
    scene = make_scene(foldrs.builtin_templates("pants")[0], seed=4)
    return scene.write(folder, "pants").with_suffix(".jpg")


def main() -> None:
    """Fit and print."""
    with tempfile.TemporaryDirectory() as folder:
        photo = Path(sys.argv[1]) if len(sys.argv) > 1 else drawn_photograph(Path(folder))
        result = foldrs.fit(photo)

    print(f"{result.garment_type}, {'folded' if result.accepted else 'not folded as far as can be told'}")
    if result.fold is not None:
        print("crease, px:", result.fold.axis_image.round().tolist())
    for pair in result.grasp_pairs[:1]:
        print("grasp", " and ".join(pair.landmarks), "at", pair.image.round().tolist())
    for other in result.alternatives:
        creases = [fold.axis_image.round().tolist() for fold in other.folds]
        print(f"  {other.probability:4.0%}  {other.garment_type:8}  creases {creases}")


if __name__ == "__main__":
    main()
