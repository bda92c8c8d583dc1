"""The stabilisation diagram: poles of rising order, and those that stay where they are."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Bool, Complex, Float, Int

from flexmodal.ema.measured import Measured
from flexmodal.ema.methods.lscf import Lscf, form_lscf
from flexmodal.errors import Fault, InvalidRequest


@dataclass(frozen=True)
class Tolerances:
    """When a pole counts as the same as one of the next lower order, and when a row of them as a mode."""

    frequency: float = 0.01
    """Largest relative change of the natural frequency."""
    damping: float = 0.05
    """Largest relative change of the damping ratio."""
    most_damping: float = 0.5
    """Poles damped more are taken for fits of the background."""
    orders: float = 0.3
    """Share of the orders in which a pole must be stable to be chosen as a mode."""

    def __post_init__(self) -> None:
        faults = [
            Fault("call", name, f"{getattr(self, name):g}", "above 0, at most 1")
            for name in ("frequency", "damping", "most_damping", "orders")
            if not 0 < getattr(self, name) <= 1
        ]
        if faults:
            raise InvalidRequest(faults)


@dataclass(frozen=True, eq=False)
class Stabilisation:
    """Every pole of every order inside the band, and which are stable."""

    problem: Lscf
    measured: Measured
    tolerances: Tolerances
    orders: Int[np.ndarray, " order"]
    order: Int[np.ndarray, " pole"]
    """Of each pole."""
    pole: Complex[np.ndarray, " pole"]
    """λ with positive damping and a frequency inside the band [rad/s]."""
    stable_frequency: Bool[np.ndarray, " pole"]
    stable: Bool[np.ndarray, " pole"]
    """Frequency and damping both."""
    participation: Complex[np.ndarray, "reference pole"]
    """How far each reference takes part in a pole, the largest 1; of FRFs that fill no matrix all 1."""

    @cached_property
    def frequency(self) -> Float[np.ndarray, " pole"]:
        """Natural frequency of each pole [Hz]."""
        return np.abs(self.pole) / (2 * np.pi)

    @cached_property
    def damping_ratio(self) -> Float[np.ndarray, " pole"]:
        """Damping ratio of each pole."""
        return -self.pole.real / np.abs(self.pole)

    def columns(self) -> list[Int[np.ndarray, " member"]]:
        """Stable poles that are one another's continuation, from low frequency to high; each is a mode."""
        least = max(2, int(np.ceil(self.tolerances.orders * len(self.orders))))
        chains: list[list[int]] = []
        for place in np.lexsort((self.frequency, self.order)).tolist():
            if not self.stable[place]:
                continue
            near = [chain for chain in chains if self._continues(chain[-1], place)]
            if near:
                best = min(near, key=lambda chain: abs(self.frequency[chain[-1]] - self.frequency[place]))
                best.append(place)
            else:
                chains.append([place])
        long = [np.array(chain) for chain in chains if len(chain) >= least]
        return sorted(long, key=lambda chain: float(np.median(self.frequency[chain])))

    def _continues(self, old: int, new: int) -> bool:
        """Whether a pole of a higher order lies where an earlier one did, within twice the tolerances."""
        if self.order[old] == self.order[new]:
            return False
        change = abs(self.frequency[new] / self.frequency[old] - 1)
        damping = abs(self.damping_ratio[new] / self.damping_ratio[old] - 1)
        return bool(change <= self.tolerances.frequency and damping <= 2 * self.tolerances.damping)

    def choose(self) -> Int[np.ndarray, " mode"]:
        """For each column the pole nearest its median, in frequency and damping by their scatter."""
        chosen = []
        for column in self.columns():
            table = np.log(np.stack([self.frequency[column], self.damping_ratio[column]]))
            away = np.abs(table - np.median(table, axis=1, keepdims=True))
            share = away / np.maximum(np.median(away, axis=1, keepdims=True), 1e-12)
            chosen.append(int(column[np.argmin(np.max(share, axis=0))]))
        return np.array(chosen, dtype=int)

    def nearest(self, frequency: float) -> int:
        """The stable pole nearest to a frequency [Hz], of the highest such order.

        Raises:
            InvalidRequest: no stable pole within 5 %.
        """
        candidates = np.flatnonzero(self.stable)
        distance = np.abs(self.frequency[candidates] / frequency - 1)
        if not len(candidates) or distance.min() > 0.05:
            raise InvalidRequest(
                Fault("call", "peaks", f"{frequency:g} Hz", "a frequency within 5 % of a stable pole")
            )
        close = candidates[distance <= distance.min() + self.tolerances.frequency]
        return int(close[np.argmax(self.order[close])])


def stabilise(
    measured: Measured, *, highest: int = 40, lowest: int = 2, tolerances: Tolerances | None = None
) -> Stabilisation:
    """Find the poles of every order and mark the stable ones.

    Args:
        measured: the FRFs; the band is theirs.
        highest: order to which the diagram goes; each order is one complex pole in the band.
        lowest: first order.
        tolerances: what counts as stable.

    Raises:
        InvalidRequest: orders out of range, or more than the lines can carry.
    """
    most = (len(measured.frequency) - 1) // 2
    if not 1 <= lowest < highest <= min(most, 300):
        found, allowed = f"{lowest} to {highest}", f"1 ≤ lowest < highest ≤ {min(most, 300)} for these lines"
        raise InvalidRequest(Fault("call", "orders", found, allowed))
    wanted = tolerances or Tolerances()
    problem = form_lscf(measured, highest)
    orders = np.arange(lowest, highest + 1)
    poles, of, by_frequency, by_both, factors = [], [], [], [], []
    before = np.empty(0, dtype=complex)
    for order in orders:
        now, part = _inside(*problem.modes(int(order)), measured, wanted)
        frequency, both = _compare(now, before, wanted)
        poles.append(now)
        of.append(np.full(len(now), order))
        by_frequency.append(frequency)
        by_both.append(both)
        factors.append(part)
        before = now
    return Stabilisation(
        problem,
        measured,
        wanted,
        orders,
        *(np.concatenate(part, axis=-1) for part in (of, poles, by_frequency, by_both, factors)),
    )


def _inside(
    poles: np.ndarray, factors: np.ndarray, measured: Measured, tolerances: Tolerances
) -> tuple[np.ndarray, np.ndarray]:
    size = np.abs(poles)
    damping = -poles.real / size
    within = (size >= measured.omega[0]) & (size <= measured.omega[-1])
    kept = np.flatnonzero(within & (damping > 0) & (damping <= tolerances.most_damping))
    kept = kept[np.argsort(size[kept])]
    return poles[kept], factors[:, kept]


def _compare(now: np.ndarray, before: np.ndarray, tolerances: Tolerances) -> tuple[np.ndarray, np.ndarray]:
    if not len(now) or not len(before):
        return np.zeros(len(now), dtype=bool), np.zeros(len(now), dtype=bool)
    frequency = np.abs(np.abs(now)[:, None] / np.abs(before)[None] - 1) <= tolerances.frequency
    ratio = (now.real / np.abs(now))[:, None] / (before.real / np.abs(before))[None]
    both = frequency & (np.abs(ratio - 1) <= tolerances.damping)
    return frequency.any(axis=1), both.any(axis=1)
