"""Draw the pictures of the pages about the stages: python docs/draw_stages.py docs/stages/drawn.

One scene goes through all of them: a photograph of a folded T-shirt, drawn by `foldrs.synth`.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

import foldrs
from foldrs import _core, _plot_panels, _plot_pens, _stages_panels
from foldrs.matching_details import matching_details
from foldrs.outline import find_outline
from foldrs.parameters import Parameters
from foldrs.synth import Scene, SynthParameters, make_scene

Panel = tuple[str, Callable[[Axes], object]]
HEIGHT, WIDTH, DPI = 3.6, 3.9, 110  # inches a panel, px an inch
MATCHES = ("#cc79a7", "#009e73", "#e69f00")


@dataclass(frozen=True)
class Example:
    """One photograph, explained by both methods."""

    scene: Scene
    paper: foldrs.FitResult
    best: foldrs.FitResult

    @classmethod
    def drawn(cls) -> Example:
        """Draw the scene and explain it; kind and scale are told, so that there is one template to show."""
        between_landmarks = SynthParameters(scenarios=("landmarks",), flap_fraction=(0.15, 0.4))
        scene = make_scene(foldrs.builtin_templates("t-shirt")[0], seed=2, parameters=between_landmarks)
        paper, best = (
            foldrs.fit(scene.image, garment_type="t-shirt", px_per_cm=4, method=method)
            for method in ("paper", "best")
        )
        return cls(scene, paper, best)


def line(points: NDArray[np.float64], colour: str, width: float = 1.6) -> Callable[[Axes], None]:
    """Draw an outline alone in a panel."""

    def draw(ax: Axes) -> None:
        _plot_pens.frame(ax, points)
        _plot_pens.line(ax, _plot_pens.closed(points), colour, width)

    return draw


def outline(example: Example) -> list[Panel]:
    """Show the photograph, the cloth found in it, candidate creases."""
    image, result = example.scene.image, example.paper
    found = find_outline(image)

    def cloth(ax: Axes) -> None:
        _plot_pens.frame(ax, found.points)
        _plot_pens.photograph(ax, image, pale=True)
        _plot_pens.line(ax, _plot_pens.closed(found.points), _plot_panels.SEEN, 2.0, halo="white")

    return [
        ("photograph", lambda ax: ax.imshow(image)),
        ("outline", cloth),
        _stages_panels.matching_panels(result, result.stages[0], image)[0],
    ]


def partial_matching(example: Example) -> list[Panel]:
    """Show the likest pieces of the seen outline and of the template."""
    seen, template = example.paper.outline_image, example.paper.original_template.outline
    matches = matching_details(example.paper).matches

    def one_side(which: int, points: NDArray[np.float64], colour: str) -> Callable[[Axes], None]:
        def draw(ax: Axes) -> None:
            line(points, colour)(ax)
            for number, (match, shade) in enumerate(zip(matches, MATCHES, strict=False)):
                piece = match[which]
                ax.plot(*piece.T, color=shade, linewidth=7, alpha=0.5, solid_capstyle="butt")
                ax.text(*piece[len(piece) // 2], str(number + 1), fontsize=13, weight="bold")

        return draw

    return [
        ("seen outline", one_side(0, seen, _plot_panels.SEEN)),
        ("template: the pieces like it", one_side(1, template, _plot_panels.MODEL)),
    ]


def hypotheses(example: Example) -> list[Panel]:
    """Show all axes claimed, and the cheapest after folding."""
    parameters = asdict(Parameters().matching)
    template = foldrs.builtin_templates("t-shirt")[0].outline
    candidates, _ = _core.Seen(example.paper.outline_image, parameters).matches([template], 4.0)
    sure = max(candidate.confidence for candidate in candidates)

    def claims(ax: Axes) -> None:
        line(template, _plot_panels.MODEL)(ax)
        for candidate in candidates:
            ax.plot(
                *candidate.axis.T, color=_plot_panels.SEEN, alpha=(0.1 + candidate.confidence / sure) / 1.1
            )

    def verified(ax: Axes) -> None:
        line(template, _plot_panels.MODEL)(ax)
        for candidate in candidates[:3]:
            _plot_pens.line(ax, candidate.axis, _plot_panels.CREASE, 2.0 + candidate.confidence / sure)
            ax.text(*candidate.axis[1], f" {candidate.cost:.2f}", color=_plot_panels.CREASE, fontsize=11)

    return [
        (f"{len(candidates)} axes claimed, the darker the surer", claims),
        ("the three cheapest after folding, with their cost", verified),
    ]


def virtual_folding(example: Example) -> list[Panel]:
    """Show a fold across the whole garment, and one of a sleeve alone."""
    template = foldrs.builtin_templates("t-shirt")[0].outline
    low, high = template.min(axis=0), template.max(axis=0)
    width, height = high - low
    across = np.array([[low[0], low[1] + 0.75 * height], [high[0], low[1] + 0.6 * height]])
    sleeve = np.array([[low[0] + 0.12 * width, low[1]], [low[0] + 0.12 * width, high[1]]])

    def folded(axis: NDArray[np.float64]) -> Callable[[Axes], None]:
        def draw(ax: Axes) -> None:
            layers = _core.fold_layers(template, axis)
            _plot_pens.frame(ax, np.vstack([template, layers.outline]))
            _plot_pens.fill(ax, layers.kept, _plot_panels.KEPT, 0.35)
            _plot_pens.fill(ax, layers.flap, _plot_panels.FLAP, 0.5)
            _plot_pens.line(ax, _plot_pens.closed(template), _plot_panels.FAINT, 1.0, linestyle=(0, (3, 2)))
            _plot_pens.line(ax, _plot_pens.closed(layers.outline), _plot_panels.MODEL, 1.8)
            for crease in layers.creases:
                _plot_pens.line(ax, crease, _plot_panels.CREASE, 3.0)

        return draw

    return [
        ("an axis across the garment", folded(across)),
        ("an axis that covers a sleeve's chord alone", folded(sleeve)),
    ]


def comparing_shapes(example: Example) -> list[Panel]:
    """Show inner distances from a hem, and correspondences."""
    trousers = foldrs.builtin_templates("pants")[0]
    points = _core.resample(trousers.outline, 200)
    start = int(np.linalg.norm(points - trousers.landmarks["hem_left_inner"], axis=1).argmin())
    straight = np.linalg.norm(points - points[start], axis=1)
    inner = _core.inner_distances(points)[start]

    def coloured(distance: NDArray[np.float64]) -> Callable[[Axes], None]:
        def draw(ax: Axes) -> None:
            line(points, _plot_panels.FAINT, 1.0)(ax)
            ax.scatter(*points.T, c=distance, s=26, vmin=0, vmax=inner.max(), zorder=3)
            ax.plot(*points[start], "s", color="black", markersize=9)

        return draw

    result = example.paper
    return [
        ("straight distance from the square, cm", coloured(straight)),
        ("inner distance: round the crotch", coloured(inner)),
        _stages_panels.matching_panels(result, result.stages[0], None)[3],
    ]


def fitting(example: Example) -> list[Panel]:
    """Show one pass of the fitting stage."""
    return _stages_panels.fitting_panels(example.paper.stages[0])


def joint_fit(example: Example) -> list[Panel]:
    """Show the fitted template, and how it agrees with what is seen."""
    result, image = example.best, example.scene.image
    return [
        ("template given (grey) and fitted", lambda ax: _plot_panels.draw_fitted_template(ax, result)),
        ("folded, over the outline seen", lambda ax: _plot_panels.draw_agreement(ax, result, image)),
    ]


def model(example: Example) -> list[Panel]:
    """Show where cloth lies twofold; landmarks, grasp pair."""
    result, image = example.best, example.scene.image
    layers = _core.fold_layers(result.unfolded_outline_image, result.fold.axis_image)

    def twofold(ax: Axes) -> None:
        line(result.outline_image, _plot_panels.SEEN)(ax)
        _plot_pens.fill(ax, layers.double_layer, _plot_panels.FLAP, 0.6)
        for mark in result.landmarks.values():
            _plot_pens.dot(ax, mark.image, filled=mark.accessible)

    return [
        ("where cloth lies twofold; filled: in reach", twofold),
        ("the best grasp pair", lambda ax: _plot_panels.draw_evidence(ax, result, image, [])),
    ]


STAGES = (outline, partial_matching, hypotheses, virtual_folding, comparing_shapes, fitting, joint_fit, model)


def draw(panels: list[Panel], path: Path) -> None:
    """Draw panels side by side."""
    figure = Figure(figsize=(WIDTH * len(panels), HEIGHT), dpi=DPI, layout="constrained")
    for number, (caption, drawn) in enumerate(panels):
        ax = figure.add_subplot(1, len(panels), number + 1)
        drawn(ax)
        ax.set_axis_off()
        ax.set_title(caption, fontsize=8, loc="left")
    figure.savefig(path)


def main() -> None:
    """Draw the picture of every stage."""
    folder = Path(sys.argv[1])
    folder.mkdir(parents=True, exist_ok=True)
    example = Example.drawn()
    for stage in STAGES:
        draw(stage(example), folder / f"{stage.__name__}.png")


if __name__ == "__main__":
    main()
