"""Bad input is refused by name, with a sentence that helps, and never at the expense of the good."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from click.testing import CliRunner, Result
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

import foldrs
from conftest import simple_polygons
from foldrs import _core, pipeline
from foldrs._mending import simple_outline
from foldrs.cli import main
from foldrs.errors import (
    FoldrsError,
    GarmentCutOffError,
    GarmentCutOffWarning,
    GarmentTooSmallError,
    ImageNotFoundError,
    InvalidOutlineError,
    NoGarmentError,
    NoHypothesisError,
    NotAnImageError,
    OutlineError,
    ParameterError,
    SeveralGarmentsError,
    TemplateError,
)
from foldrs.parameters import Parameters
from foldrs.synth import Scene, SynthParameters, make_scene
from foldrs.template import builtin_templates, save_template

SCENE = SynthParameters(image_size=(320, 240), px_per_cm=2.5, tables=("plain",), cloths=("plain",))
TOWEL = builtin_templates("towel")[0]


def command(*arguments: object) -> Result:
    return CliRunner().invoke(main, ["fit", "--type", "towel", *(str(argument) for argument in arguments)])


@pytest.fixture(scope="module")
def scene() -> Scene:
    """A towel in the middle of a plain table."""
    return make_scene(TOWEL, seed=3, parameters=SCENE)


@pytest.fixture(scope="module")
def outline(scene: Scene) -> NDArray[np.float64]:
    return np.array(scene.truth["outline_image"])


def bad_pictures(scene: Scene) -> dict[str, tuple[type[FoldrsError], str, NDArray[np.uint8]]]:
    """Pictures by what is wrong with them, with the error and a word of its sentence."""
    y, x = np.nonzero(scene.mask)
    middle_x, middle_y = int(x.mean()), int(y.mean())
    cloth = scene.image[middle_y - 12 : middle_y + 12, middle_x - 16 : middle_x + 16]
    noise = np.random.default_rng(0).integers(0, 256, scene.image.shape).astype(np.uint8)
    return {
        "one colour": (NoGarmentError, "one colour", np.full_like(scene.image, 120)),
        "noise": (NoGarmentError, "another colour", noise),
        "all cloth": (NoGarmentError, "another colour", np.tile(cloth, (6, 6, 1))),
        "two alike": (SeveralGarmentsError, "one garment", np.hstack([scene.image, scene.image])),
        "cut off": (GarmentCutOffError, "shows all of it", scene.image[:, middle_x:]),
        "one pixel": (GarmentTooSmallError, "larger", scene.image[:1, :1]),
    }


PICTURES = ("one colour", "noise", "all cloth", "two alike", "cut off", "one pixel")


@pytest.mark.parametrize("flaw", PICTURES)
def test_pictures_without_one_whole_garment(scene: Scene, flaw: str) -> None:
    error, words, picture = bad_pictures(scene)[flaw]
    with pytest.raises(error, match=words):
        foldrs.fit(picture)
    with pytest.raises(ValueError, match=words):
        foldrs.fit(picture)


def test_files_that_are_no_pictures(tmp_path: Path, scene: Scene) -> None:
    with pytest.raises(ImageNotFoundError, match="check the name"):
        foldrs.fit(tmp_path / "nowhere.jpg")
    with pytest.raises(FileNotFoundError, match="folder"):
        foldrs.fit(tmp_path)
    (tmp_path / "text.jpg").write_text("no picture")
    (tmp_path / "empty.png").touch()
    cv2.imwrite(str(tmp_path / "whole.png"), scene.image)
    (tmp_path / "half.png").write_bytes((tmp_path / "whole.png").read_bytes()[:30])
    for name in ("text.jpg", "empty.png", "half.png"):
        with pytest.raises(NotAnImageError, match=name):
            foldrs.fit(tmp_path / name)
        with pytest.raises(NotAnImageError, match=name):
            foldrs.fit(scene.image, mask=tmp_path / name)


def test_masks_without_one_whole_garment(scene: Scene) -> None:
    mask = scene.mask > 0
    middle = int(np.nonzero(mask)[1].mean())
    for error, bad in (
        (NoGarmentError, np.zeros_like(mask)),
        (NoGarmentError, np.ones_like(mask)),
        (SeveralGarmentsError, np.hstack([mask, mask])),
        (GarmentCutOffError, mask[:, middle:]),
        (GarmentTooSmallError, np.pad(np.ones((4, 4), bool), 20)),
    ):
        with pytest.raises(error):
            foldrs.fit(bad)
    with pytest.raises(OutlineError, match="size"):
        foldrs.fit(scene.image, mask=mask[1:])
    with pytest.raises(OutlineError, match="leave one out"):
        foldrs.fit(mask, mask=mask)


@pytest.mark.parametrize(
    ("source", "error", "words"),
    [
        (np.full((40, 50, 3), np.nan), NotAnImageError, "NaN"),
        (np.full((40, 50), -1), NotAnImageError, "negative"),
        (np.zeros((0, 50, 3), np.uint8), NotAnImageError, "empty"),
        (np.zeros((3, 40, 50)), NotAnImageError, "channels last"),
        (None, NotAnImageError, "real numbers"),
        ([[1, 2], [3]], InvalidOutlineError, "no array"),
        ([["a", "b"]] * 4, InvalidOutlineError, "no numbers"),
        (np.ones((4, 2), complex), InvalidOutlineError, "real numbers"),
        (np.zeros((0, 2)), InvalidOutlineError, "at least three"),
        ([[0, 0], [9, 0]], InvalidOutlineError, "at least three"),
        ([[0, 0], [9, 0], [0, 0]], InvalidOutlineError, "at least three"),
        ([[0, 0], [9, 0], [9, 9], [np.nan, 9]], InvalidOutlineError, "NaN"),
        ([[0, 0], [9, 0], [9, 9], [np.inf, 9]], InvalidOutlineError, "infinity"),
        ([[0, 0], [5, 0], [9, 0]], InvalidOutlineError, "no area"),
        ([[0, 0], [0, 1], [9e7, 1e300]], InvalidOutlineError, "1e[+]300"),
        ([[5, 5]] * 9, InvalidOutlineError, "three points"),
        ([[0, 0], [9, 9], [9, 0], [0, 9]], InvalidOutlineError, "no area"),
        ([[0, 0], [9, 9], [9, 0], [0, 6]], InvalidOutlineError, "edges 0 and 2 of the outline cross"),
        ([[0, 0], [9, 4], [18, 0], [18, 9], [9, 3], [0, 9]], InvalidOutlineError, "cross"),
    ],
)
def test_arrays_that_are_neither_picture_nor_outline(
    source: Any, error: type[FoldrsError], words: str
) -> None:
    with pytest.raises(error, match=words):
        foldrs.fit(source)


def test_points_in_no_order(outline: NDArray[np.float64]) -> None:
    with pytest.raises(InvalidOutlineError, match="in their order"):
        foldrs.fit(np.random.default_rng(0).permutation(outline))


def flawed_outlines(outline: NDArray[np.float64]) -> dict[str, NDArray[np.float64]]:
    """Outlines with the flaws that tracing leaves; the shape can still be told."""
    thread = np.vstack([outline[:5], outline[4] + [80, 0], outline[4], outline[5:]])
    return {
        "doubled points": np.repeat(outline, 3, axis=0),
        "closed": np.vstack([outline, outline[:1]]),
        "a thread out and back": thread,
        "a spike across": np.insert(outline, 5, outline[4] + [40, -60], axis=0),
        "noise": outline + np.random.default_rng(0).normal(0, 1, outline.shape),
        "neighbours swapped": np.vstack([outline[:7], outline[8], outline[7], outline[9:]]),
    }


@pytest.mark.parametrize(
    "flaw",
    ["doubled points", "closed", "a thread out and back", "a spike across", "noise", "neighbours swapped"],
)
def test_small_flaws_of_an_outline_are_mended(outline: NDArray[np.float64], flaw: str) -> None:
    result = foldrs.fit(flawed_outlines(outline)[flaw], garment_type="towel")
    _core.check_outline(result.outline_image)
    assert _core.outline_iou(result.outline_image, outline) > 0.95
    json.dumps(result.to_dict(), allow_nan=False)


def test_outlines_of_any_size_and_place(outline: NDArray[np.float64]) -> None:
    plain = foldrs.fit(outline, garment_type="towel")
    for moved in (outline * 1e6, outline * 1e-6, outline + 1e6):
        assert foldrs.fit(moved, garment_type="towel").accepted == plain.accepted
    with pytest.raises(NoHypothesisError, match="scale"):
        foldrs.fit(outline * 1e6, garment_type="pants", px_per_cm=4.0)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"px_per_cm": 0}, "positive"),
        ({"px_per_cm": -4.0}, "positive"),
        ({"px_per_cm": float("nan")}, "positive"),
        ({"px_per_cm": float("inf")}, "positive"),
        ({"garment_type": "ballgown"}, "t-shirt"),
        ({"garment_type": "towel", "templates": []}, "none"),
        ({"garment_type": "ballgown", "templates": [TOWEL]}, "towel"),
        ({"folds": -1}, "whole number"),
        ({"folds": 9}, "whole number"),
        ({"folds": 1.5}, "whole number"),
        ({"folds": "many"}, "whole number"),
        ({"folds": 2, "method": "paper"}, "undoes one fold"),
        ({"method": "guess"}, "best, paper"),
    ],
)
def test_options_out_of_range(outline: NDArray[np.float64], options: dict[str, Any], words: str) -> None:
    with pytest.raises((ParameterError, TemplateError), match=words):
        foldrs.fit(outline, **options)
    with pytest.raises(ValueError, match=words):
        foldrs.fit(outline, **options)


def template_fields() -> dict[str, Any]:
    """The towel's template file."""
    return {
        "schema": 1,
        "type": "towel",
        "units": "cm",
        "outline": TOWEL.outline.tolist(),
        "landmarks": {name: point.tolist() for name, point in TOWEL.landmarks.items()},
        "grasp_pairs": [],
    }


def bad_templates() -> dict[str, tuple[str, str]]:
    """Template files by what is wrong with them: the text, and a word of the error's sentence."""
    crossing, off, unknown, nan = (template_fields() for _ in range(4))
    crossing["outline"][0], crossing["outline"][1] = crossing["outline"][1], crossing["outline"][0]
    off["landmarks"]["corner_1"] = [500.0, 500.0]
    unknown["grasp_pairs"] = [["corner_1", "sleeve"]]
    nan["outline"][0][0] = float("nan")
    few = {**template_fields(), "outline": [[0, 0], [50, 0]]}
    return {
        "crossing": (json.dumps(crossing), "outline"),
        "landmark off": (json.dumps(off), "corner_1"),
        "unknown landmark": (json.dumps(unknown), "sleeve"),
        "NaN": (json.dumps(nan), "outline"),
        "two points": (json.dumps(few), "outline"),
        "no JSON": ("{", "JSON"),
        "a list": ("[]", "object"),
    }


@pytest.mark.parametrize(
    "flaw", ["crossing", "landmark off", "unknown landmark", "NaN", "two points", "no JSON", "a list"]
)
def test_bad_template_files(tmp_path: Path, outline: NDArray[np.float64], scene: Scene, flaw: str) -> None:
    text, words = bad_templates()[flaw]
    (tmp_path / "mine.json").write_text(text)
    with pytest.raises(TemplateError, match=words):
        foldrs.fit(outline, templates=[tmp_path / "mine.json"])
    scene.write(tmp_path, "towel")
    done = command(tmp_path / "towel.jpg", "--template", tmp_path / "mine.json", "--out", tmp_path / "out")
    assert done.exit_code == 1
    assert "mine.json" in done.stderr
    assert words in done.stderr
    assert not (tmp_path / "out").exists()


def test_a_template_file_that_is_missing(tmp_path: Path, outline: NDArray[np.float64]) -> None:
    with pytest.raises(FoldrsError, match=r"nowhere\.json"):
        foldrs.fit(outline, templates=[tmp_path / "nowhere.json"])


@pytest.fixture
def photos(tmp_path: Path, scene: Scene) -> Path:
    """A folder with towel.jpg and every bad picture, and files that are none."""
    scene.write(tmp_path, "towel")
    for flaw, (_, _, picture) in bad_pictures(scene).items():
        cv2.imwrite(str(tmp_path / f"{flaw}.png"), picture[..., ::-1])
    (tmp_path / "text.jpg").write_text("no picture")
    (tmp_path / "folder.jpg").mkdir()
    return tmp_path


def test_one_good_picture_among_bad_ones(photos: Path, scene: Scene, tmp_path: Path) -> None:
    bad = [*(f"{flaw}.png" for flaw in PICTURES), "text.jpg", "folder.jpg", "nowhere.jpg"]
    done = command(*(photos / name for name in [*bad[:4], "towel.jpg", *bad[4:]]), "--out", tmp_path / "out")
    assert done.exit_code == 1
    assert [line.split(":")[0] for line in done.stdout.splitlines()] == ["towel.jpg"]
    *reports, total = done.stderr.splitlines()
    errors = tmp_path / "out" / "errors.jsonl"
    assert total == f"{len(bad)} of {len(bad) + 1} images failed, listed in {errors}"
    listed = [json.loads(line) for line in errors.read_text().splitlines()]
    assert sorted(entry["image"] for entry in listed) == sorted(str(photos / name) for name in bad)
    assert {f"{entry['image']}: {entry['message']}" for entry in listed} == set(reports)
    assert sorted(line.split(": ")[0] for line in reports) == sorted(str(photos / name) for name in bad)
    for flaw, (_, words, _) in bad_pictures(scene).items():
        (report,) = (line for line in reports if f"{flaw}.png" in line)
        assert words in report
    assert {path.name for path in (tmp_path / "out").iterdir()} == {"towel.json", "errors.jsonl"}
    assert json.loads((tmp_path / "out" / "towel.json").read_text())["garment_type"] == "towel"


def test_a_defect_costs_one_image_only(photos: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    works = pipeline.fit

    def fit(image: Path, **options: Any) -> Any:
        if image.name == "text.jpg":
            raise IndexError("beyond the end")
        return works(image, **options)

    monkeypatch.setattr(pipeline, "fit", fit)
    done = command(photos / "text.jpg", photos / "towel.jpg", "--out", tmp_path / "out")
    assert done.exit_code == 1
    assert f"{photos / 'text.jpg'}: IndexError: beyond the end" in done.stderr
    assert {path.name for path in (tmp_path / "out").iterdir()} == {"towel.json", "errors.jsonl"}


def test_a_garment_at_the_border_is_named_in_the_warning(tmp_path: Path, scene: Scene) -> None:
    touching = scene.image[:, np.nonzero(scene.mask)[1].min() + 2 :]
    for name in ("one.png", "two.png"):
        cv2.imwrite(str(tmp_path / name), touching[..., ::-1])
    with pytest.warns(GarmentCutOffWarning, match="border"):
        foldrs.fit(tmp_path / "one.png", garment_type="towel")
    done = command(tmp_path / "one.png", tmp_path / "two.png")
    assert done.exit_code == 0
    reports = sorted(done.stderr.splitlines())
    assert [line.split(": ")[:2] for line in reports] == [
        [str(tmp_path / name), "warning"] for name in ("one.png", "two.png")
    ]


def test_results_are_written_whole_or_not_at_all(photos: Path, tmp_path: Path) -> None:
    (tmp_path / "out" / "towel.json").mkdir(parents=True)  # a folder where the result should go
    done = command(photos / "towel.jpg", "--out", tmp_path / "out")
    assert done.exit_code == 1
    assert "towel.jpg: " in done.stderr
    assert {path.name for path in (tmp_path / "out").iterdir()} == {"towel.json", "errors.jsonl"}
    assert not list((tmp_path / "out" / "towel.json").iterdir())


def test_no_folder_can_be_made(photos: Path, tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    done = command(photos / "towel.jpg", "--out", tmp_path / "file" / "out")
    assert done.exit_code == 1
    assert "Traceback" not in done.output
    assert "file" in done.stderr


def test_results_never_overwrite_each_other_or_what_is_read(tmp_path: Path, scene: Scene) -> None:
    for folder, suffix in (("a", ".jpg"), ("b", ".png")):
        scene.write(tmp_path / folder, "towel", suffix=suffix)
    save_template(TOWEL, tmp_path / "b" / "sheet.json")
    before = {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()}
    jpg, png = tmp_path / "a" / "towel.jpg", tmp_path / "b" / "towel.png"
    sheet = tmp_path / "b" / "sheet.png"
    for arguments, words in (
        ([jpg, png, "--out", tmp_path / "out"], "both"),
        ([jpg, jpg, "--out", tmp_path / "out"], "both"),
        ([jpg, "a/towel.stages.jpg", "--plot-stages", "--out", tmp_path / "out"], "both"),
        ([png, "--plot", "--out", tmp_path / "b"], "overwritten"),
        ([sheet, "--template", tmp_path / "b" / "sheet.json", "--out", tmp_path / "b"], "overwritten"),
    ):
        done = command(*arguments)
        assert done.exit_code == 2
        assert words in done.stderr
    assert {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()} == before
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("options", "status", "words"),
    [
        (["--folds", "9"], 1, "whole number"),
        (["--folds", "auto", "--method", "paper"], 1, "undoes one fold"),
        (["--folds", "many"], 2, "auto"),
        (["--px-per-cm", "nan"], 1, "px_per_cm"),
        (["--px-per-cm", "-1"], 1, "px_per_cm"),
        (["--mask", "nowhere.png"], 1, "nowhere.png"),
    ],
)
def test_options_of_the_command(photos: Path, options: list[str], status: int, words: str) -> None:
    done = command(photos / "towel.jpg", *options)
    assert done.exit_code == status
    assert words in done.stderr
    assert not done.stdout


def test_one_fold_may_be_asked_for(photos: Path, outline: NDArray[np.float64]) -> None:
    assert command(photos / "towel.jpg", "--folds", 1).exit_code == 0
    assert foldrs.fit(outline, garment_type="towel", folds=1).garment_type == "towel"


coordinates = st.floats(-1e9, 1e9) | st.integers(-5, 5).map(float) | st.sampled_from([np.nan, np.inf, 1e300])
any_points = st.lists(st.tuples(coordinates, coordinates), max_size=12)


@settings(max_examples=300)
@given(st.lists(st.tuples(st.integers(0, 6), st.integers(0, 6)), min_size=3, max_size=12))
def test_a_mended_outline_is_simple(points: list[tuple[int, int]]) -> None:
    outline = np.array(points, float)
    try:
        mended = simple_outline(outline)
    except InvalidOutlineError:
        return
    _core.check_outline(mended)
    assert abs(_core.signed_area(mended)) <= np.ptp(outline, axis=0).prod() * (1 + 1e-12)


@settings(max_examples=60)
@given(any_points, st.sampled_from([None, 3.0]))
def test_any_points_give_an_answer_or_a_named_error(
    points: list[tuple[float, float]], px_per_cm: float | None
) -> None:
    try:
        result = foldrs.fit(np.reshape(points, (-1, 2)), garment_type="towel", px_per_cm=px_per_cm)
    except FoldrsError:
        return
    json.dumps(result.to_dict(), allow_nan=False)


@settings(max_examples=15)
@given(simple_polygons, st.sampled_from(["towel", "pants"]))
def test_any_simple_outline_gives_an_answer_or_a_named_error(points: NDArray[np.float64], kind: str) -> None:
    try:
        result = foldrs.fit(points, garment_type=kind)
    except NoHypothesisError:
        return
    json.dumps(result.to_dict(), allow_nan=False)
    assert len(result.alternatives) >= 1


@pytest.mark.parametrize(
    ("group", "change"),
    [
        ("hypothesis", {"angle_bins": 0}),
        ("partial_match", {"points": 4}),
        ("partial_match", {"delta": 10**9}),
        ("fit", {"nodes": 0}),
        ("fit", {"bow": 0.0}),
        ("fit", {"noise": float("nan")}),
        ("shape_context", {"n_theta": 0}),
        ("rim", {"mislead": 2.0}),
    ],
)
@pytest.mark.parametrize("method", ["best", "paper"])
def test_parameters_out_of_range(group: str, change: dict[str, Any], method: Any) -> None:
    matching = Parameters().matching
    changed = replace(getattr(matching, group), **change)
    parameters = replace(Parameters(), matching=replace(matching, **{group: changed}))
    (name,) = change
    with pytest.raises(ParameterError, match=rf"{group}\.{name} must be"):
        foldrs.fit(TOWEL.outline, garment_type="towel", method=method, parameters=parameters)


@pytest.mark.parametrize("scale", [0.0, -1.0, float("nan")])
def test_the_core_refuses_a_scale_that_is_none(scale: float) -> None:
    seen = _core.Seen(TOWEL.outline, _core.default_parameters())
    with pytest.raises(ParameterError, match="scale"):
        seen.matches([TOWEL.outline], scale)


@pytest.mark.parametrize(
    ("group", "change", "words"),
    [
        ("outline", {"smoothing": 0.0}, "outline.smoothing must be positive"),
        ("outline", {"least_pixels": -1}, "outline.least_pixels must be 0 or"),
        ("outline", {"fine_side": 640.5}, "outline.fine_side must be a whole number"),
        ("picture", {"looks": 0}, "picture.looks must be positive"),
        ("picture", {"means_nothing": (1.0,)}, "picture.means_nothing must be 8 numbers"),
        ("grasp", {"clearance": float("nan")}, "grasp.clearance must be 0 or"),
        ("alternatives", {"nats": -1.0}, "alternatives.nats must be 0 or"),
        ("alternatives", {"most": True}, "alternatives.most must be a whole number"),
        ("depth", {"tolerance": "wide"}, "depth.tolerance must be a number"),
    ],
)
def test_parameters_of_the_stages_in_python_out_of_range(
    group: str, change: dict[str, Any], words: str
) -> None:
    parameters = replace(Parameters(), **{group: replace(getattr(Parameters(), group), **change)})
    with pytest.raises(ParameterError, match=words):
        foldrs.fit(TOWEL.outline, garment_type="towel", parameters=parameters)


def test_a_group_of_parameters_is_of_its_kind() -> None:
    parameters = replace(Parameters(), grasp=Parameters().depth)
    with pytest.raises(ParameterError, match="grasp must be a GraspParameters, not DepthParameters"):
        foldrs.fit(TOWEL.outline, garment_type="towel", parameters=parameters)


def test_what_may_be_nothing_may_be_zero() -> None:
    outline = replace(Parameters().outline, opening=0.0, cut_rounds=0, rim_rounds=0)
    grasp = replace(Parameters().grasp, clearance=0.0, ample=0.0, snap=0.0)
    made = make_scene(TOWEL, seed=3, parameters=SCENE)
    assert foldrs.fit(made.image, garment_type="towel", parameters=Parameters(outline=outline, grasp=grasp))


@pytest.mark.parametrize("scale", [1e-6, 1e4, 1e9])
def test_a_scale_far_off_is_refused_at_once(scale: float) -> None:
    with pytest.raises(NoHypothesisError, match="scale"):
        foldrs.fit(TOWEL.outline * 4, garment_type="towel", px_per_cm=scale)
