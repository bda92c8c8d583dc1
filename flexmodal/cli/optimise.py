"""`flexmodal optimise`."""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING, Any

import click

from flexmodal.cli.options import (
    SOURCE,
    band_of,
    hertz,
    json_option,
    load_robot,
    number,
    posture_of,
    quiet_option,
    robot_options,
)
from flexmodal.cli.printing import degrees, print_json, print_table, progress
from flexmodal.errors import Fault, InvalidRequest

if TYPE_CHECKING:
    from flexmodal.model import Robot
    from flexmodal.optimisation import Hold, Objective, Outcome

_OBJECTIVES = ("receptance", "stiffness", "mobility", "worst", "weighted", "tuned")
_BAND_LINES = 60
"""Lines a band is judged at, evenly spaced."""


@click.command()
@robot_options
@click.option("--hold", metavar="X,Z|X,Y,Z", help="Keep the end-effector there [m].")
@click.option("--family", metavar="NAME", help="Search along a family of the card.")
@click.option("--free", is_flag=True, help="Let the end-effector go anywhere.")
@click.option("--frequency", callback=hertz, metavar="HZ", help="Where the receptance is taken.")
@click.option("--band", metavar="LOW:HIGH", help="A band of frequencies instead of one.")
@click.option(
    "--direction",
    "directions",
    multiple=True,
    metavar="POINT:AXIS[=WEIGHT]",
    help="Such as tool:+z (the default); may be repeated.",
)
@click.option("--objective", type=click.Choice(_OBJECTIVES), default="receptance", show_default=True)
@click.option("--start", metavar="POSTURE", help="Compare with this posture, and start from it too.")
@click.option(
    "--starts", type=int, default=64, show_default=True, help="Starts in all; random but for --start."
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
@quiet_option
@json_option
@click.option("--show", is_flag=True, help="Start and optimum in the browser.")
def optimise(
    robot: str,
    stiffness: str | None,
    damping: str | None,
    tool: str | None,
    fix: str | None,
    hold: str | None,
    family: str | None,
    free: bool,
    frequency: float | None,
    band: str | None,
    directions: tuple[str, ...],
    objective: str,
    start: str | None,
    starts: int,
    seed: int,
    method: str,
    quiet: bool,
    as_json: bool,
    show: bool,
) -> None:
    """The posture that resists best, holding the end-effector, along a family, or free."""
    from flexmodal.optimisation import PostureProblem
    from flexmodal.optimisation import optimise as search

    _one_of(hold, family, free)
    arm = load_robot(robot, stiffness, damping, tool, fix)
    judge = _objective(arm, objective, directions, frequency, band)
    problem = PostureProblem(arm, judge, _hold(arm, hold))
    chosen = None if family is None else arm.family(family, source=f"{SOURCE} --family")
    where = None if start is None else posture_of(arm, start, "--start")
    with progress(401 if chosen else starts, "searching", quiet=quiet) as advance:
        outcome = search(
            problem, family=chosen, start=where, starts=starts, seed=seed, method=method, advance=advance
        )
    if as_json:
        print_json(_json(outcome))
    else:
        _print(outcome, objective)
    if show:
        from flexmodal.cli.viewing import viewer

        viewer("show_outcome")(outcome, start=where, announce=lambda text: click.echo(text, err=True))
    sys.exit(0 if outcome.converged else 1)


def _one_of(hold: str | None, family: str | None, free: bool) -> None:
    choices = {"--hold": hold is not None, "--family": family is not None, "--free": free}
    given = [name for name, on in choices.items() if on]
    if len(given) != 1:
        allowed = "exactly one of --hold X,Z, --family NAME and --free"
        raise InvalidRequest(Fault(SOURCE, "", " and ".join(given) or "none of them", allowed))


def _hold(arm: Robot, text: str | None) -> Hold | None:
    from flexmodal.optimisation import Hold

    if text is None:
        return None
    return Hold.at(
        arm, tuple(number(part, "--hold", "coordinates X,Z or X,Y,Z [m]") for part in text.split(","))
    )


def _objective(
    arm: Robot, name: str, given: tuple[str, ...], frequency: float | None, band: str | None
) -> Objective:
    import numpy as np

    from flexmodal.frf import PointDirection, frequency_axis
    from flexmodal.optimisation import (
        MobilityObjective,
        ReceptanceObjective,
        StiffnessObjective,
        TunedObjective,
    )

    split = [text.partition("=") for text in given] or [(f"{arm.tool}:+z", "", "")]
    read = tuple(PointDirection.parse(text, source=f"{SOURCE} --direction") for text, _, _ in split)
    for direction in read:
        arm.frame_of(direction.point, source=f"{SOURCE} --direction")
    weights = tuple(number(weight, "--direction", "a weight") if weight else 1.0 for _, _, weight in split)
    several = name in ("worst", "weighted", "tuned")
    if len(read) > 1 and not several:
        raise InvalidRequest(
            Fault(SOURCE, "--direction", f"{len(read)} directions", f"one for --objective {name}")
        )
    if name == "tuned":
        if band is None or frequency is not None:
            found = "no --band" if band is None else "--frequency"
            raise InvalidRequest(Fault(SOURCE, "--objective tuned", found, "--band LOW:HIGH, no --frequency"))
        return TunedObjective(read[0], band_of(band))
    if name in ("stiffness", "mobility"):
        if frequency is not None or band is not None:
            allowed = f"neither: the {name} measure has no frequency"
            raise InvalidRequest(Fault(SOURCE, "--frequency or --band", "given", allowed))
        return StiffnessObjective(read[0]) if name == "stiffness" else MobilityObjective(read[0])
    if (frequency is None) == (band is None):
        raise InvalidRequest(
            Fault(
                SOURCE,
                "--frequency",
                "none" if band is None else "given with --band",
                "--frequency HZ or --band LOW:HIGH",
            )
        )
    lines = np.array([frequency]) if band is None else np.linspace(*band_of(band), _BAND_LINES)
    axis = frequency_axis(lines, source=f"{SOURCE} --frequency")
    return ReceptanceObjective(read, axis, "worst" if name == "worst" else "weighted", weights)


def _json(outcome: Outcome) -> dict[str, Any]:
    chosen = _frequency(outcome)
    return ({} if chosen is None else {"frequency": chosen}) | {
        "posture": dict(outcome.best.posture.values),
        "objective": outcome.best.objective,
        "start": outcome.start,
        "unit": outcome.problem.objective.unit,
        "tool": list(outcome.tool),
        "converged": outcome.converged,
        "starts": outcome.starts,
        "optima": [
            {"posture": dict(optimum.posture.values), "objective": optimum.objective, "hits": optimum.hits}
            for optimum in outcome.optima
        ],
    }


def _frequency(outcome: Outcome) -> float | None:
    """The frequency that was chosen with the posture, if it was [Hz]."""
    from flexmodal.optimisation import TunedObjective

    objective = outcome.problem.objective
    if not isinstance(objective, TunedObjective):
        return None
    return objective.frequency_at(outcome.problem.robot.at(outcome.best.posture))


def _print(outcome: Outcome, objective: str) -> None:
    robot = outcome.problem.robot
    unit = outcome.problem.objective.unit
    columns = ["", f"{objective} [{unit}]", "hits", *robot.commanded]
    rows = []
    for place, optimum in enumerate(outcome.optima[:10], start=1):
        angles = [
            degrees(value, prismatic=robot.commanded[name].type == "prismatic")
            for name, value in optimum.posture.values.items()
        ]
        rows.append([f"optimum {place}", f"{optimum.objective:.5g}", str(optimum.hits), *angles])
    print_table(f"{robot.name}: best postures found", columns, rows)
    if len(outcome.optima) > 10:
        click.echo(f"and {len(outcome.optima) - 10} more; --json lists them all")
    if outcome.start is not None:
        better, worse = sorted((outcome.best.objective, outcome.start))
        factor = f": a factor of {worse / better:.3g}" if better > 0 else ""
        click.echo(f"start {outcome.start:.5g} {unit}, best {outcome.best.objective:.5g}{factor}")
    chosen = _frequency(outcome)
    if chosen is not None:
        click.echo(f"best frequency {chosen:.6g} Hz")
    click.echo(
        f"{robot.tool} at ({', '.join(f'{value:.4f}' for value in outcome.tool)}) m; {outcome.verdict}"
    )
