"""`flexmodal identify`."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from flexmodal.cli.measured import campaign_at, robot_of, say_doubled, say_findings
from flexmodal.cli.options import (
    MOST_STARTS,
    force_option,
    json_option,
    poor_option,
    quiet_option,
    trust_of,
    trust_option,
)
from flexmodal.cli.printing import noted_progress, print_json, print_table, say

if TYPE_CHECKING:
    from flexmodal.identification import Identification, IdentificationProblem
    from flexmodal.model import Robot

_STEPS = 4
PICTURES = ("fit.png", "fit.svg")
OWN = ("identification.json", "report.html", *PICTURES, "robot/robot.toml", "robot/*.urdf")
"""All that it writes: a folder that holds anything else is never replaced."""


@click.command()
@click.argument("campaign", type=click.Path(path_type=Path))
@click.option(
    "--from",
    "source",
    type=click.Choice(["modes", "frf", "both"]),
    help="What to fit; everything that was measured by default.",
)
@click.option(
    "--hold-out",
    multiple=True,
    metavar="POSTURE",
    help="A posture or a point that the fit is not to see; may be repeated. Each in turn if none is named.",
)
@click.option("--use", metavar="WHAT,…", help="Of modes: frequency, damping, shape, residue, antiresonance.")
@click.option("--robot", metavar="ROBOT", help="Instead of the robot that the campaign names.")
@click.option(
    "--kinds",
    default="stiffness,damping,mass,inertia",
    show_default=True,
    help="Kinds of parameters; mass_centre, position (of pseudo-joints) and payload besides.",
)
@trust_option
@poor_option
@click.option(
    "--starts",
    type=click.IntRange(1, MOST_STARTS),
    default=1,
    show_default=True,
    help="Starting points: the card, then random.",
)
@click.option("--seed", type=click.IntRange(min=0), default=0, show_default=True, help="Of those.")
@click.option(
    "--out",
    type=click.Path(path_type=Path),
    help="A folder for the improved card, a page, pictures and JSON.",
)
@force_option
@quiet_option
@json_option
def identify(
    campaign: Path,
    source: str | None,
    hold_out: tuple[str, ...],
    use: str | None,
    robot: str | None,
    kinds: str,
    trust: tuple[str, ...],
    poor_card: bool,
    starts: int,
    seed: int,
    out: Path | None,
    force: bool,
    quiet: bool,
    as_json: bool,
) -> None:
    """Stiffness, damping and inertia from a campaign, with uncertainty; exit 1 if it does not converge."""
    from flexmodal.identification import identify as find
    from flexmodal.identification.as_json import as_json as as_object
    from flexmodal.identification.poor import POOR
    from flexmodal.structure import robot_space

    measured = campaign_at(campaign)
    arm = robot_of(measured, robot)
    if out is not None:
        _refuse_out(out, arm, force)
    say_doubled(measured, source)
    say_findings(measured, arm)
    trusted = {**(POOR if poor_card else {}), **trust_of(trust)}
    wanted = [kind.strip() for kind in kinds.split(",") if kind.strip()]
    with noted_progress(_STEPS, "identifying", quiet=quiet) as (advance, note):

        def begin(stage: str) -> None:
            advance()
            note(stage)

        outcome = find(
            measured,
            arm,
            source=source,  # type: ignore[arg-type]  # click has seen to it
            space=robot_space(arm, wanted, trust=trusted),
            hold_out=hold_out,
            use=None if use is None else [part.strip() for part in use.split(",")],
            starts=starts,
            seed=seed,
            advance=begin,
            before=_say_before if not as_json else lambda problem: None,
        )
    found = as_object(outcome)
    if out is not None:
        _write(outcome, found, out, force)
        say(f"wrote {out}: improved card {out / 'robot' / 'robot.toml'}", err=True)
    if as_json:
        print_json(found)
    else:
        _print(outcome)
    sys.exit(0 if outcome.fitted.converged else 1)


def _say_before(problem: IdentificationProblem) -> None:
    """What the data can tell, while the fit is still to come."""
    say(f"before the fit: {problem.identifiability.verdict}", err=True)


def _refuse_out(out: Path, robot: Robot, force: bool) -> None:
    """Complain about the folder before the work starts."""
    from flexmodal.files import refuse_folder
    from flexmodal.identification.improved import refuse_own

    refuse_own(robot, out / "robot")
    refuse_folder(out, own=OWN, overwrite=force)


def _write(outcome: Identification, found: dict[str, Any], out: Path, force: bool) -> None:
    from flexmodal.files import whole_folder
    from flexmodal.identification.improved import write_improved
    from flexmodal.identification.page import write_identification_page
    from flexmodal.identification.plot import draw_identification
    from flexmodal.report import write_figure, write_json

    campaign, robot = outcome.problem.campaign, outcome.problem.robot
    source = f"the card {robot.name}, identified from the campaign: {campaign.title}. {outcome.verdict}"
    with whole_folder(out, own=OWN, overwrite=force) as scratch:
        write_improved(robot, outcome.values, scratch / "robot", source=source, home=out / "robot")
        write_json(found, scratch / "identification.json")
        write_identification_page(outcome, scratch / "report.html")
        figure = draw_identification(outcome)
        for name in PICTURES:
            write_figure(figure, scratch / name)


def _print(outcome: Identification) -> None:
    from flexmodal.identification.page import (
        BESIDE,
        GAPS,
        HEADER,
        STAGES,
        baseline_cells,
        estimate_cells,
        gap_cells,
        stage_cells,
    )

    problem = outcome.problem
    rows = [estimate_cells(one) for one in outcome.estimates]
    print_table(f"{problem.campaign.title}: {problem.robot.name} from {problem.what}", HEADER, rows)
    print_table("gap", GAPS, gap_cells(outcome))
    if outcome.stages:
        print_table("stages", STAGES, stage_cells(outcome))
    if outcome.baselines is not None:
        print_table("gap beside simple baselines", BESIDE, baseline_cells(outcome.baselines))
    for a, b, r in outcome.correlated:
        say(f"correlated: {a} and {b}, {r:+.3f}")
    for one in outcome.not_identified:
        say(f"not identified: {one.says}")
    say(outcome.verdict)
