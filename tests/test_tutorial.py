"""The page on adding a kind: its commands, run as they stand there, find the creases."""

from __future__ import annotations

import json
import re
import shlex
from collections.abc import Iterator
from pathlib import Path

import pytest
from click.testing import CliRunner

from foldrs.cli import main

PAGE = Path(__file__).resolve().parents[1] / "docs/add_a_kind.md"


@pytest.fixture(scope="module")
def outputs(_folder: None) -> list[tuple[str, str]]:
    """Commands of the page and what they print, run in the working folder."""
    text = PAGE.read_text(encoding="utf-8")
    garment = re.search(r"```json\n(.*?)```", text, re.DOTALL)
    assert garment is not None
    Path("waistcoats.json").write_text(garment[1], encoding="utf-8")
    told = []
    for command in re.findall(r"^    foldrs (.*)$", text, re.MULTILINE):
        done = CliRunner().invoke(main, shlex.split(command))
        assert done.exit_code == 0, f"{command}\n{done.output}"
        told.append((command, done.output))
    return told


@pytest.fixture(scope="module", autouse=True)
def _folder(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(tmp_path_factory.mktemp("tutorial"))
        yield


def test_the_creases_of_the_folded_garments_are_found(outputs: list[tuple[str, str]]) -> None:
    (evaluated,) = [told for command, told in outputs if command.startswith("evaluate")]
    overall = next(line for line in evaluated.splitlines() if "Overall" in line)
    scenes, _, _, right = re.findall(r"[\d.]+", overall)[:4]
    assert int(scenes) == 4
    assert float(right) >= 75.0


def test_the_template_carries_the_names(outputs: list[tuple[str, str]]) -> None:
    template = json.loads(Path("waistcoat.json").read_text())
    assert template["type"] == "waistcoat"
    assert len(template["landmarks"]) == 13
    assert ["armpit_left", "armpit_right"] in template["symmetry"]
    assert Path("waistcoat.png").is_file()
    result = json.loads(Path("results/waistcoat-01.json").read_text())
    assert result["garment_type"] == "waistcoat"
    assert result["accepted"]


def test_the_mean_of_several_tells_their_spread(outputs: list[tuple[str, str]]) -> None:
    mean = json.loads(Path("mean.json").read_text())
    assert set(mean["spread"]) == set(mean["landmarks"])
