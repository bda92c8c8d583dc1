"""A line of a free function that ended in another minimum than its neighbours takes what they have."""

from __future__ import annotations

import numpy as np

from flexmodal.diagnosis.lawfree.model import Unknown
from flexmodal.diagnosis.lawfree.profile import Profile, State

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
    best = state
    for offered in offers(state.z):
        best = _bettered(profile, profile.with_functions(state.at, offered), best)
    cost = profile.by_line(best.residual, best.z)
    stuck = cost > STANDS_OUT * np.median(cost, axis=1, keepdims=True)
    if stuck.any():
        for offered in offers(best.z):
            other = profile.with_functions(state.at, np.where(stuck[:, None], offered, best.z))
            if np.isfinite(other.cost):
                best = _bettered(profile, profile.descended(other, AGAIN, held=True), best)
    return best if best.cost < state.cost else state


def _bettered(profile: Profile, other: State, best: State) -> State:
    """The best state with the functions of another one on lines where they cost less."""
    if not np.isfinite(other.cost):
        return best
    return profile.chosen(best, other, profile.serves(best, other))


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
