"""What the end of a diagnosis asks of measured data of any kind: what is told and drawn."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import Any, Generic

from flexmodal.diagnosis.findings import Findings, ModesSeen
from flexmodal.diagnosis.outcome import NextMeasurement
from flexmodal.diagnosis.selection.comparison import M
from flexmodal.diagnosis.selection.conclusion import Conclusion
from flexmodal.diagnosis.selection.decision import Round
from flexmodal.identification.baselines import Baselines


class ToldData(ABC, Generic[M]):
    """FRFs, modes, or both, as the end of a diagnosis sees them."""

    @abstractmethod
    def conclude(self, first: M, last: M, *, again: bool) -> Conclusion[M]:
        """Look at two models once more, on everything that was measured.

        Args:
            first: the robot re-tuned.
            last: the final model.
            again: whether there is time to fit them again to what was held out, too.
        """

    @abstractmethod
    def place(self, model: M, findings: Findings | None) -> str:
        """Where something sits that has no name.

        Args:
            model: the final one.
            findings: what measured modes say.
        """

    def findings(
        self, rounds: Sequence[Round[M]], current: M, compared: tuple[M, M] | None
    ) -> Findings | None:
        """What measured modes say besides; None where FRFs decide.

        Args:
            rounds: every comparison.
            current: the final model.
            compared: it, or the best, and what it is tied with.
        """
        return None

    def modes_seen(self, first: M, last: M, conclusion: Conclusion[M]) -> ModesSeen | None:
        """Modes that were measured beside what decides; None where there are none.

        Args:
            first: the robot re-tuned, to what was not held out.
            last: the final model, likewise.
            conclusion: both, fitted to everything.
        """
        return None

    def stand_in(self, model: M, further: M | None, *, search: bool) -> M | None:
        """What predicts better though it has no name: for the improved robot alone.

        Args:
            model: the final one.
            further: one that was come to on the way, with effects that are not sure; None if there is none.
            search: whether there is time to look for one.
        """
        return None

    def baselines(self, model: M) -> Baselines | None:
        """What needs no model, beside one on the postures held out; None where there is no such thing."""
        return None

    @abstractmethod
    def next_measurement(self, models: Sequence[tuple[M, float]]) -> NextMeasurement:
        """What would tell models apart best.

        Args:
            models: two fitted models or more with their weights, the two that are told first.
        """

    def shown(self, conclusion: Conclusion[M]) -> dict[str, Any]:
        """Fields of a diagnosis that data of this kind alone have."""
        return {}
