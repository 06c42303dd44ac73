"""Scenes of real cloth: what is seen of a garment is its own photograph, upon the table of one."""

from __future__ import annotations

import json
from pathlib import Path

import cv2
import numpy as np
import pytest
from click.testing import CliRunner

from foldrs.cli import main
from foldrs.errors import ImageNotFoundError, ParameterError
from foldrs.image import read_image, read_mask
from foldrs.synth import Garment, SynthParameters, garment_from_outline, make_scene, make_scenes

LEFT, RIGHT = (200, 40, 40), (40, 40, 200)
"""Colours of the halves of the cloth, RGB."""

PLAIN = SynthParameters(
    shape_cm=0.0,
    asymmetry_cm=0.0,
    stretch=0.0,
    bow=0.0,
    size_range=(1.0, 1.0),
    noise=0.0,
    light=0.0,
    vignette=0.0,
    warmth=0.0,
    shadow=0.0,
)
"""Scenes whose colours are those of the photographs, but for the brightness of all."""

OUTLINE = [[60, 90], [260, 90], [260, 230], [60, 230]]
MARKS = {name: np.array(point, float) for name, point in zip("abcd", OUTLINE, strict=True)}


def photograph(path: Path, table: tuple[int, int, int]) -> Path:
    """A cloth, red on the left and blue on the right, that covers its outline to the pixel."""
    picture = np.empty((320, 320, 3), np.uint8)
    picture[:] = table
    picture[90:231, 60:160] = LEFT
    picture[90:231, 160:261] = RIGHT
    cv2.imwrite(str(path), picture[..., ::-1])
    return path


def sheet(path: Path) -> Garment:
    return garment_from_outline(OUTLINE, MARKS, "sheet", size_cm=60, photograph=path)


def hue(colour: np.ndarray) -> np.ndarray:
    return np.asarray(colour / np.linalg.norm(colour))


def test_cloth_lies_where_it_lay_in_the_photograph(tmp_path: Path) -> None:
    garment = sheet(photograph(tmp_path / "a.png", (150, 170, 150)))
    scene = make_scene(garment, seed=2, parameters=SynthParameters(**{**vars(PLAIN), "folds": 0}))
    mean = {}
    for name, expected in (("left", LEFT), ("right", RIGHT)):
        corners = [scene.truth["landmarks"][k]["image"] for k in ("ad" if name == "left" else "bc")]
        inwards = np.mean(scene.truth["outline_image"], axis=0) - np.mean(corners, axis=0)
        x, y = (np.mean(corners, axis=0) + 0.5 * inwards).round().astype(int)
        mean[name] = scene.image[y - 3 : y + 4, x - 3 : x + 4].reshape(-1, 3).mean(axis=0)
        assert hue(mean[name]) @ hue(np.array(expected, float)) > 0.995
    rim = np.array(scene.truth["outline_image"])
    inside = rim.mean(axis=0) + 0.97 * (rim - rim.mean(axis=0))  # no table within the rim
    colours = np.array([scene.image[y, x] for x, y in inside.round().astype(int)], float)
    ends = np.array([hue(mean["left"]), hue(mean["right"])])
    alike = (colours / np.linalg.norm(colours, axis=1, keepdims=True)) @ ends.T
    assert (alike.max(axis=1) > 0.97).mean() > 0.95


def test_the_table_is_one_of_the_photographs_that_the_cloth_stands_out_from(tmp_path: Path) -> None:
    alike = sheet(photograph(tmp_path / "alike.png", (120, 40, 120)))
    other = sheet(photograph(tmp_path / "other.png", (60, 220, 60)))
    assert other.photograph is not None
    assert alike.photograph is not None
    for seed in range(4):
        tables = [alike.photograph, other.photograph]
        scene = make_scene(alike, seed=seed, parameters=PLAIN, tables=tables)
        table = scene.image[scene.mask == 0].reshape(-1, 3).astype(float)
        green = (table[:, 1] > 2 * table[:, 0]) & (table[:, 1] > 2 * table[:, 2])
        assert green.mean() > 0.9


def test_a_photograph_that_shows_no_table_gets_a_drawn_one(tmp_path: Path) -> None:
    path = photograph(tmp_path / "close.png", (0, 255, 0))
    close = np.array(OUTLINE) - (60, 90)
    cv2.imwrite(str(path), read_image(path)[90:231, 60:261, ::-1])
    marks = {name: point - (60, 90) for name, point in MARKS.items()}
    garment = garment_from_outline(close, marks, "sheet", size_cm=60, photograph=path)
    for seed in range(3):
        scene = make_scene(garment, seed=seed, parameters=PLAIN)
        table = scene.image[scene.mask == 0].reshape(-1, 3)
        assert (table.max(axis=1) > 20).all()  # light falls on all of it
        cloth = scene.image[scene.mask > 0].reshape(-1, 3)
        assert distance(table, cloth) > 15  # and it is another colour, as of any drawn scene


def distance(a: np.ndarray, b: np.ndarray) -> float:
    means = np.array([a.mean(axis=0), b.mean(axis=0)], np.float32).reshape(1, 2, 3) / 255
    lab = cv2.cvtColor(means, cv2.COLOR_RGB2Lab)
    return float(np.linalg.norm(lab[0, 0] - lab[0, 1]))


def test_sets_of_real_cloth_do_not_depend_on_the_number_of_jobs(tmp_path: Path) -> None:
    garments = [
        sheet(photograph(tmp_path / f"{name}.png", table))
        for name, table in (("a", (150, 170, 150)), ("b", (230, 230, 220)))
    ]
    written = [
        make_scenes(garments, 4, 7, tmp_path / str(jobs), parameters=PLAIN, jobs=jobs) for jobs in (1, 2)
    ]
    for one, two in zip(*written, strict=True):
        assert one.read_bytes() == two.read_bytes()
        assert one.with_suffix(".jpg").read_bytes() == two.with_suffix(".jpg").read_bytes()


def test_a_photograph_that_is_gone_is_named(tmp_path: Path) -> None:
    garment = sheet(tmp_path / "gone.jpg")
    with pytest.raises(ImageNotFoundError, match=r"gone\.jpg"):
        make_scene(garment, seed=1, parameters=PLAIN)


def test_an_outline_of_another_photograph_is_told(tmp_path: Path) -> None:
    path = photograph(tmp_path / "a.png", (150, 170, 150))
    beyond = np.array(OUTLINE) + 1000
    garment = garment_from_outline(beyond, {}, "sheet", size_cm=60, photograph=path)
    with pytest.raises(ParameterError, match="same size"):
        make_scene(garment, seed=1, parameters=PLAIN)


def foldrs(*arguments: object) -> str:
    done = CliRunner().invoke(main, [str(argument) for argument in arguments])
    return f"{done.exit_code} {done.output}"


def test_command_takes_photographs(tmp_path: Path) -> None:
    photograph(tmp_path / "a.png", (150, 170, 150))
    entry = {
        "type": "sheet",
        "image": "a.png",
        "outline": OUTLINE,
        "landmarks": {name: point.tolist() for name, point in MARKS.items()},
        "size_cm": 60,
    }
    (tmp_path / "real.json").write_text(json.dumps([entry]))
    options = ["synth", "--outlines", tmp_path / "real.json", "--photos", tmp_path, "--count", 2, "--jobs", 1]
    told = foldrs(*options, "--out", tmp_path / "scenes")
    assert told.startswith("0"), told
    for path in (tmp_path / "scenes").glob("*.json"):
        truth = json.loads(path.read_text())
        ring = np.array(truth["outline_garment"]) / truth["px_per_cm"]
        across, down = np.ptp(ring, axis=0)
        assert across / down == pytest.approx(200 / 140, rel=0.03)  # its shape is left as it is
        cloth = read_image(path.with_suffix(".jpg"))[read_mask(path.with_suffix(".mask.png"))]
        blue_or_red = np.abs(cloth[:, 0].astype(int) - cloth[:, 2]) > 60
        assert blue_or_red.mean() > 0.8


def test_command_says_which_photograph_is_missing(tmp_path: Path) -> None:
    entry = {"type": "sheet", "image": "b.png", "outline": OUTLINE, "landmarks": {}, "size_cm": 60}
    (tmp_path / "real.json").write_text(json.dumps([entry]))
    told = foldrs(
        "synth", "--outlines", tmp_path / "real.json", "--photos", tmp_path, "--out", tmp_path / "scenes"
    )
    assert told.startswith("1")
    assert "outline 0" in told
    assert "b.png" in told
    assert not (tmp_path / "scenes").exists()
    alone = foldrs("synth", "--photos", tmp_path, "--out", tmp_path / "scenes")
    assert alone.startswith("2")
    assert "--outlines" in alone
