"""The scale from the picture: something of known size that lies on the table.

It tells the scale, and the camera's tilt as far as its shape shows it; the result is a
:class:`~foldrs.camera.TablePlane`. One module a concept: :mod:`~foldrs.scale.marker` (printed markers),
:mod:`~foldrs.scale.sheet` (a sheet of paper), :mod:`~foldrs.scale.solve` (the plane that rectangles of known
size lie on) and :mod:`~foldrs.scale.paint` (taking them out of the picture).
"""

from foldrs.scale.marker import Marker
from foldrs.scale.reference import FoundReference, Reference
from foldrs.scale.sheet import A4, Sheet

__all__ = ["A4", "FoundReference", "Marker", "Reference", "Sheet"]
