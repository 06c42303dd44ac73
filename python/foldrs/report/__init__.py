"""Results as one HTML page: every image with layers to switch, its explanations, its numbers.

The page holds everything it needs and loads nothing; a browser opens it from a disk as well as from a server.
One module a step: :mod:`~foldrs.report.frame` (the photograph, cut and embedded),
:mod:`~foldrs.report.drawing` (the shapes of every layer), :mod:`~foldrs.report.layers` (their names and
colours), :mod:`~foldrs.report.columns` (the numbers of an image) and :mod:`~foldrs.report.page` (the file).
What the page looks like and does is in ``assets``: two templates, a style sheet, a script.
"""

from foldrs.report.page import Report, write

__all__ = ["Report", "write"]
