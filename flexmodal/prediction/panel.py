"""Observations by posture and place: which of them are of the same two places and the same kind of blow."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Bool, Complex, Float, Int

from flexmodal.campaign import CampaignPosture
from flexmodal.identification import Observations
from flexmodal.identification.frf_fit import residual

LARGEST = 3.0
"""|ln| beyond which a ratio says no more than that the two have nothing to do with each other."""
FEWEST = 6
"""Lines above the noise that a record has to have to be taken between them."""


@dataclass(frozen=True, eq=False)
class Panel:
    """Observations with their places numbered."""

    observations: Observations
    place: Int[np.ndarray, " observation"]
    """Number of the pair of places of each."""
    pairs: Int[np.ndarray, "place 4"]
    """Response point and direction, force point and direction."""

    @property
    def axis(self) -> Float[np.ndarray, " line"]:
        """The lines [Hz]."""
        return self.observations.records.frequency

    def of_posture(self, number: int) -> Int[np.ndarray, " some"]:
        """Observations of a posture."""
        return np.flatnonzero(self.observations.posture == number)

    def ratio(
        self, number: int, base: Complex[np.ndarray, "observation line"]
    ) -> Complex[np.ndarray, "place line"]:
        """ln(measured / base) at each place of a posture, the mean over kinds of blow; NaN where none was.

        Lines that are not above the noise are taken between those that are; sizes are cut at `LARGEST`.

        Args:
            number: of the posture.
            base: to compare with, of every observation [m/N].
        """
        seen, rows = self.observations, self.of_posture(number)
        found = np.full((len(self.pairs), seen.value.shape[1]), np.nan, dtype=complex)
        away = _between(residual(seen.value[rows], base[rows]), seen.used[rows])
        for place in np.unique(self.place[rows]).tolist():
            found[place] = away[self.place[rows] == place].mean(axis=0)
        return found


def panel_of(observations: Observations) -> Panel:
    """Number the places of observations.

    Args:
        observations: of any postures.
    """
    keys = np.concatenate([observations.response, observations.reference], axis=1)
    pairs, place = np.unique(keys, axis=0, return_inverse=True)
    return Panel(observations, np.asarray(place).reshape(-1), pairs)


def with_posture(panel: Panel, name: str, q: Mapping[str, float]) -> Panel:
    """The same with one posture more, at the end, every place of it seen once and nothing measured there.

    Its records are long and without a window: what it is predicted as is the receptance itself.

    Args:
        panel: what was measured.
        name: of the posture.
        q: its joints [rad, m].
    """
    seen, count = panel.observations, len(panel.pairs)
    lines = seen.value.shape[1]
    posture = CampaignPosture(max(one.id for one in seen.campaign.postures) + 1, name, q)
    none: Bool[np.ndarray, "place line"] = np.zeros((count, lines), bool)
    more = replace(
        seen,
        postures=(*seen.postures, posture),
        posture=np.concatenate([seen.posture, np.full(count, len(seen.postures))]),
        response=np.concatenate([seen.response, panel.pairs[:, :2]]),
        reference=np.concatenate([seen.reference, panel.pairs[:, 2:]]),
        level=np.concatenate([seen.level, np.full(count, len(seen.levels))]),
        levels=(*seen.levels, ()),
        decays=(*seen.decays, 0.0),
        lengths=(*seen.lengths, 0.0),
        value=np.concatenate([seen.value, np.ones((count, lines), complex)]),
        variance=np.concatenate([seen.variance, np.full((count, lines), np.inf)]),
        used=np.concatenate([seen.used, none]),
    )
    return Panel(more, np.concatenate([panel.place, np.arange(count)]), panel.pairs)


def _between(
    away: Complex[np.ndarray, "row line"], used: Bool[np.ndarray, "row line"]
) -> Complex[np.ndarray, "row line"]:
    """Logarithms with a bounded real part, taken between the lines that are used where there are enough."""
    found = np.clip(away.real, -LARGEST, LARGEST) + 1j * away.imag
    lines = np.arange(away.shape[1])
    for row, kept in enumerate(used):
        if kept.sum() >= FEWEST:
            real = np.interp(lines, lines[kept], found[row, kept].real)
            found[row] = real + 1j * np.interp(lines, lines[kept], found[row, kept].imag)
    return found
