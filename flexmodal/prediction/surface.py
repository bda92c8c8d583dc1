"""What a base leaves of the measured postures, learnt once as a function of posture and asked for at any.

What is left of a resonance moves with it from posture to posture. So all postures are laid over each other on
one axis of their own, on which every resonance of the model stands at the geometric mean of its natural
frequencies; there the rows are learnt, and from there they are laid over the posture asked for.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Complex, Float

from flexmodal.prediction.alignment import aligned, resampled
from flexmodal.prediction.process import Features, Learnt, learn


@dataclass(frozen=True, eq=False)
class Surface:
    """ln(measured / base) at every place and line, over the posture."""

    axis: Float[np.ndarray, " line"]
    """Lines that it was learnt at [Hz]."""
    resonances: Float[np.ndarray, " mode"]
    """Where the resonances of all postures were laid [Hz]; none where they were left as they are."""
    features: Features
    learnt: Learnt
    places: int

    @classmethod
    def of(
        cls,
        axis: Float[np.ndarray, " line"],
        rows: Sequence[Complex[np.ndarray, "place line"]],
        postures: Sequence[Mapping[str, float]],
        resonances: Sequence[Float[np.ndarray, " mode"]] = (),
        sliding: Sequence[str] = (),
    ) -> Surface:
        """Learn the rows of some postures.

        Args:
            axis: the lines [Hz].
            rows: of each posture, what is left at each place; NaN where it was not struck.
            postures: the joints of each [rad, m].
            resonances: the model's natural frequencies in each posture [Hz]; none to leave the axes alone.
            sliding: names of prismatic joints.

        Raises:
            MissingExtra: scikit-learn is not installed.
        """
        count = min((len(one) for one in resonances), default=0)
        middle = np.zeros(0)
        if count:
            middle = np.exp(np.mean([np.log(one[:count]) for one in resonances], axis=0))
            rows = [
                resampled(row, axis, aligned(axis, middle, own[:count]))
                for row, own in zip(rows, resonances, strict=True)
            ]
        every = np.array(rows)
        struck = np.isfinite(every)
        usual = np.where(struck, every, 0).sum(axis=0) / np.maximum(struck.sum(axis=0), 1)
        every = np.where(struck, every, usual)
        flat = np.concatenate([every.real, every.imag], axis=1).reshape(len(every), -1)
        features = Features.of(postures, sliding)
        at = np.array([features.at(q) for q in postures])
        return cls(axis, middle, features, learn(flat, at), every.shape[1])

    def at(
        self,
        posture: Mapping[str, float],
        resonances: Float[np.ndarray, " mode"],
        frequency: Float[np.ndarray, " point"] | None = None,
    ) -> Complex[np.ndarray, "place point"]:
        """What is left in any posture; 0 at places nobody struck.

        Args:
            posture: its joints [rad, m].
            resonances: the model's natural frequencies there [Hz].
            frequency: where [Hz]; on the lines it was learnt at if None.
        """
        found = self.learnt.at(self.features.at(posture)).reshape(2, self.places, len(self.axis))
        value = found[0] + 1j * found[1]
        wanted = self.axis if frequency is None else frequency
        if len(self.resonances):
            wanted = aligned(wanted, resonances[: len(self.resonances)], self.resonances)
        elif frequency is None:
            return value
        return resampled(value, self.axis, wanted)
