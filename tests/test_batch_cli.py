"""Batches on the command line: they can be killed and taken up again, and nothing is lost or overwritten."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from click.testing import CliRunner, Result

from foldrs import __version__, plot, stages_plot
from foldrs.cli import main
from foldrs.synth import SynthParameters, make_scene
from foldrs.template import builtin_templates

SCENE = SynthParameters(image_size=(320, 240), px_per_cm=2.5, tables=("plain",), cloths=("plain",))
COMMAND = [sys.executable, "-c", "from foldrs.cli import main; main()"]


def fit(*arguments: object, **environment: str) -> Result:
    words = ["fit", "--type", "towel", *(str(argument) for argument in arguments)]
    return CliRunner(env=environment).invoke(main, words)


def results(folder: Path) -> dict[str, Any]:
    """All results below a folder, without how long they took."""
    found = {}
    for path in sorted(folder.rglob("*.json")):
        content = json.loads(path.read_text())
        found[path.relative_to(folder).as_posix()] = {
            key: value for key, value in content.items() if key not in ("seconds", "timings", "made_by")
        }
    return found


def marks(folder: Path) -> dict[str, int]:
    """When every result was written."""
    return {path.name: path.stat().st_mtime_ns for path in folder.glob("*.json")}


@pytest.fixture(scope="module")
def photos(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    folder = tmp_path_factory.mktemp("photos")
    for seed in range(6):
        make_scene(builtin_templates("towel")[0], seed=seed, parameters=SCENE).write(folder, f"towel-{seed}")
    return sorted(folder.glob("*.jpg"))


@pytest.fixture(scope="module")
def whole(photos: list[Path], tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The results of a batch that nothing interrupted."""
    out = tmp_path_factory.mktemp("whole") / "out"
    assert fit(*photos, "--out", out).exit_code == 0
    return out


@pytest.mark.skipif(os.name == "nt", reason="there is no SIGKILL")
@pytest.mark.parametrize("after", [0, 1, 3])
def test_a_killed_batch_is_taken_up_again(
    photos: list[Path], whole: Path, tmp_path: Path, after: int
) -> None:
    out = tmp_path / "out"
    words = [*COMMAND, "fit", "--type", "towel", *map(str, photos), "--out", str(out), "--jobs", "1"]
    batch = subprocess.Popen(words, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    end = time.monotonic() + 120
    while time.monotonic() < end and (not out.is_dir() or len(list(out.glob("*.json"))) < after):
        assert batch.poll() is None, "the batch ended before it could be killed"
        time.sleep(0.002)
    batch.send_signal(signal.SIGKILL)
    batch.wait()
    before = marks(out)
    assert after <= len(before) < len(photos)
    assert results(out).items() <= results(whole).items()  # whole, every one of them

    again = fit(*photos, "--out", out, "--resume")
    assert again.exit_code == 0, again.output
    assert results(out) == results(whole)
    assert marks(out).items() >= before.items()
    assert [path for path in out.iterdir() if path.suffix != ".json"] == []
    assert not before or f"{len(before)} of {len(photos)} images were done already" in again.stderr


def test_nothing_is_done_twice(photos: list[Path], whole: Path) -> None:
    before = marks(whole)
    again = fit(*photos, "--out", whole, "--resume")
    assert again.exit_code == 0
    assert again.stdout == ""
    assert marks(whole) == before
    assert set(results(whole)) == {f"towel-{k}.json" for k in range(6)}


@pytest.mark.parametrize(
    "change",
    ["options", "template", "image", "cut off", "not JSON", "version", "picture missing", "no record"],
)
def test_what_is_not_whole_or_not_the_same_is_made_again(
    photos: list[Path], tmp_path: Path, change: str
) -> None:
    (tmp_path / "in").mkdir()
    image = tmp_path / "in" / "towel.jpg"
    image.write_bytes(photos[0].read_bytes())
    out = tmp_path / "out"
    plot = ["--plot"] if change == "picture missing" else []
    assert fit(image, "--out", out, *plot).exit_code == 0
    path = out / "towel.json"
    stored = json.loads(path.read_text())
    options: list[object] = list(plot)
    if change == "options":
        options += ["--px-per-cm", 2.5]
    elif change == "template":
        template = json.loads(json.dumps({**towel_file(), "grasp_pairs": []}))
        (tmp_path / "mine.json").write_text(json.dumps(template))
        options += ["--template", tmp_path / "mine.json"]
    elif change == "image":
        image.write_bytes(photos[1].read_bytes())
    elif change == "cut off":
        path.write_bytes(path.read_bytes()[:200])
    elif change == "not JSON":
        path.write_bytes(b"\x00" * 50)
    elif change == "version":
        stored["made_by"]["foldrs"] = "0.0.1"
        path.write_text(json.dumps(stored))
    elif change == "picture missing":
        (out / "towel.png").unlink()
    else:
        del stored["made_by"]
        path.write_text(json.dumps(stored))
    before = path.stat().st_mtime_ns
    done = fit(image, "--out", out, "--resume", *options)
    assert done.exit_code == 0, done.output
    assert "done already" not in done.stderr
    assert path.stat().st_mtime_ns != before
    assert json.loads(path.read_text())["made_by"]["foldrs"] == __version__
    assert change != "picture missing" or (out / "towel.png").is_file()


def towel_file() -> dict[str, Any]:
    (towel,) = builtin_templates("towel")
    return {
        "schema": 1,
        "type": "towel",
        "units": "cm",
        "outline": towel.outline.tolist(),
        "landmarks": {name: point.tolist() for name, point in towel.landmarks.items()},
    }


def test_errors_are_listed_and_tried_again(photos: list[Path], tmp_path: Path) -> None:
    bad = tmp_path / "bad.jpg"
    bad.write_text("no picture")
    out = tmp_path / "out"
    done = fit(photos[0], bad, "--out", out)
    assert done.exit_code == 1
    (entry,) = (json.loads(line) for line in (out / "errors.jsonl").read_text().splitlines())
    assert entry == {"image": str(bad), "error": "NotAnImageError", "message": entry["message"]}
    bad.write_bytes(photos[1].read_bytes())
    assert fit(photos[0], bad, "--out", out, "--resume").exit_code == 0
    assert sorted(path.name for path in out.iterdir()) == ["bad.json", "towel-0.json"]


def test_many_errors_are_listed_again_at_the_end(tmp_path: Path) -> None:
    bad = [tmp_path / f"{k}.jpg" for k in range(25)]
    for path in bad[:20]:
        path.write_text("no picture")
    done = fit(*bad)
    lines = done.stderr.splitlines()
    assert lines[25] == "failed: 20 NotAnImageError, 5 ImageNotFoundError"
    assert lines[:25] == lines[26:-1]
    assert lines[-1] == "25 of 25 images failed"


def test_images_of_one_name_keep_their_folders(photos: list[Path], tmp_path: Path) -> None:
    images = []
    for folder, photo in (("left/day", photos[0]), ("right/day", photos[1])):
        (tmp_path / folder).mkdir(parents=True)
        images.append(tmp_path / folder / "0001.jpg")
        images[-1].write_bytes(photo.read_bytes())
    out = tmp_path / "out"
    refused = fit(*images, "--out", out)
    assert refused.exit_code == 2
    assert "--keep-folders" in refused.stderr
    assert not out.exists()
    done = fit(*images, "--out", out, "--keep-folders")
    assert done.exit_code == 0
    names = ["left/day/0001.jpg", "right/day/0001.jpg"]
    assert [line.split(": ")[0] for line in done.stdout.splitlines()] == names
    assert set(results(out)) == {"left/day/0001.json", "right/day/0001.json"}
    assert {one["image"] for one in results(out).values()} == {"0001.jpg"}
    again = fit(*images, "--out", out, "--keep-folders", "--resume")
    assert "2 of 2 images were done already" in again.stderr
    images[1].write_text("no picture")
    told = fit(*images, "--out", out, "--keep-folders", "--resume", "--jsonl")
    assert [json.loads(line)["image"] for line in told.stdout.splitlines()] == names
    assert f"{images[1]}: " in told.stderr
    images.append(images[0].with_suffix(".png"))
    refused = fit(*images, "--out", out, "--keep-folders")
    assert refused.exit_code == 2
    assert "both" in refused.stderr
    assert "--keep-folders" not in refused.stderr


def test_a_result_of_another_image_is_left_alone(photos: list[Path], tmp_path: Path) -> None:
    for folder, photo in (("a", photos[0]), ("b", photos[1])):
        (tmp_path / folder).mkdir()
        (tmp_path / folder / "0001.jpg").write_bytes(photo.read_bytes())
    out = tmp_path / "out"
    assert fit(tmp_path / "a" / "0001.jpg", "--out", out).exit_code == 0
    before = (out / "0001.json").read_bytes()
    for options in ([], ["--resume"]):
        done = fit(tmp_path / "b" / "0001.jpg", "--out", out, *options)
        assert done.exit_code == 1
        assert "another image" in done.stderr
        assert (out / "0001.json").read_bytes() == before
    # The same image, changed, has every right to its own place.
    (tmp_path / "a" / "0001.jpg").write_bytes(photos[2].read_bytes())
    assert fit(tmp_path / "a" / "0001.jpg", "--out", out).exit_code == 0
    assert (out / "0001.json").read_bytes() != before


@pytest.mark.parametrize(
    "content", ['{"axis_garment": null}', '{"shapes": []}', "[1]", "a note", '{"schema": 1}']
)
def test_files_that_foldrs_did_not_make_are_left_alone(
    photos: list[Path], tmp_path: Path, content: str
) -> None:
    (tmp_path / "towel-0.json").write_text(content)
    done = fit(*photos[:2], "--out", tmp_path)
    assert done.exit_code == 1
    assert f"{photos[0]}: {tmp_path / 'towel-0.json'} was not made by foldrs" in done.stderr
    assert "another folder for --out" in done.stderr
    assert (tmp_path / "towel-0.json").read_text() == content
    assert json.loads((tmp_path / "towel-1.json").read_text())["garment_type"] == "towel"


def test_a_picture_that_foldrs_did_not_draw_is_left_alone(photos: list[Path], tmp_path: Path) -> None:
    mask = tmp_path / "towel-0.png"
    mask.write_bytes(b"a mask")
    for earlier in (False, True):  # also beside a result without a picture
        if earlier:
            assert fit(photos[0], "--out", tmp_path).exit_code == 0
        for options in ([], ["--resume"]):
            done = fit(photos[0], "--out", tmp_path, "--plot", *options)
            assert done.exit_code == 1
            assert f"{mask} was not made by foldrs" in done.stderr
            assert mask.read_bytes() == b"a mask"
            assert (tmp_path / "towel-0.json").exists() == earlier
    assert fit(photos[0], "--out", tmp_path, "--px-per-cm", 2.5).exit_code == 0
    assert mask.read_bytes() == b"a mask"


def test_a_picture_goes_with_its_result(photos: list[Path], tmp_path: Path) -> None:
    result, picture = tmp_path / "towel-0.json", tmp_path / "towel-0.png"
    for _ in range(2):
        assert fit(photos[0], "--out", tmp_path, "--plot").exit_code == 0
    first = picture.read_bytes()
    assert fit(photos[0], "--out", tmp_path, "--px-per-cm", 5).exit_code == 0
    assert not picture.exists()  # it would show what is no longer told
    done = fit(photos[0], "--out", tmp_path, "--px-per-cm", 5, "--resume", "--plot")
    assert done.exit_code == 0
    assert not np.array_equal(cv2.imread(str(picture)), cv2.imdecode(np.frombuffer(first, np.uint8), 1))
    assert json.loads(result.read_text())["made_by"]["pictures"] == [".png"]


def test_a_batch_killed_between_picture_and_result_is_taken_up_again(
    photos: list[Path], tmp_path: Path
) -> None:
    assert fit(photos[0], "--out", tmp_path, "--plot").exit_code == 0
    (tmp_path / "towel-0.json").rename(tmp_path / ".towel-0.json.ab12_x.part")
    (tmp_path / "towel-0.stages.png").write_bytes(b"somebody's")
    done = fit(photos[0], "--out", tmp_path, "--plot", "--resume")
    assert done.exit_code == 0, done.output
    assert sorted(path.name for path in tmp_path.iterdir()) == [
        "towel-0.json",
        "towel-0.png",
        "towel-0.stages.png",
    ]
    assert (tmp_path / "towel-0.stages.png").read_bytes() == b"somebody's"


def test_no_picture_stays_without_its_result(
    photos: list[Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(result: object, image: object, path: Path, **_: object) -> None:
        path.write_bytes(b"a part")
        raise OSError("the disk is full")

    with monkeypatch.context() as broken:
        broken.setattr(plot, "save_picture", fail)
        assert fit(photos[0], "--out", tmp_path, "--plot").exit_code == 1
    assert [path.name for path in tmp_path.iterdir()] == ["errors.jsonl"]
    assert fit(photos[0], "--out", tmp_path, "--plot").exit_code == 0


def test_a_result_without_its_stages_is_still_a_line_of_json(
    photos: list[Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(*_: object) -> None:
        raise OSError("the disk is full")

    with monkeypatch.context() as broken:
        broken.setattr(stages_plot, "save_stages", fail)
        done = fit(photos[0], "--out", tmp_path, "--plot-stages", "--jsonl")
    assert done.exit_code == 1
    assert "the disk is full" in done.stderr
    assert json.loads(done.stdout)["garment_type"] == "towel"
    again = fit(photos[0], "--out", tmp_path, "--plot-stages", "--resume")
    assert again.exit_code == 0
    assert (tmp_path / "towel-0.stages.png").is_file()


@pytest.mark.parametrize(
    ("content", "ours"),
    [
        ("", True),
        ('{"image": "a.jpg", "error": "E", "message": ""}\n', True),
        ('{"image": "a.jpg", "error": "E", "message": ""}\n{"image": "b.j', True),
        ('{"level": "error", "text": "mine"}\n', False),
        ("a note", False),
        ("[]\n", False),
    ],
)
def test_a_list_of_errors_is_replaced_only_if_it_is_one(
    photos: list[Path], tmp_path: Path, content: str, ours: bool
) -> None:
    errors = tmp_path / "errors.jsonl"
    errors.write_text(content)
    done = fit(photos[0], "--out", tmp_path)
    assert done.exit_code == (0 if ours else 2)
    assert errors.exists() != ours
    if not ours:
        assert errors.read_text() == content
        assert str(errors) in done.stderr
        assert [path.name for path in tmp_path.iterdir()] == ["errors.jsonl"]


def test_what_a_killed_batch_left_half_written_is_cleared_away(photos: list[Path], tmp_path: Path) -> None:
    (tmp_path / ".towel-0.json.ab12_x.part").write_text("{")
    (tmp_path / ".other.json.ab12_x.part").write_text("{")  # perhaps of another batch, at work right now
    assert fit(photos[0], "--out", tmp_path).exit_code == 0
    assert sorted(path.name for path in tmp_path.iterdir()) == [".other.json.ab12_x.part", "towel-0.json"]


def test_lines_of_json_for_pipes(photos: list[Path], whole: Path, tmp_path: Path) -> None:
    bad = tmp_path / "bad.jpg"
    bad.write_text("no picture")
    done = fit(photos[0], bad, photos[1], "--jsonl")
    assert done.exit_code == 1
    first, error, second = (json.loads(line) for line in done.stdout.splitlines())
    assert (first["image"], second["image"]) == ("towel-0.jpg", "towel-1.jpg")
    assert error == {"image": str(bad), "error": "NotAnImageError", "message": error["message"]}
    # What was done already is told as well.
    resumed = fit(*photos[:2], "--jsonl", "--out", whole, "--resume")
    kept = [json.loads(line) for line in resumed.stdout.splitlines()]
    assert [one["image"] for one in kept] == ["towel-0.jpg", "towel-1.jpg"]
    assert all(set(one) == set(first) for one in kept)


def test_quiet_prints_errors_only(photos: list[Path], tmp_path: Path) -> None:
    done = fit(photos[0], tmp_path / "nowhere.jpg", "--quiet", "--timings")
    assert done.exit_code == 1
    assert done.stdout == ""
    assert "nowhere.jpg" in done.stderr
    assert fit(photos[0], "--quiet").output == ""


@pytest.mark.parametrize(("environment", "coloured"), [({}, True), ({"NO_COLOR": "1"}, False)])
def test_colours_are_left_out_on_request(environment: dict[str, str], coloured: bool) -> None:
    done = CliRunner(env=environment).invoke(main, ["fit", "nowhere.jpg"], color=True)
    assert ("\x1b[" in done.stderr) == coloured
    assert "nowhere.jpg" in done.stderr


@pytest.mark.parametrize("shell", ["bash", "fish", "zsh"])
def test_shells_are_told_how_to_complete(shell: str) -> None:
    done = CliRunner().invoke(main, ["completion", shell])
    assert done.exit_code == 0
    assert "_FOLDRS_COMPLETE" in done.stdout


def test_help_teaches_by_examples() -> None:
    for words in (["--help"], ["fit", "--help"]):
        shown = CliRunner().invoke(main, words).stdout
        assert "Examples:" in shown
        assert "  foldrs fit photos/*.jpg --out results" in shown


@pytest.mark.parametrize(
    ("options", "status", "words"),
    [
        (["--resume"], 2, "--out"),
        (["--keep-folders"], 2, "--out"),
        (["--timeout", "0"], 2, "positive"),
        (["--timeout", "inf"], 2, "positive"),
        (["--max-pixels", "0"], 2, "--max-pixels"),
        (["--max-pixels", "1000"], 1, "more than the 1000 allowed"),
        (["--timeout", "0.001"], 1, "longer than 0.001 s"),
        (["--dask", "tcp://127.0.0.1:1", "--jobs", "2"], 2, "--jobs"),
    ],
)
def test_limits_and_wrong_options_are_explained(
    photos: list[Path], options: list[str], status: int, words: str
) -> None:
    done = fit(photos[0], *options)
    assert done.exit_code == status
    assert words in done.stderr
