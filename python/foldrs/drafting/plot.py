"""Picture of a draft: the garment with its mirror axis and corners, beside the template made of it."""

from __future__ import annotations

import os

import numpy as np
from numpy.typing import NDArray

from foldrs.drafting.draft import Draft
from foldrs.explanation import apply
from foldrs.template_plot import draw_template, new_figure, write_figure


def save_draft_picture(
    draft: Draft, path: str | os.PathLike[str], *, photograph: NDArray[np.uint8] | None = None
) -> None:
    """Draw a draft into a picture file; the suffix names the format.

    Parameters
    ----------
    draft : Draft
        What to draw.
    path : path
        The file, for instance ``vest.png``.
    photograph : (h, w, 3) uint8 array, optional
        The photograph the outline was found in.

    Raises
    ------
    TemplateError
        If the picture cannot be written: no such folder, or a suffix that names no picture format.
    """
    figure = new_figure(13, 6)
    seen, made = figure.subplots(1, 2)
    if photograph is not None:
        seen.imshow(photograph)
    seen.plot(*np.vstack([draft.outline, draft.outline[:1]]).T, color="tab:orange", linewidth=1.2)
    if draft.symmetric:
        seen.plot(*_through(draft).T, color="tab:green", linestyle="-.", linewidth=1.2)
    template = draft.template
    back = np.linalg.inv(np.vstack([draft.to_template, [0.0, 0.0, 1.0]]))[:2]
    seen.plot(*apply(back, template.landmark_array).T, "o", color="tab:red", markersize=5)
    for number, point in enumerate(apply(back, template.landmark_array), start=1):
        seen.annotate(str(number), point, xytext=(5, 5), textcoords="offset points", color="tab:red")
    seen.set_title("corners in the order of their names")
    seen.set_aspect("equal")
    seen.set_axis_off()
    if not seen.yaxis_inverted():
        seen.invert_yaxis()
    draw_template(template, made)
    write_figure(figure, path)


def _through(draft: Draft) -> NDArray[np.float64]:
    """Return the mirror axis, from end to end of the garment."""
    start, end = draft.mirror.axis
    along = (end - start) / np.linalg.norm(end - start)
    reach = (draft.outline - start) @ along
    return np.array([start + reach.min() * along, start + reach.max() * along])
