"""What an examiner hides: effects, heights and parameter errors, drawn from a seed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from flexmodal.errors import Fault, InvalidRequest
from flexmodal.model import Robot
from flexmodal.rig.effects import EFFECTS
from flexmodal.rig.hidden.hide import HIGHEST, Hide, hide_places

HEIGHTS = (3.0, 30.0)
"""Times the noise floor."""
PARAMETER_ERRORS = (0.02, 0.08)
"""Standard deviation of the logarithm of a parameter, true over believed."""


@dataclass(frozen=True)
class Scenario:
    """Arguments of `simulate`: what to hide, and how far the parameters are off."""

    hide: tuple[Hide, ...]
    """Places are left open: they are drawn from the seed of the campaign, among those where the effect stands
    within the heights."""
    parameter_error: float


def draw_scenario(
    robot: Robot,
    seed: int,
    *,
    count: int = 1,
    effects: Sequence[str] | None = None,
    points: int | None = None,
    heights: tuple[float, float] = HEIGHTS,
    parameter_errors: tuple[float, float] = PARAMETER_ERRORS,
) -> Scenario:
    """Draw what to hide in a campaign.

    Args:
        robot: the robot.
        seed: of what is drawn here; other numbers are drawn than from the same seed in `simulate`.
        count: how many effects, each another.
        effects: to choose from, all alike; every catalogued one that has a place on the robot if None.
        points: how many points carry a sensor, as in `simulate`; all if None.
        heights: lowest and highest multiple of the noise floor; drawn evenly on a logarithmic scale.
        parameter_errors: lowest and highest standard deviation of the logarithm of a parameter.

    Raises:
        InvalidRequest: unknown effects, more of them than there are, ranges upside down.
    """
    there = [name for name, places in hide_places(robot, points=points).items() if places]
    pool = [name for name in there if EFFECTS[name].catalogued] if effects is None else list(effects)
    faults = [
        Fault("call", "effects", f"{name!r}", f"an effect with a place on {robot.name}: {', '.join(there)}")
        for name in pool
        if name not in there
    ]
    if seed < 0:
        faults.append(Fault("call", "seed", str(seed), "0 or more"))
    if not 0 <= count <= len(set(pool)):
        faults.append(
            Fault("call", "count", str(count), f"0 to {len(set(pool))}, as many as there are effects")
        )
    for name, (low, high), least, most in (
        ("heights", heights, 0.0, HIGHEST),
        ("parameter_errors", parameter_errors, -1.0, 0.5),
    ):
        if not least < low <= high <= most or low < 0:
            faults.append(Fault("call", name, f"{low:g} to {high:g}", f"the lower first, at most {most:g}"))
    if faults:
        raise InvalidRequest(faults)
    random = np.random.default_rng([seed, 6])
    error = float(random.uniform(*parameter_errors))
    chosen = random.choice(sorted(set(pool)), size=count, replace=False) if count else ()
    return Scenario(tuple(Hide(str(name), height=heights) for name in chosen), error)
