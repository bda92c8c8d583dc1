"""What a posture search found: the start, the optimum, the target and the force, in one picture."""

from __future__ import annotations

import numpy as np

from flexmodal.frf import PointDirection
from flexmodal.model import PosedRobot, Posture
from flexmodal.optimisation import (
    MobilityObjective,
    Objective,
    Outcome,
    ReceptanceObjective,
    RobustObjective,
    SeparationObjective,
    StiffnessObjective,
    TunedObjective,
)
from flexmodal_viewer import marks
from flexmodal_viewer.arm import Arm
from flexmodal_viewer.motion import Deflection, forced
from flexmodal_viewer.obstacles import LEGEND as OBSTACLES
from flexmodal_viewer.obstacles import obstacles
from flexmodal_viewer.palette import BASE, FORCE, OPTIMISED, START, TARGET, shade
from flexmodal_viewer.scene import Caption, Item, Label, Matrix, Motion, Scene, Swatch, Table
from flexmodal_viewer.stage import set_stage, view_of
from flexmodal_viewer.units import joint_value, plain, quantity

CLEAR = 0.42
"""Opacity of the start posture."""

_NAMES = {
    StiffnessObjective: "Stiffness",
    MobilityObjective: "Mobility",
    ReceptanceObjective: "Receptance |α|",
    TunedObjective: "Receptance |α|",
    SeparationObjective: "Distance from the poles",
}
_SIZES = {"weighted": "|tᵀαw|", "force": "‖αw‖", "worst": "‖α‖"}
"""As `ReceptanceObjective.combine` has them."""


def outcome_scene(outcome: Outcome, *, start: Posture | None) -> Scene:
    """Draw the optimised posture solid, over the start posture where there is one.

    Args:
        outcome: of a search.
        start: the posture to compare with, if any.
    """
    robot = outcome.problem.robot
    arm = Arm(robot)
    best = robot.at(outcome.best.posture)
    before = None if start is None else robot.at(start)
    nodes: dict[str, Matrix] = arm.nodes("optimised", best.posture.values)
    items: list[Item] = arm.items("optimised", lambda own: shade(OPTIMISED, own), skip=arm.still_links())
    items += arm.items(
        "optimised", lambda own: shade(BASE, own), skip=frozenset(arm.index) - arm.still_links()
    )
    labels: list[Label] = []
    legend = [Swatch("optimised posture", OPTIMISED)]
    if before is not None:
        nodes |= arm.nodes("start", before.posture.values)
        clear = arm.items("start", lambda own: shade(START, own), opacity=CLEAR, skip=arm.still_links())
        items += clear
        legend.insert(0, Swatch("start posture", START, "clear"))
    around, hidden = obstacles(arm, "optimised")
    drawn, swatches = _judged(outcome, arm, best)
    legend += [*swatches, *([OBSTACLES] if around.items else [])]
    for part in (*drawn, around):
        nodes |= part.nodes
        items += part.items
        labels += part.labels
    motion = _vibration(outcome, arm, best, before)
    caption = Caption(
        robot.title or robot.name,
        "Posture that vibrates least" if _is_receptance(outcome) else "Optimised posture",
        tuple(legend),
        _tables(outcome, before),
        (f"Search: {outcome.verdict}.", *arm.looks.notes, *hidden),
    )
    return set_stage(
        Scene(
            caption,
            view_of(robot, best.position(robot.tool)),
            nodes,
            tuple(items),
            tuple(labels),
            () if motion is None else (motion,),
            rest="Postures" if motion is not None else "",
        )
    )


def _judged(outcome: Outcome, arm: Arm, best: PosedRobot) -> tuple[list[marks.Drawn], list[Swatch]]:
    """Arrows along what was judged and a cross where the point is held, with their words."""
    legend = []
    drawn = [
        marks.force(direction, best.position(direction.point), 0.13 * arm.reach, number)
        for number, direction in enumerate(directions_of(outcome))
    ]
    if drawn:
        names = ", ".join(map(str, directions_of(outcome)))
        legend.append(Swatch(f"direction judged: {names}", FORCE, "arrow"))
    held = target_of(outcome, best)
    if held is not None:
        drawn.append(marks.target(held, 0.07 * arm.reach))
        where = ", ".join(plain(round(float(value), 4) + 0.0) for value in held)
        legend.append(Swatch(f"target ({where}) m", TARGET, "cross"))
    return drawn, legend


def judge_of(outcome: Outcome) -> Objective:
    """The objective; of one over a sample of robots, that of each."""
    objective = outcome.problem.objective
    return objective.objective if isinstance(objective, RobustObjective) else objective


def _is_receptance(outcome: Outcome) -> bool:
    return isinstance(judge_of(outcome), ReceptanceObjective | TunedObjective)


def directions_of(outcome: Outcome) -> tuple[PointDirection, ...]:
    """The directions that are judged; none where the objective has none."""
    objective = judge_of(outcome)
    several = getattr(objective, "directions", ())
    return tuple(several) or tuple(filter(None, [getattr(objective, "direction", None)]))


def target_of(outcome: Outcome, best: PosedRobot) -> np.ndarray | None:
    """Where the held point should be; along directions not held, where it is [m].

    Args:
        outcome: of a search.
        best: the robot in the best posture.
    """
    hold = outcome.problem.hold
    if hold is None:
        return None
    position = best.position(hold.point)
    return position + np.linalg.pinv(hold.rows) @ (hold.target - hold.rows @ position)


def _tables(outcome: Outcome, before: PosedRobot | None) -> tuple[Table, ...]:
    robot, best = outcome.problem.robot, outcome.best
    columns = ("joint", "start", "optimised") if before is not None else ("joint", "optimised")
    rows = []
    for name, joint in robot.commanded.items():
        values = [before.posture.values[name]] if before is not None else []
        values.append(best.posture.values[name])
        rows.append((name, *(joint_value(value, slides=joint.is_prismatic) for value in values)))
    return _objective(outcome, before), Table("Postures", columns, tuple(rows))


def _objective(outcome: Outcome, before: PosedRobot | None) -> Table:
    objective, after = outcome.problem.objective, outcome.best.objective
    first = outcome.start
    if first is None and before is not None:
        first = objective.value(before)
    rows = []
    if first is not None:
        known = np.isfinite(first)
        rows.append(("at the start", quantity(first, objective.unit) if known else "infinite"))
    rows.append(("optimised", quantity(after, objective.unit)))
    if first is not None and 0 < first < np.inf and after > 0:
        ratio = max(first / after, after / first)
        rows.append(("change", f"{plain(ratio)} times {'less' if after < first else 'more'}"))
    return Table(heading_of(outcome), (), tuple(rows))


def heading_of(outcome: Outcome) -> str:
    """What was minimised or made large, where and at which frequencies."""
    objective, along = judge_of(outcome), " and ".join(map(str, directions_of(outcome)))
    text = _NAMES.get(type(objective), "Objective")
    if isinstance(objective, ReceptanceObjective) and len(objective.directions) > 1:
        text = f"Receptance {_SIZES[objective.combine]}"
    if along:
        text += f" at {along}"
    text += _hertz(objective)
    if isinstance(outcome.problem.objective, RobustObjective):
        robust = outcome.problem.objective
        text += f", {robust.judge} of {len(robust.robots)} samples"
    return text


def _hertz(objective: Objective) -> str:
    """The frequencies that are judged, after a comma; nothing where there are none."""
    if isinstance(objective, TunedObjective):
        return f", the best of {plain(objective.band[0])} to {plain(objective.band[1])} Hz"
    given = getattr(objective, "frequency", None)
    if given is None:
        return ""
    lines = np.atleast_1d(np.asarray(given, dtype=float))
    first, last = plain(float(lines[0])), plain(float(lines[-1]))
    return f", {first} Hz" if len(lines) == 1 else f", {first} to {last} Hz"


def _vibration(outcome: Outcome, arm: Arm, best: PosedRobot, before: PosedRobot | None) -> Motion | None:
    """Both postures under the same force, drawn larger by the same factor."""
    objective = judge_of(outcome)
    if isinstance(objective, TunedObjective):
        direction, frequency = objective.direction, objective.frequency_at(best)
    elif isinstance(objective, ReceptanceObjective):
        direction = objective.directions[0]
        frequency = worst_line(objective, best if before is None else before)
    else:
        return None
    moved: dict[str, Deflection] = {"optimised": forced(best, direction, frequency)}
    if before is not None:
        moved["start"] = forced(before, direction, frequency)
    if not any(np.any(deflection.amplitude) for deflection in moved.values()):
        return None
    scale = min(deflection.scale(arm.reach) for deflection in moved.values())
    tracks: dict[str, np.ndarray] = {}
    for group, deflection in moved.items():
        tracks |= dict(deflection.tracks(arm, (group,), scale))
    names = {"start": "at the start", "optimised": "optimised"}
    over = "N·m" if direction.is_rotation else "N"
    rows = [
        (names[group], quantity(moved[group].farthest(), "m") + f" per {over}")
        for group in names
        if group in moved
    ]
    rows.append(("drawn larger by", f"× {plain(scale)}"))
    widest = max(moved.values(), key=lambda deflection: deflection.farthest())
    return Motion(
        f"Vibration at {plain(frequency)} Hz",
        tracks,
        widest.extreme / (2 * np.pi),
        table=Table(f"How far the tool goes under {direction} at {plain(frequency)} Hz", (), tuple(rows)),
        notes=("Both under the same force and drawn larger by the same factor; slowed down.",),
    )


def worst_line(objective: ReceptanceObjective, posed: PosedRobot) -> float:
    """The one frequency of the objective, or of several the one that is answered most [Hz].

    Args:
        objective: of the search.
        posed: the robot in a posture.
    """
    values = np.abs(posed.frf(objective.frequency, response=objective.directions[0]).value[:, 0, 0])
    return float(objective.frequency[int(np.argmax(values))])
