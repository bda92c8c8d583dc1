"""What a hidden effect is: where it can sit, how strong it comes, and what it does to the structure."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from flexmodal.campaign import CampaignPoint
from flexmodal.model import Robot
from flexmodal.model.placements import link_placements
from flexmodal.rig.believed import TrueRobot
from flexmodal.rig.plan import HammerPlan
from flexmodal.rig.plant.assembly import PlantAssembly
from flexmodal.rig.sensing import Sensor
from flexmodal.structure.arm import plane_normal

Parameters = Mapping[str, float]
Check = Callable[[Parameters], str | None]
"""What is wrong with given parameters, if anything."""

OWN = "own"
"""The form that the rig has always had."""


@dataclass(frozen=True, eq=False)
class Stand:
    """What an effect may look at before it is put in."""

    robot: Robot
    true: TrueRobot
    plan: HammerPlan
    deflection: Mapping[str, tuple[float, float]]
    """Peak deflection of each joint under the weakest and the hardest kind of blow, nothing hidden [rad]."""
    acceleration: Mapping[str, float]
    """Peak at each point under the hardest kind of blow, nothing hidden [m/s²]."""

    @property
    def mass(self) -> float:
        """Of the robot, its base among it [kg]."""
        return sum(body.mass for body in self.true.bodies.values())

    @property
    def normal(self) -> np.ndarray | None:
        """Normal of a planar chain's plane."""
        return plane_normal(self.robot)

    def link_of(self, point: str) -> str:
        """The link that a point is on."""
        return next(one.link for one in self.plan.points if one.name == point)

    def normal_in(self, link: str) -> np.ndarray | None:
        """The same in the frame of a link."""
        if self.normal is None:
            return None
        return link_placements(self.robot, {})[link][:3, :3].T @ self.normal


@dataclass(frozen=True)
class Site:
    """An effect's place and the numbers it is put in with."""

    stand: Stand
    where: str
    parameters: Parameters

    def __getitem__(self, name: str) -> float:
        """A parameter."""
        return self.parameters[name]

    def vector(self, *names: str) -> np.ndarray:
        """Several parameters as a vector."""
        return np.array([self.parameters[name] for name in names])


Draw = Callable[[Stand, str, np.random.Generator], dict[str, float]]
"""Plausible parameters for a place."""


@dataclass(frozen=True)
class Effect:
    """One way in which a robot differs from its card. The hooks that do not apply are None."""

    name: str
    says: str
    """What it is, for people."""
    units: Mapping[str, str]
    """Its parameters and their units."""
    places: Callable[[Robot, Sequence[CampaignPoint]], tuple[str, ...]]
    """Where it can sit, on a robot with sensors on these points."""
    place_is: str
    """What kind of place that is, for people."""
    draw: Draw
    """Of severity 1."""
    scaled: Callable[[Parameters, float], dict[str, float]]
    """The parameters at another severity; 0 is nothing at all, or as good as."""
    most: Callable[[Parameters], float] = lambda parameters: 30.0
    """The highest severity that still makes sense."""
    check: Check = lambda parameters: None
    shape: Callable[[PlantAssembly, Site], None] | None = None
    """New coordinates: done first, since they change how everything moves."""
    body: Callable[[PlantAssembly, Site], bool] | None = None
    """Takes over putting in the mass of the link `where`; says whether it did."""
    act: Callable[[PlantAssembly, Site], None] | None = None
    """Masses, springs, laws."""
    sense: Callable[[dict[str, Sensor], Site], None] | None = None
    """What the sensors make of the motion."""
    linear: bool = True
    catalogued: bool = True
    """Whether a diagnosis has a name for it."""
    active: bool = False
    """Whether it may give work, so that the arm might ring up: a motor, or springs that hold only beside
    others."""
    form: str = OWN
    """Which of the physical forms under this name."""
    source: str = ""
    """Where the form is described."""

    @property
    def key(self) -> str:
        """The name, and the form where it is not the rig's own."""
        return self.name if self.form == OWN else f"{self.name}:{self.form}"


def standing(stand: Stand) -> list[PlantAssembly]:
    """The robot in each posture of the plan, nothing hidden in it.

    Args:
        stand: with the plan.
    """
    return [PlantAssembly(stand.robot.at(dict(posture.q))) for posture in stand.plan.postures]


def drawing(draw: Draw | None = None, /, **spans: tuple[float, float]) -> Draw:
    """Parameters drawn evenly from spans, after those of another way to draw.

    Args:
        draw: the other way, if any.
        spans: least and most, by parameter.
    """

    def drawn(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
        before = {} if draw is None else draw(stand, where, random)
        return before | {name: float(random.uniform(*span)) for name, span in spans.items()}

    return drawn


def either_sign(random: np.random.Generator, low: float, high: float) -> float:
    """A number of a size between two, as often below 0 as above.

    Args:
        random: drawn from twice, the size first.
        low: the least size.
        high: the most.
    """
    size = float(random.uniform(low, high))
    return size if random.uniform() < 0.5 else -size


def damping_time(random: np.random.Generator) -> float:
    """Damping over stiffness of steel that is bolted together, from 0.1 to 1 ms [s]."""
    return float(np.exp(random.uniform(np.log(1e-4), np.log(1e-3))))


def within(**spans: tuple[float, float]) -> Check:
    """A check that parameters lie within spans, both ends allowed."""

    def check(parameters: Parameters) -> str | None:
        for name, (low, high) in spans.items():
            if not low <= parameters[name] <= high:
                allowed = f"{low:g} or more" if high == np.inf else f"{low:g} to {high:g}"
                return f"{name} = {parameters[name]:g}, where {allowed.replace('-', '−')} is allowed"
        return None

    return check


def each(*checks: Check) -> Check:
    """One check after the other, until something is wrong."""
    return lambda parameters: next(filter(None, (check(parameters) for check in checks)), None)


def directed(*names: str) -> Check:
    """A check that the parts of a direction are not all 0."""

    def check(parameters: Parameters) -> str | None:
        given = any(parameters[name] for name in names)
        return None if given else f"{', '.join(names)} all 0, where a direction is needed"

    return check


def positive(*names: str) -> Check:
    """A check that these parameters are above 0."""

    def check(parameters: Parameters) -> str | None:
        low = [name for name in names if parameters[name] <= 0]
        return f"{low[0]} = {parameters[low[0]]:g}, where a number above 0 is needed" if low else None

    return check


def multiplied(*names: str) -> Callable[[Parameters, float], dict[str, float]]:
    """Severity multiplies these parameters."""
    return lambda parameters, s: {k: v * s if k in names else v for k, v in parameters.items()}


def divided(*names: str) -> Callable[[Parameters, float], dict[str, float]]:
    """Severity divides these parameters: stiffnesses, which are infinite where nothing is hidden."""
    return lambda parameters, s: {k: v / s if k in names else v for k, v in parameters.items()}
