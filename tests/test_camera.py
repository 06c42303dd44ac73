"""The camera: round trips, OpenCV as oracle, files as others write them, and what is refused."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from click.testing import CliRunner, Result
from hypothesis import assume, given
from hypothesis import strategies as st
from numpy.typing import NDArray

import foldrs
from foldrs import _core
from foldrs.camera import Camera, Pose, TablePlane, ViewFromAbove, load_camera, load_homography, load_pose
from foldrs.cli import main
from foldrs.errors import CalibrationError, ParameterError
from foldrs.evaluation import Evaluation, load_scenes
from foldrs.plot import draw_result
from foldrs.stages_plot import draw_stages
from foldrs.synth import Scene, SynthParameters, make_scene
from foldrs.template import builtin_templates

MATRIX = np.array([[600.0, 0, 320], [0, 610.5, 239], [0, 0, 1]])
LENS = np.array([-0.28, 0.1, 0.001, -0.0005, 0.01])
CAMERA = Camera(MATRIX, LENS, (640, 480))
TOWEL = builtin_templates("towel")[0]
TILTED = SynthParameters(tilt_deg=30, scenarios=("corner",), deformation_cm=0.0)

angles = st.floats(-0.7, 0.7)
poses = st.builds(
    lambda x, y, z, offset: Pose.of_vectors([x, y, z], [*offset, 1.5]),
    angles,
    angles,
    st.floats(-3.1, 3.1),
    st.tuples(st.floats(-0.3, 0.3), st.floats(-0.3, 0.3)),
)
table_points = st.lists(st.tuples(st.floats(-60, 60), st.floats(-60, 60)), min_size=1, max_size=20).map(
    lambda points: np.array(points)
)


def command(*arguments: object) -> Result:
    return CliRunner().invoke(main, ["fit", "--type", "towel", *(str(argument) for argument in arguments)])


@pytest.fixture(scope="module")
def scene() -> Scene:
    """A folded towel seen at an angle of 30 degrees."""
    return make_scene(TOWEL, seed=5, parameters=TILTED)


@pytest.fixture(scope="module")
def plane(scene: Scene) -> TablePlane:
    return TablePlane(np.linalg.inv(scene.camera.table_to_image))


@pytest.fixture(scope="module")
def result(scene: Scene, plane: TablePlane) -> foldrs.FitResult:
    base = Pose([[0, 1, 0, 0.5], [1, 0, 0, -0.2], [0, 0, -1, 0.1], [0, 0, 0, 1]])
    return foldrs.fit(scene.image, garment_type="towel", table=plane, robot_base=base)


# -- geometry --


@given(poses, table_points)
def test_table_and_image_points_are_each_others_inverse(pose: Pose, points: NDArray[np.float64]) -> None:
    plane = TablePlane.of_pose(Camera(MATRIX), pose)
    in_camera = pose.of_table(points)
    assume((in_camera[:, 2] > 0.2).all())
    image = plane.to_image(points)
    np.testing.assert_allclose(plane.to_table(image), points, atol=1e-6)


@given(poses, table_points)
def test_the_plane_projects_as_opencv_does(pose: Pose, points: NDArray[np.float64]) -> None:
    in_camera = pose.of_table(points)
    assume((in_camera[:, 2] > 0.2).all())
    assume(np.abs(in_camera[:, :2] / in_camera[:, 2:]).max() < 0.6)
    rvec, _ = cv2.Rodrigues(np.array(pose.matrix[:3, :3]))
    spatial = np.column_stack([points / 100, np.zeros(len(points))])
    expected, _ = cv2.projectPoints(spatial, rvec, np.array(pose.matrix[:3, 3]), MATRIX, LENS)
    plane = TablePlane.of_pose(CAMERA, pose)
    np.testing.assert_allclose(plane.to_image(points), expected.reshape(-1, 2), atol=1e-6)
    np.testing.assert_allclose(plane.to_table(expected.reshape(-1, 2)), points, atol=1e-4)


@given(st.lists(st.tuples(st.floats(0, 639), st.floats(0, 479)), min_size=1).map(np.array))
def test_distortion_taken_off_and_put_on_again_changes_nothing(points: NDArray[np.float64]) -> None:
    np.testing.assert_allclose(CAMERA.distorted(CAMERA.undistorted(points)), points, atol=1e-5)


@given(poses)
def test_the_view_from_above_keeps_lengths_turn_and_hand(pose: Pose) -> None:
    plane = TablePlane.of_pose(CAMERA, pose)
    square = np.array([[-20.0, -20], [20, -20], [20, 20], [-20, 20]])
    in_camera = pose.of_table(square * 3)
    assume((in_camera[:, 2] > 0.3).all() and np.abs(in_camera[:, :2] / in_camera[:, 2:]).max() < 0.8)
    image = plane.to_image(square)
    view = ViewFromAbove.of(plane, image)
    seen = view.from_image(image)
    sides = np.linalg.norm(np.roll(seen, -1, axis=0) - seen, axis=1)
    np.testing.assert_allclose(sides, 40 * view.px_per_cm, rtol=1e-6)
    assert _core.signed_area(seen) == pytest.approx(_core.signed_area(image), rel=1e-6)
    np.testing.assert_allclose(view.to_image(seen), image, atol=1e-5)
    way, there = image[1] - image[0] + image[2] - image[3], seen[1] - seen[0]
    assert way @ there > 0.5 * np.linalg.norm(way) * np.linalg.norm(there)
    assert (seen >= 0).all()
    assert (seen <= np.array(view.size) - 1).all()


def test_the_picture_from_above_shows_what_lies_there(scene: Scene, plane: TablePlane) -> None:
    outline = np.array(scene.truth["outline_image"])
    view = ViewFromAbove.of(plane, outline)
    seen = view.picture(scene.mask) > 127
    expected = np.zeros(seen.shape, np.uint8)
    cv2.fillPoly(expected, [np.round(view.from_image(outline)).astype(np.int32).reshape(-1, 1, 2)], 1)
    assert np.count_nonzero(seen & (expected > 0)) / np.count_nonzero(seen | (expected > 0)) > 0.98


def test_a_point_of_the_table_comes_into_the_base_in_metres() -> None:
    base = Pose.of_vectors([0, 0, np.pi / 2], [1.0, 2.0, 3.0])
    np.testing.assert_allclose(base.of_table(np.array([[100.0, 0], [0, 50]])), [[1, 3, 3], [0.5, 2, 3]])


def test_the_horizon_is_told_not_crossed() -> None:
    plane = TablePlane.of_pose(Camera(MATRIX), Pose.of_vectors([1.2, 0, 0], [0, 0, 1.5]))
    with pytest.raises(CalibrationError, match="horizon"):
        plane.to_table([[320.0, 400], [320, -2000], [320, 5000]])


# -- results --


def test_image_and_table_tell_the_same_points(result: foldrs.FitResult, plane: TablePlane) -> None:
    assert result.table is not None
    for image, table in (
        (result.outline_image, result.table.outline),
        (result.fold.axis_image, result.table.creases[-1]),
        (result.unfolded_outline_image, result.table.unfolded_outline),
        (result.grasp_pairs[0].image, result.table.grasp_pairs[0].points),
        (
            [mark.image for mark in result.landmarks.values()],
            list(result.table.landmarks.values()),
        ),
    ):
        np.testing.assert_allclose(plane.to_table(image), table, atol=1e-6)
    chosen = result.alternatives[0]
    np.testing.assert_allclose(chosen.fold.axis_image, result.fold.axis_image, atol=1e-6)
    np.testing.assert_allclose(chosen.unfolded_outline_image, result.unfolded_outline_image, atol=1e-6)
    one, there = result.unfolding.one_arm, result.table.unfolding.one_arm
    assert one is not None
    assert there is not None
    np.testing.assert_allclose(plane.to_table([one.pick, one.place]), [there.pick, there.place], atol=1e-6)


def test_robot_points_are_table_points_in_the_base(result: foldrs.FitResult) -> None:
    assert result.table is not None
    assert result.robot is not None
    x, y = result.table.grasp_pairs[0].points.T / 100
    np.testing.assert_allclose(
        result.robot.grasp_pairs[0].points, np.column_stack([y + 0.5, x - 0.2, np.full(2, 0.1)]), atol=1e-9
    )


def test_the_garment_is_measured_true_on_the_table(
    result: foldrs.FitResult, scene: Scene, plane: TablePlane
) -> None:
    assert result.table is not None
    truth = plane.to_table(scene.truth["outline_image"])
    assert _core.outline_iou(result.table.outline, truth) > 0.95
    crease = np.linalg.norm(np.diff(plane.to_table(scene.truth["axis_image"]), axis=0))
    assert np.linalg.norm(np.diff(result.table.creases[-1], axis=0)) == pytest.approx(crease, rel=0.05)


def test_json_holds_all_frames(result: foldrs.FitResult) -> None:
    answer = json.loads(json.dumps(result.to_dict()))
    assert answer["table"]["units"] == "cm"
    assert answer["robot"]["units"] == "m"
    assert np.shape(answer["table"]["fold"]["axis"]) == (2, 2)
    assert np.shape(answer["robot"]["fold"]["axis"]) == (2, 3)
    assert set(answer["table"]["landmarks"]) == set(answer["landmarks"])


def test_without_a_plane_nothing_is_said_of_the_table(scene: Scene) -> None:
    outline = np.array(scene.truth["outline_image"])
    answer = foldrs.fit(outline, garment_type="towel")
    assert answer.table is None
    assert not {"table", "robot"} & set(answer.to_dict())


def test_an_outline_goes_with_a_plane(scene: Scene, plane: TablePlane) -> None:
    answer = foldrs.fit(np.array(scene.truth["outline_image"]), garment_type="towel", table=plane)
    assert answer.table is not None


def test_a_lens_is_straightened(scene: Scene) -> None:
    """The same scene through a distorting lens gives the same table points."""
    bent = Camera(scene.camera.matrix, LENS)
    x, y = np.meshgrid(np.arange(640.0), np.arange(480.0))
    way = bent.undistorted(np.column_stack([x.ravel(), y.ravel()])).reshape(480, 640, 2).astype(np.float32)
    photo = cv2.remap(scene.image, way[..., 0], way[..., 1], cv2.INTER_LINEAR, borderMode=cv2.BORDER_REFLECT)
    pose = scene.camera.pose.copy()
    pose[:3, 3] /= 100
    answer = foldrs.fit(photo, garment_type="towel", table=TablePlane.of_pose(bent, Pose(pose)))
    truth = TablePlane(np.linalg.inv(scene.camera.table_to_image)).to_table(scene.truth["outline_image"])
    assert answer.table is not None
    assert _core.outline_iou(answer.table.outline, truth) > 0.95


def test_pictures_are_drawn_from_above(result: foldrs.FitResult, scene: Scene, plane: TablePlane) -> None:
    assert result.from_above is not None
    assert result.from_above.picture is not None
    axes = draw_result(result, scene.image).axes
    expected = draw_result(result.from_above.result, result.from_above.picture).axes
    for drawn, wanted in zip(axes, expected, strict=True):
        assert drawn.get_xlim() == wanted.get_xlim()
        for one, other in zip(drawn.get_images(), wanted.get_images(), strict=True):
            np.testing.assert_array_equal(one.get_array(), other.get_array())
    paper = foldrs.fit(scene.image, garment_type="towel", table=plane, method="paper")
    assert draw_stages(paper, scene.image).axes


# -- files --

ROS = """
image_width: 640
image_height: 480
camera_name: head
camera_matrix: {rows: 3, cols: 3, data: [600, 0, 320, 0, 610.5, 239, 0, 0, 1]}
distortion_model: plumb_bob
distortion_coefficients: {rows: 1, cols: 5, data: [-0.28, 0.1, 0.001, -5e-4, 0.01]}
projection_matrix: {rows: 3, cols: 4, data: [600, 0, 320, 0, 0, 610.5, 239, 0, 0, 0, 1, 0]}
"""


def written_by_opencv(path: Path, **extra: NDArray[np.float64]) -> Path:
    storage = cv2.FileStorage(str(path), cv2.FILE_STORAGE_WRITE)
    storage.write("image_width", 640)
    storage.write("image_height", 480)
    storage.write("Camera_Matrix", MATRIX)
    storage.write("Distortion_Coefficients", LENS[:, None])
    for name, value in extra.items():
        storage.write(name, value)
    storage.release()
    return path


def test_a_camera_info_of_ros_is_read(tmp_path: Path) -> None:
    (tmp_path / "head.yaml").write_text(ROS)
    camera, pose = load_camera(tmp_path / "head.yaml")
    np.testing.assert_array_equal(camera.matrix, MATRIX)
    np.testing.assert_array_equal(camera.distortion, LENS)
    assert camera.size == (640, 480)
    assert pose is None


@pytest.mark.parametrize("suffix", [".yml", ".yaml", ".json"])
def test_calibrations_of_opencv_are_read(tmp_path: Path, suffix: str) -> None:
    rvec, tvec = np.array([[0.5], [0.1], [0.0]]), np.array([[0.0], [0.2], [1.5]])
    camera, pose = load_camera(written_by_opencv(tmp_path / f"c{suffix}", rvec=rvec, tvec=tvec))
    np.testing.assert_array_equal(camera.matrix, MATRIX)
    np.testing.assert_array_equal(camera.distortion, LENS)
    assert pose is not None
    np.testing.assert_allclose(pose.matrix, Pose.of_vectors(rvec, tvec).matrix)


def test_a_pose_may_be_a_matrix_or_vectors_in_any_unit(tmp_path: Path) -> None:
    pose = Pose.of_vectors([0.5, 0, 0], [0.1, 0.2, 1.5])
    files: dict[str, Any] = {
        "list.json": json.dumps(pose.matrix.tolist()),
        "named.json": json.dumps({"table_pose": pose.matrix.tolist()}),
        "vectors.yaml": "rvec: [0.5, 0, 0]\ntvec: [100, 200, 1500]\nunits: mm\n",
        "plain.txt": "\n".join(" ".join(map(str, row)) for row in pose.matrix),
    }
    for name, text in files.items():
        (tmp_path / name).write_text(text)
    np.save(tmp_path / "array.npy", pose.matrix)
    for name in (*files, "array.npy"):
        np.testing.assert_allclose(load_pose(tmp_path / name).matrix, pose.matrix, err_msg=name)


def test_a_homography_is_read_in_every_form(tmp_path: Path) -> None:
    matrix = np.array([[0.25, 0.01, -3], [0.0, 0.3, 2], [0.0001, 0.0, 1]])
    (tmp_path / "list.json").write_text(json.dumps(matrix.tolist()))
    (tmp_path / "named.json").write_text(json.dumps({"homography": matrix.tolist()}))
    (tmp_path / "flat.yaml").write_text(f"H: {matrix.ravel().tolist()}")
    (tmp_path / "plain.csv").write_text("\n".join(", ".join(map(str, row)) for row in matrix))
    np.save(tmp_path / "array.npy", matrix)
    for path in sorted(tmp_path.iterdir()):
        np.testing.assert_allclose(load_homography(path).homography, matrix, err_msg=path.name)


BAD_FILES = {
    "missing": (load_homography, None, "", "cannot be read"),
    "singular": (load_homography, "1 0 0\n0 1 0\n1 1 0", "homography", "no inverse"),
    "shape": (load_homography, "[[1, 2], [3, 4]]", "homography", "3 x 3"),
    "words": (load_homography, '{"homography": "as usual"}', "homography", "no matrix"),
    "other": (load_homography, '{"camera_matrix": [1]}', "homography", "no field homography"),
    "infinite": (load_homography, "[[1, 0, 0], [0, .inf, 0], [0, 0, 1]]", "homography", "infinity"),
    "broken": (load_camera, "camera_matrix: [1, 2", "", "neither JSON nor YAML"),
    "no camera": (load_camera, "image_width: 640", "camera_matrix", "camera_info"),
    "fisheye": (
        load_camera,
        ROS.replace("plumb_bob", "equidistant"),
        "distortion_model",
        "undistort",
    ),
    "coefficients": (
        load_camera,
        ROS.replace("cols: 5", "cols: 3").replace(", -5e-4, 0.01]", "]"),
        "distortion_coefficients",
        "holds 3 numbers",
    ),
    "rows": (load_camera, ROS.replace("{rows: 3, cols: 3", "{rows: 2, cols: 3"), "camera_matrix", "matrix"),
    "focal": (load_camera, ROS.replace("[600, 0, 320", "[-600, 0, 320"), "camera_matrix", "focal"),
    "half a pose": (load_camera, ROS + "rvec: [0, 0, 0]", "tvec", "both"),
    "no pose": (load_pose, "{}", "pose", "4 x 4"),
    "scaled": (load_pose, "2 0 0 0\n0 2 0 0\n0 0 2 0\n0 0 0 1", "pose", "rigid"),
    "mirrored": (load_pose, "-1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1", "pose", "rigid"),
    "units": (load_pose, "rvec: [0, 0, 0]\ntvec: [0, 0, 1]\nunits: inch", "units", "cm"),
}


@pytest.mark.parametrize("name", BAD_FILES)
def test_a_bad_file_is_refused_with_file_field_and_advice(tmp_path: Path, name: str) -> None:
    load, text, field, word = BAD_FILES[name]
    path = tmp_path / "bad.yaml"
    if text is not None:
        path.write_text(text)
    with pytest.raises(CalibrationError, match=word) as raised:
        load(path)
    assert raised.value.field == field
    assert str(raised.value).startswith(str(path))


def test_no_array_and_no_text_are_refused(tmp_path: Path) -> None:
    (tmp_path / "bad.npy").write_bytes(b"no array")
    (tmp_path / "bad.txt").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(CalibrationError, match="NumPy"):
        load_homography(tmp_path / "bad.npy")
    with pytest.raises(CalibrationError, match="text"):
        load_homography(tmp_path / "bad.txt")


# -- what contradicts itself --


def test_contradictions_are_refused(scene: Scene, plane: TablePlane) -> None:
    for known, word in (
        ({"table": plane, "px_per_cm": 4.0}, "px_per_cm"),
        ({"table": plane, "camera": CAMERA}, "camera"),
        ({"camera": CAMERA}, "pose"),
        ({"robot_base": Pose(np.eye(4))}, "robot"),
    ):
        with pytest.raises(ParameterError, match=word):
            foldrs.fit(scene.image, **known)


def test_a_camera_of_another_size_is_refused(scene: Scene) -> None:
    plane = TablePlane.of_pose(Camera(MATRIX, size=(1280, 960)), Pose.of_vectors([0, 0, 0], [0, 0, 1.5]))
    with pytest.raises(CalibrationError, match="1280 x 960"):
        foldrs.fit(scene.image, table=plane)


def test_a_table_behind_the_camera_is_refused() -> None:
    with pytest.raises(CalibrationError, match="behind"):
        TablePlane.of_pose(CAMERA, Pose.of_vectors([0, 0, 0], [0, 0, -1.5]))


# -- commands --


def test_homography_camera_and_robot_base_by_command(scene: Scene, tmp_path: Path) -> None:
    scene.write(tmp_path, "towel")
    (tmp_path / "base.json").write_text(json.dumps(np.diag([1.0, -1, -1, 1]).tolist()))
    answers = []
    for how in ("homography", "camera"):
        done = command(
            tmp_path / "towel.jpg",
            f"--{how}",
            tmp_path / f"towel.{how}.json",
            "--robot-base",
            tmp_path / "base.json",
            "--out",
            tmp_path / how,
            "--plot",
        )
        assert done.exit_code == 0, done.output
        assert (tmp_path / how / "towel.png").is_file()
        answers.append(json.loads((tmp_path / how / "towel.json").read_text()))
    first, second = (answer["table"]["outline"] for answer in answers)
    np.testing.assert_allclose(first, second, atol=1e-3)
    pair = answers[0]["robot"]["grasp_pairs"][0]["points"]
    on_table = np.array(answers[0]["table"]["grasp_pairs"][0]["points"]) / 100
    np.testing.assert_allclose(pair, np.column_stack([on_table * [1, -1], np.zeros(2)]), atol=1e-5)


def test_the_pose_may_lie_in_a_second_file(scene: Scene, tmp_path: Path) -> None:
    scene.write(tmp_path, "towel")
    whole = json.loads((tmp_path / "towel.camera.json").read_text())
    pose = {name: whole.pop(name) for name in ("rvec", "tvec", "units")}
    (tmp_path / "camera.json").write_text(json.dumps(whole))
    (tmp_path / "pose.json").write_text(json.dumps(pose))
    done = command(
        tmp_path / "towel.jpg", "--camera", tmp_path / "camera.json", "--table-pose", tmp_path / "pose.json"
    )
    assert done.exit_code == 0, done.output
    alone = command(tmp_path / "towel.jpg", "--camera", tmp_path / "camera.json")
    assert alone.exit_code == 1
    assert "pose" in alone.stderr


@pytest.mark.parametrize(
    "options",
    [
        ("--homography", "h.json", "--a4"),
        ("--homography", "h.json", "--camera", "c.json"),
        ("--marker", "5", "--a4"),
        ("--marker-family", "aruco-4x4"),
        ("--table-pose", "p.json"),
    ],
)
def test_options_that_contradict_are_refused(options: tuple[str, ...]) -> None:
    done = command("photo.jpg", *options)
    assert done.exit_code == 2
    assert "Traceback" not in done.output


def test_a_bad_homography_stops_the_command_before_anything_is_written(tmp_path: Path) -> None:
    (tmp_path / "h.json").write_text("{}")
    done = command("photo.jpg", "--homography", tmp_path / "h.json", "--out", tmp_path / "out")
    assert done.exit_code == 1
    assert "homography" in done.output
    assert not (tmp_path / "out").exists()


# -- scenes and their evaluation --


def test_a_scene_at_an_angle_is_the_scene_from_above_seen_otherwise(scene: Scene) -> None:
    above = make_scene(TOWEL, seed=5, parameters=replace(TILTED, tilt_deg=0.0))
    assert above.truth["axis_garment"] == scene.truth["axis_garment"]
    seen = cv2.perspectiveTransform(np.array([above.truth["outline_image"]]), scene.camera.from_above)[0]
    np.testing.assert_allclose(seen, scene.truth["outline_image"], atol=0.02)
    cloth = np.zeros(scene.mask.shape, np.uint8)
    cv2.fillPoly(cloth, [np.round(seen).astype(np.int32).reshape(-1, 1, 2)], 255)
    assert np.count_nonzero(cloth != scene.mask) < 0.03 * np.count_nonzero(cloth)


def test_evaluation_measures_scenes_at_an_angle_from_above(scene: Scene, tmp_path: Path) -> None:
    scene.write(tmp_path, "towel")
    (loaded,) = load_scenes(tmp_path)
    assert loaded.plane is not None
    known = Evaluation("generic", [TOWEL]).run(loaded)
    assert known.error == ""
    assert known.right
    assert known.segmentation_iou > 0.95
    assert known.unfolded_iou > 0.9
    true_outline = Evaluation("generic", [TOWEL], true_outlines=True).run(loaded)
    assert true_outline.segmentation_iou == pytest.approx(1.0, abs=1e-6)
    ignored = Evaluation("generic", [TOWEL], 4.0, calibrated=False).run(loaded)
    assert ignored.segmentation_iou == pytest.approx(known.segmentation_iou, abs=1e-6)
    assert ignored.unfolded_iou < known.unfolded_iou
