"""`flexmodal rig`."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from flexmodal.cli.options import (
    SOURCE,
    RobotOptions,
    band_of,
    json_option,
    number,
    quiet_option,
    robot_options,
)
from flexmodal.cli.printing import print_json, print_table, progress, say
from flexmodal.errors import Fault, InvalidInput, InvalidRequest

if TYPE_CHECKING:
    from flexmodal.model import Robot
    from flexmodal.rig import Hide, RigResult
    from flexmodal.rig.plan import HammerPlan
    from flexmodal.text.gather import Gathering


@click.command("rig")
@click.option("--continue", "campaign", required=True, type=click.Path(path_type=Path))
@click.option("--as", "measurement", required=True, type=click.Path(path_type=Path), metavar="NEXT.json")
@click.option("--out", type=click.Path(path_type=Path), help="A new folder; CAMPAIGN_2 or so if not said.")
@click.option("--ascii", "as_text", is_flag=True, help="Universal files in ASCII instead of binary.")
@quiet_option
@json_option
def go_on(
    campaign: Path, measurement: Path, out: Path | None, as_text: bool, quiet: bool, as_json: bool
) -> None:
    """The measurement that a diagnosis asked for, taken on the simulated arm of CAMPAIGN.

    OUT holds the campaign with what is new last; CAMPAIGN stays as it is.
    """
    from flexmodal.rig.asked import read_asked
    from flexmodal.rig.continued import continued
    from flexmodal.rig.result import refuse_existing

    target = _free(campaign) if out is None else out
    refuse_existing(target)
    asked = read_asked(measurement)
    with progress(1, "striking", quiet=quiet) as advance:
        result = continued(campaign, asked)
        advance()
    truth = result.write(target, binary=not as_text)
    if as_json:
        print_json(_json(result, target, truth))
    else:
        _print(result.robot, result, target, truth)


def _free(campaign: Path) -> Path:
    """A name beside a campaign's that nothing has, nor its truth."""
    from flexmodal.rig.truth import truth_path

    plain, number = Path(os.path.abspath(campaign)), 2
    while True:
        found = plain.with_name(f"{plain.name}_{number}")
        if not os.path.lexists(found) and not os.path.lexists(truth_path(found)):
            return found
        number += 1


class _Rig(click.Command):
    """With --continue it is another command, which takes no robot."""

    def make_context(
        self, info_name: str | None, args: list[str], parent: click.Context | None = None, **extra: Any
    ) -> click.Context:
        if any(word.partition("=")[0] == "--continue" for word in args):
            return go_on.make_context(info_name, args, parent, **extra)
        return super().make_context(info_name, args, parent, **extra)


_GO_ON = (
    "flexmodal rig --continue CAMPAIGN --as NEXT.json [--out DIR] takes the measurement that a diagnosis "
    "asked for; NEXT.json is its diagnosis.json."
)


@click.command(cls=_Rig, epilog=_GO_ON)
@robot_options
@click.option("--out", required=True, type=click.Path(path_type=Path), help="A new folder for the campaign.")
@click.option(
    "--hide",
    multiple=True,
    metavar="EFFECT[:FORM][@WHERE][,NAME=VALUE…]",
    help="An effect to hide; may be repeated. Where and how strong is drawn unless said.",
)
@click.option("--height", metavar="X", help="Each hidden effect X times the noise floor; LOW:HIGH draws it.")
@click.option("--postures", type=int, default=7, show_default=True, help="The card's own, then random.")
@click.option("--points", type=int, help="Points with a sensor; all of the card's if not said.")
@click.option(
    "--references",
    metavar="N|NAME:±AXIS,…",
    help="Hammer positions; 2 if not said, or 1 where one point is measured one way.",
)
@click.option("--axes", metavar="XYZ", help="Directions the sensor measures, such as xz.")
@click.option(
    "--frame",
    default="world",
    show_default=True,
    metavar="world|link",
    help="Whose axes those of sensor and hammer are: the world's, or of the link they sit on.",
)
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
@click.option("--no-time", is_flag=True, help="FRFs alone, no time records.")
@click.option("--workers", type=int, default=1, show_default=True, help="Postures struck side by side.")
@click.option("--ascii", "as_text", is_flag=True, help="Universal files in ASCII instead of binary.")
@quiet_option
@json_option
def rig(
    robot: RobotOptions,
    out: Path,
    no_time: bool,
    as_text: bool,
    quiet: bool,
    as_json: bool,
    **asked: Any,
) -> None:
    """A simulated hammer test; the truth goes to OUT.truth.toml, beside the folder, not in it."""
    from flexmodal.rig import simulate
    from flexmodal.rig.plan import default_axes
    from flexmodal.rig.request import prepare
    from flexmodal.rig.result import refuse_existing
    from flexmodal.text.gather import Gathering

    gathering = Gathering()
    with gathering.step():
        refuse_existing(out)
    request = _read(gathering, **asked)
    with gathering.step():
        arm = robot.load()
        with _as_options():
            if request.get("references", 2) is None:
                alone = request["points"] == 1 and len(request["axes"] or default_axes(arm)) == 1
                request["references"] = 1 if alone else 2
            prepare(arm, **request)
    gathering.done()
    total = request["postures"] * (request["points"] or len(arm.points) or len(arm.joints))
    with progress(max(total, 1), "striking", quiet=quiet) as advance, _as_options():
        result = simulate(arm, time=not no_time, advance=advance, **request)
    truth = result.write(out, binary=not as_text)
    if as_json:
        print_json(_json(result, out, truth))
    else:
        _print(arm, result, out, truth)


def _read(
    gathering: Gathering,
    hide: tuple[str, ...],
    height: str | None,
    references: str | None,
    peaks: str,
    band: str,
    **numbers: Any,
) -> dict[str, Any]:
    """What `simulate` takes, from the options that are texts; one that cannot be read is left out."""
    request = dict(numbers)
    with gathering.step():
        request["references"] = None if references is None else _references(references)
    with gathering.step():
        request["peaks"] = [number(part, "--peaks", "forces in N") for part in peaks.split(",")]
    with gathering.step():
        request["band"] = band_of(band)
    high = None
    with gathering.step():
        high = _height(height)
    request["hide"] = []
    for text in hide:
        with gathering.step():
            request["hide"].append(_hidden(text, high))
    return request


@contextmanager
def _as_options() -> Iterator[None]:
    """Faults of arguments become faults of the options that gave them."""
    try:
        yield
    except InvalidInput as error:
        raise type(error)(_as_option(fault) for fault in error.faults) from None


def _as_option(fault: Fault) -> Fault:
    if fault.file != "call":
        return fault
    name, *rest = fault.key.split(" ")
    return replace(fault, file=SOURCE, key=" ".join([f"--{name.replace('_', '-')}", *rest]))


def _hidden(text: str, height: float | tuple[float, float] | None) -> Hide:
    from flexmodal.rig import Hide

    return replace(Hide.parse(text, source=f"{SOURCE} --hide"), height=height)


def _height(text: str | None) -> float | tuple[float, float] | None:
    if text is None:
        return None
    parts = [number(part, "--height", "X or LOW:HIGH, times the noise floor") for part in text.split(":")]
    if len(parts) > 2:
        raise InvalidRequest(Fault(SOURCE, "--height", repr(text), "X or LOW:HIGH, times the noise floor"))
    return parts[0] if len(parts) == 1 else (parts[0], parts[1])


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
        "blows": _blows(plan),
        "frfs": 0 if campaign.frfs is None else len(campaign.frfs),
        "band": list(plan.band),
        "seed": result.truth.seed,
    }


def _blows(plan: HammerPlan) -> int:
    averages = sum(trial.averages for trial in plan.trials)
    return len(plan.postures) * len(plan.points) * len(plan.references) * averages


def _print(arm: Robot, result: RigResult, out: Path, truth: Path) -> None:
    from flexmodal.campaign import named_direction

    plan, campaign = result.plan, result.campaign
    names = {point.id: point.name for point in plan.points}
    hammer = ", ".join(str(named_direction(place, names)) for place in plan.references)
    count = 0 if campaign.frfs is None else len(campaign.frfs)
    print_table(
        f"{arm.name}: simulated hammer test",
        ["", "value"],
        [
            ["postures", str(len(plan.postures))],
            ["points", ", ".join(names.values())],
            ["hammer at", hammer],
            ["trials", ", ".join(f"{trial.force_peak:g} N" for trial in plan.trials)],
            ["blows", str(_blows(plan))],
            ["FRFs", str(count)],
            ["hidden effects", str(len(result.truth.effects))],
        ],
    )
    say(f"campaign in {out}, what is hidden in it in {truth}")
