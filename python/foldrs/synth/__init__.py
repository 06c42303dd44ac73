"""Scenes of folded garments with ground truth, at any number.

A flat garment (a template, or the outline of a real one) is varied, folded once or twice, laid on a table
and pictured from above or at an angle; what is true of the picture is known exactly and written beside it.
The steps, one module each: :mod:`~foldrs.synth.ordered_landmarks` (landmarks moved so that they follow each
other along their outline), :mod:`~foldrs.synth.garment` (another garment of the kind),
:mod:`~foldrs.synth.fold_lines` (where it is folded), :mod:`~foldrs.synth.layers` (the layers of cloth and
where a point of the garment comes to lie), :mod:`~foldrs.synth.pose` (how the whole lies in the picture),
:mod:`~foldrs.synth.camera` and :mod:`~foldrs.synth.depth` (what looks at it),
:mod:`~foldrs.synth.references` (markers beside it), :mod:`~foldrs.synth.cloth`,
:mod:`~foldrs.synth.table`, :mod:`~foldrs.synth.photographs` (real cloth upon real tables)
and :mod:`~foldrs.synth.render` (the pixels), :mod:`~foldrs.synth.truth` (the ground truth),
:mod:`~foldrs.synth.scene` (one scene) and :mod:`~foldrs.synth.batch` (many).

Examples
--------
>>> import foldrs
>>> from foldrs.synth import SynthParameters, make_scene
>>> towel = foldrs.builtin_templates("towel")[0]
>>> scene = make_scene(towel, seed=7, parameters=SynthParameters(scenarios=("corner",)))
>>> scene.truth["type"], scene.truth["scenario"], len(scene.truth["axis_image"])
('towel', 'corner', 2)
>>> scene.image.shape[:2] == scene.mask.shape
True
"""

from foldrs.synth.batch import make_scenes
from foldrs.synth.garment import FlatGarment, Garment, Photograph, garment_from_outline
from foldrs.synth.parameters import CLOTHS, SCENARIOS, TABLES, SynthParameters
from foldrs.synth.scene import Scene, make_scene

__all__ = [
    "CLOTHS",
    "SCENARIOS",
    "TABLES",
    "FlatGarment",
    "Garment",
    "Photograph",
    "Scene",
    "SynthParameters",
    "garment_from_outline",
    "make_scene",
    "make_scenes",
]
