"""The thesis's own way to dynamic parameters [Hearne 2.6]: eigenvalues alone, absolute bounds, no priors.

Masses, moments of inertia, stiffness and damping are independent unknowns within bounds [Hearne, Appendix
D]; the error is that of natural frequency and damping ratio [2.54], in stages: a fit to a few configurations
is the start of the next one. What it cannot tell — the scale of everything, for one — it leaves where the
bounds or the start put it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float

from flexmodal.campaign import Campaign
from flexmodal.errors import Fault, InvalidRequest
from flexmodal.identification.evidence.evidence import refuse
from flexmodal.identification.evidence.modal import ModalEvidence
from flexmodal.identification.evidence.mode_sources import modes_of_table
from flexmodal.identification.optima import search
from flexmodal.identification.outcome import TOUCHING
from flexmodal.identification.spot import Spot, in_world
from flexmodal.model import Robot
from flexmodal.structure.arm import Arm, Body, moved_bodies
from flexmodal.structure.assembly import Assembly
from flexmodal.structure.mass_map import moment_of
from flexmodal.structure.parameter import Parameter, ParameterSpace
from flexmodal.structure.structure import Structure

FAR = 0.3
"""Relative error of frequencies that pairing grants the model at first: the start may be anywhere."""
NO_PRIOR = 30.0
"""Standard deviation of a logarithm that says nothing."""
UNITS = {"stiffness": "N·m/rad", "damping": "N·m·s/rad", "mass": "kg", "moment": "kg·m²"}

Bounds = Mapping[str, tuple[float, float, float]]
"""Lowest, initial, highest value: `stiffness.JOINT`, `damping.JOINT`, `mass.LINK`, `moment.LINK`."""


@dataclass(frozen=True, eq=False)
class EigenvalueModel:
    """A robot whose masses and moments of inertia are independent of one another."""

    robot: Robot
    space: ParameterSpace

    def structure_at(
        self,
        x: Float[np.ndarray, " parameter"],
        q: Mapping[str, float],
        responses: Sequence[Spot],
        references: Sequence[Spot],
    ) -> Structure:
        """In one posture, see `PosedModel`; what is not a parameter is as the card says."""
        values = self.space.values(x)
        assembly = Assembly(Arm(self.robot, dict(q)))
        for link, body in assembly.arm.bodies.items():
            mass = values.get(f"mass.{link}", body.mass)
            size = moment_of(body.inertia)
            grown = values.get(f"moment.{link}", size) / size if size > 0 else 1.0
            assembly.add_body(link, Body(mass, body.centre, np.zeros((3, 3))), mass=f"mass.{link}")
            assembly.add_body(link, Body(0.0, body.centre, body.inertia * grown), mass=f"moment.{link}")
        for name, joint in self.robot.joints.items():
            row = assembly.row(name)
            assembly.add_spring(row, values.get(f"stiffness.{name}", joint.stiffness), f"stiffness.{name}")
            assembly.add_damper(row, values.get(f"damping.{name}", joint.damping), f"damping.{name}")
            if joint.rotor_inertia:
                assembly.add_inertia(row, joint.rotor_inertia)
        return assembly.close(
            *(assembly.rows(in_world(spots, assembly)) for spots in (responses, references))
        )


@dataclass(frozen=True, eq=False)
class Stage:
    """Where the fit to some postures ended."""

    postures: tuple[str, ...]
    model: EigenvalueModel
    x: Float[np.ndarray, " parameter"]
    converged: bool
    optima: int
    """Distinct ones among the starts."""

    @property
    def values(self) -> dict[str, float]:
        """By name."""
        return self.model.space.values(self.x)

    @property
    def at_bound(self) -> tuple[str, ...]:
        """Names of those that stand at a bound."""
        low, high = self.model.space.bounds
        near = (self.x <= low + TOUCHING) | (self.x >= high - TOUCHING)
        return tuple(name for name, at in zip(self.model.space.names, near, strict=True) if at)


def eigenvalue_method(
    campaign: Campaign,
    robot: Robot,
    bounds: Bounds,
    stages: Sequence[Sequence[str]],
    *,
    model_error: float = 0.01,
    starts: int = 1,
    seed: int = 0,
) -> tuple[Stage, ...]:
    """Fit eigenvalues of more and more postures.

    Args:
        campaign: with modes.
        robot: its chain, mass centres and, for what has no bounds, its card's numbers.
        bounds: lowest, initial and highest value of each unknown.
        stages: names of the postures of each stage; every stage begins where the one before ended.
        model_error: relative error of natural frequencies that the model is granted.
        starts: of the first stage: the initial values, then others drawn around them.
        seed: of those.

    Raises:
        InvalidRequest: an unknown name, values out of order, no such posture, fewer numbers than unknowns.
    """
    model = EigenvalueModel(robot, _space(robot, bounds))
    observed = modes_of_table(campaign)
    names = [posture.name for posture in observed.postures]
    unknown = [name for stage in stages for name in stage if name not in names]
    if unknown or not stages:
        allowed = f"postures with modes: {', '.join(names)}"
        raise InvalidRequest([Fault("call", "stages", repr(name), allowed) for name in unknown or ["none"]])
    found: list[Stage] = []
    for number, stage in enumerate(stages):
        keep = np.array([names[mode.posture] in stage for mode in observed.modes])
        evidence = ModalEvidence(model, observed.keeping(keep), ("frequency", "damping"), model_error, FAR)
        refuse(evidence.faults())
        if number == 0:
            fitted, optima = search(evidence, starts=starts, seed=seed)
        else:
            fitted, optima = evidence.fit(found[-1].x), ()
        found.append(Stage(tuple(stage), model, fitted.x, fitted.converged, max(len(optima), 1)))
    return tuple(found)


def _space(robot: Robot, bounds: Bounds) -> ParameterSpace:
    known = {f"{kind}.{joint}" for kind in ("stiffness", "damping") for joint in robot.joints}
    known |= {f"{kind}.{link}" for kind in ("mass", "moment") for link in moved_bodies(robot)}
    faults = [
        Fault("call", "bounds", repr(name), ", ".join(sorted(known))) for name in bounds if name not in known
    ]
    faults += [
        Fault("call", f"bounds of {name}", f"{low:g}, {start:g}, {high:g}", "0 < lowest ≤ initial ≤ highest")
        for name, (low, start, high) in bounds.items()
        if not 0 < low <= start <= high < np.inf
    ]
    if faults:
        raise InvalidRequest(faults)
    blank = Parameter("", "", 1.0, NO_PRIOR)
    return ParameterSpace(
        tuple(
            replace(blank, name=name, unit=UNITS[name.split(".")[0]], card=start, lower=low, upper=high)
            for name, (low, start, high) in bounds.items()
        )
    )
