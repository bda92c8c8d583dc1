"""The law-free look at the start of every diagnosis of FRFs: for one place, and for several if need be."""

from __future__ import annotations

from collections.abc import Callable, Collection
from dataclasses import dataclass
from functools import cached_property

from flexmodal.diagnosis.disagreement.compare import force_dependence
from flexmodal.diagnosis.lawfree.findings import summed_up
from flexmodal.diagnosis.lawfree.look import Field
from flexmodal.diagnosis.lawfree.pursuit import LawFree, alone, pursued
from flexmodal.diagnosis.lawfree.records import of_first_blow
from flexmodal.diagnosis.lawfree.result import Findings
from flexmodal.diagnosis.selection.decision import Answer, reaches
from flexmodal.diagnosis.selection.frf_comparison import FittedFrfs
from flexmodal.diagnosis.selection.frf_thresholds import FORCE, FORCE_MARGIN
from flexmodal.diagnosis.setup import Setup
from flexmodal.diagnosis.time_domain.model import has_law
from flexmodal.diagnosis.time_domain.straightened import straightened
from flexmodal.identification import Observations


@dataclass(frozen=True, eq=False)
class LooksWithoutLaw:
    """Both looks, each taken when it is asked for."""

    setup: Setup
    """What the diagnosis works with."""
    root: FittedFrfs
    """The robot re-tuned."""
    by_force: bool
    """Whether FRFs change with the force of the blow."""
    advance: Callable[[str, float], None]
    """Called with what is being done and the part of it that is done."""
    hinted: Collection[tuple[str, str]] = ()
    """Kinds and places of rare ports that are tried with the others."""
    known: Findings | None = None
    """For one place, as the test was thought to be set up before."""

    @cached_property
    def _seen(self) -> Observations:
        """Without what torques that are integrated do beyond their stand-ins, where there are any."""
        seen, root = self.setup.observations, self.root
        if not has_law(root.hypothesis):
            return seen
        return straightened(seen, root.hypothesis, root.x, root.predicted)

    @cached_property
    def depends_on_force(self) -> bool:
        """Whether what is missing changes with the force of the blow, beside torques that are there."""
        if not self.by_force or not has_law(self.root.hypothesis):
            return self.by_force
        alike = of_first_blow(self._seen, self.root.hypothesis, self.root.x)
        return reaches(force_dependence(alike), FORCE, FORCE_MARGIN) > Answer.NO

    @cached_property
    def _field(self) -> Field:
        held = self.setup.held
        away = self._seen.keeping(held) if held.any() else None
        fitted = self._seen.keeping(~held)
        root, by_force = self.root, self.depends_on_force
        return Field.of(root.hypothesis, root.x, fitted, away, by_force=by_force, hinted=self.hinted)

    @cached_property
    def _alone(self) -> LawFree:
        return alone(self._field, lambda part: self.advance("looking without a law", part))

    @cached_property
    def one(self) -> Findings:
        """For one place."""
        return summed_up(self._alone, self._seen) if self.known is None else self.known

    @cached_property
    def several(self) -> Findings:
        """For as many as it takes."""
        doing = "looking without a law for several places"
        return summed_up(pursued(self._field, self._alone, lambda part: self.advance(doing, part)))
