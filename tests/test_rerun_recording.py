"""The recording for Rerun, read back: every layer at every step, in the viewer's coordinates."""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from click.testing import CliRunner

from foldrs.cli import main
from foldrs.errors import ImageNotFoundError, MissingExtraError
from foldrs.rerun_recording import ROOT, TIMELINE, RerunRecording
from foldrs.synth import make_scene
from foldrs.template import builtin_templates
from test_plot import exact_result


def read(path: Path) -> dict[str, dict[int, dict[str, Any]]]:
    """Component values by entity and step."""
    chunk = pytest.importorskip("rerun.chunk", reason="this rerun-sdk has no reader (rerun.chunk)")
    found: dict[str, dict[int, dict[str, Any]]] = {}
    for one in chunk.RrdReader(path).stream().to_chunks():
        batch = one.to_record_batch()
        kept = [name for name in batch.schema.names if name == TIMELINE or ":" in name]
        columns = batch.select(kept).to_pydict()
        for row, step in enumerate(columns.get(TIMELINE, [])):
            values = {name: column[row] for name, column in columns.items() if name != TIMELINE}
            steps = found.setdefault(one.entity_path.lstrip("/"), {})
            steps.setdefault(step, {}).update({k: v for k, v in values.items() if v is not None})
    return found


@pytest.fixture
def rerun() -> Any:
    return pytest.importorskip("rerun", reason="rerun-sdk is not installed: pip install 'foldrs[rerun]'")


@pytest.mark.usefixtures("rerun")
def test_every_layer_is_read_back(tmp_path: Path) -> None:
    result = exact_result()
    photo = np.full((480, 640, 3), (10, 200, 60), dtype=np.uint8)
    with RerunRecording(tmp_path / "results.rrd") as recording:
        recording.add(result, photo)
        recording.add(replace(result, grasp_pairs=(), image="second.jpg"), None)
    assert [path.name for path in tmp_path.iterdir()] == ["results.rrd"]
    found = read(tmp_path / "results.rrd")

    (strip,) = found[f"{ROOT}/outline"][0]["LineStrips2D:strips"]
    np.testing.assert_allclose(strip[:-1], result.outline_image + 0.5, atol=1e-3)
    assert strip[0] == strip[-1]
    (strip,) = found[f"{ROOT}/unfolded"][0]["LineStrips2D:strips"]
    np.testing.assert_allclose(strip[:-1], result.unfolded_outline_image + 0.5, atol=1e-3)
    (strip,) = found[f"{ROOT}/crease"][0]["LineStrips2D:strips"]
    np.testing.assert_allclose(strip, result.fold.axis_image + 0.5, atol=1e-3)
    marks = found[f"{ROOT}/landmarks"][0]
    assert marks["Points2D:labels"] == list(result.landmarks)
    np.testing.assert_allclose(
        marks["Points2D:positions"], [mark.image + 0.5 for mark in result.landmarks.values()], atol=1e-3
    )
    pair = found[f"{ROOT}/grasp"][0]
    assert pair["Points2D:labels"] == list(result.grasp_pairs[0].landmarks)
    coded = np.array(found[ROOT][0]["EncodedImage:blob"][0], dtype=np.uint8)
    assert cv2.imdecode(coded, cv2.IMREAD_COLOR).shape == photo.shape

    assert set(found[f"{ROOT}/outline"]) == {0, 1}
    assert set(found[f"{ROOT}/grasp"]) == {0}
    assert found[ROOT][1]["Clear:is_recursive"] == [True]
    assert "EncodedImage:blob" not in found[ROOT][1]
    assert "second.jpg" in found[f"{ROOT}/about"][1]["TextDocument:text"][0]


@pytest.mark.usefixtures("rerun")
def test_fit_records_images_at_their_places_and_failures_too(tmp_path: Path) -> None:
    make_scene(builtin_templates("towel")[0], seed=0).write(tmp_path, "towel")
    (tmp_path / "bad.jpg").write_text("no image")
    path = tmp_path / "new" / "results.rrd"
    arguments = ["fit", tmp_path / "bad.jpg", tmp_path / "towel.jpg", "--type", "towel", "--rerun", path]
    done = CliRunner().invoke(main, [str(argument) for argument in arguments])
    assert done.exit_code == 1
    found = read(path)
    assert set(found[f"{ROOT}/outline"]) == {1}
    assert "cannot be read" in found[f"{ROOT}/about"][0]["TextDocument:text"][0]


@pytest.mark.usefixtures("rerun")
def test_a_recording_appears_whole_or_not_at_all(tmp_path: Path) -> None:
    with RerunRecording(tmp_path / "results.rrd") as recording:
        recording.add(exact_result())
        earlier = (tmp_path / "results.rrd").exists()
    assert not earlier
    (tmp_path / "results.rrd").unlink()
    with pytest.raises(ImageNotFoundError), RerunRecording(tmp_path / "results.rrd") as recording:
        recording.add(exact_result(), tmp_path / "nowhere.jpg")
    assert list(tmp_path.iterdir()) == []


def test_a_missing_package_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "rerun", None)
    with pytest.raises(MissingExtraError, match=r"foldrs\[rerun\]"):
        RerunRecording(tmp_path / "results.rrd")
    done = CliRunner().invoke(main, ["fit", "photo.jpg", "--rerun", str(tmp_path / "results.rrd")])
    assert done.exit_code == 1
    assert "foldrs[rerun]" in done.stderr
