"""Every error of the package.

One family: `FlexmodalError`. What a user can mend is an `InvalidInput`, which carries its evidence
as `Fault` records: which file, which key in it, what stands there, and what may stand there. All the
faults of one input are gathered before anything is raised.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

_LONGEST_NAME = 300
"""Characters of a path that is printed whole."""


@dataclass(frozen=True)
class Fault:
    """One thing wrong with an input, as a sentence somebody can act on."""

    file: str
    """Path of the file, or where else the input came from ("command line", "call")."""
    key: str
    """The key, record or element inside it; empty when the file as a whole is meant."""
    found: str
    """What stands there."""
    allowed: str
    """What may stand there, or what to do."""

    def __post_init__(self) -> None:
        """Shorten what somebody else's file made long: a fault is a sentence."""
        for name, most in (("key", 200), ("found", 450), ("allowed", 1000)):
            text = getattr(self, name)
            if len(text) > most:
                object.__setattr__(self, name, f"{text[:most]}…")

    def __str__(self) -> str:
        """`file: key: found …; allowed: …`, all of it shorter than 2 kB."""
        half = _LONGEST_NAME // 2
        short = len(self.file) <= _LONGEST_NAME
        name = self.file if short else f"{self.file[:half]}…{self.file[-half:]}"
        where = f"{name}: {self.key}" if self.key else name
        return f"{where}: found {self.found}; allowed: {self.allowed}"


@dataclass(frozen=True)
class Report:
    """What a check of a robot or a campaign found."""

    path: str
    faults: tuple[Fault, ...]
    warnings: tuple[str, ...]

    @property
    def is_sound(self) -> bool:
        """Whether the robot or the campaign can be used."""
        return not self.faults


class FlexmodalError(Exception):
    """Base of every error that flexmodal raises on purpose."""


class InvalidInput(FlexmodalError, ValueError):
    """An input is wrong; `faults` says where and how, all of it at once."""

    def __init__(self, faults: Iterable[Fault] | Fault) -> None:
        self.faults: tuple[Fault, ...] = (faults,) if isinstance(faults, Fault) else tuple(faults)
        super().__init__("\n".join(str(fault) for fault in self.faults))


class RobotNotFound(InvalidInput):
    """No card, URDF or example arm answers to that name or path."""


class InvalidCard(InvalidInput):
    """A robot card breaks its format, or does not belong to its URDF."""


class InvalidCampaign(InvalidInput):
    """A campaign breaks its format, contradicts itself, or holds data that no measurement gives."""


class InvalidCut(InvalidInput):
    """A cut breaks its format, or describes a cutter, an engagement or a frame that cannot be."""


class InvalidUrdf(InvalidInput):
    """A URDF is not a sound description of a robot."""


class InvalidPosture(InvalidInput):
    """A posture has wrong names, values that are no numbers, or lies outside the limits."""


class InvalidPoint(InvalidInput):
    """A point or a direction does not exist on this robot."""


class InvalidFrequencies(InvalidInput):
    """A frequency axis is empty, negative, not finite or not ascending."""


class InvalidSystem(InvalidInput):
    """Mass, damping and stiffness are not those of a passive vibrating system."""


class InvalidRequest(InvalidInput):
    """An option or argument is out of its range, or contradicts another."""


class OutputExists(InvalidInput):
    """A file stands where output should go, and nobody asked for it to be replaced."""


class NotWritten(InvalidInput):
    """Output could not be written; what stood in its place stands there as it was."""


class MissingExtra(FlexmodalError, ImportError):
    """An optional package is needed for this and is not installed."""


class SingularResponse(FlexmodalError, ArithmeticError):
    """The receptance is infinite: an undamped system driven exactly at resonance."""


class DefectiveModes(FlexmodalError, ArithmeticError):
    """Critically damped poles without a full set of modes; use the direct solve instead."""


class InaccurateModes(FlexmodalError, ArithmeticError):
    """Poles that rounding has left no digits of; use the direct solve instead."""


class Unreachable(FlexmodalError):
    """No posture within the limits puts the held frame on its target."""


class InCollision(Unreachable):
    """Postures that would do come nearer to something than the clearance that was asked for."""
