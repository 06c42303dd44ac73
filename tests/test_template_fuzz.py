"""Template files with anything wrong in them are read, or refused by name; never anything else."""

from __future__ import annotations

import copy
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from foldrs import _core
from foldrs.errors import TemplateError
from foldrs.template import Template, builtin_templates, load_template

numbers = st.floats() | st.integers() | st.sampled_from([0, -1, 1e300, -1e-300, 2**70])
words = st.text(max_size=5) | st.sampled_from(["crotch", "corner_1", "cm", "type", "outline", "landmarks"])
values = st.recursive(
    st.none() | st.booleans() | numbers | words,
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(words, inner, max_size=4),
    max_leaves=12,
)


def fields() -> dict[str, Any]:
    """A valid template file."""
    (towel,) = builtin_templates("towel")
    return {
        "schema": 1,
        "type": "towel",
        "units": "cm",
        "outline": towel.outline.tolist(),
        "landmarks": {name: point.tolist() for name, point in towel.landmarks.items()},
        "symmetry": [list(pair) for pair in towel.symmetry],
        "grasp_pairs": [list(pair) for pair in towel.grasp_pairs],
    }


def places(value: Any) -> list[tuple[Any, Any]]:
    """Every place in a JSON value that holds another one: the container and its key or index."""
    keys = value.keys() if isinstance(value, dict) else range(len(value)) if isinstance(value, list) else ()
    return [place for key in keys for place in ((value, key), *places(value[key]))]


@st.composite
def flawed_files(draw: st.DrawFn) -> Any:
    content = copy.deepcopy(fields())
    for _ in range(draw(st.integers(1, 3))):
        holder, key = draw(st.sampled_from(places(content)))
        flaw = draw(st.sampled_from(["replace", "remove", "double", "swap"]))
        if flaw == "replace":
            holder[key] = draw(values)
        elif flaw == "remove" or isinstance(holder, dict):
            del holder[key]
        elif flaw == "double":
            holder.insert(key, copy.deepcopy(holder[key]))
        else:
            holder[key], holder[0] = holder[0], holder[key]
        if not places(content):
            break
    return content


def check(content: Any) -> None:
    """Read a template; one that is accepted can be used."""
    try:
        template = Template.from_dict(content, name="mine")
    except TemplateError:
        return
    _core.check_outline(template.outline)
    assert np.isfinite(template.landmark_array).all()
    assert Template.from_dict(template.to_dict(), name="mine").to_dict() == template.to_dict()


@settings(max_examples=400)
@given(flawed_files())
def test_a_valid_file_with_flaws(content: Any) -> None:
    check(content)


@settings(max_examples=150)
@given(values)
def test_any_json(content: Any) -> None:
    check(content)


@settings(max_examples=150)
@given(st.binary(max_size=60), st.integers(0, 400), st.booleans())
def test_any_bytes(tmp_path_factory: Any, noise: bytes, at: int, whole: bool) -> None:
    path: Path = tmp_path_factory.mktemp("template") / "mine.json"
    valid = json.dumps(fields()).encode()
    path.write_bytes(valid[:at] + noise + valid[at:] if whole else noise)
    try:
        load_template(path)
    except TemplateError as refused:
        told = str(refused)
    else:
        told = "mine.json was read"
    assert "mine.json" in told


def test_deep_nesting_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "mine.json"
    path.write_text("[" * 100_000)
    with pytest.raises(TemplateError, match=r"mine\.json"):
        load_template(path)
