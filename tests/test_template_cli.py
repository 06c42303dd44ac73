"""The commands `foldrs template ...`, annotations included."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner, Result

from foldrs import _core
from foldrs.cli import main
from foldrs.drafting.annotations import read_coco, read_labelme
from foldrs.errors import TemplateError
from foldrs.synth import SynthParameters, make_scene
from foldrs.template import builtin_templates, load_template, save_template

SHIRT = builtin_templates("t-shirt")[0]
MARKS = {name: (4.0 * point + 200.0).tolist() for name, point in SHIRT.landmarks.items()}
OUTLINE = (4.0 * SHIRT.outline + 200.0).tolist()


def foldrs(*arguments: object) -> Result:
    return CliRunner().invoke(main, ["template", *(str(argument) for argument in arguments)])


def labelme() -> dict[str, Any]:
    points = [{"label": name, "points": [at], "shape_type": "point"} for name, at in MARKS.items()]
    polygon = {"label": "t-shirt", "points": OUTLINE, "shape_type": "polygon", "group_id": None}
    return {"version": "5.0.1", "flags": {}, "shapes": [polygon, *points], "imagePath": "shirt.jpg"}


def coco() -> dict[str, Any]:
    keypoints = [value for at in MARKS.values() for value in (*at, 2)]
    one = {
        "id": 7,
        "image_id": 3,
        "category_id": 1,
        "segmentation": [[value for point in OUTLINE for value in point]],
        "keypoints": keypoints,
        "num_keypoints": len(MARKS),
    }
    return {
        "images": [{"id": 3, "file_name": "shirt.jpg"}],
        "annotations": [one],
        "categories": [{"id": 1, "name": "t-shirt", "keypoints": list(MARKS)}],
    }


@pytest.fixture(scope="module")
def flat(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    """Photographs of two flat T-shirts, 4 px/cm."""
    folder = tmp_path_factory.mktemp("flat")
    for seed in (1, 2):
        make_scene(SHIRT, seed=seed, parameters=SynthParameters(folds=0)).write(folder, f"flat-{seed}")
    return sorted(folder.glob("*.jpg"))


class TestFromPhoto:
    def test_template_and_picture_are_written(self, flat: list[Path], tmp_path: Path) -> None:
        out = tmp_path / "mine.json"
        done = foldrs("from-photo", flat[0], "--kind", "tee", "--px-per-cm", 4, "--out", out, "--plot")
        assert done.exit_code == 0, done.output
        template = load_template(out)
        assert template.garment_type == "tee"
        truth = json.loads(flat[0].with_suffix(".json").read_text())
        true_area = abs(_core.signed_area(np.array(truth["outline_garment"]))) / 16
        assert template.area == pytest.approx(true_area, rel=0.05)
        assert len(template.symmetry) >= 4
        assert out.with_suffix(".png").stat().st_size > 10_000
        assert "mirror pair on the hull" in done.output

    def test_several_make_their_mean(self, flat: list[Path], tmp_path: Path) -> None:
        out = tmp_path / "mine.json"
        done = foldrs("from-photo", *flat, "--kind", "tee", "--px-per-cm", 4, "--out", out)
        assert done.exit_code == 0, done.output
        template = load_template(out)
        assert set(template.spread) == set(template.landmarks)

    def test_an_assumed_size_is_told(self, flat: list[Path], tmp_path: Path) -> None:
        done = foldrs("from-photo", flat[0], "--kind", "tee", "--out", tmp_path / "t.json")
        assert "size is assumed" in done.output

    @pytest.mark.parametrize(
        ("more", "status", "told"),
        [
            (["--kind", "tee", "--landmarks", "a,b"], 1, "2 landmarks are named"),
            (["--kind", "tee", "--px-per-cm", "-1"], 1, "px_per_cm"),
            ([], 2, "--kind"),
            (["--kind", "tee", "--px-per-cm", "4", "--size-cm", "70"], 2, "--size-cm"),
        ],
    )
    def test_what_is_wrong_is_told_and_nothing_written(
        self, flat: list[Path], tmp_path: Path, more: list[str], status: int, told: str
    ) -> None:
        out = tmp_path / "t.json"
        done = foldrs("from-photo", flat[0], "--out", out, *more)
        assert done.exit_code == status
        assert told in done.output
        assert not out.exists()

    def test_a_bad_photograph_among_several_is_named(self, flat: list[Path], tmp_path: Path) -> None:
        bad = tmp_path / "bad.jpg"
        bad.write_text("no image")
        done = foldrs("from-photo", flat[0], bad, "--kind", "tee", "--out", tmp_path / "t.json")
        assert done.exit_code == 1
        assert "bad.jpg" in done.output

    def test_inputs_are_never_overwritten(self, flat: list[Path], tmp_path: Path) -> None:
        photo, mask = tmp_path / "flat.png", tmp_path / "mask.png"
        photo.write_bytes(flat[0].read_bytes())
        mask.write_bytes(flat[0].with_name("flat-1.mask.png").read_bytes())
        truth = tmp_path / "truth.json"
        truth.write_bytes(flat[0].with_suffix(".json").read_bytes())
        before = {path: path.read_bytes() for path in tmp_path.iterdir()}
        for out, plot, told in (
            ("flat.png", [], "*.json"),
            ("flat.json", ["--plot"], "overwritten"),
            ("mask.json", ["--plot", "--mask", mask], "overwritten"),
            ("truth.json", [], "no template file"),
        ):
            done = foldrs("from-photo", photo, "--kind", "tee", "--out", tmp_path / out, *plot)
            assert done.exit_code == 2, done.output
            assert told in done.output
            assert {path: path.read_bytes() for path in tmp_path.iterdir()} == before
        out = tmp_path / "mine.json"
        for _ in range(2):  # a template may be made again
            assert foldrs("from-photo", photo, "--kind", "tee", "--out", out, "--plot").exit_code == 0

    def test_a_kind_may_not_lead_elsewhere(
        self, flat: list[Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        (tmp_path / "here").mkdir()
        monkeypatch.chdir(tmp_path / "here")
        done = foldrs("from-photo", flat[0], "--kind", "../v2")
        assert done.exit_code == 2
        assert "--kind" in done.output
        assert [path.name for path in tmp_path.rglob("*")] == ["here"]
        assert foldrs("from-photo", flat[0], "--kind", "../v2", "--out", "v2.json").exit_code == 0


class TestAnnotations:
    @pytest.mark.parametrize(("command", "content"), [("from-labelme", labelme()), ("from-coco", coco())])
    def test_annotations_are_never_overwritten(self, tmp_path: Path, command: str, content: Any) -> None:
        source, other = tmp_path / "marked.json", tmp_path / "other.json"
        source.write_text(json.dumps(content))
        other.write_text(json.dumps(content))
        (tmp_path / "link.json").symlink_to("marked.json")
        for out in (source, other, tmp_path / "link.json", tmp_path / "mine.txt"):
            done = foldrs(command, source, "--out", out)
            assert done.exit_code == 2, done.output
            assert out.name in done.output
        assert json.loads(source.read_text()) == json.loads(other.read_text()) == content
        assert len(list(tmp_path.iterdir())) == 3

    def test_a_label_may_not_lead_elsewhere(self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        content = labelme()
        content["shapes"][0]["label"] = "../v2"
        (tmp_path / "here").mkdir()
        monkeypatch.chdir(tmp_path / "here")
        Path("marked.json").write_text(json.dumps(content))
        done = foldrs("from-labelme", "marked.json")
        assert done.exit_code == 1
        assert "can name no file" in done.output
        assert not (tmp_path / "v2.json").exists()

    @pytest.mark.parametrize(("command", "content"), [("from-labelme", labelme()), ("from-coco", coco())])
    def test_names_and_places_are_kept(self, tmp_path: Path, command: str, content: Any) -> None:
        source, out = tmp_path / "marked.json", tmp_path / "template.json"
        source.write_text(json.dumps(content))
        done = foldrs(command, source, "--px-per-cm", 4, "--out", out)
        assert done.exit_code == 0, done.output
        template = load_template(out)
        assert template.garment_type == "t-shirt"
        assert list(template.landmarks) == list(MARKS)
        for name, point in SHIRT.landmarks.items():
            np.testing.assert_allclose(template.landmarks[name], point, atol=0.6)
        assert {frozenset(pair) for pair in SHIRT.symmetry} <= {frozenset(pair) for pair in template.symmetry}

    def test_a_keypoint_that_is_not_labelled_is_left_out(self, tmp_path: Path) -> None:
        content = coco()
        content["annotations"][0]["keypoints"][:3] = [0, 0, 0]
        path = tmp_path / "coco.json"
        path.write_text(json.dumps(content))
        assert list(read_coco(path).landmarks) == list(MARKS)[1:]

    @pytest.mark.parametrize(
        ("change", "field"),
        [
            (lambda d: d.pop("shapes"), "shapes"),
            (lambda d: d["shapes"][0].update(shape_type="circle"), "shapes[0].shape_type"),
            (lambda d: d["shapes"][0].update(points=[[1, 2], [3, "x"]]), "shapes[0].points[1]"),
            (lambda d: d["shapes"][2].update(label=""), "shapes[2].label"),
            (lambda d: d["shapes"][3].update(label=d["shapes"][2]["label"]), "shapes[3].label"),
            (lambda d: d["shapes"][1].update(points=[[1, 2], [3, 4]]), "shapes[1].points"),
            (lambda d: d["shapes"].append(d["shapes"][0]), "shapes"),
            (lambda d: d["shapes"].append("shape"), "shapes[11]"),
        ],
    )
    def test_labelme_errors_name_the_field(self, tmp_path: Path, change: Any, field: str) -> None:
        content = labelme()
        change(content)
        path = tmp_path / "marked.json"
        path.write_text(json.dumps(content))
        with pytest.raises(TemplateError, match=r"marked\.json") as caught:
            read_labelme(path)
        assert caught.value.field == field

    @pytest.mark.parametrize(
        ("change", "field"),
        [
            (lambda d: d.pop("annotations"), "annotations"),
            (lambda d: d["annotations"].append(d["annotations"][0]), "annotations"),
            (lambda d: d["annotations"][0].update(category_id=9), "annotations[0].category_id"),
            (
                lambda d: d["annotations"][0].update(segmentation={"counts": "x"}),
                "annotations[0].segmentation",
            ),
            (lambda d: d["annotations"][0]["segmentation"].append([1, 2]), "annotations[0].segmentation"),
            (lambda d: d["annotations"][0]["segmentation"][0].pop(), "annotations[0].segmentation[0]"),
            (lambda d: d["annotations"][0]["keypoints"].pop(), "annotations[0].keypoints"),
            (lambda d: d["categories"][0].update(keypoints="all"), "categories[0].keypoints"),
            (lambda d: d["categories"][0].update(name=3), "categories[0].name"),
        ],
    )
    def test_coco_errors_name_the_field(self, tmp_path: Path, change: Any, field: str) -> None:
        content = coco()
        change(content)
        path = tmp_path / "coco.json"
        path.write_text(json.dumps(content))
        with pytest.raises(TemplateError, match=r"coco\.json") as caught:
            read_coco(path)
        assert caught.value.field == field

    @pytest.mark.parametrize("text", ["", "[1]", "{", "\ud83d"])
    def test_no_json_object_is_told(self, tmp_path: Path, text: str) -> None:
        path = tmp_path / "marked.json"
        path.write_bytes(text.encode("utf-16" if text == "\ud83d" else "utf-8", "surrogatepass"))
        for command in ("from-labelme", "from-coco"):
            done = foldrs(command, path)
            assert done.exit_code == 1
            assert "marked.json" in done.output

    def test_image_id_chooses(self, tmp_path: Path) -> None:
        content = coco()
        content["annotations"].append({**content["annotations"][0], "image_id": 4})
        path = tmp_path / "coco.json"
        path.write_text(json.dumps(content))
        assert foldrs("from-coco", path, "--image-id", 4, "--out", tmp_path / "t.json").exit_code == 0
        refused = foldrs("from-coco", path, "--out", tmp_path / "u.json")
        assert refused.exit_code == 1
        assert "3, 4" in refused.output

    def test_a_landmark_off_the_outline_is_named(self, tmp_path: Path) -> None:
        content = labelme()
        content["shapes"][1]["points"] = [[200.0, 300.0]]
        path = tmp_path / "marked.json"
        path.write_text(json.dumps(content))
        done = foldrs("from-labelme", path, "--out", tmp_path / "t.json")
        assert done.exit_code == 1
        assert "landmarks.collar_left" in done.output


def test_check_tells_good_from_bad(tmp_path: Path) -> None:
    good, bad = tmp_path / "good.json", tmp_path / "bad.json"
    save_template(SHIRT, good)
    bad.write_text(good.read_text().replace('"hem_left", "hem_right"', '"hem_left", "nose"'))
    assert foldrs("check", good).exit_code == 0
    done = foldrs("check", good, bad)
    assert done.exit_code == 1
    assert "good.json" in done.stdout
    assert "bad.json: symmetry[4][1]" in done.stderr


def test_list_names_every_built_in_template() -> None:
    listed = foldrs("list").output.splitlines()
    assert [line.split()[0] for line in listed] == [template.name for template in builtin_templates()]


class TestCheck:
    def test_nothing_is_told_of_what_is_symmetric(self, tmp_path: Path) -> None:
        save_template(SHIRT, tmp_path / "shirt.json")
        done = foldrs("check", tmp_path / "shirt.json")
        assert done.exit_code == 0, done.output
        assert "symmetry" not in done.output

    def test_pairs_that_do_not_mirror_each_other_are_named(self, tmp_path: Path) -> None:
        swapped = {"hem_left": "armpit_left", "armpit_left": "hem_left"}
        pairs = [[swapped.get(a, a), b] for a, b in SHIRT.symmetry]
        path = tmp_path / "shirt.json"
        path.write_text(json.dumps({**SHIRT.to_dict(), "symmetry": pairs}))
        done = foldrs("check", path)
        assert done.exit_code == 0, done.output
        told = [line for line in done.output.splitlines() if "symmetry" in line]
        for pair in (("armpit_left", "hem_right"), ("hem_left", "armpit_right")):
            assert any(" and ".join(pair) in line for line in told)
            assert load_template(path).crooked_pairs()[pair] > 20.0

    def test_without_pairs_there_is_nothing_to_tell(self, tmp_path: Path) -> None:
        path = tmp_path / "shirt.json"
        path.write_text(json.dumps({**SHIRT.to_dict(), "symmetry": []}))
        assert "symmetry" not in foldrs("check", path).output
        assert load_template(path).crooked_pairs() == {}

    def test_a_point_on_the_axis_alone_tells_no_axis(self, tmp_path: Path) -> None:
        path = tmp_path / "shirt.json"
        path.write_text(json.dumps({**SHIRT.to_dict(), "symmetry": [["hem_left", "hem_left"]]}))
        done = foldrs("check", path)
        assert done.exit_code == 0, done.output
        assert "no mirror axis" in done.output


@pytest.mark.parametrize("template", builtin_templates(), ids=lambda one: one.name)
def test_built_in_templates_mirror_themselves(template: Any) -> None:
    assert template.symmetry
    assert template.crooked_pairs() == {}
