"""Markers and sheets: what they tell of the table, that they are no cloth, and what is refused."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest
from click.testing import CliRunner
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

import foldrs
from foldrs import _core
from foldrs.camera import Camera, TablePlane
from foldrs.cli import main
from foldrs.errors import ParameterError, ScaleReferenceError
from foldrs.outline import find_outline
from foldrs.parameters import ScaleParameters
from foldrs.scale import A4, Marker, Reference, Sheet
from foldrs.scale.marker import DICTIONARIES
from foldrs.scale.paint import painted_over
from foldrs.scale.solve import plane_of_rectangles
from foldrs.synth import Scene, SynthParameters, make_scene
from foldrs.template import builtin_templates

PARAMETERS = ScaleParameters()
TOWEL = builtin_templates("towel")[0]
SCENE = SynthParameters(scenarios=("corner",), tables=("wood",), cloths=("stripes",), px_per_cm=3.5)
WITH: dict[str, tuple[Reference, SynthParameters]] = {
    "markers": (Marker(8.0), replace(SCENE, marker_cm=8.0)),
    "sheet": (A4, replace(SCENE, sheet=True)),
}


def true_plane(scene: Scene) -> TablePlane:
    return TablePlane(np.linalg.inv(scene.camera.table_to_image))


def lengths(plane: TablePlane, outline: NDArray[np.float64]) -> NDArray[np.float64]:
    """Distances between all corners of an outline, cm: what does not depend on the table's frame."""
    points = plane.to_table(outline)
    return np.linalg.norm(points[:, None] - points[None], axis=2)


@pytest.fixture(scope="module", params=[0.0, 30.0], ids=["above", "tilted"])
def tilt(request: pytest.FixtureRequest) -> float:
    return float(request.param)


@pytest.fixture(scope="module", params=list(WITH))
def scene_with(request: pytest.FixtureRequest, tilt: float) -> tuple[Reference, Scene]:
    reference, parameters = WITH[request.param]
    return reference, make_scene(TOWEL, seed=4, parameters=replace(parameters, tilt_deg=tilt))


def test_lengths_on_the_table_are_true(scene_with: tuple[Reference, Scene]) -> None:
    reference, scene = scene_with
    found = reference.find(scene.image, None, PARAMETERS)
    outline = np.array(scene.truth["outline_image"])[::3]
    truth = lengths(true_plane(scene), outline)
    assert np.abs(lengths(found.plane, outline) - truth).max() < 0.05 * truth.max()


def test_it_is_not_taken_for_cloth(scene_with: tuple[Reference, Scene]) -> None:
    reference, scene = scene_with
    found = reference.find(scene.image, None, PARAMETERS)
    assert not (found.covered & (scene.mask > 0)).any()
    seen = find_outline(painted_over(scene.image, found.covered))
    assert seen.mask is not None
    assert not (seen.mask & found.covered).any()
    assert _core.outline_iou(seen.points, np.array(scene.truth["outline_image"])) > 0.95


def test_z_comes_out_of_the_table(scene_with: tuple[Reference, Scene]) -> None:
    reference, scene = scene_with
    plane = reference.find(scene.image, None, PARAMETERS).plane
    outline = np.array(scene.truth["outline_image"])
    # y runs down in the picture, so a frame whose z points at the camera reverses the winding
    assert _core.signed_area(plane.to_table(outline)) * _core.signed_area(outline) < 0


def test_a_known_camera_is_used(tilt: float) -> None:
    scene = make_scene(TOWEL, seed=4, parameters=replace(SCENE, marker_cm=8.0, tilt_deg=tilt))
    outline = np.array(scene.truth["outline_image"])[::3]
    truth = lengths(true_plane(scene), outline)
    plane = Marker(8.0, "apriltag-36h11").find(scene.image, Camera(scene.camera.matrix), PARAMETERS).plane
    assert np.abs(lengths(plane, outline) - truth).max() < 0.04 * truth.max()


def test_the_frame_is_that_of_the_first_marker() -> None:
    scene = make_scene(TOWEL, seed=4, parameters=replace(SCENE, marker_cm=8.0))
    found = Marker(8.0).find(scene.image, None, PARAMETERS)
    on_table = [found.plane.to_table(corners) for corners in found.corners]
    expected = np.array([[-4.0, 4], [4, 4], [4, -4], [-4, -4]])
    assert min(np.abs(one - expected).max() for one in on_table) < 0.15


@settings(max_examples=15)
@given(
    st.floats(-0.55, 0.55),
    st.floats(-0.55, 0.55),
    st.lists(st.tuples(st.floats(-45, 45), st.floats(-30, 30), st.floats(0, 6.28)), min_size=3, max_size=5),
)
def test_markers_far_apart_tell_the_tilt(
    x: float, y: float, places: list[tuple[float, float, float]]
) -> None:
    """Exact corners, as OpenCV projects them, of a camera with the focal length that is expected."""
    focal = PARAMETERS.focal * 640
    matrix = np.array([[focal, 0, 319.5], [0, focal, 239.5], [0, 0, 1]])
    square = np.array([[-4.0, -4], [4, -4], [4, 4], [-4, 4]])
    quads, tables = [], []
    for px, py, turn in places:
        c, s = np.cos(turn), np.sin(turn)
        tables.append(square @ np.array([[c, s], [-s, c]]) + (px, py))
        spatial = np.column_stack([tables[-1], np.zeros(4)])
        image, _ = cv2.projectPoints(spatial, np.array([x, y, 0.0]), np.array([0, 0, 170.0]), matrix, None)
        quads.append(image.reshape(-1, 2))
    strict = replace(PARAMETERS, corner_noise=0.01)
    solved = plane_of_rectangles(quads, [(8.0, 8.0)] * len(quads), (640, 480), None, strict)
    assert solved.worst < 0.05
    found = np.vstack([solved.plane.to_table(quad) for quad in quads])
    truth = np.vstack(tables)
    for points in (found, truth):
        points -= points.mean(axis=0)
    size = np.linalg.norm(truth, axis=1)
    np.testing.assert_allclose(np.linalg.norm(found, axis=1), size, atol=0.02 * size.max())


def test_every_family_is_one_of_opencv() -> None:
    for name in DICTIONARIES.values():
        assert hasattr(cv2.aruco, name)


def test_fit_takes_it_and_tells_the_table(scene_with: tuple[Reference, Scene]) -> None:
    reference, scene = scene_with
    result = foldrs.fit(scene.image, garment_type="towel", table=reference)
    assert result.table is not None
    truth = true_plane(scene).to_table(scene.truth["outline_image"])
    measured = abs(_core.signed_area(result.table.outline))
    assert measured == pytest.approx(abs(_core.signed_area(truth)), rel=0.08)


def test_marker_and_sheet_by_command(tmp_path: Path) -> None:
    for name, option in (("markers", ("--marker", "8")), ("sheet", ("--a4",))):
        make_scene(TOWEL, seed=4, parameters=WITH[name][1]).write(tmp_path, name)
        arguments = ["fit", str(tmp_path / f"{name}.jpg"), *option, "--out", str(tmp_path / "out")]
        done = CliRunner().invoke(main, [*arguments, "--type", "towel"])
        assert done.exit_code == 0, done.output
        assert json.loads((tmp_path / "out" / f"{name}.json").read_text())["table"]["units"] == "cm"


# -- what is refused --


@pytest.fixture(scope="module")
def bare() -> Scene:
    return make_scene(TOWEL, seed=4, parameters=SCENE)


def test_what_is_not_there_is_not_found(bare: Scene) -> None:
    with pytest.raises(ScaleReferenceError, match="No marker"):
        Marker(8.0).find(bare.image, None, PARAMETERS)
    with pytest.raises(ScaleReferenceError, match="No white sheet"):
        A4.find(bare.image, None, PARAMETERS)


def test_two_sheets_are_ambiguous(bare: Scene) -> None:
    picture = np.full((480, 640, 3), 120, np.uint8)
    for x in (60, 400):
        cv2.rectangle(picture, (x, 100), (x + 118, 183), (240, 240, 240), cv2.FILLED)
    with pytest.raises(ScaleReferenceError, match="2 things"):
        A4.find(picture, None, PARAMETERS)


@pytest.mark.parametrize("shape", ["long", "round", "printed", "coloured"])
def test_what_is_no_sheet_is_not_taken_for_one(shape: str) -> None:
    picture = np.full((480, 640, 3), 120, np.uint8)
    if shape == "long":
        cv2.rectangle(picture, (100, 100), (400, 160), (240, 240, 240), cv2.FILLED)
    elif shape == "round":
        cv2.ellipse(picture, (300, 200), (90, 64), 0, 0, 360, (240, 240, 240), cv2.FILLED)
    elif shape == "printed":
        cv2.rectangle(picture, (100, 100), (218, 183), (240, 240, 240), cv2.FILLED)
        cv2.rectangle(picture, (120, 115), (198, 170), (140, 140, 140), cv2.FILLED)
    else:
        cv2.rectangle(picture, (100, 100), (218, 183), (240, 160, 160), cv2.FILLED)
    with pytest.raises(ScaleReferenceError, match="No white sheet"):
        A4.find(picture, None, PARAMETERS)


def test_markers_of_two_families_are_ambiguous() -> None:
    picture = np.full((480, 640), 230, np.uint8)
    for x, name in ((100, "DICT_APRILTAG_36h11"), (400, "DICT_5X5_250")):
        dictionary = cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, name))
        picture[200:280, x : x + 80] = cv2.aruco.generateImageMarker(dictionary, 7, 80)
    rgb = np.repeat(picture[:, :, None], 3, axis=2)
    with pytest.raises(ScaleReferenceError, match="several families"):
        Marker(8.0).find(rgb, None, PARAMETERS)
    assert len(Marker(8.0, "aruco-5x5").find(rgb, None, PARAMETERS).corners) == 1


def test_markers_of_two_sizes_are_refused() -> None:
    picture = np.full((480, 640), 230, np.uint8)
    dictionary = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_APRILTAG_36h11)
    for number, (x, y, side) in enumerate(
        ((60, 60, 40), (500, 60, 80), (300, 200, 40), (60, 380, 80), (540, 400, 40))
    ):
        picture[y : y + side, x : x + side] = cv2.aruco.generateImageMarker(dictionary, number, side)
    with pytest.raises(ScaleReferenceError, match="one size"):
        Marker(8.0).find(np.repeat(picture[:, :, None], 3, axis=2), None, PARAMETERS)


def test_impossible_sizes_are_refused() -> None:
    for size in (0.0, -1.0, float("nan")):
        with pytest.raises(ParameterError, match="size"):
            Marker(size)
    with pytest.raises(ParameterError, match="family"):
        Marker(5.0, "aruco-3x3")
    with pytest.raises(ParameterError, match="sides"):
        Sheet(29.7, 21.0)


def test_they_need_a_photograph(bare: Scene) -> None:
    with pytest.raises(ParameterError, match="photograph"):
        foldrs.fit(np.array(bare.truth["outline_image"]), table=A4)
