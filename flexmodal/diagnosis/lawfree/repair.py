"""A line of a free function that ended in another minimum than its neighbours takes what they have."""

from __future__ import annotations

import numpy as np

from flexmodal.diagnosis.lawfree.model import Unknown
from flexmodal.diagnosis.lawfree.profile import Costs, Profile, State

STANDS_OUT, AGAIN = 10.0, 4
"""Times the median cost of lines beyond which one sets out again, and how many steps it is given."""


def repaired(profile: Profile, state: State) -> State:
    """Each line offered what its neighbours have or lead to, and the median around it.

    It takes what serves best. Lines that stand out then set out from there: beside a resonance a function has
    to be nearer to the true one than its neighbours are, if another minimum is not to be better.

    Args:
        profile: in which the fit goes on.
        state: where it has come to.
    """
    z, best = state.z, profile.by_line(state.residual, state.z)
    for offered in offers(state.z):
        z, best = _bettered(profile, profile.with_functions(state.at, offered), z, best)
    stuck = best > STANDS_OUT * np.median(best, axis=1, keepdims=True)
    if stuck.any():
        for offered in offers(z):
            other = profile.with_functions(state.at, np.where(stuck[:, None], offered, z))
            if np.isfinite(other.cost):
                z, best = _bettered(profile, profile.descended(other, AGAIN, held=True), z, best)
    found = profile.with_functions(state.at, z)
    return found if found.cost < state.cost else state


def _bettered(profile: Profile, other: State, z: Unknown, best: Costs) -> tuple[Unknown, Costs]:
    """Functions and costs line by line: those of another state where it costs less."""
    if not np.isfinite(other.cost):
        return z, best
    cost = profile.by_line(other.residual, other.z)
    better = cost < best
    return np.where(better[:, None], other.z, z), np.where(better, cost, best)


def offers(z: Unknown) -> list[Unknown]:
    """What is above and below on the axis, what these and the next two lead to, and the median of five lines.

    At an end of the axis there is no neighbour beyond, and where a function is steep the one neighbour is not
    near enough; a straight line through two is.
    """
    left, right = (
        np.concatenate([z[..., :1], z[..., :-1]], axis=-1),
        np.concatenate([z[..., 1:], z[..., -1:]], axis=-1),
    )
    wide = np.pad(z, [(0, 0), (0, 0), (2, 2)], mode="edge")
    stack = np.stack([wide[..., k : k + z.shape[-1]] for k in range(5)])
    return [left, right, *_led_to(z), np.median(stack.real, axis=0) + 1j * np.median(stack.imag, axis=0)]


def _led_to(z: Unknown) -> list[Unknown]:
    """Straight lines through the two lines below and the two above; where there are none, what is there."""
    up, down = z.copy(), z.copy()
    up[..., 2:] = 2 * z[..., 1:-1] - z[..., :-2]
    down[..., :-2] = 2 * z[..., 1:-1] - z[..., 2:]
    return [up, down]
