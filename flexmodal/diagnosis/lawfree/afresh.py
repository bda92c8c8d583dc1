"""The best ports of a round fitted once more, from the beginning, where none comes near to nothing.

Where so much is left that more is missing than one, only a port of few functions that has wider ones is tried
as these: that takes little.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass

from flexmodal.diagnosis.effects.context import Context
from flexmodal.diagnosis.lawfree.related import widened
from flexmodal.diagnosis.lawfree.sighting import Sighting

NEARLY, AFRESH = 1.0, 2
"""Where none comes that near to nothing, so many of the best are fitted once more, from the beginning."""
FEW = 4
"""Functions of a port that is tried as its wider ones where more may be missing than one."""
WITHIN = 2.5
"""Times the misfit of the best, fitted once more itself, up to which others of them are."""


@dataclass(frozen=True, eq=False)
class Again:
    """Fits the best of a round once more."""

    fits: Callable[..., Sighting]
    """Ports fitted well and judged, see `port_fits.PortFits.sighted`."""
    context: Context
    before: Sighting | None
    """Ports that are there already."""
    most: float
    """Misfit of the best up to which it pays."""
    passed: Collection[str] = ()
    """Kinds of port that are not fitted once more."""

    def better(self, found: Sequence[Sighting], known: Collection[tuple[str, str]] = ()) -> list[Sighting]:
        """All in order, those that were fitted once more by what that came to.

        Args:
            found: in any order.
            known: kinds and places of ports that were fitted once more before.
        """
        order = sorted(found, key=lambda one: one.judged)
        if not order or order[0].judged <= NEARLY:
            return order
        if order[0].judged > self.most:
            wider = [self._widened(one) if len(one.port.names) <= FEW else one for one in order[:AFRESH]]
            return sorted([*wider, *order[AFRESH:]], key=lambda one: one.judged)
        again: list[Sighting] = []
        for one in order[:AFRESH]:
            least = min((better.judged for better in again), default=one.judged)
            passed = one.port.key in known or one.port.kind.name in self.passed
            again.append(one if passed or one.judged > WITHIN * least else self._one(one))
        return sorted([*again, *order[AFRESH:]], key=lambda one: one.judged)

    def _one(self, one: Sighting) -> Sighting:
        """The best of a fit, of another that sets out from constants on all lines, and of wider ports.

        Beside other ports more may be missing than one: there patience would not be rewarded.
        """
        other = self.fits((one.port,), self.before, patient=self.before is None)
        return self._widened(min(one, other, key=lambda each: each.judged))

    def _widened(self, one: Sighting) -> Sighting:
        """The best of a fit and of wider ports."""
        best = one
        for wider in one.port.kind.wider:
            if best.judged > NEARLY and one.port.where in wider.kind.places(self.context):
                port, start = widened(one, wider, self.context)
                more = self.fits((port,), self.before, start, patient=True)
                best = min(best, more, key=lambda each: each.judged)
        return best
