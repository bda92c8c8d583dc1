"""Modes as evidence on parameters."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from jaxtyping import Bool, Float, Int, Shaped

from flexmodal.errors import Fault
from flexmodal.identification.descent import Normal
from flexmodal.identification.evidence.evidence import Evidence, Fitted, Key, Misfit, few
from flexmodal.identification.evidence.measured_modes import ModeObservations
from flexmodal.identification.evidence.modal_gap import errors_of, gap_of_errors, noise_of
from flexmodal.identification.evidence.modal_residuals import ModeProblem, PosedModel
from flexmodal.identification.gap import Gap
from flexmodal.identification.uncertainty import Uncertainty, laplace
from flexmodal.structure.parameter import ParameterSpace
from flexmodal.text.words import enumeration

FLOORS_OF_MODES = (0.1, 0.02, 0.003)
"""Relative model error of a natural frequency, in the order in which it is lowered."""
MODEL_ERROR = 0.0005
"""Where that ends, unless it is said otherwise."""
WORDS = {"frequency": "natural frequencies", "damping": "damping ratios", "shape": "mode shapes",
         "residue": "residues", "antiresonance": "antiresonances"}  # fmt: skip
WIDE, CLOSE = 0.3, 0.1
"""Relative differences of frequency that pairing counts as large, at first and then."""


@dataclass(frozen=True, eq=False)
class ModalMisfit:
    """Of a model on modes, pairs held; see `Misfit`."""

    problem: ModeProblem
    partners: tuple[int, ...]
    floor: float

    def cost(self, x: Float[np.ndarray, " parameter"]) -> float:
        """See `Misfit`."""
        return self.problem.cost(x, self.partners, self.floor)

    def equations(self, x: Float[np.ndarray, " parameter"], *, apart: bool = False) -> Normal:
        """See `Misfit`."""
        return self.problem.equations(x, self.partners, self.floor)

    def same_pairs(self, other: Misfit) -> bool:
        """Whether both have the same partners."""
        return isinstance(other, ModalMisfit) and other.partners == self.partners


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
    """Relative difference of frequency that the first pairing counts as large."""

    @property
    def space(self) -> ParameterSpace:
        """What is fitted."""
        return self.model.space

    @cached_property
    def problem(self) -> ModeProblem:
        """Model and modes."""
        return ModeProblem(self.model, self.observations, self.use)

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
        return ModalMisfit(self.problem, self.problem.partners(x, scale=CLOSE if near else self.reach), floor)

    def information(self) -> Float[np.ndarray, "parameter parameter"]:
        """Of modes with these errors, exactly where the card has them."""
        card = np.zeros(len(self.space))
        partners = self.problem.partners(card, scale=WIDE)
        size = len(self.space)
        total = np.zeros((size, size))
        for one in self.problem.entries(card, partners, slopes=True):
            if one is not None:
                weight = 1 / (one.variance + (self.model_error * one.coarse) ** 2)
                total += (one.slopes * weight) @ one.slopes.T
        return total

    def clusters(self) -> Int[np.ndarray, " observation"]:
        """Each mode by itself."""
        return np.arange(len(self.observations))

    def uncertainty(self, fitted: Fitted) -> Uncertainty:
        """Of the curvature, widened where the misfit is larger than the errors."""
        partners = self.problem.partners(fitted.x, scale=CLOSE)
        entries = self.problem.entries(fitted.x, partners, slopes=False)
        count = sum(len(one.residual) for one in entries if one is not None)
        return laplace(self.space, fitted.normal, count)

    def predicted(self, x: Float[np.ndarray, " parameter"]) -> Shaped[np.ndarray, "observation *entry"]:
        """Relative errors of frequency and damping, and 1 − MAC."""
        return errors_of(self.problem, x)

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
