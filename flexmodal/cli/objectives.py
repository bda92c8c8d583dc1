"""What postures are judged by, as options of several commands."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import click

from flexmodal.cli.options import SOURCE, Command, band_of, hertz, number
from flexmodal.errors import Fault, InvalidRequest

if TYPE_CHECKING:
    import numpy as np

    from flexmodal.frf import PointDirection
    from flexmodal.model import Robot
    from flexmodal.model.receptance_source import ReceptanceSource
    from flexmodal.optimisation import Objective

_SEVERAL = ("worst", "weighted", "force")
_OBJECTIVES = ("receptance", *_SEVERAL, "tuned", "stiffness", "mobility", "separation")
_BAND_LINES = 60
"""Lines a band is judged at, evenly spaced."""

_OPTIONS = (
    click.option("--objective", type=click.Choice(_OBJECTIVES), default="receptance", show_default=True),
    click.option(
        "--direction",
        "directions",
        multiple=True,
        metavar="POINT:AXIS[=WEIGHT]",
        help="Such as tool:+z (the default); may be repeated.",
    ),
    click.option(
        "--toward",
        multiple=True,
        metavar="POINT:AXIS[=WEIGHT]",
        help="For weighted: where motion counts, among the directions.",
    ),
    click.option("--frequency", callback=hertz, metavar="HZ", help="Where the receptance is taken."),
    click.option("--band", metavar="LOW:HIGH", help="A band of frequencies instead of one."),
    click.option("--spindle", metavar="RPM", help="The tooth-passing frequency of this speed instead."),
    click.option("--teeth", type=click.IntRange(1, 1000), help="Of the cutter, with --spindle."),
    click.option(
        "--harmonics",
        type=click.IntRange(1, 100),
        default=1,
        show_default=True,
        help="Of the tooth passing, the first included.",
    ),
    click.option(
        "--over",
        type=click.Choice(["mean", "largest"]),
        help="How several frequencies are taken together; largest for worst, else mean.",
    ),
    click.option(
        "--robust",
        type=click.Choice(["expected", "worst"]),
        help="Judge by the mean, or the worst, of a sample of uncertain stiffness and damping.",
    ),
    click.option(
        "--samples", type=click.IntRange(1, 1000), default=16, show_default=True, help="For --robust."
    ),
    click.option(
        "--uncertainty",
        metavar="K[,B]",
        default="0.1,0.3",
        show_default=True,
        help="For --robust: relative standard deviations of stiffness and damping.",
    ),
)


def judging_options(command: Command) -> Command:
    """Objective, directions, frequencies, uncertainty."""
    for decorate in reversed(_OPTIONS):
        command = decorate(command)
    return command


def objective_of(
    arm: Robot,
    *,
    objective: str,
    directions: Sequence[str],
    toward: Sequence[str],
    robust: str | None,
    samples: int,
    uncertainty: str,
    seed: int = 0,
    source: ReceptanceSource | None = None,
    **lines: Any,
) -> Objective:
    """The objective that the options of `judging_options` describe, of receptances from a source.

    Args:
        arm: the robot.
        objective: its name.
        directions: texts of --direction; the tool along z if none.
        toward: texts of --toward.
        robust: expected or worst over a sample of robots; None for the robot alone.
        samples: how many robots.
        uncertainty: relative standard deviations of their stiffness and damping, or one of both.
        seed: of the sample.
        source: of receptances; None for the model of the robot.
        **lines: the options that say at which frequencies, and `over`.
    """
    from flexmodal.optimisation import RobustObjective, sample_robots

    if source is not None:
        _refuse_beside(objective, robust)
    owner = arm if source is None else None
    read, weights = _directions(owner, directions or (f"{arm.tool}:+z",), "--direction")
    if len(read) > 1 and objective not in _SEVERAL:
        found = f"{len(read)} directions"
        raise InvalidRequest(Fault(SOURCE, "--direction", found, f"one for --objective {objective}"))
    if toward and objective != "weighted":
        raise InvalidRequest(Fault(SOURCE, "--toward", f"with {objective}", "--objective weighted"))
    judge = _judge(objective, read, weights, _toward(owner, toward, read), lines, source)
    if robust is None:
        return judge
    spread = [number(part, "--uncertainty", "a relative deviation") for part in uncertainty.split(",")]
    if len(spread) > 2:
        raise InvalidRequest(Fault(SOURCE, "--uncertainty", repr(uncertainty), "one number, or two"))
    drawn = sample_robots(arm, samples, stiffness=spread[0], damping=spread[-1], seed=seed)
    return RobustObjective(judge, drawn, robust)


def _judge(
    name: str,
    read: tuple[PointDirection, ...],
    weights: tuple[float, ...],
    toward: tuple[float, ...],
    lines: dict[str, Any],
    source: ReceptanceSource | None,
) -> Objective:
    from flexmodal.model.receptance_source import MODEL
    from flexmodal.optimisation import (
        MobilityObjective,
        ReceptanceObjective,
        SeparationObjective,
        StiffnessObjective,
        TunedObjective,
    )

    given = [f"--{key}" for key in ("frequency", "band", "spindle") if lines[key] is not None]
    if name in ("stiffness", "mobility"):
        if given:
            allowed = f"none: the {name} measure has no frequency"
            raise InvalidRequest(Fault(SOURCE, " and ".join(given), "given", allowed))
        return StiffnessObjective(read[0]) if name == "stiffness" else MobilityObjective(read[0])
    if name == "tuned":
        if given != ["--band"]:
            found = " and ".join(given) or "no --band"
            raise InvalidRequest(Fault(SOURCE, "--objective tuned", found, "--band LOW:HIGH alone"))
        return TunedObjective(read[0], band_of(lines["band"]))
    if name == "separation":
        if given not in ([], ["--frequency"]):
            found = " and ".join(given)
            raise InvalidRequest(Fault(SOURCE, "--objective separation", found, "--frequency HZ, or none"))
        return SeparationObjective(lines["frequency"])
    combine = name if name in _SEVERAL else "weighted"
    over = lines["over"] or ""
    return ReceptanceObjective(
        read, _axis(given, lines), combine, weights, toward, over, source=source or MODEL
    )


def _refuse_beside(objective: str, robust: str | None) -> None:
    """What asks more of a source than receptances."""
    if objective not in ("receptance", *_SEVERAL):
        allowed = ", ".join(("receptance", *_SEVERAL)) + " with --campaign: the others are of a model"
        raise InvalidRequest(Fault(SOURCE, "--objective", objective, allowed))
    if robust is not None:
        allowed = "none with --campaign: a prediction has a band of its own"
        raise InvalidRequest(Fault(SOURCE, "--robust", robust, allowed))


def _axis(given: list[str], lines: dict[str, Any]) -> np.ndarray:
    """The frequencies that are judged [Hz]."""
    import numpy as np

    from flexmodal.frf import frequency_axis
    from flexmodal.optimisation import tooth_passing

    if len(given) != 1:
        allowed = "--frequency HZ or --band LOW:HIGH or --spindle RPM"
        found = f"{given[0]} given with {' and '.join(given[1:])}" if given else "none"
        raise InvalidRequest(Fault(SOURCE, "--frequency", found, allowed))
    if (lines["spindle"] is None) != (lines["teeth"] is None):
        missing = "--teeth" if lines["teeth"] is None else "--spindle"
        raise InvalidRequest(Fault(SOURCE, missing, "none", "--spindle RPM with --teeth N"))
    if lines["spindle"] is not None:
        speed = number(lines["spindle"], "--spindle", "a speed in 1/min")
        return frequency_axis(tooth_passing(speed, lines["teeth"], lines["harmonics"]))
    if lines["band"] is not None:
        return frequency_axis(np.linspace(*band_of(lines["band"]), _BAND_LINES), source=f"{SOURCE} --band")
    return frequency_axis([lines["frequency"]], source=f"{SOURCE} --frequency")


def _directions(
    arm: Robot | None, given: Sequence[str], option: str
) -> tuple[tuple[PointDirection, ...], tuple[float, ...]]:
    from flexmodal.frf import PointDirection

    split = [text.partition("=") for text in given]
    read = tuple(PointDirection.parse(text, source=f"{SOURCE} {option}") for text, _, _ in split)
    for direction in read:
        if arm is not None:  # a prediction knows the points of its campaign
            arm.frame_of(direction.point, source=f"{SOURCE} {option}")
    return read, tuple(number(weight, option, "a weight") if weight else 1.0 for _, _, weight in split)


def _toward(arm: Robot | None, given: Sequence[str], among: tuple[PointDirection, ...]) -> tuple[float, ...]:
    """Weights over the directions of the force."""
    if not given:
        return ()
    read, weights = _directions(arm, given, "--toward")
    strange = [str(direction) for direction in read if direction not in among]
    if strange:
        allowed = "among --direction: " + ", ".join(map(str, among))
        raise InvalidRequest(Fault(SOURCE, "--toward", ", ".join(strange), allowed))
    found = dict(zip(read, weights, strict=True))
    return tuple(found.get(direction, 0.0) for direction in among)
