"""Ways to predict one posture from others: physics, physics and what it leaves, data alone."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Complex, Float, Int

from flexmodal.identification.baselines import log_mean, posture_distance
from flexmodal.prediction.alignment import aligned, resampled
from flexmodal.prediction.cross_motion import PARTS, with_cross_motion
from flexmodal.prediction.panel import Panel
from flexmodal.prediction.process import NEGLIGIBLE, likeness
from flexmodal.prediction.surface import Surface

METHODS: Mapping[str, str] = {
    "hybrid": "the model fitted to the others, with shares of what it leaves, learnt over the posture, and "
    "of the process",
    "physics": "the model fitted to the others",
    "process": "their mean, times what that leaves, learnt over the posture: data alone",
    "mean": "the mean of the other postures",
    "nearest": "the nearest posture",
}
"""Every method, the most trusted first."""
DATA_ALONE = ("process", "mean", "nearest")
"""Those that know no physics."""


@dataclass(frozen=True, eq=False)
class Known:
    """What a posture is predicted from; what is learnt from it is learnt once."""

    panel: Panel
    postures: tuple[int, ...]
    """Numbers of the postures whose FRFs may be looked at."""
    physics: Complex[np.ndarray, "observation line"]
    """The model's receptances of every observation, by a fit to those postures [m/N]."""
    resonances: Sequence[Float[np.ndarray, " mode"]]
    """The model's natural frequencies in each posture of the panel [Hz]."""
    sliding: tuple[str, ...] = ()
    """Names of prismatic joints."""
    beside: float = PARTS[0]
    """Part of the mean that moves beside the model."""

    @cached_property
    def beside_physics(self) -> Surface:
        """What the physics leaves where it moves, its resonances laid over each other."""
        mean, posture = self.mean[self.panel.place], self.panel.observations.posture
        base = with_cross_motion(self.physics, mean, self.beside, posture)
        return self._learnt(base, [self.resonances[number] for number in self.postures])

    @cached_property
    def beside_mean(self) -> Surface:
        """What the mean of the postures leaves."""
        return self._learnt(self.mean[self.panel.place], ())

    @cached_property
    def mean(self) -> Complex[np.ndarray, "place line"]:
        """Mean over the known postures at each place; 1 where none of them was struck there."""
        seen, panel = self.panel.observations, self.panel
        here = np.isin(seen.posture, self.postures)
        found = np.ones((len(panel.pairs), seen.value.shape[1]), dtype=complex)
        for place in np.unique(panel.place[here]).tolist():
            value = log_mean(seen.value[here & (panel.place == place)])
            found[place] = np.where(value == 0, 1.0, value)
        return found

    def nearest(self, q: Mapping[str, float]) -> Complex[np.ndarray, "place line"]:
        """At each place the FRF of the nearest posture that was struck there.

        Args:
            q: the posture [rad, m].
        """
        seen, panel = self.panel.observations, self.panel
        order = sorted(self.postures, key=lambda number: posture_distance(seen.postures[number].q, q))
        found, open_ = np.array(self.mean), np.ones(len(panel.pairs), bool)
        for number in order:
            rows = panel.of_posture(number)
            for place in np.unique(panel.place[rows]).tolist():
                if open_[place]:
                    found[place] = log_mean(seen.value[rows[panel.place[rows] == place]])
                    open_[place] = False
        return found

    def by_process(
        self, q: Mapping[str, float], place: Int[np.ndarray, " some"], axis: Float[np.ndarray, " line"]
    ) -> Complex[np.ndarray, "some line"]:
        """Their mean times what that leaves: data alone [m/N].

        Args:
            q: the posture [rad, m].
            place: numbers of the places asked for.
            axis: where [Hz].
        """

        def plain(where: Mapping[str, float], at: np.ndarray, lines: np.ndarray, _: object) -> np.ndarray:
            mean = resampled(self.mean[at], self.panel.axis, lines)
            return mean * np.exp(self.beside_mean.at(where, np.zeros(0), lines)[at])

        return plain(q, place, axis, None) * np.exp(self._rest(q, place, np.zeros(0), axis, plain))

    def by_hybrid(
        self,
        q: Mapping[str, float],
        physics: Complex[np.ndarray, "some line"],
        place: Int[np.ndarray, " some"],
        resonances: Float[np.ndarray, " mode"],
        axis: Float[np.ndarray, " line"],
        share: float,
        mix: float,
    ) -> Complex[np.ndarray, "some line"]:
        """Physics, with what moves beside it, a share of what that leaves, and a share of data alone [m/N].

        The last is a weighted mean of two predictions, in ln size and along the shorter way of the phase:
        where their errors have little to do with each other it is nearer than either.

        Args:
            q: the posture [rad, m].
            physics: the model's receptances there [m/N].
            place: numbers of the places, all that were struck.
            resonances: the model's natural frequencies there [Hz].
            axis: where [Hz].
            share: of what was learnt beside the physics.
            mix: weight of the prediction without physics.
        """

        def plain(
            where: Mapping[str, float], at: np.ndarray, lines: np.ndarray, near: int | None
        ) -> np.ndarray:
            model, own = (physics, resonances) if near is None else (
                self.physics[self.panel.of_posture(near)], self.resonances[near]
            )  # fmt: skip
            mean = resampled(self.mean[at], self.panel.axis, lines)
            value = with_cross_motion(model, mean, self.beside)
            value = value * np.exp(share * self.beside_physics.at(where, own, lines)[at])
            return value * np.exp(mix * log_ratio(self.by_process(where, at, lines), value)) if mix else value

        return plain(q, place, axis, None) * np.exp(self._rest(q, place, resonances, axis, plain))

    def _rest(
        self,
        q: Mapping[str, float],
        place: Int[np.ndarray, " some"],
        resonances: Float[np.ndarray, " mode"],
        axis: Float[np.ndarray, " line"],
        plain: Callable[[Mapping[str, float], np.ndarray, np.ndarray, int | None], np.ndarray],
    ) -> Complex[np.ndarray, "some line"] | float:
        """What a prediction leaves of a known posture, as far as the one asked for is nearly the same."""
        seen, features = self.panel.observations, self.beside_mean.features
        here = features.at(q)
        alike = [likeness(features.at(seen.postures[number].q), here) for number in self.postures]
        near = self.postures[int(np.argmax(alike))]
        if max(alike) < NEGLIGIBLE:
            return 0.0
        rows, base = self.panel.of_posture(near), np.ones(seen.value.shape, dtype=complex)
        base[rows] = plain(seen.postures[near].q, self.panel.place[rows], self.panel.axis, near)
        left = np.nan_to_num(self.panel.ratio(near, base)[place])
        there = aligned(axis, resonances, self.resonances[near]) if len(resonances) else axis
        return max(alike) * resampled(left, self.panel.axis, there)

    def _learnt(
        self, base: Complex[np.ndarray, "observation line"], resonances: Sequence[np.ndarray]
    ) -> Surface:
        """What a base leaves."""
        rows = [self.panel.ratio(number, base) for number in self.postures]
        postures = [self.panel.observations.postures[number].q for number in self.postures]
        return Surface.of(self.panel.axis, rows, postures, resonances, self.sliding)


def predicted_by_all(
    known: Known,
    q: Mapping[str, float],
    physics: Complex[np.ndarray, "some line"],
    place: Int[np.ndarray, " some"],
    resonances: Float[np.ndarray, " mode"],
    share: float = 1.0,
    mix: float = 0.0,
) -> dict[str, Complex[np.ndarray, "some line"]]:
    """Receptances of a posture by every method [m/N].

    Args:
        known: what may be looked at.
        q: the posture [rad, m].
        physics: the model's receptances there, at each place asked for.
        place: numbers of those places.
        resonances: the model's natural frequencies there [Hz].
        share: of what was learnt that goes into `hybrid`.
        mix: of what `process` says beside that.

    Raises:
        MissingExtra: scikit-learn is not installed.
    """
    axis = known.panel.axis
    return {
        "hybrid": known.by_hybrid(q, physics, place, resonances, axis, share, mix),
        "physics": physics,
        "process": known.by_process(q, place, axis),
        "mean": known.mean[place],
        "nearest": known.nearest(q)[place],
    }


def log_ratio(
    value: Complex[np.ndarray, "some line"], base: Complex[np.ndarray, "some line"]
) -> Complex[np.ndarray, "some line"]:
    """The logarithm of value / base, 0 where there is nothing to divide by.

    Args:
        value: receptances [m/N].
        base: likewise.
    """
    there = (base != 0) & (value != 0)
    return np.log(np.where(there, value, 1.0) / np.where(there, base, 1.0))
