"""`flexmodal lobes`."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click

from flexmodal.cli.holds import hold_of, orientation_options
from flexmodal.cli.options import (
    SOURCE,
    RobotOptions,
    force_option,
    json_option,
    posture_of,
    quiet_option,
    refuse_existing,
    robot_options,
)
from flexmodal.cli.predicted_lobes import lobes_of_file, lobes_there, say_standing, tips_of
from flexmodal.cli.printing import busy, noted_progress, print_json, print_table, progress, say
from flexmodal.cli.sources import Sourcing, source_options
from flexmodal.errors import Fault, InvalidRequest

if TYPE_CHECKING:
    from flexmodal.machining import Comparison, Cut, MeasuredTip
    from flexmodal.machining.depth import PostureDepth
    from flexmodal.model import Posture, Robot
    from flexmodal.optimisation import Hold
    from flexmodal.prediction import PredictedTips

_ENDINGS = (".csv", ".json", ".png", ".svg", ".html")
_LISTED = 10
"""Most postures that a search lists."""

_METHODS = ("zero-order", "multi-frequency", "semi-discretisation")


@click.command()
@robot_options
@click.option(
    "--posture", "postures", multiple=True, metavar="POSTURE",
    help="A named posture, or q1=50deg,q2=-0.8; several are compared.",
)  # fmt: skip
@click.option(
    "--prediction", type=click.Path(path_type=Path), metavar="FILE.json",
    help="In place of a posture: the FRFs that flexmodal predict wrote of one that nobody struck.",
)  # fmt: skip
@click.option("--family", metavar="NAME", help="Compare the members of a family of the card.")
@click.option("--members", type=int, default=21, show_default=True, help="Of the family.")
@click.option(
    "--hold", metavar="X,Z|X,Y,Z", help="Search the posture that cuts deepest, the tool held there [m]."
)
@orientation_options
@source_options
@click.option("--starts", type=click.IntRange(1, 1000), default=6, show_default=True, help="With --hold.")
@click.option("--seed", type=click.IntRange(min=0), default=0, show_default=True, help="Of the starts.")
@click.option(
    "--cut", "cut_file", required=True, type=click.Path(path_type=Path), metavar="FILE.toml|NAME",
    help="Cutter, forces, engagement, frame (see docs/machining.md), or a cut that ships: aluminium.",
)  # fmt: skip
@click.option(
    "--spindle", type=click.Path(path_type=Path), metavar="FILE.csv",
    help="Measured receptance of tool and spindle at the tip, added to the arm's.",
)  # fmt: skip
@click.option("--method", type=click.Choice(_METHODS), default="zero-order", show_default=True)
@click.option("--speeds", type=int, help="How many spindle speeds are looked at.")
@click.option("--out", type=click.Path(path_type=Path), help="A .csv, .json, .png, .svg or .html file.")
@force_option
@quiet_option
@json_option
def lobes(
    robot: RobotOptions,
    sourcing: Sourcing,
    postures: tuple[str, ...],
    prediction: Path | None,
    family: str | None,
    members: int,
    hold: str | None,
    orientation: str | None,
    axis: str | None,
    tool_axis: str,
    starts: int,
    seed: int,
    cut_file: Path,
    spindle: Path | None,
    method: str,
    speeds: int | None,
    out: Path | None,
    force: bool,
    quiet: bool,
    as_json: bool,
) -> None:
    """Stability lobes of a milling cut in a posture, or postures compared by depth of cut."""
    from flexmodal.machining import read_cut, read_measured_tip

    _one_way(postures, prediction, family, hold, sourcing)
    refuse_existing(out, force, _ENDINGS)
    arm = robot.load()
    cut = read_cut(cut_file)
    added = None if spindle is None else read_measured_tip(spindle)
    _mention(cut, added)
    held = hold_of(arm, hold, orientation, axis, tool_axis)
    several = len(postures) != 1 and prediction is None
    if several and method != "zero-order":
        raise InvalidRequest(Fault(SOURCE, "--method", f"{method} of several postures", "zero-order"))
    if prediction is not None:
        found = lobes_of_file(arm, prediction, cut, added, method, speeds, quiet)
        _give_one(arm, found, out, force, as_json)
        return
    where = [posture_of(arm, posture) for posture in postures]
    tips = tips_of(sourcing, arm, method, quiet=quiet)
    if not several:
        one = _single(arm, where[0], cut, added, method, speeds, quiet, tips)
        _give_one(arm, one, out, force, as_json)
        return
    if held is not None:
        where = _searched(arm, held, cut, added, starts, seed, quiet, tips)
    compared = _several(arm, where, family, members, cut, added, speeds, quiet, tips)
    if tips is not None:
        say_standing(arm, compared.postures[compared.best].posture, cut, added, tips)
    _give_several(compared, out, force, as_json)


def _one_way(
    postures: tuple[str, ...],
    prediction: Path | None,
    family: str | None,
    hold: str | None,
    sourcing: Sourcing,
) -> None:
    others = {"--prediction": prediction, "--family": family, "--hold": hold}
    given = ["--posture"] * bool(postures) + [name for name, value in others.items() if value is not None]
    if len(given) != 1:
        found = " and ".join(given) or "none of them"
        allowed = "exactly one of --posture, --prediction, --family and --hold"
        raise InvalidRequest(Fault(SOURCE, "", found, allowed))
    if prediction is not None and sourcing.campaign is not None:
        raise InvalidRequest(Fault(SOURCE, "--prediction", "given with --campaign", "one of the two"))


def _mention(cut: Cut, added: MeasuredTip | None) -> None:
    """What is assumed of a measured receptance, and what is counted twice."""
    if added is not None and added.lines[0] > 0:
        first, last = added.lines[0], added.lines[-1]
        say(
            f"note: chatter is sought between {first:g} and {last:g} Hz, the lines of --spindle; below them "
            "its real part is held",
            err=True,
        )
    if added is not None and cut.modes:
        say("note: the modes of the cut and --spindle are both added to the arm", err=True)


def _single(
    arm: Robot,
    where: Posture,
    cut: Cut,
    added: MeasuredTip | None,
    method: str,
    speeds: int | None,
    quiet: bool,
    tips: PredictedTips | None,
) -> PostureDepth:
    from flexmodal.machining import lobes as find
    from flexmodal.machining.stability.solve import SPEEDS

    if tips is not None:
        return lobes_there(arm, where, cut, added, method, speeds, quiet, tips)
    if method == "zero-order":  # its speeds come all at once
        with busy("lobes", quiet=quiet):
            return find(arm, where, cut, method=method, speeds=speeds, added=added)
    with progress(speeds or SPEEDS[method], "speeds", quiet=quiet) as advance:
        return find(arm, where, cut, method=method, speeds=speeds, added=added, advance=advance)


def _searched(
    arm: Robot,
    held: Hold,
    cut: Cut,
    added: MeasuredTip | None,
    starts: int,
    seed: int,
    quiet: bool,
    tips: PredictedTips | None,
) -> list[Posture]:
    """The best postures that a search by the depth of cut ends in."""
    from flexmodal.machining import depth_over
    from flexmodal.optimisation import FunctionObjective, PostureProblem, optimise

    judge = FunctionObjective(depth_over(cut, added=added, tips=tips), "m", larger_is_better=True)
    with noted_progress(starts, "searching", quiet=quiet) as (advance, note):
        found = optimise(
            PostureProblem(arm, judge, held),
            starts=starts,
            seed=seed,
            advance=advance,
            improved=lambda value: note(f"best {1e3 * value:.4g} mm"),
        )
    if found.interrupted:
        say(f"note: {found.verdict}", err=True)
    return [optimum.posture for optimum in found.optima[:_LISTED]]


def _several(
    arm: Robot,
    poses: Sequence[Posture],
    family: str | None,
    members: int,
    cut: Cut,
    added: MeasuredTip | None,
    speeds: int | None,
    quiet: bool,
    tips: PredictedTips | None,
) -> Comparison:
    from flexmodal.machining import compare_family, compare_postures
    from flexmodal.machining.depth import SPEEDS

    count = SPEEDS if speeds is None else speeds

    if family is not None:
        arm.family(family, source=f"{SOURCE} --family")
        with progress(members, "postures", quiet=quiet) as advance:
            return compare_family(
                arm, family, cut, members=members, speeds=count, added=added, tips=tips, advance=advance
            )
    with progress(len(poses), "postures", quiet=quiet) as advance:
        return compare_postures(arm, poses, cut, speeds=count, added=added, tips=tips, advance=advance)


def _give_one(arm: Robot, one: PostureDepth, out: Path | None, force: bool, as_json: bool) -> None:
    from flexmodal.machining import report
    from flexmodal.report import write_figure, write_json

    found = report.lobes_object(arm.name, one)
    if out is not None:
        ending = out.suffix.lower()
        if ending == ".csv":
            report.write_lobes_csv(one, out, overwrite=force)
        elif ending == ".json":
            write_json(found, out, overwrite=force)
        elif ending == ".html":
            report.write_lobes_page(arm.name, one, out, overwrite=force)
        else:
            write_figure(report.lobes_picture(arm.name, one), out, overwrite=force)
        say(f"wrote {out}", err=True)
    if as_json:
        print_json(found)
    elif out is None:
        title = f"{arm.name} at {one.posture}: {one.lobes.cut.title} ({one.lobes.method})"
        print_table(title, report.NUMBERS, report.numbers(one))
        print_table("The deepest speeds of the range", report.BEST, report.best_rows(one))


def _give_several(several: Comparison, out: Path | None, force: bool, as_json: bool) -> None:
    from flexmodal.machining import report
    from flexmodal.machining.plot import draw_comparison
    from flexmodal.report import write_figure, write_json

    found = report.comparison_object(several)
    if out is not None:
        ending = out.suffix.lower()
        if ending == ".csv":
            report.write_comparison_csv(several, out, overwrite=force)
        elif ending == ".json":
            write_json(found, out, overwrite=force)
        elif ending == ".html":
            report.write_comparison_page(several, out, overwrite=force)
        else:
            write_figure(draw_comparison(several), out, overwrite=force)
        say(f"wrote {out}", err=True)
    if as_json:
        print_json(found)
    elif out is None:
        print_table(
            f"{several.robot.name}: {several.cut.title}", report.POSTURES, report.posture_rows(several)
        )
        best = report.posture_rows(several)[several.best][0]
        say(f"best by critical depth: {best}, {several.gain:.3g} times the worst")
