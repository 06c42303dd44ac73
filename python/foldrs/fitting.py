"""Stage 5, the fitting stage (section 2.2): templates changed until they fit the seen outline.

Every pass registers a fold of the template to the seen outline, unfolds it virtually, makes the next template
of it and matches that. The cheapest match of all passes wins.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from foldrs import _core
from foldrs._stopwatch import Stopwatch
from foldrs.alternatives import alike
from foldrs.explanation import Explanation, directed_crease
from foldrs.landmark import carried
from foldrs.parameters import AlternativeParameters, FittingParameters
from foldrs.result import FittedTemplate, Fold
from foldrs.template import Template
from foldrs.template_update import Points, TemplateUpdate, update_template


@dataclass(frozen=True, eq=False)
class FitStage:
    """One template of the iteration: how it matched, and what became of it."""

    explanation: Explanation
    """The template as it was matched, with the axis found on it."""
    laid: _core.Explanation
    """Its folded outline and the correspondences."""
    update: TemplateUpdate | None = None
    """The pass that followed; None after the last one, and if the template could not be changed."""


@dataclass(frozen=True, eq=False)
class IterativeFit:
    """One course of the iteration, from one fold of a template as given."""

    stages: tuple[FitStage, ...]
    """The template as given, then that of every pass."""

    @property
    def cheapest(self) -> FitStage:
        """The stage of the cheapest match, the earliest of equals."""
        return min(self.stages, key=lambda stage: stage.explanation.cost)

    @property
    def explanation(self) -> Explanation:
        """The cheapest match, placed in the image as its registration has it (section 2.2.1)."""
        stage = self.cheapest
        if stage.update is None:
            return stage.explanation
        told = stage.explanation
        # Where the garment shows its other face, the registration's frame has x the other way round.
        way = np.array([-1.0 if np.linalg.det(told.to_image[:, :2]) < 0 else 1.0, 1.0])
        (fold,) = told.folds
        crease = directed_crease(stage.update.fold.axis * way, fold.axis_template, told.to_image)
        placed = replace(told, placed=stage.update.corners * way, folds=(replace(fold, axis_image=crease),))
        return placed if placed.holds else told


def fit_iteratively(
    seen: _core.Seen,
    templates: Sequence[Template],
    px_per_unit: float | None,
    parameters: FittingParameters,
    same: AlternativeParameters,
    clock: Stopwatch | None = None,
) -> list[IterativeFit]:
    """Match templates and fit them, in turn (section 2.2).

    Parameters
    ----------
    seen : _core.Seen
        The seen outline.
    templates : sequence of Template
        Those that compete.
    px_per_unit : float or None
        The scale, if known.
    parameters : FittingParameters
        Parameters of the stage.
    same : AlternativeParameters
        When two folds are one, so that the iteration does not start from it twice.
    clock : Stopwatch, optional
        Gets the laps ``matching``, of the templates as given, and ``fitting``, all that follows.

    Returns
    -------
    list of IterativeFit
        One a start, the cheapest explanation first; empty if no fold of any template could be compared.
    """
    clock = clock or Stopwatch()
    iteration = _Iteration(seen, px_per_unit, parameters)
    courses = [[stage] for stage in iteration.starts(templates, same)]
    clock.lap("matching")
    moving = courses
    for _ in range(parameters.iterations):
        moving = iteration.advance(moving)
    for course in courses:
        # The cheapest stage is placed by its registration: the last one has none yet.
        course[-1] = replace(course[-1], update=course[-1].update or iteration.update(course[-1]))
    fits = [fit for fit in map(IterativeFit, map(tuple, courses)) if fit.explanation.holds]
    clock.lap("fitting")
    return sorted(fits, key=lambda fit: fit.explanation.cost)  # stable: equals keep their order


@dataclass(frozen=True, eq=False)
class _Iteration:
    """What all passes share."""

    seen: _core.Seen
    px_per_unit: float | None
    parameters: FittingParameters

    def starts(self, templates: Sequence[Template], same: AlternativeParameters) -> list[FitStage]:
        """Find the folds of the templates as given to start from: the cheapest distinct ones of each."""
        outlines = [t.outline for t in templates]
        # One start is the cheapest fold; where that cannot be laid over the outline, others are looked at.
        if self.parameters.starts == 1:
            cheapest, unfolded = self.seen.matches(outlines, self.px_per_unit, cheapest_only=True)
            found = self._distinct(templates, cheapest, unfolded, same)
            if all(found[candidate.template] for candidate in cheapest):
                return [stage for stages in found for stage in stages]
        found = self._distinct(templates, *self.seen.matches(outlines, self.px_per_unit), same)
        return [stage for stages in found for stage in stages]

    def _distinct(
        self,
        templates: Sequence[Template],
        candidates: Sequence[_core.Candidate],
        unfolded: Sequence[float],
        same: AlternativeParameters,
    ) -> list[list[FitStage]]:
        """Lay the cheapest distinct candidates of every template over the outline."""
        per_template: list[list[FitStage]] = [[] for _ in templates]
        spare = max(self.parameters.starts_in_all - len(templates), 0)
        for candidate in candidates:
            template, found = templates[candidate.template], per_template[candidate.template]
            if len(found) == self.parameters.starts or (found and not spare):
                continue
            first = found[0].explanation if found else None
            stage = self.stage(template, template.outline, candidate, unfolded[candidate.template], first)
            if stage is None or any(alike(stage.explanation, other.explanation, same) for other in found):
                continue
            spare -= bool(found)
            found.append(stage)
        return per_template

    def advance(self, courses: Sequence[list[FitStage]]) -> list[list[FitStage]]:
        """Match the updated template of every course and add the stage; return the courses that go on."""
        going = []
        for course in courses:
            update = self.update(course[-1])
            if update is not None:
                course[-1] = replace(course[-1], update=update)
                going.append((course, update.outline))
        if not going:
            return []
        candidates, unfolded = self.seen.matches(
            [outline for _, outline in going], self.px_per_unit, cheapest_only=True
        )
        cheapest = {c.template: c for c in candidates}
        moved = []
        for i, (course, outline) in enumerate(going):
            if i not in cheapest:
                continue
            first = course[0].explanation
            stage = self.stage(first.template, outline, cheapest[i], unfolded[i], first)
            if stage is not None:
                course.append(stage)
                moved.append(course)
        return moved

    def stage(
        self,
        template: Template,
        outline: Points,
        candidate: _core.Candidate,
        unfolded_cost: float,
        first: Explanation | None,
    ) -> FitStage | None:
        """Lay a fold of a template, as given or as fitted so far, over the seen outline.

        `first` is what the matching stage found on the template as given; None if that is this very fold.
        """
        laid = self.seen.explain(outline, candidate)
        if laid is None:
            return None
        explanation = Explanation(
            template=template,
            original_axis=first.original_axis if first else candidate.axis,
            fitted=FittedTemplate(
                outline, carried(template.landmarks, template.outline, outline), candidate.axis
            ),
            to_image=laid.to_seen,
            folds=(Fold(directed_crease(laid.crease, candidate.axis, laid.to_seen), candidate.axis),),
            cost=candidate.cost,
            original_cost=first.original_cost if first else candidate.cost,
            # The fold has to beat the template unfolded in any shape it took.
            unfolded_cost=min(unfolded_cost, first.unfolded_cost) if first else unfolded_cost,
        )
        return FitStage(explanation, laid)

    def update(self, stage: FitStage) -> TemplateUpdate | None:
        """Make the next template of a stage; None if that cannot be done."""
        (fold,) = stage.explanation.folds
        return update_template(
            stage.explanation.fitted.outline,
            fold.axis_template,
            stage.laid,
            self.seen.points,
            self.px_per_unit,
            self.parameters,
        )
