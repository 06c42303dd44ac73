"""Depth images: the table's plane, the garment by its height, rims as steps, and what is refused."""

from __future__ import annotations

import errno
import struct
import zlib
from dataclasses import asdict, replace
from pathlib import Path

import cv2
import numpy as np
import pytest
from click.testing import CliRunner
from hypothesis import given, settings
from hypothesis import strategies as st

import foldrs
from foldrs import _core
from foldrs.camera import Camera
from foldrs.cli import main
from foldrs.depth import cloth_by_height, heights_above_table, read_depth
from foldrs.errors import DepthError, ImageTooLargeError, NoGarmentError, ParameterError
from foldrs.joint_fit import flexible_template
from foldrs.parameters import (
    DepthParameters,
    MatchingParameters,
    OutlineParameters,
    Parameters,
    PictureParameters,
)
from foldrs.picture import colour_edges, with_heights
from foldrs.synth import Scene, SynthParameters, make_scene
from foldrs.template import builtin_templates

PARAMETERS = DepthParameters()
TOWEL = builtin_templates("towel")[0]
SCENE = SynthParameters(scenarios=("corner",), tilt_deg=25, depth=True, thickness_cm=(0.3, 0.3))


@pytest.fixture(scope="module")
def scene() -> Scene:
    return make_scene(TOWEL, seed=2, parameters=SCENE)


@settings(max_examples=25)
@given(st.floats(-0.5, 0.5), st.floats(-0.5, 0.5), st.floats(0.5, 2.0), st.integers(0, 1000))
def test_the_table_is_found_under_things_that_lie_on_it(
    x: float, y: float, distance: float, seed: int
) -> None:
    matrix = np.array([[300.0, 0, 80], [0, 300, 60], [0, 0, 1]])
    normal = cv2.Rodrigues(np.array([x, y, 0]))[0][:, 2]
    u, v = np.meshgrid(np.arange(160.0), np.arange(120.0))
    rays = np.stack([(u - 80) / 300, (v - 60) / 300, np.ones_like(u)], axis=-1)
    depth = distance / (rays @ normal)
    depth[30:80, 40:100] *= 0.98
    depth += np.random.default_rng(seed).normal(0, 0.001 * distance, depth.shape)
    heights = heights_above_table(depth.astype(np.float32), None, PARAMETERS)
    np.testing.assert_allclose(
        np.linalg.inv(matrix).T @ normal / distance, heights.inverse_depth, rtol=0.02, atol=1e-4
    )
    assert np.median(heights.above[40:70, 50:90]) > 10
    assert abs(np.median(heights.above[:20])) < 1


def test_depth_and_camera_tell_the_plane(scene: Scene) -> None:
    assert scene.depth is not None
    camera = Camera(scene.camera.matrix)
    plane = heights_above_table(scene.depth, camera, PARAMETERS).plane(camera)
    outline = np.array(scene.truth["outline_image"])
    truth = cv2.perspectiveTransform(outline[None], np.linalg.inv(scene.camera.table_to_image))[0]
    assert abs(_core.signed_area(plane.to_table(outline))) == pytest.approx(
        abs(_core.signed_area(truth)), rel=0.02
    )
    assert _core.signed_area(plane.to_table(outline)) * _core.signed_area(outline) < 0  # z out of the table


def test_the_garment_is_told_by_its_height(scene: Scene) -> None:
    assert scene.depth is not None
    heights = heights_above_table(scene.depth, None, PARAMETERS)
    mask = cloth_by_height(heights, scene.mask.shape, PARAMETERS, OutlineParameters())
    assert mask is not None
    cloth = scene.mask > 0
    assert np.count_nonzero(mask & cloth) / np.count_nonzero(mask | cloth) > 0.95


def test_cloth_of_the_tables_colour_is_found_by_depth(scene: Scene) -> None:
    grey = np.full_like(scene.image, 128)
    noise = np.random.default_rng(0).integers(-3, 4, grey.shape)
    picture = (grey + noise).astype(np.uint8)
    with pytest.raises(NoGarmentError):
        foldrs.fit(picture, garment_type="towel")
    result = foldrs.fit(picture, garment_type="towel", depth=scene.depth, px_per_cm=4.0)
    assert _core.outline_iou(result.outline_image, np.array(scene.truth["outline_image"])) > 0.93


def test_where_depth_shows_nothing_the_colours_tell(scene: Scene) -> None:
    table, _ = scene.camera.depth_of_table((640, 480))
    noisy = table / 100 + np.random.default_rng(0).normal(0, 0.002, table.shape)
    heights = heights_above_table(noisy.astype(np.float32), None, PARAMETERS)
    assert cloth_by_height(heights, (480, 640), PARAMETERS, OutlineParameters()) is None
    result = foldrs.fit(scene.image, garment_type="towel", depth=noisy)
    assert _core.outline_iou(result.outline_image, np.array(scene.truth["outline_image"])) > 0.95


def test_camera_and_depth_need_nothing_else(scene: Scene) -> None:
    result = foldrs.fit(
        scene.image, garment_type="towel", camera=Camera(scene.camera.matrix), depth=scene.depth
    )
    assert result.table is not None
    truth = cv2.perspectiveTransform(
        np.array([scene.truth["outline_image"]]), np.linalg.inv(scene.camera.table_to_image)
    )[0]
    assert abs(_core.signed_area(result.table.outline)) == pytest.approx(
        abs(_core.signed_area(truth)), rel=0.05
    )


def test_steps_show_rims_that_colours_do_not() -> None:
    """A picture of one colour with a step in height across it: the step is an edge, and only there."""
    picture = np.full((120, 160, 3), 90, np.uint8)
    heights = np.zeros((120, 160), np.float32)
    heights[:, 80:] = 5.0
    edges = with_heights(colour_edges(picture, PictureParameters()), heights, 0.5)
    assert edges.steps is not None
    assert edges.steps.shape == edges.tensor.shape
    strength = edges.steps[:, :, 0]
    assert strength[:, 79:81].min() > 100
    assert strength[:, :70].max() == strength[:, 90:].max() == 0
    assert edges.tensor.max() == 0


def test_steps_are_evidence_for_the_fold(scene: Scene) -> None:
    """Heights raise what the true explanation gains from the picture, whichever layer is on top."""
    gains = []
    for depth in (None, scene.depth):
        result = foldrs.fit(scene.image, garment_type="towel", px_per_cm=4.0, depth=depth)
        gains.append(result.matching_cost)
    assert gains[1] < gains[0]


# -- files and bad input --


def test_every_kind_of_file_gives_metres(tmp_path: Path) -> None:
    metres = np.linspace(0.5, 2.0, 48 * 64, dtype=np.float32).reshape(48, 64)
    millimetres = np.round(metres * 1000).astype(np.uint16)
    cv2.imwrite(str(tmp_path / "a.png"), millimetres)
    cv2.imwrite(str(tmp_path / "b.tiff"), millimetres)
    cv2.imwrite(str(tmp_path / "c.tiff"), metres)
    np.save(tmp_path / "d.npy", metres)
    for path in sorted(tmp_path.iterdir()):
        np.testing.assert_allclose(read_depth(path), metres, atol=6e-4, err_msg=path.name)
    np.testing.assert_allclose(read_depth(millimetres), metres, atol=6e-4)


def test_what_was_not_measured_is_unknown() -> None:
    depth = read_depth(np.array([[0, 1000], [2000, 3000]], np.uint16))
    np.testing.assert_array_equal(np.isnan(depth), [[True, False], [False, False]])
    assert np.isnan(read_depth(np.array([[np.inf, -1.0, np.nan, 1.0]]))).sum() == 3


def test_holes_in_the_depth_do_no_harm(scene: Scene) -> None:
    assert scene.depth is not None
    holed = scene.depth.copy()
    holed[np.random.default_rng(0).random(holed.shape) < 0.2] = 0
    heights = heights_above_table(read_depth(holed), None, PARAMETERS)
    mask = cloth_by_height(heights, scene.mask.shape, PARAMETERS, OutlineParameters())
    assert mask is not None
    cloth = scene.mask > 0
    assert np.count_nonzero(mask & cloth) / np.count_nonzero(mask | cloth) > 0.94


@pytest.mark.parametrize(
    ("name", "content", "word"),
    [
        ("none.png", None, "no such"),
        ("text.png", b"no image", "no image"),
        ("text.npy", b"no array", "NumPy"),
        ("empty.png", b"", "no image"),
    ],
)
def test_bad_files_are_refused(tmp_path: Path, name: str, content: bytes | None, word: str) -> None:
    if content is not None:
        (tmp_path / name).write_bytes(content)
    with pytest.raises(DepthError, match=word):
        read_depth(tmp_path / name)


def test_large_files_are_refused_by_their_headers(tmp_path: Path) -> None:
    metres = np.ones((30, 40), np.float32)
    np.save(tmp_path / "d.npy", metres)
    cv2.imwrite(str(tmp_path / "d.tiff"), metres)
    for path in tmp_path.iterdir():
        with pytest.raises(ImageTooLargeError, match="40 x 30"):
            read_depth(path, max_pixels=1000)
        assert read_depth(path, max_pixels=1200).shape == (30, 40)
    # What ends after its header is no array, though the header tells of one.
    path = tmp_path / "d.npy"
    path.write_bytes(path.read_bytes()[:128])
    with pytest.raises(DepthError, match="NumPy"):
        read_depth(path)


def test_bad_arrays_are_refused() -> None:
    for values, word in (
        (np.zeros((4, 4, 3), np.uint16), "shape"),
        (np.zeros((4, 4), np.uint8), "16-bit"),
        (np.zeros((4, 4), np.uint16), "no measurement"),
    ):
        with pytest.raises(DepthError, match=word):
            read_depth(values)


def test_depth_without_a_table_is_refused() -> None:
    random = np.random.default_rng(0).uniform(0.5, 5.0, (120, 160)).astype(np.float32)
    with pytest.raises(DepthError, match="no table"):
        heights_above_table(random, None, PARAMETERS)


def test_depth_of_another_size_is_refused(scene: Scene) -> None:
    assert scene.depth is not None
    with pytest.raises(DepthError, match="aligned"):
        foldrs.fit(scene.image, depth=scene.depth[:200])


def test_depth_goes_with_a_photograph(scene: Scene) -> None:
    with pytest.raises(ParameterError, match="photograph"):
        foldrs.fit(np.array(scene.truth["outline_image"]), depth=scene.depth)


def test_depth_by_command(scene: Scene, tmp_path: Path) -> None:
    scene.write(tmp_path, "towel")
    photo, depth = str(tmp_path / "towel.jpg"), str(tmp_path / "towel.depth.tiff")
    done = CliRunner().invoke(main, ["fit", "--type", "towel", photo, "--depth", depth])
    assert done.exit_code == 0, done.output
    two = CliRunner().invoke(main, ["fit", photo, photo, "--depth", depth])
    assert two.exit_code == 2
    assert "single" in two.output
    large = CliRunner().invoke(main, ["fit", photo, "--depth", depth, "--max-pixels", "1000"])
    assert large.exit_code == 1
    assert "towel.depth.tiff has" in large.output


def test_the_same_scene_without_depth_looks_the_same(scene: Scene) -> None:
    plain = make_scene(TOWEL, seed=2, parameters=replace(SCENE, depth=False))
    np.testing.assert_array_equal(plain.image, scene.image)
    assert plain.depth is None


def test_tensors_of_two_shapes_are_refused() -> None:
    parameters = asdict(MatchingParameters())
    seen = _core.Seen(TOWEL.outline * 4 + 200, parameters)
    flexible = flexible_template(TOWEL, parameters)
    colours, steps = np.zeros((40, 60, 3), np.float32), np.zeros((40, 50, 3), np.float32)
    picture = (colours, 1.0, steps, None)
    with pytest.raises(ValueError, match="one shape"):
        _core.fit_jointly(seen, [TOWEL.outline], [flexible], 1, False, 4.0, picture)


def png_header(width: int, height: int) -> bytes:
    """A PNG file that claims to be of this size and 16 bits deep, and holds next to nothing."""
    content = b""
    header = struct.pack(">IIBBBBB", width, height, 16, 0, 0, 0, 0)
    for name, data in ((b"IHDR", header), (b"IDAT", zlib.compress(bytes(9))), (b"IEND", b"")):
        content += struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))
    return b"\x89PNG\r\n\x1a\n" + content


def test_a_too_large_depth_image_is_refused_undecoded(
    scene: Scene, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "large.png"
    path.write_bytes(png_header(40_000, 40_000))
    monkeypatch.setattr(cv2, "imdecode", lambda *_: pytest.fail("it was decoded"))
    with pytest.raises(ImageTooLargeError, match=r"large\.png has 40000 x 40000"):
        read_depth(path)
    path.write_bytes(png_header(2_000, 2_000))
    with pytest.raises(ImageTooLargeError, match="3999999 allowed"):
        read_depth(path, 3_999_999)
    outline = replace(OutlineParameters(), max_pixels=scene.image.shape[0] * scene.image.shape[1])
    with pytest.raises(ImageTooLargeError, match=r"large\.png"):
        foldrs.fit(scene.image, depth=path, parameters=Parameters(outline=outline))


def test_a_depth_image_that_opencv_refuses_is_refused_in_our_words(tmp_path: Path) -> None:
    (tmp_path / "large.png").write_bytes(png_header(40_000, 40_000))  # more than OpenCV takes
    with pytest.raises(DepthError, match="no image"):
        read_depth(tmp_path / "large.png", None)


def test_a_depth_image_that_may_not_be_read_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refused(path: Path) -> bytes:
        raise PermissionError(errno.EACCES, "Permission denied", str(path))

    (tmp_path / "locked.png").write_bytes(b"x")
    monkeypatch.setattr(Path, "read_bytes", refused)
    with pytest.raises(DepthError, match=r"locked\.png: cannot be read .Permission denied"):
        read_depth(tmp_path / "locked.png")
    with pytest.raises(DepthError, match="cannot be read"):
        read_depth(tmp_path / ("x" * 5000 + ".png"))
