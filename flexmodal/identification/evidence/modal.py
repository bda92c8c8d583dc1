"""Modes as evidence on parameters."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from jaxtyping import Bool, Float, Int, Shaped

from flexmodal.errors import Fault
from flexmodal.identification.descent import Normal, prior_cost, robust, robust_weight
from flexmodal.identification.evidence.evidence import Evidence, Fitted, Key, Misfit, few
from flexmodal.identification.evidence.likelihood.fit import COARSE
from flexmodal.identification.evidence.likelihood.likelihood import Likelihood, Pairs
from flexmodal.identification.evidence.likelihood.pairing import paired
from flexmodal.identification.evidence.likelihood.residuals import Part, Residuals, residuals
from flexmodal.identification.evidence.likelihood.scatter import (
    DAMPING,
    FREQUENCY,
    RESIDUE,
    SHAPE,
    Beliefs,
)
from flexmodal.identification.evidence.measured_modes import ModeObservations
from flexmodal.identification.evidence.modal_gap import errors_of, gap_of_errors, noise_of
from flexmodal.identification.evidence.posed import ANTIRESONANCE, PosedModel, PosedModes
from flexmodal.identification.gap import Gap
from flexmodal.identification.uncertainty import Uncertainty, laplace
from flexmodal.modal import NO_MODES
from flexmodal.structure.parameter import ParameterSpace
from flexmodal.text.words import enumeration

FLOORS_OF_MODES = (0.1, 0.02, 0.003)
"""Relative model error of a natural frequency, in the order in which it is lowered."""
MODEL_ERROR = 0.0005
"""Where that ends, unless it is said otherwise."""
WORDS = {FREQUENCY: "natural frequencies", DAMPING: "damping ratios", SHAPE: "mode shapes",
         RESIDUE: "residues", ANTIRESONANCE: "antiresonances"}  # fmt: skip
USES = tuple(WORDS)
WIDE, CLOSE = COARSE


@dataclass(frozen=True, eq=False)
class ModalMisfit:
    """Of a model on modes, pairs held; see `Misfit`."""

    likelihood: Likelihood
    zeros: Callable[..., Iterable[Part]]
    """Residuals of antiresonances: at coordinates, with derivatives (`slopes`) or without."""
    pairs: Pairs
    floor: float

    def residuals(self, x: Float[np.ndarray, " parameter"], *, slopes: bool) -> Residuals:
        """Of every pair and antiresonance.

        Args:
            x: coordinates.
            slopes: with derivatives.
        """
        zeros = self.zeros(x, slopes=slopes) if ANTIRESONANCE in self.likelihood.use else ()
        seen = self.likelihood.see(x, slopes=slopes)
        return residuals(self.likelihood, seen, self.pairs, zeros).relative()

    def cost(self, x: Float[np.ndarray, " parameter"]) -> float:
        """See `Misfit`."""
        try:
            found = self.residuals(x, slopes=False)
        except NO_MODES:
            return float("inf")
        scaled = found.granting(self.floor) * found.away**2
        return float(np.sum(robust(scaled))) + prior_cost(self.likelihood.space, x)

    def equations(self, x: Float[np.ndarray, " parameter"], *, apart: bool = False) -> Normal:
        """See `Misfit`."""
        found, space = self.residuals(x, slopes=True), self.likelihood.space
        weight, count = found.granting(self.floor), len(self.likelihood.measured)
        scaled = weight * found.away**2
        used, data = weight * robust_weight(scaled), float(np.sum(robust(scaled)))
        scores, blocks = np.zeros((count, len(space))), None
        np.add.at(scores, found.owner, (found.slopes * (used * found.away)).T)
        if apart:
            own = [found.owner == k for k in range(count)]
            blocks = np.array([(found.slopes[:, k] * used[k]) @ found.slopes[:, k].T for k in own])
        return Normal(
            data + prior_cost(space, x), data, scores.sum(axis=0) + space.precision * x,
            (found.slopes * used) @ found.slopes.T, scores, np.bincount(found.owner, scaled, count), blocks,
        )  # fmt: skip

    def same_pairs(self, other: Misfit) -> bool:
        """Whether both have the same."""
        return isinstance(other, ModalMisfit) and other.pairs == self.pairs


@dataclass(frozen=True, eq=False)
class ModalEvidence(Evidence):
    """Modes, posture by posture."""

    most = 60

    model: PosedModel
    observations: ModeObservations
    use: tuple[str, ...] = ("frequency", "damping", "shape")
    model_error: float = MODEL_ERROR
    """Relative error of natural frequencies that the model itself is granted; tenfold for all else."""
    reach: float = WIDE
    """Relative error of frequencies that the first pairing grants the model."""

    @property
    def space(self) -> ParameterSpace:
        """What is fitted."""
        return self.model.space

    @cached_property
    def posed(self) -> PosedModes:
        """The model in the postures of the modes."""
        return PosedModes(self.model, self.observations)

    @cached_property
    def likelihood(self) -> Likelihood:
        """Of the modes, by what of them is used; shapes help to pair where there are residues too."""
        shapes = bool({SHAPE, RESIDUE} & set(self.use))
        return Likelihood(self.posed, self.observations, Beliefs(shapes=shapes), self.use)

    def pairs(self, x: Float[np.ndarray, " parameter"], *, grant: float = CLOSE) -> Pairs:
        """The mode of the model that each measured one is, by frequencies and shapes; −1 for none.

        Of the numbers of a card, those of damping are known worst.

        Args:
            x: coordinates.
            grant: relative error of frequencies that the model is granted.

        Raises:
            InvalidSystem: no model there.
        """
        likelihood = replace(self.likelihood, use=tuple(one for one in self.use if one != DAMPING))
        return paired(likelihood, likelihood.see(x, slopes=False), likelihood.usual(), grant)

    @property
    def what(self) -> str:
        """The data in words."""
        return f"the {enumeration([WORDS[name] for name in self.use])}"

    @property
    def count(self) -> int:
        """Of each posture at most as many modes as the model has coordinates."""
        total, observed = 0, self.observations
        shapes = len({"shape", "residue"} & set(self.use))
        for number in range(len(observed.postures)):
            numbers = []
            for mode in (observed.modes[k] for k in observed.here[number]):
                damped = "damping" in self.use and bool(np.isfinite(mode.damping_ratio))
                size = int("frequency" in self.use) + int(damped)
                numbers.append(size + sum(2 * shapes * len(shape.places) for shape in mode.shapes))
            total += sum(sorted(numbers, reverse=True)[: len(self.model.robot.joints)])
        return total + len(observed.antiresonances) * ("antiresonance" in self.use)

    def faults(self) -> list[Fault]:
        """Too few numbers."""
        source = str(self.observations.campaign.path or "campaign")
        return few(source, self.count, len(self.space), f"numbers ({', '.join(self.use)}) of modes")

    def floors(self, *, quick: bool = False, warm: bool = False) -> Sequence[float]:
        """Of natural frequencies, the last one the model's own."""
        every = (*(floor for floor in FLOORS_OF_MODES if floor > self.model_error), self.model_error)
        return every[:2] if quick else every[-1:] if warm else every

    def misfit(
        self, x: Float[np.ndarray, " parameter"], floor: float, *, near: bool = True, quick: bool = False
    ) -> ModalMisfit:
        """Each measured mode paired with one of the model's at x."""
        pairs = self.pairs(x, grant=CLOSE if near else self.reach)
        return ModalMisfit(self.likelihood, self.posed.zeros, pairs, floor)

    def information(self) -> Float[np.ndarray, "parameter parameter"]:
        """Of modes with these errors, exactly where the card has them."""
        card = np.zeros(len(self.space))
        found = self.misfit(card, self.model_error, near=False).residuals(card, slopes=True)
        return (found.slopes * found.granting(self.model_error)) @ found.slopes.T

    def clusters(self) -> Int[np.ndarray, " observation"]:
        """Each mode by itself."""
        return np.arange(len(self.observations))

    def uncertainty(self, fitted: Fitted) -> Uncertainty:
        """Of the curvature, widened where the misfit is larger than the errors."""
        found = self.misfit(fitted.x, self.model_error).residuals(fitted.x, slopes=False)
        return laplace(self.space, fitted.normal, len(found.away))

    def predicted(self, x: Float[np.ndarray, " parameter"]) -> Shaped[np.ndarray, "observation *entry"]:
        """Relative errors of frequency and damping, and 1 − MAC."""
        seen, modes = self.likelihood.see(x, slopes=False), len(self.observations.modes)
        table = np.full((len(self.observations), 3), np.nan)
        shapes = self.likelihood.beliefs.shapes
        table[:modes] = errors_of(self.observations, seen, self.pairs(x), shapes=shapes)
        for zero in self.posed.zeros(x, slopes=False) if ANTIRESONANCE in self.use else ():
            table[zero.owner, 0] = np.expm1(zero.away[0])
        return table

    def gap(self, predicted: Shaped[np.ndarray, "observation *entry"]) -> Gap:
        """Of the file formats."""
        return Gap(gap_of_errors(predicted), noise_of(self.observations, predicted))

    def over_noise(self, predicted: Shaped[np.ndarray, "observation *entry"]) -> float:
        """The gap over its noise."""
        return self.gap(predicted).over_floor

    def folds(self) -> Mapping[Key, Bool[np.ndarray, " observation"]]:
        """Postures."""
        zeros = [zero.posture for zero in self.observations.antiresonances]
        posture = np.array([mode.posture for mode in self.observations.modes] + zeros)
        return {
            ("posture", one.name): posture == number
            for number, one in enumerate(self.observations.postures)
            if np.any(posture == number)
        }

    def keeping(self, keep: Bool[np.ndarray, " observation"]) -> ModalEvidence:
        """See `Evidence`."""
        return replace(self, observations=self.observations.keeping(keep))
