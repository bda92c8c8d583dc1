"""What to hide, as it is asked for, and where it could be."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from flexmodal.campaign import CampaignPoint
from flexmodal.errors import Fault, InvalidRequest
from flexmodal.model import Robot
from flexmodal.rig.effects import EFFECTS
from flexmodal.rig.effects.effect import OWN
from flexmodal.rig.forms import FORMS, find
from flexmodal.rig.positions import choose_points

Height = float | tuple[float, float]
"""Multiple of the noise floor, or the lowest and the highest that will do."""
HIGHEST = 1000.0


@dataclass(frozen=True)
class Hide:
    """An effect to hide."""

    effect: str
    where: str = ""
    """Where; drawn from the seed if empty."""
    parameters: Mapping[str, float] = field(default_factory=dict)
    """Some or all of its parameters; the others are drawn from the seed."""
    severity: float = 1.0
    """Multiple of those parameters, in the sense of `Effect.scaled`."""
    height: Height | None = None
    """How many times the noise floor it is to stand; then the severity is searched for. In a range, the
    height is drawn from the seed, and one out of the effect's reach gives way to the nearest within it."""
    form: str = OWN
    """Which of its physical forms; see `flexmodal.rig.FORMS`."""

    @classmethod
    def parse(cls, text: str | Hide, *, source: str = "call") -> Hide:
        """Read "EFFECT", "EFFECT:FORM", "EFFECT@WHERE" or "EFFECT:FORM@WHERE,parameter=value,…".

        Args:
            text: what to hide; a `Hide` is given back as it is.
            source: where the text came from, for the error.
        """
        if isinstance(text, Hide):
            return text
        head, *rest = (part.strip() for part in text.split(","))
        name, _, where = head.partition("@")
        name, _, form = name.partition(":")
        parameters, faults = {}, []
        for part in rest:
            key, equals, value = part.partition("=")
            try:
                parameters[key.strip()] = float(value)
            except ValueError:
                equals = ""
            if not equals:
                faults.append(Fault(source, "hide", repr(part), "parameter=value"))
        if faults:
            raise InvalidRequest(faults)
        return cls(name.strip(), where.strip(), parameters, form=form.strip() or OWN)

    @property
    def range(self) -> tuple[float, float] | None:
        """Lowest and highest height; None where none is asked for."""
        if self.height is None or isinstance(self.height, tuple):
            return self.height
        return float(self.height), float(self.height)


def hide_places(robot: Robot, *, points: int | None = None) -> dict[str, tuple[str, ...]]:
    """Where each effect can sit on a robot.

    Args:
        robot: the robot.
        points: how many of its points carry a sensor, as in `simulate`; all if None.

    Returns:
        Places by name of the effect, in the order of `EFFECTS`; none where the robot has no such place.

    Raises:
        InvalidRequest: more points than the robot has, or none at all.
    """
    chosen = choose_points(robot, points)
    return {name: effect.places(robot, chosen) for name, effect in EFFECTS.items()}


def canonical(where: str, places: Sequence[str]) -> str:
    """A pair of joints is the same in either order.

    Args:
        where: a place as it was asked for.
        places: those there are.
    """
    turned = "+".join(reversed(where.split("+")))
    return turned if where not in places and turned in places else where


def check_hides(
    robot: Robot, points: Sequence[CampaignPoint] | None, wanted: Sequence[Hide], noise: float
) -> None:
    """Complain about what cannot be hidden.

    Args:
        robot: the robot.
        points: with sensors; None where they are not known, and places are not looked at.
        wanted: what is to be hidden.
        noise: of the campaign; heights are measured against it.

    Raises:
        InvalidRequest: unknown effects, places or parameters, numbers out of their range, an effect twice.
    """
    faults = [fault for item in wanted for fault in _faults(robot, points, item)]
    names = [item.effect for item in wanted]
    if len(set(names)) < len(names):
        faults.append(Fault("call", "hide", "the same effect twice", "each effect once"))
    if noise == 0 and any(item.height is not None for item in wanted):
        allowed = "noise above 0, since heights are measured against it"
        faults.append(Fault("call", "hide", "a height over the noise floor, without noise", allowed))
    if faults:
        raise InvalidRequest(faults)


def _faults(robot: Robot, points: Sequence[CampaignPoint] | None, item: Hide) -> list[Fault]:
    key = f"hide {item.effect}" + (f"@{item.where}" if item.where else "")
    if item.effect not in EFFECTS:
        return [Fault("call", "hide", f"unknown effect {item.effect!r}", ", ".join(EFFECTS))]
    if item.form not in FORMS[item.effect]:
        return [Fault("call", key, f"unknown form {item.form!r}", ", ".join(FORMS[item.effect]))]
    effect = find(item.effect, item.form)
    faults = []
    if points is not None:
        places = effect.places(robot, points)
        if not places:
            faults.append(Fault("call", key, f"a robot without {effect.place_is}", "another effect"))
        elif item.where and canonical(item.where, places) not in places:
            found = f"no place {item.where!r} for it"
            faults.append(Fault("call", key, found, f"{effect.place_is}: {', '.join(places)}"))
    for name, value in item.parameters.items():
        if name not in effect.units:
            faults.append(Fault("call", key, f"unknown parameter {name!r}", ", ".join(effect.units)))
        elif not np.isfinite(value):
            faults.append(Fault("call", key, f"{name} = {value}", "a finite number"))
    if not (np.isfinite(item.severity) and item.severity > 0):
        faults.append(Fault("call", key, f"severity {item.severity}", "a finite number above 0"))
    if item.range is not None and not 0 < item.range[0] <= item.range[1] <= HIGHEST:
        found = f"{item.height} times the noise floor"
        faults.append(Fault("call", key, found, f"above 0, at most {HIGHEST:g}, the lower one first"))
    return faults
