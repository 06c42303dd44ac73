"""From photograph or outline to the answer: right on scenes of known truth, the same however it is asked."""

from __future__ import annotations

import json
import math
import subprocess
import sys
from functools import cache
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

import foldrs
from foldrs import _core
from foldrs.errors import ParameterError
from foldrs.parameters import GraspParameters
from foldrs.result import FitResult
from foldrs.synth import Scene, SynthParameters, make_scene
from foldrs.template import builtin_templates, save_template

Points = NDArray[np.float64]

KINDS = sorted({template.garment_type for template in builtin_templates()})
PX_PER_CM = 3.0
SCENE = SynthParameters(
    image_size=(480, 360), px_per_cm=PX_PER_CM, tables=("plain", "wood"), cloths=("plain", "stripes")
)
SQUARE = [[0, 0], [90, 0], [90, 60], [0, 60]]
RIGHT = 0.1  # largest dA of a crease that counts as right, as in the paper


@cache
def drawn(kind: str, seed: int) -> Scene:
    """A garment of the kind, another than the template, folded somewhere."""
    return make_scene(builtin_templates(kind)[0], seed=seed, parameters=SCENE)


def outline_of(scene: Scene) -> Points:
    return np.array(scene.truth["outline_image"])


def axis_error(scene: Scene, axis: Points) -> float:
    """Area between an axis and the true crease, as a share of the unfolded garment's."""
    garment = abs(_core.signed_area(np.array(scene.truth["unfolded_image"])))
    return _core.axis_difference(axis, np.array(scene.truth["axis_image"])) / garment


def is_right(scene: Scene, result: FitResult) -> bool:
    kind_right = result.garment_type == scene.truth["type"]
    return kind_right and axis_error(scene, result.fold.axis_image) < RIGHT


def ends_apart(one: Points, other: Points) -> float:
    """Largest distance between the ends of two axes, in whichever order."""
    return float(min(np.linalg.norm(one - ends, axis=1).max() for ends in (other, other[::-1])))


@pytest.mark.parametrize(
    ("options", "kind_given", "seeds", "floor"),
    [
        ({}, True, (1, 2), 9),
        ({"px_per_cm": PX_PER_CM}, True, (1, 2), 9),
        ({}, False, (1,), 4),
        ({"method": "paper"}, True, (1,), 3),
    ],
    ids=["kind given", "kind and scale given", "nothing given", "as published"],
)
def test_most_folds_are_found_on_the_outline(
    options: dict[str, Any], kind_given: bool, seeds: tuple[int, ...], floor: int
) -> None:
    right = 0
    for kind in KINDS:
        for scene in (drawn(kind, seed) for seed in seeds):
            given = {"garment_type": kind} if kind_given else {}
            right += is_right(scene, foldrs.fit(outline_of(scene), **given, **options))
    assert right >= floor


def test_most_folds_are_found_in_the_picture() -> None:
    right = 0
    for kind in KINDS:
        scene = drawn(kind, 1)
        right += is_right(scene, foldrs.fit(scene.image, garment_type=kind))
    assert right >= 4


def test_landmarks_lie_where_they_are() -> None:
    errors = []
    for kind in KINDS:
        scene = drawn(kind, 1)
        result = foldrs.fit(outline_of(scene), garment_type=kind, px_per_cm=PX_PER_CM)
        truth = {name: np.array(mark["image"]) for name, mark in scene.truth["landmarks"].items()}
        assert set(result.landmarks) == set(truth)
        # A garment's two halves look alike: left and right may be told the other way round.
        swapped = {a: b for pair in builtin_templates(kind)[0].symmetry for a, b in (pair, pair[::-1])}
        as_named = {name: name for name in truth}
        errors.append(
            min(
                np.median(
                    [np.linalg.norm(result.landmarks[names[name]].image - truth[name]) for name in truth]
                )
                for names in (as_named, as_named | swapped)
            )
        )
    assert np.median(errors) < 3.0 * PX_PER_CM


@pytest.mark.parametrize("method", ["best", "paper"])
@pytest.mark.parametrize("kind", ["pants", "shirt", "skirt"])
def test_a_fold_is_accepted_only_where_there_is_one(kind: str, method: Any) -> None:
    flat = builtin_templates(kind)[0].outline * 4.0 + 50.0
    assert not foldrs.fit(flat, garment_type=kind, method=method).accepted
    assert foldrs.fit(outline_of(drawn(kind, 1)), garment_type=kind, method=method).accepted


def plain(result: FitResult) -> dict[str, Any]:
    """The answer without what may differ from run to run, and without the file's name."""
    return {k: v for k, v in result.to_dict().items() if k not in ("seconds", "timings", "image")}


def test_points_of_every_type_and_layout_give_the_same_answer() -> None:
    points = np.round(outline_of(drawn("pants", 1))).astype(np.int32)
    want = plain(foldrs.fit(points.astype(np.float64), garment_type="pants"))
    read_only = points.astype(np.float64)
    read_only.flags.writeable = False
    for given in (
        points,
        points[:, None, :],
        points.astype(np.float32),
        points.astype(np.int64).tolist(),
        [tuple(point) for point in points],
        np.asfortranarray(points.astype(np.float64)),
        np.repeat(points, 2, axis=1)[:, ::2],
        np.vstack([points, points[:1]]),
        read_only,
    ):
        assert plain(foldrs.fit(given, garment_type="pants")) == want


@pytest.mark.parametrize("kind", ["pants", "towel"])
def test_neither_winding_nor_first_point_matters_much(kind: str) -> None:
    scene = drawn(kind, 1)
    outline = outline_of(scene)
    for given in (outline, outline[::-1], np.roll(outline, len(outline) // 3, axis=0)):
        assert is_right(scene, foldrs.fit(given, garment_type=kind))


def test_the_answer_moves_and_grows_with_the_outline() -> None:
    outline = outline_of(drawn("skirt", 1))
    here = foldrs.fit(outline, garment_type="skirt").fold.axis_image
    there = foldrs.fit(2.0 * outline + [300.0, -200.0], garment_type="skirt").fold.axis_image
    assert ends_apart(2.0 * here + [300.0, -200.0], there) < 1.0


def test_pictures_of_every_source_give_the_same_answer(tmp_path: Path) -> None:
    scene = drawn("skirt", 1)
    path = scene.write(tmp_path, "skirt", suffix=".png").with_suffix(".png")
    rgba = np.dstack([scene.image, np.full(scene.image.shape[:2], 255, np.uint8)])
    want = plain(foldrs.fit(path, garment_type="skirt"))
    for given in (str(path), scene.image, scene.image.astype(np.uint16) * 257, rgba):
        assert plain(foldrs.fit(given, garment_type="skirt")) == want


def test_masks_of_every_source_give_the_same_answer(tmp_path: Path) -> None:
    scene = drawn("skirt", 1)
    cv2.imwrite(str(tmp_path / "mask.png"), scene.mask)
    want = plain(foldrs.fit(scene.image, mask=scene.mask > 0, garment_type="skirt"))
    for mask in (scene.mask, scene.mask / 255, tmp_path / "mask.png", str(tmp_path / "mask.png")):
        assert plain(foldrs.fit(scene.image, mask=mask, garment_type="skirt")) == want


@pytest.mark.parametrize("method", ["best", "paper"])
def test_any_number_of_threads_gives_the_same_answer(tmp_path: Path, method: str) -> None:
    images = []
    for kind in ("skirt", "pants"):
        drawn(kind, 1).write(tmp_path, kind)
        images.append(tmp_path / f"{kind}.jpg")
    answers = []
    for jobs in (1, 2, 8):
        out = tmp_path / f"{len(answers)}"
        options = ["--out", out, "--jobs", str(jobs), "--method", method, "--type", "skirt"]
        subprocess.run([Path(sys.executable).with_name("foldrs"), "fit", *images, *options], check=True)
        told = [json.loads((out / f"{image.stem}.json").read_text()) for image in images]
        answers.append([{k: v for k, v in one.items() if k not in ("seconds", "timings")} for one in told])
    assert answers.count(answers[0]) == len(answers)


def test_asking_again_gives_the_same_answer() -> None:
    outline = outline_of(drawn("t-shirt", 1))
    assert plain(foldrs.fit(outline)) == plain(foldrs.fit(outline))


def check_points(value: Any, count: int | None = None) -> None:
    """Check a list of [x, y], finite floats."""
    assert isinstance(value, list)
    assert len(value) >= 3 if count is None else len(value) == count
    for point in value:
        assert len(point) == 2
        assert all(isinstance(number, float) and math.isfinite(number) for number in point)


def check_template(value: Any, kind: str) -> None:
    assert set(value) >= {"outline", "landmarks", "axis"}
    check_points(value["outline"])
    check_points(value["axis"], 2)
    check_points(list(value["landmarks"].values()), len(value["landmarks"]))
    assert list(value["landmarks"]) == list(builtin_templates(kind)[0].landmarks)


def check_answer(answer: Any) -> None:
    """Check the JSON form field by field."""
    kind = answer["garment_type"]
    assert answer["schema"] == 1
    assert kind in KINDS
    assert isinstance(answer["image"], str)
    assert isinstance(answer["accepted"], bool)
    assert answer["seconds"] > 0
    assert math.isfinite(answer["matching_cost"])
    assert all(seconds >= 0 for seconds in answer["timings"].values())
    assert sum(answer["timings"].values()) <= answer["seconds"] + 1e-6
    check_points(answer["outline_image"])
    check_points(answer["unfolded_outline_image"])
    check_points(answer["fold"]["axis_image"], 2)
    assert answer["folds"][-1]["axis_image"] == answer["fold"]["axis_image"]
    for fold in answer["folds"]:
        check_points(fold["axis_image"], 2)
        check_points(fold["axis_template"], 2)
    check_template(answer["original_template"], kind)
    check_template(answer["template"], kind)

    assert list(answer["landmarks"]) == list(answer["template"]["landmarks"])
    for mark in answer["landmarks"].values():
        check_points([mark["image"]], 1)
        assert isinstance(mark["accessible"], bool)
    for pair in answer["grasp_pairs"]:
        marks = [answer["landmarks"][name] for name in pair["landmarks"]]
        assert all(mark["accessible"] for mark in marks)
        assert pair["image"] == [mark["image"] for mark in marks]

    chosen, *others = answer["alternatives"]
    assert chosen["garment_type"] == kind
    assert chosen["fold"]["axis_image"] == answer["fold"]["axis_image"]
    assert chosen["template"] == answer["template"]
    probabilities = [other["probability"] for other in answer["alternatives"]]
    assert all(0 <= probability <= 1 for probability in probabilities)
    assert sum(probabilities) <= 1 + 1e-9
    for other in others:
        check_points(other["fold"]["axis_image"], 2)
        check_template(other["template"], other["garment_type"])


@pytest.mark.parametrize("method", ["best", "paper"])
@pytest.mark.parametrize("kind", ["t-shirt", "towel"])
def test_the_written_answer_keeps_the_contract(tmp_path: Path, kind: str, method: Any) -> None:
    scene = drawn(kind, 1)
    cv2.imwrite(str(tmp_path / f"{kind}.png"), scene.image[..., ::-1])
    cv2.imwrite(str(tmp_path / "mask.png"), scene.mask)
    result = foldrs.fit(
        tmp_path / f"{kind}.png", mask=tmp_path / "mask.png", garment_type=kind, method=method
    )
    result.save(tmp_path / "answer.json")

    def refuse(constant: str) -> None:
        raise AssertionError(f"{constant} is no JSON")

    answer = json.loads((tmp_path / "answer.json").read_text(), parse_constant=refuse)
    assert answer["image"] == f"{kind}.png"
    check_answer(answer)


def test_the_answer_in_python_is_made_of_the_promised_types() -> None:
    result = foldrs.fit(outline_of(drawn("t-shirt", 1)), garment_type="t-shirt")
    for array, columns in (
        (result.outline_image, 2),
        (result.unfolded_outline_image, 2),
        (result.fold.axis_image, 2),
        (result.fold.axis_template, 2),
        (result.template.outline, 2),
        (result.template.axis, 2),
        (result.original_template.axis, 2),
        *((pair.image, 2) for pair in result.grasp_pairs),
        *((crease, 2) for crease in result.candidate_creases),
    ):
        assert array.dtype == np.float64
        assert array.shape[1:] == (columns,)
        assert np.isfinite(array).all()
    for mark in result.landmarks.values():
        assert mark.image.shape == (2,)
        assert mark.image.dtype == np.float64
        assert type(mark.accessible) is bool
    assert type(result.accepted) is bool
    assert type(result.matching_cost) is float
    assert type(result.garment_type) is str
    assert all(type(other.probability) is float for other in result.alternatives)
    assert result.image == ""
    assert result.seconds > 0


def test_the_candidate_creases_are_sides_of_the_outline() -> None:
    result = foldrs.fit(outline_of(drawn("t-shirt", 1)), garment_type="t-shirt")
    assert result.candidate_creases
    size = math.sqrt(abs(_core.signed_area(result.outline_image)))
    for crease in result.candidate_creases:
        _, distance, _ = _core.nearest_on_outline(result.outline_image, crease)
        assert distance.max() < 0.1 * size


def test_numpy_scalars_are_numbers_too() -> None:
    outline = outline_of(drawn("pants", 1))
    want = plain(foldrs.fit(outline, garment_type="pants", px_per_cm=3.0))
    for scale in (np.float32(3), np.int64(3), 3):
        assert plain(foldrs.fit(outline, garment_type=np.str_("pants"), px_per_cm=scale)) == want


@pytest.mark.parametrize("scale", ["4", [4], np.array([4.0]), True, 4j])
def test_a_scale_that_is_no_number_is_refused(scale: Any) -> None:
    with pytest.raises(ParameterError, match="px_per_cm must be a positive number"):
        foldrs.fit(SQUARE, px_per_cm=scale)


@pytest.mark.parametrize("templates", [3, [3], [None], [{}], {}, {"type": "towel"}, b"towel.json", [b"a"]])
def test_what_is_no_template_is_refused(templates: Any) -> None:
    with pytest.raises(ParameterError, match="templates"):
        foldrs.fit(SQUARE, templates=templates)


def test_one_template_needs_no_list(tmp_path: Path) -> None:
    (towel,) = builtin_templates("towel")
    path = tmp_path / "towel.json"
    save_template(towel, path)
    want = plain(foldrs.fit(SQUARE, templates=[towel]))
    for one in (towel, path, str(path)):
        assert plain(foldrs.fit(SQUARE, templates=one)) == want


@pytest.mark.parametrize("parameters", [3, {}, "best", GraspParameters()])
def test_parameters_of_another_type_are_refused(parameters: Any) -> None:
    with pytest.raises(ParameterError, match="parameters"):
        foldrs.fit(SQUARE, parameters=parameters)


@pytest.mark.parametrize("number", [np.int64(2), np.uint8(2), np.array(2)], ids=lambda n: type(n).__name__)
def test_whole_numbers_of_any_type_are_numbers_of_folds(number: Any) -> None:
    outline = outline_of(drawn("towel", 1))
    answers = [foldrs.fit(outline, garment_type="towel", folds=folds) for folds in (2, number)]
    assert len(answers[0].folds) == 2
    assert plain(answers[0]) == plain(answers[1])


@pytest.mark.parametrize("number", [True, False, np.True_, 1.0, np.float64(1), "1", None, -1, 5, "Auto"])
def test_what_is_no_number_of_folds_is_refused(number: Any) -> None:
    with pytest.raises(ParameterError, match="folds must be a whole number"):
        foldrs.fit(outline_of(drawn("towel", 1)), garment_type="towel", folds=number)
