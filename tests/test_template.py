"""Templates: what is built in, what is refused and how the refusal is worded, saving, pictures."""

from __future__ import annotations

import copy
import json
import math
import pickle
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from foldrs.errors import FoldrsError, TemplateError
from foldrs.pipeline import choose_templates
from foldrs.template import Template, builtin_templates, load_template, save_template
from foldrs.template_plot import draw_template, save_template_picture

LANDMARKS = {
    "t-shirt": "collar_left sleeve_left_top sleeve_left_bottom armpit_left hem_left "
    "hem_right armpit_right sleeve_right_bottom sleeve_right_top collar_right",
    "shirt": "collar_left cuff_left_outer cuff_left_inner armpit_left hem_left "
    "hem_right armpit_right cuff_right_inner cuff_right_outer collar_right",
    "pants": "waist_left hem_left_outer hem_left_inner crotch hem_right_inner hem_right_outer waist_right",
    "shorts": "waist_left hem_left_outer hem_left_inner crotch hem_right_inner hem_right_outer waist_right",
    "skirt": "waist_left hem_left hem_right waist_right",
    "towel": "corner_1 corner_2 corner_3 corner_4",
}


def kite() -> dict:
    """A small valid template: symmetric about x = 0, with one landmark on the mirror axis."""
    return {
        "schema": 1,
        "type": "kite",
        "units": "cm",
        "outline": [[0, 0], [-10, 10], [0, 40], [10, 10]],
        "landmarks": {"top": [0, 0], "left": [-10, 10], "tail": [0, 40], "right": [10, 10]},
        "symmetry": [["left", "right"], ["top", "top"]],
        "grasp_pairs": [["left", "right"], ["top", "tail"], ["top", "left"]],
    }


@pytest.fixture(params=builtin_templates(), ids=lambda template: template.name)
def builtin(request) -> Template:
    return request.param


class TestBuiltin:
    def test_there_are_templates_of_every_kind_the_one_named_like_it_first(self):
        assert {template.garment_type for template in builtin_templates()} == set(LANDMARKS)
        for kind in LANDMARKS:
            assert builtin_templates(kind)[0].name == kind

    def test_landmarks_and_their_order(self, builtin):
        assert list(builtin.landmarks) == LANDMARKS[builtin.garment_type].split()

    def test_landmarks_are_corners_in_order_along_the_outline(self, builtin):
        corners = builtin.outline.tolist()
        places = [corners.index(point.tolist()) for point in builtin.landmarks.values()]
        assert places == sorted(places)

    def test_outline_is_its_own_mirror_image(self, builtin):
        mirrored = {(-x, y) for x, y in builtin.outline.tolist()}
        assert mirrored == {(x, y) for x, y in builtin.outline.tolist()}

    def test_symmetric_landmarks_are_mirror_images(self, builtin):
        for a, b in builtin.symmetry:
            np.testing.assert_array_equal(builtin.landmarks[a] * [-1, 1], builtin.landmarks[b])

    def test_every_landmark_has_a_mirror_image(self, builtin):
        assert {name for pair in builtin.symmetry for name in pair} == set(builtin.landmarks)

    def test_left_is_left_and_the_garment_upright(self, builtin):
        assert all(x < 0 for name, (x, _) in builtin.landmarks.items() if "left" in name)
        assert all(x > 0 for name, (x, _) in builtin.landmarks.items() if "right" in name)
        points = builtin.landmark_array
        assert points[0, 1] == points[-1, 1] < builtin.outline[:, 1].mean()

    def test_grasp_pairs_prefer_mirror_images_and_favour_no_side(self, builtin):
        image = {a: b for pair in builtin.symmetry for a, b in (pair, pair[::-1])}
        assert image[builtin.grasp_pairs[0][0]] == builtin.grasp_pairs[0][1]
        pairs = {frozenset(pair) for pair in builtin.grasp_pairs}
        assert pairs == {frozenset(image[name] for name in pair) for pair in pairs}

    def test_size_of_an_adult_garment_in_centimetres(self, builtin):
        assert builtin.units == "cm"
        assert 35 < math.sqrt(builtin.area) < 75

    def test_chosen_by_kind(self):
        assert {template.garment_type for template in builtin_templates("skirt")} == {"skirt"}

    def test_all_compete_where_the_kind_is_not_known_and_those_of_the_kind_where_it_is(self):
        assert choose_templates(None, None) == list(builtin_templates())
        for kind in LANDMARKS:
            assert choose_templates(None, kind) == list(builtin_templates(kind))

    def test_the_published_method_has_one_template_a_kind(self):
        assert [template.name for template in choose_templates(None, None, "paper")] == sorted(LANDMARKS)
        for kind in LANDMARKS:
            assert [template.name for template in choose_templates(None, kind, "paper")] == [kind]

    def test_unknown_kind_names_the_known_ones(self):
        with pytest.raises(TemplateError, match="'sock'") as caught:
            builtin_templates("sock")
        assert all(kind in str(caught.value) for kind in LANDMARKS)


class TestTemplate:
    def test_fields(self):
        template = Template.from_dict(kite(), name="small kite")
        assert (template.name, template.garment_type, template.units) == ("small kite", "kite", "cm")
        assert template.outline.dtype == np.float64
        assert template.area == 400
        assert template.landmark_array.tolist() == [[0, 0], [-10, 10], [0, 40], [10, 10]]
        assert template.symmetry == (("left", "right"), ("top", "top"))
        assert template.grasp_pairs[0] == ("left", "right")

    def test_either_winding(self):
        data = kite()
        data["outline"].reverse()
        assert Template.from_dict(data, name="kite").area == 400

    def test_symmetry_is_optional(self):
        data = kite()
        del data["symmetry"]
        assert Template.from_dict(data, name="kite").symmetry == ()

    def test_cannot_be_changed(self):
        template = Template.from_dict(kite(), name="kite")
        with pytest.raises(ValueError, match="read-only"):
            template.outline[0] = 1
        with pytest.raises(ValueError, match="read-only"):
            template.landmarks["top"][0] = 1
        with pytest.raises(TypeError):
            template.landmarks["top"] = np.zeros(2)
        with pytest.raises(AttributeError):
            template.name = "other"

    def test_does_not_share_the_arrays_it_is_made_of(self):
        data = kite() | {"outline": np.array(kite()["outline"], dtype=float)}
        template = Template.from_dict(data, name="kite")
        data["outline"][:] = 0
        assert template.area == 400

    @pytest.mark.parametrize("duplicate", [copy.deepcopy, lambda t: pickle.loads(pickle.dumps(t))])
    def test_copies_and_travels_between_processes(self, duplicate):
        template = Template.from_dict(kite(), name="kite")
        twin = duplicate(template)
        assert (twin.name, twin.to_dict()) == (template.name, template.to_dict())
        assert not twin.outline.flags.writeable

    def test_landmark_off_by_rounding_is_moved_onto_the_outline(self):
        data = kite()
        data["landmarks"]["tail"] = [0, 40.05]
        assert Template.from_dict(data, name="kite").landmarks["tail"].tolist() == [0, 40]

    def test_landmark_may_lie_within_an_edge(self):
        data = kite()
        data["landmarks"]["tail"] = [5, 25]
        assert Template.from_dict(data, name="kite").landmarks["tail"].tolist() == [5, 25]


def changed(**fields) -> dict:
    return kite() | fields


def without(field: str) -> dict:
    return {name: value for name, value in kite().items() if name != field}


def outline_with(point: object, at: int = 2) -> dict:
    data = kite()
    data["outline"][at] = point
    return data


def landmark(name: str, point: object) -> dict:
    data = kite()
    data["landmarks"][name] = point
    return data


REFUSED = {
    "no schema": (without("schema"), "schema", "missing"),
    "other schema": (changed(schema=2), "schema", "must be 1"),
    "schema of another type": (changed(schema=True), "schema", "must be 1"),
    "no type": (without("type"), "type", "missing"),
    "empty type": (changed(type=" "), "type", "empty"),
    "type of two lines": (changed(type="a\nb"), "type", "printable"),
    "type is no text": (changed(type=3), "type", "text"),
    "no units": (without("units"), "units", "missing"),
    "units are no text": (changed(units=None), "units", "text"),
    "no outline": (without("outline"), "outline", "missing"),
    "outline is no list": (changed(outline={"x": 1}), "outline", "list"),
    "point is no list": (outline_with(7), "outline[2]", "list"),
    "point of three numbers": (outline_with([0, 40, 1]), "outline[2]", "two numbers"),
    "coordinate is a text": (outline_with([0, "40"]), "outline[2]", "'40'"),
    "coordinate is a bool": (outline_with([0, True]), "outline[2]", "True"),
    "coordinate is NaN": (outline_with([0, math.nan]), "outline[2]", "finite"),
    "coordinate is infinite": (outline_with([0, -math.inf]), "outline[2]", "finite"),
    "coordinate beyond floats": (outline_with([0, 10**400]), "outline[2]", "finite"),
    "no points": (changed(outline=[]), "outline", ""),
    "two points": (changed(outline=[[0, 0], [1, 1]]), "outline", ""),
    "first point repeated": (changed(outline=[*kite()["outline"], [0, 0]]), "outline[4]", "repeats"),
    "point repeated": (outline_with([-10, 10]), "outline[2]", "repeats"),
    "edges cross": (changed(outline=[[0, 0], [10, 40], [-10, 40], [10, 10]]), "outline", "cross"),
    "bow tie": (changed(outline=[[0, 0], [10, 40], [10, 0], [0, 40]]), "outline", "crosses itself"),
    "no area": (changed(outline=[[0, 0], [1, 1], [2, 2]]), "outline", ""),
    "area beyond floats": (changed(outline=[[0, 0], [-1e200, 1e200], [1e200, 1e200]]), "outline", ""),
    "no landmarks": (without("landmarks"), "landmarks", "missing"),
    "landmarks are a list": (changed(landmarks=[[0, 0]]), "landmarks", "names"),
    "not one landmark": (changed(landmarks={}, symmetry=[], grasp_pairs=[]), "landmarks", "at least one"),
    "landmark without a name": (
        landmark(" ", [0, 0]),
        "landmarks",
        "the name of a landmark must be a text that is not empty",
    ),
    "landmark of one number": (landmark("tail", [0]), "landmarks.tail", "two numbers"),
    "landmark is NaN": (landmark("tail", [math.nan, 40]), "landmarks.tail", "finite"),
    "landmark outside": (landmark("tail", [0, 46]), "landmarks.tail", "off the outline"),
    "landmark inside": (landmark("tail", [0, 20]), "landmarks.tail", "off the outline"),
    "symmetry is no list": (changed(symmetry="left right"), "symmetry", "list"),
    "mirror image unknown": (changed(symmetry=[["left", "rigth"]]), "symmetry[0][1]", "'rigth'"),
    "three mirror images": (changed(symmetry=[["left", "right", "top"]]), "symmetry[0]", "two landmarks"),
    "mirrored twice": (changed(symmetry=[["left", "right"], ["top", "left"]]), "symmetry[1]", "'left'"),
    "no grasp pairs": (without("grasp_pairs"), "grasp_pairs", "missing"),
    "grasp pairs are no list": (changed(grasp_pairs=1), "grasp_pairs", "list"),
    "grasp pair is no list": (changed(grasp_pairs=["left"]), "grasp_pairs[0]", "list"),
    "grasp pair of one": (changed(grasp_pairs=[["left"]]), "grasp_pairs[0]", "two landmarks"),
    "grasp point is no text": (changed(grasp_pairs=[["left", 1]]), "grasp_pairs[0][1]", "text"),
    "grasp point unknown": (
        changed(grasp_pairs=[["left", "right"], ["top", "tail"], ["crotch", "top"]]),
        "grasp_pairs[2][0]",
        "'crotch'",
    ),
    "grasp point twice": (changed(grasp_pairs=[["top", "top"]]), "grasp_pairs[0]", "twice"),
    "grasp pair twice": (
        changed(grasp_pairs=[["top", "tail"], ["tail", "top"]]),
        "grasp_pairs[1]",
        "already",
    ),
}


class TestErrors:
    @pytest.mark.parametrize(("data", "field", "says"), REFUSED.values(), ids=REFUSED.keys())
    def test_error_names_the_field(self, data, field, says):
        with pytest.raises(TemplateError) as caught:
            Template.from_dict(data, name="bad")
        assert caught.value.field == field
        assert str(caught.value).startswith(f"{field}: ")
        assert says in str(caught.value)

    @pytest.mark.parametrize(("data", "field", "says"), REFUSED.values(), ids=REFUSED.keys())
    def test_error_of_a_file_names_the_file_too(self, tmp_path, data, field, says):
        path = tmp_path / "bad.json"
        path.write_text(json.dumps(data))
        with pytest.raises(TemplateError) as caught:
            load_template(path)
        assert caught.value.field == field
        assert str(caught.value).startswith(f"{path}: {field}: ")

    @pytest.mark.parametrize("data", [None, 3, "pants", [kite()]])
    def test_not_an_object(self, data):
        with pytest.raises(TemplateError, match="object"):
            Template.from_dict(data, name="bad")

    @pytest.mark.parametrize(
        "content",
        [b"", b"{", b"\xff\xfe\x00", b"[" * 100_000, b"<xml/>", b"1" * 5000],
        ids=["empty", "cut", "binary", "deep", "xml", "digits"],
    )
    def test_not_json(self, tmp_path, content):
        path = tmp_path / "bad.json"
        path.write_bytes(content)
        with pytest.raises(TemplateError, match=r"bad\.json: not a template file") as caught:
            load_template(path)
        assert caught.value.field == ""

    @pytest.mark.parametrize(
        ("text", "twice", "field"),
        [
            ('"type": "kite"', '"type": "kite", "type": "kite"', "type"),
            ('"top": [0, 0]', '"top": [0, 0], ' * 2 + '"x": [0, 0]', "landmarks.top"),
            ('"type": "kite"', '"type": "kite", "spread": {"top": 1, "top": 2}', "spread.top"),
        ],
        ids=["field", "landmark", "spread"],
    )
    def test_name_given_twice(self, tmp_path, text, twice, field):
        path = tmp_path / "twice.json"
        path.write_text(json.dumps(kite()).replace(text, twice))
        with pytest.raises(TemplateError, match="given twice") as caught:
            load_template(path)
        assert caught.value.field == field

    def test_file_missing_or_a_folder(self, tmp_path):
        with pytest.raises(TemplateError, match="no such template file"):
            load_template(tmp_path / "missing.json")
        with pytest.raises(TemplateError, match="cannot be read"):
            load_template(tmp_path)

    def test_caught_as_value_error_and_as_foldrs_error(self, tmp_path):
        for kind in (ValueError, FoldrsError):
            with pytest.raises(kind):
                load_template(tmp_path / "missing.json")


@st.composite
def star_templates(draw) -> Template:
    """Random simple polygons, star-shaped about the origin, with some corners as landmarks."""
    n = draw(st.integers(3, 12))
    radii = draw(st.lists(st.floats(1, 100), min_size=n, max_size=n))
    turn = draw(st.floats(0, 2 * math.pi))
    angles = turn + 2 * math.pi * np.arange(n) / n
    outline = np.array(radii)[:, None] * np.c_[np.cos(angles), np.sin(angles)]
    names = draw(st.lists(st.sampled_from("abcdefghäß雪 x"), min_size=2, max_size=n, unique=True))
    names = [f"{name}{i}" for i, name in enumerate(names)][:n]
    return Template(
        name="star",
        garment_type=draw(st.sampled_from(["star", "Halstuch für Ärzte"])),
        units="mm",
        outline=outline,
        landmarks=dict(zip(names, outline, strict=False)),
        symmetry=((names[0], names[-1]),),
        grasp_pairs=((names[0], names[1]),),
    )


class TestFiles:
    @given(template=star_templates())
    def test_saved_and_loaded_is_the_same(self, tmp_path_factory, template):
        path = tmp_path_factory.mktemp("templates") / "star.json"
        save_template(template, path)
        loaded = load_template(path)
        assert loaded.name == "star"
        assert loaded.to_dict() == template.to_dict()

    @given(template=star_templates())
    def test_dict_is_plain_json_and_makes_the_same_template(self, template):
        data = json.loads(json.dumps(template.to_dict()))
        assert Template.from_dict(data, name="star").to_dict() == template.to_dict()

    def test_builtin_round_trip(self, tmp_path, builtin):
        path = tmp_path / f"{builtin.name}.json"
        save_template(builtin, path)
        assert load_template(path).to_dict() == builtin.to_dict()

    def test_name_is_the_stem_so_a_kind_may_have_several(self, tmp_path):
        for name in ("kite-wide", "kite-long"):
            (tmp_path / f"{name}.json").write_text(json.dumps(kite()))
        wide, long = (load_template(tmp_path / f"{name}.json") for name in ("kite-wide", "kite-long"))
        assert (wide.name, long.name) == ("kite-wide", "kite-long")
        assert wide.garment_type == long.garment_type == "kite"

    def test_byte_order_mark_is_no_obstacle(self, tmp_path):
        path = tmp_path / "kite.json"
        path.write_text(json.dumps(kite()), encoding="utf-8-sig")
        assert load_template(path).garment_type == "kite"

    def test_saving_replaces_and_leaves_nothing_beside(self, tmp_path):
        path = tmp_path / "kite.json"
        path.write_text("old")
        save_template(Template.from_dict(kite(), name="kite"), path)
        assert load_template(path).garment_type == "kite"
        assert [file.name for file in tmp_path.iterdir()] == ["kite.json"]

    def test_failure_leaves_the_old_file(self, tmp_path, monkeypatch):
        path = tmp_path / "kite.json"
        path.write_text("old")

        def full_disk(self, target):
            raise OSError(28, "No space left on device")

        monkeypatch.setattr("pathlib.Path.replace", full_disk)
        with pytest.raises(TemplateError, match="No space left"):
            save_template(Template.from_dict(kite(), name="kite"), path)
        assert path.read_text() == "old"
        assert [file.name for file in tmp_path.iterdir()] == ["kite.json"]

    def test_saving_into_a_missing_folder(self, tmp_path):
        with pytest.raises(TemplateError, match="cannot be written"):
            save_template(Template.from_dict(kite(), name="kite"), tmp_path / "missing" / "kite.json")


class TestPicture:
    def test_picture_is_written(self, tmp_path, builtin):
        cv2 = pytest.importorskip("cv2")
        path = tmp_path / "template.png"
        save_template_picture(builtin, path)
        picture = cv2.imread(str(path))
        assert min(picture.shape[:2]) > 300
        assert (picture < 128).any()

    def test_names_numbers_and_scale_are_shown(self, builtin):
        ax = draw_template(builtin)
        texts = [text.get_text() for text in ax.texts]
        assert {name.replace("_", " ") for name in builtin.landmarks} <= set(texts)
        assert {str(rank + 1) for rank in range(len(builtin.grasp_pairs))} <= set(texts)
        assert any(text.endswith(" cm") for text in texts)
        assert builtin.name in ax.get_title()

    def test_names_do_not_overlap(self, builtin):
        figure = draw_template(builtin).figure
        figure.canvas.draw()
        names = {name.replace("_", " ") for name in builtin.landmarks}
        boxes = [text.get_window_extent() for text in figure.axes[0].texts if text.get_text() in names]
        assert not any(a.overlaps(b) for i, a in enumerate(boxes) for b in boxes[:i])

    def test_y_runs_down_in_the_given_axes(self):
        figure = pytest.importorskip("matplotlib.figure").Figure()
        ax = figure.add_subplot()
        template = Template.from_dict(kite(), name="kite")
        assert draw_template(template, ax) is ax
        draw_template(template, ax)
        assert ax.yaxis_inverted()

    def test_without_symmetry_or_grasp_pairs(self, tmp_path):
        data = kite() | {"symmetry": [], "grasp_pairs": []}
        save_template_picture(Template.from_dict(data, name="kite"), tmp_path / "kite.svg")
        assert "<svg" in (tmp_path / "kite.svg").read_text()

    @pytest.mark.parametrize("name", ["missing/kite.png", "kite.nonsense"])
    def test_picture_that_cannot_be_written(self, tmp_path, name):
        with pytest.raises(TemplateError, match="cannot be written"):
            save_template_picture(Template.from_dict(kite(), name="kite"), tmp_path / name)


CORNERS = kite()["outline"]
MARKS = kite()["landmarks"]


class TestConstructor:
    @pytest.mark.parametrize(
        ("changes", "field"),
        [
            ({"outline": [["a", "b"]] * 3}, "outline"),
            ({"outline": [["0", "0"], ["-10", "10"], ["0", "40"]]}, "outline"),
            ({"outline": [[0, 0], [1]]}, "outline"),
            ({"outline": None}, "outline"),
            ({"outline": np.array(CORNERS) * 1j}, "outline"),
            ({"outline": [[0, 0, 0], [-10, 10, 0], [0, 40, 0]]}, "outline"),
            ({"outline": [[0, 0], [-10, math.nan], [0, 40]]}, "outline"),
            ({"landmarks": MARKS | {"top": [0, 0, 0]}}, "landmarks.top"),
            ({"landmarks": MARKS | {"top": "here"}}, "landmarks.top"),
            ({"landmarks": MARKS | {"top": None}}, "landmarks.top"),
            ({"landmarks": MARKS | {"top": [0, math.inf]}}, "landmarks.top"),
            ({"landmarks": [[0, 0]]}, "landmarks"),
            ({"symmetry": "ab"}, "symmetry"),
            ({"symmetry": [["left", "right", "top"]]}, "symmetry[0]"),
            ({"grasp_pairs": [["left"]]}, "grasp_pairs[0]"),
            ({"grasp_pairs": [3]}, "grasp_pairs[0]"),
            ({"spread": {"top": "wide"}}, "spread.top"),
            ({"spread": 3}, "spread"),
        ],
    )
    def test_what_is_no_template_is_refused_by_field(self, changes, field):
        given = {"outline": CORNERS, "landmarks": MARKS} | changes
        with pytest.raises(TemplateError) as caught:
            Template("kite", "kite", "cm", **given)
        assert caught.value.field == field
        assert str(caught.value).startswith(f"{field}: ")

    def test_shares_nothing_with_what_it_is_made_of(self):
        pairs, best, spread = [["left", "right"]], [["top", "tail"]], {"top": 2}
        marks = {name: np.array(point, float) for name, point in MARKS.items()}
        template = Template("kite", "kite", "cm", CORNERS, marks, pairs, best, spread)
        before = json.dumps(template.to_dict())
        for changed_later in (pairs, best):
            changed_later[0][0] = "nowhere"
            changed_later.append(["left", "left"])
        spread["top"] = -1
        marks["top"][:] = 7
        assert json.dumps(template.to_dict()) == before
        assert template.symmetry == (("left", "right"),)
        assert template.grasp_pairs == (("top", "tail"),)

    def test_threads_may_save_to_one_path(self, tmp_path):
        template = Template.from_dict(kite(), name="kite")
        with ThreadPoolExecutor(8) as pool:
            list(pool.map(lambda _: save_template(template, tmp_path / "kite.json"), range(200)))
        assert load_template(tmp_path / "kite.json").to_dict() == template.to_dict()
        assert [file.name for file in tmp_path.iterdir()] == ["kite.json"]
