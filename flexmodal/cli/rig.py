"""`flexmodal rig`."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from flexmodal.cli.options import (
    SOURCE,
    band_of,
    json_option,
    load_robot,
    number,
    quiet_option,
    robot_options,
)
from flexmodal.cli.printing import print_json, print_table, progress
from flexmodal.errors import Fault, InvalidRequest

if TYPE_CHECKING:
    from flexmodal.model import Robot
    from flexmodal.rig import Hide, RigResult


@click.command()
@robot_options
@click.option("--out", required=True, type=click.Path(path_type=Path), help="A new folder for the campaign.")
@click.option(
    "--hide",
    multiple=True,
    metavar="EFFECT[@WHERE][,NAME=VALUE…]",
    help="An effect to hide; may be repeated. Where and how strong is drawn unless said.",
)
@click.option("--height", type=float, metavar="X", help="Each hidden effect X times the noise floor.")
@click.option("--postures", type=int, default=7, show_default=True, help="The card's own, then random.")
@click.option("--points", type=int, help="Points with a sensor; all of the card's if not said.")
@click.option(
    "--references", default="2", show_default=True, metavar="N|NAME:±AXIS,…", help="Hammer positions."
)
@click.option("--axes", metavar="XYZ", help="World directions the sensor measures, such as xz.")
@click.option("--trials", type=int, default=4, show_default=True, help="Through --peaks, then repeats.")
@click.option("--averages", type=int, default=3, show_default=True, help="Blows in each FRF.")
@click.option("--peaks", default="60,240", show_default=True, metavar="N,…", help="Peaks of the blows [N].")
@click.option("--tip", default="soft", show_default=True, help="Of the hammer: soft, medium or hard.")
@click.option("--band", default="2:200", show_default=True, metavar="LOW:HIGH", help="Of interest [Hz].")
@click.option("--record-length", type=float, default=4.0, show_default=True, help="Of each record [s].")
@click.option("--noise", type=float, default=0.01, show_default=True, help="Over the RMS of a record.")
@click.option("--scatter", type=float, default=1.0, show_default=True, help="Of the blows; 0 strikes alike.")
@click.option(
    "--parameter-error",
    type=float,
    default=0.05,
    show_default=True,
    help="Card off the robot, relative.",
)
@click.option("--seed", type=click.IntRange(min=0), default=0, show_default=True, help="Of everything drawn.")
@click.option("--ascii", "as_text", is_flag=True, help="Universal files in ASCII instead of binary.")
@quiet_option
@json_option
def rig(
    robot: str,
    stiffness: str | None,
    damping: str | None,
    tool: str | None,
    fix: str | None,
    out: Path,
    hide: tuple[str, ...],
    height: float | None,
    references: str,
    peaks: str,
    band: str,
    as_text: bool,
    quiet: bool,
    as_json: bool,
    **numbers: Any,
) -> None:
    """A simulated hammer test; the truth goes to OUT.truth.toml, beside the folder, not in it."""
    from flexmodal.rig import simulate
    from flexmodal.rig.simulate import refuse_existing

    refuse_existing(out)
    arm = load_robot(robot, stiffness, damping, tool, fix)
    total = numbers["postures"] * (numbers["points"] or len(arm.points) or len(arm.joints))
    with progress(max(total, 1), "striking", quiet=quiet) as advance:
        result = simulate(
            arm,
            hide=_hidden(hide, height),
            references=_references(references),
            peaks=tuple(number(part, "--peaks", "forces in N") for part in peaks.split(",")),
            band=band_of(band),
            advance=advance,
            **numbers,
        )
    truth = result.write(out, binary=not as_text)
    if as_json:
        print_json(_json(result, out, truth))
    else:
        _print(arm, result, out, truth)


def _hidden(texts: tuple[str, ...], height: float | None) -> list[Hide]:
    from dataclasses import replace

    from flexmodal.rig import Hide

    return [replace(Hide.parse(text, source=f"{SOURCE} --hide"), height=height) for text in texts]


def _references(text: str) -> int | list[str]:
    if ":" in text:
        return [part.strip() for part in text.split(",")]
    try:
        return int(text)
    except ValueError:
        allowed = "a number, or hammer positions such as tip:+z,elbow:-x"
        raise InvalidRequest(Fault(SOURCE, "--references", repr(text), allowed)) from None


def _json(result: RigResult, out: Path, truth: Path) -> dict[str, Any]:
    plan, campaign = result.plan, result.campaign
    return {
        "campaign": str(out),
        "truth": str(truth),
        "robot": result.robot.name,
        "postures": len(plan.postures),
        "points": [point.name for point in plan.points],
        "references": [list(reference) for reference in plan.references],
        "trials": len(plan.trials),
        "blows": len(campaign.blows),
        "frfs": 0 if campaign.frfs is None else len(campaign.frfs),
        "band": list(plan.band),
        "seed": result.truth.seed,
    }


def _print(arm: Robot, result: RigResult, out: Path, truth: Path) -> None:
    plan, campaign = result.plan, result.campaign
    names = {point.id: point.name for point in plan.points}
    hammer = ", ".join(f"{names[p]}:{'+' if d > 0 else '-'}{'xyz'[abs(d) - 1]}" for p, d in plan.references)
    count = 0 if campaign.frfs is None else len(campaign.frfs)
    print_table(
        f"{arm.name}: simulated hammer test",
        ["", "value"],
        [
            ["postures", str(len(plan.postures))],
            ["points", ", ".join(names.values())],
            ["hammer at", hammer],
            ["trials", ", ".join(f"{trial.force_peak:g} N" for trial in plan.trials)],
            ["blows", str(len(campaign.blows))],
            ["FRFs", str(count)],
            ["hidden effects", str(len(result.truth.effects))],
        ],
    )
    click.echo(f"campaign in {out}, what is hidden in it in {truth}")
