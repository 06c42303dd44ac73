"""The geometry of the ROS 2 example, without ROS; the node itself is only compiled."""

from __future__ import annotations

import importlib.util
import py_compile
import sys
from dataclasses import replace
from pathlib import Path
from types import ModuleType
from typing import Any

import cv2
import numpy as np
import pytest

import foldrs
from foldrs.synth import SynthParameters, make_scene

FOLDER = Path(__file__).resolve().parents[1] / "examples/ros2"
CAMERA = np.array([[900.0, 0.0, 640.0], [0.0, 900.0, 360.0], [0.0, 0.0, 1.0]])


@pytest.fixture(scope="module")
def ros2() -> ModuleType:
    spec = importlib.util.spec_from_file_location("table_view", FOLDER / "table_view.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules["table_view"] = module  # its dataclass looks itself up there
    spec.loader.exec_module(module)
    return module


def tilted(ros2: ModuleType, degrees: float) -> Any:
    """A window of 1.2 by 0.9 m, its middle 1.3 m before the camera, which looks down or at an angle."""
    above = ros2.rotation_of((1.0, 0.0, 0.0, 0.0))  # half a turn about x: looks down
    tilt = cv2.Rodrigues(np.radians([degrees, 0.0, 0.0]))[0]
    return ros2.TableView(
        camera=CAMERA,
        rotation=tilt @ above,
        translation=np.array([0.0, 0.0, 1.3]),
        corner=np.array([-0.6, -0.45]),
        size=np.array([1.2, 0.9]),
    )


def test_the_node_compiles(tmp_path: Path) -> None:
    py_compile.compile(str(FOLDER / "foldrs_node.py"), cfile=str(tmp_path / "node.pyc"), doraise=True)


@pytest.mark.parametrize(
    ("encoding", "pixel", "rgb"),
    [
        ("mono8", [7], [7, 7, 7]),
        ("rgb8", [1, 2, 3], [1, 2, 3]),
        ("bgr8", [1, 2, 3], [3, 2, 1]),
        ("rgba8", [1, 2, 3, 9], [1, 2, 3]),
        ("bgra8", [1, 2, 3, 9], [3, 2, 1]),
    ],
)
def test_pictures_of_every_encoding(
    ros2: ModuleType, encoding: str, pixel: list[int], rgb: list[int]
) -> None:
    padding = [255, 255]
    rows = bytes((pixel * 4 + padding) * 3)
    picture = ros2.picture_of(encoding, 3, 4, 4 * len(pixel) + len(padding), rows)
    assert picture.shape == (3, 4, 3)
    assert (picture == rgb).all()


def test_an_unknown_encoding_is_named(ros2: ModuleType) -> None:
    with pytest.raises(ValueError, match="bayer_rggb8"):
        ros2.picture_of("bayer_rggb8", 1, 1, 1, b"0")


def test_points_of_the_view_are_those_of_the_table(ros2: ModuleType) -> None:
    view = tilted(ros2, 0.0)
    rows, columns = view.shape
    assert (rows, columns) == (360, 480)
    assert np.allclose(view.to_table(np.array([[-0.5, -0.5], [479.5, 359.5]])), [[-0.6, 0.45], [0.6, -0.45]])
    # Straight below the camera is the middle of its picture; x of the table runs to its right, y up.
    middle, right, up = view.to_camera_picture(np.array([[239.5, 179.5], [340.0, 179.5], [239.5, 80.0]]))
    assert np.allclose(middle, [640.0, 360.0])
    assert right[0] > middle[0]
    assert up[1] < middle[1]


def test_a_window_behind_the_camera_is_refused(ros2: ModuleType) -> None:
    behind = replace(tilted(ros2, 0.0), translation=np.array([0.0, 0.0, -1.3]))
    with pytest.raises(ValueError, match="behind the camera"):
        behind.to_camera_picture(np.array([[0.0, 0.0]]))


def test_a_gripper_points_down_and_into_the_cloth(ros2: ModuleType) -> None:
    position, quaternion = ros2.grasp_pose(np.array([0.1, -0.2]), np.array([-1.0, 1.0]))
    turn = ros2.rotation_of(tuple(quaternion))
    assert np.allclose(position, [0.1, -0.2, 0.0])
    assert np.allclose(turn @ [0, 0, 1], [0, 0, -1])
    assert np.allclose(turn @ [1, 0, 0], [-np.sqrt(0.5), np.sqrt(0.5), 0])
    assert np.isclose(np.linalg.norm(quaternion), 1)


@pytest.mark.parametrize("degrees", [0.0, 25.0])
def test_a_picture_taken_at_an_angle_is_seen_from_above(ros2: ModuleType, degrees: float) -> None:
    plain = SynthParameters(scenarios=("corner",), px_per_cm=4.0)
    scene = make_scene(foldrs.builtin_templates("towel")[0], seed=7, parameters=plain)
    view = tilted(ros2, degrees)
    height, width = scene.mask.shape
    # What the camera would see if the scene lay on the table, the scene's first pixel at the view's.
    corners = np.array([[0, 0], [width - 1, 0], [width - 1, height - 1], [0, height - 1]], float)
    seen = cv2.getPerspectiveTransform(
        corners.astype(np.float32), view.to_camera_picture(corners).astype(np.float32)
    )
    photo = cv2.warpPerspective(scene.image, seen, (1280, 720))

    rows, columns = min(height, view.shape[0]), min(width, view.shape[1])
    again = view.of(photo)[:rows, :columns].astype(float)
    inside = (slice(10, rows - 10), slice(10, columns - 10))
    assert np.abs(again - scene.image[:rows, :columns])[inside].mean() < 6.0
