"""What a diagnosis found: the disagreement, the steps, the verdict."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Complex, Float

from flexmodal.diagnosis.findings import Findings, ModesSeen
from flexmodal.diagnosis.hypothesis import Hypothesis
from flexmodal.diagnosis.lawfree.result import Findings as LawFreeFindings
from flexmodal.diagnosis.names import UNKNOWN
from flexmodal.identification import Observations
from flexmodal.identification.baselines import Baselines
from flexmodal.identification.setting_up import Found


@dataclass(frozen=True)
class Gaps:
    """Gap between model and measurement at the stages of a diagnosis, as the file formats define it."""

    before: float
    """The robot re-tuned, nothing added; of a step, the model before it."""
    after: float
    held_out_before: float | None
    """On postures that no fit of this pair of figures saw; None where none could be held out."""
    held_out_after: float | None
    noise_floor: float
    believed: float | None = None
    """The card as it came."""


@dataclass(frozen=True)
class Region:
    """Where, and how, measurement and re-tuned model disagree."""

    posture: int
    """Id in the campaign, as are the others."""
    response: tuple[int, int]
    reference: tuple[int, int]
    trial: int
    band: tuple[float, float]
    """[Hz]"""
    share: float
    """Of the whole disagreement above the noise, 0 to 1."""
    kind: str
    says: str


@dataclass(frozen=True)
class Compared:
    """One explanation on the scales."""

    effect: str
    """Name of the effect, or `NONE` or `UNSTRUCTURED` (`names`)."""
    where: str
    gap: float
    held_out_gap: float | None
    evidence: float
    """Logarithm of the evidence over that of the best [nat], tempered (see `weigh`)."""
    confidence: float
    parameters: int
    """How many it adds."""


@dataclass(frozen=True)
class Step:
    """One effect added."""

    effect: str
    where: str
    parameters: Mapping[str, float]
    """In a diagnosis those of the final model, fitted to everything; until then of when it was added."""
    units: Mapping[str, str]
    uncertainty: Mapping[str, float]
    """Standard errors."""
    confidence: float
    gaps: Gaps
    alternatives: tuple[Compared, ...]
    """What was compared against it, the best first; the robot re-tuned among them."""
    ties: tuple[tuple[str, str], ...] = ()
    """Explanations that these data cannot tell from it."""
    share: float | None = None
    """Part of the disagreement above the noise that it takes; None where that has no figure."""


@dataclass(frozen=True)
class NextMeasurement:
    """What would separate two explanations best."""

    posture: Mapping[str, float]
    response: tuple[int, int]
    reference: tuple[int, int]
    separates: tuple[str, str]
    """Two explanations, `effect@where`."""
    expected: float
    """Root mean square difference of the two, line by line, over what noise and unsure parameters make."""
    force_peak: float
    """[N]"""
    point: str | None = None
    """Where a sensor not in the campaign should sit, by name; None for one of its own points."""
    gain: float | None = None
    """Expected information: the logarithm of the odds that it brings [nat]."""
    new_points: Mapping[int, str] = field(default_factory=dict)
    """Names of points of the card that the campaign has not used yet, by the ids that they have here."""
    locked: tuple[str, ...] = ()
    """Joints to lock from link to link."""
    masses: Mapping[str, float] = field(default_factory=dict)
    """Masses to bolt on, by the name of the point [kg]."""


@dataclass(frozen=True)
class Remaining:
    """What is left beside the effects that are named."""

    over_noise: float
    """Distance of the final model from the measurement, over that of the noise."""
    where: str
    """The place to look at."""
    kind: str
    """Of the region that disagrees most."""


@dataclass(frozen=True)
class Verdict:
    """The answer."""

    effects: tuple[tuple[str, str], ...]
    explained: bool
    """Whether nothing significant is left."""
    says: str
    undecided: tuple[str, ...] = ()
    """Sentences on figures too near to their threshold for a yes or a no; the simpler answer was kept."""
    share: float | None = None
    """Part of the disagreement above the noise that the named effects take; None where that has no figure."""
    remaining: Remaining | None = None
    """None where everything is explained, or nothing says where noise begins."""
    cut_off: bool = False
    """Whether looking for effects was cut off for its time, which `undecided` says too."""

    @property
    def named(self) -> bool:
        """Whether something of the catalogue is named."""
        return any(name != UNKNOWN for name, _ in self.effects)


@dataclass(frozen=True, eq=False)
class Diagnosis:
    """Everything that `diagnose` found out."""

    campaign: str
    robot: str
    gaps: Gaps
    disagreement: tuple[Region, ...]
    remaining: tuple[Region, ...]
    """Disagreement that is left at the end."""
    steps: tuple[Step, ...]
    verdict: Verdict
    next_measurement: NextMeasurement | None
    untestable: Mapping[str, str]
    """Effects that these data cannot tell of, and why."""
    left_out: tuple[str, ...]
    """Records without a signal, and effects that were not asked for."""
    held_out: tuple[int, ...]
    """Ids of the postures that were held out."""
    model: Hypothesis = field(repr=False)
    """The final model, with all effects that were added."""
    x: Float[np.ndarray, " parameter"] = field(repr=False)
    """Coordinates of its parameters."""
    deviation: Float[np.ndarray, " parameter"] = field(repr=False)
    """Their standard errors."""
    frfs: Observations | None = field(repr=False, default=None)
    """None where modes alone were measured."""
    predicted: Mapping[str, Complex[np.ndarray, "observation line"]] = field(repr=False, default_factory=dict)
    """Receptances by stage: "believed", "before", "after"; with several effects "step 1" and on too."""
    refused: tuple[Compared, ...] = ()
    """What was compared last and not found worth adding, the best first; `NONE` among them."""
    warnings: tuple[str, ...] = ()
    """What was taken for granted that may not be so."""
    provenance: Mapping[str, str] = field(default_factory=dict)
    """Versions, hashes of the inputs, seed, settings, seconds."""
    look: LawFreeFindings | None = None
    """What was found without a law; None of a diagnosis from modes alone."""
    stand_in: tuple[tuple[str, str], ...] = ()
    """Effects of the final model that are not named: they stand for something that has no name."""
    baselines: Baselines | None = None
    """What needs no model, beside the final one on the postures held out."""
    moved: tuple[Found, ...] = ()
    """What was not set up as the campaign says, by what it was moved."""
    modes: ModesSeen | None = None
    """Measured modes beside those of the models; None where FRFs alone were measured."""
    modal: Findings | None = None
    """What a diagnosis from modes alone knows besides; None of one from FRFs."""
    over_noise: float | None = None
    """Distance of the final model from the averages over that of their noise; None where there is no such."""

    @property
    def observations(self) -> Observations:
        """The FRFs.

        Raises:
            ValueError: modes alone were measured.
        """
        if self.frfs is None:
            raise ValueError("a diagnosis from modes alone has no FRFs")
        return self.frfs
