"""Explanations of measured modes under several sets of beliefs: a margin that a prior turns is a tie."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from jaxtyping import Float

from flexmodal.diagnosis.hypothesis import Hypothesis
from flexmodal.diagnosis.modal_model import ModalModel
from flexmodal.diagnosis.search.modal_search import followed
from flexmodal.identification.evidence.likelihood.held_out import HeldOut
from flexmodal.identification.evidence.likelihood.laplace import ModalFit
from flexmodal.identification.evidence.likelihood.scatter import Beliefs
from flexmodal.identification.evidence.measured_modes import ModeObservations


@dataclass(frozen=True)
class Variant:
    """One set of beliefs."""

    name: str
    trust: float = 1.0
    """Factor on the priors of the robot's parameters."""
    stretch: float = 1.0
    """The same for those of what is added."""
    beliefs: Beliefs = field(default_factory=Beliefs)

    def of(self, model: ModalModel) -> ModalModel:
        """A model with these priors."""
        old = model.hypothesis
        base = old.base.trusting({p.name: p.deviation * self.trust for p in old.base})
        return ModalModel(Hypothesis(old.context, base, old.placed), model.free, self.stretch)


VARIANTS = (
    Variant("as believed"),
    Variant("card trusted twice as far", trust=0.5),
    Variant("card trusted half as far", trust=2.0),
    Variant("wider priors of what is added", stretch=2.0),
    Variant("frequencies and damping alone", beliefs=Beliefs(shapes=False)),
    Variant("more peaks that are no modes", beliefs=Beliefs(spurious=1.5)),
)


@dataclass(frozen=True, eq=False)
class FittedModes:
    """One explanation, fitted under every set of beliefs."""

    model: ModalModel
    fit: ModalFit
    """Of the model, under the first variant."""
    evidence: tuple[float, ...]
    """ln of the evidence under each variant [nat]."""
    held: HeldOut | None = None

    @property
    def key(self) -> tuple[str, str]:
        """What it adds last, and where."""
        return self.model.key

    @property
    def hypothesis(self) -> Hypothesis:
        """What of it has a structure."""
        return self.model.hypothesis

    @property
    def x(self) -> Float[np.ndarray, " parameter"]:
        """Coordinates of that."""
        return self.fit.x[: len(self.hypothesis.space)]

    @property
    def covariance(self) -> Float[np.ndarray, "parameter parameter"]:
        """Of these."""
        size = len(self.hypothesis.space)
        return self.fit.covariance[:size, :size]

    @property
    def parameters(self) -> int:
        """How many there are, those of modes with no structure among them."""
        return len(self.model.space)


def under_variants(model: ModalModel, fits: Sequence[ModalFit], measured: ModeObservations) -> FittedModes:
    """Fit again under every variant, from where several fits under the first ended.

    Args:
        model: what is fitted.
        fits: of it, the best first.
        measured: to what.
    """
    best = fits[0]
    found = [best.evidence]
    for variant in VARIANTS[1:]:
        near = [replace(one, beliefs=variant.beliefs) for one in fits[:2]]
        again = followed(variant.of(model), measured, near, variant.beliefs)
        found.append(again[0].evidence if again else -np.inf)
    return FittedModes(model, best, tuple(found))
