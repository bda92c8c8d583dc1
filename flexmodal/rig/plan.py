"""The test plan: postures, points, hammer references, trials, band and analyser."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from flexmodal.campaign import CampaignPoint, CampaignPosture, Trial
from flexmodal.errors import Fault, InvalidInput, InvalidPosture, InvalidRequest
from flexmodal.frf import PointDirection
from flexmodal.model import Robot
from flexmodal.rig.analyser import RATIO, Analyser
from flexmodal.rig.blow import TIPS
from flexmodal.rig.chain import moved_links, plane_normal, reach

AXES = "xyz"
MOST = 1000
"""The most postures, points, references or trials: beyond, it is a slip of the keyboard."""
MOST_SAMPLES = 2**20
"""In one record."""
_WIDEST = np.radians(150.0)
"""Random postures turn a joint by at most this, even where its limits are wider."""


@dataclass(frozen=True, eq=False)
class Plan:
    """What is struck and measured, where and how often."""

    postures: tuple[CampaignPosture, ...]
    points: tuple[CampaignPoint, ...]
    references: tuple[tuple[int, int], ...]
    """Point id and direction ±1 ±2 ±3 of each hammer position."""
    axes: tuple[int, ...]
    """Directions that the sensor measures: 1, 2, 3 for x, y, z."""
    trials: tuple[Trial, ...]
    band: tuple[float, float]
    """[Hz]"""
    analyser: Analyser

    def point(self, number: int) -> CampaignPoint:
        """The point of that id."""
        return next(point for point in self.points if point.id == number)


def make_plan(
    robot: Robot,
    *,
    postures: int | Sequence[str | Mapping[str, float]],
    points: int | None,
    references: int | Sequence[str],
    axes: str | None,
    trials: int,
    averages: int,
    peaks: Sequence[float],
    tip: str,
    band: tuple[float, float],
    record_length: float,
    random: np.random.Generator,
) -> Plan:
    """Plan a campaign; see `simulate` for the arguments.

    Raises:
        InvalidRequest, InvalidPosture, InvalidPoint: every argument out of its range at once.
    """
    faults = _faults(trials, averages, peaks, tip, band, record_length, axes)
    for name, value in (("postures", postures), ("points", points), ("references", references)):
        count = value if isinstance(value, int) or value is None else len(value)
        if count is not None and not 1 <= count <= MOST:
            faults.append(Fault("call", name, str(count), f"1 to {MOST}"))
    if faults:
        raise InvalidRequest(faults)
    chosen = _points(robot, points)
    measured = tuple(AXES.index(axis) + 1 for axis in (axes or default_axes(robot)))
    rate = RATIO * band[1]
    return Plan(
        postures=_postures(robot, postures, random),
        points=chosen,
        references=_references(robot, chosen, references, measured),
        axes=measured,
        trials=_trials(trials, averages, peaks, tip, record_length),
        band=band,
        analyser=Analyser(rate, round(record_length * rate)),
    )


def _faults(
    trials: int, averages: int, peaks: Sequence[float], tip: str, band: tuple[float, float],
    record_length: float, axes: str | None,
) -> list[Fault]:  # fmt: skip
    faults = []

    def need(ok: bool, key: str, found: object, allowed: str) -> None:
        if not ok:
            faults.append(Fault("call", key, str(found), allowed))

    need(1 <= trials <= MOST, "trials", trials, f"1 to {MOST}")
    need(1 <= averages <= MOST, "averages", averages, f"1 to {MOST}")
    sound = len(peaks) > 0 and all(np.isfinite(peak) and peak > 0 for peak in peaks)
    need(sound, "peaks", peaks, "at least one finite force above 0 N")
    need(tip in TIPS, "tip", repr(tip), ", ".join(TIPS))
    ordered = all(np.isfinite(band)) and 0 < band[0] < band[1] <= 1e5
    need(ordered, "band", f"{band[0]:g}:{band[1]:g}", "LOW:HIGH in Hz, 0 < LOW < HIGH ≤ 100000")
    need(np.isfinite(record_length) and record_length > 0, "record_length", record_length, "above 0 s")
    if not faults:
        samples = record_length * RATIO * band[1]
        allowed = f"64 to {MOST_SAMPLES}: a longer or shorter record, or another band"
        need(64 <= samples <= MOST_SAMPLES, "record_length", f"{samples:.0f} samples", allowed)
    fine = axes is None or (axes != "" and set(axes) <= set(AXES) and len(set(axes)) == len(axes))
    need(fine, "axes", repr(axes), "some of x, y, z, such as xz")
    return faults


def default_axes(robot: Robot) -> str:
    """The vertical for a planar chain that moves in it, else the first axis in its plane; xyz for others."""
    normal = plane_normal(robot)
    if normal is None:
        return AXES
    inside = [axis for k, axis in enumerate(AXES) if abs(normal[k]) < 0.9]
    return "z" if "z" in inside else inside[0]


def _postures(
    robot: Robot, wanted: int | Sequence[str | Mapping[str, float]], random: np.random.Generator
) -> tuple[CampaignPosture, ...]:
    given: list[tuple[str, Mapping[str, float]]] = []
    if isinstance(wanted, int):
        named = list(robot.postures)
        count = min(wanted, len(named))
        spaced: list[int] = []
        if count:
            spaced = np.unique(np.linspace(0, len(named) - 1, count).round().astype(int)).tolist()
        given = [(named[k], robot.postures[named[k]]) for k in spaced]
        while len(given) < wanted:
            given.append((f"random_{len(given) + 1}", _random_posture(robot, random)))
    else:
        faults: list[Fault] = []
        for number, pose in enumerate(wanted, start=1):
            try:
                posture = robot.posture(pose)
                given.append((posture.name or f"posture_{number}", posture.values))
            except InvalidPosture as error:
                faults += error.faults
        if faults:
            raise InvalidPosture(faults)
    return tuple(
        CampaignPosture(number, name, {joint: float(values.get(joint, 0.0)) for joint in robot.commanded})
        for number, (name, values) in enumerate(given, start=1)
    )


def _random_posture(robot: Robot, random: np.random.Generator) -> dict[str, float]:
    values = {}
    for name, joint in robot.commanded.items():
        widest = _WIDEST if joint.type != "prismatic" else np.inf
        lower, upper = max(joint.lower, -widest), min(joint.upper, widest)
        if lower > upper:
            lower, upper = joint.lower, joint.upper
        if not np.isfinite(upper - lower):
            lower, upper = -0.5, 0.5
        middle, half = (lower + upper) / 2, 0.9 * (upper - lower) / 2
        values[name] = float(random.uniform(middle - half, middle + half))
    return values


def _points(robot: Robot, count: int | None) -> tuple[CampaignPoint, ...]:
    """The card's points on moving links, or the far ends of the links; evenly chosen, the outermost kept."""
    moved = moved_links(robot)
    found = [(name, point.link, point.xyz) for name, point in robot.points.items()]
    if not found:
        for link in moved:
            end = reach(robot, link)
            if np.linalg.norm(end) > 1e-3:
                found.append((f"{link}_end", link, (float(end[0]), float(end[1]), float(end[2]))))
    if not found:
        allowed = "a card with points, or links of some length"
        raise InvalidRequest(Fault(robot.name, "points", "no point to measure at", allowed))
    total = len(found)
    if count is None:
        count = total
    if count > total:
        names = ", ".join(name for name, *_ in found)
        raise InvalidRequest(Fault("call", "points", str(count), f"1 to {total}: {names}"))
    outer = _outermost(robot, [(link, xyz) for _, link, xyz in found])
    order = [outer, *(k for k in range(total) if k != outer)]
    picked = sorted({order[k] for k in np.linspace(0, total - 1, count).round().astype(int)})
    return tuple(CampaignPoint(n, *found[k]) for n, k in enumerate(picked, start=1))


def _depth(robot: Robot, link: str) -> int:
    parent = {joint.child: joint for joint in robot.urdf.joints}
    depth = 0
    while link in parent:
        depth += parent[link].name in robot.joints
        link = parent[link].parent
    return depth


def _outermost(robot: Robot, places: Sequence[tuple[str, tuple[float, float, float]]]) -> int:
    """The place that most joints move, the farthest out on its link."""
    return max(
        range(len(places)), key=lambda k: (_depth(robot, places[k][0]), float(np.linalg.norm(places[k][1])))
    )


def _references(
    robot: Robot, points: tuple[CampaignPoint, ...], wanted: int | Sequence[str], axes: tuple[int, ...]
) -> tuple[tuple[int, int], ...]:
    if not isinstance(wanted, int):
        return _named_references(points, wanted)
    outer = _outermost(robot, [(point.link, point.xyz) for point in points])
    inner = sorted(range(len(points)), key=lambda k: _depth(robot, points[k].link), reverse=True)
    halfway = [inner[len(inner) // 2], *(k for k in inner if k != inner[len(inner) // 2])]
    order = [outer, *(k for k in halfway if k != outer)]
    upright = sorted(axes, reverse=True)
    pairs = [(points[order[(k + turn) % len(order)]].id, upright[(k + turn) % len(upright)])
             for turn in range(len(upright)) for k in range(len(order))]  # fmt: skip
    everything = list(dict.fromkeys([*pairs, *((p.id, axis) for p in points for axis in upright)]))
    if wanted > len(everything):
        allowed = f"1 to {len(everything)} with these points and axes"
        raise InvalidRequest(Fault("call", "references", str(wanted), allowed))
    return tuple(everything[:wanted])


def _named_references(
    points: tuple[CampaignPoint, ...], wanted: Sequence[str]
) -> tuple[tuple[int, int], ...]:
    ids = {point.name: point.id for point in points}
    faults: list[Fault] = []
    found = []
    for text in wanted:
        try:
            direction = PointDirection.parse(text)
        except InvalidInput as error:
            faults += error.faults
            continue
        if direction.point not in ids or direction.is_rotation:
            allowed = f"NAME:±x, ±y or ±z with one of {', '.join(ids)}"
            faults.append(Fault("call", "references", repr(text), allowed))
            continue
        found.append((ids[direction.point], direction.sign * (AXES.index(direction.axis) + 1)))
    if len(set(found)) < len(found):
        faults.append(Fault("call", "references", "one of them twice", "different ones"))
    if faults:
        raise InvalidRequest(faults)
    return tuple(found)


def _trials(
    count: int, averages: int, peaks: Sequence[float], tip: str, record_length: float
) -> tuple[Trial, ...]:
    """Trials go through the levels in turn, so that 4 trials at two levels are two pairs of repeats."""
    trials = []
    for number in range(1, count + 1):
        level = (number - 1) % len(peaks)
        first = level + 1
        trials.append(
            Trial(
                id=number,
                force_peak=float(peaks[level]),
                averages=averages,
                tip=tip,
                record_length=record_length,
                repeat_of=first if number > first else None,
            )
        )
    return tuple(trials)
