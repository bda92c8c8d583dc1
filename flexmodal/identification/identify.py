"""`identify`: from a campaign and a card to better parameters, their errors, and how well they carry over."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
from threadpoolctl import threadpool_limits

from flexmodal.campaign import Campaign
from flexmodal.identification.beside import baselines_beside
from flexmodal.identification.evidence.modal import MODEL_ERROR
from flexmodal.identification.held_out import predicted_apart
from flexmodal.identification.optima import search
from flexmodal.identification.outcome import Gaps, HeldOut, Identification, Optimum
from flexmodal.identification.problem import IdentificationProblem, build_identification
from flexmodal.identification.source import Source
from flexmodal.identification.stages import Stage, is_poor, staged
from flexmodal.model import Robot
from flexmodal.structure.parameter import ParameterSpace


def identify(
    campaign: Campaign,
    robot: Robot,
    *,
    source: Source | None = None,
    space: ParameterSpace | None = None,
    trust: Mapping[str, float] | None = None,
    hold_out: Sequence[str | int] = (),
    use: Sequence[str] | None = None,
    model_error: float = MODEL_ERROR,
    starts: int = 1,
    seed: int = 0,
    advance: Callable[[str], None] = lambda stage: None,
    before: Callable[[IdentificationProblem], None] = lambda problem: None,
) -> Identification:
    """Identify a robot's parameters.

    What is named in `hold_out` is never fitted, and the model is judged on it. Where nothing is named, every
    posture is left out in turn, refitted without, and predicted; so is every point; the parameters given
    are those of the fit to everything.

    Args:
        campaign: what was measured.
        robot: as its card says.
        source: "frf", "modes" or "both"; see `build_identification`.
        space: parameters; stiffness, damping, mass and inertia of the robot if None.
        trust: standard deviations of ln(true / card) by kind or name, over the card's.
        hold_out: names or ids of postures, or names of points, that the fit is not to see.
        use: what of the modes.
        model_error: relative error of natural frequencies that the model is granted.
        starts: how many starting points: the card, then others drawn from the prior. With one, and a prior of
            a decade on the stiffness, the fit goes in stages, see `flexmodal.identification.stages`.
        seed: of those.
        advance: called with the name of each stage as it begins.
        before: called with the problem before it is solved, to see what the data can tell.

    Raises:
        InvalidRequest: see `build_identification`.
        InaccurateModes, SingularResponse: see there.
    """
    advance("reading")
    problem = build_identification(
        campaign,
        robot,
        source=source,
        space=space,
        trust=trust,
        hold_out=hold_out,
        use=use,
        model_error=model_error,
    )
    before(problem)
    with threadpool_limits(1):  # matrices this small only wait for the threads of a BLAS
        return solve_identification(problem, starts=starts, seed=seed, advance=advance)


def solve_identification(
    problem: IdentificationProblem,
    *,
    starts: int = 1,
    seed: int = 0,
    in_turn: bool = True,
    advance: Callable[[str], None] = lambda stage: None,
) -> Identification:
    """Solve a problem that `build_identification` made; see `identify`.

    Args:
        problem: what is to be found, and from what.
        starts: how many starting points.
        seed: of those.
        in_turn: where nothing was named to be held out, leave out each posture and point in turn; without it
            there are no held-out gaps then.
        advance: called with the name of each stage as it begins.

    Raises:
        InvalidRequest: fewer than one start.
    """
    advance("what the data can tell")
    before = problem.identifiability
    advance("fitting")
    stages: tuple[Stage, ...] = ()
    if starts == 1 and is_poor(problem.evidence):
        fitted, stages = staged(problem.evidence)
        optima: tuple[Optimum, ...] = (Optimum(tuple(fitted.x.tolist()), fitted.cost, 1),)
    else:
        fitted, optima = search(problem.evidence, starts=starts, seed=seed)
    sure = problem.evidence.uncertainty(fitted)
    card = np.zeros(len(problem.space))
    shown = problem.evidence.predicted(fitted.x)
    fit_gap, card_gap = problem.evidence.gap(shown), problem.evidence.gap(problem.evidence.predicted(card))
    advance("holding out")
    parts = predicted_apart(problem, fitted) if in_turn or problem.held_out else None
    gaps = Gaps(
        before=card_gap.value,
        after=fit_gap.value,
        held_out_before=None if parts is None else parts.before.value,
        held_out_after=None if parts is None else parts.after.value,
        noise_floor=fit_gap.noise_floor,
        held_out_noise_floor=None if parts is None else parts.after.noise_floor,
    )
    return Identification(
        problem,
        fitted,
        sure,
        before,
        gaps,
        () if parts is None else parts.each,
        optima,
        _provenance(problem, () if parts is None else parts.each, starts, seed),
        problem.evidence.over_noise(shown),
        problem.evidence.shared_misfit(shown),
        None if parts is None else baselines_beside(problem, parts.predicted, fit_gap),
        stages,
        None if parts is None else parts.without,
    )


def _provenance(
    problem: IdentificationProblem, held: Sequence[HeldOut], starts: int, seed: int
) -> dict[str, Any]:
    from importlib.metadata import version

    campaign = problem.campaign
    kinds = dict.fromkeys(f"each {one.kind}" for one in held)
    in_turn = f"{' and '.join(kinds)} in turn" if kinds else "nothing"
    return {
        "campaign": campaign.title,
        "folder": None if campaign.path is None else str(campaign.path),
        "robot": problem.robot.name,
        "source": problem.source,
        "fitted_to": problem.what,
        "band": [float(campaign.band[0]), float(min(campaign.band[1], 1e9))],
        "held_out": [name for _, name in problem.held_out] or in_turn,
        "numbers": problem.evidence.count,
        "starts": starts,
        "seed": seed,
        "flexmodal": version("flexmodal"),
    }
