"""A kind of garment of one's own: measured, written to a template file, drawn folded, and found again."""

import tempfile
from pathlib import Path

import foldrs
from foldrs.synth import SynthParameters, make_scene

# An apron, measured with a ruler: cm, x to the right, y down, the neck at the top.
APRON = {
    "schema": 1,
    "type": "apron",
    "units": "cm",
    "outline": [[-14, 0], [-17, 8], [-35, 28], [-35, 88], [35, 88], [35, 28], [17, 8], [14, 0]],
    "landmarks": {
        "neck_left": [-14, 0],
        "waist_left": [-35, 28],
        "hem_left": [-35, 88],
        "hem_right": [35, 88],
        "waist_right": [35, 28],
        "neck_right": [14, 0],
    },
    "symmetry": [["neck_left", "neck_right"], ["waist_left", "waist_right"], ["hem_left", "hem_right"]],
    "grasp_pairs": [["waist_left", "waist_right"], ["hem_left", "hem_right"], ["neck_left", "neck_right"]],
}


def main() -> None:
    """Write the template, fold it, fit it."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        template_file = folder / "apron.json"
        foldrs.save_template(foldrs.Template.from_dict(APRON, name="apron"), template_file)

        template = foldrs.load_template(template_file)
        scene = make_scene(template, seed=1, parameters=SynthParameters(flap_fraction=(0.2, 0.4)))
        photo = scene.write(folder, "scene").with_suffix(".jpg")
        result = foldrs.fit(photo, templates=[template_file])

    print("crease found, px:", result.fold.axis_image.round().tolist())
    print("true crease, px: ", scene.truth["axis_image"])
    for name, mark in result.landmarks.items():
        print(f"  {name:12} {mark.image.round().tolist()}  {'in reach' if mark.accessible else 'hidden'}")


if __name__ == "__main__":
    main()
