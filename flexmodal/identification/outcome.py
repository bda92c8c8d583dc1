"""What an identification found, and how far it can be trusted."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from jaxtyping import Float

from flexmodal.identification.baselines import Baselines
from flexmodal.identification.doubt import Limits, jackknife, limits
from flexmodal.identification.evidence.both import Both
from flexmodal.identification.evidence.evidence import Fitted
from flexmodal.identification.evidence.frf import FrfEvidence
from flexmodal.identification.identifiability import Combination, Identifiability
from flexmodal.identification.stages import Stage
from flexmodal.identification.uncertainty import Uncertainty
from flexmodal.report.words import times_noise
from flexmodal.structure.parameter import Parameter
from flexmodal.text.extras import extra
from flexmodal.text.shown import Shown

if TYPE_CHECKING:
    from flexmodal.identification.problem import IdentificationProblem

EXPLAINED = 1.6
"""Multiple of the noise floor up to which a model explains the data: repeats share leakage and bias. Beyond,
what is missing in the model moves the parameters, from one choice of data to another by more than any
interval says, and none is given: at 1.6 to 5 times the noise intervals held 4 of 5 parameters or fewer on the
rig."""
WORSE = 1.5
"""Held-out gap over fitted gap from which a fit does not carry over."""
TOUCHING = 1e-9
UNTRUSTED = 0.3
"""Standard deviation of the logarithm of a mass from which it holds no scale."""


@dataclass(frozen=True)
class Estimate:
    """One parameter."""

    name: str
    unit: str
    value: float
    standard_error: float
    """In the unit of the value; of a logarithm the linear one times the value. NaN at a bound or withheld."""
    interval: tuple[float, float]
    """95 %; of a logarithm not symmetric. NaN at a bound, or withheld."""
    card: float
    at_bound: bool
    identified: bool
    """Whether the data, not the prior, decide."""


@dataclass(frozen=True)
class Gaps:
    """Distances of card and fit from the data, as the file formats define them."""

    before: float
    """Of the card."""
    after: float
    """Of the fit, on what it was fitted to."""
    held_out_before: float | None
    """Of the card, on what was held out; None where nothing could be."""
    held_out_after: float | None
    """Of fits that had not seen what they are judged on."""
    noise_floor: float
    held_out_noise_floor: float | None = None


@dataclass(frozen=True)
class HeldOut:
    """One posture or point, predicted by a fit that had not seen it."""

    kind: str
    name: str
    before: float
    after: float
    noise_floor: float


@dataclass(frozen=True)
class Optimum:
    """One distinct optimum."""

    x: tuple[float, ...]
    cost: float
    hits: int
    """Starts that ended there."""


@dataclass(frozen=True, eq=False, repr=False)
class Identification(Shown):
    """Result of an identification."""

    problem: IdentificationProblem
    fitted: Fitted
    uncertainty: Uncertainty
    before_fit: Identifiability
    """What the data could tell, computed at the card."""
    gap: Gaps
    held_out: tuple[HeldOut, ...]
    optima: tuple[Optimum, ...]
    """Distinct ones, best first."""
    provenance: Mapping[str, Any]
    over_noise: float
    """Misfit of the fit over the noise, on data that are more than noise; 1 for a perfect model."""
    shared_misfit: float | None = None
    """Misfit that neighbouring lines share, in variances of the noise; None without FRFs."""
    baselines: Baselines | None = None
    """What needs no model, on the postures held out; None without FRFs of several postures."""
    stages: tuple[Stage, ...] = ()
    """What each stage reached, where the fit went in stages; the card as it came is the first."""
    without: Float[np.ndarray, "posture parameter"] | None = None
    """Coordinates of the fits without each posture, where they were left out in turn."""

    _PICTURE: ClassVar[str] = "flexmodal.identification.plot:draw_identification"

    def _facts(self) -> Mapping[str, object]:
        known = f"{sum(one.identified for one in self.estimates)} of {len(self.estimates)}"
        return {
            "": self.problem.campaign.title,
            "robot": self.problem.robot.name,
            "parameters identified": known,
            "gap": f"{self.gap.before:.4g} to {self.gap.after:.4g}, noise floor {self.gap.noise_floor:.4g}",
        }

    def to_pandas(self) -> Any:
        """A table of the parameters: value, standard error, interval, card.

        Raises:
            MissingExtra: pandas is not installed.
        """
        pandas = extra("pandas", "pandas", "to_pandas")
        return pandas.DataFrame([vars(one) for one in self.estimates]).set_index("name")

    @property
    def at(self) -> Float[np.ndarray, " parameter"]:
        """Coordinates of the answer."""
        return self.fitted.x

    @property
    def values(self) -> dict[str, float]:
        """Values by name."""
        return self.problem.space.values(self.at)

    @cached_property
    def estimates(self) -> tuple[Estimate, ...]:
        """Every parameter."""
        low, high = self.uncertainty.interval(self.at)
        errors = self.uncertainty.deviation
        if self.doubted and self.without is not None:
            moved, t = jackknife(self.at, self.without)
            low, high = np.minimum(low, self.at - t * moved), np.maximum(high, self.at + t * moved)
            errors = np.maximum(errors, moved)
        least, most = self.problem.space.bounds
        known = set(self.uncertainty.identified)
        errors = errors * (np.nan if self.withheld else 1.0)
        return tuple(
            _estimate(
                p,
                self.at[k],
                errors[k],
                (low[k], high[k]),
                (least[k], most[k]),
                p.name in known,
            )
            for k, p in enumerate(self.problem.space)
        )

    @property
    def correlated(self) -> tuple[tuple[str, str, float], ...]:
        """Pairs that the data tell together only."""
        return self.uncertainty.correlated

    @cached_property
    def not_identified(self) -> tuple[Combination, ...]:
        """Combinations that the data left open, at the fit."""
        found = Identifiability(self.problem.space, self.uncertainty.information, self.problem.what)
        return found.combinations

    @property
    def at_bound(self) -> tuple[str, ...]:
        """Parameters that stand at a bound."""
        return tuple(one.name for one in self.estimates if one.at_bound)

    @property
    def explained(self) -> bool:
        """Whether what is left is about the noise."""
        return self.over_noise <= EXPLAINED

    @property
    def made_up_for(self) -> bool:
        """Whether something is missing that the parameters make up for: within the noise, yet no noise."""
        return self.shared_misfit is not None and self.shared_misfit > self._limits.withheld

    @property
    def doubted(self) -> bool:
        """Whether neighbouring lines share more than complete models leave, and not enough to be sure."""
        if self.shared_misfit is None or self.made_up_for:
            return False
        return self.shared_misfit > self._limits.doubted

    @property
    def _limits(self) -> Limits:
        return limits(self.problem.evidence, bare=self.problem.bare)

    @property
    def withheld(self) -> bool:
        """Whether no intervals are given, since the model's error decides and not the measurement's."""
        if self.problem.source == "modes":
            return False
        return not self.explained or self.made_up_for or (self.doubted and self.without is None)

    @property
    def scale_untold(self) -> bool:
        """Whether nothing holds the scale of the records: one point, and masses that may be anything."""
        parts = self.problem.evidence
        frfs = parts.frfs if isinstance(parts, Both) else parts
        masses = [one.deviation for one in self.problem.space if one.name.startswith("mass.")]
        if not isinstance(frfs, FrfEvidence) or not masses or min(masses) < UNTRUSTED:
            return False
        return len(np.unique(frfs.observations.response[:, 0])) == 1

    @property
    def verdict(self) -> str:
        """What to think of it, and what to do next."""
        gap, says = self.gap, []
        times = times_noise(self.over_noise)
        if not self.fitted.converged:
            says.append("the fit did not converge: give more steps or better starting values")
        if self.explained:
            says.append(f"the model meets the data to {times}")
        else:
            says.append(
                f"the fit leaves {times}: something is missing from the model; "
                "`flexmodal diagnose` looks for it"
            )
        if self.withheld:
            if self.explained:
                says.append(
                    "what it leaves goes on from line to line as noise does not "
                    f"({self.shared_misfit:.2g} of its variance): something is missing that the parameters "
                    "make up for; `flexmodal diagnose` looks for it"
                )
            says.append("no intervals are given: the model's error decides here, not the measurement's")
        elif self.doubted and self.without is not None:
            says.append(
                f"neighbouring lines share {self.shared_misfit:.2g} of the noise's variance, more than most "
                "complete models leave: intervals are as wide as the parameters move where a posture is left "
                "out"
            )
        if gap.held_out_after is not None and gap.held_out_after > WORSE * max(gap.after, gap.noise_floor):
            says.append(f"it does not carry over: {gap.held_out_after:.3g} on what was held out")
        if gap.held_out_after is None:
            says.append("nothing could be held out: how far it carries over is not known")
        elif not any(one.kind == "posture" for one in self.held_out) and len(self.problem.postures) < 2:
            says.append("one posture was measured: how far it carries over to others is not known")
        if self.baselines is not None:
            says.append(self.baselines.verdict)
        count = len(self.problem.space)
        known = len(self.uncertainty.identified)
        says.append(
            f"all {count} parameters are identified"
            if known == count
            else f"{known} of {count} parameters are identified"
        )
        if self.scale_untold:
            says.append(
                "one point was measured and no mass is trusted: a wrong scale of sensor or hammer passes for "
                "masses and stiffness that are all off as much; weigh a link, or strike a known mass"
            )
        if self.at_bound:
            says.append(f"at a bound: {', '.join(self.at_bound)}: look at the bounds before using them")
        if len(self.optima) > 1:
            says.append(f"{len(self.optima)} distinct optima; the best one is given")
        return "; ".join(says)


def _estimate(
    parameter: Parameter, x: float, deviation: float, reach: tuple[float, float], bounds: tuple[float, float],
    identified: bool,
) -> Estimate:  # fmt: skip
    touching = TOUCHING * max(1.0, abs(float(x)))
    at_bound = bool(x <= bounds[0] + touching or x >= bounds[1] - touching)
    error = abs(parameter.slope(float(x))) * float(deviation)
    interval = parameter.value(float(reach[0])), parameter.value(float(reach[1]))
    if at_bound or not np.isfinite(error):  # at a bound it would be the bound's doing, not the data's
        error, interval = float("nan"), (float("nan"), float("nan"))
    return Estimate(
        parameter.name, parameter.unit, parameter.value(float(x)), error, interval, parameter.card, at_bound,
        identified and not at_bound,
    )  # fmt: skip
