"""Scenes: what is written as true of a picture must be true, and every parameter must be obeyed."""

from __future__ import annotations

import dataclasses
import importlib.util
import json
from types import ModuleType
from typing import Any

import click
import cv2
import numpy as np
import pytest
import shapely
from hypothesis import given, reject, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from shapely.geometry import LinearRing, LineString, Point, Polygon

from conftest import SHARED, simple_polygons
from foldrs.errors import FoldrsError, InvalidOutlineError, ParameterError
from foldrs.synth import (
    CLOTHS,
    SCENARIOS,
    TABLES,
    Garment,
    Photograph,
    Scene,
    SynthParameters,
    garment_from_outline,
    make_scene,
    make_scenes,
)
from foldrs.synth.layers import Turn
from foldrs.synth.ordered_landmarks import follow_outline
from foldrs.synth_cli import synth_command
from foldrs.template import builtin_templates

TEMPLATES = builtin_templates()
EXACT = SynthParameters(deformation_cm=0.0, flap_turn_deg=0.0)
RECTANGLE = Garment(
    "sheet",
    np.array([[0, 0], [60, 0], [60, 40], [0, 40]], dtype=float),
    {"a": np.array([0.0, 0]), "b": np.array([60.0, 0]), "c": np.array([60.0, 40]), "d": np.array([0.0, 40])},
)


def template(kind: str) -> Any:
    return builtin_templates(kind)[0]


def polygon(points: Any) -> Polygon:
    return shapely.make_valid(Polygon(points))


def mirrored(points: Any, axis: Any) -> np.ndarray:
    points, (a, b) = np.asarray(points, dtype=float), np.asarray(axis, dtype=float)
    along = (b - a) / np.linalg.norm(b - a)
    return 2 * (a + ((points - a) @ along)[:, None] * along) - points


def beyond(axis: Any, shape: Polygon, inside: Any) -> Polygon:
    """The part of a shape on the other side of an axis's line than a point."""
    a, b = np.asarray(axis, dtype=float)
    along = (b - a) / np.linalg.norm(b - a) * 1e4
    normal = np.array([-along[1], along[0]])
    if normal @ (np.asarray(inside) - a) > 0:
        normal = -normal
    return shape & Polygon([a - along, a + along, a + along + normal, a - along + normal])


@pytest.fixture(scope="module", params=[1, 2], ids=["once", "twice"])
def scenes(request: pytest.FixtureRequest) -> list[Scene]:
    """Two scenes of every built-in template."""
    parameters = SynthParameters(folds=request.param)
    return [
        make_scene(t, seed=10 * k + n, parameters=parameters) for k, t in enumerate(TEMPLATES) for n in (1, 2)
    ]


# What is true of every scene


def test_mask_is_what_the_outline_encloses(scenes: list[Scene]) -> None:
    for scene in scenes:
        y, x = np.indices(scene.mask.shape)
        inside = shapely.contains_xy(polygon(scene.truth["outline_image"]), x, y)
        cloth = scene.mask > 0
        assert (inside & cloth).sum() / (inside | cloth).sum() > 0.99


def test_unfolded_garment_keeps_its_area(scenes: list[Scene]) -> None:
    for scene in scenes:
        before, after = (polygon(scene.truth[k]).area for k in ("outline_garment", "unfolded_image"))
        assert after == pytest.approx(before, rel=0.06)


def test_folding_hides_no_more_than_the_flaps(scenes: list[Scene]) -> None:
    for scene in scenes:
        truth = scene.truth
        flat, seen = polygon(truth["outline_garment"]).area, polygon(truth["outline_image"]).area
        turned = truth["flap_fraction"] + truth.get("second_fold", {}).get("flap_fraction", 0.0)
        assert (1 - turned) * flat * 0.94 < seen < flat


def test_landmarks_are_on_the_outline_if_and_only_if_it_says_so(scenes: list[Scene]) -> None:
    for scene in scenes:
        rim = LineString([*scene.truth["outline_image"], scene.truth["outline_image"][0]])
        for mark in scene.truth["landmarks"].values():
            near = 0.75 * scene.truth["px_per_cm"]
            distance = rim.distance(Point(mark["image"]))
            assert abs(distance - near) < 0.1 or mark["on_outline"] == (distance < near)
            assert mark["on_outline"] or not mark["accessible"]


def test_axis_ends_on_the_unfolded_outline(scenes: list[Scene]) -> None:
    for scene in scenes:
        ring = scene.truth["outline_garment"]
        rim = LineString([*ring, ring[0]])
        assert all(rim.distance(Point(end)) < 0.05 for end in scene.truth["axis_garment"])


def test_last_crease_is_a_side_of_the_seen_outline(scenes: list[Scene]) -> None:
    for scene in scenes:
        truth = scene.truth
        creases = [truth["second_fold"]["axis_image"]] if "second_fold" in truth else truth["creases_image"]
        rim = LineString([*truth["outline_image"], truth["outline_image"][0]])
        if "second_fold" in truth or len(creases) == 1:
            assert min(rim.distance(Point(np.mean(crease, axis=0))) for crease in creases) < 6.0


def test_cloth_stands_out_from_the_table() -> None:
    plain = SynthParameters(
        tables=("plain",), cloths=("plain",), contrast=30.0, warmth=0.0, light=0.0, vignette=0.0
    )
    for seed in range(5):
        scene = make_scene(RECTANGLE, seed=seed, parameters=plain)
        lab = cv2.cvtColor(scene.image.astype(np.float32) / 255, cv2.COLOR_RGB2Lab)
        core = cv2.erode(scene.mask, np.ones((9, 9))) > 0
        table = cv2.dilate(scene.mask, np.ones((25, 25))) == 0
        assert np.linalg.norm(lab[core].mean(axis=0) - lab[table].mean(axis=0)) > 20


@pytest.mark.parametrize("kind", [t.name for t in TEMPLATES])
def test_exact_fold_is_a_mirror_image(kind: str) -> None:
    source = next(t for t in TEMPLATES if t.name == kind)
    for seed in range(6):
        truth = make_scene(source, seed=seed, parameters=EXACT).truth
        ring = np.array(truth["outline_garment"])
        for mark in truth["landmarks"].values():
            flat = np.array(truth["unfolded_image"])[((ring - mark["garment"]) ** 2).sum(axis=1).argmin()][
                None
            ]
            lies = mirrored(flat, truth["axis_image"]) if mark["on_flap"] else flat
            np.testing.assert_allclose(mark["image"], lies[0], atol=0.05)


def test_exact_fold_turns_what_lies_beyond_its_line() -> None:
    parameters = dataclasses.replace(EXACT, scenarios=("random", "parallel", "corner"))
    for seed in range(12):
        truth = make_scene(TEMPLATES[seed % len(TEMPLATES)], seed=seed, parameters=parameters).truth
        flat = polygon(truth["unfolded_image"])
        parts = [beyond(truth["axis_image"], flat, side) for side in ((-1e4, 0), (1e4, 0))]
        flap = min(parts, key=lambda part: part.area)
        kept = max(parts, key=lambda part: part.area)
        turned = shapely.transform(flap, lambda p, axis=truth["axis_image"]: mirrored(p, axis))
        seen = polygon(truth["outline_image"])
        assert flap.area / flat.area == pytest.approx(truth["flap_fraction"], abs=1e-3)
        assert (seen & (kept | turned)).area / (seen | kept | turned).area > 0.985
        doubled = (kept & turned).buffer(-0.5)
        for mark in truth["landmarks"].values():
            distance = doubled.distance(Point(mark["image"])) / truth["px_per_cm"]
            if mark["on_outline"] and abs(distance - 2.0) > 0.3:
                assert mark["accessible"] == (distance > 2.0)


def test_first_crease_is_broken_by_the_second_fold() -> None:
    parameters = dataclasses.replace(EXACT, folds=2)
    broken = 0
    for seed in range(12):
        truth = make_scene(RECTANGLE, seed=seed, parameters=parameters).truth
        pieces = [np.array(piece) for piece in truth["creases_image"]]
        length = sum(np.linalg.norm(piece[1] - piece[0]) for piece in pieces)
        axis = np.array(truth["axis_image"])
        assert length == pytest.approx(np.linalg.norm(axis[1] - axis[0]), abs=2 * truth["px_per_cm"])
        rim = polygon(truth["outline_image"]).buffer(1.0)
        assert all(rim.covers(Point(end)) for piece in pieces for end in piece)
        broken += len(pieces) == 2
    assert broken > 0


# The benchmark's own words


def scorer() -> ModuleType:
    path = SHARED / "bench/score.py"
    if not path.exists():
        pytest.skip("the benchmark's score.py is not at hand")
    spec = importlib.util.spec_from_file_location("score", path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_the_truth_itself_scores_full_marks() -> None:
    score = scorer()
    for k, source in enumerate(TEMPLATES):
        truth = {"id": "scene", **make_scene(source, seed=k).truth}
        marks = truth["landmarks"]
        flat = {
            "outline": truth["outline_garment"],
            "landmarks": {name: mark["garment"] for name, mark in marks.items()},
            "axis": truth["axis_garment"],
        }
        assert (
            min(np.abs(axis - truth["axis_garment"]).max() for axis in score.true_axes_on(truth, flat)) < 0.1
        )
        result = score.score(
            truth,
            {
                "garment_type": truth["type"],
                "outline_image": truth["outline_image"],
                "original_template": flat,
                "template": flat,
                "fold": {"axis_image": truth["axis_image"]},
                "unfolded_outline_image": truth["unfolded_image"],
                "landmarks": marks,
            },
        )
        assert result["right_m"]
        assert result["right_f"]
        assert result["seg"] > 0.999
        assert result["unf"] > 0.999
        assert max(result["lm"], default=0.0) < 0.01


@pytest.mark.parametrize(("folds", "folder"), [(1, "once"), (2, "twice")])
def test_fields_are_those_of_the_benchmark(folds: int, folder: str, tmp_path: Any) -> None:
    examples = sorted((SHARED / "data/scenes" / folder).glob("*.json"))
    if not examples:
        pytest.skip("the benchmark's scenes are not at hand")
    example = json.loads(examples[0].read_text())
    scene = make_scene(template("pants"), seed=1, parameters=SynthParameters(folds=folds))
    written = json.loads(scene.write(tmp_path, "pants-01").read_text())
    assert set(example) - {"sameness"} <= set(written)
    for name, mark in example["landmarks"].items():
        assert set(mark) <= set(written["landmarks"][name])
    assert set(example.get("second_fold", {})) <= set(written.get("second_fold", {}))


# Same seed, same scene


def test_same_seed_gives_the_same_scene_and_another_seed_another() -> None:
    first, same, other = (make_scene(template("t-shirt"), seed=seed) for seed in (5, 5, 6))
    assert np.array_equal(first.image, same.image)
    assert first.truth == same.truth
    assert not np.array_equal(first.image, other.image)


def test_number_of_jobs_changes_nothing(tmp_path: Any) -> None:
    seen: list[tuple[int, int]] = []
    sources = [template("pants"), template("towel")]
    one = make_scenes(sources, 5, 3, tmp_path / "one", jobs=1)
    two = make_scenes(sources, 5, 3, tmp_path / "two", jobs=2, progress=lambda k, n: seen.append((k, n)))
    assert [path.name for path in one] == [path.name for path in two]
    assert [path.stem for path in one] == ["pants-01", "towel-02", "pants-03", "towel-04", "pants-05"]
    assert seen == [(k, 5) for k in range(1, 6)]
    files = sorted(path.name for path in (tmp_path / "one").iterdir())
    assert len(files) == 15
    assert files == sorted(path.name for path in (tmp_path / "two").iterdir())
    for name in files:
        assert (tmp_path / "one" / name).read_bytes() == (tmp_path / "two" / name).read_bytes()


def test_a_longer_set_begins_with_the_shorter_one(tmp_path: Any) -> None:
    short = make_scenes([RECTANGLE], 1, 9, tmp_path / "short", jobs=1)
    long = make_scenes([RECTANGLE], 2, 9, tmp_path / "long", jobs=1)
    assert short[0].read_bytes() == long[0].read_bytes()


def test_png_keeps_the_pixels_and_the_truth_names_its_files(tmp_path: Any) -> None:
    scene = make_scene(RECTANGLE, seed=1)
    path = scene.write(tmp_path / "new", "sheet-7", suffix=".png")
    truth = json.loads(path.read_text())
    assert (truth["id"], truth["image"]) == ("sheet-7", "sheet-7.png")
    assert np.array_equal(cv2.imread(str(path.with_name(truth["image"])))[..., ::-1], scene.image)
    mask = cv2.imread(str(path.with_name("sheet-7.mask.png")), cv2.IMREAD_UNCHANGED)
    assert np.array_equal(mask, scene.mask)
    assert sorted(p.name for p in path.parent.iterdir()) == [
        "sheet-7.json",
        "sheet-7.mask.png",
        "sheet-7.png",
    ]


def test_a_file_that_cannot_be_written_leaves_no_part_behind(tmp_path: Any) -> None:
    (tmp_path / "sheet-7.jpg").mkdir()
    with pytest.raises(OSError, match=r"sheet-7\.jpg"):
        make_scene(RECTANGLE, seed=1).write(tmp_path, "sheet-7")
    assert [path.name for path in tmp_path.iterdir()] == ["sheet-7.jpg"]


def test_what_holds_arrays_can_be_compared_and_be_a_key(tmp_path: Any) -> None:
    scene = make_scene(RECTANGLE, seed=1)
    photograph = Photograph(tmp_path / "sheet.jpg", RECTANGLE.outline)
    for one in (RECTANGLE, scene, scene.camera, photograph, Turn(RECTANGLE.outline[:2])):
        assert one == one
        assert one != dataclasses.replace(one)  # arrays are not compared
        assert {one: "found"}[one] == "found"


def test_the_command_knows_every_scenario() -> None:
    (option,) = (option for option in synth_command.params if option.name == "scenarios")
    assert isinstance(option.type, click.Choice)
    assert tuple(option.type.choices) == SCENARIOS


# Every parameter is obeyed


def made(source: Any = RECTANGLE, count: int = 6, **parameters: Any) -> list[Scene]:
    return [make_scene(source, seed=seed, parameters=SynthParameters(**parameters)) for seed in range(count)]


def test_image_size_and_scale() -> None:
    for scene in made(image_size=(320, 300), px_per_cm=2.5, size_range=(1.0, 1.0), stretch=0.0, shape_cm=0.0):
        assert scene.image.shape == (300, 320, 3)
        assert scene.mask.shape == (300, 320)
        assert scene.truth["px_per_cm"] == 2.5
        assert polygon(scene.truth["outline_garment"]).area == pytest.approx(60 * 40 * 2.5**2, rel=0.15)


def test_margin() -> None:
    for scene in made(margin_cm=6.0):
        assert not scene.mask[:22].any()
        assert not scene.mask[-22:].any()
        assert not scene.mask[:, :22].any()
        assert not scene.mask[:, -22:].any()


def test_size_and_shape_of_the_garment() -> None:
    still = {"shape_cm": 0.0, "asymmetry_cm": 0.0, "stretch": 0.0, "bow": 0.0, "rim_cm": 0.0}
    for size in (0.8, 1.05):
        scene = made(count=1, size_range=(size, size), **still)[0]
        ring = np.array(scene.truth["outline_garment"]) / 4.0
        expected = RECTANGLE.outline * size - RECTANGLE.outline.mean(axis=0) * size
        assert (polygon(ring) ^ polygon(expected)).area < 0.01 * polygon(expected).area
    alike = [polygon(s.truth["outline_garment"]) for s in made(size_range=(1, 1), **still)]
    varied = [
        polygon(s.truth["outline_garment"]) for s in made(size_range=(1, 1), **{**still, "shape_cm": 4.0})
    ]
    assert max((shape ^ alike[0]).area for shape in alike) < 1.0
    assert min((shape ^ alike[0]).area for shape in varied) > 0.02 * alike[0].area


def test_symmetric_pairs_vary_alike() -> None:
    symmetric = SynthParameters(asymmetry_cm=0.0, rim_cm=0.0, bow=0.0, folds=1)
    source = template("pants")
    for seed in range(3):
        marks = make_scene(source, seed=seed, parameters=symmetric).truth["landmarks"]
        for a, b in source.symmetry:
            left, right = (np.array(marks[m]["garment"]) / 4.0 for m in (a, b))
            assert left[1] - right[1] == pytest.approx(
                source.landmarks[a][1] - source.landmarks[b][1], abs=1.0
            )


@pytest.mark.parametrize("bounds", [(0.1, 0.2), (0.4, 0.5)])
def test_flap_fraction(bounds: tuple[float, float]) -> None:
    for scene in made(template("t-shirt"), flap_fraction=bounds):
        assert bounds[0] <= scene.truth["flap_fraction"] <= bounds[1]


@pytest.mark.parametrize("scenario", SCENARIOS)
def test_scenario(scenario: str) -> None:
    for scene in made(template("pants"), count=3, scenarios=(scenario,)):
        assert scene.truth["scenario"] == scenario
        if scenario == "limb":
            assert len(scene.truth["creases_image"]) == 1
        if scenario == "limbs":
            assert len(scene.truth["creases_image"]) >= 2


def test_flap_over_or_under() -> None:
    assert not any(scene.truth["flap_under"] for scene in made(under=0.0))
    assert all(scene.truth["flap_under"] for scene in made(under=1.0))


def test_under_changes_what_is_seen_not_where_it_lies() -> None:
    over, under = (made(count=1, under=share, flap_fraction=(0.3, 0.5))[0] for share in (0.0, 1.0))
    assert over.truth["outline_image"] == under.truth["outline_image"]
    assert not np.array_equal(over.image, under.image)


def test_mirrored() -> None:
    for share in (0.0, 1.0):
        for scene in made(mirrored=share):
            before, after = (np.array(scene.truth[k]) for k in ("outline_garment", "unfolded_image"))
            turned = [
                np.sum(p[:, 0] * np.roll(p[:, 1], -1) - p[:, 1] * np.roll(p[:, 0], -1))
                for p in (before, after)
            ]
            assert (np.sign(turned[0]) != np.sign(turned[1])) == (share == 1.0)


def test_number_of_folds() -> None:
    assert all(scene.truth["axis_garment"] is None for scene in made(folds=0))
    assert all("second_fold" not in scene.truth for scene in made(folds=1))
    assert all("second_fold" in scene.truth for scene in made(folds=2))


def test_deformation_has_the_size_asked_for() -> None:
    for rms in (0.0, 0.5, 1.0):
        left = []
        for scene in made(deformation_cm=rms, count=12):
            a, b = (np.array(scene.truth[k]) @ [1, 1j] / 4.0 for k in ("outline_garment", "unfolded_image"))
            a, b = a - a.mean(), b - b.mean()
            rest = [b - (b @ c.conj()) / np.sum(np.abs(c) ** 2) * c for c in (a, a.conj())]
            left.append(min(np.mean(np.abs(r) ** 2) for r in rest))
        # The best similarity takes up the part of the deformation that shifts, turns and scales.
        assert 0.5 * rms - 0.01 <= np.sqrt(np.mean(left)) <= rms + 0.01


@pytest.mark.parametrize("table", TABLES)
@pytest.mark.parametrize("cloth", CLOTHS)
def test_textures_are_light_on_any_cloth_and_table(table: str, cloth: str) -> None:
    still = {"noise": 0.0, "shadow": 0.0, "wrinkles": 0.0, "light": 0.0, "vignette": 0.0}
    image = made(count=1, tables=(table,), cloths=(cloth,), **still)[0].image
    assert 10 < image.mean() < 245


@pytest.mark.parametrize("effect", ["wrinkles", "shadow", "light", "vignette", "warmth", "noise"])
def test_effects_change_the_picture_and_nothing_else(effect: str) -> None:
    full, without = made(count=1)[0], made(count=1, **{effect: 0.0})[0]
    assert full.truth == without.truth
    assert not np.array_equal(full.image, without.image)


def test_noise_has_the_strength_asked_for() -> None:
    still = {"tables": ("plain",), "image_size": (320, 240), "px_per_cm": 2.0}
    image = made(count=1, noise=5.0, **still)[0].image.astype(float)
    corner = image[:20, :60, 0] - cv2.GaussianBlur(image[:20, :60, 0], (0, 0), 5)
    assert corner.std() == pytest.approx(5.0, rel=0.2)


# Nonsense is refused


@pytest.mark.parametrize(
    "wrong",
    [
        {"image_size": (0, 480)},
        {"image_size": (640.5, 480)},
        {"px_per_cm": -4.0},
        {"px_per_cm": float("nan")},
        {"size_range": (1.2, 0.8)},
        {"size_range": (1.0,)},
        {"flap_fraction": (0.2, 0.7)},
        {"flap_fraction": (0.4, 0.2)},
        {"folds": 3},
        {"under": 1.5},
        {"shape_cm": -1.0},
        {"noise": float("inf")},
        {"scenarios": ()},
        {"scenarios": "random"},
        {"scenarios": ("diagonally",)},
        {"tables": ("marble",)},
        {"cloths": ("silk",)},
    ],
    ids=str,
)
def test_nonsense_parameters(wrong: dict[str, Any]) -> None:
    with pytest.raises(ParameterError, match=next(iter(wrong))):
        SynthParameters(**wrong)


def test_garment_too_large_for_the_picture() -> None:
    with pytest.raises(ParameterError, match="does not fit"):
        made(count=1, image_size=(100, 100))


def test_fold_the_garment_does_not_offer() -> None:
    with pytest.raises(ParameterError, match="limb"):
        made(count=1, scenarios=("limb",))


def test_outline_that_is_none() -> None:
    bow_tie = dataclasses.replace(RECTANGLE, outline=RECTANGLE.outline[[0, 2, 1, 3]])
    for garment in (bow_tie, dataclasses.replace(RECTANGLE, outline=RECTANGLE.outline[:2])):
        with pytest.raises(InvalidOutlineError, match="outline"):
            make_scene(garment, seed=1)


def test_garment_without_a_real_size(tmp_path: Any) -> None:
    pixels = dataclasses.replace(template("towel"), units="px")
    with pytest.raises(ParameterError, match="garment_from_outline"):
        make_scene(pixels, seed=1)
    with pytest.raises(ParameterError, match="garment_from_outline"):
        make_scenes([pixels], 1, 1, tmp_path)


def test_nonsense_counts(tmp_path: Any) -> None:
    for sources, count, seed, jobs in (([], 1, 1, 1), ([RECTANGLE], 0, 1, 1), ([RECTANGLE], 1, -1, 1)):
        with pytest.raises(ParameterError):
            make_scenes(sources, count, seed, tmp_path, jobs=jobs)
    with pytest.raises(ParameterError, match="jobs"):
        make_scenes([RECTANGLE], 1, 1, tmp_path, jobs=0)
    with pytest.raises(ParameterError, match="bmp"):
        make_scenes([RECTANGLE], 1, 1, tmp_path, suffix=".bmp")
    with pytest.raises(ParameterError, match="seed"):
        make_scene(RECTANGLE, seed=-1)


@pytest.mark.parametrize("kind", ["../evil", "a/b", "a\\b", "two\nlines", "bell\a"])
def test_a_kind_that_can_name_no_file(tmp_path: Any, kind: str) -> None:
    with pytest.raises(ParameterError, match="can name no file"):
        make_scenes([RECTANGLE, dataclasses.replace(RECTANGLE, garment_type=kind)], 2, 1, tmp_path / "out")
    assert list(tmp_path.iterdir()) == []


def test_error_in_another_process_is_the_same_error(tmp_path: Any) -> None:
    small = SynthParameters(image_size=(100, 100))
    with pytest.raises(ParameterError, match="does not fit"):
        make_scenes([RECTANGLE], 2, 1, tmp_path, parameters=small, jobs=2)
    assert list(tmp_path.iterdir()) == []


# Any outline will do


def test_size_of_a_traced_outline() -> None:
    traced = {"corner": (10.0, 20.0)}
    ring = [(10, 20), (110, 20), (110, 70), (10, 70)]
    by_length = garment_from_outline(ring, traced, "flag", size_cm=50.0)
    by_area = garment_from_outline(ring, traced, "flag", area_cm2=50.0 * 25.0)
    np.testing.assert_allclose(by_length.outline, by_area.outline)
    assert polygon(by_length.outline).area == pytest.approx(1250.0)
    np.testing.assert_allclose(by_length.landmarks["corner"], (5.0, 10.0))
    for sizes in ({}, {"size_cm": 50.0, "area_cm2": 9.0}, {"size_cm": -1.0}, {"area_cm2": float("nan")}):
        with pytest.raises(ParameterError, match="size"):
            garment_from_outline(ring, traced, "flag", **sizes)


def test_landmarks_of_a_corner_turned_in_keep_their_order() -> None:
    # The third corner lies so far within that the place nearest to it is beyond the fourth.
    ring = [(0.0, 0.0), (40.0, 0.0), (40.0, 20.0), (20.0, 40.0), (0.0, 40.0)]
    corners = {"a": (0.0, 0.0), "b": (40.0, 0.0), "c": (3.0, 20.0), "d": (0.0, 39.0)}
    as_given = garment_from_outline(ring, corners, "towel", size_cm=40.0)
    assert turns_round(as_given) != pytest.approx(1.0)
    for order in ("abcd", "dcba", "cdab"):
        kept = garment_from_outline(ring, corners, "towel", size_cm=40.0, order=order)
        assert turns_round(kept) == pytest.approx(1.0)
        np.testing.assert_allclose(kept.landmarks["a"], corners["a"], atol=0.5)
        np.testing.assert_allclose(kept.landmarks["b"], corners["b"], atol=0.5)
    with pytest.raises(ParameterError, match="e"):
        garment_from_outline(ring, corners, "towel", size_cm=40.0, order="abcde")


def turns_round(garment: Garment) -> float:
    """How often one goes round the outline to pass the landmarks a, b, c, d in turn, the shorter way."""
    outline = LinearRing(garment.outline)
    arc = np.array([outline.project(Point(garment.landmarks[mark])) for mark in "abcd"])
    steps = np.roll(arc, -1) - arc
    return min((way * steps % outline.length).sum() for way in (1, -1)) / outline.length


@given(ring=simple_polygons, data=st.data())
def test_no_order_of_places_along_an_outline_is_nearer(ring: np.ndarray, data: st.DataObject) -> None:
    low, high = ring.min(axis=0), ring.max(axis=0)
    shares = data.draw(arrays(float, (4, 2), elements=st.floats(0, 1)))
    marks = low + shares * (high - low)
    placed = follow_outline(ring, marks)
    outline = LinearRing(ring)
    arc = outline.project([Point(p) for p in placed])
    if (placed == marks).all():
        return  # their nearest places follow each other
    assert max(outline.distance([Point(p) for p in placed])) < 1e-6 * outline.length
    # Any four places that follow each other lie as far off or farther, up to the spacing of those tried.
    others = np.sort(data.draw(arrays(float, 4, elements=st.floats(0, 1), unique=True))) * outline.length
    others = np.roll(others[:: data.draw(st.sampled_from([1, -1]))], data.draw(st.integers(0, 3)))
    away = np.linalg.norm([outline.interpolate(a).coords[0] for a in others] - marks, axis=1)
    spacing = outline.length / 400
    assert (np.linalg.norm(placed - marks, axis=1) ** 2).sum() <= ((away + 4 * spacing) ** 2).sum()
    steps = np.roll(arc, -1) - arc
    assert min((way * steps % outline.length).sum() for way in (1, -1)) == pytest.approx(outline.length)


@settings(max_examples=12)
@given(ring=simple_polygons, seed=st.integers(0, 2**32), folds=st.sampled_from([1, 2]))
def test_scenes_of_arbitrary_outlines(ring: np.ndarray, seed: int, folds: int) -> None:
    try:
        garment = garment_from_outline(ring, {"first": ring[0]}, "thing", size_cm=50.0)
        scene = make_scene(garment, seed=seed, parameters=SynthParameters(folds=folds, px_per_cm=3.0))
    except FoldrsError:
        reject()
    outline = np.array(scene.truth["outline_image"])
    assert Polygon(outline).is_valid
    assert outline.min() > 0
    assert (outline.max(axis=0) < (639, 479)).all()
    covered, seen = (scene.mask > 0).sum(), Polygon(outline)
    assert abs(covered - seen.area) < 0.35 * seen.length  # the rims agree to a third of a pixel
    assert covered < polygon(scene.truth["outline_garment"]).area * 1.05


@given(
    ends=st.lists(st.floats(-50, 50), min_size=4, max_size=4).filter(lambda e: abs(e[0] - e[2]) > 1),
    angle=st.floats(-0.035, 0.035),
)
def test_turning_back_undoes_the_turn(ends: list[float], angle: float) -> None:
    turn = Turn(np.array(ends).reshape(2, 2), angle)
    points = np.random.default_rng(0).uniform(-40, 40, (50, 2))
    np.testing.assert_allclose(turn.undo(turn.apply(points)), points, atol=0.05)
    on_axis = np.array(ends).reshape(2, 2)
    np.testing.assert_allclose(turn.apply(on_axis), on_axis, atol=1e-6)
