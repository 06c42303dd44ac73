"""The command line: what each command writes, says and exits with."""

from __future__ import annotations

import json
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import click
import cv2
import numpy as np
import pytest
from click.testing import CliRunner, Result

from foldrs import __version__, plot
from foldrs.cli import main
from foldrs.synth import SCENARIOS, SynthParameters, make_scene
from foldrs.template import builtin_templates, save_template

TOP_FIELDS = {
    "schema",
    "image",
    "seconds",
    "garment_type",
    "accepted",
    "matching_cost",
    "outline_image",
    "fold",
    "folds",
    "original_template",
    "template",
    "unfolded_outline_image",
    "landmarks",
    "grasp_pairs",
    "alternatives",
}


def foldrs(*arguments: object) -> Result:
    return CliRunner().invoke(main, [str(argument) for argument in arguments])


def read(path: Path) -> Any:
    return json.loads(path.read_text())


def without_times(answer: Any) -> Any:
    return {field: value for field, value in answer.items() if field not in ("seconds", "timings", "made_by")}


@pytest.fixture(scope="module")
def photos(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with photographs towel.jpg and skirt.jpg, their masks, and bad.jpg that is none."""
    folder = tmp_path_factory.mktemp("photos")
    for seed, kind in enumerate(("towel", "skirt")):
        make_scene(builtin_templates(kind)[0], seed=seed, parameters=SynthParameters()).write(folder, kind)
    (folder / "bad.jpg").write_text("no image")
    return folder


def test_help_lists_every_command() -> None:
    shown = foldrs("--help").output
    for command in ("demo", "fit", "synth", "template"):
        assert f"\n  {command} " in shown
        assert foldrs(command, "--help").exit_code == 0


def test_the_installed_script_runs() -> None:
    script = Path(sys.executable).with_name("foldrs")
    for command in ([script], [sys.executable, "-m", "foldrs"]):
        told = subprocess.run([*command, "--version"], capture_output=True, text=True, check=True)
        assert __version__ in told.stdout


def test_fit_prints_one_line_and_writes_nothing_without_out(photos: Path, tmp_path: Path) -> None:
    before = sorted(photos.iterdir())
    done = foldrs("fit", photos / "towel.jpg")
    assert done.exit_code == 0, done.output
    assert done.stdout.startswith("towel.jpg: ")
    assert len(done.stdout.splitlines()) == 1
    assert sorted(photos.iterdir()) == before


def test_timings_are_printed_by_stage(photos: Path) -> None:
    done = foldrs("fit", photos / "towel.jpg", "--type", "towel", "--timings")
    assert done.exit_code == 0, done.output
    line, stages = done.stdout.splitlines()
    assert line.startswith("towel.jpg: ")
    seconds = [float(stage.split()[1]) for stage in stages.split(", ")]
    assert "outline" in stages
    assert 0 < sum(seconds) < 1.01 * float(line.split()[-2]) + 0.01


def test_the_picture_shows_the_candidate_creases(
    photos: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    drawn: list[Any] = []
    monkeypatch.setattr(plot, "save_picture", lambda *_, details: drawn.append(details))
    done = foldrs("fit", photos / "towel.jpg", "--type", "towel", "--plot", "--out", tmp_path)
    assert done.exit_code == 0, done.output
    (details,) = drawn
    assert details.sides
    assert all(side.shape == (2, 2) for side in details.sides)


def test_fit_writes_every_good_image_though_one_is_bad(photos: Path, tmp_path: Path) -> None:
    done = foldrs(
        "fit", photos / "towel.jpg", photos / "bad.jpg", photos / "skirt.jpg", "--out", tmp_path, "--plot"
    )
    assert done.exit_code == 1
    assert "bad.jpg" in done.stderr
    assert "1 of 3" in done.stderr
    assert sorted(p.name for p in tmp_path.iterdir()) == [
        "errors.jsonl",
        "skirt.json",
        "skirt.png",
        "towel.json",
        "towel.png",
    ]
    for kind in ("towel", "skirt"):
        answer = read(tmp_path / f"{kind}.json")
        assert set(answer) >= TOP_FIELDS
        assert answer["image"] == f"{kind}.jpg"
        assert answer["seconds"] > 0
        assert answer["alternatives"][0]["garment_type"] == answer["garment_type"]
        assert sum(other["probability"] for other in answer["alternatives"]) <= 1 + 1e-9
        assert cv2.imread(str(tmp_path / f"{kind}.png")).shape[2] == 3


def test_an_image_that_is_missing_is_named(tmp_path: Path) -> None:
    done = foldrs("fit", tmp_path / "nowhere.jpg")
    assert done.exit_code == 1
    assert "nowhere.jpg" in done.stderr
    assert "Traceback" not in done.stderr


@pytest.mark.parametrize("method", ["best", "paper"])
def test_jobs_do_not_change_the_answer(photos: Path, tmp_path: Path, method: str) -> None:
    answers = []
    for jobs in (1, 2):
        out = tmp_path / str(jobs)
        images = [photos / "towel.jpg", photos / "skirt.jpg"]
        done = foldrs("fit", *images, "--out", out, "--jobs", jobs, "--method", method)
        assert done.exit_code == 0, done.output
        answers.append([without_times(read(out / f"{kind}.json")) for kind in ("towel", "skirt")])
    assert answers[0] == answers[1]


def test_type_template_mask_and_scale_are_obeyed(photos: Path, tmp_path: Path) -> None:
    towel = builtin_templates("towel")[0]
    save_template(towel, tmp_path / "sheet.json")
    by_type = foldrs(
        "fit", photos / "skirt.jpg", "--type", "towel", "--px-per-cm", 4, "--out", tmp_path / "a"
    )
    by_file = foldrs(
        "fit",
        photos / "skirt.jpg",
        "--template",
        tmp_path / "sheet.json",
        "--px-per-cm",
        4,
        "--out",
        tmp_path / "b",
    )
    assert by_type.exit_code == by_file.exit_code == 0
    first, second = (read(tmp_path / folder / "skirt.json") for folder in "ab")
    assert first["garment_type"] == "towel"
    assert without_times(first) == without_times(second)

    masked = foldrs(
        "fit",
        photos / "skirt.jpg",
        "--type",
        "skirt",
        "--mask",
        photos / "skirt.mask.png",
        "--out",
        tmp_path / "c",
    )
    assert masked.exit_code == 0, masked.output
    seen = np.array(read(tmp_path / "c" / "skirt.json")["outline_image"])
    mask = cv2.imread(str(photos / "skirt.mask.png"), cv2.IMREAD_GRAYSCALE)
    drawn = cv2.fillPoly(np.zeros_like(mask), [seen.round().astype(np.int32)], 255)
    assert (drawn != mask).mean() < 0.01


@pytest.mark.parametrize(
    ("options", "status", "told"),
    [
        (["--plot"], 2, "--out"),
        (["--type", "ballgown"], 1, "t-shirt"),
        (["--px-per-cm", "0"], 1, "px_per_cm"),
        (["--template", "nowhere.json"], 1, "nowhere.json"),
        (["--method", "guess"], 2, "paper"),
        (["--jobs", "0"], 2, "--jobs"),
    ],
)
def test_wrong_options_are_explained(photos: Path, options: list[str], status: int, told: str) -> None:
    done = foldrs("fit", photos / "towel.jpg", *options)
    assert done.exit_code == status
    assert told in done.stderr


@pytest.mark.parametrize(
    ("options", "told"),
    [
        (["--marker", "0"], "--marker: "),
        (["--marker", "5", "--marker-family", "foo"], "--marker-family: "),
        (["--marker", "8", "--px-per-cm", "4"], "--px-per-cm goes without --marker"),
        (["--a4", "--px-per-cm", "4"], "--px-per-cm goes without --a4"),
        (["--homography", "h.json", "--px-per-cm", "4"], "--px-per-cm goes without --homography"),
        (["--camera", "c.json", "--px-per-cm", "4"], "--px-per-cm goes without --camera"),
        (["--robot-base", "r.json"], "--robot-base needs"),
        (["--timeout", "0"], "--timeout"),
    ],
)
def test_wrong_calls_are_refused_before_anything_is_done(
    photos: Path, tmp_path: Path, options: list[str], told: str
) -> None:
    done = foldrs("fit", photos / "towel.jpg", *options, "--out", tmp_path / "out")
    assert done.exit_code == 2
    assert told in done.stderr
    assert not done.stdout
    assert not (tmp_path / "out").exists()


def test_a_camera_without_a_pose_is_told_by_its_option(photos: Path, tmp_path: Path) -> None:
    camera = {"camera_matrix": [[800, 0, 320], [0, 800, 240], [0, 0, 1]], "dist_coeffs": [0, 0, 0, 0, 0]}
    (tmp_path / "camera.json").write_text(json.dumps(camera))
    done = foldrs(
        "fit", photos / "towel.jpg", "--camera", tmp_path / "camera.json", "--out", tmp_path / "out"
    )
    assert done.exit_code == 1
    assert "--table-pose" in done.stderr
    assert "TablePlane" not in done.stderr
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("options", "told"),
    [
        (["--px-per-cm", "0"], "--px-per-cm: "),
        (["--folds", "7"], "--folds: "),
        (["--folds", "-1"], "--folds: "),
    ],
)
def test_numbers_out_of_range_are_told_by_their_option(
    photos: Path, tmp_path: Path, options: list[str], told: str
) -> None:
    done = foldrs("fit", photos / "towel.jpg", *options, "--out", tmp_path / "out")
    assert told in done.stderr
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("options", "told"),
    [
        (["--px-per-cm", "0"], "--px-per-cm is 0"),
        (["--size", "0", "0"], "--size is (0, 0)"),
        (["--tilt", "90"], "--tilt is 90"),
        (["--marker", "-1"], "--marker is -1"),
        (["--folds", "0", "--scenario", "limb"], "--scenario"),
    ],
)
def test_synth_refuses_wrong_calls(tmp_path: Path, options: list[str], told: str) -> None:
    done = foldrs("synth", "--out", tmp_path / "scenes", "--count", 1, *options)
    assert done.exit_code == 2
    assert told in done.stderr
    assert not (tmp_path / "scenes").exists()


@pytest.mark.parametrize(
    "command",
    [
        ["synth", "--count", "1", "--out"],
        ["demo", "--out"],
        ["fit", "photo.jpg", "--out"],
        ["evaluate", "--protocol", "synthetic", "--count", "1", "--out"],
        ["fit", "photo.jpg", "--report"],
    ],
)
def test_a_folder_that_cannot_be_is_told_in_words(tmp_path: Path, command: list[str]) -> None:
    (tmp_path / "afile").touch()
    done = foldrs(*command, tmp_path / "afile" / "sub" / "page.html")
    assert done.exit_code == 1
    assert f"{command[-1]}: {tmp_path / 'afile'} is not a folder" in done.stderr
    assert "Errno" not in done.stderr
    assert isinstance(done.exception, SystemExit)


@pytest.mark.skipif(not Path("/dev/null").exists(), reason="there is no such device")
@pytest.mark.parametrize("command", [["fit", "photo.jpg"], ["synth", "--count", "1"]])
def test_a_device_is_no_folder(command: list[str]) -> None:
    done = foldrs(*command, "--out", "/dev/null")
    assert done.exit_code == 1
    assert "--out: /dev/null is not a folder" in done.stderr


@pytest.mark.parametrize("kind", ["../evil/x", "a\\b"])
def test_a_kind_that_can_name_no_file_writes_none(tmp_path: Path, kind: str) -> None:
    save_template(replace(builtin_templates("towel")[0], garment_type=kind), tmp_path / "mine.json")
    before = sorted(tmp_path.rglob("*"))
    done = foldrs("synth", "--out", tmp_path / "scenes", "--template", tmp_path / "mine.json", "--count", 1)
    assert done.exit_code == 1
    assert "can name no file" in done.stderr
    assert sorted(tmp_path.rglob("*")) == before


def test_outlines_that_are_not_there_are_told_in_words(tmp_path: Path) -> None:
    done = foldrs("synth", "--out", tmp_path / "scenes", "--outlines", tmp_path / "nope.json")
    assert done.exit_code == 1
    assert "no such file of outlines" in done.stderr
    assert "Errno" not in done.stderr


def test_a_mask_goes_with_one_image(photos: Path) -> None:
    done = foldrs("fit", photos / "towel.jpg", photos / "skirt.jpg", "--mask", photos / "towel.mask.png")
    assert done.exit_code == 2


def test_template_show_draws_kinds_and_files(tmp_path: Path) -> None:
    save_template(builtin_templates("skirt")[0], tmp_path / "mine.json")
    for source in ("pants", tmp_path / "mine.json"):
        done = foldrs("template", "show", source, "--out", tmp_path / "shown.png")
        assert done.exit_code == 0, done.output
        assert cv2.imread(str(tmp_path / "shown.png")) is not None
        (tmp_path / "shown.png").unlink()
    unknown = foldrs("template", "show", "ballgown", "--out", tmp_path / "shown.png")
    assert unknown.exit_code == 1
    assert "skirt" in unknown.stderr
    before = (tmp_path / "mine.json").read_bytes()
    (tmp_path / "shown.png").symlink_to("mine.json")
    for picture in ("mine.json", "shown.png", "other.json"):
        refused = foldrs("template", "show", tmp_path / "mine.json", "--out", tmp_path / picture)
        assert refused.exit_code == 2
        assert picture in refused.stderr
        assert (tmp_path / "mine.json").read_bytes() == before


def test_synth_writes_the_same_scenes_with_any_number_of_jobs(tmp_path: Path) -> None:
    for jobs in (1, 2):
        options = ["--count", 5, "--type", "towel", "--type", "skirt", "--seed", 5, "--size", 320, 240]
        done = foldrs("synth", "--out", tmp_path / str(jobs), "--jobs", jobs, "--px-per-cm", 2, *options)
        assert done.exit_code == 0, done.output
    one, two = (sorted((tmp_path / jobs).iterdir()) for jobs in "12")
    kinds = [p.name.split("-")[0] for p in one if p.suffix == ".json"]
    assert kinds == [
        template.garment_type for kind in ("skirt", "towel") for template in builtin_templates(kind)
    ]
    assert [p.read_bytes() for p in one] == [p.read_bytes() for p in two]
    assert cv2.imread(str(tmp_path / "1" / "towel-05.jpg")).shape == (240, 320, 3)


def test_synth_obeys_folds_scenario_and_format(tmp_path: Path) -> None:
    done = foldrs(
        "synth", "--out", tmp_path, "--count", 1, "--folds", 2, "--scenario", "corner", "--png", "--jobs", 1
    )
    assert done.exit_code == 0, done.output
    (truth,) = (read(path) for path in tmp_path.glob("*.json"))
    assert truth["scenario"] == "corner"
    assert truth["second_fold"]
    assert (tmp_path / truth["image"]).suffix == ".png"


def test_synth_knows_every_scenario() -> None:
    shown = foldrs("synth", "--help").output
    assert all(scenario in shown for scenario in SCENARIOS)


def test_synth_takes_outlines_of_real_garments(tmp_path: Path) -> None:
    towel = builtin_templates("towel")[0]
    entry = {
        "type": "towel",
        "outline": (7 * towel.outline).tolist(),
        "landmarks": {name: (7 * point).tolist() for name, point in towel.landmarks.items()},
    }
    flag = {"type": "flag", "outline": [[0, 0], [3, 0], [3, 2], [0, 2]], "landmarks": {}, "size_cm": 60}
    (tmp_path / "real.json").write_text(json.dumps([entry, flag]))
    done = foldrs(
        "synth", "--out", tmp_path / "scenes", "--outlines", tmp_path / "real.json", "--count", 2, "--jobs", 1
    )
    assert done.exit_code == 0, done.output
    assert sorted(path.stem for path in (tmp_path / "scenes").glob("*.jpg")) == ["flag-02", "towel-01"]
    truth = read(tmp_path / "scenes" / "towel-01.json")
    size = np.ptp(np.array(truth["outline_garment"]), axis=0) / truth["px_per_cm"]
    assert 0.5 * 65 < size.max() < 1.5 * 65  # as large as the template, not seven times


@pytest.mark.parametrize(
    ("content", "told"),
    [
        ("{}", "list"),
        ("[]", "list"),
        ("not JSON", "JSON"),
        ('[{"type": "flag"}]', "outline"),
        ("[[[0, 0], [3, 0], [3, 2]]]", "outline 0 must be an object"),
        ('[{"type": "flag", "outline": [[0,0],[3,0],[3,2]], "landmarks": {}}]', "size_cm"),
        ('[{"type": "flag", "outline": "round", "landmarks": {}, "size_cm": 60}]', "outline 0"),
        (
            '[{"type": "flag", "outline": [[0,0],[3,3],[3,0],[0,3]], "landmarks": {}, "size_cm": 60}]',
            "outline 0",
        ),
    ],
)
def test_bad_files_of_outlines_are_explained(tmp_path: Path, content: str, told: str) -> None:
    (tmp_path / "real.json").write_text(content)
    done = foldrs("synth", "--out", tmp_path / "scenes", "--outlines", tmp_path / "real.json")
    assert done.exit_code == 1
    assert told in done.stderr
    assert not (tmp_path / "scenes").exists()


def test_synth_names_the_kinds_there_are(tmp_path: Path) -> None:
    done = foldrs("synth", "--out", tmp_path, "--type", "ballgown")
    assert done.exit_code == 1
    assert "ballgown" in done.stderr
    assert "towel" in done.stderr


def test_demo_is_right_and_shows_what_it_wrote(tmp_path: Path) -> None:
    done = foldrs("demo", "--out", tmp_path / "demo")
    assert done.exit_code == 0, done.output
    answer = read(tmp_path / "demo" / "t-shirt.json")
    truth = read(tmp_path / "demo" / "scene" / "t-shirt.json")
    rows = {line.split("  ")[0]: line.split() for line in done.stdout.splitlines()}
    assert rows["kind"] == ["kind", answer["garment_type"], truth["type"], "right"]
    assert rows["fold axis"][-1] == "right"
    assert rows["grasp pair"][-1] == "right"
    assert cv2.imread(str(tmp_path / "demo" / "t-shirt.png")) is not None
    assert cv2.imread(str(tmp_path / "demo" / "scene" / truth["image"])) is not None


def test_a_name_too_long_does_not_stop_the_other_images(photos: Path, tmp_path: Path) -> None:
    done = foldrs("fit", "x" * 300 + ".jpg", photos / "towel.jpg", "--type", "towel", "--out", tmp_path)
    assert done.exit_code == 1
    assert "check the name" in done.stderr
    assert json.loads((tmp_path / "errors.jsonl").read_text())["error"] == "ImageNotFoundError"
    assert (tmp_path / "towel.json").is_file()


@pytest.mark.parametrize("images", [["bad.jpg"], ["bad.jpg", "towel.jpg"]])
def test_the_error_of_a_draft_is_no_cause_of_itself(photos: Path, images: list[str]) -> None:
    call = ["template", "from-photo", "--kind", "towel", *(str(photos / name) for name in images)]
    with pytest.raises(click.ClickException) as caught:
        main(call, standalone_mode=False)
    seen: list[BaseException] = []
    error: BaseException | None = caught.value
    while error is not None:
        assert all(error is not other for other in seen)
        seen.append(error)
        error = error.__cause__
    assert "bad.jpg" in str(seen[0])
