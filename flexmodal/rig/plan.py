"""The test plan: postures, points, hammer references, trials, band and analyser."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import get_args

import numpy as np

from flexmodal.campaign import AxisFrame, CampaignPoint, CampaignPosture, Trial
from flexmodal.errors import Fault, InvalidPosture, InvalidRequest
from flexmodal.model import Robot
from flexmodal.rig.analyser import RATIO, Analyser
from flexmodal.rig.blow import TIPS
from flexmodal.rig.positions import AXES, choose_points, choose_references
from flexmodal.structure.arm import plane_normal
from flexmodal.text.gather import Gathering
from flexmodal.text.words import listing

MOST = 1000
"""The most postures, points, references or trials: beyond, it is a slip of the keyboard."""
PEAKS = 1e-3, 1e6
"""Peaks of a blow [N], from a pencil's to a pile driver's."""
MOST_SAMPLES = 2**20
"""In one record."""
_WIDEST = np.radians(150.0)
"""Random postures turn a joint by at most this, even where its limits are wider."""


@dataclass(frozen=True, eq=False)
class HammerPlan:
    """What is struck and measured, where and how often."""

    postures: tuple[CampaignPosture, ...]
    points: tuple[CampaignPoint, ...]
    references: tuple[tuple[int, int], ...]
    """Point id and direction ±1 ±2 ±3 of each hammer position."""
    axes: tuple[int, ...]
    """Directions that the sensor measures: 1, 2, 3 for x, y, z of the point's axes."""
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
    frame: AxisFrame,
    trials: int,
    averages: int,
    peaks: Sequence[float],
    tip: str,
    band: tuple[float, float],
    record_length: float,
    random: np.random.Generator,
) -> HammerPlan:
    """Plan a campaign; see `simulate` for the arguments.

    Raises:
        InvalidRequest, InvalidPosture, InvalidPoint: every argument out of its range at once.
    """
    gathering = Gathering()
    measured: tuple[int, ...] = ()
    chosen: tuple[CampaignPoint, ...] = ()
    with gathering.step():
        _check(trials, averages, peaks, tip, band, record_length)
    with gathering.step():
        measured = _axes(robot, axes)
    with gathering.step():
        _check_count("postures", postures)
        stood = _postures(robot, postures, random)
    with gathering.step():
        _check_frame(frame)
        chosen = tuple(replace(point, frame=frame) for point in choose_points(robot, points))
    with gathering.step():
        _check_count("references", references)
        if chosen and (measured or not isinstance(references, int)):
            struck = choose_references(robot, chosen, references, measured)
    gathering.done()
    rate = RATIO * band[1]
    return HammerPlan(
        postures=stood,
        points=chosen,
        references=struck,
        axes=measured,
        trials=_trials(trials, averages, peaks, tip, record_length),
        band=band,
        analyser=Analyser(rate, round(record_length * rate)),
    )


def _check(
    trials: int, averages: int, peaks: Sequence[float], tip: str, band: tuple[float, float],
    record_length: float,
) -> None:  # fmt: skip
    faults = []

    def need(ok: bool, key: str, found: object, allowed: str) -> None:
        if not ok:
            faults.append(Fault("call", key, str(found), allowed))

    need(1 <= trials <= MOST, "trials", trials, f"1 to {MOST}")
    need(1 <= averages <= MOST, "averages", averages, f"1 to {MOST}")
    sound = 0 < len(peaks) <= MOST and all(PEAKS[0] <= peak <= PEAKS[1] for peak in peaks)
    need(sound, "peaks", listing(f"{peak:g}" for peak in peaks), "forces from {:g} to {:g} N".format(*PEAKS))
    need(tip in TIPS, "tip", repr(tip), ", ".join(TIPS))
    ordered = all(np.isfinite(band)) and 0 < band[0] < band[1] <= 1e5
    need(ordered, "band", f"{band[0]:g}:{band[1]:g}", "LOW:HIGH in Hz, 0 < LOW < HIGH ≤ 100000")
    need(np.isfinite(record_length) and record_length > 0, "record_length", record_length, "above 0 s")
    if not faults:
        samples = record_length * RATIO * band[1]
        allowed = f"64 to {MOST_SAMPLES}: a longer or shorter record, or another band"
        need(64 <= samples <= MOST_SAMPLES, "record_length", f"{samples:.0f} samples", allowed)
    if faults:
        raise InvalidRequest(faults)


def _check_count(name: str, wanted: int | Sequence[object]) -> None:
    count = wanted if isinstance(wanted, int) else len(wanted)
    if not 1 <= count <= MOST:
        raise InvalidRequest(Fault("call", name, str(count), f"1 to {MOST}"))


def _check_frame(frame: str) -> None:
    if frame not in get_args(AxisFrame):
        raise InvalidRequest(Fault("call", "frame", repr(frame), " or ".join(get_args(AxisFrame))))


def _axes(robot: Robot, wanted: str | None) -> tuple[int, ...]:
    axes = default_axes(robot) if wanted is None else wanted
    if not axes or not set(axes) <= set(AXES) or len(set(axes)) < len(axes):
        raise InvalidRequest(Fault("call", "axes", repr(wanted), "some of x, y, z, such as xz"))
    return tuple(AXES.index(axis) + 1 for axis in axes)


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
        widest = _WIDEST if not joint.is_prismatic else np.inf
        lower, upper = max(joint.lower, -widest), min(joint.upper, widest)
        if lower > upper:
            lower, upper = joint.lower, joint.upper
        if not np.isfinite(upper - lower):
            lower, upper = -0.5, 0.5
        middle, half = (lower + upper) / 2, 0.9 * (upper - lower) / 2
        values[name] = float(random.uniform(middle - half, middle + half))
    return values


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
