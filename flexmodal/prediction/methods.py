"""Ways to predict one posture from others: physics, physics and what it leaves, data alone."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Complex, Float, Int

from flexmodal.identification.baselines import log_mean, posture_distance
from flexmodal.prediction.panel import Panel
from flexmodal.prediction.surface import Surface

METHODS: Mapping[str, str] = {
    "hybrid": "the model fitted to the others, times a share of what it leaves, learnt over the posture",
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

    @cached_property
    def beside_physics(self) -> Surface:
        """What the physics leaves, its resonances laid over each other."""
        return self._learnt(self.physics, [self.resonances[number] for number in self.postures])

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
) -> dict[str, Complex[np.ndarray, "some line"]]:
    """Receptances of a posture by every method [m/N].

    Args:
        known: what may be looked at.
        q: the posture [rad, m].
        physics: the model's receptances there, at each place asked for.
        place: numbers of those places.
        resonances: the model's natural frequencies there [Hz].
        share: of what was learnt that goes into `hybrid`.

    Raises:
        MissingExtra: scikit-learn is not installed.
    """
    mean = known.mean[place]
    return {
        "hybrid": physics * np.exp(share * known.beside_physics.at(q, resonances)[place]),
        "physics": physics,
        "process": mean * np.exp(known.beside_mean.at(q, resonances)[place]),
        "mean": mean,
        "nearest": known.nearest(q)[place],
    }
