"""`flexmodal demo`: the tour that `make demo` runs."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from flexmodal.cli.options import force_option, quiet_option
from flexmodal.cli.printing import print_table, progress, say

if TYPE_CHECKING:
    from flexmodal.model import Robot

_TARGET = (-2.0, 2.0)
_FREQUENCY = 5.0
_FILES = ("frf_before_after.png", "frf_before_after.svg", "six_link.html", "ur5.html")
_FOUND = "diagnosis"
_UR5 = {"shoulder_lift_joint": -1.2, "elbow_joint": 1.5, "wrist_1_joint": -0.3}
_GUESSED = (2e4, 30.0)
"""Stiffness [N·m/rad] and damping [N·m·s/rad] of each joint of an arm whose maker prints neither."""
_HIDDEN = ("link_flexibility", "link_2")


@click.command()
@click.option(
    "--out",
    type=click.Path(path_type=Path, file_okay=False),
    default=Path("demo"),
    show_default=True,
    help="Folder for the pictures and the page.",
)
@force_option
@quiet_option
def demo(out: Path, force: bool, quiet: bool) -> None:
    """Load three robots, print modes and receptance, better a posture; hide a bending link and find it."""
    from flexmodal.diagnosis.write import OWN
    from flexmodal.files import whole_folder
    from flexmodal.model import load

    out.absolute().parent.mkdir(parents=True, exist_ok=True)
    own = (*_FILES, *(f"{_FOUND}/{name}" for name in OWN))
    with whole_folder(out, own=own, overwrite=force) as scratch:
        fanuc = load("fanuc_s360")
        _modes(fanuc, "configuration_1")
        _receptance(fanuc, "configuration_1", [0.0, 2.0, 7.6, 20.0, 51.0, 94.0])
        arm = load("six_link")
        _modes(arm, "start_2")
        _better_posture(arm, scratch, quiet)
        _bare_urdf(scratch)
        _something_missing(scratch / _FOUND, quiet)
    for name in (*_FILES, f"{_FOUND}/report.html"):
        if not (out / name).exists():
            continue
        say(f"wrote {(out / name).resolve()}")


def _modes(robot: Robot, posture: str) -> None:
    found = robot.modes(posture)
    rows = [
        [str(mode + 1), f"{frequency:.3f}", "overdamped" if real else f"{ratio:.4f}"]
        for mode, (frequency, ratio, real) in enumerate(
            zip(found.frequency, found.damping_ratio, found.overdamped, strict=True)
        )
    ]
    print_table(f"{robot.title}, {posture}: modes", ["mode", "frequency [Hz]", "damping ratio"], rows)


def _receptance(robot: Robot, posture: str, frequencies: list[float]) -> None:
    import numpy as np

    found = robot.frf(posture, frequencies)
    rows = [
        [f"{frequency:g}", f"{abs(value):.4g}", f"{np.degrees(np.angle(value)):.1f}"]
        for frequency, value in zip(found.frequency, found.value[:, 0, 0], strict=True)
    ]
    title = f"{robot.name}, {posture}: receptance of {found.response[0]} per {found.reference[0]}"
    print_table(title, ["frequency [Hz]", f"amplitude [{found.unit()}]", "phase [°]"], rows)


def _better_posture(robot: Robot, out: Path, quiet: bool) -> None:
    import numpy as np

    from flexmodal.cli.viewing import viewer
    from flexmodal.frf import PointDirection, frequency_axis
    from flexmodal.frf.plot import draw_frf
    from flexmodal.optimisation import Hold, PostureProblem, ReceptanceObjective, optimise
    from flexmodal.report import write_figure

    up = PointDirection(robot.tool, "z")
    objective = ReceptanceObjective((up,), frequency_axis([_FREQUENCY]))
    problem = PostureProblem(robot, objective, Hold.at(robot, _TARGET))
    start = robot.posture("start_2")
    starts = 64
    with progress(starts, "searching postures", quiet=quiet) as advance:
        outcome = optimise(problem, start=start, starts=starts, advance=advance)
    printed = objective.value(robot.at("table_3_9_final"))
    brought = problem.retract(problem.vector(start))
    rows = [["start of the thesis (Table 3.9), tool elsewhere", f"{objective.value(robot.at(start)):.4g}"]]
    if brought is not None:
        nearest = objective.value(robot.at(problem.posture(brought)))
        rows.append(["the start, its tool brought to the target", f"{nearest:.4g}"])
    rows += [
        ["final posture of the thesis, in this model", f"{printed:.4g}"],
        ["best posture found here", f"{outcome.best.objective:.4g}"],
    ]
    held = ", ".join(f"{value:g}" for value in _TARGET)
    title = f"{robot.title}: |receptance| of {up} at {_FREQUENCY:g} Hz, end-effector held at ({held}) m"
    print_table(title, ["posture", "[m/N]"], rows)
    say(outcome.verdict)
    lines = frequency_axis(np.geomspace(0.2, 60, 800))
    curves = {
        "before": robot.frf(start, lines),
        "after": robot.frf(outcome.best.posture, lines),
    }
    figure = draw_frf(curves, title=f"{robot.title}, start and best posture", mark=_FREQUENCY)
    for name in _FILES[:2]:
        write_figure(figure, out / name)
    quietly = {"open_browser": False, "announce": lambda text: None}
    viewer("show_outcome")(outcome, start=start, out=out / _FILES[2], **quietly)


def _bare_urdf(out: Path) -> None:
    """An arm that comes as a URDF alone, its stiffness guessed: modes, and a page that shows them move."""
    from flexmodal.cards import example_arms
    from flexmodal.cli.viewing import viewer
    from flexmodal.model import load

    if "ur5" not in example_arms():
        say("\nThe UR5 is left out, it needs the example arms: pip install 'flexmodal[arms]'\n")
        return
    stiffness, damping = _GUESSED
    arm = load("ur5", stiffness=stiffness, damping=damping)
    found = arm.modes(_UR5)
    rows = [
        [str(mode + 1), f"{frequency:.2f}", f"{ratio:.4f}"]
        for mode, (frequency, ratio) in enumerate(zip(found.frequency, found.damping_ratio, strict=True))
    ]
    title = f"UR5, {stiffness:g} N·m/rad guessed for each joint: modes"
    print_table(title, ["mode", "frequency [Hz]", "damping ratio"], rows)
    quietly = {"open_browser": False, "announce": lambda text: None}
    viewer("show_robot")(arm, arm.posture(_UR5), modes=True, out=out / _FILES[3], **quietly)


def _something_missing(out: Path, quiet: bool) -> None:
    """A hammer test on a robot whose second link bends, and a card that does not know: what is missing?"""
    from flexmodal.cli.printing import stages
    from flexmodal.diagnosis import diagnose
    from flexmodal.diagnosis.write import write_diagnosis
    from flexmodal.model import load
    from flexmodal.rig import Hide, simulate

    card = load("fanuc_s360_rigid_link")
    effect, where = _HIDDEN
    hide = [Hide(effect, where, height=10.0)]
    with stages(quiet=quiet) as advance:
        advance("striking", 0.0)
        test = simulate(
            card, hide=hide, postures=4, points=4, references=2, seed=1, record_length=2.0, band=(2.0, 150.0)
        )
        found = diagnose(test.campaign, card, advance=advance)
        write_diagnosis(found, out)
    gaps = found.gaps
    rows = [
        ["hidden in the robot that was struck", f"{effect} at {where}"],
        ["found", " and ".join(f"{name} at {place}" for name, place in found.verdict.effects) or "nothing"],
        ["gap of the card, re-tuned", f"{gaps.before:.4f}"],
        ["gap with what was found", f"{gaps.after:.4f}"],
        ["noise floor", f"{gaps.noise_floor:.4f}"],
    ]
    print_table(f"{card.title}: a simulated hammer test, diagnosed", ["", ""], rows)
    say(found.verdict.says)
