"""`flexmodal path`."""

from __future__ import annotations

import csv
import sys
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from flexmodal.cli.clearing import clearance_json, clearance_of, clearance_options, say_clearance
from flexmodal.cli.holds import at, orientation_options
from flexmodal.cli.options import (
    SOURCE,
    RobotOptions,
    force_option,
    hertz,
    json_option,
    number,
    per_joint,
    quiet_option,
    refuse_existing,
    robot_options,
)
from flexmodal.cli.printing import degrees, noted_progress, print_json, print_table, say
from flexmodal.cli.sources import no_source
from flexmodal.errors import Fault, InvalidRequest

if TYPE_CHECKING:
    import numpy as np

    from flexmodal.model import Robot
    from flexmodal.optimisation.path import PathOutcome, PathProblem, Toolpath

_ENDINGS = (".csv", ".png", ".svg")


@click.command()
@robot_options
@no_source
@click.option("--toolpath", type=click.Path(path_type=Path), help="CSV: x,z or x,y,z; fx,fy,fz; time [s].")
@click.option("--line", metavar="X,Z:X,Z", help="From one place to another [m].")
@click.option("--arc", metavar="X,Z:X,Z:X,Z", help="From the first through the second to the third [m].")
@click.option("--points", type=int, default=20, show_default=True, help="Along a line or an arc.")
@click.option("--feed", metavar="M/S", help="Speed of the tool along the path.")
@click.option("--push", metavar="X,Y,Z", help="Direction of the cutting force; 0,0,1 if none.")
@click.option("--frequency", callback=hertz, required=True, metavar="HZ", help="Of the force.")
@click.option("--way", type=click.Choice(["sum", "worst"]), default="sum", show_default=True)
@orientation_options
@clearance_options
@click.option("--speed", metavar="VALUE", help="Of the joints [rad/s, m/s]: one number or joint=number,…")
@click.option(
    "--stride",
    metavar="VALUE",
    default="0.2",
    show_default=True,
    help="Of a joint from point to point [rad, m].",
)
@click.option("--nodes", type=click.IntRange(1, 2000), default=60, show_default=True)
@click.option("--seed", type=click.IntRange(min=0), default=0, show_default=True)
@click.option(
    "--compare", is_flag=True, help="Beside it the greedy sequence and the statically stiffest one."
)
@click.option("--out", type=click.Path(path_type=Path), help="A .csv, .png or .svg file.")
@force_option
@quiet_option
@json_option
def path(
    robot: RobotOptions,
    toolpath: Path | None,
    line: str | None,
    arc: str | None,
    points: int,
    feed: str | None,
    push: str | None,
    frequency: float,
    way: str,
    orientation: str | None,
    axis: str | None,
    tool_axis: str,
    clearance: str | None,
    no_collisions: bool,
    speed: str | None,
    stride: str,
    nodes: int,
    seed: int,
    compare: bool,
    out: Path | None,
    force: bool,
    quiet: bool,
    as_json: bool,
) -> None:
    """A posture for each point of a toolpath: smooth, within limits and speeds, vibrating least."""
    from flexmodal.frf import frequency_axis
    from flexmodal.optimisation.path import PathProblem

    refuse_existing(out, force, _ENDINGS)
    arm = robot.load()
    problem = partial(
        PathProblem.along,
        arm,
        _toolpath(arm, toolpath, line, arc, points, feed),
        force=None if push is None else _three(push, "--push"),
        hold=lambda place: at(arm, place, orientation, axis, tool_axis),
        way=way,
        speed=_speeds(arm, speed),
        stride=number(stride, "--stride", "a step in rad or m"),
        clearance=clearance_of(arm, clearance, no_collisions),
    )
    judged = problem(float(frequency_axis([frequency], source=f"{SOURCE} --frequency")[0]))
    planned = _planned(judged, nodes, seed, quiet)
    found = {"least vibration": planned}
    if compare and not planned.interrupted:
        found |= _others(judged, problem(0.0), nodes, seed)
    if out is not None:
        _write(found, out, force)
        say(f"wrote {out}", err=True)
    if as_json:
        print_json(_json(found))
    else:
        _print(arm, found)
    if planned.interrupted:
        say("flexmodal: interrupted; the best sequence so far is kept", err=True)
        sys.exit(130)


def _planned(judged: PathProblem, nodes: int, seed: int, quiet: bool) -> PathOutcome:
    """The sequence that vibrates least, with a bar that tells the best so far."""
    from flexmodal.optimisation.path import plan_path

    unit = judged.points[0].objective.unit
    with noted_progress(len(judged.points) + 60, "planning", quiet=quiet) as (advance, note):
        return plan_path(
            judged,
            nodes=nodes,
            seed=seed,
            advance=advance,
            improved=lambda value: note(f"best {value:.4g} {unit}"),
        )


def _others(judged: PathProblem, static: PathProblem, nodes: int, seed: int) -> dict[str, PathOutcome]:
    """What to compare with, under the same judgement; what does not exist is said and left out."""
    from flexmodal.errors import Unreachable
    from flexmodal.optimisation.path import greedy_path, plan_path

    found: dict[str, PathOutcome] = {}
    for name in ("greedy", "static stiffness"):
        try:
            if name == "greedy":
                found[name] = greedy_path(judged, seed=seed)
            else:
                found[name] = plan_path(static, nodes=nodes, seed=seed).judged_by(judged)
        except Unreachable as error:
            say(f"note: {name}: {error}", err=True)
    return found


def _toolpath(
    arm: Robot, file: Path | None, straight: str | None, round_: str | None, points: int, feed: str | None
) -> Toolpath:
    from flexmodal.optimisation.path import arc, line, read_toolpath

    given = {"--toolpath": file, "--line": straight, "--arc": round_}
    named = [name for name, value in given.items() if value is not None]
    if len(named) != 1:
        allowed = "exactly one of --toolpath FILE, --line FROM:TO and --arc FROM:VIA:TO"
        raise InvalidRequest(Fault(SOURCE, "", " and ".join(named) or "none of them", allowed))
    pace = None if feed is None else number(feed, "--feed", "a speed in m/s")
    if file is not None:
        return read_toolpath(file, planar=arm.is_planar, feed=pace)
    if pace is None:
        raise InvalidRequest(Fault(SOURCE, "--feed", "none", "the speed of the tool [m/s]"))
    option, text, count = ("--line", straight, 2) if straight is not None else ("--arc", round_, 3)
    places = [_place(part, option) for part in (text or "").split(":")]
    if len(places) != count:
        found = f"{len(places)} places"
        raise InvalidRequest(Fault(SOURCE, option, found, f"{count} places with : between them"))
    if count == 2:
        return line(places[0], places[1], points, pace)
    return arc(places[0], places[1], places[2], points, pace)


def _place(text: str, option: str) -> tuple[float, ...]:
    return tuple(number(part, option, "coordinates X,Z or X,Y,Z [m]") for part in text.split(","))


def _three(text: str, option: str) -> tuple[float, float, float]:
    values = _place(text, option)
    if len(values) != 3 or not any(values):
        raise InvalidRequest(Fault(SOURCE, option, repr(text), "three components, not all 0"))
    return values[0], values[1], values[2]


def _speeds(arm: Robot, text: str | None) -> np.ndarray | None:
    """Most that each joint may do; those not named keep the URDF's velocity."""
    import numpy as np

    given = per_joint(text, "--speed")
    if given is None:
        return None
    if isinstance(given, float):
        return np.full(len(arm.commanded), given)
    strange = [name for name in given if name not in arm.commanded]
    if strange:
        raise InvalidRequest(Fault(SOURCE, "--speed", ", ".join(strange), ", ".join(arm.commanded)))
    return np.array(
        [given.get(name, joint.velocity or float("inf")) for name, joint in arm.commanded.items()]
    )


def _json(found: dict[str, PathOutcome]) -> dict[str, Any]:
    best, *others = found.items()
    return _summary(best[1]) | {
        "points": [
            {
                "time": point.time,
                "tool": best[1].problem.at[place].posed(values).position(best[1].problem.robot.tool).tolist(),
                "posture": dict(best[1].posture(place).values),
                "value": float(best[1].values[place]),
            }
            for place, (point, values) in enumerate(
                zip(best[1].problem.points, best[1].postures, strict=True)
            )
        ],
        "collisions": clearance_json(best[1].problem.clearance, best[1].nearest),
        "compare": {name: _summary(outcome) for name, outcome in others},
    }


def _summary(outcome: PathOutcome) -> dict[str, Any]:
    return {
        "unit": outcome.problem.points[0].objective.unit,
        "sum": outcome.total,
        "worst": outcome.worst,
        "fastest": outcome.fastest,
        "deviation": outcome.deviation,
    }


def _print(arm: Robot, found: dict[str, PathOutcome]) -> None:
    best = next(iter(found.values()))
    unit = best.problem.points[0].objective.unit
    rows = []
    for place, point in enumerate(best.problem.points):
        angles = [
            degrees(value, prismatic=arm.commanded[name].is_prismatic)
            for name, value in best.posture(place).values.items()
        ]
        rows.append([f"{point.time:.3g}", f"{best.values[place]:.4g}", *angles])
    print_table(f"{arm.name}: a posture for each point", ["time [s]", f"[{unit}]", *arm.commanded], rows)
    rows = [
        [name, f"{one.total:.4g}", f"{one.worst:.4g}", f"{100 * one.fastest:.1f} %", f"{one.deviation:.2g}"]
        for name, one in found.items()
    ]
    print_table(
        "",
        ["sequence", f"sum [{unit}]", f"worst [{unit}]", "of the joint speeds", "between points [m]"],
        rows,
    )

    say_clearance(best.problem.clearance, best.nearest)


def _write(found: dict[str, PathOutcome], out: Path, overwrite: bool) -> None:
    from flexmodal.files import whole_file
    from flexmodal.optimisation.path.plot import draw_path
    from flexmodal.report import write_figure

    if out.suffix.lower() != ".csv":
        write_figure(draw_path(found), out, overwrite=overwrite)
        return
    best = next(iter(found.values()))
    robot = best.problem.robot
    with whole_file(out, overwrite=overwrite) as scratch, scratch.open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(["time", "x", "y", "z", "value", *robot.commanded])
        for point, at_, values, value in zip(
            best.problem.points, best.problem.at, best.postures, best.values, strict=True
        ):
            place = at_.posed(values).position(robot.tool)
            writer.writerow(map(repr, map(float, (point.time, *place, value, *values))))
