"""Templates drafted from flat garments: mirror axis, corners, pairs, landmarks by hand, means of several."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from foldrs import _core
from foldrs.drafting import Draft, DraftParameters, draft_template, mean_template
from foldrs.drafting.pairs import grasp_pairs
from foldrs.drafting.symmetry import mirror_axis
from foldrs.errors import InvalidOutlineError, ParameterError, TemplateError
from foldrs.explanation import apply
from foldrs.joint_fit import vertex_spreads
from foldrs.synth import SynthParameters
from foldrs.synth.garment import checked, vary
from foldrs.template import Template, builtin_templates, load_template, save_template

P = DraftParameters()

GLOVE = np.array(
    [
        [0, 40],
        [0, 20],
        [-9, 12],
        [-6, 9],
        [3, 14],
        [2, 0],
        [6, 0],
        [7, 12],
        [9, -3],
        [13, -3],
        [13, 12],
        [16, -1],
        [20, 0],
        [18, 13],
        [21, 5],
        [25, 6],
        [22, 22],
        [20, 40],
    ],
    float,
)


def turned(points: NDArray[np.float64], degrees: float, scale: float = 4.0) -> NDArray[np.float64]:
    """Points in a photograph: turned, larger, elsewhere."""
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    return scale * points @ np.array([[c, -s], [s, c]]).T + np.array([400.0, 120.0])


def with_limb_turned(template: Template, degrees: float) -> NDArray[np.float64]:
    """The T-shirt with its left sleeve turned about the armpit and the shoulder's middle."""
    outline = _core.resample(template.outline, 400)
    marks = template.landmarks
    pivot = (marks["armpit_left"] + marks["collar_left"]) / 2
    sleeve = outline[:, 0] < marks["armpit_left"][0] - 1.0
    sleeve &= outline[:, 1] < marks["armpit_left"][1] + 2.0
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    moved = outline.copy()
    moved[sleeve] = (outline[sleeve] - pivot) @ np.array([[c, -s], [s, c]]).T + pivot
    return moved


def angle_of(axis: NDArray[np.float64]) -> float:
    """Degrees from the vertical, in (-90, 90]."""
    x, y = axis[1] - axis[0]
    return (math.degrees(math.atan2(-x, y)) + 90) % 180 - 90


@pytest.fixture(params=["t-shirt", "shirt", "pants", "shorts", "skirt", "towel"])
def builtin(request: pytest.FixtureRequest) -> Template:
    return builtin_templates(request.param)[0]


@pytest.fixture
def shirt() -> Template:
    return builtin_templates("t-shirt")[0]


class TestMirrorAxis:
    @pytest.mark.parametrize("degrees", [-35.0, 0.0, 12.0, 40.0])
    def test_it_is_found_however_the_garment_is_turned(self, builtin: Template, degrees: float) -> None:
        found = mirror_axis(turned(builtin.outline, degrees), P)
        assert found.deviation < 0.03
        assert angle_of(found.axis) == pytest.approx(degrees, abs=0.5)

    def test_a_sleeve_laid_otherwise_hardly_turns_it(self, shirt: Template) -> None:
        found = mirror_axis(turned(with_limb_turned(shirt, 12.0), 10.0), P)
        assert angle_of(found.axis) == pytest.approx(10.0, abs=2.0)
        assert found.deviation <= P.asymmetric

    def test_of_a_towels_two_the_one_nearest_to_the_vertical_is_taken(self) -> None:
        towel = builtin_templates("towel")[0]
        assert abs(angle_of(mirror_axis(turned(towel.outline, 70.0), P).axis)) == pytest.approx(20.0, abs=0.5)

    def test_a_glove_has_none(self) -> None:
        draft = draft_template(GLOVE, "glove", size_cm=25)
        assert not draft.symmetric
        assert draft.template.symmetry == ()
        assert len(draft.template.landmarks) >= 8
        with pytest.raises(ParameterError, match="mirror image"):
            draft_template(GLOVE, "glove", symmetric=True)


class TestDraft:
    def test_a_kind_drawn_turned_comes_back_with_its_landmarks(self, builtin: Template) -> None:
        # The order of the built-in ones: from the top down the left side and up the right one.
        corners = np.array(list(builtin.landmarks.values()))
        draft = draft_template(turned(builtin.outline, 8.0), builtin.garment_type, px_per_cm=4.0)
        assert _core.outline_iou(
            draft.template.outline, builtin.outline - [0.0, builtin.outline[:, 1].min()]
        ) == pytest.approx(1.0, abs=0.03)
        names = list(builtin.landmarks)
        marks = dict(zip(names, turned(corners, 8.0), strict=True))
        marked = draft_template(
            turned(builtin.outline, 8.0), builtin.garment_type, px_per_cm=4.0, landmarks=marks
        ).template
        offset = corners - np.array([marked.landmarks[name] for name in names])
        assert np.abs(offset - offset.mean(axis=0)).max() < 0.6
        declared = {frozenset(pair) for pair in builtin.symmetry}
        assert declared <= {frozenset(pair) for pair in marked.symmetry}

    def test_corners_are_named_in_their_order(self, shirt: Template) -> None:
        names = ["a", "b", "c", "d", "e", "f", "g", "h", "i", "j"]
        draft = draft_template(turned(shirt.outline, -5.0), "t-shirt", landmarks=names, px_per_cm=4.0)
        found = draft.template.landmarks
        assert list(found) == names
        for name, true in zip(names, shirt.landmarks.values(), strict=True):
            assert np.linalg.norm(found[name] - true) < 3.0, name
        assert ("a", "j") in draft.template.symmetry

    def test_a_dash_skips_a_corner(self, shirt: Template) -> None:
        names = ["a", "-", "c", "d", "e", "f", "g", "h", "-", "j"]
        draft = draft_template(shirt.outline, "t-shirt", landmarks=names)
        assert list(draft.template.landmarks) == [name for name in names if name != "-"]

    def test_a_number_of_corners_there_is_not_is_told(self, shirt: Template) -> None:
        with pytest.raises(ParameterError, match=r"2 landmarks .* offers .*10"):
            draft_template(shirt.outline, "t-shirt", landmarks=["a", "b"])

    def test_a_name_given_twice_is_refused(self, shirt: Template) -> None:
        with pytest.raises(TemplateError, match="given twice") as caught:
            draft_template(shirt.outline, "t-shirt", landmarks=list("abcdefghia"))
        assert caught.value.field == "landmarks.a"

    def test_symmetric_ones_are_their_own_mirror_image(self, shirt: Template) -> None:
        draft = draft_template(with_limb_turned(shirt, 10.0), "t-shirt", symmetric=True, px_per_cm=1.0)
        template = draft.template
        image = template.outline * [-1.0, 1.0]
        _, off, _ = _core.nearest_on_outline(template.outline, image)
        assert off.max() < 0.02
        for a, b in template.symmetry:
            np.testing.assert_allclose(template.landmarks[a], template.landmarks[b] * [-1.0, 1.0], atol=0.011)

    def test_the_map_carries_the_outline_onto_the_template(self, builtin: Template) -> None:
        outline = turned(builtin.outline, 5.0)
        draft = draft_template(outline, builtin.garment_type, px_per_cm=4.0)
        assert _core.outline_iou(apply(draft.to_template, outline), draft.template.outline) > 0.97

    def test_the_size_is_that_told(self, shirt: Template) -> None:
        longer = np.ptp(draft_template(shirt.outline, "t-shirt", size_cm=80.0).template.outline, axis=0).max()
        assert longer == pytest.approx(80.0, rel=0.02)
        for wrong in ({"size_cm": 0.0}, {"px_per_cm": math.nan}, {"size_cm": 60.0, "px_per_cm": 4.0}):
            with pytest.raises(ParameterError):
                draft_template(shirt.outline, "t-shirt", **wrong)

    def test_what_is_no_outline_is_refused(self) -> None:
        with pytest.raises(InvalidOutlineError):
            draft_template([[0, 0], [1, 1]], "towel")

    def test_a_landmark_off_the_outline_is_named(self, shirt: Template) -> None:
        with pytest.raises(TemplateError, match="off the outline") as caught:
            draft_template(shirt.outline, "t-shirt", landmarks={"pocket": [0.0, 40.0]})
        assert caught.value.field == "landmarks.pocket"

    def test_real_garments_give_templates(self, real_outlines: tuple[NDArray[np.float64], ...]) -> None:
        for outline in real_outlines[::40]:
            template = draft_template(outline, "some", size_cm=60.0).template
            assert 3 <= len(template.landmarks) <= 30


def test_grasp_pairs_are_wide_mirror_pairs_of_the_hull_first(shirt: Template) -> None:
    pairs = grasp_pairs(shirt.landmarks, shirt.symmetry)
    assert pairs[0][0] == ("sleeve_left_top", "sleeve_right_top")
    assert "hull" in pairs[0][1]
    places = [reason.split(",")[0] for _, reason in pairs]
    assert places == sorted(
        places, key=["mirror pair on the hull", "mirror pair within the hull", "one side"].index
    )
    inner = [pair for pair, reason in pairs if "within" in reason]
    assert ("armpit_left", "armpit_right") in inner


class TestMean:
    @pytest.fixture
    def drafts(self, shirt: Template) -> list[Draft]:
        wide = SynthParameters(shape_cm=3.0, asymmetry_cm=0.5, rim_cm=0.0, size_range=(1.0, 1.0))
        drafts = []
        for seed in range(6):
            garment = vary(checked(shirt), np.random.default_rng(seed), wide)
            drafts.append(
                draft_template(garment.outline, "t-shirt", landmarks=dict(garment.landmarks), px_per_cm=1.0)
            )
        return drafts

    def test_proportions_are_nearer_to_the_kind_than_one_garments(
        self, shirt: Template, drafts: list[Draft]
    ) -> None:
        def overlap(template: Template) -> float:
            one, other = (_core.resample(t.outline, 200) for t in (template, shirt))
            return _core.outline_iou(one - one.mean(axis=0), other - other.mean(axis=0))

        mean = mean_template(drafts)
        assert overlap(mean) > np.mean([overlap(draft.template) for draft in drafts])

    def test_spreads_tell_how_far_garments_differ(self, drafts: list[Draft]) -> None:
        mean = mean_template(drafts)
        same = mean_template([drafts[0]] * 6)
        assert set(mean.spread) == set(mean.landmarks)
        assert all(same.spread[name] < mean.spread[name] for name in mean.spread)
        unshrunk = mean_template(drafts, parameters=replace(P, usual_garments=0.0))
        assert 0.5 < np.mean(list(unshrunk.spread.values())) < 4.0

    def test_garments_without_names_are_matched_by_shape(self, shirt: Template, drafts: list[Draft]) -> None:
        unnamed = [draft_template(draft.outline, "t-shirt", px_per_cm=1.0) for draft in drafts]
        by_shape, by_name = mean_template(unnamed), mean_template(drafts)
        assert _core.outline_iou(by_shape.outline, by_name.outline) > 0.93

    def test_what_does_not_belong_together_is_refused(self, shirt: Template, drafts: list[Draft]) -> None:
        with pytest.raises(ParameterError, match="two garments"):
            mean_template(drafts[:1])
        other = draft_template(shirt.outline, "vest")
        with pytest.raises(ParameterError, match="several kinds"):
            mean_template([drafts[0], other])
        with pytest.raises(ParameterError, match="different names"):
            mean_template([drafts[0], draft_template(shirt.outline, "t-shirt")])


class TestSpread:
    def test_it_is_written_and_read_again(self, shirt: Template, tmp_path) -> None:
        spread = {"collar_left": 2.0, "hem_left": 5.5}
        save_template(replace(shirt, spread=spread), tmp_path / "t.json")
        assert dict(load_template(tmp_path / "t.json").spread) == spread
        assert "spread" not in shirt.to_dict()

    @pytest.mark.parametrize(
        ("spread", "field"),
        [({"nose": 1.0}, "spread.nose"), ({"hem_left": 0}, "spread.hem_left"), ([1.0], "spread")],
    )
    def test_what_is_wrong_is_named(self, shirt: Template, spread: object, field: str) -> None:
        with pytest.raises(TemplateError) as caught:
            Template.from_dict({**shirt.to_dict(), "spread": spread}, name="t")
        assert caught.value.field == field

    def test_between_landmarks_it_changes_along_the_outline(self) -> None:
        towel = builtin_templates("towel")[0]
        assert vertex_spreads(towel) is None
        half = replace(towel, spread={"corner_1": 2.0, "corner_3": 4.0})
        spreads = vertex_spreads(half)
        assert spreads is not None
        np.testing.assert_allclose(spreads, [2.0, 3.13, 4.0, 2.87], atol=0.01)

    def test_the_joint_fit_heeds_it(self) -> None:
        import foldrs

        skirt = builtin_templates("skirt")[0]
        axis = np.array([[-60.0, 30.0], [60.0, 32.0]])
        folded = 4.0 * _core.fold_layers(skirt.outline * [1.25, 1.0], axis).outline
        tight = replace(skirt, spread=dict.fromkeys(skirt.landmarks, 0.5))

        def off(template: Template) -> float:
            fitted = foldrs.fit(folded, templates=[template], px_per_cm=4.0).template
            width = np.ptp(fitted.outline[:, 0]) / np.ptp(fitted.outline[:, 1])
            given = np.ptp(skirt.outline[:, 0]) / np.ptp(skirt.outline[:, 1])
            return abs(width / given - 1)

        assert off(tight) < off(skirt)
