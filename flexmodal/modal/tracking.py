"""Which mode of one posture is which of another."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float, Int, Shaped

from flexmodal.errors import Fault, InvalidRequest
from flexmodal.modal.mac import mac


def track(
    frequency: Float[np.ndarray, " mode"],
    shape: Shaped[np.ndarray, "dof mode"] | None,
    next_frequency: Float[np.ndarray, " other"],
    next_shape: Shaped[np.ndarray, "dof other"] | None,
    *,
    shape_weight: float = 0.7,
    frequency_scale: float = 0.1,
    worst: float = 0.8,
) -> Int[np.ndarray, " mode"]:
    """Pair modes so that the sum of disagreements is least (the assignment problem, solved exactly).

    A pair disagrees by `w(1 − MAC) + (1 − w)(1 − exp(−(ln(f₂/f₁)/s)²))`, between 0 and 1.

    Args:
        frequency: natural frequencies [Hz], above 0.
        shape: shapes as columns; None where there are none, then frequencies alone decide.
        next_frequency: those of the other posture [Hz].
        next_shape: shapes there, in the same rows.
        shape_weight: w.
        frequency_scale: s, the relative change that counts as a large one.
        worst: pairs that disagree more are no pairs.

    Returns:
        For each mode the place of its partner, −1 where it has none.

    Raises:
        InvalidRequest: frequencies that are not above 0, weights out of range, or shapes that do not fit.
    """
    _check(frequency, next_frequency, shape_weight, frequency_scale, worst)
    gap = np.log(next_frequency[None, :] / frequency[:, None])
    cost = 1 - np.exp(-((gap / frequency_scale) ** 2))
    if shape is not None and next_shape is not None:
        cost = shape_weight * (1 - mac(shape, next_shape)) + (1 - shape_weight) * cost
    return assign(cost, worst)


def assign(cost: Float[np.ndarray, "mode other"], single: float) -> Int[np.ndarray, " mode"]:
    """Partners that make the sum of costs least, by `scipy.optimize.linear_sum_assignment`.

    Args:
        cost: of each pair.
        single: cost of staying without a partner.

    Returns:
        For each row the column of its partner, −1 where it has none.
    """
    partner = np.full(len(cost), -1)
    if cost.size:
        from scipy.optimize import linear_sum_assignment

        # As many dummy partners as modes.
        padded = np.concatenate([cost, np.full((len(cost), len(cost)), single)], axis=1)
        rows, columns = linear_sum_assignment(padded)
        real = columns < cost.shape[1]
        partner[rows[real]] = columns[real]
    return partner


def track_all(
    frequencies: Sequence[Float[np.ndarray, " _"]],
    shapes: Sequence[np.ndarray] | None = None,
    **policy: float,
) -> Int[np.ndarray, "posture track"]:
    """Follow modes over a sequence of postures, each posture paired with the one before.

    Args:
        frequencies: natural frequencies of each posture [Hz].
        shapes: shapes of each posture, or None.
        policy: as `track` takes it.

    Returns:
        For each posture the place of each track's mode, −1 where the track has none there. A track ends
        where its mode finds no partner; modes without a predecessor begin a new one.

    Raises:
        InvalidRequest: see `track`.
    """
    tracks: list[list[int]] = [[place] for place in range(len(frequencies[0]))] if frequencies else []
    for here in range(1, len(frequencies)):
        before = None if shapes is None else shapes[here - 1]
        now = None if shapes is None else shapes[here]
        partner = track(frequencies[here - 1], before, frequencies[here], now, **policy)
        for one in tracks:
            one.append(int(partner[one[-1]]) if one[-1] >= 0 else -1)
        fresh = sorted(set(range(len(frequencies[here]))) - set(partner.tolist()))
        tracks += [[-1] * here + [place] for place in fresh]
    return np.array(tracks, dtype=int).T.reshape(len(frequencies), len(tracks))


def _check(
    frequency: np.ndarray, other: np.ndarray, shape_weight: float, frequency_scale: float, worst: float
) -> None:
    faults = []
    for key, values in (("frequency", frequency), ("next_frequency", other)):
        if not np.all(np.isfinite(values) & (values > 0)):
            faults.append(Fault("call", key, "a value that is not above 0 Hz", "finite, above 0 Hz"))
    for key, value in (("shape_weight", shape_weight), ("worst", worst)):
        if not 0 <= value <= 1:
            faults.append(Fault("call", key, f"{value:g}", "between 0 and 1"))
    if not frequency_scale > 0:
        faults.append(Fault("call", "frequency_scale", f"{frequency_scale:g}", "above 0"))
    if faults:
        raise InvalidRequest(faults)
