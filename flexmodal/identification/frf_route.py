"""FRFs as a route to parameters."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Bool, Float, Shaped

from flexmodal.errors import Fault
from flexmodal.identification.frf_fit import Weighing, fit, normal_equations
from flexmodal.identification.gap import Gap, gap, over_noise
from flexmodal.identification.model import FrfModel, predict
from flexmodal.identification.observations import Observations
from flexmodal.identification.route import Advance, Fitted, few
from flexmodal.identification.uncertainty import Uncertainty, uncertainty
from flexmodal.structure.parameter import ParameterSpace

QUICK_LINES = 120
"""Lines of each FRF that a first look takes."""
SHARE_ABOVE_NOISE = 0.05
"""Of all lines, that must be above the noise for a fit to make sense."""


@dataclass(frozen=True, eq=False)
class FrfRoute:
    """FRFs, line by line."""

    model: FrfModel
    observations: Observations
    share: Float[np.ndarray, " observation"] | None = None
    """Multiple of each observation's weight in the fit; 1 if None."""

    @property
    def space(self) -> ParameterSpace:
        """What is fitted."""
        return self.model.space

    @property
    def count(self) -> int:
        """Two for each usable line."""
        return 2 * int(self.observations.used.sum())

    def faults(self) -> list[Fault]:
        """Nothing but noise, or too little of anything else."""
        source = str(self.observations.campaign.path or "campaign")
        used = float(self.observations.used.mean()) if self.observations.used.size else 0.0
        if used < SHARE_ABOVE_NOISE:
            found = f"{100 * used:.1f} % of the lines above the noise"
            allowed = f"{100 * SHARE_ABOVE_NOISE:g} % or more: harder blows, more averages, another band"
            return [Fault(source, "frfs", found, allowed)]
        return few(source, self.count, len(self.space), "usable values in FRFs")

    def fit(
        self,
        start: Float[np.ndarray, " parameter"] | None = None,
        *,
        quick: bool = False,
        warm: bool = False,
        hold: Mapping[str, float] | None = None,
        advance: Advance = lambda step, cost: None,
    ) -> Fitted:
        """See `Route`."""
        stride = max(1, len(self.observations.axis) // QUICK_LINES) if quick else 1
        floors = (0.2, 0.05) if quick else (0.01,) if warm else (0.2, 0.05, 0.01)
        found = fit(
            self.model,
            self.observations,
            start,
            floors=floors,
            stride=stride,
            share=self.share,
            hold=hold,
            advance=advance,
        )
        return Fitted(found.x, found.normal, found.converged, found.steps)

    def information(self) -> Float[np.ndarray, "parameter parameter"]:
        """JᵀWJ at the card, with the noise of the lines."""
        card = np.zeros(len(self.space))
        ideal = replace(self.observations, value=predict(self.model, card, self.observations))
        weighing = Weighing(0.01, np.arange(len(ideal.axis)))
        return normal_equations(self.model, card, ideal, weighing).curvature

    def uncertainty(self, fitted: Fitted) -> Uncertainty:
        """By clusters."""
        return uncertainty(self.space, fitted.normal, self.observations)

    def predicted(self, x: Float[np.ndarray, " parameter"]) -> Shaped[np.ndarray, "observation entry"]:
        """Receptances [m/N]."""
        return predict(self.model, x, self.observations)

    def gap(self, predicted: Shaped[np.ndarray, "observation entry"]) -> Gap:
        """Of the file formats."""
        return gap(self.observations, predicted)

    def over_noise(self, predicted: Shaped[np.ndarray, "observation entry"]) -> float:
        """On the lines that are fitted."""
        return over_noise(self.observations, predicted)

    def folds(self) -> Mapping[tuple[str, str], Bool[np.ndarray, " observation"]]:
        """Postures, and points that carried the sensor."""
        seen = self.observations
        found = {
            ("posture", posture.name): seen.posture == number for number, posture in enumerate(seen.postures)
        }
        for point in seen.campaign.points:
            rows = seen.response[:, 0] == point.id
            if rows.any():
                found["point", point.name] = rows
        return found

    def keeping(self, keep: Bool[np.ndarray, " observation"]) -> FrfRoute:
        """See `Route`."""
        share = None if self.share is None else self.share[keep]
        return replace(self, observations=self.observations.keeping(keep), share=share)
