"""The evaluation: measures on hand-made cases, against the benchmark's scorer, and whole runs."""

from __future__ import annotations

import csv
import importlib.util
import io
import json
import math
import sys
from dataclasses import replace
from pathlib import Path
from types import ModuleType
from typing import Any

import click
import numpy as np
import pytest
from click.testing import CliRunner
from hypothesis import given
from hypothesis import strategies as st
from rich.console import Console
from shapely.geometry import Point, Polygon

from conftest import SHARED, simple_polygons
from foldrs.errors import ParameterError
from foldrs.evaluate_cli import evaluate_command
from foldrs.evaluation import (
    PROTOCOLS,
    Evaluation,
    Kind,
    Scene,
    SceneMeasures,
    TrueLandmark,
    failed,
    load_scenes,
    measure,
    print_tables,
    run_all,
    summary,
    table,
    virtual_scenes,
    write_csv,
    write_json,
)
from foldrs.evaluation.axes import axis_error, template_distance
from foldrs.evaluation.geometry import iou, iou_by_rigid_motion, mirrored, polygon, similarity
from foldrs.evaluation.landmarked import LandmarkedOutline
from foldrs.evaluation.reliability import reliability
from foldrs.evaluation.run import own_template
from foldrs.evaluation.search import SAME_NATS, missed_nats
from foldrs.pipeline import fit
from foldrs.synth import SynthParameters, make_scene
from foldrs.template import Template, builtin_templates

CM = 4.0  # px a cm of the hand-made scenes


def template(corners: Any, *, symmetry: Any = (), name: str = "sheet", order: Any = None) -> Template:
    """A template whose landmarks are its corners: a, b, c, ... in the order of the outline."""
    names = "abcdefgh"[: len(corners)]
    marks = {mark: np.array(corner, float) for mark, corner in zip(names, corners, strict=True)}
    marks = {mark: marks[mark] for mark in order or names}
    return Template(name, "sheet", "cm", np.array(corners, float), marks, symmetry, (("a", "b"),))


RECTANGLE = template([[0, 0], [60, 0], [60, 40], [0, 40]])
TRAPEZOID = template([[0, 0], [60, 0], [45, 40], [15, 40]])


def scene(of: Template = RECTANGLE, **changes: Any) -> Scene:
    """The right third of a sheet turned over; it lies in the picture as on the template."""
    folded = np.array([[0, 0], [40, 0], [40, 40], [0, 40]], float)
    marks = {name: TrueLandmark(p * CM, p * CM, True, True) for name, p in of.landmarks.items()}
    truth = Scene(
        "sheet-01", "sheet", "1", "by hand", CM, of.outline * CM, np.array([[40.0, 0], [40, 40]]) * CM,
        folded * CM, of.outline * CM, marks,
    )  # fmt: skip
    return replace(truth, **changes)


def prediction(truth: Scene, of: Template = RECTANGLE, **changes: Any) -> dict[str, Any]:
    """The right prediction of a scene, with changes."""
    fitted = {
        "outline": of.outline.tolist(),
        "landmarks": {name: p.tolist() for name, p in of.landmarks.items()},
        "axis": (truth.axis_garment / CM).tolist(),
    }
    crease = {"axis_image": truth.axis_garment.tolist()}
    right = {
        "garment_type": "sheet",
        "seconds": 0.5,
        "matching_cost": 0.3,
        "original_matching_cost": 0.4,
        "outline_image": truth.outline_image.tolist(),
        "fold": crease,
        "folds": [crease],
        "original_template": fitted,
        "template": fitted,
        "unfolded_outline_image": truth.unfolded_image.tolist(),
        "landmarks": {
            name: {"image": m.image.tolist(), "accessible": True} for name, m in truth.landmarks.items()
        },
        "grasp_pairs": [
            {"landmarks": ["a", "b"], "image": [truth.landmarks[m].image.tolist() for m in "ab"]}
        ],
        "alternatives": [{"garment_type": "sheet", "template": fitted}],
    }
    return {**right, **changes}


def with_axis(axis: Any, of: Template = RECTANGLE) -> dict[str, Any]:
    return {
        "outline": of.outline.tolist(),
        "landmarks": {name: p.tolist() for name, p in of.landmarks.items()},
        "axis": axis,
    }


SHEET = Kind.of([RECTANGLE], RECTANGLE.landmarks)


# Kinds: order and symmetries


def test_a_rectangle_has_the_symmetries_of_a_sheet_whatever_its_proportions():
    assert SHEET.landmarks == ("a", "b", "c", "d")
    assert len(SHEET.relabellings) == 8
    assert SHEET.relabellings[0] == (0, 1, 2, 3)


def test_what_tells_its_ends_apart_has_its_mirror_symmetry_only():
    assert Kind.of([TRAPEZOID], "abcd").relabellings == ((0, 1, 2, 3), (1, 0, 3, 2))


def test_a_symmetry_must_hold_for_every_template_of_the_kind():
    both = Kind.of([RECTANGLE, TRAPEZOID], "abcd")
    assert set(both.relabellings) == set(Kind.of([TRAPEZOID], "abcd").relabellings)


def test_three_landmarks_are_not_symmetric_because_an_affine_map_fits_any_three():
    right_angled = template([[0, 0], [40, 0], [0, 40]])
    assert set(Kind.of([right_angled], "abc").relabellings) == {(0, 1, 2), (0, 2, 1)}


def test_landmarks_alone_do_not_make_a_symmetry_the_whole_outline_does():
    corners = [[0, 0], [60, 0], [60, 40], [30, 10], [0, 40]]
    marks = {m: np.array(corners[k], float) for m, k in zip("abcd", (0, 1, 2, 4), strict=True)}
    notched = Template("v", "sheet", "cm", np.array(corners, float), marks)
    assert set(Kind.of([notched], "abcd").relabellings) == {(0, 1, 2, 3), (1, 0, 3, 2)}


def test_declared_pairs_are_a_symmetry_of_an_uneven_template():
    uneven = [[0, 0], [60, 0], [40, 65], [5, 20]]
    assert len(Kind.of([template(uneven)], "abcd").relabellings) == 1
    declared = template(uneven, symmetry=(("a", "b"), ("c", "d")))
    assert Kind.of([declared], "abcd").relabellings == ((0, 1, 2, 3), (1, 0, 3, 2))


def test_landmarks_are_ordered_along_the_outline_not_as_listed():
    shuffled = template(TRAPEZOID.outline, order="acdb")
    assert Kind.of([shuffled], "abcd").landmarks == ("a", "b", "c", "d")
    assert len(Kind.of([shuffled], "abcd").relabellings) == 2


@pytest.mark.parametrize(
    ("templates", "landmarks", "message"),
    [([], "abc", "no template"), ([RECTANGLE], "ab", "three landmarks"), ([RECTANGLE], "abcx", "lacks .* x")],
)
def test_kinds_that_cannot_be_measured_are_named(templates, landmarks, message):
    with pytest.raises(ParameterError, match=message):
        Kind.of(templates, landmarks)


# Geometry


@given(simple_polygons, st.booleans(), st.lists(st.floats(0, 0.999), min_size=1, max_size=5))
def test_places_lead_back_to_their_points_in_either_winding(outline, backwards, shares):
    marks = outline[:: max(1, len(outline) // 4)][:4]
    ring = LandmarkedOutline(outline[::-1] if backwards else outline, marks)
    corners = np.vstack([outline, outline[:1]])
    k = [int(share * len(outline)) for share in shares]
    t = np.array([share * len(outline) % 1 for share in shares])[:, None]
    points = corners[k] * (1 - t) + corners[np.array(k) + 1] * t
    np.testing.assert_allclose(ring.at(ring.locate(points)), points, atol=1e-6)


def test_a_place_keeps_its_share_of_the_way_between_landmarks():
    narrow = LandmarkedOutline(RECTANGLE.outline, RECTANGLE.landmark_array)
    wide = LandmarkedOutline(RECTANGLE.outline * [10, 1], RECTANGLE.landmark_array * [10, 1])
    places = narrow.locate(np.array([[15.0, 0], [60, 10]]))
    np.testing.assert_allclose(wide.at(places), [[150, 0], [600, 10]])
    np.testing.assert_allclose(wide.at_relabelled(places, (1, 0, 3, 2)), [[450, 0], [0, 10]])


@given(simple_polygons, st.floats(0.1, 10), st.floats(0, 6.3), st.booleans())
def test_similarity_is_found(points, scale, angle, reflecting):
    c, s, f = scale * np.cos(angle), scale * np.sin(angle), -1.0 if reflecting else 1.0
    true = np.array([[c, -s * f, 3.0], [s, c * f, -7.0]])
    moved = points @ true[:, :2].T + true[:, 2]
    np.testing.assert_allclose(similarity(points, moved, reflecting=reflecting), true, atol=1e-9)


def test_overlap_of_halves_and_of_a_copy_moved_rigidly():
    square = np.array([[0, 0], [100, 0], [100, 100], [0, 100]], float)
    assert iou(square, square + np.array([50, 0])) == pytest.approx(1 / 3)
    shape = np.array([[0, 0], [120, 0], [120, 30], [40, 30], [40, 90], [0, 90]], float)
    turned = mirrored(shape, np.array([[0.0, 0], [1, 0.3]])) + np.array([500, 20])
    assert iou(shape, turned) == 0
    assert iou_by_rigid_motion(shape, turned) > 0.98
    assert iou_by_rigid_motion(shape, 1.2 * turned) < 0.75  # no scaling


def test_of_an_outline_that_crosses_itself_the_largest_part_counts():
    assert polygon(np.array([[0, 0], [4, 4], [4, 0], [0, 2]], float)).area == pytest.approx(16 / 3, rel=0.5)
    assert polygon(np.array([[0, 0], [4, 4], [4, 0], [0, 2]], float)).is_valid


# One scene


def test_a_right_prediction_is_right_in_every_measure():
    row = measure(scene(), prediction(scene()), SHEET)
    assert (row.type_right, row.right, row.right_matched, row.right_in_first, row.pair_right) == (True,) * 5
    assert (row.axis_error, row.axis_angle) == pytest.approx((0, 0), abs=1e-4)
    assert (row.segmentation_iou, row.unfolded_iou) == pytest.approx((1, 1))
    assert row.landmarks_px == pytest.approx([0] * 4)
    assert row.cost_decrease == pytest.approx(25)
    assert row.mismatch is False


@pytest.mark.parametrize(
    ("axis", "share", "angle"),
    [
        ([[43, 0], [43, 40]], 3 * 40 / 2400, 0),
        ([[40, 0], [44, 40]], 4 * 40 / 2 / 2400, math.degrees(math.atan(0.1))),
        ([[40, 40], [40, 0]], 0, 0),  # an axis has no direction here
        ([[20, 0], [20, 40]], 0, 0),  # the left third of a sheet is as good as the right
        ([[0, 40 / 3], [60, 40 / 3]], 0, 0),  # and so is any third
    ],
)
def test_axis_error_by_hand(axis, share, angle):
    assert axis_error(scene(), with_axis(axis), SHEET) == pytest.approx((share, angle), abs=1e-4)


def test_ends_that_are_not_alike_are_not_interchanged():
    kind = Kind.of([TRAPEZOID], "abcd")
    near_top = scene(TRAPEZOID, axis_garment=np.array([[0, 0], [60, 0]]) * CM + [[15, 40], [-15, 40]])
    axis = near_top.axis_garment / CM
    assert axis_error(near_top, with_axis(axis, TRAPEZOID), kind)[0] == pytest.approx(0, abs=1e-6)
    near_bottom = [[11.25, 30], [48.75, 30]]
    assert axis_error(near_top, with_axis(near_bottom, TRAPEZOID), kind)[0] > 0.4


def test_which_part_was_turned_over_cannot_be_told():
    truth = scene()
    twin = mirrored(truth.unfolded_image, truth.axis_garment).tolist()
    assert measure(
        truth, prediction(truth, unfolded_outline_image=twin), SHEET
    ).unfolded_iou == pytest.approx(1)


def test_interchanged_landmarks_are_as_right():
    truth = scene()
    image = {m: {"image": truth.landmarks[p].image.tolist()} for m, p in zip("abcd", "cdab", strict=True)}
    row = measure(truth, prediction(truth, landmarks=image), SHEET)
    assert row.landmarks_px == pytest.approx([0] * 4)
    kind = Kind.of([TRAPEZOID], "abcd")
    assert min(measure(truth, prediction(truth, landmarks=image), kind).landmarks_px) > 30


@pytest.mark.parametrize(("off_cm", "right"), [(4.9, True), (5.1, False)])
def test_a_grasp_pair_is_right_within_the_margin(off_cm, right):
    truth = scene()
    image = [
        (truth.landmarks["a"].image + np.array([0, off_cm * CM])).tolist(),
        truth.landmarks["b"].image.tolist(),
    ]
    pair = [{"landmarks": ["a", "b"], "image": image}]
    assert measure(truth, prediction(truth, grasp_pairs=pair), SHEET).pair_right is right


def test_a_grasp_pair_must_be_accessible_and_be_there():
    truth = scene()
    hidden = {**truth.landmarks, "b": replace(truth.landmarks["b"], accessible=False)}
    assert measure(replace(truth, landmarks=hidden), prediction(truth), SHEET).pair_right is False
    assert measure(truth, prediction(truth, grasp_pairs=[]), SHEET).pair_right is False
    none = {m: replace(mark, accessible=False) for m, mark in truth.landmarks.items()}
    assert not measure(replace(truth, landmarks=none), prediction(truth), SHEET).pair_due


def test_a_mismatch_is_a_wrong_choice_beside_a_right_hypothesis():
    truth = scene()
    wrong, right = with_axis([[0, 0], [30, 40]]), with_axis([[40, 0], [40, 40]])
    chosen = {"garment_type": "sheet", "template": wrong}
    other = {"garment_type": "sheet", "template": right}
    for others, in_first, mismatch in (
        [[other], True, True],
        [[chosen] * 2 + [other], False, True],
        [[], False, False],
    ):
        row = measure(truth, prediction(truth, template=wrong, alternatives=[chosen, *others]), SHEET)
        assert (row.right, row.right_matched) == (False, True)
        assert (row.right_in_first, row.mismatch) == (in_first, mismatch)


def test_probabilities_are_compared_with_what_happened():
    truth = scene()
    wrong, right = with_axis([[0, 0], [30, 40]]), with_axis([[40, 0], [40, 40]])

    def told(first, *others):
        shares = (0.7, 0.2, 0.1)
        alternatives = [
            {"garment_type": "sheet", "template": one, "probability": p}
            for one, p in zip((first, *others), shares, strict=False)
        ]
        return measure(truth, prediction(truth, template=first, alternatives=alternatives), SHEET)

    # Of two alternatives with the right axis only the first is the right one.
    assert told(wrong, right, right).chances == ((0.7, False), (0.2, True), (0.1, False))
    rows = [told(right, wrong, wrong)] * 3 + [told(wrong, right, wrong)]
    low, middle, high = reliability(rows)
    assert (high.said, high.happened, high.cases) == pytest.approx((0.7, 0.75, 4))
    assert (middle.said, middle.happened, middle.cases) == pytest.approx((0.2, 0.25, 4))
    assert (low.said, low.happened, low.cases) == pytest.approx((0.1, 0.0, 4))
    (first,) = reliability(rows, first_only=True)
    assert first == high
    assert reliability([failed(truth, "no picture")]) == []


def test_another_kind_is_wrong_in_every_rate_but_may_be_among_the_first():
    truth = scene()
    other = {"garment_type": "sheet", "template": with_axis([[40, 0], [40, 40]])}
    row = measure(truth, prediction(truth, garment_type="sock", alternatives=[{}, other]), SHEET)
    assert (row.type_right, row.right, row.right_matched, row.pair_right) == (False,) * 4
    assert row.right_in_first
    assert row.unfolded_iou == 0
    assert row.segmentation_iou == pytest.approx(1)


def test_scenes_folded_twice_ask_for_the_creases_seen():
    truth = scene(creases=(np.array([[40.0, 0], [40, 40]]) * CM, np.array([[0.0, 0], [0, 40]]) * CM))
    row = measure(truth, prediction(truth), SHEET)
    assert row.creases_met == (True, False)
    assert (row.right, row.right_in_first, row.pair_right) == (None, None, None)
    assert row.unfolded_iou > 0.98


def test_scenes_not_folded_are_measured_as_they_lie():
    folded = scene()
    flat = scene(axis_garment=None, outline_image=folded.unfolded_image)
    as_flat = {"fold": None, "folds": [], "template": {**with_axis([[0, 0], [1, 1]]), "axis": None}}
    row = measure(flat, prediction(folded, **as_flat), SHEET)
    assert (row.folds, row.folds_found) == (0, 0)
    assert (row.right, row.right_in_first) == (None, None)
    assert row.unfolded_iou > 0.98
    assert max(row.landmarks_px) < 1e-6
    assert row.pair_right
    assert summary([row]).folds_rate == 100
    taken_for_folded = measure(flat, prediction(folded), SHEET)
    assert summary([row, taken_for_folded]).folds_rate == 50


def test_a_fold_taken_for_none_is_wrong_but_measured():
    truth = scene()
    flat = {**with_axis([[0, 0], [1, 1]]), "axis": None}
    told = prediction(truth, fold=None, folds=[], template=flat, original_template=flat, alternatives=[])
    row = measure(truth, told, SHEET)
    assert (row.right, row.right_in_first, row.folds_found) == (False, False, 0)


def test_distance_of_a_template_before_folding():
    assert template_distance(scene(), [RECTANGLE], SHEET) == pytest.approx(0, abs=1e-6)
    half_size = template(RECTANGLE.outline / 2)
    assert template_distance(scene(), [half_size], SHEET) == pytest.approx(0, abs=1e-6)
    square = template([[0, 0], [50, 0], [50, 50], [0, 50]])
    far = template_distance(scene(), [square], SHEET)
    assert 2 < far < 10
    assert template_distance(scene(), [square, RECTANGLE], SHEET) == pytest.approx(0, abs=1e-6)


# Tables


def rows() -> list[SceneMeasures]:
    right = measure(scene(), prediction(scene(), template=with_axis([[43, 0], [43, 40]])), SHEET)
    off = replace(right, scene="sheet-02", axis_error=0.01, landmarks_px=(8.0, 4.0), seconds=1.5)
    return [
        right,
        off,
        failed(scene(name="sheet-03"), "nothing there"),
        failed(scene(garment_type="sock"), "no"),
    ]


def test_a_summary_averages_right_cases_and_counts_failures_in_every_rate():
    found = summary(rows()[:3])
    assert (found.n, found.failed) == (3, 1)
    for rate in (found.type_rate, found.clr_matched, found.clr_fitted, found.clr_top3, found.pair_rate):
        assert rate == pytest.approx(200 / 3)
    assert (found.da, found.da_deviation) == pytest.approx((3, 2))
    assert found.landmark_px == pytest.approx(2)
    assert found.landmark_cm == pytest.approx(0.5)
    assert found.segmentation_iou == pytest.approx(2 / 3)
    assert (found.seconds, found.mcd, found.nmm) == pytest.approx((1.0, 25, 0))


def test_where_nothing_is_averaged_there_is_no_number():
    found = summary([failed(scene(), "nothing there")])
    assert math.isnan(found.da)
    assert math.isnan(found.seconds)
    assert found.clr_fitted == 0
    assert found.to_dict()["da"] is None


def test_tables_have_a_row_a_kind_and_one_overall():
    assert list(table(rows())) == ["sheet", "sock", "overall"]
    text = io.StringIO()
    print_tables(rows(), Console(file=text, width=110))
    for words in (
        "Table 1",
        "Table 2",
        "EucDist",
        "CLRm",
        "CLRf",
        "NMM",
        "MCD",
        "3.0 ± 2.0",
        "Overall",
        "0.50 ±",
    ):
        assert words in text.getvalue()


@pytest.mark.parametrize("width", [60, 110, 160])
def test_every_table_keeps_its_kinds_and_headings(width):
    text = io.StringIO()
    print_tables(rows(), Console(file=text, width=width))
    lines = text.getvalue().splitlines()
    assert max(map(len, lines)) <= width
    assert "…" not in text.getvalue()
    tables = sum("┃ Type" in line for line in lines)
    assert (
        tables == sum("│ Overall │" in line for line in lines) == sum("│ Sheet   │" in line for line in lines)
    )
    for heading in ("EucDist (cm)", "Pixels", "top 3 (%)", "unf IoU", "median s"):
        assert sum(f" {heading} ┃" in line for line in lines) == 1
    if width == 160:
        assert tables == 3


def test_csv_and_json_hold_every_scene(tmp_path):
    write_csv(rows(), tmp_path / "e.csv")
    write_json(rows(), {"protocol": "own"}, tmp_path / "e.json")
    with (tmp_path / "e.csv").open(newline="") as file:
        lines = list(csv.DictReader(file))
    assert [line["scene"] for line in lines] == ["sheet-01", "sheet-02", "sheet-03", "sheet-01"]
    assert float(lines[1]["landmark_cm"]) == pytest.approx(1.5)
    assert (lines[2]["error"], lines[2]["right_f"], lines[2]["dA"]) == ("nothing there", "False", "")
    content = json.loads((tmp_path / "e.json").read_text())
    assert content["options"] == {"protocol": "own"}
    assert content["table"]["sheet"]["clr_fitted"] == pytest.approx(200 / 3)
    assert content["scenes"][1]["landmarks_px"] == [8, 4]


# Scenes on disk


TRUTH = {
    "type": "sheet",
    "px_per_cm": 4,
    "axis_garment": [[0, 0], [4, 0]],
    "outline_garment": [[0, 0], [4, 0], [4, 4]],
    "outline_image": [[0, 0], [4, 0], [4, 4]],
    "unfolded_image": [[0, 0], [4, 0], [4, 4]],
    "landmarks": {"a": {"garment": [0, 0], "image": [0, 0], "on_outline": True, "accessible": False}},
}


def test_scenes_are_read_with_their_photographs(tmp_path):
    for name in ("b", "a"):
        (tmp_path / f"{name}.json").write_text(json.dumps(TRUTH))
    (tmp_path / "a.mask.png").touch()
    (tmp_path / "b.png").touch()
    (tmp_path / "other.json").write_text("[]")
    first, second = load_scenes(tmp_path)
    assert (first.name, second.name) == ("a", "b")
    assert (first.image, second.image) == (tmp_path / "a.jpg", tmp_path / "b.png")
    row = Evaluation("generic", [RECTANGLE]).run(replace(first, landmarks=scene().landmarks))
    assert "a.jpg" in row.error
    assert row.template_distance_cm is not None  # the template is what it is
    assert (row.type_right, row.right) == (False, False)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("{", "cannot be read as JSON"),
        (
            json.dumps({k: v for k, v in TRUTH.items() if k != "unfolded_image"}),
            "'unfolded_image' is missing",
        ),
        (json.dumps({**TRUTH, "px_per_cm": 0}), "px_per_cm"),
        (json.dumps({**TRUTH, "axis_garment": [[0, 0]]}), "at least 2 finite points"),
        (json.dumps({**TRUTH, "landmarks": []}), "not the ground truth"),
        ("{}", "no scenes"),
    ],
)
def test_bad_scenes_are_named(tmp_path, text, message):
    (tmp_path / "a.json").write_text(text)
    with pytest.raises(ParameterError, match=message):
        load_scenes(tmp_path)


def test_a_garment_of_its_own_is_a_template_with_the_pairs_of_its_kind():
    like = template([[0, 0], [90, 0], [90, 30], [0, 30]], symmetry=(("a", "b"), ("c", "d")))
    own = own_template(scene(), [like])
    np.testing.assert_allclose(own.outline, RECTANGLE.outline)
    assert (own.symmetry, own.grasp_pairs) == (like.symmetry, like.grasp_pairs)
    assert len(own_template(scene(), []).grasp_pairs) == 6


# Virtual folds and whole runs


def test_virtual_scenes_are_true_and_always_the_same():
    templates = builtin_templates()
    made = virtual_scenes(templates, 12, seed=3)
    again = virtual_scenes(templates, 12, seed=3)
    for (truth, itself), (same, _) in zip(made, again, strict=True):
        np.testing.assert_array_equal(truth.outline_image, same.outline_image)
        folded, unfolded = Polygon(truth.outline_image), Polygon(truth.unfolded_image)
        assert 0.4 < folded.area / unfolded.area < 1
        assert unfolded.area == pytest.approx(itself.area * truth.px_per_cm**2)
        ends = LandmarkedOutline(truth.outline_garment, itself.landmark_array * truth.px_per_cm)
        np.testing.assert_allclose(ends.at(ends.locate(truth.axis_garment)), truth.axis_garment, atol=1e-6)
        for mark in truth.landmarks.values():
            assert folded.buffer(1e-6).covers(Point(mark.image))
            assert mark.on_outline or not mark.accessible
    assert not np.allclose(virtual_scenes(templates, 1, seed=4)[0][0].axis_garment, made[0][0].axis_garment)


@pytest.fixture(scope="module")
def drawn_scenes(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Photographs of garments a little unlike the templates, drawn by the package."""
    folder = tmp_path_factory.mktemp("scenes")
    parameters = SynthParameters(shape_cm=1.5, asymmetry_cm=0.8, flap_fraction=(0.15, 0.4), under=0.0)
    for number, kind in enumerate(("pants", "t-shirt", "towel", "pants", "t-shirt", "shirt")):
        scene = make_scene(builtin_templates(kind)[0], seed=100 + number, parameters=parameters)
        scene.write(folder, f"{kind}-{number}")
    return folder


@pytest.mark.parametrize(("protocol", "method"), [("generic", "paper"), ("own", "paper"), ("open", "best")])
def test_every_protocol_finds_most_folds_end_to_end(drawn_scenes, tmp_path, protocol, method):
    """From photographs to the tables; the floors lie well below what is reached (four to six of six)."""
    arguments = [str(drawn_scenes), "--protocol", protocol, "--method", method, "--px-per-cm", "4"]
    done = CliRunner().invoke(evaluate_command, [*arguments, "--out", str(tmp_path)], catch_exceptions=False)
    assert done.exit_code == 0
    overall = json.loads((tmp_path / "evaluation.json").read_text())["table"]["overall"]
    assert overall["n"] == 6
    assert overall["failed"] == 0
    assert overall["clr_fitted"] >= 50
    assert overall["segmentation_iou"] >= 0.9


def test_the_truth_is_never_overwritten(drawn_scenes, tmp_path):
    truth = drawn_scenes / "towel-2.json"
    (tmp_path / "scenes").symlink_to(drawn_scenes)
    (tmp_path / "copy").mkdir()
    (tmp_path / "copy" / truth.name).write_bytes(truth.read_bytes())
    (tmp_path / "link").mkdir()
    (tmp_path / "link" / truth.name).symlink_to(truth)
    before = {path: path.read_bytes() for path in drawn_scenes.iterdir()}
    for out, told in (
        (drawn_scenes, "is the folder of the scenes"),
        (tmp_path / "scenes", "is the folder of the scenes"),
        (tmp_path / "copy" / ".." / "scenes", "is the folder of the scenes"),
        (tmp_path / "copy", truth.name),
        (tmp_path / "link", truth.name),
    ):
        done = CliRunner().invoke(evaluate_command, [str(drawn_scenes), "--out", str(out)])
        assert done.exit_code == 2
        assert told in done.output
    assert {path: path.read_bytes() for path in drawn_scenes.iterdir()} == before
    assert [path.name for path in (tmp_path / "copy").iterdir()] == [truth.name]


def test_virtual_folds_spare_what_they_did_not_make(tmp_path):
    arguments = ["--protocol", "synthetic", "--count", "1", "--method", "paper", "--out", str(tmp_path)]
    for _ in range(2):  # predictions may be made again
        done = CliRunner().invoke(evaluate_command, arguments)
        assert done.exit_code == 0
        assert done.stdout.count("┃ Type ") == 3  # in a pipe no table is cut or taken apart
        assert "…" not in done.stdout
    (path,) = tmp_path.glob("*-001.json")
    path.write_text("[]")
    done = CliRunner().invoke(evaluate_command, arguments)
    assert done.exit_code == 2
    assert path.read_text() == "[]"
    assert path.name in done.output


def test_what_the_search_misses_is_measured(drawn_scenes, tmp_path):
    arguments = [str(drawn_scenes), "--search", "--px-per-cm", "4", "--out", str(tmp_path)]
    done = CliRunner().invoke(evaluate_command, arguments, catch_exceptions=False)
    assert done.exit_code == 0
    content = json.loads((tmp_path / "evaluation.json").read_text())
    assert content["options"]["true_outlines"]
    missed = [row["missed_nats"] for row in content["scenes"]]
    # A start from the truth ends near what was found: it is hardly better, and mostly the same.
    assert max(missed) < SAME_NATS
    assert sum(abs(nats) < SAME_NATS for nats in missed) >= 4
    assert content["table"]["overall"]["missed_rate"] == 0


def test_a_search_that_ends_dearer_than_the_truth_has_missed_it(drawn_scenes):
    one = next(one for one in load_scenes(drawn_scenes) if one.garment_type == "pants")
    templates = builtin_templates("pants")
    kind = Kind.of(templates, one.landmarks)
    found = fit(one.outline_image, templates=templates, px_per_cm=4)
    assert abs(missed_nats(one, found, templates, kind, 4.0)) < SAME_NATS
    dearer = replace(found, matching_cost=found.matching_cost + 5.0)
    assert missed_nats(one, dearer, templates, kind, 4.0) == pytest.approx(5.0, abs=SAME_NATS)
    with pytest.raises(ParameterError, match="folded once"):
        missed_nats(replace(one, axis_image=None), found, templates, kind, 4.0)


def test_the_search_is_measured_in_the_view_in_which_the_result_was_found(tmp_path):
    """Of a picture taken at an angle the plane tells the scale and straightens outline and crease."""
    parameters = SynthParameters(scenarios=("random",), shape_cm=1.0, tilt_deg=35.0)
    templates = builtin_templates("pants")
    make_scene(templates[0], seed=3, parameters=parameters).write(tmp_path, "pants-1")
    (one,) = load_scenes(tmp_path)
    assert one.plane is not None
    row = Evaluation("generic", templates, true_outlines=True, search=True).run(one)
    assert (row.error, row.right) == ("", True)
    assert abs(row.missed_nats) < SAME_NATS
    found = fit(one.outline_image, templates=templates, px_per_cm=one.px_per_cm)  # as if it were not known
    missed = missed_nats(one, found, templates, Kind.of(templates, one.landmarks), one.px_per_cm)
    assert abs(missed) < SAME_NATS


@pytest.mark.parametrize("argument", ["--method=paper", "--protocol=open", "--folds=2"])
def test_the_search_is_measured_for_one_fold_of_a_known_kind(drawn_scenes, argument):
    done = CliRunner().invoke(evaluate_command, [str(drawn_scenes), "--search", argument])
    assert done.exit_code == 2
    assert "--search" in done.output


def test_the_command_knows_every_protocol():
    (protocol,) = (option for option in evaluate_command.params if option.name == "protocol")
    assert isinstance(protocol.type, click.Choice)
    assert tuple(protocol.type.choices) == PROTOCOLS


def test_the_synthetic_protocol_from_the_command_line(tmp_path):
    arguments = [
        "--protocol",
        "synthetic",
        "--count",
        "5",
        "--seed",
        "1",
        "--method",
        "paper",
        "--out",
        str(tmp_path),
    ]
    done = CliRunner().invoke(evaluate_command, arguments, catch_exceptions=False)
    assert done.exit_code == 0
    assert "Table 2" in done.output
    content = json.loads((tmp_path / "evaluation.json").read_text())
    assert content["options"]["protocol"] == "synthetic"
    assert content["table"]["overall"]["n"] == 5
    assert content["table"]["overall"]["clr_fitted"] >= 60  # theirs: 97
    assert content["table"]["overall"]["euc_dist_cm"] == pytest.approx(0, abs=1e-6)
    for row in content["scenes"]:
        assert json.loads((tmp_path / f"{row['scene']}.json").read_text())["garment_type"] == row["type"]
    assert len((tmp_path / "evaluation.csv").read_text().splitlines()) == 6


def test_a_scene_that_fails_is_listed_and_counted(tmp_path):
    marks = {m: {"garment": p.tolist(), "image": p.tolist(), "on_outline": True, "accessible": True}
             for m, p in RECTANGLE.landmarks.items()}  # fmt: skip
    ring = RECTANGLE.outline.tolist()
    truth = {**TRUTH, "outline_garment": ring, "type": "no such kind", "landmarks": marks}
    (tmp_path / "a.json").write_text(json.dumps(truth))
    for protocol, message in (("generic", "no template"), ("own", "a.jpg")):
        done = CliRunner().invoke(
            evaluate_command, [str(tmp_path), "--protocol", protocol], catch_exceptions=False
        )
        assert done.exit_code == 0
        assert message in done.output
        assert "Table 1" in done.output


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--protocol", "open"], "needs SCENES"),
        (["nowhere"], "no such folder"),
        (["--protocol", "synthetic", "--px-per-cm", "-1"], "px_per_cm"),
        (["--protocol", "synthetic", "--template", "nowhere.json"], "no such template"),
    ],
)
def test_bad_arguments_are_named(arguments, message):
    done = CliRunner().invoke(evaluate_command, arguments)
    assert done.exit_code != 0
    assert message in done.output


def test_the_command_offers_every_protocol():
    choice = next(p for p in evaluate_command.params if p.name == "protocol").type
    assert tuple(choice.choices) == PROTOCOLS


# Agreement with the benchmark's scorer


@pytest.fixture(scope="module")
def scorer() -> ModuleType:
    path = SHARED / "bench/score.py"
    if not path.is_file():
        pytest.skip("the benchmark's scorer (../shared/bench/score.py) is not here")
    spec = importlib.util.spec_from_file_location("benchmark_scorer", path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    writes, sys.dont_write_bytecode = sys.dont_write_bytecode, True  # the folder is not ours
    try:
        spec.loader.exec_module(module)
    finally:
        sys.dont_write_bytecode = writes
    return module


def kind_of(truth: Scene) -> Kind:
    return Kind.of(builtin_templates(truth.garment_type), truth.landmarks)


def assert_same(row: SceneMeasures, theirs: dict[str, Any]) -> None:
    def near(value: Any) -> Any:
        return value if value is None or isinstance(value, bool) else pytest.approx(value, abs=1e-6)

    assert row.type_right == theirs["type_ok"], row.scene
    assert (row.right_matched, row.right, row.right_in_first) == (
        theirs["right_m"],
        theirs["right_f"],
        theirs["right_3"],
    )
    assert row.pair_right == theirs["pair_ok"], row.scene
    assert row.pair_due == theirs.get("pair_due", True), row.scene
    assert row.axis_error_matched == near(theirs.get("dA_m")), row.scene
    assert row.axis_error == near(theirs.get("dA")), row.scene
    assert row.axis_angle == near(theirs.get("dtheta")), row.scene
    assert list(row.landmarks_cm) == pytest.approx([float(e) for e in theirs.get("lm", [])], abs=1e-6), (
        row.scene
    )
    assert row.unfolded_iou == near(theirs["unf"]), row.scene
    assert row.segmentation_iou == near(theirs["seg"]), row.scene
    assert list(row.creases_met) == theirs.get("creases", []), row.scene


def assert_same_tables(ours: list[SceneMeasures], theirs: list[dict[str, Any]], scorer: ModuleType) -> None:
    columns = {
        "n": "n",
        "type %": "type_rate",
        "seg IoU": "segmentation_iou",
        "CLRm %": "clr_matched",
        "CLRf %": "clr_fitted",
        "top3 %": "clr_top3",
        "dA %": "da",
        "dtheta": "dtheta",
        "lm cm": "landmark_cm",
        "pair %": "pair_rate",
        "unf IoU": "unfolded_iou",
        "crease %": "crease_rate",
        "s/img": "seconds",
    }
    for kind, mine in table(ours).items():
        expected = scorer.summary([row for row in theirs if kind in (row["type"], "overall")])
        assert set(expected) == set(columns)
        for column, attribute in columns.items():
            assert getattr(mine, attribute) == pytest.approx(expected[column], abs=1e-6, nan_ok=True), (
                kind,
                column,
            )


def test_kinds_have_the_order_and_symmetries_of_the_scorer(scorer):
    for name, order in scorer.ORDER.items():
        kind = Kind.of(builtin_templates(name), order)
        assert kind.landmarks == tuple(order)
        assert set(kind.relabellings) == {tuple(relabelling) for relabelling in scorer.symmetries(name)}


def invented(truth: Scene, rng: np.random.Generator) -> dict[str, Any]:
    """A prediction near the truth, under one of the symmetries, wrong in every respect now and then."""
    kind, given = kind_of(truth), builtin_templates(truth.garment_type)[0]
    names, new = kind.landmarks, kind.relabellings[rng.integers(len(kind.relabellings))]
    turned = np.array([truth.landmarks[name].garment for name in names])
    places = LandmarkedOutline(truth.outline_garment, turned).locate(truth.axis_garment)

    def fitted() -> dict[str, Any]:
        bend = np.eye(2) + rng.normal(0, 0.05, (2, 2))
        outline, marks = given.outline @ bend, np.array([given.landmarks[name] for name in names]) @ bend
        axis = LandmarkedOutline(outline, marks).at_relabelled(places, new) + rng.normal(
            0, rng.choice([1, 8]), (2, 2)
        )
        return {
            "outline": np.round(outline, 4).tolist(),
            "landmarks": dict(zip(names, np.round(marks, 4).tolist(), strict=True)),
            "axis": np.round(axis, 4).tolist(),
        }

    def alternative() -> dict[str, Any]:
        return {"garment_type": rng.choice([truth.garment_type, "sock"], p=[0.8, 0.2]), "template": fitted()}

    image = {names[new[k]]: truth.landmarks[name].image + rng.normal(0, 8, 2) for k, name in enumerate(names)}
    pairs = [pair for pair in given.grasp_pairs if rng.random() < 0.5]
    creases = [rng.normal(0, 6, (2, 2)) + crease for crease in (truth.creases or (truth.outline_image[:2],))]
    axes = [{"axis_image": crease.tolist()} for crease in creases]
    flip = rng.random() < 0.5
    unfolded = truth.unfolded_image + rng.normal(0, 3, 2)
    chosen = alternative()
    return {
        **chosen,
        "original_template": fitted(),
        "matching_cost": 0.2,
        "original_matching_cost": 0.3,
        "seconds": float(rng.uniform(0.1, 2)),
        "outline_image": (truth.outline_image + rng.normal(0, 3, 2)).tolist(),
        "fold": axes[-1],
        "folds": axes,
        "unfolded_outline_image": (mirrored(unfolded, creases[-1]) if flip else unfolded).tolist(),
        "landmarks": {name: {"image": point.tolist()} for name, point in image.items()},
        "grasp_pairs": [{"landmarks": list(p), "image": [image[m].tolist() for m in p]} for p in pairs],
        "alternatives": [chosen, *(alternative() for _ in range(rng.integers(4)))],
    }


@pytest.mark.parametrize("folder", ["once", "twice"])
def test_every_measure_and_mean_is_that_of_the_scorer(scorer, scenes, folder):
    rng = np.random.default_rng(1)
    ours, theirs = [], []
    for truth in load_scenes(scenes.parent / folder):
        predicted = invented(truth, rng)
        ours.append(measure(truth, predicted, kind_of(truth)))
        theirs.append(
            scorer.score(json.loads((scenes.parent / folder / f"{truth.name}.json").read_text()), predicted)
        )
        assert_same(ours[-1], theirs[-1])
    assert_same_tables(ours, theirs, scorer)
    if folder == "once":
        assert {row.right for row in ours} == {row.pair_right for row in ours} == {True, False}


def test_a_run_writes_predictions_that_score_the_same(scorer, scenes, tmp_path):
    """One scene a kind, by outline: what is measured in the run is what the scorer finds in the files."""
    some = [truth for truth in load_scenes(scenes) if truth.name.endswith("-04")]
    evaluation = Evaluation("generic", builtin_templates(), CM, "paper", true_outlines=True, out=tmp_path)
    ours = sorted(run_all(evaluation, some, jobs=2), key=lambda row: row.scene)
    assert [row.scene for row in ours] == [truth.name for truth in some]
    theirs = []
    for row in ours:
        assert row.error == ""
        truth: Path = scenes / f"{row.scene}.json"
        written = json.loads((tmp_path / truth.name).read_text())
        theirs.append(scorer.score(json.loads(truth.read_text()), written))
        assert_same(row, theirs[-1])
    assert_same_tables(ours, theirs, scorer)
