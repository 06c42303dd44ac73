"""Templates drafted from flat garments: photographs, annotations, or several garments of a kind.

The steps, one module each: :mod:`~foldrs.drafting.symmetry` (the mirror axis),
:mod:`~foldrs.drafting.upright` (the garment turned upright, in centimetres),
:mod:`~foldrs.drafting.halves` (places along its two halves, each matched with its mirror image),
:mod:`~foldrs.drafting.matching`, :mod:`~foldrs.drafting.corners`,
:mod:`~foldrs.drafting.places` (landmarks marked by hand), :mod:`~foldrs.drafting.pairs` (names, mirror pairs,
grasp pairs) and :mod:`~foldrs.drafting.draft`, which puts them together; then :mod:`~foldrs.drafting.mean`
(several garments) and :mod:`~foldrs.drafting.annotations` (LabelMe, COCO).
"""

from foldrs.drafting.draft import Draft, draft_template
from foldrs.drafting.mean import mean_template
from foldrs.drafting.parameters import DraftParameters

__all__ = ["Draft", "DraftParameters", "draft_template", "mean_template"]
