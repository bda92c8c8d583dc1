"""The loop of `kernel` in numpy, a step at a time for all blows at once: where numba is not installed."""

from __future__ import annotations

import numpy as np
from jaxtyping import Float, Int

from flexmodal.diagnosis.time_domain.law import FRICTION, HARDENING, KNEE, SLOW
from flexmodal.diagnosis.time_domain.law_kernel import SLOW_WAY
from flexmodal.diagnosis.time_domain.settle_kernel import CLOSE, ROUNDS, STUBBORN


def integrate(
    turn: Float[np.ndarray, "tile state lane"],
    cross: Float[np.ndarray, "tile state lane"],
    carried: Float[np.ndarray, "tile law state lane"],
    late: Float[np.ndarray, "tile law state lane"],
    rows: Float[np.ndarray, "tile law state lane"],
    gain: Float[np.ndarray, "tile law law lane"],
    kinds: Int[np.ndarray, " law"],
    parameters: Float[np.ndarray, "tile law 8 lane"],
    push: Float[np.ndarray, "tile step state lane"],
    torque: Float[np.ndarray, "tile lane law time"],
    last: Float[np.ndarray, "tile state lane"],
) -> None:
    """See `kernel.integrate` for the arguments."""
    turn, cross, carried, late, rows, gain, parameters, push = (
        np.moveaxis(a, -1, 1).reshape(-1, *a.shape[1:-1])
        for a in (turn, cross, carried, late, rows, gain, parameters, push)
    )
    other = np.arange(turn.shape[1]) ^ 1
    now = np.zeros_like(turn)
    held, before, old, size, stuck, stuck_before = (np.zeros(gain.shape[:2]) for _ in range(6))
    lag = np.where(kinds == FRICTION, parameters[:, :, 5], 0.0)
    found = torque.reshape(len(turn), *torque.shape[2:])
    for k in range(torque.shape[3] - 1):
        base = turn * now + cross * now[:, other] - np.einsum("bl,bli->bi", held, carried)
        if k < push.shape[1]:
            base += push[:, k]
        free = np.einsum("bli,bi->bl", rows, base)
        end = free - np.einsum("blm,bm->bl", gain, 2 * held - before)
        known = lag * (2 * stuck - 0.5 * stuck_before)
        end, after = _settle(free, end, gain, kinds, parameters, old, stuck, lag, known, size)
        stuck, stuck_before = (after + known) / (1 + 1.5 * lag), stuck
        now, old, before, held = base, end, held, after
        found[:, :, k + 1] = held
    now = now - np.einsum("bl,bli->bi", held, late)
    last[:] = np.moveaxis(now.reshape(len(last), -1, now.shape[1]), 1, 2)


def _settle(
    free: np.ndarray, end: np.ndarray, gain: np.ndarray, kinds: np.ndarray, parameters: np.ndarray,
    old: np.ndarray, stuck: np.ndarray, lag: np.ndarray, known: np.ndarray, size: np.ndarray,
) -> tuple[np.ndarray, np.ndarray]:  # fmt: skip
    """Elongations and torques at the end of a step; blows that are settled wait for the others."""
    guess, grown = np.zeros_like(end), 1 + 1.5 * lag
    active = np.ones(len(free), dtype=bool)
    for turn in range(ROUNDS):
        found = [
            law(int(kind), parameters[:, k], old[:, k], end[:, k], stuck[:, k])
            for k, kind in enumerate(kinds)
        ]
        value, slope = (grown * np.stack(each, axis=1) for each in zip(*found, strict=True))
        value -= known
        matrix = np.eye(len(kinds)) + gain * slope[:, None, :]
        miss = free - end - np.einsum("blm,bm->bl", gain, value)
        change = np.linalg.solve(matrix, miss[..., None])[..., 0] * (0.5 if turn >= STUBBORN else 1.0)
        change = np.where(active[:, None], change, 0.0)
        end += change
        guess = np.where(active[:, None], value + slope * change, guess)
        np.maximum(size, np.abs(end), out=size)
        active &= np.any(np.abs(change) > CLOSE * size, axis=1)
        if not active.any():
            break
    return end, guess


def law(
    kind: int,
    p: Float[np.ndarray, "blow 8"],
    old: Float[np.ndarray, " blow"],
    new: Float[np.ndarray, " blow"],
    memory: Float[np.ndarray, " blow"],
) -> tuple[Float[np.ndarray, " blow"], Float[np.ndarray, " blow"]]:
    """Torques at elongations and their derivatives.

    Args:
        kind: code of the law, see `law`.
        p: its parameters, of friction the speed in elongation per step; what sticks damps elsewhere.
        old: elongations one step ago.
        new: elongations now; of a law by speed that speed.
        memory: torques one step ago.
    """
    if kind == SLOW:
        part = np.tanh(new / p[:, 1])
        return p[:, 0] * part, p[:, 0] / p[:, 1] * (1 - part**2)
    if kind == HARDENING:
        ratio, rest = ((new + p[:, 2]) / p[:, 1]) ** 2, (p[:, 2] / p[:, 1]) ** 2
        part = ratio / (1 + ratio)
        torque = p[:, 0] * ((new + p[:, 2]) * part - p[:, 2] * rest / (1 + rest)) + p[:, 3] * new
        return torque, p[:, 0] * part * (3 + ratio) / (1 + ratio) + p[:, 3]
    if kind == KNEE:
        (held, _), (torque, slope) = _bent(p, p[:, 2]), _bent(p, new + p[:, 2])
        return p[:, 0] * (torque - held) + p[:, 3] * new, p[:, 0] * slope + p[:, 3]
    moved = new - old
    most = p[:, 0] * (1 + p[:, 3] * np.exp(-((moved / p[:, 4]) ** 2)))
    most = most + p[:, 6] * np.abs((old + new) / 2 + p[:, 7])
    limit = np.where(moved >= 0, most, -most)
    share = 1 - memory / limit  # of the way to sliding that is left; negative where the limit has fallen
    way, power = p[:, 1] * np.abs(moved) / most, 1 - p[:, 2]
    smooth = np.abs(power) < 1e-9
    root = np.where(smooth, 1.0, power)
    with np.errstate(divide="ignore", invalid="ignore"):
        left = np.where(share != 0, np.abs(share) ** root - root * way, 0.0)
        size = np.where(smooth, np.abs(share) * np.exp(-way), np.where(left > 0, left ** (1 / root), 0.0))
        ratio = np.where(size > 0, size ** p[:, 2], 0.0)
        followed = (1 + np.exp(-way)) / 2 + np.expm1(-way) / way
    followed = np.where(way < SLOW_WAY, way**2 / 12, followed) * np.where(smooth, 1.0, p[:, 2])
    start, middle, end = (np.abs(one + p[:, 7]) for one in (old, (old + new) / 2, new))
    grows = np.where(smooth | (size > 0), followed * (end - start), end - middle)
    grows = p[:, 6] * np.where(moved >= 0, grows, -grows)
    sign = np.sign(share)
    outward = np.where((moved >= 0) == (new + p[:, 7] >= 0), p[:, 6], -p[:, 6])
    slope = np.where(share > 0, p[:, 1] * ratio + outward * (1 - size) * (1 - ratio), 0.0)
    return limit - limit * sign * size + grows, slope


def _bent(
    p: Float[np.ndarray, "blow 8"], u: Float[np.ndarray, " blow"]
) -> tuple[Float[np.ndarray, " blow"], Float[np.ndarray, " blow"]]:
    """Of a knee at elongations from no load the torque over A, and its slope."""
    low, high = u - p[:, 1], u + p[:, 1]
    near, far = np.hypot(low, p[:, 4]), np.hypot(high, p[:, 4])
    return u * (1 - 2 * p[:, 1] / (near + far)), 1 + (low / near - high / far) / 2
