"""The stages of the published method: all outlines can be had and fit together; their picture."""

from __future__ import annotations

import json
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from click.testing import CliRunner
from matplotlib.axes import Axes
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from numpy.typing import NDArray

from foldrs import _core, _plot_panels, fit, stages_plot
from foldrs._stages_panels import PARTNERS
from foldrs.cli import main
from foldrs.errors import NoHypothesisError, NotAnImageError, ParameterError
from foldrs.explanation import apply
from foldrs.fit_cli import fit_command
from foldrs.parameters import AlternativeParameters, Parameters
from foldrs.result import FitResult
from foldrs.stages import chosen_pass
from foldrs.stages_plot import draw_stages, save_stages
from foldrs.synth import make_scene
from foldrs.template import Template, builtin_templates, save_template

Points = NDArray[np.float64]

SKIRT = builtin_templates("skirt")[0]


# No mirror image of it is like it, so that a result tells which face is up.
_CORNERS = np.array([[0.0, 0.0], [50.0, 0.0], [78.0, 34.0], [40.0, 42.0], [36.0, 70.0], [0.0, 60.0]])
BANNER = Template("banner", "banner", "cm", _CORNERS, {"top": _CORNERS[0], "tip": _CORNERS[2]})


def outline_of_folded(template: Template, *, mirrored: bool = False) -> Points:
    """The outline in px of a garment a little wider than its template, its upper half turned down, askew."""
    garment = template.outline * [1.1, 0.95]
    low, high = garment.min(axis=0), garment.max(axis=0)
    y = low[1] + 0.5 * (high[1] - low[1])
    folded = _core.fold_layers(garment, np.array([[high[0] + 1, y - 8], [low[0] - 1, y + 4]])).outline
    c, s = np.cos(0.7), np.sin(0.7)
    turned = (folded * [-1 if mirrored else 1, 1]) @ np.array([[c, s], [-s, c]])
    return np.asarray(4.0 * turned + [300, 250])


def explained(template: Template, *, mirrored: bool = False) -> FitResult:
    outline = outline_of_folded(template, mirrored=mirrored)
    return fit(outline, templates=[template], px_per_cm=4.0, method="paper")


@pytest.fixture(scope="module")
def result() -> FitResult:
    return explained(SKIRT)


@pytest.fixture(scope="module")
def figure(result: FitResult) -> Figure:
    """The picture of `result`, to look at only."""
    return draw_stages(result, None)


@pytest.fixture(scope="module")
def photos(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the photograph of a folded towel and its mask."""
    folder = tmp_path_factory.mktemp("photos")
    make_scene(builtin_templates("towel")[0], seed=3).write(folder, "towel")
    return folder


def captions(figure: Figure) -> list[str]:
    return [ax.get_title(loc="left") for ax in figure.axes]


def drawn(ax: Axes, points: Points) -> bool:
    """Whether a line or row of dots of a panel goes through these points, in order."""
    curves = [np.asarray(line.get_xydata()) for line in ax.lines]
    return any(len(c) >= len(points) and np.allclose(c[: len(points)], points) for c in curves)


def off_outline(outline: Points, points: Points) -> Points:
    return _core.nearest_on_outline(outline, points)[1]


def count(picture: NDArray[Any], colour: str) -> int:
    return int((np.abs(picture[:, :, ::-1] - 255 * np.array(to_rgb(colour))) < 3).all(axis=2).sum())


# -- the stages of a result --


def test_stages_are_those_of_the_answer(result: FitResult) -> None:
    stages = result.stages
    assert len(stages) > 1
    chosen = stages[chosen_pass(stages)]
    assert chosen.cost == result.matching_cost == min(one.cost for one in stages)
    assert stages[0].cost == result.original_matching_cost
    np.testing.assert_array_equal(chosen.template.outline, result.template.outline)
    np.testing.assert_array_equal(stages[0].template.axis, result.original_template.axis)


def test_every_pass_matches_what_the_one_before_made(result: FitResult) -> None:
    for one, following in zip(result.stages, result.stages[1:], strict=False):
        assert one.update is not None
        np.testing.assert_array_equal(one.update.outline, following.template.outline)


@pytest.mark.parametrize("mirrored", [False, True], ids=["one face", "other face"])
def test_outlines_lie_in_the_image_whichever_face_is_up(mirrored: bool) -> None:
    """Registration brings the folded outline nearer; unfolding it back over its axis gives VUC."""
    result = explained(BANNER, mirrored=mirrored)
    assert (np.linalg.det(result.stages[0].to_image[:, :2]) < 0) == mirrored
    for one in result.stages:
        update = one.update
        assert update is not None
        assert off_outline(result.outline_image, one.seen).max() < 1e-6
        before = off_outline(result.outline_image, one.folded_image).mean()
        assert off_outline(result.outline_image, update.folded).mean() < before
        back = update.unfolded.copy()
        back[update.on_flap] = _core.reflect(back[update.on_flap], update.axis)
        apart = np.linalg.norm(back[:, None] - update.folded, axis=2).min(axis=1)
        np.testing.assert_allclose(apart, 0, atol=1e-6)
        assert len(one.partner) == len(one.folded)
        assert one.partner.max() < len(one.seen)
    first = result.stages[0].update
    assert first is not None
    assert 0 < first.on_flap.sum() < len(first.on_flap)


def test_straight_lines_run_beside_the_sides_of_the_updated_template(result: FitResult) -> None:
    update = result.stages[0].update
    assert update is not None
    assert 0 < len(update.lines) <= len(update.corners)
    size = np.sqrt(abs(_core.signed_area(update.corners)))
    for line in update.lines:
        assert off_outline(update.corners, line).max() < 0.1 * size


def test_other_methods_have_no_stages_and_the_json_form_none_at_all(result: FitResult) -> None:
    best = fit(outline_of_folded(SKIRT), templates=[SKIRT], px_per_cm=4.0)
    assert best.stages == ()
    assert result.to_dict().keys() == best.to_dict().keys()
    assert "stages" not in result.to_dict()
    with pytest.raises(ParameterError, match="paper"):
        draw_stages(best, None)


# -- the picture --


def test_every_outline_is_drawn(result: FitResult, figure: Figure) -> None:
    one = result.stages[0]
    update = one.update
    assert update is not None
    seen, template, folded, partners, registered, unfolded, whole, lines = figure.axes[:8]
    assert drawn(seen, result.outline_image)
    assert all(drawn(seen, side) for side in result.candidate_creases)
    assert drawn(template, one.template.outline)
    assert drawn(template, one.template.axis)
    assert drawn(folded, one.folded)
    assert drawn(partners, one.folded_image)
    assert drawn(partners, apply(one.to_image, one.template.axis))
    assert drawn(registered, update.folded)
    assert drawn(registered, update.axis)
    assert drawn(unfolded, update.unfolded[update.on_flap])
    assert drawn(unfolded, update.unfolded[~update.on_flap])
    assert drawn(whole, update.registered)
    assert drawn(lines, update.corners)
    for ax, stage in zip(figure.axes[8:], result.stages, strict=True):
        assert drawn(ax, stage.template.outline)
        assert drawn(ax, stage.template.axis)


def test_correspondences_join_partners(result: FitResult, figure: Figure) -> None:
    one, ax = result.stages[0], figure.axes[3]
    joins = [np.asarray(line.get_xydata()) for line in ax.lines if line.get_color() == PARTNERS]
    assert len(joins) > 20
    aside = joins[0][1] - one.seen[one.partner[np.abs(one.folded_image - joins[0][0]).sum(axis=1).argmin()]]
    for start, end in joins:
        i = np.abs(one.folded_image - start).sum(axis=1).argmin()
        np.testing.assert_allclose(one.seen[one.partner[i]] + aside, end, atol=1e-6)


def test_titles_name_stages_and_sections_costs_and_the_pass_chosen(result: FitResult, figure: Figure) -> None:
    titles = captions(figure)
    sections = ("2.1.1", "2.1.2", "2.1.2", "2.1.2", "2.2.1", "2.2.1", "2.2.2", "2.2.3")
    names = ("FC", "UC", "VFC", "PC", "RVFC", "VUC", "RUC", "UCfit")
    for title, name, section in zip(titles[:8], names, sections, strict=True):
        assert name in title
        assert f"({section})" in title
    framed = []
    for i, (ax, one) in enumerate(zip(figure.axes[8:], result.stages, strict=True)):
        assert f"{one.cost:.3f}" in titles[8 + i]
        framed.append(ax.spines["left"].get_visible())
    assert [i for i, is_framed in enumerate(framed) if is_framed] == [chosen_pass(result.stages)]


def test_any_pass_can_be_shown(result: FitResult) -> None:
    last = len(result.stages) - 1
    figure = draw_stages(result, None, Figure(figsize=(12, 9)), shown=last)
    assert drawn(figure.axes[2], result.stages[last].folded)
    for wrong in (-1, last + 1):
        with pytest.raises(ParameterError, match=f"0 to {last}"):
            draw_stages(result, None, shown=wrong)


def test_a_template_that_could_not_be_updated_is_said_to_be_such(result: FitResult) -> None:
    stuck = replace(result, stages=(replace(result.stages[0], update=None),), candidate_creases=())
    titles = captions(draw_stages(stuck, None))
    assert len(titles) == 6
    assert "could not be updated" in titles[4]


def test_pictures_of_several_threads_are_whole_and_alike(result: FitResult, tmp_path: Path) -> None:
    photo = np.full((480, 640, 3), (10, 200, 60), dtype=np.uint8)
    paths = [tmp_path / f"{i}.png" for i in range(2)]
    with ThreadPoolExecutor(2) as pool:
        list(pool.map(lambda path: save_stages(result, photo, path), paths))
    assert paths[0].read_bytes() == paths[1].read_bytes()
    picture = cv2.imread(str(paths[0]))
    assert picture is not None
    assert picture.shape == (1260, 1600, 3)
    assert count(picture, _plot_panels.CREASE) > 2000
    assert count(picture, "#0ac83c") > 10000  # the photograph


def test_what_is_no_image_leaves_an_earlier_picture_as_it_was(result: FitResult, tmp_path: Path) -> None:
    (tmp_path / "a.png").write_bytes(b"earlier")
    with pytest.raises(NotAnImageError):
        save_stages(result, np.zeros((4, 4, 7)), tmp_path / "a.png")
    assert (tmp_path / "a.png").read_bytes() == b"earlier"


# -- the command line --


@pytest.mark.parametrize("method", ["best", "paper"])
@pytest.mark.parametrize("options", [["--plot", "stages"], ["--plot-stages"]])
def test_plot_stages_adds_its_picture(photos: Path, tmp_path: Path, method: str, options: list[str]) -> None:
    call = ["fit", *options, str(photos / "towel.jpg"), "--type", "towel", "--method", method]
    done = CliRunner().invoke(main, [*call, "--out", str(tmp_path)])
    assert done.exit_code == 0, done.output
    assert sorted(p.name for p in tmp_path.iterdir()) == ["towel.json", "towel.png", "towel.stages.png"]
    picture = cv2.imread(str(tmp_path / "towel.stages.png"))
    assert picture is not None
    assert picture.shape == (1260, 1600, 3)
    assert "stages" not in json.loads((tmp_path / "towel.json").read_text())


@pytest.mark.parametrize(
    ("words", "plot", "stages", "images"),
    [
        (["--plot", "a.jpg"], True, False, ["a.jpg"]),
        (["--plot", "stages", "a.jpg"], False, True, ["a.jpg"]),
        (["a.jpg", "--plot", "stages"], False, True, ["a.jpg"]),
        (["--plot", "a.jpg", "stages"], True, False, ["a.jpg", "stages"]),
        (["--plot", "./stages"], True, False, ["stages"]),
        (["--plot", "--", "stages"], True, False, ["stages"]),
        (["a.jpg", "--", "--plot", "stages"], False, False, ["a.jpg", "--plot", "stages"]),
        (["stages"], False, False, ["stages"]),
    ],
)
def test_plot_stays_a_flag(words: list[str], plot: bool, stages: bool, images: list[str]) -> None:
    read = fit_command.make_context("fit", list(words)).params
    assert (read["plot"], read["plot_stages"]) == (plot, stages)
    assert [str(path) for path in read["images"]] == images


def test_an_image_after_the_flag_is_an_image(photos: Path, tmp_path: Path) -> None:
    call = ["fit", "--type", "towel", "--out", str(tmp_path), "--plot", str(photos / "towel.jpg")]
    done = CliRunner().invoke(main, call)
    assert done.exit_code == 0, done.output
    assert sorted(p.name for p in tmp_path.iterdir()) == ["towel.json", "towel.png"]


def test_plot_stages_needs_a_folder_to_write_to_and_spares_its_inputs(photos: Path) -> None:
    towel = str(photos / "towel.jpg")
    done = CliRunner().invoke(main, ["fit", "--plot", "stages", towel])
    assert done.exit_code == 2
    assert "--out" in done.stderr
    mask = photos / "towel.stages.png"
    mask.write_bytes((photos / "towel.mask.png").read_bytes())
    call = ["fit", towel, "--mask", str(mask), "--out", str(photos), "--plot", "stages"]
    done = CliRunner().invoke(main, call)
    mask.unlink()
    assert done.exit_code == 2
    assert "overwritten" in done.stderr


def test_stages_are_those_of_the_answer_where_its_kind_wins_by_its_weight() -> None:
    """The cheapest fit is not the answer where its kind has many templates that explain nothing."""

    def scaled(kind: str, *scale: float) -> Template:
        marks = {name: point * scale for name, point in SKIRT.landmarks.items()}
        return Template(f"{kind} {scale}", kind, "cm", SKIRT.outline * scale, marks)

    many = [scaled("many", 1.0, 1.0), scaled("many", 1.6, 0.7), scaled("many", 0.6, 1.5)]
    parameters = Parameters(alternatives=AlternativeParameters(temperature=1.0))
    result = fit(
        outline_of_folded(SKIRT),
        templates=[*many, scaled("single", 1.0, 1.25)],
        px_per_cm=4.0,
        method="paper",
        parameters=parameters,
    )
    assert result.garment_type == "single"
    chosen = result.stages[chosen_pass(result.stages)]
    assert {one.garment_type for one in result.stages} == {"single"}
    assert chosen.cost == result.matching_cost
    np.testing.assert_array_equal(chosen.template.outline, result.template.outline)


def test_plot_stages_shows_the_published_method_with_its_own_templates(
    photos: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """One usual template a kind, whatever competes for the answer; but those given all of them."""
    shown: list[FitResult] = []
    monkeypatch.setattr(stages_plot, "save_stages", lambda result, *_: shown.append(result))
    towel, skirt = builtin_templates("towel")[0], builtin_templates("skirt")[0]
    for name, template in (("mine", towel), ("other", replace(towel, name="other")), ("skirt", skirt)):
        save_template(template, tmp_path / f"{name}.json")
    own = [tmp_path / f"{name}.json" for name in ("mine", "other", "skirt")]
    for templates in ([], own):
        call = ["fit", str(photos / "towel.jpg"), "--plot-stages", "--out", str(tmp_path / "out")]
        for template in templates:
            call += ["--template", str(template)]
        done = CliRunner().invoke(main, call)
        assert done.exit_code == 0, done.output
        outline = json.loads((tmp_path / "out" / "towel.json").read_text())["outline_image"]
        wanted = fit(shown[-1].outline_image, templates=templates or None, method="paper")
        np.testing.assert_allclose(shown[-1].outline_image, outline, atol=1e-4)
        assert [(a.garment_type, a.probability) for a in shown[-1].alternatives] == [
            (a.garment_type, a.probability) for a in wanted.alternatives
        ]


@pytest.mark.parametrize("error", [NoHypothesisError("nothing to compare"), OSError(28, "No space left")])
def test_a_result_is_written_though_its_stages_cannot_be_drawn(
    photos: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, error: Exception
) -> None:
    def failing(*_: object) -> None:
        raise error

    call = ["fit", str(photos / "towel.jpg"), "--type", "towel", "--plot", "stages", "--out", str(tmp_path)]
    assert CliRunner().invoke(main, call).exit_code == 0
    with monkeypatch.context() as patch:
        patch.setattr(stages_plot, "save_stages", failing)
        done = CliRunner().invoke(main, call)
    assert done.exit_code == 1
    assert "towel.stages.png could not be drawn" in done.stderr
    assert str(error) in done.stderr
    assert "towel.jpg: towel, folded" in done.stdout
    assert json.loads((tmp_path / "towel.json").read_text())["garment_type"] == "towel"
    (line,) = (tmp_path / "errors.jsonl").read_text().splitlines()
    assert str(error) in json.loads(line)["message"]
    left = sorted(p.name for p in tmp_path.iterdir())
    assert left == ["errors.jsonl", "towel.json", "towel.png"]  # no picture of an earlier result
    again = CliRunner().invoke(main, [*call, "--resume"])
    assert again.exit_code == 0, again.output
    assert (tmp_path / "towel.stages.png").is_file()
