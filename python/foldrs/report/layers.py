"""The layers of a picture that a reader of the page can switch, with their colours.

The colours are those of the plots (after Okabe and Ito): they suit any colour vision.
"""

from __future__ import annotations

from dataclasses import dataclass

from foldrs import _plot_panels as panels

TRUTH = "#cc79a7"


@dataclass(frozen=True)
class Layer:
    """One layer; its `name` is that of its class and of its switch."""

    name: str
    label: str
    colour: str
    shown: bool = True
    """Whether the page shows it when it is opened."""


PHOTO = Layer("photo", "photograph", "")
TRUE = Layer("truth", "truth", TRUTH)
OUTLINE = Layer("outline", "outline seen", panels.SEEN)
KEPT = Layer("kept", "kept part", panels.KEPT, shown=False)
FLAP = Layer("flap", "flap", panels.FLAP, shown=False)
UNFOLDED = Layer("unfolded", "unfolded garment", panels.UNFOLDED)
CREASE = Layer("crease", "crease", panels.CREASE)
LANDMARKS = Layer("landmarks", "landmarks", "currentcolor")
GRASP = Layer("grasp", "grasp pair", panels.GRASP)

LAYERS = (PHOTO, TRUE, OUTLINE, KEPT, FLAP, UNFOLDED, CREASE, LANDMARKS, GRASP)
"""In the order of their switches; they are drawn in the order of the page's template."""
