"""`flexmodal diagnose`."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING

import click

from flexmodal.cli.measured import campaign_at, robot_of, say_doubled, say_findings
from flexmodal.cli.options import force_option, json_option, quiet_option, trust_of, trust_option
from flexmodal.cli.printing import print_json, print_table, say, stages
from flexmodal.cli.viewing import deliver, page_option, refuse_page

if TYPE_CHECKING:
    from flexmodal.diagnosis import Diagnosis

_MOST_WORKERS = 256


@click.command()
@click.argument("campaign", type=click.Path(path_type=Path))
@click.option("--out", required=True, type=click.Path(path_type=Path), help="A new folder for what is found.")
@click.option(
    "--from",
    "source",
    type=click.Choice(["modes", "frf", "both"]),
    help="What counts; everything that was measured by default.",
)
@click.option("--robot", metavar="ROBOT", help="Instead of the robot that the campaign names.")
@click.option(
    "--hold-out",
    multiple=True,
    metavar="POSTURE",
    help="A posture, by name or id, that no fit is to see; may be repeated. One in four if none is named.",
)
@click.option(
    "--effects",
    metavar="NAME,…",
    help="Look for these effects only; NAME@WHERE in that place, added if it explains anything.",
)
@trust_option
@click.option(
    "--seed",
    type=click.IntRange(min=0),
    default=0,
    show_default=True,
    help="Of what is drawn in the comparison.",
)
@click.option(
    "--within",
    type=click.FloatRange(min=0, min_open=True),
    metavar="SECONDS",
    help="Stop looking after so long, and say what was found by then.  [default: as long as it takes]",
)
@click.option(
    "--workers",
    type=click.IntRange(1, _MOST_WORKERS),
    metavar="NUMBER",
    help="Processes that it works on, on Linux.  "
    "[default: FLEXMODAL_WORKERS, or as many as cores, at most 8]",
)
@page_option("the arm step by step as well,")
@click.option("--show", is_flag=True, help="The arm step by step in the browser.")
@force_option
@quiet_option
@json_option
def diagnose(
    campaign: Path,
    out: Path,
    source: str | None,
    robot: str | None,
    hold_out: tuple[str, ...],
    effects: str | None,
    trust: tuple[str, ...],
    seed: int,
    within: float | None,
    workers: int | None,
    page: Path | None,
    show: bool,
    force: bool,
    quiet: bool,
    as_json: bool,
) -> None:
    """What is missing in the robot's model, by its measurements; exit 1 if nothing known explains them.

    Writes OUT/diagnosis.json, OUT/report.html and OUT/robot, the improved robot, all of them or none.
    """
    from flexmodal.diagnosis import diagnose as find
    from flexmodal.diagnosis.as_json import as_json as as_object
    from flexmodal.diagnosis.write import OWN, write_diagnosis
    from flexmodal.files import refuse_folder

    refuse_folder(out, own=OWN, overwrite=force)
    refuse_page(page, force)
    wanted, trusted = _names(effects), trust_of(trust)
    measured = campaign_at(campaign)
    arm = robot_of(measured, robot)
    say_findings(measured, arm)
    say_doubled(measured, source)
    with stages(quiet=quiet) as advance:
        diagnosis = find(
            measured,
            arm,
            source=source,  # type: ignore[arg-type]  # click has seen to it
            hold_out=hold_out or None,
            effects=wanted,
            trust=trusted,
            seed=seed,
            within=within,
            workers=workers,
            advance=advance,
        )
        advance("writing the report", 0.0)
        write_diagnosis(diagnosis, out, overwrite=force)
    say(f"wrote {out}: report {out / 'report.html'}, robot {out / 'robot' / 'robot.toml'}", err=True)
    if as_json:
        print_json(as_object(diagnosis))
    else:
        _print(diagnosis)
    deliver("show_diagnosis", diagnosis, page=page, show=show, force=force)
    sys.exit(0 if diagnosis.verdict.explained else 1)


def _names(text: str | None) -> list[str] | None:
    return None if text is None else [name.strip() for name in text.split(",") if name.strip()]


def _print(diagnosis: Diagnosis) -> None:
    from flexmodal.report.words import percent, size

    say(diagnosis.verdict.says)
    for step in diagnosis.steps:
        rows = [
            [name, f"{value:.5g}", _error(step.uncertainty.get(name)), step.units.get(name) or "–"]
            for name, value in step.parameters.items()
        ]
        title = f"{step.effect} at {step.where}, confidence {percent(step.confidence)}"
        print_table(title, ["parameter", "value", "±", "unit"], rows)
    gaps = diagnosis.gaps
    cells: list[tuple[str, float | None, float | None]] = [
        ("the card as it came", gaps.believed, None),
        ("re-tuned, nothing added", gaps.before, gaps.held_out_before),
        ("the final model", gaps.after, gaps.held_out_after),
        ("noise of one record" if diagnosis.modal is None else "scatter over places", gaps.noise_floor, None),
    ]
    rows = [[name, size(value), size(held)] for name, value, held in cells]
    print_table("gap between model and measurement", ["", "all", "held out"], rows)
    for name, why in diagnosis.untestable.items():
        say(f"could not be tested: {name}: {why}")


def _error(value: float | None) -> str:
    return "–" if value is None else f"{value:.2g}"
