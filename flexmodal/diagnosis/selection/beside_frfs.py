"""Modes beside FRFs: what measured modes say of models that were fitted to FRFs.

By the chain rule the evidence of both is that of the FRFs times the density of the modes given the FRFs,

    ln p(F, M) = ln p(F) + ln p(M | F),

the latter predicted by the fit, what is unsure of its parameters included to first order. Damping counts only
where no model has hysteretic losses, which the modes of viscous structures leave out.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float

from flexmodal.diagnosis.findings import ModesSeen
from flexmodal.diagnosis.modal_model import ModalModel
from flexmodal.diagnosis.names import UNSTRUCTURED
from flexmodal.diagnosis.selection.comparison import Comparison
from flexmodal.diagnosis.selection.frf_comparison import FittedFrfs
from flexmodal.identification import uncertainty
from flexmodal.identification.evidence.likelihood.errors import mean_of_others
from flexmodal.identification.evidence.likelihood.held_out import HeldOut, together
from flexmodal.identification.evidence.likelihood.laplace import ModalFit
from flexmodal.identification.evidence.likelihood.likelihood import Likelihood
from flexmodal.identification.evidence.likelihood.pairing import paired
from flexmodal.identification.evidence.likelihood.predictive import predictive
from flexmodal.identification.evidence.likelihood.residuals import residuals
from flexmodal.identification.evidence.likelihood.scales import rescaled
from flexmodal.identification.evidence.likelihood.scatter import Beliefs
from flexmodal.identification.evidence.measured_modes import ModeObservations
from flexmodal.modal import NO_MODES

SETTINGS = (Beliefs(), Beliefs(shapes=False), Beliefs(spurious=1.5))
"""Beliefs under which modes are looked at."""
TURNS = 3
"""Times that pairs and scales of the scatter are improved in turn."""


@dataclass(frozen=True, eq=False)
class ModesBeside:
    """Measured modes of a campaign that has FRFs too."""

    measured: ModeObservations

    def added_to(self, comparison: Comparison[FittedFrfs]) -> Comparison[FittedFrfs]:
        """A comparison by FRFs with what the modes say; every draw under each set of beliefs."""
        seen = [self.predicted(one, lossless=not _lossy(comparison.models)) for one in comparison.models]
        scores = np.array([[fit.evidence for fit in fits] for fits in seen])
        table = np.concatenate([comparison.table + column[:, None] for column in scores.T], axis=1)
        return replace(comparison, scores=comparison.scores + scores[:, 0], table=table)

    def shown(
        self, fitted: Sequence[FittedFrfs], everywhere: Sequence[FittedFrfs], held: Collection[int]
    ) -> ModesSeen:
        """The modes beside those of two models.

        Args:
            fitted: the robot re-tuned and the final model, to what was not held out.
            everywhere: the same fitted to everything.
            held: ids of the postures held out.
        """
        lossless = not _lossy([*fitted, *everywhere])
        measured = self.measured if lossless else _undamped(self.measured)
        away = np.array([measured.postures[mode.posture].id in held for mode in measured.modes])
        before, after = (self.predicted(one, lossless=lossless)[0] for one in everywhere)
        apart: list[HeldOut | None] = [None, None]
        if away.any():
            seen = [self.predicted(one, lossless=lossless)[0] for one in fitted]
            apart = [together([one], measured, [away], one) if one.forecasts else None for one in seen]
        return ModesSeen(measured, before, after, apart[0], apart[1], mean_of_others(measured))

    def predicted(self, model: FittedFrfs, *, lossless: bool = True) -> list[ModalFit]:
        """The modes as a model predicts them, under each set of beliefs.

        Args:
            model: fitted to the FRFs.
            lossless: whether its damping ratios count.
        """
        measured = self.measured if lossless else _undamped(self.measured)
        explanation = ModalModel(model.hypothesis, int(model.key[0] == UNSTRUCTURED))
        size = len(model.hypothesis.space)
        x = np.concatenate([model.x, np.zeros(len(explanation.space) - size)])
        covariance = np.diag([p.deviation**2 for p in explanation.space])
        fitted = model.fitted
        sure = uncertainty(model.hypothesis.space, fitted.normal, fitted.misfit.observations)
        covariance[:size, :size] = sure.covariance
        return [_seen(explanation, measured, beliefs, x, covariance) for beliefs in SETTINGS]


def _seen(
    explanation: ModalModel,
    measured: ModeObservations,
    beliefs: Beliefs,
    x: Float[np.ndarray, " parameter"],
    covariance: Float[np.ndarray, "parameter parameter"],
) -> ModalFit:
    """Pairs and scales at their best; the evidence is ln p(M | F), of no model at all −∞."""
    likelihood = Likelihood(explanation, measured, beliefs)
    scales = likelihood.usual()
    try:
        forecasts = likelihood.see(x, slopes=True)
    except NO_MODES:
        none = (-1,) * len(measured.modes)
        return ModalFit(explanation, measured, beliefs, x, scales, none, -np.inf, -np.inf, covariance, ())
    pairs = paired(likelihood, forecasts, scales, 0.0)
    for _ in range(TURNS):
        scales = rescaled(residuals(likelihood, forecasts, pairs), scales, beliefs)
        pairs = paired(likelihood, forecasts, scales, 0.0)
    fit = ModalFit(explanation, measured, beliefs, x, scales, pairs, 0.0, 0.0, covariance, tuple(forecasts))
    return replace(fit, evidence=predictive(fit) + likelihood.log_prior_of_scales(scales))


def _lossy(models: Sequence[FittedFrfs]) -> bool:
    """Whether any of them has hysteretic losses."""
    return any(
        structure.loss.any() or structure.loss_factor
        for model in models
        for structure in model.hypothesis.structures(model.x, (), (), slopes=False)[:1]
    )


def _undamped(measured: ModeObservations) -> ModeObservations:
    """Modes whose damping is not known."""
    return replace(
        measured, modes=tuple(replace(mode, damping_ratio=float("nan")) for mode in measured.modes)
    )
