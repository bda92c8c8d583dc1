"""`flexmodal optimise`."""

from __future__ import annotations

import math
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn

import click

from flexmodal.cli.clearing import clearance_of, clearance_options, say_clearance
from flexmodal.cli.holds import hold_of, orientation_options
from flexmodal.cli.objectives import judging_options, objective_of
from flexmodal.cli.optimised import band_of, chosen_frequency, outcome_json
from flexmodal.cli.options import (
    MOST_STARTS,
    SOURCE,
    RobotOptions,
    force_option,
    is_typed_in_radians,
    json_option,
    posture_of,
    quiet_option,
    robot_options,
)
from flexmodal.cli.picturing import draw_pictures, pictures_of, plot_option
from flexmodal.cli.printing import degrees, noted_progress, print_json, print_table, progress, say
from flexmodal.cli.sources import Sourcing, band_says, source_options
from flexmodal.cli.viewing import deliver, page_option, refuse_page
from flexmodal.errors import Fault, InvalidRequest

if TYPE_CHECKING:
    from flexmodal.cards import FamilyCard
    from flexmodal.model import Posture
    from flexmodal.optimisation import Outcome, PostureProblem, Start


_NEAR = 1e-6
"""A tool this near its target is on it [m]."""


@click.command()
@robot_options
@click.option("--hold", metavar="X,Z|X,Y,Z", help="Keep the end-effector there [m].")
@orientation_options
@click.option("--family", metavar="NAME", help="Search along a family of the card.")
@click.option("--free", is_flag=True, help="Let the end-effector go anywhere.")
@judging_options
@source_options
@clearance_options
@click.option("--start", metavar="POSTURE", help="Compare with this posture, and start from it too.")
@click.option(
    "--starts",
    type=click.IntRange(1, MOST_STARTS),
    help="Starts in all, random but for --start; if none, till the best is found again.",
)
@click.option(
    "--seed", type=click.IntRange(min=0), default=0, show_default=True, help="Of the random starts."
)
@click.option(
    "--method",
    type=click.Choice(["newton", "null-space"]),
    default="newton",
    show_default=True,
    help="null-space: the thesis's gradient descent, from --start.",
)
@plot_option
@force_option
@click.option(
    "--scheduler", metavar="ADDRESS", help="A Dask scheduler over whose workers --starts are spread."
)
@quiet_option
@json_option
@page_option("the search, descent by descent,")
@click.option("--show", is_flag=True, help="Start and optimum in the browser.")
def optimise(
    robot: RobotOptions,
    hold: str | None,
    family: str | None,
    free: bool,
    sourcing: Sourcing,
    orientation: str | None,
    axis: str | None,
    tool_axis: str,
    clearance: str | None,
    no_collisions: bool,
    start: str | None,
    starts: int | None,
    seed: int,
    method: str,
    plots: tuple[str, ...],
    force: bool,
    scheduler: str | None,
    quiet: bool,
    as_json: bool,
    page: Path | None,
    show: bool,
    **judging: Any,
) -> None:
    """The posture that resists best, holding the end-effector, along a family, or free."""
    from flexmodal.optimisation import PostureProblem

    _one_of(hold, family, free)
    refuse_page(page, force)
    pictures = pictures_of(
        plots, force=force, hold=hold is not None, start=start is not None, family=family is not None
    )
    arm = robot.load()
    predicted = sourcing.source(arm, quiet=quiet)
    judge = objective_of(arm, seed=seed, source=predicted, **judging)
    kept = clearance_of(arm, clearance, no_collisions)
    problem = PostureProblem(arm, judge, hold_of(arm, hold, orientation, axis, tool_axis), clearance=kept)
    chosen = None if family is None else arm.family(family, source=f"{SOURCE} --family")
    where = None if start is None else posture_of(arm, start, "--start")
    if scheduler is None:
        outcome = _search(problem, chosen, where, starts, seed, method, quiet)
    else:
        _refuse_along(family is not None, method)
        outcome = _spread(problem, where, starts, seed, scheduler, quiet)
    if as_json:
        print_json(outcome_json(outcome) | ({} if predicted is None else {"prediction": band_of(outcome)}))
    else:
        _print(outcome, judging["objective"], radians=is_typed_in_radians(start))
        if predicted is not None:
            say("; ".join(band_says(outcome.best.objective, judge.unit, band_of(outcome))))
    shown = None if outcome.compared is None else outcome.compared.held
    draw_pictures(outcome, shown, pictures, force=force, quiet=quiet)
    deliver("show_outcome", outcome, page=page, show=show, force=force, start=shown)
    _leave(outcome)


def _search(
    problem: PostureProblem,
    family: FamilyCard | None,
    start: Posture | None,
    starts: int | None,
    seed: int,
    method: str,
    quiet: bool,
) -> Outcome:
    from flexmodal.optimisation import optimise as search
    from flexmodal.optimisation.search import BLOCK, DEFAULT_STARTS, choose_way

    way = "plain" if family or method != "newton" else choose_way(problem, starts or DEFAULT_STARTS)
    total = 401 if family else starts or (BLOCK if way == "compiled" else DEFAULT_STARTS)
    unit = problem.objective.unit
    with noted_progress(total, "searching", quiet=quiet) as (advance, note):
        return search(
            problem,
            family=family,
            start=start,
            starts=starts,
            seed=seed,
            method=method,
            way=way,
            advance=advance,
            improved=lambda value: note(f"best {value:.4g} {unit}"),
        )


def _spread(
    problem: PostureProblem,
    start: Posture | None,
    starts: int | None,
    seed: int,
    scheduler: str,
    quiet: bool,
) -> Outcome:
    from flexmodal.atlas import search_spread
    from flexmodal.atlas.search import EACH
    from flexmodal.optimisation.search import DEFAULT_STARTS

    count = starts or DEFAULT_STARTS
    with progress(-(-count // EACH), "searching", quiet=quiet) as advance:
        return search_spread(problem, count, start=start, seed=seed, scheduler=scheduler, advance=advance)


def _refuse_along(family: bool, method: str) -> None:
    other = "--family" if family else f"--method {method}"
    if family or method != "newton":
        allowed = "--hold or --free by newton, from many starts"
        raise InvalidRequest(Fault(SOURCE, "--scheduler", f"with {other}", allowed))


def _leave(outcome: Outcome) -> NoReturn:
    if outcome.interrupted:
        say("flexmodal: interrupted", err=True)
        sys.exit(130)
    sys.exit(0 if outcome.converged else 1)


def _one_of(hold: str | None, family: str | None, free: bool) -> None:
    choices = {"--hold": hold is not None, "--family": family is not None, "--free": free}
    given = [name for name, on in choices.items() if on]
    if len(given) != 1:
        allowed = "exactly one of --hold X,Z, --family NAME and --free"
        raise InvalidRequest(Fault(SOURCE, "", " and ".join(given) or "none of them", allowed))


def _print_start(outcome: Outcome, compared: Start, *, radians: bool) -> None:
    """The start as it was given, and as it holds the target: the best is compared with that alone."""
    unit, start = outcome.problem.objective.unit, outcome.start
    if not compared.is_held:
        given = "infinite" if math.isinf(compared.objective) else f"{compared.objective:.5g} {unit}"
        off = f"{1e3 * compared.away:.4g} mm from the target" if compared.away > _NEAR else "turned otherwise"
        say(f"start as given: {given}, but its tool is {off}, so it is not compared")
    if compared.held is None or start is None:
        say("start: could not be brought onto the target")
        return
    name = "start" if compared.is_held else "start brought to the target"
    moved = "" if compared.is_held else f" ({_moved(outcome, compared, radians)})"
    if math.isinf(start):
        say(f"{name}: infinite, an undamped mode is driven at its natural frequency there")
        return
    better, worse = sorted((outcome.best.objective, start))
    factor = f": a factor of {worse / better:.3g}" if better > 0 else ""
    say(f"{name} {start:.5g} {unit}{moved}, best {outcome.best.objective:.5g}{factor}")


def _moved(outcome: Outcome, compared: Start, radians: bool) -> str:
    """How far the joints had to move for it."""
    assert compared.held is not None
    robot = outcome.problem.robot
    far = {n: abs(compared.held.values[n] - compared.given.values[n]) for n in robot.commanded}
    name = max(far, key=far.__getitem__)
    by = degrees(far[name], prismatic=robot.commanded[name].is_prismatic, radians=radians)
    return f"{name} moved most, by {by}"


def _print(outcome: Outcome, objective: str, *, radians: bool) -> None:
    robot = outcome.problem.robot
    unit = outcome.problem.objective.unit
    names = [
        f"{name} [rad]" if radians and not joint.is_prismatic else name
        for name, joint in robot.commanded.items()
    ]
    columns = ["", f"{objective} [{unit}]", "hits", *names]
    rows = []
    for place, optimum in enumerate(outcome.optima[:10], start=1):
        angles = [
            degrees(value, prismatic=robot.commanded[name].is_prismatic, radians=radians)
            for name, value in optimum.posture.values.items()
        ]
        rows.append([f"optimum {place}", f"{optimum.objective:.5g}", str(optimum.hits), *angles])
    print_table(f"{robot.name}: best postures found", columns, rows)
    if len(outcome.optima) > 10:
        say(f"and {len(outcome.optima) - 10} more; --json lists them all")
    several = sum(bool(optimum.equals) for optimum in outcome.optima)
    if several:
        what = "a wrist turned over, an idle joint"
        say(f"{several} of them stand for several postures of one value ({what}); --json lists them")
    if outcome.compared is not None:
        _print_start(outcome, outcome.compared, radians=radians)
    chosen = chosen_frequency(outcome)
    if chosen is not None:
        say(f"best frequency {chosen:.6g} Hz")
    say(f"{robot.tool} at ({', '.join(f'{value:.4f}' for value in outcome.tool)}) m; {outcome.verdict}")
    say_clearance(outcome.problem.clearance, outcome.nearest)
