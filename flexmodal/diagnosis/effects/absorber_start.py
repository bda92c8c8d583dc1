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
_ROLL = 5
"""Number of the roll among the unknowns, in space."""
_ROLLS = (0.0, np.pi / 4, np.pi / 2, 3 * np.pi / 4)
"""Of the second direction about the first: from the first of them the nearest is not found where the second
lies across the link, for nothing tells to which side to roll."""
_LOSSES = (0.02, 0.1)
NEAR = 0.15
"""Distance of lines from a frequency that are looked at together: a logarithm."""
OUTLYING = 0.3
"""From what part of the mass a line counts for less: where nothing depends on it, it may be anywhere."""
FEW, MANY = 12, 50
"""Steps from each start, and of the best of them."""


def ways_of(angles: Float[np.ndarray, " angle"]) -> Float[np.ndarray, "way axis"]:
    """Directions in which an absorber gives, and the one in which it does not.

    Args:
        angles: out of the plane across the link; in space also about the link, and about the first direction.

    Returns:
        Along the link and across it; the first two give.
    """
    cosine, sine = np.cos(angles[0]), np.sin(angles[0])
    if len(angles) == 1:
        return np.array([[sine, cosine], [cosine, -sine]])
    side = np.array([0.0, np.cos(angles[1]), np.sin(angles[1])])
    axis = np.array([1.0, 0.0, 0.0])
    first, second = cosine * side + sine * axis, cosine * axis - sine * side
    third = np.cross(first, second)
    cosine, sine = np.cos(angles[2]), np.sin(angles[2])
    return np.array([first, cosine * second + sine * third, cosine * third - sine * second])


def effective_mass(
    omega: Float[np.ndarray, " line"], x: Float[np.ndarray, " unknown"], angles: int
) -> Complex[np.ndarray, "line way way"]:
    """−1/ω² times the dynamic stiffness, along the link and across it [kg].

    Args:
        omega: lines [rad/s].
        x: logarithms of mass, frequency [rad/s], damping ratio; angles; logarithms of the stiffness across
            over that along, of the other mass over the first, and of its frequency over that of the first.
        angles: one in the plane, three in space.
    """
    mass, own, ratio = np.exp(x[:3])
    across, other, faster = np.exp(x[3 + angles :])
    ways = ways_of(x[3 : 3 + angles])
    found = np.zeros((len(omega), len(ways)), dtype=complex)
    for size, moves in ((mass, (own, np.sqrt(across) * own)), (other * mass, (None, faster * own))):
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
        lower: of each parameter of the effect.
        upper: likewise.

    Returns:
        One that is free along one direction, and one that does more; none where the functions are nothing.
    """
    some = free.frequency > 0
    omega = 2 * np.pi * free.frequency[some]
    target = -free.tensor[some] / omega[:, None, None] ** 2
    turned = ("angle",) if target.shape[-1] == 2 else ("angle", "turn", "roll")
    names = ("mass", "frequency", "damping_ratio", *turned, "across_ratio", "other", "other_ratio")
    scale = float(np.median(np.abs(np.einsum("laa->l", target)))) / target.shape[-1]
    if not np.isfinite(target).all() or scale <= 0:
        return []
    low, high = (
        np.array([one[name] if name in turned else np.log(one[name]) for name in names])
        for one in (lower, upper)
    )
    low[1], high[1] = low[1] + np.log(2 * np.pi), high[1] + np.log(2 * np.pi)
    laid = _Laid(omega, target, scale, low, high)
    simple = np.array([name not in ("roll", "across_ratio", "other", "other_ratio") for name in names])
    tried = [laid.nearest(start, simple, FEW) for start in _starts(laid)]
    first = laid.nearest(min(tried, key=lambda one: one[0])[1], simple, MANY)[1]
    wider = [laid.nearest(start, np.ones_like(simple), MANY) for start in _wider(first, laid.angles)]
    return [_values(names, turned, x) for x in (first, min(wider, key=lambda one: one[0])[1])]


def _wider(first: Float[np.ndarray, " unknown"], angles: int) -> list[Float[np.ndarray, " unknown"]]:
    """With a second mass, or with the first free along two directions."""
    found = []
    in_space = angles == 3
    for (faster, across), roll in product(_BESIDE, _ROLLS if in_space else (0.0,)):
        x = first.copy()
        if in_space:
            x[_ROLL] = roll
        if across is not None:
            x[-3] = np.log(across)
        if faster is not None:
            x[-2:] = np.log(0.7), np.log(faster)
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
            found.append(np.array([*begin, *turned, np.log(_STIFF), np.log(_NOTHING), np.log(_FASTER)]))
    return found


def _values(names: Sequence[str], turned: Sequence[str], x: np.ndarray) -> dict[str, float]:
    values = {name: float(v if name in turned else np.exp(v)) for name, v in zip(names, x, strict=True)}
    return {**values, "frequency": values["frequency"] / (2 * np.pi)}
