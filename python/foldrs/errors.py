"""Everything foldrs raises on bad input.

Every exception here derives from :class:`FoldrsError`, so one ``except`` catches them all, and from the
built-in exception a Python user would expect (``ValueError``, ``FileNotFoundError``), so code that knows
nothing of foldrs behaves as well. Each message says what was wrong and what to do about it.

Examples
--------
>>> import foldrs
>>> from foldrs.errors import FoldrsError, ImageNotFoundError
>>> try:
...     foldrs.fit("no-such-photo.jpg")
... except FoldrsError as error:
...     print(isinstance(error, ImageNotFoundError), isinstance(error, FileNotFoundError))
True True
"""

from __future__ import annotations


class FoldrsError(Exception):
    """Base of all errors raised by foldrs.

    Attributes
    ----------
    image : str
        Name of the image, where :func:`foldrs.fit_many` yields the error; empty otherwise.
    """

    image: str = ""


class ImageNotFoundError(FoldrsError, FileNotFoundError):
    """The image file does not exist or is a folder."""


class NotAnImageError(FoldrsError, ValueError):
    """The file or array cannot be read as an image."""


class ImageTooLargeError(NotAnImageError):
    """The image has more pixels than allowed; it was not decoded."""


class OutlineError(FoldrsError, ValueError):
    """No usable outline: base of the errors of stage 0."""


class NoGarmentError(OutlineError):
    """Nothing that stands out from the table (an empty table, or cloth that fills the picture)."""


class SeveralGarmentsError(OutlineError):
    """Two or more objects of like size: which one is meant cannot be told."""


class GarmentCutOffError(OutlineError):
    """The border of the picture cuts the garment."""


class GarmentTooSmallError(OutlineError):
    """The garment covers too few pixels for its shape to be told."""


class InvalidOutlineError(OutlineError):
    """The points are no outline: fewer than three, not finite, without area, or crossing themselves."""


class TemplateError(FoldrsError, ValueError):
    """A template file or object is not valid, or an annotation that a template is to be made of.

    Attributes
    ----------
    field : str
        The field at fault, for instance ``"landmarks.crotch"``; empty if it is the file as a whole.
    """

    def __init__(self, message: str, field: str = "") -> None:
        super().__init__(message)
        self.field = field


class CalibrationError(FoldrsError, ValueError):
    """A homography, camera or pose is not valid, or does not go with the picture.

    Attributes
    ----------
    field : str
        The field at fault, for instance ``"camera_matrix"``; empty if it is the file as a whole.
    """

    def __init__(self, message: str, field: str = "") -> None:
        super().__init__(message)
        self.field = field


class ScaleReferenceError(FoldrsError, ValueError):
    """The marker or sheet that tells the scale is not in the picture, or it is unclear which one is."""


class DepthError(FoldrsError, ValueError):
    """A depth image cannot be read, does not go with the photograph, or shows no table."""


class ParameterError(FoldrsError, ValueError):
    """A parameter is outside its range, for instance a scale of zero pixels a centimetre."""


class NoHypothesisError(FoldrsError):
    """No template offers a single fold that could be compared with the outline."""


class MissingExtraError(FoldrsError, ImportError):
    """What was asked for needs a package that is installed only on demand."""


class FitTimeoutError(FoldrsError, TimeoutError):
    """An image took longer than it was allowed to."""


class WorkerLostError(FoldrsError, RuntimeError):
    """The process that was at work on an image ended: killed, out of memory, or by a defect."""


class OutputError(FoldrsError, OSError):
    """A result would overwrite that of another image."""


class GarmentCutOffWarning(UserWarning):
    """The garment touches the border of the picture a little: its outline may be cut there."""
