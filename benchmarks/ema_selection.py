"""Modes that the automatic choice finds in simulated campaigns, beside those that are there."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from flexmodal.ema import Choices, EstimatedModes, fit
from flexmodal.model import Robot, load
from flexmodal.rig import Hide, RigResult, simulate
from flexmodal.rig.plant.build import build

CAMPAIGNS = (
    ("fanuc_s360", "local_absorber"),
    ("fanuc_s360", "link_flexibility"),
    ("fanuc_s360", "base_flexibility"),
    ("fanuc_s360", ""),
    ("ur5", "local_absorber"),
    ("ur5", "servo_compliance"),
    ("ur5", ""),
    ("six_link", "local_absorber"),
    ("six_link", "added_mass"),
    ("six_link", ""),
)
"""Robot and what is hidden in it, ten times the noise floor high; each in two postures drawn at random."""

HEAVIEST = 0.5
"""Modes damped more make no resonance and are not asked for."""


@dataclass(frozen=True)
class Count:
    """What came out of one posture."""

    true: int
    found: int
    false: int
    missed: tuple[tuple[float, float], ...]
    """Frequency [Hz] and damping ratio."""


def robot_of(name: str) -> Robot:
    """A card, or the UR5 with joints of equal stiffness and damping."""
    return load(name, stiffness=2e4, damping=10.0) if name == "ur5" else load(name)


def random_postures(robot: Robot, count: int, seed: int) -> list[dict[str, float]]:
    """Every commanded joint anywhere within 0.9 of its limits, or of 150° to either side."""
    rng = np.random.default_rng([11, seed])
    postures = []
    for _ in range(count):
        values = {}
        for name, joint in robot.commanded.items():
            low, high = max(joint.lower, -np.radians(150)), min(joint.upper, np.radians(150))
            middle, half = (low + high) / 2, 0.45 * (high - low)
            values[name] = float(rng.uniform(middle - half, middle + half))
        postures.append(values)
    return postures


def campaign(name: str, hidden: str, postures: Sequence[dict[str, float] | str], seed: int) -> RigResult:
    """Two trials of three blows at every point (four of the UR5), 1 % noise, parameters 5 % off."""
    return simulate(
        robot_of(name),
        postures=postures,
        points=4 if name == "ur5" else None,
        trials=2,
        hide=[Hide(hidden, height=10.0)] if hidden else [],
        seed=seed,
    )


def true_modes(result: RigResult, posture: int) -> list[tuple[float, float]]:
    """Natural frequency [Hz] and damping ratio of the structure that was struck, inside the band."""
    plan = result.plan
    plant = build(result.stand, plan.postures[posture - 1], result.hidden)
    poles = np.linalg.eigvals(plant.state_matrix)
    poles = poles[poles.imag > 0]
    frequency, damping = np.abs(poles) / (2 * np.pi), -poles.real / np.abs(poles)
    inside = (frequency > plan.band[0]) & (frequency < plan.band[1])
    order = np.argsort(frequency[inside])
    return list(zip(frequency[inside][order].tolist(), damping[inside][order].tolist(), strict=True))


def counted(found: EstimatedModes, true: Sequence[tuple[float, float]]) -> Count:
    """Pair modes nearest first: within half a half-power bandwidth (1 % at least), damping within two."""
    near = sorted(
        (abs(mode.frequency / frequency - 1), number, place)
        for number, mode in enumerate(found)
        for place, (frequency, damping) in enumerate(true)
        if abs(mode.frequency / frequency - 1) < max(0.01, damping) and 0.5 < mode.damping_ratio / damping < 2
    )
    modes: set[int] = set()
    places: set[int] = set()
    for _, number, place in near:
        if number not in modes and place not in places:
            modes.add(number)
            places.add(place)
    asked = {place for place, (_, damping) in enumerate(true) if damping <= HEAVIEST}
    missed = tuple(true[place] for place in sorted(asked - places))
    return Count(len(asked), len(asked & places), len(found) - len(modes), missed)


def counts(result: RigResult, method: str) -> list[Count]:
    """One for each posture, its FRFs fitted together, nothing chosen by hand."""
    fits = fit(result.campaign, method, per="posture", choices=Choices(vary=False))
    return [counted(one.modes, true_modes(result, one.posture)) for one in fits]


LEAD = f"""\
Made by `benchmarks/ema_selection.py`: simulated campaigns in two postures drawn at random, two trials of
three blows, noise of 1 %, the effect hidden ten times the noise floor high; the FRFs of a posture fitted
together, nothing chosen by hand. True: modes of the structure that was struck, from 2 to 200 Hz, damped
up to {100 * HEAVIEST:.0f} %. Found: within half a half-power bandwidth, or 1 % where that is more, and
within a factor of two in damping, each once. False: every other."""
END = """\
What is missed are modes damped by a fifth and more, which hardly rise out of what surrounds them. The
six-link arm has such modes near the lowest line, and others damped beyond half of critical among them."""
METHODS = ("least-squares", "lscf")


def main() -> None:
    from tables import write

    rows = []
    total: dict[str, list[Count]] = {method: [] for method in METHODS}
    for seed, (name, hidden) in enumerate(CAMPAIGNS, start=1):
        result = campaign(name, hidden, random_postures(robot_of(name), 2, seed), seed)
        found = {method: counts(result, method) for method in METHODS}
        rows.append([f"{seed}, {name}, {hidden or 'nothing hidden'}", *cells(found)])
        for method in METHODS:
            total[method] += found[method]
    rows.append(["all", *cells(total)[:-1], ""])
    header = ["campaign, robot, hidden", "true", "least squares: found", "false", "LSCF: found", "false"]
    header.append("missed by LSCF: frequency, ζ")
    write("ema_selection", "Modes found without a person", LEAD.replace("\n", " "), header, rows,
          END.replace("\n", " "))  # fmt: skip


def cells(found: dict[str, list[Count]]) -> list[str]:
    """True ones, then found and false ones of each method, then what the last method missed."""
    row = [str(sum(one.true for one in found[METHODS[0]]))]
    for method in METHODS:
        row += [str(sum(one.found for one in found[method])), str(sum(one.false for one in found[method]))]
    missed = [mode for one in found[METHODS[-1]] for mode in one.missed]
    return [*row, ", ".join(f"{f:.3g} Hz {100 * z:.2g} %" for f, z in missed) or "–"]


if __name__ == "__main__":
    main()
