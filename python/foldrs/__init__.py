"""Which garment is it, where is it folded, where to grasp it: foldable templates fitted to one photograph.

The method is that of Mariolis & Malassiotis, *Modelling folded garments by fitting foldable templates*
(2015).

Examples
--------
>>> import foldrs
>>> foldrs.builtin_templates("pants")[0].grasp_pairs[0]
('waist_left', 'waist_right')
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from foldrs._core import __version__

if TYPE_CHECKING:
    from foldrs.batch import fit_many
    from foldrs.parameters import Parameters
    from foldrs.pipeline import fit
    from foldrs.result import FitResult
    from foldrs.tables import table
    from foldrs.template import Template, builtin_templates, load_template, save_template

__all__ = [
    "FitResult",
    "Parameters",
    "Template",
    "__version__",
    "builtin_templates",
    "fit",
    "fit_many",
    "load_template",
    "save_template",
    "table",
]

_HOME = {
    "FitResult": "result",
    "Parameters": "parameters",
    "Template": "template",
    "builtin_templates": "template",
    "fit": "pipeline",
    "fit_many": "batch",
    "load_template": "template",
    "save_template": "template",
    "table": "tables",
}


def __getattr__(name: str) -> Any:
    """Load a public name when it is first used: importing foldrs must not wait for OpenCV."""
    if name not in _HOME:
        raise AttributeError(f"module 'foldrs' has no attribute {name!r}")
    from importlib import import_module

    value = getattr(import_module(f"foldrs.{_HOME[name]}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted(__all__)
