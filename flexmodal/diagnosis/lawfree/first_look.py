"""The law-free look at the start of every diagnosis of FRFs: for one place, and for several if need be."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

from flexmodal.diagnosis.lawfree.findings import summed_up
from flexmodal.diagnosis.lawfree.look import Field
from flexmodal.diagnosis.lawfree.pursuit import LawFree, alone, pursued
from flexmodal.diagnosis.lawfree.records import straightened
from flexmodal.diagnosis.lawfree.result import Findings
from flexmodal.diagnosis.selection.frf_comparison import FittedFrfs
from flexmodal.diagnosis.setup import Setup
from flexmodal.diagnosis.time_domain.model import has_law


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

    @cached_property
    def _field(self) -> Field:
        setup, root = self.setup, self.root
        seen = setup.observations
        if has_law(root.hypothesis):
            seen = straightened(seen, root.hypothesis, root.x, root.predicted)
        held = seen.keeping(setup.held) if setup.held.any() else None
        return Field.of(root.hypothesis, root.x, seen.keeping(~setup.held), held, by_force=self.by_force)

    @cached_property
    def _alone(self) -> LawFree:
        return alone(self._field, lambda part: self.advance("looking without a law", part))

    @cached_property
    def one(self) -> Findings:
        """For one place."""
        return summed_up(self._alone)

    @cached_property
    def several(self) -> Findings:
        """For as many as it takes."""
        doing = "looking without a law for several places"
        return summed_up(pursued(self._field, self._alone, lambda part: self.advance(doing, part)))
