"""Stability of the interrupted cut from a receptance alone: several harmonics, and the criterion of Nyquist.

A perturbation exp(iωt) of a cut of tooth period T vibrates at ω + 2πs/T for all whole s. With the Fourier
coefficients W_k of the directional matrix, its parts r_s obey `r_s = a (1 − exp(−iωT)) Φ(ω + 2πs/T) Σ_m
W_{s−m} r_m` (Budak and Altintas, Journal of Dynamic Systems, Measurement and Control 120 (1998) 22; Merdol
and Altintas, Journal of Manufacturing Science and Engineering 126 (2004) 459). Instead of iterating on ω we
count: as ω runs from 0 to π/T, the phase of the determinant of that system grows by π for each unstable
Floquet exponent (Nyquist; for the zero-order system Eynian and Altintas 2009). At ω = 0 the determinant is 1;
at π/T, where period doubling sets in, it is real because the harmonics −h−1 … h pair off. The cut-off is thus
exact in phase.

It needs no mass and stiffness, so a measured receptance will do. No step of it is shared with
semi-discretisation.
"""

from __future__ import annotations

import numpy as np
from jaxtyping import Complex, Float

from flexmodal.errors import Fault, FlexmodalError, InvalidRequest
from flexmodal.machining.cut import Cut
from flexmodal.machining.stability.directional import chip_axes, harmonics, helix_lag
from flexmodal.machining.stability.first_loss import first_loss, searches
from flexmodal.machining.stability.lobes import Lobes, unfolded
from flexmodal.machining.tip_receptance import TipReceptance

_FEWEST, _MOST = 6, 60
_BEYOND = 1.3
"""The harmonics reach this many times the highest natural frequency, and two further."""
_PULSE = 2.0
"""They reach this many times over the spectrum of a tooth's pulse: 1 over the part of the period it cuts."""
_TURN = 0.7
"""Most the determinant may turn between two lines [rad]."""
_ROUNDS = 30


class HillDeterminant:
    """The determinant at one spindle speed; the lines it was evaluated at are kept from depth to depth."""

    def __init__(self, tip: TipReceptance, cut: Cut, spindle_speed: float, count: int | None = None) -> None:
        self.tip, self.cut = tip, cut
        self.period = cut.tooth_period(spindle_speed)
        count = _enough(tip, cut, spindle_speed) if count is None else count
        self.orders = np.arange(-count - 1, count + 1)
        self.axes = chip_axes(cut)
        self.line = self._first_lines()
        self.shaken = self._receptances(self.line)

    def unstable(self, depth: float) -> int:
        """How many Floquet exponents are unstable at a depth [m].

        Raises:
            FlexmodalError: the phase cannot be followed: the depth is unstable by a hair.
        """
        weights = self._weights(depth)
        value = self._determinant(self.shaken, self.line, weights, depth)
        for _ in range(_ROUNDS):
            turn = np.angle(value[1:] / value[:-1])
            coarse = (np.abs(turn) > _TURN) & (np.diff(self.line) > 1e-13 / self.period)
            if not np.any(coarse):
                return abs(round(float(np.sum(turn)) / np.pi))
            between = (self.line[1:][coarse] + self.line[:-1][coarse]) / 2
            fresh = self._receptances(between)
            value = np.concatenate([value, self._determinant(fresh, between, weights, depth)])
            order = np.argsort(np.concatenate([self.line, between]))
            self.line = np.concatenate([self.line, between])[order]
            self.shaken = np.concatenate([self.shaken, fresh])[order]
            value = value[order]
        raise FlexmodalError(f"the stability at {depth:g} m cannot be told: a multiplier has the size 1")

    def weakest(self, depth: float) -> float:
        """Line in 0 … 1/2T where the determinant is nearest to 0: at the limit, that of the chatter [Hz]."""
        value = self._determinant(self.shaken, self.line, self._weights(depth), depth)
        return float(self.line[1:][np.argmin(np.abs(value[1:]))])

    def _first_lines(self) -> Float[np.ndarray, " line"]:
        """An even grid, and the tip's resonances folded into 0 … 1/2T [Hz]."""
        half, lines = 0.5 / self.period, self.tip.resonances
        folded = np.abs(lines - np.round(lines * self.period) / self.period)
        even = np.linspace(0.0, half, 25)
        return np.unique(np.concatenate([even, np.round(folded / half, 5) * half]))

    def _receptances(self, line: np.ndarray) -> Complex[np.ndarray, "line order axis 3"]:
        frequency = line[:, None] + self.orders / self.period
        ordered, back = np.unique(np.abs(frequency), return_inverse=True)
        value = self.tip.receptance(ordered)[back.reshape(frequency.shape)][..., : self.axes, :]
        return np.where((frequency < 0)[..., None, None], value.conj(), value)

    def _weights(self, depth: float) -> Complex[np.ndarray, "order order 3 axis"]:
        smeared = depth if helix_lag(self.cut, depth) else 0.0
        span = self.orders[-1] - self.orders[0]
        series = harmonics(self.cut, np.arange(-span, span + 1), smeared)[:, :, : self.axes]
        return series[span + self.orders[:, None] - self.orders[None, :]]

    def _determinant(
        self, shaken: np.ndarray, line: np.ndarray, weights: np.ndarray, depth: float
    ) -> Complex[np.ndarray, " line"]:
        size = len(self.orders) * self.axes
        product = np.einsum("lsij,smjk->lsimk", shaken, weights, optimize=True)
        product = product.reshape(len(line), size, size)
        delay = depth * (1 - np.exp(-2j * np.pi * line * self.period))
        return np.linalg.det(np.eye(size) - delay[:, None, None] * product)


def multi_frequency(
    tip: TipReceptance, cut: Cut, speed: Float[np.ndarray, " speed"], *, count: int | None = None
) -> Lobes:
    """Stability limit at each spindle speed; the zero-order solution says where to begin.

    Args:
        tip: receptance of the tip in the frame of the cut.
        cut: the cut.
        speed: ascending [rev/min].
        count: h, harmonics on each side; enough to pass the highest natural frequency if none.

    Raises:
        InvalidFrequencies: a measured receptance does not reach up to the harmonics.
        InvalidRequest: more than sixty harmonics would be needed.
        SingularResponse: a mode that the tip sees has no damping.
    """
    depth, chatter = np.full(len(speed), np.inf), np.full(len(speed), np.nan)
    lobe, flip = np.full(len(speed), -1), np.zeros(len(speed), dtype=bool)
    for place, (one, search) in enumerate(zip(speed.tolist(), searches(tip, cut, speed), strict=True)):
        hill = HillDeterminant(tip, cut, one, count)
        depth[place] = first_loss(
            lambda tried, hill=hill: hill.unstable(tried) > 0,  # type: ignore[misc]
            search,
        )
        if np.isfinite(depth[place]):
            base = hill.weakest(float(depth[place]))
            chatter[place], lobe[place], flip[place] = unfolded(base, hill.period, search.near)
    return Lobes(cut, "multi-frequency", speed, depth, chatter, lobe, flip)


def _enough(tip: TipReceptance, cut: Cut, spindle_speed: float) -> int:
    """Harmonics that pass the highest resonance and the pulse, and stay within a measurement."""
    period = cut.tooth_period(spindle_speed)
    part = (cut.engagement.exit - cut.engagement.entry) * cut.cutter.teeth / (2 * np.pi)
    count = max(_FEWEST, int(np.ceil(_BEYOND * tip.resonances[-1] * period)) + 2, int(np.ceil(_PULSE / part)))
    if np.isfinite(tip.highest):
        count = min(count, max(1, int(np.floor(tip.highest * period)) - 1))
    if count > _MOST:
        found = f"{spindle_speed:g} rev/min, where {count} harmonics would be needed"
        allowed = f"speeds that need at most {_MOST}; so slow a cut is as good as its zero-order solution"
        raise InvalidRequest(Fault("call", "method multi-frequency", found, allowed))
    return count
