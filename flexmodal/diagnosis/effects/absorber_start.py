"""An absorber laid beside the free functions of a link: what its search sets out from.

A mass m on a spring k(1 + 2iζω/ω₀) acts along its direction as the dynamic stiffness −ω²m·k/(k − ω²m), and as
−ω²m where it is not free (den Hartog, Mechanical Vibrations, 1956, chapter 3).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
from jaxtyping import Bool, Complex, Float
from scipy.optimize import least_squares

from flexmodal.diagnosis.effects.absorber_further import FASTER, FOOT, FURTHER
from flexmodal.diagnosis.effects.absorber_ways import ways_of
from flexmodal.diagnosis.effects.free_function import FreeFunction

_SETS_OUT = 12
"""Frequencies, over the band."""
_FASTER = 1.7
"""Frequency of another mass, over that of the first."""
_BESIDE: tuple[tuple[float | None, float | None], ...] = (
    (None, 0.4),
    (None, 2.5),
    (0.6, None),
    (_FASTER, None),
)
"""Frequency of another mass over that of the first, or the stiffness across over that along: one of them."""
_STIFF, _NOTHING = 1e3, 0.003
"""Stiffness across, over that along, of a mass that is free along one direction; the other mass if there is
none, over the first."""
BEYOND = (FURTHER, FASTER, FOOT)
"""Names of what the wider law has besides."""
_FURTHER_STARTS, _NO_FURTHER = ((0.1, 3.0, 0.05), (0.4, 6.0, 0.05)), (1e-4, 10.0, 1e-5)
"""Of these: from what a fit with them starts, a line and a beam, and where they do nothing."""
_ROLL = 5
"""Number of the roll among the unknowns, in space."""
_ROLLS = (0.0, np.pi / 4, np.pi / 2, 3 * np.pi / 4)
"""Of the second direction about the first: from the first of them the nearest is not found where the second
lies across the link, for nothing tells to which side to roll."""
_NEGLIGIBLE = 0.1
"""Another mass, over the first, that plays no part."""
_LEAST = 1e-12
"""Moment of inertia that nothing is measured by [kg·m²]."""
_LOSSES = (0.02, 0.1)
NEAR = 0.15
"""Distance of lines from a frequency that are looked at together: a logarithm."""
OUTLYING = 0.3
"""From what part of the mass a line counts for less: where nothing depends on it, it may be anywhere."""
FEW, MANY = 12, 50
"""Steps from each start, and of the best of them."""


def effective_mass(
    omega: Float[np.ndarray, " line"], x: Float[np.ndarray, " unknown"], angles: int
) -> Complex[np.ndarray, "line way way"]:
    """−1/ω² times the dynamic stiffness, along the link and across it [kg].

    Args:
        omega: lines [rad/s].
        x: logarithms of mass, frequency [rad/s], damping ratio; angles; logarithms of the stiffness across
            over that along, of the other mass over the first, and of its frequency over that of the first;
            perhaps of a further mass over the first, of its frequencies over those of the first, and of a
            mass that does not swing over the first.
        angles: one in the plane, three in space.
    """
    mass, own, ratio = np.exp(x[:3])
    across, other, faster, *more = np.exp(x[3 + angles :])
    ways = ways_of(x[3 : 3 + angles])
    found = np.zeros((len(omega), len(ways)), dtype=complex)
    moving: list[tuple[float, tuple[float | None, ...]]] = [
        (mass, (own, np.sqrt(across) * own)),
        (other * mass, (None, faster * own)),
    ]
    if more:
        further, times, foot = more
        moving += [(further * mass, (times * own, times * np.sqrt(across) * own)), (foot * mass, ())]
    for size, moves in moving:
        for k, _ in enumerate(ways):
            free = moves[k] if k < len(moves) else None
            if free is None:
                found[:, k] += size
            else:
                spring = free**2 + 2j * ratio * free * omega
                found[:, k] += size * spring / (spring - omega**2)
    return np.einsum("lk,ka,kb->lab", found, ways, ways)


@dataclass(frozen=True, eq=False)
class _Laid:
    """Free functions, and absorbers within bounds to be laid beside them."""

    omega: Float[np.ndarray, " line"]
    target: Complex[np.ndarray, "line way way"]
    """Effective mass [kg]."""
    scale: float
    """Of it."""
    low: Float[np.ndarray, " unknown"]
    high: Float[np.ndarray, " unknown"]

    @property
    def angles(self) -> int:
        """How many directions are unknown."""
        return 1 if self.target.shape[-1] == 2 else 3

    def far(self, x: Float[np.ndarray, " unknown"]) -> Float[np.ndarray, " value"]:
        """How far an absorber is from the functions."""
        gap = ((effective_mass(self.omega, x, self.angles) - self.target) / self.scale).ravel()
        return np.concatenate([gap.real, gap.imag])

    def nearest(
        self, start: Float[np.ndarray, " unknown"], free: Bool[np.ndarray, " unknown"], steps: int
    ) -> tuple[float, Float[np.ndarray, " unknown"]]:
        """Cost and unknowns of the nearest from a start, some of these free."""
        start = np.clip(start, self.low + 1e-9, self.high - 1e-9)

        def full(part: np.ndarray) -> np.ndarray:
            x = start.copy()
            x[free] = part
            return x

        made = least_squares(
            lambda part: self.far(full(part)), start[free], bounds=(self.low[free], self.high[free]),
            loss="soft_l1", f_scale=OUTLYING, max_nfev=steps,
        )  # fmt: skip
        return float(made.cost), full(made.x)


def told_by(
    free: FreeFunction, lower: Mapping[str, float], upper: Mapping[str, float]
) -> list[dict[str, float]]:
    """Parameters of absorbers whose dynamic stiffness is nearest to free functions.

    Args:
        free: of a body port.
        lower: of each parameter of the effect; those of `BEYOND` where it has them.
        upper: likewise.

    Returns:
        One that is free along one direction, and one that does more; none where the functions are nothing.
    """
    some = free.frequency > 0
    omega = 2 * np.pi * free.frequency[some]
    target = -free.tensor[some] / omega[:, None, None] ** 2
    turned = ("angle",) if target.shape[-1] == 2 else ("angle", "turn", "roll")
    further = tuple(name for name in BEYOND if name in lower)
    names = ("mass", "frequency", "damping_ratio", *turned, "across_ratio", "other", "other_ratio", *further)
    scale = float(np.median(np.abs(np.einsum("laa->l", target)))) / target.shape[-1]
    if not np.isfinite(target).all() or scale <= 0:
        return []
    low, high = (
        np.array([one[name] if name in turned else np.log(one[name]) for name in names])
        for one in (lower, upper)
    )
    low[1], high[1] = low[1] + np.log(2 * np.pi), high[1] + np.log(2 * np.pi)
    laid = _Laid(omega, target, scale, low, high)
    beside = ("roll", "across_ratio", "other", "other_ratio", *BEYOND)
    simple, narrow = (np.array([name not in left for name in names]) for left in (beside, BEYOND))
    tried = [laid.nearest(start, simple, FEW) for start in _starts(laid)]
    first = laid.nearest(min(tried, key=lambda one: one[0])[1], simple, MANY)[1]
    wider = [laid.nearest(start, narrow, MANY) for start in _wider(first, laid.angles)]
    found = [first, min(wider, key=lambda one: one[0])[1]]
    if further:
        found = [min(_furthered(laid, x), key=lambda one: one[0])[1] for x in found]
    found = [softer_first(x, laid.angles) for x in found]
    return [_values(names, turned, x) for x in found]


def turning_by(
    omega: Float[np.ndarray, " line"],
    turns: Complex[np.ndarray, "line turn turn"],
    values: Mapping[str, float],
) -> tuple[float, float, float]:
    """What swings by turning at the place of an absorber, beside what turns with the link.

    Args:
        omega: lines [rad/s].
        turns: dynamic stiffness against turning there [N·m/rad].
        values: of the absorber.

    Returns:
        Its radius of gyration with the absorber's mass [m], its frequency over that of the absorber, and the
        radius of gyration of what does not swing.
    """
    loss, own = 2j * values["damping_ratio"], 2 * np.pi * values["frequency"]
    angles = [values[name] for name in ("angle", "turn", "roll") if name in values]
    about = ways_of(np.array(angles))[:2]
    inertia = -turns / omega[:, None, None] ** 2
    each = (
        inertia[:, :, 0] if len(angles) == 1 else np.einsum("ka,lab,kb->lk", about, inertia, about)[:, ::-1]
    )
    faster = np.sqrt(values["across_ratio"]) if len(angles) > 1 else 1.0
    scale = max(float(np.median(np.abs(each))), _LEAST)

    def far(x: Float[np.ndarray, "3"]) -> Float[np.ndarray, " value"]:
        size, still, at = np.exp(x)
        moves = at * np.array([1.0, faster])[: each.shape[1]]
        spring = moves**2 + loss * moves * omega[:, None]
        gap = (size * spring / (spring - omega[:, None] ** 2) + still - each) / scale
        return np.concatenate([gap.real.ravel(), gap.imag.ravel()])

    tried = [
        least_squares(far, np.log([scale, 0.1 * scale, at]), loss="soft_l1", f_scale=OUTLYING, max_nfev=MANY)
        for at in np.geomspace(omega[0], omega[-1], _SETS_OUT)
    ]
    size, still, at = np.exp(min(tried, key=lambda one: one.cost).x)
    return float(np.sqrt(size / values["mass"])), float(at / own), float(np.sqrt(still / values["mass"]))


def softer_first(x: Float[np.ndarray, " unknown"], angles: int) -> Float[np.ndarray, " unknown"]:
    """The same absorber, its softer direction the first one; as it is where another mass swings.

    Args:
        x: see `effective_mass`.
        angles: one in the plane, three in space.
    """
    across, other = np.exp(x[3 + angles : 5 + angles])
    if across >= 1 or other > _NEGLIGIBLE:
        return x
    second, first = ways_of(x[3 : 3 + angles])[:2]
    first = -first if first[1] < 0 else first
    turned = [float(np.arcsin(np.clip(first[0], -1.0, 1.0)))]
    if angles == 3:
        turned += [float(np.arctan2(first[2], first[1])), 0.0]
        _, level, upright = ways_of(np.array(turned))
        turned[2] = float(np.arctan2(second @ upright, second @ level))
    found = x.copy()
    found[1] += np.log(across) / 2
    found[3 : 3 + angles], found[3 + angles] = turned, -np.log(across)
    return found


def _furthered(
    laid: _Laid, x: Float[np.ndarray, " unknown"]
) -> list[tuple[float, Float[np.ndarray, " unknown"]]]:
    """With a further mass, from some."""
    starts = [np.concatenate([x[: -len(BEYOND)], np.log(one)]) for one in _FURTHER_STARTS]
    return [laid.nearest(start, np.ones(len(x), dtype=bool), MANY) for start in starts]


def _wider(first: Float[np.ndarray, " unknown"], angles: int) -> list[Float[np.ndarray, " unknown"]]:
    """With a second mass, or with the first free along two directions."""
    found = []
    in_space = angles == 3
    for (faster, across), roll in product(_BESIDE, _ROLLS if in_space else (0.0,)):
        x = first.copy()
        if in_space:
            x[_ROLL] = roll
        if across is not None:
            x[3 + angles] = np.log(across)
        if faster is not None:
            x[4 + angles : 6 + angles] = np.log(0.7), np.log(faster)
        found.append(x)
    return found


def _starts(laid: _Laid) -> list[Float[np.ndarray, " unknown"]]:
    """At frequencies over the band, each along the direction in which most is lost there."""
    found = []
    for own in np.geomspace(laid.omega[0], laid.omega[-1], _SETS_OUT):
        here = np.abs(np.log(laid.omega / own)) < NEAR
        lost = -laid.target[here if here.any() else slice(None)].imag.mean(axis=0)
        way = np.linalg.eigh(lost)[1][:, -1]
        if laid.angles == 1 and way[1] < 0:
            way = -way
        turned = [float(np.arcsin(np.clip(way[0], -1.0, 1.0)))]
        if laid.angles == 3:
            turned += [float(np.arctan2(way[2], way[1])), 0.0]
        for loss in _LOSSES:
            begin = [np.log(laid.scale), np.log(own), np.log(loss)]
            plain = [*begin, *turned, np.log(_STIFF), np.log(_NOTHING), np.log(_FASTER)]
            found.append(np.array([*plain, *np.log(_NO_FURTHER)][: len(laid.low)]))
    return found


def _values(names: Sequence[str], turned: Sequence[str], x: np.ndarray) -> dict[str, float]:
    values = {name: float(v if name in turned else np.exp(v)) for name, v in zip(names, x, strict=True)}
    return {**values, "frequency": values["frequency"] / (2 * np.pi)}
