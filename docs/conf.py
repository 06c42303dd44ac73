"""Sphinx configuration: Markdown pages, and the API from the docstrings."""

from foldrs import __version__

project = "foldrs"
author = "The foldrs developers"
copyright = "2026, The foldrs developers"
release = version = __version__

extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon", "sphinx.ext.viewcode"]
source_suffix = {".md": "markdown"}
exclude_patterns = ["list_licences.py", "tutorial/*"]
myst_enable_extensions = ["deflist", "dollarmath"]
myst_heading_anchors = 3
suppress_warnings = ["ref.python"]  # a type named like a field of two classes

html_theme = "furo"
html_title = f"foldrs {version}"
default_role = "code"  # `word` in a docstring

autodoc_member_order = "bysource"
autodoc_typehints = "signature"
autodoc_default_options = {"members": True}
autodoc_preserve_defaults = True
napoleon_google_docstring = False
napoleon_use_ivar = True
